"""Writes fields.rs, the layout of MuJoCo's structs, from its headers: python3 fields.py [third_party/mujoco/include].

Needs a C compiler as `cc`. FIELDS has a word for each field; `+` makes it writable.
Its keys are the struct, the type that reads it (`-` for none) and the type that writes it.
"""

import pathlib
import re
import subprocess
import sys
import tempfile
import textwrap

# Pointers become slices, all other fields values. Sizes, indices and addresses must not be writable.
FIELDS = {
    "mjModel Model ModelMut<'_>": """
        nq nv nbody njnt ngeom nsite neq ntendon
        opt.timestep+ opt.gravity+ opt.integrator+ opt.disableflags+ opt.enableflags+ stat.meaninertia+ stat.meanmass+
        qpos0 qpos_spring
        body_parentid body_rootid body_weldid body_pos body_quat body_ipos+ body_iquat body_mass+ body_subtreemass+
        body_inertia+ body_invweight0+ body_gravcomp
        jnt_type jnt_qposadr jnt_dofadr jnt_pos jnt_axis jnt_stiffness jnt_limited jnt_range jnt_actfrcrange
        dof_bodyid dof_armature+ dof_damping+ dof_frictionloss+ dof_invweight0+ dof_M0+
        geom_type geom_contype+ geom_conaffinity+ geom_condim geom_bodyid geom_dataid geom_priority geom_size geom_pos
        geom_quat geom_friction+ geom_margin geom_gap geom_solref geom_solimp
        site_bodyid site_pos site_quat
        eq_type eq_obj1id eq_obj2id eq_objtype eq_active0 eq_solref eq_solimp eq_data
        tendon_invweight0+""",
    "mjData Data Data": """
        ncon nefc nJ time+ energy
        qpos+ qvel+ qacc_warmstart+ qfrc_applied+ xfrc_applied+ qacc
        xpos xquat xipos subtree_com cdof qfrc_bias qfrc_passive subtree_linvel subtree_angmom
        qfrc_smooth qacc_smooth qfrc_constraint cfrc_int cfrc_ext
        contact efc_type efc_id efc_J_rowadr efc_J efc_force""",
    "mjsGeom - Geom<'_>": """
        type+ pos+ size+ contype+ conaffinity+ condim+ priority+ friction+ solref+ solimp+ margin+ gap+""",
}
# Offsets of what is read or written by hand.
OFFSETS = """
    mjModel.body_simple mjModel.body_sameframe mjModel.dof_simplenum mjModel.geom_sameframe mjModel.site_sameframe
    mjsJoint.armature mjsJoint.stiffness mjsJoint.damping mjsJoint.springdamper mjsGeom.element mjsGeom.hfieldname
    mjsHField.element mjsHField.size mjsHField.nrow mjsHField.ncol mjsHField.userdata
    mjContact.dist mjContact.frame mjContact.geom mjContact.efc_address mjLogMessage.level mjLogMessage.subject"""
CONSTANTS = """
    mjVERSION_HEADER mjOBJ_BODY mjOBJ_JOINT mjOBJ_GEOM mjOBJ_SITE mjGEOM_PLANE mjGEOM_HFIELD mjINT_EULER mjINT_RK4
    mjDSBL_SPRING mjDSBL_DAMPER mjDSBL_ACTUATION mjDSBL_SENSOR mjDSBL_EULERDAMP mjDSBL_AUTORESET mjENBL_ENERGY
    mjCNSTR_EQUALITY mjCNSTR_FRICTION_DOF mjCNSTR_LIMIT_JOINT mjEQ_WELD mjEQ_JOINT mjSAMEFRAME_NONE mjLOG_WARNING mjLOG_ERROR"""
TYPES = {"mjtNum": "f64", "double": "f64", "int": "i32", "mjtGeom": "i32", "mjtBool": "bool", "mjtByte": "u8"}
TYPES |= {"mjtSize": "i64", "mjContact": "Contact"}
C = '#include <stddef.h>\n#include <stdio.h>\n#include <mujoco/mujoco.h>\nint main(void) {\n'


def members(headers: str, struct: str) -> dict[str, re.Match]:
    """The members of a struct by name: type, star, columns in brackets, and rows and columns of its comment."""
    body = re.search(rf"typedef struct {struct}_ \{{(.*?)\n\}} {struct};", headers, re.S).group(1)
    found = re.finditer(r"^ +(\w+)(\*?) +(\w+)(?:\[(.+?)\])?;[^\n(]*(?:.*?\((\w+) x (\w+)\))?", body, re.M)
    return {match[3]: match for match in found}


def main() -> None:
    default = pathlib.Path(__file__).parents[4] / "third_party/mujoco/include"
    include = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else default
    headers = "".join(path.read_text() for path in sorted(include.glob("mujoco/mj*.h")))
    lines = []  # format of printf, and its arguments
    for names, fields in FIELDS.items():
        struct, reader, writer = names.split()
        for writable in [False, True]:
            owner, rows = (writer if writable else reader), {"arrays": [], "values": []}
            for word in fields.split():
                if owner == "-" or (writable and not word.endswith("+")):
                    continue
                path = word.rstrip("+")
                where = {"opt": "mjOption", "stat": "mjStatistic"}.get(path.split(".")[0], struct)
                member = members(headers, where)[path.split(".")[-1]]
                kind, star, brackets, count, columns = member[1], member[2], member[4], member[5], member[6]
                columns = (columns if star else brackets) or "1"
                name = path.replace(".", "_").lower() + ("_mut" if writable else "")
                entry = f"{name}: {{[{TYPES[kind]}; %d]}}, " + (f"{count.lower()}, " if star else "") + "%zu;\\n"
                rows["arrays" if star else "values"].append((entry, f"(int)({columns}), offsetof({struct}, {path})"))
            for macro, entries in rows.items():
                if entries:
                    lines += [(f"{macro}{'_mut' if writable else ''}! {{ {owner};\\n", ""), *entries, ("}\\n", "")]
    lines.append(("constants! {\\n", ""))
    for name in CONSTANTS.split():
        lines.append((f"{name.removeprefix('mj')}: i32, %d;\\n", f"(int){name}"))
    lines.append(("}\\noffsets! {\\n", ""))
    for path in OFFSETS.split():
        struct, field = path.split(".")
        name = re.sub(r"^MJS?", "", struct.upper()) + "_" + field.upper()
        lines.append((f"{name}: usize, %zu;\\n", f"offsetof({struct}, {field})"))
    lines.append(("CONTACT_SIZE: usize, %zu;\\n}\\n", "sizeof(mjContact)"))
    calls = "".join(f'    printf("{text}"{", " + values if values else ""});\n' for text, values in lines)
    with tempfile.TemporaryDirectory() as folder:
        program = pathlib.Path(folder) / "fields"
        source = program.with_suffix(".c")
        source.write_text(C + calls + "    return 0;\n}\n")
        subprocess.run(["cc", "-I", include, source, "-o", program], check=True)
        output = subprocess.run([program], check=True, capture_output=True, text=True).stdout
    output = re.sub(r"\{\[(\w+); 1\]\}", r"\1", output)
    output = re.sub(r"\{(\[.*?\])\}", r"\1", output)
    # Entries of a macro side by side.
    wrap = textwrap.TextWrapper(width=118, initial_indent="    ", subsequent_indent="    ", break_on_hyphens=False)
    block = lambda match: "\n".join(["", match[1], *wrap.wrap(match[2].replace(" ", "\0").replace("\n", " "))]) + "\n}\n"
    output = re.sub(r"(\w+! \{.*)\n((?:.*;\n)+)\}\n", block, output).replace("\0", " ")
    head = "//! The layout of MuJoCo's structs: names, types, rows and offsets. Written by fields.py.\n\nuse super::native::*;\n"
    pathlib.Path(__file__).with_name("fields.rs").write_text(head + output)


if __name__ == "__main__":
    main()
