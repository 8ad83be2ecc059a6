//! Every clip of our own, checked for what a careful robot needs; and what is wrong is said with its line.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use lifelike_character::Vec3;
use proptest::prelude::*;

use super::figure::{ANKLE, ARMS, HEEL, LEGS, TOE};
use super::flight::{self, Flight};
use super::*;

const SOLE_HALF_WIDTH: f64 = 0.045;

fn clips() -> Vec<SourceClip> {
    builtin().map(|(name, text)| parse(text.as_bytes(), format!("{name}.keys.toml").as_ref()).unwrap()).collect()
}

/// Returns whether a foot (0 left, 1 right) stands: its ankle is at standing height now and in the frames beside.
fn stands(clip: &SourceClip, frame: usize, foot: usize) -> bool {
    let ankle = |f: usize| clip.pose(f.min(clip.len() - 1)).0[LEGS[foot][2]];
    [frame.saturating_sub(1), frame, frame + 1].into_iter().all(|f| ankle(f).z < ANKLE + 1e-9)
}

fn sole(clip: &SourceClip, frame: usize, foot: usize) -> Vec<Vec3> {
    let (places, turns) = clip.pose(frame);
    let joint = LEGS[foot][2];
    let corners = [(HEEL, -1.0), (HEEL, 1.0), (TOE, -1.0), (TOE, 1.0)];
    corners.map(|(x, side)| places[joint] + turns[joint] * Vec3::new(x, side * SOLE_HALF_WIDTH, -ANKLE)).to_vec()
}

/// Returns the depth of a point inside the convex hull of some points on the ground (m); negative outside. Its edges
/// are the pairs that have all points on their left.
fn depth_inside(points: &[Vec3], p: [f64; 2]) -> f64 {
    let mut depth = f64::INFINITY;
    for a in points {
        for b in points {
            let edge = (b - a).xy();
            if edge.norm() < 1e-9 {
                continue;
            }
            let left = |q: [f64; 2]| (edge.x * (q[1] - a.y) - edge.y * (q[0] - a.x)) / edge.norm();
            if points.iter().all(|q| left([q.x, q.y]) > -1e-9) {
                depth = depth.min(left(p));
            }
        }
    }
    depth
}

fn centre(clip: &SourceClip, frame: usize) -> Vec3 {
    let (places, turns) = clip.pose(frame);
    figure::centre_of_mass(&places, &turns)
}

fn script(name: &str) -> text::Script {
    let (_, content) = builtin().find(|(known, _)| *known == name).unwrap();
    text::Script::parse(content, name.as_ref()).unwrap()
}

fn flights(name: &str) -> Vec<Flight> {
    flight::flights(&script(name).steps)
}

#[test]
fn every_text_in_the_folder_is_built_in() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("motions");
    let mut there: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .filter_map(|e| e.unwrap().file_name().to_str()?.strip_suffix(".keys.toml").map(str::to_owned))
        .collect();
    there.sort();
    assert_eq!(there, builtin().map(|(name, _)| name.to_owned()).collect::<Vec<_>>());
    assert!(there.len() >= 12);
}

#[test]
fn the_pressure_under_the_feet_stays_on_the_soles() {
    let mut bad = Vec::new();
    for clip in clips() {
        let (mut least, air) = ((f64::INFINITY, 0.0), flights(&clip.name));
        let gravity = if air.is_empty() { balance::GRAVITY } else { script(&clip.name).gravity };
        for frame in 1..clip.len() - 1 {
            let near = |f: &Flight| (f.start - 0.04..f.end + 0.04).contains(&(frame as f64 / clip.fps));
            if air.iter().any(near) {
                continue;
            }
            let [a, c, b] = [frame - 1, frame, frame + 1].map(|f| centre(&clip, f));
            let acceleration = (a - 2.0 * c + b) * (clip.fps * clip.fps);
            let lever = c.z / (gravity + acceleration.z);
            let pressure = [c.x - lever * acceleration.x, c.y - lever * acceleration.y];
            // Of a foot that is tilted, toes or heel.
            let support: Vec<Vec3> = (0..2)
                .flat_map(|foot| {
                    let near = [frame - 1, frame, frame + 1].map(|f| sole(&clip, f, foot));
                    (0..4).filter(|at| near.iter().all(|s| s[*at].z < 1e-9)).map(|at| near[1][at]).collect::<Vec<_>>()
                })
                .collect();
            assert!(!support.is_empty(), "{} flies at frame {frame}", clip.name);
            let depth = depth_inside(&support, pressure);
            if depth < least.0 {
                least = (depth, frame as f64 / clip.fps);
            }
        }
        // Who hops balances on the edge of a foot for a moment.
        if least.0 <= if air.is_empty() { 0.015 } else { 0.0 } {
            bad.push(format!("{}: {:.4} m at {:.2} s", clip.name, least.0, least.1));
        }
    }
    assert!(bad.is_empty(), "{bad:#?}");
}

#[test]
fn a_standing_foot_does_not_move_and_none_is_under_the_ground() {
    for clip in clips() {
        for frame in 1..clip.len() {
            for foot in 0..2 {
                let (now, before) = (sole(&clip, frame, foot), sole(&clip, frame - 1, foot));
                assert!(now.iter().all(|corner| corner.z > -1e-6), "{} frame {frame}", clip.name);
                if stands(&clip, frame, foot) && stands(&clip, frame - 1, foot) {
                    let moved = now.iter().zip(&before).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
                    assert!(moved < 1e-9, "{} slips by {moved} m at frame {frame}", clip.name);
                }
            }
        }
    }
}

#[test]
fn the_centre_of_mass_flies_on_a_parabola() {
    let mut seen = 0;
    for clip in clips() {
        let gravity = script(&clip.name).gravity;
        for air in flights(&clip.name) {
            seen += 1;
            let speed = 0.5 * gravity * (air.end - air.start);
            let inside: Vec<usize> =
                (0..clip.len()).filter(|f| (air.start..=air.end).contains(&(*f as f64 / clip.fps))).collect();
            let since = |f: usize| f as f64 / clip.fps - air.start;
            let fallen = |f: usize| centre(&clip, f).z - speed * since(f) + 0.5 * gravity * since(f).powi(2);
            for f in &inside {
                let off = fallen(*f) - fallen(inside[0]);
                // The text may lift or lower the body a little meanwhile.
                assert!(off.abs() < 0.01, "{} at frame {f}: {off} m off the parabola", clip.name);
            }
        }
    }
    assert!(seen >= 1);
}

#[test]
fn a_jump_rises_as_high_as_its_text_says_and_lands_where_it_says() {
    let text = "seconds = 3.0\ngravity = 9.81\n[[pose]]\ntime = 1.0\npelvis = { z = -0.06 }\n[[pose]]\ntime = 2.0\n\
                pelvis = { z = -0.06 }\n[[jump]]\nstart = 1.5\nheight = 0.06\nby = [0.2, 0.0]";
    let clip = parse(text.as_bytes(), "x.keys.toml".as_ref()).unwrap();
    let heights: Vec<f64> = (0..clip.len()).map(|f| centre(&clip, f).z).collect();
    let highest = heights.iter().copied().fold(0.0, f64::max);
    assert!((highest - heights[0]).abs() < 1e-3, "6 cm down, 6 cm up: {}", highest - heights[0]);
    let way = clip.root_position[clip.len() - 1] - clip.root_position[0];
    assert!((way - 0.2 * Vec3::x()).norm() < 1e-3, "{way}");
    // In the air nothing pushes: the way along the ground is straight.
    let (a, b, c) = (centre(&clip, 92), centre(&clip, 97), centre(&clip, 102));
    assert!((a.x - 2.0 * b.x + c.x).abs() < 1e-3, "{a} {b} {c}");
}

#[test]
fn joints_are_slower_than_a_small_robots_motors() {
    let mut bad = Vec::new();
    for clip in clips() {
        let mut fastest = (0.0_f64, 0, 0.0);
        for frame in 1..clip.len() {
            for joint in 1..clip.skeleton.names.len() {
                let speed = clip.rotations[frame][joint].angle_to(&clip.rotations[frame - 1][joint]) * clip.fps;
                if speed > fastest.0 {
                    fastest = (speed, joint, frame as f64 / clip.fps);
                }
            }
        }
        let name = &clip.skeleton.names[fastest.1];
        // Who jumps stretches the legs fast.
        let most = if flights(&clip.name).is_empty() { 6.0 } else { 16.0 };
        if fastest.0 >= most {
            bad.push(format!("{}: {name} {:.2} rad/s at {:.2} s", clip.name, fastest.0, fastest.2));
        }
    }
    assert!(bad.is_empty(), "{bad:#?}");
}

#[test]
fn clips_follow_on_each_other_and_cycles_close() {
    let all = clips();
    let stand = &all.iter().find(|c| c.name == "nod").unwrap().rotations[0];
    for clip in &all {
        let (first, last) = (&clip.rotations[0], &clip.rotations[clip.len() - 1]);
        let near = |a: &[lifelike_character::Quat], b: &[lifelike_character::Quat]| {
            a.iter().zip(b).skip(1).map(|(a, b)| a.angle_to(b)).fold(0.0, f64::max)
        };
        if clip.cyclic {
            assert!(near(first, last) < 1e-6, "{}", clip.name);
            let into = near(last, &clip.rotations[clip.len() - 2]);
            let out = near(first, &clip.rotations[1]);
            assert!((into - out).abs() < 2e-3, "{}: {into} then {out}", clip.name);
        } else {
            assert!(near(first, stand) < 1e-3, "{} does not start standing", clip.name);
            assert!(near(last, stand) < 2e-3, "{} does not end standing: {}", clip.name, near(last, stand));
        }
    }
}

#[test]
fn knees_and_elbows_never_bend_backwards() {
    for clip in clips() {
        for frame in 0..clip.len() {
            for side in 0..2 {
                let knee = clip.rotations[frame][LEGS[side][1]].scaled_axis();
                assert!(knee.y > 0.05, "{} frame {frame}: knee {knee}", clip.name);
                let elbow = clip.rotations[frame][ARMS[side][1]].scaled_axis().z * if side == 0 { -1.0 } else { 1.0 };
                assert!((0.0..2.3).contains(&elbow), "{} frame {frame}: elbow {elbow}", clip.name);
            }
        }
    }
}

#[test]
fn the_walk_goes_where_its_steps_say() {
    let walk = clips().into_iter().find(|c| c.name == "walk").unwrap();
    let way = walk.root_position[walk.len() - 1] - walk.root_position[0];
    assert!((way.x - 3.0).abs() < 1e-3 && way.y.abs() < 1e-3, "ten steps of 0.3 m: {way}");
    assert_eq!(walk.captions[0].text, "a person walks forward at a calm pace");
}

#[test]
fn angles_mean_what_the_text_says() {
    let text = "seconds = 1.0\n[[pose]]\ntime = 0.0\nleft_arm = { raise = 90, aside = 0, elbow = 0 }\n\
                right_arm = { raise = 0, aside = 90, elbow = 90, turn = -90 }\nchest = { yaw = 90 }";
    let clip = parse(text.as_bytes(), "x.keys.toml".as_ref()).unwrap();
    let (places, _) = clip.pose(0);
    // The chest has turned left, so what was forward points left, and what was right points forward.
    let along = |from: usize, to: usize| (places[to] - places[from]).normalize();
    assert!((along(ARMS[0][0], ARMS[0][2]) - Vec3::y()).norm() < 1e-9, "raised forward");
    assert!((along(ARMS[1][0], ARMS[1][1]) - Vec3::x()).norm() < 1e-9, "lifted aside");
    assert!((along(ARMS[1][1], ARMS[1][2]) - Vec3::z()).norm() < 1e-9, "turned outward, the elbow bends upward");
}

#[test]
fn what_is_wrong_is_said_with_its_line() {
    let wrong = |text: &str| parse(text.as_bytes(), "x.keys.toml".as_ref()).unwrap_err().to_string();
    let head = "seconds = 3.0\n";
    for (text, line, part) in [
        ("seconds = nan", 1, "a length in seconds"),
        ("seconds = 1e300", 1, "0.1 to 600"),
        ("seconds = 3.0\nfps = inf", 2, "frames per second"),
        ("seconds = 3.0\nspeed = 2", 2, "unknown field"),
        ("seconds = 3.0\n[[pose]]\ntime = 1\nhead = { pich = 3 }", 4, "unknown field"),
        ("seconds = 3.0\n[[pose]]\ntime = 1\n[[pose]]\ntime = 0.5", 5, "a time after 1"),
        ("seconds = 3.0\n[[pose]]\ntime = 1\nhead = { yaw = 999 }", 4, "degrees from -360"),
        ("seconds = 3.0\ncyclic = true\n[[step]]\nfoot = \"left\"\nstart = 1\nend = 2\nto = [0, 0]", 5, "no steps"),
        (
            "seconds = 3.0\n[[gait]]\nfoot = \"left\"\nstart = 1\nsteps = 4000000000\nperiod = 1\nswing = 0.5\nby = [0, 0]",
            5,
            "steps",
        ),
    ] {
        let error = wrong(text);
        assert!(error.contains(&format!("x.keys.toml:{line}:")) && error.contains(part), "{text:?}: {error}");
    }
    let step = |foot: &str, start: f64| format!("[[step]]\nfoot = \"{foot}\"\nstart = {start}\nend = 2\nto = [0, 0]\n");
    let error = wrong(&format!("{head}{}{}", step("left", 1.0), step("right", 1.5)));
    assert!(error.contains("x.keys.toml:9:") && error.contains("one before has ended"), "{error}");
    let far = format!("{head}{}", step("left", 1.0).replace("[0, 0]", "[1.5, 0]"));
    assert!(wrong(&far).contains("the left foot is out of the leg's reach at"), "{}", wrong(&far));
    assert!(parse(&[0xff, 0xfe, 0x00], "x".as_ref()).unwrap_err().to_string().contains("UTF-16"));
}

proptest! {
    #[test]
    fn any_bytes_are_a_clip_or_an_error(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = parse(&bytes, "x.keys.toml".as_ref());
    }

    #[test]
    fn a_spoilt_clip_is_a_clip_or_an_error(
        which in 0..builtin().count(),
        cut in 0.0..1.0f64,
        put in "[0-9a-z.=\\-\\[\\]{} \n]{0,6}",
    ) {
        let (_, text) = builtin().nth(which).unwrap();
        let at = (cut * text.len() as f64) as usize;
        let at = (0..=at).rev().find(|at| text.is_char_boundary(*at)).unwrap();
        let spoilt = format!("{}{put}{}", &text[..at], &text[at..]);
        let _ = parse(spoilt.as_bytes(), "x.keys.toml".as_ref());
        let _ = parse(&text.as_bytes()[..at], "x.keys.toml".as_ref());
    }
}
