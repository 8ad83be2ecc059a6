//! SMPL's mean body at rest: the 22 joints of the body, without a shape of anybody's.
//!
//! Measured lengths only, to 0.1 mm, of the neutral model with all betas zero, as open repositories publish them:
//! `phc/data/assets/mjcf/smpl_humanoid.xml` of github.com/ZhengyiLuo/PHC (`pos` of its bodies). The body stands in a
//! T-pose, y up, z forward, x left. It was averaged from scans, so left and right differ by some millimetres.

/// Place of the pelvis in the body's own frame (m): the point about which the root's rotation turns.
pub(in crate::formats) const PELVIS: [f64; 3] = [-0.0018, -0.2233, 0.0282];

/// Name, parent, and offset from the parent (m) of each joint, in the order of `poses`.
pub(in crate::formats) const JOINTS: [(&str, Option<usize>, [f64; 3]); 22] = [
    ("pelvis", None, [0.0, 0.0, 0.0]),
    ("left_hip", Some(0), [0.0695, -0.0914, -0.0068]),
    ("right_hip", Some(0), [-0.0677, -0.0905, -0.0043]),
    ("spine1", Some(0), [-0.0025, 0.1090, -0.0267]),
    ("left_knee", Some(1), [0.0343, -0.3752, -0.0045]),
    ("right_knee", Some(2), [-0.0383, -0.3826, -0.0089]),
    ("spine2", Some(3), [0.0055, 0.1352, 0.0011]),
    ("left_ankle", Some(4), [-0.0136, -0.3980, -0.0437]),
    ("right_ankle", Some(5), [0.0158, -0.3984, -0.0423]),
    ("spine3", Some(6), [0.0015, 0.0529, 0.0254]),
    ("left_foot", Some(7), [0.0264, -0.0558, 0.1193]),
    ("right_foot", Some(8), [-0.0254, -0.0481, 0.1233]),
    ("neck", Some(9), [-0.0028, 0.2139, -0.0429]),
    ("left_collar", Some(9), [0.0788, 0.1217, -0.0341]),
    ("right_collar", Some(9), [-0.0818, 0.1188, -0.0386]),
    ("head", Some(12), [0.0052, 0.0650, 0.0513]),
    ("left_shoulder", Some(13), [0.0910, 0.0305, -0.0089]),
    ("right_shoulder", Some(14), [-0.0960, 0.0326, -0.0091]),
    ("left_elbow", Some(16), [0.2596, -0.0128, -0.0275]),
    ("right_elbow", Some(17), [-0.2537, -0.0133, -0.0214]),
    ("left_wrist", Some(18), [0.2492, 0.0090, -0.0012]),
    ("right_wrist", Some(19), [-0.2553, 0.0078, -0.0056]),
];

/// The wrists, and from there the middle of the knuckles (m): SMPL's last two joints. They make the hands' direction.
pub(in crate::formats) const HANDS: [(usize, [f64; 3]); 2] =
    [(20, [0.0840, -0.0082, -0.0149]), (21, [-0.0846, -0.0061, -0.0103])];
