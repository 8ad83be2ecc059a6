"""How long lima stands on one leg: sentences in physics, and the longest time in which the lifted foot is up.

    pip install mujoco safetensors
    python peers/language/legs.py LIFELIKE [POLICY]

A foot is up where it is more than 12 mm above its lowest place. Three seeds a sentence; the table is that of docs/results/language.md.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import mujoco
import numpy as np
from safetensors import safe_open

UP = 0.012
# The sentence, and the foot that is lifted; None is either.
SENTENCES = [
    ("stand on your left leg for 6 seconds", "right"),
    ("stand on your right leg for 6 seconds", "left"),
    ("stand on one leg for ten seconds", None),
    ("lift your right knee and hold it for four seconds", "right"),
    ("lift your left knee and hold it for four seconds", "left"),
    ("tree pose for eight seconds", None),
    ("lift your left leg to the side and hold it for three seconds", "left"),
    ("lift your right leg to the side and hold it for three seconds", "right"),
]
MODEL = mujoco.MjModel.from_xml_path(str(Path(__file__).resolve().parents[2] / "robots/lima.xml"))


def heights(clip):
    """Heights of both feet (m), a row for each frame, and the rate (Hz)."""
    with safe_open(clip, "np") as file:
        told = json.loads(file.metadata()["motion"])
        joints, orientation, position = (file.get_tensor(k) for k in ("joints", "root_orientation", "root_position"))
    columns = [MODEL.joint(name).qposadr[0] for name in told["joint_names"]]
    data, feet = mujoco.MjData(MODEL), {side: MODEL.body(f"{side}_foot").id for side in ("left", "right")}
    rows = {side: [] for side in feet}
    for t in range(len(position)):
        data.qpos[:3], data.qpos[3:7], data.qpos[columns] = position[t], orientation[t], joints[t]
        mujoco.mj_kinematics(MODEL, data)
        for side, body in feet.items():
            rows[side].append(data.xpos[body][2])
    return rows, told["fps"]


def longest(height, rate):
    """The longest time at a stretch in which a foot is up (s)."""
    up = np.concatenate([[False], np.array(height) > min(height) + UP, [False]]).astype(int)
    stretches = np.flatnonzero(np.diff(up)).reshape(-1, 2)
    return max((end - begin) / rate for begin, end in stretches) if len(stretches) else 0.0


def main(program, policy=None):
    chosen = ["--policy", policy] if policy else []
    for sentence, foot in SENTENCES:
        seconds = []
        for seed in ("1", "2", "3"):
            with tempfile.TemporaryDirectory() as folder:
                clip = Path(folder) / "x.motion.safetensors"
                command = [program, "generate", sentence, "--robot", "lima", "--project", "--seed", seed, "-o", clip, *chosen]
                subprocess.run(command, capture_output=True, check=True)
                rows, rate = heights(clip)
            seconds.append(max(longest(rows[side], rate) for side in rows if foot in (None, side)))
        print(f'| "{sentence}" | {", ".join(f"{x:.1f}" for x in seconds)} |', flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
