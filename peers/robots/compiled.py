"""Masses, axes, ranges and drives as MuJoCo compiles them, to compare ours with.

    python compiled.py FILE...                          prints ranges and drives as JSON
    python compiled.py --with LIFELIKE [--walk BVH] FILE...
                                                        compares them with `LIFELIKE inspect --json`, a row of a Markdown
                                                        table per file; retargets a walk to each, too

A drive is the sum of a joint's actuators: stiffness and damping (N m/rad, N m s/rad), and the range of its torque (N m). The control
of an actuator without stiffness is a force, unless it is a velocity servo; then its range limits the torque. Needs mujoco 4.0.
"""

import json
import os
import re
import subprocess
import sys
import tempfile

import mujoco
import numpy as np

HINGE_OR_SLIDE = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
ON_JOINT = (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT))


def overlap(a, b):
    if a is None or b is None:
        return b if a is None else a
    return [max(a[0], b[0]), min(a[1], b[1])]


def drive(model, joint):
    """The sum of a joint's actuators; None where none moves it."""
    stiffness, damping, torque, moved = 0.0, 0.0, [0.0, 0.0], False
    for i in range(len(model.actuator_trntype)):
        if model.actuator_trntype[i] not in ON_JOINT or model.actuator_trnid[i, 0] != joint:
            continue
        gear = model.actuator_gear[i, 0]
        affine = model.actuator_biastype[i] == int(mujoco.mjtBias.mjBIAS_AFFINE)
        bias = model.actuator_biasprm[i, :3] if affine else [0.0, 0.0, 0.0]
        gain = model.actuator_gainprm[i, 0]
        if model.actuator_gaintype[i] == int(mujoco.mjtGain.mjGAIN_DCMOTOR):
            resistance, constant = model.actuator_gainprm[i, :2]
            gain, bias = constant / resistance, [0.0, 0.0, -(constant**2) / resistance]
        if gain == 0.0 and bias[1] == 0.0:
            continue  # a damper
        moved = True
        stiffness -= bias[1] * gear**2
        damping -= bias[2] * gear**2
        own = list(model.actuator_forcerange[i] * gear) if model.actuator_forcelimited[i] else None
        servo = bias[1] != 0.0 or (affine and bias[2] != 0.0 and gain == -bias[2])
        if not servo and model.actuator_ctrllimited[i]:
            own = overlap(own and sorted(own), sorted(model.actuator_ctrlrange[i] * gear * gain))
        own = own and sorted(own)
        torque = [torque[0] + own[0], torque[1] + own[1]] if torque and own else None
    if model.jnt_actfrclimited[joint]:
        torque = overlap(torque, list(model.jnt_actfrcrange[joint]))
    return {"stiffness": stiffness, "damping": damping, "torque": torque} if moved else None


def urdf(path):
    """A URDF without pictures and with boxes for meshes, which MuJoCo cannot all read: a URDF states its masses."""
    text = open(path, encoding="utf-8", errors="replace").read()
    text = re.sub(r"<visual\b.*?</visual>|<visual\b[^>]*/>", "", text, flags=re.DOTALL)
    text = re.sub(r"<mesh\b[^>]*?/>|<mesh\b.*?</mesh>", '<box size="0.1 0.1 0.1"/>', text, flags=re.DOTALL)
    return mujoco.MjSpec.from_string(text.encode("ascii", "ignore").decode())


def joints(path):
    """Range and drive of every hinge and slide by name."""
    spec = urdf(path) if path.endswith(".urdf") else mujoco.MjSpec.from_file(path)
    spec.compiler.fusestatic = False  # a URDF's fixed links stay apart, as in our reading
    model = spec.compile()
    found = {}
    for j in range(model.njnt):
        if model.jnt_type[j] in HINGE_OR_SLIDE:
            limits = list(model.jnt_range[j]) if model.jnt_limited[j] else None
            found[model.joint(j).name] = {"axis": list(model.jnt_axis[j]), "range": limits, "drive": drive(model, j)}
    return {"joints": found, "bodies": bodies(model)}


def bodies(model):
    """Mass, centre and inertia about it (xx, yy, zz, xy, xz, yz, along the axes of the body) of every body by name."""
    found = {}
    for b in (b for b in range(1, model.nbody) if model.body(b).name):
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, model.body_iquat[b])
        turn = turn.reshape(3, 3)
        inertia = turn @ np.diag(model.body_inertia[b]) @ turn.T
        rows = [inertia[0, 0], inertia[1, 1], inertia[2, 2], inertia[0, 1], inertia[0, 2], inertia[1, 2]]
        found[model.body(b).name] = {"mass": float(model.body_mass[b]), "com": list(model.body_ipos[b]), "inertia": rows}
    return found


def close(ours, theirs):
    if ours is None or theirs is None:
        return ours is None and theirs is None
    if isinstance(ours, (list, tuple)):
        return all(close(a, b) for a, b in zip(ours, theirs, strict=True))
    return abs(ours - theirs) <= 1e-6 * max(1.0, abs(theirs))


def near(ours, theirs, scale):
    """Equal to a millionth of a scale."""
    return all(abs(a - b) <= 1e-6 * scale for a, b in zip(ours, theirs, strict=True))


def differences(ours, theirs):
    """What differs between `inspect --json` and MuJoCo's model, as words."""
    drives = {a["joint"]: a for a in ours["actuators"]}
    ranges = {j["name"]: j["range"] for j in ours["joints"]}
    own_bodies = {b["name"]: b for b in ours["bodies"]}
    for name, expected in theirs["bodies"].items():
        own = own_bodies.get(name)
        if own is None:
            yield f"{name}: no such body"
            continue
        if not close(own["mass_kg"], expected["mass"]):
            yield f"{name}: {own['mass_kg']} kg for {expected['mass']}"
            continue
        # MuJoCo's compiler gives a body without mass a hundredth of a gram.
        if expected["mass"] > 1e-5 and not near(own["com_m"], expected["com"], 1.0):
            yield f"{name}: centre {own['com_m']} for {expected['com']}"
        # A link without an inertia gets a small one from us, and a warning.
        if any(expected["inertia"]) and not near(own["inertia_kg_m2"], expected["inertia"], max(expected["inertia"][:3])):
            yield f"{name}: inertia {own['inertia_kg_m2']} for {expected['inertia']}"
    axes = {j["name"]: j["axis"] for j in ours["joints"]}
    for name, expected in theirs["joints"].items():
        if name not in axes:
            yield f"{name}: missing"
            continue
        if not near(axes[name], expected["axis"], 1.0):
            yield f"{name}: axis {axes[name]} for {expected['axis']}"
        if not close(ranges[name], expected["range"]):
            yield f"{name}: range {ranges[name]} for {expected['range']}"
        if name not in drives:
            # What follows another joint has no drive.
            if expected["drive"] or not any(c["follower"] == name for c in ours["couplings"]):
                yield f"{name}: no drive"
            continue
        own = drives[name]["model"]
        if own is None or expected["drive"] is None:
            if own or expected["drive"]:
                yield f"{name}: drive {own} for {expected['drive']}"
            continue
        for key, value in expected["drive"].items():
            if not close(own[key], value):
                yield f"{name}: {key} {own[key]} for {value}"
        used, stiffness = drives[name]["parameters"], expected["drive"]["stiffness"]
        if stiffness > 0 and not (close(used["kp"], stiffness) and close(used["kd"], max(0.0, expected["drive"]["damping"]))):
            yield f"{name}: uses kp {used['kp']} kd {used['kd']} for {expected['drive']}"


def walked(program, path, walk):
    """Retargets a walk, and returns its mean errors as words."""
    with tempfile.TemporaryDirectory() as folder:
        command = [program, "-q", "--json", "motion", "retarget", walk, "--robot", path, "-o", folder]
        run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode != 0:
        return "refused: " + (run.stderr.strip().splitlines() or ["?"])[-1].removeprefix("lifelike: ")[:90]
    report = json.loads(run.stdout)["clips"][0]["report"]
    mean = lambda errors: sum(e["mean"] for e in errors.values()) / max(1, len(errors))
    return f"{100 * mean(report['position_error']):.1f} cm, {mean(report['orientation_error']):.1f} deg"


def compare(program, walk, paths):
    equal = both = 0
    print("| file | MuJoCo's joints | the same to 1e-6 | verdict | a walk |")
    print("| --- | ---: | --- | --- | --- |")
    for path in paths:
        name = "/".join(os.path.normpath(path).split(os.sep)[-3:])
        try:
            theirs = joints(path)
        except ValueError as error:
            theirs = str(error).splitlines()[0]
        run = subprocess.run([program, "-q", "inspect", "--json", path], capture_output=True, text=True)
        ours = json.loads(run.stdout) if run.stdout else {}
        said = (run.stderr.strip().splitlines() or [""])[-1].removeprefix("lifelike: ").replace(path, name)
        verdict = ours.get("verdict", "refused: " + said)
        if isinstance(theirs, str):
            print(f"| {name} | | MuJoCo refuses: {theirs[:90]} | {verdict[:120]} | |")
            continue
        if "actuators" not in ours:
            print(f"| {name} | {len(theirs['joints'])} | | {verdict[:120]} | |")
            continue
        wrong = list(differences(ours, theirs))
        both, equal = both + 1, equal + (not wrong)
        steps = walked(program, path, walk) if walk and verdict.startswith("ready") else ""
        print(f"| {name} | {len(theirs['joints'])} | {'; '.join(wrong[:3]) or 'all'} | {verdict[:120]} | {steps} |", flush=True)
    print(f"\n{len(paths)} files; both read {both}, of which {equal} are the same.")


def main(arguments):
    if arguments[:1] != ["--with"]:
        drives = {os.path.basename(path): joints(path)["joints"] for path in arguments}
        for joint in (joint for file in drives.values() for joint in file.values()):
            del joint["axis"]
        print(json.dumps(drives, indent=1))
        return
    program, files, walk = arguments[1], arguments[2:], None
    if files[:1] == ["--walk"]:
        walk, files = files[1], files[2:]
    compare(program, walk, files)


if __name__ == "__main__":
    main(sys.argv[1:])
