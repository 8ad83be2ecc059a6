"""Makes amass.npz, a file in AMASS' layout as NumPy writes it, and amass.json, where its joints are by SciPy.

    pip install numpy scipy
    python3 make_amass.py        # in this folder

Positions and rotations follow the definition of SMPL's skeleton, in the file's own world (z up): a joint's rotation
vector turns its frame in its parent's, the pelvis turns about its place at rest, and `trans` moves all of it. Lengths are
those of the neutral mean body to 0.1 mm, as github.com/ZhengyiLuo/PHC publishes them (smpl_humanoid.xml).
"""

import json

import numpy as np
from scipy.spatial.transform import Rotation

PELVIS = np.array([-0.0018, -0.2233, 0.0282])
PARENTS = [-1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19]
OFFSETS = np.array(
    [
        [0, 0, 0], [0.0695, -0.0914, -0.0068], [-0.0677, -0.0905, -0.0043], [-0.0025, 0.109, -0.0267],
        [0.0343, -0.3752, -0.0045], [-0.0383, -0.3826, -0.0089], [0.0055, 0.1352, 0.0011], [-0.0136, -0.398, -0.0437],
        [0.0158, -0.3984, -0.0423], [0.0015, 0.0529, 0.0254], [0.0264, -0.0558, 0.1193], [-0.0254, -0.0481, 0.1233],
        [-0.0028, 0.2139, -0.0429], [0.0788, 0.1217, -0.0341], [-0.0818, 0.1188, -0.0386], [0.0052, 0.065, 0.0513],
        [0.091, 0.0305, -0.0089], [-0.096, 0.0326, -0.0091], [0.2596, -0.0128, -0.0275], [-0.2537, -0.0133, -0.0214],
        [0.2492, 0.009, -0.0012], [-0.2553, 0.0078, -0.0056],
    ]
)

rng = np.random.default_rng(2019)
frames = 3
# Rotation vectors longer than a half turn are the same rotations, and must be read as such.
poses = rng.normal(scale=0.8, size=(frames, 156))
poses[1, :3] = [0.0, 0.0, 5.0]
poses[2, :6] = 0.0
trans = rng.normal(scale=1.5, size=(frames, 3))
np.savez_compressed(
    "amass.npz",
    trans=trans,
    gender=np.array("female"),
    mocap_framerate=np.array(120.0),
    betas=rng.normal(size=16),
    dmpls=np.zeros((frames, 8)),
    poses=poses,
)

positions, rotations = [], []
for pose, place in zip(poses, trans):
    turns, places = [], []
    for joint, parent in enumerate(PARENTS):
        local = Rotation.from_rotvec(pose[3 * joint : 3 * joint + 3])
        turns.append(local if parent < 0 else turns[parent] * local)
        places.append(PELVIS + place if parent < 0 else places[parent] + turns[parent].apply(OFFSETS[joint]))
    positions.append(np.round(places, 12).tolist())
    rotations.append([np.round(turn.as_quat(scalar_first=True), 12).tolist() for turn in turns])
with open("amass.json", "w") as file:
    json.dump({"positions": positions, "rotations_wxyz": rotations}, file)
    file.write("\n")
