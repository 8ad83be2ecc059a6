//! One walk in the layouts of many writers: names, frames of joints, axes, units. Places of joints over time are the same
//! in all, so the retargeted motion must be.
use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt::Write as _;
use std::path::Path;

use lifelike_character::{Anatomy, Character, Kinematics, Quat, Vec3};
use lifelike_motion::formats::{Axis, ReadOptions, bvh};
use lifelike_motion::retarget::{Bounds, Correspondence, RetargetOptions, RetargetReport, retarget};
use lifelike_motion::{MotionClip, MotionError, SourceClip, keyframes};

/// Parent, offset (m; x forward, y left, z up), joint of the keyframed figure whose rotation it has.
type Bone = (Option<usize>, [f64; 3], Option<&'static str>);

/// The keyframed figure with the joints that captures have besides: spine, neck, collar bones, toes.
const BONES: [Bone; 21] = [
    (None, [0.0, 0.0, 0.0], Some("pelvis")),
    (Some(0), [0.0, 0.09, 0.0], Some("left_hip")),
    (Some(1), [0.0, 0.0, -0.41], Some("left_knee")),
    (Some(2), [0.0, 0.0, -0.41], Some("left_ankle")),
    (Some(3), [0.12, 0.0, -0.06], None),
    (Some(0), [0.0, -0.09, 0.0], Some("right_hip")),
    (Some(5), [0.0, 0.0, -0.41], Some("right_knee")),
    (Some(6), [0.0, 0.0, -0.41], Some("right_ankle")),
    (Some(7), [0.12, 0.0, -0.06], None),
    (Some(0), [0.0, 0.0, 0.07], None),
    (Some(9), [0.0, 0.0, 0.08], Some("chest")),
    (Some(10), [0.0, 0.0, 0.34], None),
    (Some(11), [0.0, 0.0, 0.06], Some("head")),
    (Some(10), [0.0, 0.04, 0.33], None),
    (Some(13), [0.0, 0.14, 0.0], Some("left_shoulder")),
    (Some(14), [0.0, 0.29, 0.0], Some("left_elbow")),
    (Some(15), [0.0, 0.25, 0.0], Some("left_wrist")),
    (Some(10), [0.0, -0.04, 0.33], None),
    (Some(17), [0.0, -0.14, 0.0], Some("right_shoulder")),
    (Some(18), [0.0, -0.29, 0.0], Some("right_elbow")),
    (Some(19), [0.0, -0.25, 0.0], Some("right_wrist")),
];
/// Ends of toes, head and hands.
const ENDS: [(usize, [f64; 3]); 5] = [
    (4, [0.06, 0.0, 0.0]),
    (8, [0.06, 0.0, 0.0]),
    (12, [0.0, 0.0, 0.2]),
    (16, [0.0, 0.17, 0.0]),
    (20, [0.0, -0.17, 0.0]),
];

/// The frames of a layout's joints.
#[derive(Clone, Copy, PartialEq)]
enum Frames {
    /// Zero rotations are a T-pose, along the axes of the world.
    Upright,
    /// Likewise, with arms that hang by this angle (rad) below the horizontal.
    Arms(f64),
    /// Bones along an axis of their joint's frame, in the direction of the sign on the right side.
    Bones { axis: usize, mirrored: bool },
    /// Zero rotations stand along y, whatever axis of the world is up.
    YUp,
}

struct Layout {
    writer: &'static str,
    names: [&'static str; 21],
    frames: Frames,
}

fn layouts() -> Vec<Layout> {
    let layout = |writer, names: &'static str, frames| Layout {
        writer,
        names: names.split(',').collect::<Vec<_>>().try_into().unwrap(),
        frames,
    };
    let x = Frames::Bones { axis: 0, mirrored: false };
    vec![
        layout(
            "LAFAN1",
            "Hips,LeftUpLeg,LeftLeg,LeftFoot,LeftToe,RightUpLeg,RightLeg,RightFoot,RightToe,Spine,Spine2,Neck,Head,LeftShoulder,LeftArm,LeftForeArm,LeftHand,RightShoulder,RightArm,RightForeArm,RightHand",
            x,
        ),
        layout(
            "Rokoko",
            "Hips,LeftThigh,LeftShin,LeftFoot,LeftToe,RightThigh,RightShin,RightFoot,RightToe,Spine1,Spine4,Neck,Head,LeftShoulder,LeftArm,LeftForeArm,LeftHand,RightShoulder,RightArm,RightForeArm,RightHand",
            x,
        ),
        layout(
            "Mixamo",
            "mixamorig:Hips,mixamorig:LeftUpLeg,mixamorig:LeftLeg,mixamorig:LeftFoot,mixamorig:LeftToeBase,mixamorig:RightUpLeg,mixamorig:RightLeg,mixamorig:RightFoot,mixamorig:RightToeBase,mixamorig:Spine,mixamorig:Spine1,mixamorig:Neck,mixamorig:Head,mixamorig:LeftShoulder,mixamorig:LeftArm,mixamorig:LeftForeArm,mixamorig:LeftHand,mixamorig:RightShoulder,mixamorig:RightArm,mixamorig:RightForeArm,mixamorig:RightHand",
            Frames::Upright,
        ),
        layout(
            "Unreal",
            "pelvis,thigh_l,calf_l,foot_l,ball_l,thigh_r,calf_r,foot_r,ball_r,spine_01,spine_02,neck_01,head,clavicle_l,upperarm_l,lowerarm_l,hand_l,clavicle_r,upperarm_r,lowerarm_r,hand_r",
            Frames::Bones { axis: 0, mirrored: true },
        ),
        layout(
            "Rigify",
            "DEF-spine,DEF-thigh.L,DEF-shin.L,DEF-foot.L,DEF-toe.L,DEF-thigh.R,DEF-shin.R,DEF-foot.R,DEF-toe.R,DEF-spine.001,DEF-spine.003,DEF-spine.004,DEF-spine.006,DEF-shoulder.L,DEF-upper_arm.L,DEF-forearm.L,DEF-hand.L,DEF-shoulder.R,DEF-upper_arm.R,DEF-forearm.R,DEF-hand.R",
            Frames::Bones { axis: 1, mirrored: false },
        ),
        layout(
            "VRM",
            "J_Bip_C_Hips,J_Bip_L_UpperLeg,J_Bip_L_LowerLeg,J_Bip_L_Foot,J_Bip_L_ToeBase,J_Bip_R_UpperLeg,J_Bip_R_LowerLeg,J_Bip_R_Foot,J_Bip_R_ToeBase,J_Bip_C_Spine,J_Bip_C_Chest,J_Bip_C_Neck,J_Bip_C_Head,J_Bip_L_Shoulder,J_Bip_L_UpperArm,J_Bip_L_LowerArm,J_Bip_L_Hand,J_Bip_R_Shoulder,J_Bip_R_UpperArm,J_Bip_R_LowerArm,J_Bip_R_Hand",
            Frames::Upright,
        ),
        layout(
            "SMPL",
            "Pelvis,L_Hip,L_Knee,L_Ankle,L_Foot,R_Hip,R_Knee,R_Ankle,R_Foot,Spine1,Spine3,Neck,Head,L_Collar,L_Shoulder,L_Elbow,L_Wrist,R_Collar,R_Shoulder,R_Elbow,R_Wrist",
            Frames::Upright,
        ),
        layout(
            "Xsens",
            "Hips,LeftHip,LeftKnee,LeftAnkle,LeftToe,RightHip,RightKnee,RightAnkle,RightToe,Chest,Chest4,Neck,Head,LeftCollar,LeftShoulder,LeftElbow,LeftWrist,RightCollar,RightShoulder,RightElbow,RightWrist",
            Frames::Arms(1.5),
        ),
        layout(
            "OptiTrack",
            "Hip,LThigh,LShin,LFoot,LToe,RThigh,RShin,RFoot,RToe,Ab,Chest,Neck,Head,LShoulder,LUArm,LFArm,LHand,RShoulder,RUArm,RFArm,RHand",
            Frames::Arms(0.8),
        ),
        layout(
            "3ds Max",
            "Bip01,Bip01 L Thigh,Bip01 L Calf,Bip01 L Foot,Bip01 L Toe0,Bip01 R Thigh,Bip01 R Calf,Bip01 R Foot,Bip01 R Toe0,Bip01 Spine,Bip01 Spine1,Bip01 Neck,Bip01 Head,Bip01 L Clavicle,Bip01 L UpperArm,Bip01 L Forearm,Bip01 L Hand,Bip01 R Clavicle,Bip01 R UpperArm,Bip01 R Forearm,Bip01 R Hand",
            x,
        ),
        layout("no names", "a,b,c,d,e,f,g,h,i,j,k,l,m,n,o,p,q,s,t,u,v", Frames::Upright),
        layout("no names, bones along x", "a,b,c,d,e,f,g,h,i,j,k,l,m,n,o,p,q,s,t,u,v", x),
    ]
}

/// The walk's first seconds, and its joints of [`BONES`].
fn walk() -> (SourceClip, Vec<Option<usize>>) {
    let (_, text) = keyframes::builtin().find(|(name, _)| *name == "walk").unwrap();
    let mut clip = keyframes::parse(text.as_bytes(), Path::new("walk")).unwrap();
    let frames = (4.0 * clip.fps) as usize;
    clip.root_position.truncate(frames);
    clip.rotations.truncate(frames);
    let joints = BONES.map(|(.., name)| name.map(|name| clip.skeleton.names.iter().position(|n| n == name).unwrap()));
    (clip, joints.to_vec())
}

/// From our axes to a file's: y or z up, facing by quarter turns.
fn axes(z_up: bool, quarters: usize) -> Quat {
    let turn = Quat::from_axis_angle(&Vec3::z_axis(), quarters as f64 * FRAC_PI_2);
    // x forward, y left, z up become z, x, y.
    let y_up = Quat::from_axis_angle(&nalgebra::Unit::new_normalize(Vec3::new(1.0, 1.0, 1.0)), -2.0 * PI / 3.0);
    if z_up { turn } else { y_up * turn }
}

/// The frame of every joint in the T-pose, in our axes.
fn frames_of(kind: Frames, axes: &Quat, joint: usize) -> Quat {
    let y_up = Quat::from_axis_angle(&nalgebra::Unit::new_normalize(Vec3::new(1.0, 1.0, 1.0)), -2.0 * PI / 3.0);
    let is_arm = joint >= 13;
    let on_the_right = (5..9).contains(&joint) || joint >= 17;
    match kind {
        Frames::Upright => axes.inverse(),
        Frames::YUp => y_up.inverse(),
        Frames::Arms(angle) if is_arm => {
            let sign = if on_the_right { -1.0 } else { 1.0 };
            Quat::from_axis_angle(&Vec3::x_axis(), sign * angle) * axes.inverse()
        }
        Frames::Arms(_) => axes.inverse(),
        Frames::Bones { axis, mirrored } => {
            let child = if joint == 0 { 9 } else { (joint + 1..21).find(|j| BONES[*j].0 == Some(joint)).unwrap_or(0) };
            let offset = match child {
                0 => ENDS.iter().find(|(j, _)| *j == joint).unwrap().1,
                child => BONES[child].1,
            };
            let sign = if mirrored && on_the_right { -1.0 } else { 1.0 };
            let bone = Vec3::from(offset).normalize() * sign;
            let side = if bone.y.abs() < 0.5 { Vec3::y() } else { Vec3::z() };
            let third = bone.cross(&side).normalize();
            let columns = if axis == 0 { [bone, side, third] } else { [-side, bone, third] };
            Quat::from_matrix(&nalgebra::Matrix3::from_columns(&columns))
        }
    }
}

/// Writes the walk as a BVH file in a layout, in centimetres and degrees.
fn write(layout: &Layout, axes: &Quat) -> String {
    write_with(layout, axes, 0, 1.0)
}

/// Likewise, with frames of a T-pose before the walk, and angles in another unit.
fn write_with(layout: &Layout, axes: &Quat, lead: usize, unit: f64) -> String {
    let (mut clip, joints) = walk();
    for _ in 0..lead {
        let still = vec![Quat::identity(); clip.skeleton.names.len()];
        clip.root_position.insert(0, clip.root_position[0]);
        clip.rotations.insert(0, still);
    }
    let frames: Vec<Quat> = (0..21).map(|joint| frames_of(layout.frames, axes, joint)).collect();
    let mut text = "HIERARCHY\n".to_owned();
    node(layout, &frames, 0, &mut text);
    writeln!(text, "MOTION\nFrames: {}\nFrame Time: {}", clip.len(), 1.0 / clip.fps).unwrap();
    for t in 0..clip.len() {
        let root = axes * clip.root_position[t] * 100.0;
        write!(text, "{} {} {}", root.x, root.y, root.z).unwrap();
        for (joint, (parent, ..)) in BONES.iter().enumerate() {
            let own = joints[joint].map_or_else(Quat::identity, |joint| clip.rotations[t][joint]);
            let before = parent.map_or(*axes, |parent| frames[parent].inverse());
            let [z, x, y] = angles(&(before * own * frames[joint])).map(|angle| angle * unit);
            write!(text, " {z} {x} {y}").unwrap();
        }
        text.push('\n');
    }
    text
}

fn node(layout: &Layout, frames: &[Quat], joint: usize, text: &mut String) {
    let (parent, offset, _) = BONES[joint];
    let at = |parent: usize, offset: [f64; 3]| frames[parent].inverse() * Vec3::from(offset) * 100.0;
    let offset = parent.map_or_else(Vec3::zeros, |parent| at(parent, offset));
    let (kind, channels) = match parent {
        None => ("ROOT", "6 Xposition Yposition Zposition"),
        Some(_) => ("JOINT", "3"),
    };
    let name = layout.names[joint];
    let [x, y, z] = [offset.x, offset.y, offset.z];
    writeln!(text, "{kind} {name}\n{{\nOFFSET {x} {y} {z}\nCHANNELS {channels} Zrotation Xrotation Yrotation").unwrap();
    for child in (0..21).filter(|child| BONES[*child].0 == Some(joint)) {
        node(layout, frames, child, text);
    }
    for (_, offset) in ENDS.iter().filter(|(j, _)| *j == joint) {
        let end = at(joint, *offset);
        writeln!(text, "End Site\n{{\nOFFSET {} {} {}\n}}", end.x, end.y, end.z).unwrap();
    }
    text.push_str("}\n");
}

/// Angles (deg) about z, x, y, applied in this order: R = Rz Rx Ry.
fn angles(turn: &Quat) -> [f64; 3] {
    let m = turn.to_rotation_matrix();
    let sine: f64 = m[(2, 1)].clamp(-1.0, 1.0);
    let (z, y) = if sine.abs() > 1.0 - 1e-12 {
        (m[(1, 0)].atan2(m[(0, 0)]), 0.0)
    } else {
        ((-m[(0, 1)]).atan2(m[(1, 1)]), (-m[(2, 0)]).atan2(m[(2, 2)]))
    };
    [z, sine.asin(), y].map(f64::to_degrees)
}

fn robot() -> (Character, Anatomy) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/lima.xml");
    let character = Character::load(path).unwrap();
    let anatomy = Anatomy::guess(&character, &Default::default()).unwrap();
    (character, anatomy)
}

fn read(text: &str, options: &ReadOptions) -> Result<SourceClip, MotionError> {
    bvh::parse(text.as_bytes(), Path::new("walk.bvh"), options)
}

fn converted(text: &str) -> Result<(MotionClip, RetargetReport), MotionError> {
    let (character, anatomy) = robot();
    let source = read(text, &ReadOptions::default())?;
    retarget(&source, &character, &anatomy, &RetargetOptions::default())
}

fn base() -> Layout {
    layouts().into_iter().find(|layout| layout.writer == "Mixamo").unwrap()
}

/// The largest differences: of a joint or the root's orientation (deg), and of a body's place (m).
fn difference(a: &MotionClip, b: &MotionClip) -> (f64, f64) {
    assert_eq!(a.len(), b.len());
    let (character, _) = robot();
    let columns = a.columns_for(&character).unwrap();
    let mut kinematics = [Kinematics::new(&character), Kinematics::new(&character)];
    let mut positions = [character.reference_position(), character.reference_position()];
    let (mut angle, mut place) = (0.0_f64, 0.0_f64);
    for t in 0..a.len() {
        for ((clip, kinematics), position) in [a, b].into_iter().zip(&mut kinematics).zip(&mut positions) {
            clip.write_position(&character, &columns, t, position);
            kinematics.update(&character, position);
        }
        let joints = a.joints_at(t).iter().zip(b.joints_at(t)).map(|(a, b)| (a - b).abs());
        let turn = a.root_orientation[t].angle_to(&b.root_orientation[t]);
        angle = joints.fold(angle.max(turn), f64::max);
        let [a, b] = &kinematics;
        place = a.body_position.iter().zip(&b.body_position).map(|(a, b)| (a - b).norm()).fold(place, f64::max);
    }
    (angle.to_degrees(), place)
}

#[test]
fn one_walk_is_one_motion_in_every_layout_up_axis_and_facing() {
    let (wanted, _) = converted(&write(&base(), &axes(false, 0))).unwrap();
    let mut wrong = Vec::new();
    for layout in layouts() {
        for z_up in [false, true] {
            for quarters in 0..4 {
                let what = format!("{} {} up, {quarters} quarters", layout.writer, if z_up { "z" } else { "y" });
                match converted(&write(&layout, &axes(z_up, quarters))) {
                    Ok((clip, _)) => {
                        let (angle, place) = difference(&clip, &wanted);
                        if angle > 1.0 || place > 0.01 {
                            wrong.push(format!("{what}: {angle:.2} deg, {place:.4} m"));
                        }
                    }
                    Err(error) => wrong.push(format!("{what}: {error}")),
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), layouts().len() * 8, wrong.join("\n"));
}

#[test]
fn a_motion_may_have_another_up_axis_than_its_rest_pose() {
    let (wanted, _) = converted(&write(&base(), &axes(false, 0))).unwrap();
    let layout = Layout { frames: Frames::YUp, ..base() };
    for quarters in 0..4 {
        let (clip, report) = converted(&write(&layout, &axes(true, quarters))).unwrap();
        let (angle, place) = difference(&clip, &wanted);
        assert!(angle < 1.0 && place < 0.01, "{quarters}: {angle} deg, {place} m");
        assert!(report.notes[0].contains("stands along y, the motion along z"), "{:?}", report.notes);
    }
    // Upside down, as in a camera's frame.
    let over = Quat::from_axis_angle(&Vec3::z_axis(), PI) * axes(false, 0);
    let (clip, _) = converted(&write(&layout, &over)).unwrap();
    let (angle, place) = difference(&clip, &wanted);
    assert!(angle < 1.0 && place < 0.01, "{angle} deg, {place} m");
}

#[test]
fn a_rest_pose_before_the_motion_is_left_out() {
    let (wanted, _) = converted(&write(&base(), &axes(false, 0))).unwrap();
    for layout in layouts().iter().filter(|layout| ["Mixamo", "LAFAN1"].contains(&layout.writer)) {
        for lead in [1, 3] {
            let (clip, report) = converted(&write_with(layout, &axes(false, 0), lead, 1.0)).unwrap();
            let (angle, place) = difference(&clip, &wanted);
            assert!(angle < 1.0 && place < 0.01, "{} {lead}: {angle} deg, {place} m", layout.writer);
            let said = report.notes.iter().any(|note| note.contains(&format!("frames 1 to {lead} are a rest pose")));
            assert!(said, "{:?}", report.notes);
        }
    }
}

#[test]
fn radians_are_told_from_degrees() {
    let (wanted, plain) = converted(&write(&base(), &axes(false, 0))).unwrap();
    let (clip, report) = converted(&write_with(&base(), &axes(false, 0), 0, PI / 180.0)).unwrap();
    let (angle, place) = difference(&clip, &wanted);
    assert!(angle < 1.0 && place < 0.01, "{angle} deg, {place} m");
    assert!(report.notes[0].contains("radians") && plain.notes.is_empty(), "{:?} {:?}", report.notes, plain.notes);
}

#[test]
fn arms_that_end_in_end_sites_move_and_joints_without_a_name_are_found() {
    let (wanted, _) = converted(&write(&base(), &axes(false, 0))).unwrap();
    let hands = Layout { names: base().names.map(|name| if name.ends_with("Hand") { "" } else { name }), ..base() };
    let text = without(&write(&hands, &axes(false, 0)), &["LeftHand", "RightHand"], &[16, 20]);
    let (clip, report) = converted(&text).unwrap();
    let column = |name: &str| clip.joint_names.iter().position(|joint| joint.contains(name)).unwrap();
    for joint in ["left_shoulder_pitch", "right_shoulder_pitch"] {
        let at = column(joint);
        let swing = |clip: &MotionClip| {
            let values = (0..clip.len()).map(|t| clip.joints_at(t)[at]);
            values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
        };
        assert!(swing(&clip) > 0.8 * swing(&wanted), "{joint}: {} of {}", swing(&clip), swing(&wanted));
    }
    assert!(report.notes.is_empty(), "{:?}", report.notes);

    let renamed = Layout {
        names: base().names.map(|name| if name.ends_with("LeftArm") { "mixamorig:Wing" } else { name }),
        ..base()
    };
    // A name that says nothing, between joints whose names do: found by its place.
    let (clip, report) = converted(&write(&renamed, &axes(false, 0))).unwrap();
    let (angle, place) = difference(&clip, &wanted);
    assert!(angle < 1.0 && place < 0.01 && report.unfollowed.is_empty(), "{angle} {place} {:?}", report.unfollowed);
}

/// Removes joints without children from a file's text: their end becomes the parent's, their channels go.
fn without(text: &str, names: &[&str], joints: &[usize]) -> String {
    let (tree, motion) = text.split_once("MOTION\n").unwrap();
    let mut lines: Vec<&str> = tree.lines().collect();
    for _ in names {
        let at = lines.iter().position(|line| line.trim() == "JOINT").unwrap();
        // JOINT { OFFSET CHANNELS End Site { OFFSET } } becomes End Site { OFFSET }.
        let offset = lines[at + 2];
        lines.splice(at..at + 9, ["End Site", "{", offset, "}"]);
    }
    let rows: Vec<String> = motion
        .lines()
        .map(|line| {
            let numbers: Vec<&str> = line.split(' ').collect();
            if numbers.len() < 60 {
                return line.to_owned();
            }
            let keep = |at: &usize| *at < 3 || !joints.contains(&((at - 3) / 3));
            (0..numbers.len()).filter(keep).map(|at| numbers[at]).collect::<Vec<_>>().join(" ")
        })
        .collect();
    format!("{}\nMOTION\n{}\n", lines.join("\n"), rows.join("\n"))
}

/// Changes a file's hierarchy, and each row of its motion.
fn changed(text: &str, tree: impl Fn(&str) -> String, row: impl Fn(usize, &[&str]) -> String) -> String {
    let (head, motion) = text.split_once("MOTION\n").unwrap();
    let (counts, rows) = motion.split_at(motion.match_indices('\n').nth(1).unwrap().0);
    let rows = rows.trim().lines().enumerate().map(|(t, line)| row(t, &line.split(' ').collect::<Vec<_>>()));
    format!("{}MOTION\n{counts}\n{}\n", tree(head), rows.collect::<Vec<_>>().join("\n"))
}

#[test]
fn a_root_above_the_body_and_targets_beside_it_change_nothing() {
    let unreal = layouts().into_iter().find(|layout| layout.writer == "Unreal").unwrap();
    let plain = write(&unreal, &axes(true, 0));
    let (wanted, plainly) = converted(&plain).unwrap();
    let joint = |name: &str, inside: &str| {
        format!("JOINT {name}\n{{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n{inside}}}\n")
    };
    let targets = |names: [&str; 3]| joint(names[0], &(joint(names[1], "") + &joint(names[2], "")));
    let rig = |body: &str| {
        let body = body.replace("HIERARCHY\n", "").replace("ROOT", "JOINT");
        let [feet, hands] = [["ik_foot_root", "ik_foot_l", "ik_foot_r"], ["ik_hand_root", "ik_hand_l", "ik_hand_r"]];
        let channels = "CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation";
        format!("HIERARCHY\nROOT root\n{{\nOFFSET 0 0 0\n{channels}\n{}{body}{}}}\n", targets(feet), targets(hands))
    };
    let zeros = |count: usize| vec!["0"; count].join(" ");
    let text = changed(&plain, rig, |_, row| format!("{} {} {}", zeros(6 + 9), row.join(" "), zeros(9)));
    let (clip, report) = converted(&text).unwrap();
    let (angle, place) = difference(&clip, &wanted);
    assert!(angle < 1e-6 && place < 1e-9, "{angle} {place}");
    assert_eq!(report.notes, plainly.notes);
}

#[test]
fn positions_of_all_joints_are_offsets_or_changes_of_them() {
    let plain = write(&base(), &axes(false, 0));
    let (wanted, _) = converted(&plain).unwrap();
    let offsets: Vec<Vec<String>> = plain
        .lines()
        .map(str::trim)
        .scan(String::new(), |before, line| Some((std::mem::replace(before, line.to_owned()), line)))
        .filter(|(before, line)| line.starts_with("CHANNELS") && before.starts_with("OFFSET"))
        .map(|(offset, _)| offset.split(' ').skip(1).map(str::to_owned).collect())
        .collect();
    let with_positions = |place: &dyn Fn(usize, usize) -> Vec<String>| {
        let tree = |head: &str| head.replace("CHANNELS 3", "CHANNELS 6 Xposition Yposition Zposition");
        let row = |t: usize, row: &[&str]| {
            let mut all: Vec<String> = row[..6].iter().map(|value| (*value).to_owned()).collect();
            for joint in 1..21 {
                all.extend(place(t, joint));
                all.extend(row[3 + 3 * joint..6 + 3 * joint].iter().map(|value| (*value).to_owned()));
            }
            all.join(" ")
        };
        converted(&changed(&plain, tree, row)).unwrap()
    };
    let (clip, report) = with_positions(&|_, joint| offsets[joint].clone());
    assert!(difference(&clip, &wanted).1 < 1e-9 && report.notes.is_empty(), "{:?}", report.notes);
    let (clip, report) = with_positions(&|_, _| vec!["0".to_owned(); 3]);
    assert!(difference(&clip, &wanted).1 < 1e-9);
    assert!(report.notes[0].contains("added to the offsets"), "{:?}", report.notes);
    // Bones that become longer: said, and left as they were at first.
    let (clip, report) = with_positions(&|t, joint| match (t, joint) {
        (9, 16) => vec!["40".to_owned(); 3],
        _ => offsets[joint].clone(),
    });
    assert!(difference(&clip, &wanted).1 < 1e-9);
    assert!(report.notes[0].contains("but 'mixamorig:LeftHand' moves by"), "{:?}", report.notes);
}

#[test]
fn what_cannot_be_is_refused_with_the_option_that_cures_it() {
    let refused = |text: &str, part: &str| {
        let message = converted(text).map(|_| ()).unwrap_err().to_string();
        assert!(message.contains(part), "'{part}': {message}");
    };
    // Left and right exchanged: a left-handed export.
    let leak = |name: String| -> &'static str { Box::leak(name.into_boxed_str()) };
    let exchanged = |name: &str| match name.contains("Left") {
        true => name.replace("Left", "Right"),
        false => name.replace("Right", "Left"),
    };
    let swapped = base().names.map(|name| leak(exchanged(name)));
    refused(&write(&Layout { names: swapped, ..base() }, &axes(false, 0)), "--roles");
    // Rotations stand along y, the root's height is along z.
    let text = write(&base(), &axes(false, 0));
    let (head, rows) = text.split_once("Frame Time").unwrap();
    let rows: Vec<String> = rows
        .lines()
        .enumerate()
        .map(|(at, line)| match line.splitn(4, ' ').collect::<Vec<_>>().as_slice() {
            [x, y, z, rest] if at > 0 => format!("{z} {x} {y} {rest}"),
            _ => line.to_owned(),
        })
        .collect();
    refused(&format!("{head}Frame Time{}\n", rows.join("\n")), "places and rotations are in different axes");
    // No legs by any means.
    refused(
        "HIERARCHY\nROOT tail\n{\nOFFSET 0 0 0\nCHANNELS 3 Xrotation Yrotation Zrotation\nEnd Site\n{\nOFFSET 0 150 0\n}\n}\nMOTION\nFrames: 9\nFrame Time: 0.04\n0 0 0\n1 0 0\n2 0 0\n3 0 0\n4 0 0\n5 0 0\n6 0 0\n7 0 0\n8 0 0\n",
        "--roles left_thigh=JOINT",
    );
}

#[test]
fn a_root_that_stays_is_named_where_soles_slide() {
    let row = |_: usize, row: &[&str]| format!("0 90 0 {}", row[3..].join(" "));
    let still = changed(&write(&base(), &axes(false, 0)), str::to_owned, row);
    let (character, anatomy) = robot();
    let source = read(&still, &ReadOptions::default()).unwrap();
    let strict = Bounds { skate: 1e-6, ..Bounds::default() };
    let options = RetargetOptions { bounds: strict, ..RetargetOptions::default() };
    let message = retarget(&source, &character, &anatomy, &options).unwrap_err().to_string();
    assert!(message.contains("The root stays at its place: a treadmill, or a capture without"), "{message}");
}

#[test]
fn stated_axes_and_roles_override_what_is_found() {
    let (character, anatomy) = robot();
    let convert = |text: &str, options: &ReadOptions| {
        let retargeting =
            RetargetOptions { correspondence: options.correspondence.clone(), ..RetargetOptions::default() };
        retarget(&read(text, options)?, &character, &anatomy, &retargeting)
    };
    let text = write(&base(), &axes(false, 0));
    let (wanted, _) = convert(&text, &ReadOptions::default()).unwrap();
    let axis = |name: &str| Some(name.parse::<Axis>().unwrap());
    let (clip, _) =
        convert(&text, &ReadOptions { up: axis("y"), forward: axis("z"), ..ReadOptions::default() }).unwrap();
    assert!(difference(&clip, &wanted).0 < 1e-9);
    // On its head: beyond the bounds of a conversion, or of what a person does.
    convert(&text, &ReadOptions { up: axis("-y"), ..ReadOptions::default() }).unwrap_err();
    // Names that say nothing and a spine like a third leg: only the user knows.
    let odd = Layout { names: base().names.map(|name| if name.ends_with("LeftLeg") { "odd" } else { name }), ..base() };
    let text = write(&odd, &axes(false, 0));
    let roles: Correspondence = "left_shank=odd".parse().unwrap();
    let (clip, _) = convert(&text, &ReadOptions { correspondence: roles, ..ReadOptions::default() }).unwrap();
    assert!(difference(&clip, &wanted).0 < 1e-9);
    let unknown: Correspondence = "left_shank=none".parse().unwrap();
    let message = convert(&text, &ReadOptions { correspondence: unknown, ..ReadOptions::default() }).unwrap_err();
    assert!(message.to_string().contains("'none'"), "{message}");
}
