//! Promises of retargeting, on the project's own keyframed clips and, where the shared data is, on real captures.
use std::io::Read;
use std::path::{Path, PathBuf};

use lifelike_character::rotation::{heading_angle, to_wxyz};
use lifelike_character::{Anatomy, Character, Kinematics, Quat, Role, Vec3};
use lifelike_motion::formats::{ReadOptions, bvh, deepmimic};
use lifelike_motion::retarget::{Bounds, Correspondence, RetargetOptions, RetargetReport, retarget};
use lifelike_motion::{MotionClip, MotionError, SourceClip, feasibility, keyframes};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn robot(name: &str) -> (Character, Anatomy) {
    let character = Character::load(root().join(format!("robots/{name}.xml"))).unwrap();
    let anatomy = Anatomy::guess(&character, &Default::default()).unwrap();
    (character, anatomy)
}

fn own(name: &str) -> SourceClip {
    let (_, text) = keyframes::builtin().find(|(n, _)| *n == name).unwrap();
    keyframes::parse(text.as_bytes(), Path::new(name)).unwrap()
}

fn convert(clip: &SourceClip, name: &str, options: &RetargetOptions) -> (MotionClip, RetargetReport) {
    let (character, anatomy) = robot(name);
    retarget(clip, &character, &anatomy, options).unwrap()
}

/// Measured here, apart from the report: speeds of sole points of labelled feet, the lowest corner, the joints' excess.
struct Check {
    skate: f64,
    lowest: f64,
    excess: f64,
    fastest: f64,
}

fn check(clip: &MotionClip, character: &Character, anatomy: &Anatomy) -> Check {
    let columns = clip.columns_for(character).unwrap();
    let contacts = clip.contacts.as_ref().unwrap();
    let mut kinematics = Kinematics::new(character);
    let mut q = character.reference_position();
    let mut result = Check { skate: 0.0, lowest: f64::INFINITY, excess: f64::NEG_INFINITY, fastest: 0.0 };
    let (mut speeds, mut before) = (Vec::new(), Vec::<Vec3>::new());
    for t in 0..clip.len() {
        clip.write_position(character, &columns, t, &mut q);
        for joint in character.scalar_joints() {
            let (low, high) = joint.range.unwrap();
            result.excess = result.excess.max(low - q[joint.q_index]).max(q[joint.q_index] - high);
        }
        kinematics.update(character, &q);
        let mut soles = Vec::new();
        for (side, role) in [Role::LeftFoot, Role::RightFoot].iter().enumerate() {
            let sole = &anatomy.soles[role];
            assert_eq!(character.bodies[sole.body].name, contacts.names[side]);
            let corners = sole.corners.iter().map(|c| kinematics.point(sole.body, c));
            // The lowest corner is what a standing foot stands on, flat or not.
            let stand = corners.min_by(|a, b| a.z.total_cmp(&b.z)).unwrap();
            result.lowest = result.lowest.min(stand.z);
            soles.extend(sole.corners.iter().map(|c| kinematics.point(sole.body, c)));
        }
        let half = soles.len() / 2;
        for (i, (now, old)) in soles.iter().zip(&before).enumerate() {
            let side = i / half;
            if contacts.flags[2 * t + side] && contacts.flags[2 * (t - 1) + side] && now.z.max(old.z) < 0.005 {
                speeds.push((now - old).xy().norm() * clip.fps);
            }
        }
        if t > 0 {
            let rows = clip.joints_at(t).iter().zip(clip.joints_at(t - 1));
            result.fastest = rows.fold(result.fastest, |f, (a, b)| f.max((a - b).abs() * clip.fps));
        }
        before = soles;
    }
    result.skate = speeds.iter().sum::<f64>() / speeds.len().max(1) as f64;
    result
}

/// Clips in which `humanoid`'s hands meet inside of each other: they are keyed for `lima`, whose hands are thinner. The
/// retargeter does not keep hands apart.
const HANDS_MEET: [&str; 13] = [
    "baseball_swing",
    "block",
    "bowl",
    "breaststroke",
    "catch",
    "climb_arms",
    "cover_face",
    "hands_behind_back",
    "hug",
    "namaste",
    "hands_on_head",
    "pray",
    "shoot_basketball",
];
/// Diameter of `humanoid`'s hands (m).
const HAND: f64 = 0.09;

#[test]
fn own_clips_stand_on_the_ground_within_all_limits() {
    for name in ["lima", "humanoid"] {
        let (character, anatomy) = robot(name);
        let options = RetargetOptions { default_velocity_limit: 6.0, ..RetargetOptions::default() };
        for (title, text) in keyframes::builtin() {
            let source = keyframes::parse(text.as_bytes(), Path::new(title)).unwrap();
            // Who leaves the ground needs legs that are faster.
            let flies = text.contains("\ngravity = ");
            let fastest = if flies { 16.0 } else { 6.0 };
            let options = RetargetOptions { default_velocity_limit: fastest, ..options.clone() };
            let (clip, report) = retarget(&source, &character, &anatomy, &options).unwrap();
            let found = check(&clip, &character, &anatomy);
            assert!(found.excess <= 0.0, "{name} {title}: {} rad out of range", found.excess);
            assert!(found.fastest <= fastest + 1e-6, "{name} {title}: {} rad/s", found.fastest);
            assert!(found.lowest > -0.01, "{name} {title}: sole at {} m", found.lowest);
            assert!(found.skate < 0.03, "{name} {title}: skate {} m/s", found.skate);
            assert!((found.skate - report.foot_skate.mean).abs() < 1e-9, "{name} {title}: the report says otherwise");
            assert!(report.ground_penetration.max < 0.01 && report.ground_float.max < 0.02, "{name} {title}");
            let least = if flies { 0.6 } else { 0.99 };
            assert!(report.contact_share > least, "{name} {title}: {}", report.contact_share);
            let most = if name == "humanoid" && HANDS_MEET.contains(&title) { HAND } else { 0.01 };
            assert!(report.self_penetration.max < most, "{name} {title}: {}", report.self_penetration.max);
            let signs = clip.root_orientation.windows(2).all(|w| w[0].coords.dot(&w[1].coords) > 0.0);
            assert!(signs, "{name} {title}: the root's quaternion flips its sign");
        }
    }
}

#[test]
fn a_walk_goes_where_the_human_goes_at_the_robots_size() {
    let source = own("walk");
    let (clip, report) = convert(&source, "lima", &RetargetOptions::default());
    let path = |p: &[Vec3]| (p[p.len() - 1] - p[0]).xy().norm();
    let expected = path(&source.root_position) * report.scale;
    assert!((path(&clip.root_position) - expected).abs() < 0.05 * expected, "{} {expected}", path(&clip.root_position));
    assert!((report.scale - 0.44 / 0.9).abs() < 0.05, "{}", report.scale);
    let contacts = clip.contacts.unwrap();
    for side in 0..2 {
        let flags: Vec<bool> = contacts.flags.iter().skip(side).step_by(2).copied().collect();
        let lifts = flags.windows(2).filter(|w| w[0] && !w[1]).count();
        assert!(lifts >= 2, "foot {side} lifts {lifts} times");
    }
}

/// The hands' and elbows' heights against the shoulders, left and right.
fn raised(clip: &MotionClip, character: &Character, anatomy: &Anatomy, frame: usize) -> [f64; 2] {
    let mut kinematics = Kinematics::new(character);
    let mut q = character.reference_position();
    clip.write_position(character, &clip.columns_for(character).unwrap(), frame, &mut q);
    kinematics.update(character, &q);
    let z = |role| kinematics.point(anatomy.places[&role].body, &anatomy.places[&role].point).z;
    [z(Role::LeftHand) - z(Role::LeftUpperArm), z(Role::RightHand) - z(Role::RightUpperArm)]
}

#[test]
fn left_is_left_and_arms_go_where_the_humans_go() {
    let source = own("idle_breathing");
    let joint = |name: &str| source.skeleton.names.iter().position(|n| n == name).unwrap();
    let (shoulder, elbow) = (joint("left_shoulder"), joint("left_elbow"));
    let up = Vec3::new(0.0, 0.5, 0.9);
    let mut raised_arm = source.clone();
    for rotations in &mut raised_arm.rotations {
        rotations[shoulder] = Quat::rotation_between(&source.skeleton.offsets[elbow], &up).unwrap();
        rotations[elbow] = Quat::identity();
    }
    for name in ["lima", "humanoid"] {
        let (character, anatomy) = robot(name);
        let (clip, report) = retarget(&raised_arm, &character, &anatomy, &RetargetOptions::default()).unwrap();
        let [left, right] = raised(&clip, &character, &anatomy, clip.len() / 2);
        assert!(left > 0.1 && right < -0.1, "{name}: left hand {left}, right hand {right}");
        // Both arms' directions are within reach of both robots: the error is a few millimetres.
        for role in [Role::LeftForearm, Role::LeftHand, Role::RightHand] {
            assert!(report.position_error[&role].max < 0.03, "{name} {role:?}: {:?}", report.position_error[&role]);
        }
    }
}

/// As many robots are built: the twist of the upper arm is the elbow's first joint, and what bends is its second, in the same place.
#[test]
fn an_elbow_may_begin_with_the_twist_of_the_upper_arm() {
    let mut text = std::fs::read_to_string(root().join("robots/lima.xml")).unwrap();
    for side in ["left", "right"] {
        let twist = format!("<joint name=\"{side}_shoulder_yaw\" class=\"upper\" axis=\"0 0 1\" range=\"-1.8 1.8\"/>");
        assert!(text.contains(&twist));
        text = text.replace(&twist, "");
        text = text.replace(
            &format!("<motor name=\"{side}_shoulder_yaw\" joint=\"{side}_shoulder_yaw\" class=\"upper\"/>"),
            "",
        );
        let elbow = format!(
            "<body name=\"{side}_elbow_roll_link\" pos=\"0 0 -0.135\">{}<inertial pos=\"0 0 0\" mass=\"0.01\" diaginertia=\"1e-5 1e-5 1e-5\"/>",
            twist.replace("shoulder_yaw", "elbow_roll")
        );
        let hand = format!("<site name=\"{side}_hand\" pos=\"0 0 -0.13\"/>");
        text = text.replace(
            &format!("<body name=\"{side}_forearm\" pos=\"0 0 -0.135\">"),
            &format!("{elbow}<body name=\"{side}_forearm\">"),
        );
        text = text.replace(&hand, &format!("{hand}</body>"));
    }
    let twisted = Character::from_mjcf(&text, "lima.xml", None).unwrap();
    let anatomy = Anatomy::guess(&twisted, &Default::default()).unwrap();
    for name in ["wave", "walk"] {
        let (_, ours) = convert(&own(name), "lima", &RetargetOptions::default());
        let (clip, theirs) = retarget(&own(name), &twisted, &anatomy, &RetargetOptions::default()).unwrap();
        for role in [Role::LeftForearm, Role::RightForearm, Role::LeftHand, Role::RightHand] {
            let (a, b) = (ours.position_error[&role].mean, theirs.position_error[&role].mean);
            assert!((a - b).abs() < 0.005, "{name} {role:?}: {a} and {b} m");
        }
        assert_eq!(clip.joint_names.iter().filter(|joint| joint.contains("elbow_roll")).count(), 2);
    }
}

#[test]
fn the_same_motion_turned_and_moved_gives_the_same_joints() {
    let source = own("walk");
    let mut turned = source.clone();
    let turn = Quat::from_axis_angle(&Vec3::z_axis(), 2.0);
    for (p, r) in turned.root_position.iter_mut().zip(&mut turned.rotations) {
        *p = turn * *p + Vec3::new(3.0, -1.0, 0.0);
        r[0] = turn * r[0];
    }
    let (a, _) = convert(&source, "lima", &RetargetOptions::default());
    let (b, _) = convert(&turned, "lima", &RetargetOptions::default());
    // Weights per world axis and the solver's stopping rule leave small traces.
    let worst = a.joints.iter().zip(&b.joints).fold(0.0_f64, |m, (x, y)| m.max((x - y).abs()));
    assert!(worst < 0.02, "{worst} rad");
    let heading = heading_angle(&(turn.inverse() * b.root_orientation[40])) - heading_angle(&a.root_orientation[40]);
    assert!(heading.abs() < 0.01, "{heading}");
}

/// Distance of the centre of mass, seen from above, beside the sole of each foot (m), in the middle of the clip.
fn beside_the_soles(clip: &MotionClip, character: &Character, anatomy: &Anatomy) -> [f64; 2] {
    let columns = clip.columns_for(character).unwrap();
    let mut kinematics = Kinematics::new(character);
    let mut q = character.reference_position();
    clip.write_position(character, &columns, clip.len() / 2, &mut q);
    kinematics.update(character, &q);
    let bodies = character.bodies.iter().enumerate();
    let centre: Vec3 = bodies.map(|(i, b)| b.inertial.mass * kinematics.point(i, &b.inertial.com)).sum();
    let centre = centre / character.mass();
    [Role::LeftFoot, Role::RightFoot].map(|role| {
        let sole = &anatomy.soles[&role];
        let corners: Vec<Vec3> = sole.corners.iter().map(|c| kinematics.point(sole.body, c)).collect();
        feasibility::outside(&corners, &centre).unwrap()
    })
}

#[test]
fn who_stands_on_one_foot_is_above_it_and_who_walks_is_as_before() {
    let (character, anatomy) = robot("lima");
    let leans = RetargetOptions::default();
    let as_before = RetargetOptions { balance: false, ..RetargetOptions::default() };
    for name in ["balance_on_one_leg", "tree_pose"] {
        let [left, right] = beside_the_soles(&convert(&own(name), "lima", &leans).0, &character, &anatomy);
        assert!(left < 1e-3 && right > 0.05, "{name}: {left} {right}");
        let [left, _] = beside_the_soles(&convert(&own(name), "lima", &as_before).0, &character, &anatomy);
        assert!(left > 0.02, "{name}: {left} without");
    }
    // A robot without masses has no balance.
    let mut weightless = character.clone();
    weightless.bodies.iter_mut().for_each(|body| body.inertial.mass = 0.0);
    let clip = retarget(&own("tree_pose"), &weightless, &anatomy, &leans).unwrap().0;
    assert_eq!(clip.joints, convert(&own("tree_pose"), "lima", &as_before).0.joints);
    let walks = [leans, as_before].map(|options| convert(&own("walk"), "lima", &options).0);
    assert_eq!(walks[0].joints, walks[1].joints);
}

#[test]
fn a_cycle_closes() {
    let source = own("sway_dance");
    assert!(source.cyclic);
    let (clip, _) = convert(&source, "humanoid", &RetargetOptions::default());
    let last = clip.len() - 1;
    let gap = clip.joints_at(0).iter().zip(clip.joints_at(last)).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
    assert!(clip.cyclic && gap < 0.02, "{gap} rad between the ends");
}

#[test]
fn tempo_is_how_fast_the_motion_is_performed() {
    use lifelike_motion::retarget::{Tempo, TempoRule};
    let source = own("walk");
    let at = |tempo| convert(&source, "lima", &RetargetOptions { tempo, ..RetargetOptions::default() });
    let (plain, report) = at(Tempo::Times(1.0));
    assert_eq!(report.tempo, 1.0);
    let (twice, report) = at(Tempo::Times(2.0));
    assert_eq!((report.tempo, twice.fps), (2.0, plain.fps));
    let halves = plain.len() as f64 / twice.len() as f64;
    assert!((halves - 2.0).abs() < 0.05, "{} frames become {}", plain.len(), twice.len());
    // The same way in half the time.
    let way = |clip: &MotionClip| (clip.root_position[clip.len() - 1] - clip.root_position[0]).norm();
    assert!((way(&twice) / way(&plain) - 1.0).abs() < 0.05, "{} {}", way(&plain), way(&twice));
    // Froude: a leg of 0.35 m swings faster than a grown-up's, by the root of how much shorter it is.
    let (_, report) = at(Tempo::Rule(TempoRule::Froude));
    assert!((1.3..1.8).contains(&report.tempo), "{}", report.tempo);
}

#[test]
fn the_result_depends_on_nothing_but_the_input() {
    let source = own("wave");
    let (a, _) = convert(&source, "lima", &RetargetOptions::default());
    let (b, _) = convert(&source, "lima", &RetargetOptions::default());
    assert_eq!(a, b);
}

#[test]
fn what_cannot_be_converted_is_refused_with_the_reason() {
    let (character, anatomy) = robot("lima");
    let refuse = |clip: &SourceClip, options: &RetargetOptions| {
        retarget(clip, &character, &anatomy, options).unwrap_err().to_string()
    };
    let options = RetargetOptions::default();
    let good = own("wave");

    let mut short = good.clone();
    short.root_position.truncate(2);
    short.rotations.truncate(2);
    assert!(refuse(&short, &options).contains("too short: 2 frames"));

    let mut broken = good.clone();
    broken.root_position[7].x = f64::NAN;
    assert!(refuse(&broken, &options).contains("frame 7"));

    // Feet whose names say nothing are found by their place.
    let mut unnamed = good.clone();
    for name in &mut unnamed.skeleton.names {
        *name = name.to_lowercase().replace("foot", "thing").replace("ankle", "thing");
    }
    let wanted = retarget(&good, &character, &anatomy, &options).unwrap().0;
    assert_eq!(retarget(&unnamed, &character, &anatomy, &options).unwrap().0.joints, wanted.joints);

    // Lifted by 1 m in its middle: it hangs from something.
    let mut hanging = good.clone();
    let (a, b) = (hanging.len() / 3, 2 * hanging.len() / 3);
    hanging.root_position[a..b].iter_mut().for_each(|p| p.z += 1.0);
    let text = refuse(&hanging, &options);
    assert!(text.contains("neither touches flat ground nor falls"), "{text}");
    let anyway = RetargetOptions { allow_off_ground: true, ..options.clone() };
    assert!(retarget(&hanging, &character, &anatomy, &anyway).is_ok());

    let correspondence = Correspondence { left_toe: Some("nobody".into()), ..Correspondence::default() };
    assert!(refuse(&good, &RetargetOptions { correspondence, ..options.clone() }).contains("'nobody'"));
    assert!(refuse(&good, &RetargetOptions { fps: f64::NAN, ..options.clone() }).contains("fps is NaN"));

    let text = "<mujoco><worldbody><body name='b'><joint name='j'/><geom size='1'/></body></worldbody></mujoco>";
    let fixed = Character::from_mjcf(text, "fixed.xml", None);
    let error = retarget(&good, &fixed.unwrap(), &anatomy, &options).unwrap_err();
    assert!(matches!(&error, MotionError::Mismatch { message, .. } if message.contains("no free joint")), "{error}");
}

#[test]
fn options_beyond_what_can_be_are_refused_by_name() {
    let walk = own("walk");
    let (character, anatomy) = robot("lima");
    let refused = |options: RetargetOptions, part: &str| {
        let error = retarget(&walk, &character, &anatomy, &options).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    };
    let options = RetargetOptions::default;
    refused(RetargetOptions { smoothing: f64::NAN, ..options() }, "smoothing is NaN; it must be from 0 to 1");
    refused(RetargetOptions { smoothing: -1.0, ..options() }, "smoothing is -1; it must be from 0 to 1");
    refused(RetargetOptions { heel_rise: 2.0, ..options() }, "heel_rise is 2; it must be from 0 to 1");
    let bounds = Bounds { position: f64::NAN, ..Bounds::default() };
    refused(RetargetOptions { bounds, ..options() }, "bounds.position is NaN; it must be from 0 to inf");
}

#[test]
fn options_are_text_and_unknown_keys_are_refused() {
    let options: RetargetOptions = toml::from_str("fps = 60.0\n[velocity_limit]\nleft_knee = 5.0").unwrap();
    assert_eq!((options.fps, options.velocity_limit["left_knee"]), (60.0, 5.0));
    assert!(toml::from_str::<RetargetOptions>("fsp = 60.0").is_err());
}

/// Files of an archive of the shared data with these names, in the archive's order.
fn archived(archive: &str, names: &[&str]) -> Vec<(String, Vec<u8>)> {
    let data = std::env::var_os("LIFELIKE_DATA").map_or_else(|| root().join("../shared/data"), PathBuf::from);
    let path = data.join("mocap").join(format!("{archive}.tar.zst"));
    let file = std::fs::File::open(&path).unwrap_or_else(|e| {
        panic!("{}: {e}; let LIFELIKE_DATA name the data folder (CONTRIBUTING.md)", path.display())
    });
    let mut decoder = zstd::stream::read::Decoder::new(file).unwrap();
    decoder.window_log_max(27).unwrap();
    let mut found = Vec::new();
    for entry in tar::Archive::new(decoder).entries().unwrap() {
        let mut entry = entry.unwrap();
        let name = entry.path().unwrap().file_name().unwrap().to_string_lossy().into_owned();
        if names.contains(&name.as_str()) {
            let mut bytes = Vec::new();
            entry.read_to_end(&mut bytes).unwrap();
            found.push((name, bytes));
        }
    }
    found
}

#[test]
#[ignore = "needs motion capture that may not be redistributed: LIFELIKE_DATA"]
fn real_walks_punches_and_gestures_stand_firm() {
    let mut clips = Vec::new();
    for (name, bytes) in archived("cmu_bvh_daz", &["02_01.bvh", "02_05.bvh", "13_26.bvh"]) {
        clips.push(bvh::parse(&bytes, Path::new(&name), &ReadOptions::default()).unwrap());
    }
    let moves = ["humanoid3d.txt", "humanoid3d_walk.txt", "humanoid3d_jump.txt", "humanoid3d_run.txt"];
    let files = archived("deepmimic", &moves);
    let (_, body) = files.iter().find(|(n, _)| n == moves[0]).unwrap();
    let body = deepmimic::parse_character(body, Path::new(moves[0])).unwrap();
    for (name, bytes) in files.iter().filter(|(n, _)| n != moves[0]) {
        clips.push(deepmimic::parse(bytes, Path::new(name), &body, &ReadOptions::default()).unwrap());
    }
    for name in ["lima", "humanoid"] {
        let (character, anatomy) = robot(name);
        for source in &clips {
            let (clip, report) = retarget(source, &character, &anatomy, &RetargetOptions::default()).unwrap();
            let found = check(&clip, &character, &anatomy);
            let title = format!("{name} {}", source.name);
            assert!(found.excess <= 0.0 && found.lowest > -0.01, "{title}: {} {}", found.excess, found.lowest);
            assert!(found.skate < 0.06, "{title}: skate {} m/s", found.skate);
            // Jumps and runs leave the ground, walks and gestures never do.
            let flies = source.name.contains("jump") || source.name.contains("run");
            assert_eq!(report.contact_share < 0.9, flies, "{title}: contact {}", report.contact_share);
            let sum: f64 = to_wxyz(&clip.root_orientation[0]).iter().map(|c| c * c).sum();
            assert!((sum - 1.0).abs() < 1e-9);
        }
    }
}
