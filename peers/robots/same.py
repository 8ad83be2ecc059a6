"""Compares robot files with MuJoCo's compiler: a line per file, then a table by package.

    cargo build --release -p lifelike-character --example compiled
    python same.py target/release/examples/compiled LIFELIKE FILE...

Of every hinge and slide: range, axis, anchor, mass, centre and inertia of what it carries, stiffness, damping and torque of its
actuators, armature, damping, dry friction and spring. Needs mujoco 4.0. A file's package is the folder below `x/` in its path.
"""

import collections
import json
import subprocess
import sys

import mujoco
import numpy as np

from compiled import HINGE_OR_SLIDE, drive

TOLERANCE = 1e-6


def carried(model, data, body):
    """Mass, centre and inertia about it of a body with all below it."""
    below = [b for b in range(1, model.nbody) if is_below(model, b, body)]
    mass = sum(model.body_mass[b] for b in below)
    com = sum(model.body_mass[b] * data.xipos[b] for b in below) / max(mass, 1e-300)
    inertia = np.zeros((3, 3))
    for b in below:
        turn = data.ximat[b].reshape(3, 3)
        offset = data.xipos[b] - com
        inertia += turn @ np.diag(model.body_inertia[b]) @ turn.T
        inertia += model.body_mass[b] * (offset @ offset * np.eye(3) - np.outer(offset, offset))
    return mass, com, inertia


def is_below(model, body, ancestor):
    while body not in (0, ancestor):
        body = model.body_parentid[body]
    return body == ancestor


def joints(path):
    """What each joint is and carries, in the frame of the first body (of the world, where MuJoCo joined the root to it)."""
    model = mujoco.MjModel.from_xml_path(path)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    found = {}
    for j in range(model.njnt):
        if model.jnt_type[j] not in HINGE_OR_SLIDE:
            continue
        own, dof = drive(model, j), model.jnt_dofadr[j]
        mass, com, inertia = carried(model, data, model.jnt_bodyid[j])
        found[model.joint(j).name] = {
            "range": list(model.jnt_range[j]) if model.jnt_limited[j] else [],
            "axis": data.xaxis[j],
            "anchor": data.xanchor[j],
            "mass": [mass],
            "com": com,
            "inertia": inertia,
            "gains": [own["stiffness"], own["damping"]] if own else [],
            "torque": list(own["torque"]) if own and own["torque"] else [],
            "passive": [model.dof_armature[dof], model.dof_damping[dof], model.dof_frictionloss[dof], model.jnt_stiffness[j]],
        }
    urdf = path.lower().endswith("urdf")
    root = 0 if urdf else next((b for b in range(1, model.nbody) if model.body_parentid[b] == 0 and is_robot(model, b)), 0)
    turn, origin = data.xmat[root].reshape(3, 3), data.xpos[root]
    for joint in found.values():
        joint["axis"] = turn.T @ joint["axis"]
        joint["anchor"], joint["com"] = turn.T @ (joint["anchor"] - origin), turn.T @ (joint["com"] - origin)
        joint["inertia"] = (turn.T @ joint["inertia"] @ turn).ravel()
    return found


def is_robot(model, body):
    """Whether a body or one below it has a hinge or slide."""
    return any(model.jnt_type[j] in HINGE_OR_SLIDE and is_below(model, model.jnt_bodyid[j], body) for j in range(model.njnt))


def differences(ours, theirs, urdf):
    for name, expected in theirs.items():
        if name not in ours:
            yield f"{name} missing"
            continue
        for key, value in expected.items():
            # A URDF has no actuators; its damping and friction are the joint's.
            got, value = np.array(ours[name][key], float), np.array(value, float)
            size = max(1.0, np.abs(value).max(initial=0.0)) if key != "inertia" else max(1e-3, np.abs(value).max())
            if got.shape != value.shape or np.abs(got - value).max(initial=0.0) > TOLERANCE * size:
                yield f"{name}.{key} {np.round(got, 7).tolist()} for {np.round(value, 7).tolist()}"


def verdict(program, path):
    run = subprocess.run([program, "-q", "inspect", "--json", path], capture_output=True, text=True, errors="replace")
    said = json.loads(run.stdout) if run.stdout else {}
    words = said.get("verdict") or run.stderr.strip()
    return words.split(":")[0] if words.startswith(("ready", "cannot")) else "refused", words


def main(arguments):
    reader, program, *paths = arguments
    counts = collections.defaultdict(collections.Counter)
    for path in paths:
        count = counts[path.split("x/", 1)[-1].split("/")[0]]
        count["files"] += 1
        ours = json.loads(subprocess.run([reader, path], capture_output=True, text=True).stdout or '{"error": "crashed"}')
        short, words = verdict(program, path)
        try:
            theirs = joints(path)
        except ValueError as error:
            theirs = str(error).splitlines()[0]
        if isinstance(theirs, str) or "error" in ours:
            what = "refused by both" if isinstance(theirs, str) and "error" in ours else "refused by us" if "error" in ours else "refused by MuJoCo"
            count[what] += 1
            print(f"{path}: {what}; MuJoCo: {theirs if isinstance(theirs, str) else 'reads it'}; ours: {ours.get('error', words)}")
        else:
            wrong = list(differences(ours["joints"], theirs, path.lower().endswith("urdf")))
            count["differs" if wrong else "equal"] += 1
            print(f"{path}: {len(theirs)} joints, {'; '.join(wrong[:3]) or 'equal'}; {words}")
        count[short if short != "ready to train, with 1 warning" else short] += 1
    columns = ["files", "equal", "differs", "refused by both", "refused by MuJoCo", "refused by us"]
    print("| package | " + " | ".join(columns) + " | ready | cannot be trained |\n| --- |" + " ---: |" * 8)
    for package, count in counts.items():
        ready = sum(n for name, n in count.items() if name.startswith("ready"))
        print(f"| {package} | " + " | ".join(str(count[c]) for c in columns) + f" | {ready} | {count['cannot be trained']} |")


main(sys.argv[1:])
