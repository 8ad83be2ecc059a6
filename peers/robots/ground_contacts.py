"""Contacts of cylinders and ellipsoids with level ground, as MuJoCo finds them at random poses: the fixture of `engine::curved`.

    python ground_contacts.py > crates/sim/tests/fixtures/ground_contacts.json

Needs mujoco 4.0 and numpy.
"""

import json

import mujoco
import numpy as np


def contacts(form, size, position, quaternion):
    text = f"""<mujoco><worldbody><geom type="plane" size="1 1 1"/><body><freejoint/>
      <geom type="{form}" size="{' '.join(map(repr, size))}" mass="1"/></body></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[:] = [*position, *quaternion]
    mujoco.mj_normalizeQuat(model, data.qpos)
    mujoco.mj_forward(model, data)
    return [([round(x, 12) for x in c.pos], round(c.dist, 12)) for c in data.contact]


def main():
    random = np.random.default_rng(0)
    poses = []
    while len(poses) < 300:
        form = ["cylinder", "ellipsoid"][len(poses) % 2]
        size = [round(float(x), 3) for x in random.uniform(0.02, 0.2, 3)]
        if len(poses) % 4 == 0:  # nearly upright, as feet are
            quaternion = np.concatenate([[1.0], random.uniform(-0.1, 0.1, 3)])
        else:
            quaternion = random.normal(size=4)
        quaternion = [round(float(x), 3) for x in quaternion]  # MuJoCo normalises it
        position = [round(float(x), 3) for x in random.uniform([-0.5, -0.5, -0.05], [0.5, 0.5, 0.15])]
        found = contacts(form, size, position, quaternion)
        poses.append({"form": form, "size": size, "position": position, "quaternion": quaternion, "contacts": found})
    print("[\n" + ",\n".join(json.dumps(pose) for pose in poses) + "\n]")


main()
