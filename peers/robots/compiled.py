"""Drives of every joint as MuJoCo compiles them, to compare ours with.

    python compiled.py FILE...                 prints them as JSON
    python compiled.py --with LIFELIKE FILE... compares them with `LIFELIKE inspect --json`, a line per file

A drive is the sum of a joint's actuators: stiffness and damping (N m/rad, N m s/rad), and the range of its torque (N m). The control
of an actuator without stiffness is a force, unless it is a velocity servo; then its range limits the torque. Needs mujoco 4.0.
"""

import json
import os
import subprocess
import sys

import mujoco

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


def joints(path):
    """Range and drive of every hinge and slide by name."""
    model = mujoco.MjModel.from_xml_path(path)
    found = {}
    for j in range(model.njnt):
        if model.jnt_type[j] in HINGE_OR_SLIDE:
            limits = list(model.jnt_range[j]) if model.jnt_limited[j] else None
            found[model.joint(j).name] = {"range": limits, "drive": drive(model, j)}
    return found


def close(ours, theirs):
    if ours is None or theirs is None:
        return ours is None and theirs is None
    if isinstance(ours, (list, tuple)):
        return all(close(a, b) for a, b in zip(ours, theirs, strict=True))
    return abs(ours - theirs) <= 1e-6 * max(1.0, abs(theirs))


def differences(ours, theirs):
    """What differs between `inspect --json` and MuJoCo's model, as words."""
    drives = {a["joint"]: a for a in ours["actuators"]}
    ranges = {j["name"]: j["range"] for j in ours["joints"]}
    for name, expected in theirs.items():
        if name not in drives:
            yield f"{name}: missing"
            continue
        if not close(ranges[name], expected["range"]):
            yield f"{name}: range {ranges[name]} for {expected['range']}"
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


def compare(program, paths):
    right = 0
    for path in paths:
        try:
            theirs = joints(path)
        except ValueError as error:
            theirs = str(error).splitlines()[0]
        run = subprocess.run([program, "-q", "inspect", "--json", path], capture_output=True, text=True)
        ours = json.loads(run.stdout) if run.stdout else {}
        if isinstance(theirs, str) or "actuators" not in ours:
            said = (run.stderr.strip().splitlines() or [ours.get("verdict", "")])[-1]
            print(f"{path}: MuJoCo: {theirs if isinstance(theirs, str) else 'reads it'}; ours: {ours.get('verdict', said)}")
            continue
        wrong = list(differences(ours, theirs))
        right += not wrong
        print(f"{path}: {len(theirs)} joints, {'; '.join(wrong[:4]) or 'equal'}; {ours['verdict']}")
    print(f"{right} of {len(paths)} files equal")


def main(arguments):
    if arguments[:1] == ["--with"]:
        compare(arguments[1], arguments[2:])
    else:
        print(json.dumps({os.path.basename(path): joints(path) for path in arguments}, indent=1))


if __name__ == "__main__":
    main(sys.argv[1:])
