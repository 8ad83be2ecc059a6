//! Skeletons of the data sets that people use.
#![allow(clippy::unwrap_used, clippy::expect_used)]
use super::*;
use crate::source::Skeleton;
use lifelike_character::Vec3;

fn clip(tree: &[(&str, Option<usize>)]) -> SourceClip {
    SourceClip {
        name: "c".into(),
        fps: 30.0,
        skeleton: Skeleton {
            names: tree.iter().map(|(n, _)| (*n).to_string()).collect(),
            parents: tree.iter().map(|(_, p)| *p).collect(),
            offsets: vec![Vec3::zeros(); tree.len()],
            ends: Vec::new(),
        },
        root_position: Vec::new(),
        rotations: Vec::new(),
        cyclic: false,
        captions: Vec::new(),
        provenance: String::new(),
        notes: Vec::new(),
    }
}

/// Joints in the order in which they are named, and the parent of each: a line goes from a joint that is known, or from
/// the root, to a joint that hangs on it, and so on.
fn tree<'a>(lines: &[&'a str]) -> Vec<(&'a str, Option<usize>)> {
    let mut joints: Vec<(&str, Option<usize>)> = Vec::new();
    for line in lines {
        let mut parent = None;
        for name in line.split(' ') {
            let known = joints.iter().position(|(joint, _)| *joint == name);
            parent = Some(known.unwrap_or_else(|| {
                joints.push((name, parent));
                joints.len() - 1
            }));
        }
    }
    joints
}

/// Lines of a skeleton ([`tree`]); (thigh, shank, foot, upper arm, forearm, hand) of the left side, then pelvis, chest,
/// head.
fn check(lines: &[&str], expected: &str) {
    let tree = tree(lines);
    let roles = SourceRoles::guess(&clip(&tree), &Correspondence::default()).unwrap();
    use Role::*;
    let wanted = [LeftThigh, LeftShank, LeftFoot, LeftUpperArm, LeftForearm, LeftHand, Pelvis, Chest, Head];
    let found: Vec<Option<&str>> = wanted.iter().map(|role| roles.get(*role).map(|joint| tree[joint].0)).collect();
    assert_eq!(found, expected.split(' ').map(Some).collect::<Vec<_>>());
    assert!(tree[roles.get(RightThigh).unwrap()].0.to_lowercase().contains('r'));
    assert_ne!(roles.get(RightThigh), roles.get(LeftThigh));
}

#[test]
fn cmu_asf() {
    check(
        &[
            "root lhipjoint lfemur ltibia lfoot ltoes",
            "root rhipjoint rfemur rtibia rfoot rtoes",
            "root lowerback upperback thorax lowerneck upperneck head",
            "thorax lclavicle lhumerus lradius lwrist lhand",
            "thorax rclavicle rhumerus rradius rwrist rhand",
        ],
        "lfemur ltibia lfoot lhumerus lradius lwrist root thorax head",
    );
}

#[test]
fn daz_bvh() {
    check(
        &[
            "hip abdomen chest neck head leftEye",
            "chest rCollar rShldr rForeArm rHand",
            "chest lCollar lShldr lForeArm lHand",
            "hip rButtock rThigh rShin rFoot",
            "hip lButtock lThigh lShin lFoot",
        ],
        "lThigh lShin lFoot lShldr lForeArm lHand hip chest head",
    );
}

#[test]
fn deepmimic() {
    check(
        &[
            "root chest neck",
            "root right_hip right_knee right_ankle",
            "chest right_shoulder right_elbow right_wrist",
            "root left_hip left_knee left_ankle",
            "chest left_shoulder left_elbow left_wrist",
        ],
        "left_hip left_knee left_ankle left_shoulder left_elbow left_wrist root chest neck",
    );
}

#[test]
fn smpl() {
    check(
        &[
            "pelvis left_hip",
            "pelvis right_hip",
            "pelvis spine1",
            "left_hip left_knee",
            "right_hip right_knee",
            "spine1 spine2",
            "left_knee left_ankle",
            "right_knee right_ankle",
            "spine2 spine3",
            "left_ankle left_foot",
            "right_ankle right_foot",
            "spine3 neck",
            "spine3 left_collar",
            "spine3 right_collar",
            "neck head",
            "left_collar left_shoulder",
            "right_collar right_shoulder",
            "left_shoulder left_elbow",
            "right_shoulder right_elbow",
            "left_elbow left_wrist",
            "right_elbow right_wrist",
        ],
        "left_hip left_knee left_ankle left_shoulder left_elbow left_wrist pelvis spine3 head",
    );
}

#[test]
fn bandai_and_mixamo() {
    check(
        &[
            "joint_Root Hips Spine Chest Neck Head",
            "Chest Shoulder_L UpperArm_L LowerArm_L Hand_L",
            "Chest Shoulder_R UpperArm_R LowerArm_R Hand_R",
            "Hips UpperLeg_L LowerLeg_L Foot_L Toes_L",
            "Hips UpperLeg_R LowerLeg_R Foot_R",
        ],
        "UpperLeg_L LowerLeg_L Foot_L UpperArm_L LowerArm_L Hand_L Hips Chest Head",
    );
    check(
        &[
            "mixamorig:Hips mixamorig:Spine2 mixamorig:Head",
            "mixamorig:Spine2 mixamorig:LeftShoulder mixamorig:LeftArm mixamorig:LeftForeArm mixamorig:LeftHand",
            "mixamorig:Spine2 mixamorig:RightShoulder mixamorig:RightArm mixamorig:RightForeArm mixamorig:RightHand",
            "mixamorig:Hips mixamorig:LeftUpLeg mixamorig:LeftLeg mixamorig:LeftFoot mixamorig:LeftToeBase",
            "mixamorig:Hips mixamorig:RightUpLeg mixamorig:RightLeg mixamorig:RightFoot",
        ],
        "mixamorig:LeftUpLeg mixamorig:LeftLeg mixamorig:LeftFoot mixamorig:LeftArm mixamorig:LeftForeArm mixamorig:LeftHand mixamorig:Hips mixamorig:Spine2 mixamorig:Head",
    );
}

#[test]
fn a_skeleton_without_legs_is_refused_with_its_joints() {
    let error = SourceRoles::guess(&clip(&[("root", None), ("tail", Some(0))]), &Correspondence::default());
    let text = error.unwrap_err().to_string();
    assert!(text.contains("no left leg") && text.contains("root, tail"), "{text}");
}

#[test]
fn overrides_are_text_and_unknown_keys_are_refused() {
    let given: Correspondence = toml::from_str("left_toe = \"t\"\n[roles]\nleft_thigh = \"a\"").unwrap();
    assert_eq!(given.roles[&Role::LeftThigh], "a");
    assert!(toml::from_str::<Correspondence>("left_tow = \"t\"").is_err());
    let error = SourceRoles::guess(&clip(&[("root", None)]), &given).unwrap_err().to_string();
    assert!(error.contains("'a'"), "{error}");
}

#[test]
fn writers_names_lead_to_the_same_roles() {
    // Hips, spine, chest, neck, head; left thigh to hand; the right ones by swapping the marks.
    const PARENTS: [Option<usize>; 12] =
        [None, Some(0), Some(1), Some(2), Some(3), Some(0), Some(5), Some(6), Some(2), Some(8), Some(9), Some(10)];
    for (middle, limbs, [left, right]) in [
        (
            "Bip01",
            "Bip01_?_Thigh Bip01_?_Calf Bip01_?_Foot Bip01_?_Clavicle Bip01_?_UpperArm Bip01_?_Forearm Bip01_?_Hand",
            ["L", "R"],
        ),
        (
            "Bip001 Pelvis",
            "Bip001·?·Thigh Bip001·?·Calf Bip001·?·Foot Bip001·?·Clavicle Bip001·?·UpperArm Bip001·?·Forearm Bip001·?·Hand",
            ["L", "R"],
        ),
        (
            "CC_Base_Hip",
            "CC_Base_?_Thigh CC_Base_?_Calf CC_Base_?_Foot CC_Base_?_Clavicle CC_Base_?_Upperarm CC_Base_?_Forearm CC_Base_?_Hand",
            ["L", "R"],
        ),
        (
            "m_avg_Pelvis",
            "m_avg_?_Hip m_avg_?_Knee m_avg_?_Ankle m_avg_?_Collar m_avg_?_Shoulder m_avg_?_Elbow m_avg_?_Wrist",
            ["L", "R"],
        ),
        (
            "J_Bip_C_Hips",
            "J_Bip_?_UpperLeg J_Bip_?_LowerLeg J_Bip_?_Foot J_Bip_?_Shoulder J_Bip_?_UpperArm J_Bip_?_LowerArm J_Bip_?_Hand",
            ["L", "R"],
        ),
        (
            "Character1_Hips",
            "Character1_?UpLeg Character1_?Leg Character1_?Foot Character1_?Shoulder Character1_?Arm Character1_?ForeArm Character1_?Hand",
            ["Left", "Right"],
        ),
        (
            "Armature_Pelvis",
            "Armature_?Thigh Armature_?Calf Armature_?Foot Armature_?Clavicle Armature_?UpperArm Armature_?Forearm Armature_?Hand",
            ["Left", "Right"],
        ),
        (
            "def_Pelvis",
            "def_?_Thigh def_?_Calf def_?_Foot def_?_Clavicle def_?_UpperArm def_?_Forearm def_?_Hand",
            ["l", "r"],
        ),
        ("Hip", "?Thigh ?Shin ?Foot ?Shoulder ?UArm ?FArm ?Hand", ["L", "R"]),
        ("hip", "?Thigh ?Shin ?Foot ?Collar ?Shldr ?ForeArm ?Hand", ["l", "r"]),
        ("pelvis", "?hip ?knee ?ankle ?clavicle ?shoulder ?elbow ?wrist", ["l", "r"]),
        ("pelvis", "thigh_? calf_? foot_? clavicle_? upperarm_? lowerarm_? hand_?", ["l", "r"]),
        (
            "DEF-spine",
            "DEF-thigh.? DEF-shin.? DEF-foot.? DEF-shoulder.? DEF-upper_arm.? DEF-forearm.? DEF-hand.?",
            ["L", "R"],
        ),
        ("root", "upperleg01.? lowerleg01.? foot.? clavicle.? upperarm01.? lowerarm01.? wrist.?", ["L", "R"]),
        ("pelvis", "?_leg_upper_leg ?_leg_shin ?_foot ?_shoulder ?_upper_arm ?_lower_arm ?_hand", ["left", "right"]),
        ("LOWERTORSO", "?THIGH ?SHIN ?FOOT ?SHOULDER ?UPPERARM ?FOREARM ?HAND", ["LEFT", "RIGHT"]),
    ] {
        let mut tree: Vec<(String, Option<usize>)> = [middle, "Spine", "Chest", "Neck", "Head"]
            .into_iter()
            .zip(PARENTS)
            .map(|(name, parent)| (name.to_owned(), parent))
            .collect();
        for (side, mark) in [left, right].into_iter().enumerate() {
            for (at, name) in limbs.split(' ').enumerate() {
                let parent = PARENTS[5 + at].map(|parent| if parent < 5 { parent } else { parent + 7 * side });
                tree.push((name.replace('?', mark).replace('·', " "), parent));
            }
        }
        let named: Vec<(&str, Option<usize>)> = tree.iter().map(|(name, parent)| (name.as_str(), *parent)).collect();
        let roles = SourceRoles::guess(&clip(&named), &Correspondence::default()).unwrap_or_else(|e| panic!("{e}"));
        use Role::*;
        let wanted = [
            LeftThigh,
            LeftShank,
            LeftFoot,
            LeftUpperArm,
            LeftForearm,
            LeftHand,
            RightThigh,
            RightShank,
            RightFoot,
            RightUpperArm,
            RightForearm,
            RightHand,
            Pelvis,
            Chest,
            Head,
        ];
        let joints = wanted.map(|role| roles.get(role));
        assert_eq!(joints, [5, 6, 7, 9, 10, 11, 12, 13, 14, 16, 17, 18, 0, 2, 4].map(Some), "{limbs}: {joints:?}");
    }
}

#[test]
fn helper_bones_are_no_limbs() {
    check(
        &[
            "pelvis spine_03 head",
            "pelvis thigh_l thigh_twist_01_l",
            "thigh_l calf_l calf_twist_01_l",
            "pelvis ik_foot_l",
            "calf_l foot_l",
            "pelvis thigh_r calf_r foot_r",
            "spine_03 upperarm_l upperarm_twist_01_l",
            "upperarm_l lowerarm_l lowerarm_twist_01_l",
            "pelvis ik_hand_l",
            "lowerarm_l hand_l",
            "spine_03 upperarm_r lowerarm_r hand_r",
        ],
        "thigh_l calf_l foot_l upperarm_l lowerarm_l hand_l pelvis spine_03 head",
    );
}

#[test]
fn roles_on_a_command_line() {
    let given: Correspondence = "left_thigh=L Hip, right_toe=R_Ball".parse().unwrap();
    assert_eq!((given.roles[&Role::LeftThigh].as_str(), given.right_toe.as_deref()), ("L Hip", Some("R_Ball")));
    assert!("left_thig=a".parse::<Correspondence>().unwrap_err().contains("left_thig"));
    assert!("left_thigh".parse::<Correspondence>().is_err());
}
