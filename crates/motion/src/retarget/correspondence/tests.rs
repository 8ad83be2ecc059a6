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

/// Roots first; (thigh, shank, foot, upper arm, forearm, hand) of the left side, then pelvis, chest, head.
fn check(tree: &[(&str, Option<usize>)], expected: [&str; 9]) {
    let clip = clip(tree);
    let roles = SourceRoles::guess(&clip, &Correspondence::default()).unwrap();
    use Role::*;
    let wanted = [LeftThigh, LeftShank, LeftFoot, LeftUpperArm, LeftForearm, LeftHand, Pelvis, Chest, Head];
    for (role, name) in wanted.into_iter().zip(expected) {
        assert_eq!(roles.get(role).map(|j| tree[j].0), Some(name), "{role:?}");
    }
    assert!(tree[roles.get(RightThigh).unwrap()].0.to_lowercase().contains('r'));
    assert_ne!(roles.get(RightThigh), roles.get(LeftThigh));
}

#[test]
fn cmu_asf() {
    check(
        &[
            ("root", None),
            ("lhipjoint", Some(0)),
            ("lfemur", Some(1)),
            ("ltibia", Some(2)),
            ("lfoot", Some(3)),
            ("ltoes", Some(4)),
            ("rhipjoint", Some(0)),
            ("rfemur", Some(6)),
            ("rtibia", Some(7)),
            ("rfoot", Some(8)),
            ("rtoes", Some(9)),
            ("lowerback", Some(0)),
            ("upperback", Some(11)),
            ("thorax", Some(12)),
            ("lowerneck", Some(13)),
            ("upperneck", Some(14)),
            ("head", Some(15)),
            ("lclavicle", Some(13)),
            ("lhumerus", Some(17)),
            ("lradius", Some(18)),
            ("lwrist", Some(19)),
            ("lhand", Some(20)),
            ("rclavicle", Some(13)),
            ("rhumerus", Some(22)),
            ("rradius", Some(23)),
            ("rwrist", Some(24)),
            ("rhand", Some(25)),
        ],
        ["lfemur", "ltibia", "lfoot", "lhumerus", "lradius", "lwrist", "root", "thorax", "head"],
    );
}

#[test]
fn daz_bvh() {
    check(
        &[
            ("hip", None),
            ("abdomen", Some(0)),
            ("chest", Some(1)),
            ("neck", Some(2)),
            ("head", Some(3)),
            ("leftEye", Some(4)),
            ("rCollar", Some(2)),
            ("rShldr", Some(6)),
            ("rForeArm", Some(7)),
            ("rHand", Some(8)),
            ("lCollar", Some(2)),
            ("lShldr", Some(10)),
            ("lForeArm", Some(11)),
            ("lHand", Some(12)),
            ("rButtock", Some(0)),
            ("rThigh", Some(14)),
            ("rShin", Some(15)),
            ("rFoot", Some(16)),
            ("lButtock", Some(0)),
            ("lThigh", Some(18)),
            ("lShin", Some(19)),
            ("lFoot", Some(20)),
        ],
        ["lThigh", "lShin", "lFoot", "lShldr", "lForeArm", "lHand", "hip", "chest", "head"],
    );
}

#[test]
fn deepmimic() {
    check(
        &[
            ("root", None),
            ("chest", Some(0)),
            ("neck", Some(1)),
            ("right_hip", Some(0)),
            ("right_knee", Some(3)),
            ("right_ankle", Some(4)),
            ("right_shoulder", Some(1)),
            ("right_elbow", Some(6)),
            ("right_wrist", Some(7)),
            ("left_hip", Some(0)),
            ("left_knee", Some(9)),
            ("left_ankle", Some(10)),
            ("left_shoulder", Some(1)),
            ("left_elbow", Some(12)),
            ("left_wrist", Some(13)),
        ],
        ["left_hip", "left_knee", "left_ankle", "left_shoulder", "left_elbow", "left_wrist", "root", "chest", "neck"],
    );
}

#[test]
fn smpl() {
    check(
        &[
            ("pelvis", None),
            ("left_hip", Some(0)),
            ("right_hip", Some(0)),
            ("spine1", Some(0)),
            ("left_knee", Some(1)),
            ("right_knee", Some(2)),
            ("spine2", Some(3)),
            ("left_ankle", Some(4)),
            ("right_ankle", Some(5)),
            ("spine3", Some(6)),
            ("left_foot", Some(7)),
            ("right_foot", Some(8)),
            ("neck", Some(9)),
            ("left_collar", Some(9)),
            ("right_collar", Some(9)),
            ("head", Some(12)),
            ("left_shoulder", Some(13)),
            ("right_shoulder", Some(14)),
            ("left_elbow", Some(16)),
            ("right_elbow", Some(17)),
            ("left_wrist", Some(18)),
            ("right_wrist", Some(19)),
        ],
        [
            "left_hip",
            "left_knee",
            "left_ankle",
            "left_shoulder",
            "left_elbow",
            "left_wrist",
            "pelvis",
            "spine3",
            "head",
        ],
    );
}

#[test]
fn bandai_and_mixamo() {
    check(
        &[
            ("joint_Root", None),
            ("Hips", Some(0)),
            ("Spine", Some(1)),
            ("Chest", Some(2)),
            ("Neck", Some(3)),
            ("Head", Some(4)),
            ("Shoulder_L", Some(3)),
            ("UpperArm_L", Some(6)),
            ("LowerArm_L", Some(7)),
            ("Hand_L", Some(8)),
            ("Shoulder_R", Some(3)),
            ("UpperArm_R", Some(10)),
            ("LowerArm_R", Some(11)),
            ("Hand_R", Some(12)),
            ("UpperLeg_L", Some(1)),
            ("LowerLeg_L", Some(14)),
            ("Foot_L", Some(15)),
            ("Toes_L", Some(16)),
            ("UpperLeg_R", Some(1)),
            ("LowerLeg_R", Some(18)),
            ("Foot_R", Some(19)),
        ],
        ["UpperLeg_L", "LowerLeg_L", "Foot_L", "UpperArm_L", "LowerArm_L", "Hand_L", "Hips", "Chest", "Head"],
    );
    check(
        &[
            ("mixamorig:Hips", None),
            ("mixamorig:Spine2", Some(0)),
            ("mixamorig:Head", Some(1)),
            ("mixamorig:LeftShoulder", Some(1)),
            ("mixamorig:LeftArm", Some(3)),
            ("mixamorig:LeftForeArm", Some(4)),
            ("mixamorig:LeftHand", Some(5)),
            ("mixamorig:RightShoulder", Some(1)),
            ("mixamorig:RightArm", Some(7)),
            ("mixamorig:RightForeArm", Some(8)),
            ("mixamorig:RightHand", Some(9)),
            ("mixamorig:LeftUpLeg", Some(0)),
            ("mixamorig:LeftLeg", Some(11)),
            ("mixamorig:LeftFoot", Some(12)),
            ("mixamorig:LeftToeBase", Some(13)),
            ("mixamorig:RightUpLeg", Some(0)),
            ("mixamorig:RightLeg", Some(15)),
            ("mixamorig:RightFoot", Some(16)),
        ],
        [
            "mixamorig:LeftUpLeg",
            "mixamorig:LeftLeg",
            "mixamorig:LeftFoot",
            "mixamorig:LeftArm",
            "mixamorig:LeftForeArm",
            "mixamorig:LeftHand",
            "mixamorig:Hips",
            "mixamorig:Spine2",
            "mixamorig:Head",
        ],
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
            ("pelvis", None),
            ("spine_03", Some(0)),
            ("head", Some(1)),
            ("thigh_l", Some(0)),
            ("thigh_twist_01_l", Some(3)),
            ("calf_l", Some(3)),
            ("calf_twist_01_l", Some(5)),
            ("ik_foot_l", Some(0)),
            ("foot_l", Some(5)),
            ("thigh_r", Some(0)),
            ("calf_r", Some(9)),
            ("foot_r", Some(10)),
            ("upperarm_l", Some(1)),
            ("upperarm_twist_01_l", Some(12)),
            ("lowerarm_l", Some(12)),
            ("lowerarm_twist_01_l", Some(14)),
            ("ik_hand_l", Some(0)),
            ("hand_l", Some(14)),
            ("upperarm_r", Some(1)),
            ("lowerarm_r", Some(18)),
            ("hand_r", Some(19)),
        ],
        ["thigh_l", "calf_l", "foot_l", "upperarm_l", "lowerarm_l", "hand_l", "pelvis", "spine_03", "head"],
    );
}

#[test]
fn roles_on_a_command_line() {
    let given: Correspondence = "left_thigh=L Hip, right_toe=R_Ball".parse().unwrap();
    assert_eq!((given.roles[&Role::LeftThigh].as_str(), given.right_toe.as_deref()), ("L Hip", Some("R_Ball")));
    assert!("left_thig=a".parse::<Correspondence>().unwrap_err().contains("left_thig"));
    assert!("left_thigh".parse::<Correspondence>().is_err());
}
