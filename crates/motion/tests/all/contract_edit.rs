//! Promises of direction (thesis 4.3.4), on Lima with the project's own keyframed clips.
use std::path::Path;

use lifelike_character::rotation::heading_angle;
use lifelike_character::{Anatomy, Character, Kinematics, Role, Vec3};
use lifelike_motion::edit::{
    Amplify, Around, Compose, Key, Length, Part, Target, Warp, amplify, blend, compose, joints_of, mirror, place,
    sequence, smooth, too_fast, trim, warp,
};
use lifelike_motion::retarget::{RetargetOptions, retarget};
use lifelike_motion::{MotionClip, container, keyframes};

struct Lima {
    character: Character,
    anatomy: Anatomy,
    options: RetargetOptions,
}

impl Lima {
    fn new() -> Self {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/lima.xml");
        let character = Character::load(file).unwrap();
        let anatomy = Anatomy::guess(&character, &Default::default()).unwrap();
        Self { character, anatomy, options: RetargetOptions::default() }
    }

    fn own(&self, name: &str) -> MotionClip {
        let (_, text) = keyframes::builtin().find(|(n, _)| *n == name).unwrap();
        let mut source = keyframes::parse(text.as_bytes(), Path::new(name)).unwrap();
        source.name = name.into();
        retarget(&source, &self.character, &self.anatomy, &self.options).unwrap().0
    }

    fn part(&self, name: &str) -> Vec<String> {
        joints_of(&self.character, &self.anatomy, &[name.to_string()]).unwrap()
    }

    /// Kinematics of every frame.
    fn poses(&self, clip: &MotionClip) -> Vec<Kinematics> {
        let columns = clip.columns_for(&self.character).unwrap();
        let mut q = self.character.reference_position();
        let pose = |t| {
            clip.write_position(&self.character, &columns, t, &mut q);
            let mut kinematics = Kinematics::new(&self.character);
            kinematics.update(&self.character, &q);
            kinematics
        };
        (0..clip.len()).map(pose).collect()
    }

    fn hand(&self, pose: &Kinematics, role: Role) -> Vec3 {
        let place = &self.anatomy.places[&role];
        pose.point(place.body, &place.point)
    }

    /// Corners of both soles.
    fn soles(&self, pose: &Kinematics) -> Vec<Vec3> {
        self.anatomy.soles.values().flat_map(|s| s.corners.iter().map(|c| pose.point(s.body, c))).collect()
    }

    fn is_within_ranges(&self, clip: &MotionClip) -> bool {
        self.character.scalar_joints().all(|joint| {
            let (low, high) = joint.range.unwrap();
            column(clip, &joint.name).iter().all(|v| (low..=high).contains(v))
        })
    }
}

fn column(clip: &MotionClip, joint: &str) -> Vec<f64> {
    let at = clip.joint_names.iter().position(|n| n == joint).unwrap();
    (0..clip.len()).map(|t| clip.joints_at(t)[at]).collect()
}

fn fastest(clip: &MotionClip) -> f64 {
    let n = clip.joint_names.len();
    let steps = clip.joints.iter().zip(clip.joints.iter().skip(n)).map(|(a, b)| (b - a).abs());
    steps.fold(0.0, f64::max) * clip.fps
}

fn key(body: &str, time: f64, target: Target) -> Key {
    Key { body: body.into(), point: None, time, target, before: 0.5, after: 0.5 }
}

#[test]
fn a_placed_hand_is_there_and_the_planted_feet_stay() {
    let lima = Lima::new();
    let clip = lima.own("wave");
    let old = lima.poses(&clip);
    let frame = 100;
    let from = lima.hand(&old[frame], Role::RightHand);
    // To the side and down; then so far ahead that the trunk must come along (the arm is 0.27 m long); both at once with
    // the left hand.
    let near = from + Vec3::new(0.05, -0.05, -0.08);
    let far = Vec3::new(0.24, -0.1, from.z - 0.05);
    for (target, by_left) in [(near, Vec3::new(0.06, 0.0, 0.05)), (far, Vec3::new(0.1, 0.02, 0.02))] {
        let keys = [key("right_hand", 2.0, Target::At(target)), key("left_hand", 2.0, Target::By(by_left))];
        let (out, report) = place(&clip, &lima.character, &lima.anatomy, &keys, &lima.options).unwrap();
        let new = lima.poses(&out);
        let residual = (lima.hand(&new[frame], Role::RightHand) - target).norm();
        assert!(residual < 0.01, "{residual} m from {target:?}");
        assert!((residual - report.keys[0].residual).abs() < 1e-6, "the report says otherwise");
        let left = lima.hand(&new[frame], Role::LeftHand) - lima.hand(&old[frame], Role::LeftHand);
        assert!((left - by_left).norm() < 0.01, "{left:?}");
        let moved = old.iter().zip(&new).flat_map(|(a, b)| {
            let pairs: Vec<f64> = lima.soles(a).iter().zip(lima.soles(b)).map(|(a, b)| (a - b).norm()).collect();
            pairs
        });
        let moved = moved.fold(0.0, f64::max);
        assert!(moved < 1e-3 && (moved - report.feet_moved).abs() < 1e-6, "soles moved by {moved} m");
        // Frames 75 to 125 are the windows' ends: nothing is changed outside, and something inside.
        for t in (0..=75).chain(125..clip.len()) {
            assert_eq!(out.joints_at(t), clip.joints_at(t), "frame {t}");
            assert_eq!(out.root_position[t], clip.root_position[t], "frame {t}");
        }
        assert!(lima.is_within_ranges(&out));
        assert!(fastest(&out) <= lima.options.default_velocity_limit + 1e-9, "{}", fastest(&out));
        assert_eq!(out.contacts, clip.contacts);
        // No jerk at the windows' ends: the change begins with a step far smaller than its largest.
        let change = |t: usize| {
            let rows = out.joints_at(t).iter().zip(clip.joints_at(t));
            rows.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        let largest = (0..clip.len()).map(change).fold(0.0, f64::max);
        assert!(change(76) < 0.05 * largest && change(124) < 0.05 * largest, "{} {}", change(76), change(124));
    }
}

#[test]
fn a_foot_is_placed_while_it_swings_and_the_other_stays() {
    let lima = Lima::new();
    let clip = lima.own("step_in_place");
    let contacts = clip.contacts.as_ref().unwrap();
    // The middle of the left foot's first swing.
    let air: Vec<usize> = (0..clip.len()).filter(|t| !contacts.flags[2 * t]).collect();
    let end = air.windows(2).position(|w| w[1] != w[0] + 1).unwrap_or(air.len() - 1);
    let frame = air[end / 2];
    let mut keys = [key("left_foot", frame as f64 / clip.fps, Target::By(Vec3::new(0.05, 0.02, 0.02)))];
    (keys[0].before, keys[0].after) = (0.15, 0.15);
    let (out, report) = place(&clip, &lima.character, &lima.anatomy, &keys, &lima.options).unwrap();
    assert!(report.keys[0].residual < 0.01 && report.feet_moved < 1e-3, "{report:?}");
    let place = lima.character.site("left_foot").map(|s| &lima.character.sites[s]).unwrap();
    let at = |clip: &MotionClip| lima.poses(clip)[frame].point(place.body, &place.position);
    assert!((at(&out) - at(&clip) - Vec3::new(0.05, 0.02, 0.02)).norm() < 0.01);
}

#[test]
fn a_place_out_of_reach_is_told_and_the_feet_hold() {
    let lima = Lima::new();
    let clip = lima.own("nod");
    let keys = [key("right_hand", 1.0, Target::At(Vec3::new(2.0, 0.0, 0.5)))];
    let (out, report) = place(&clip, &lima.character, &lima.anatomy, &keys, &lima.options).unwrap();
    assert!(report.keys[0].residual > 1.0 && report.feet_moved < 1e-3, "{report:?}");
    assert!(lima.is_within_ranges(&out));
    let message =
        |keys: &[Key]| place(&clip, &lima.character, &lima.anatomy, keys, &lima.options).unwrap_err().to_string();
    assert!(message(&[key("tail", 1.0, Target::By(Vec3::x()))]).contains("right_hand"), "names what there is");
    assert!(message(&[key("right_hand", 99.0, Target::By(Vec3::x()))]).contains("99"));
    assert!(message(&[]).contains("at least one"));
}

#[test]
fn mirroring_twice_is_the_identity_and_once_is_the_other_side() {
    let lima = Lima::new();
    for name in ["walk", "wave", "turn_in_place"] {
        let clip = lima.own(name);
        let once = mirror(&clip, &lima.character).unwrap();
        let twice = mirror(&once, &lima.character).unwrap();
        for t in 0..clip.len() {
            assert!((twice.root_position[t] - clip.root_position[t]).norm() < 1e-12);
            assert!(twice.root_orientation[t].angle_to(&clip.root_orientation[t]) < 1e-6);
            let rows = twice.joints_at(t).iter().zip(clip.joints_at(t));
            assert!(rows.fold(0.0, |worst: f64, (a, b)| worst.max((a - b).abs())) < 1e-12);
        }
        assert_eq!(twice.contacts, clip.contacts);
        let (old, new) = (lima.poses(&clip), lima.poses(&once));
        for (a, b) in old.iter().zip(&new) {
            let (mut p, q) = (lima.hand(a, Role::RightHand), lima.hand(b, Role::LeftHand));
            p.y = -p.y;
            assert!((p - q).norm() < 1e-6, "{name}: {p:?} {q:?}");
        }
        let (from, to) = (clip.contacts.unwrap().flags, once.contacts.unwrap().flags);
        assert!((0..clip.root_position.len()).all(|t| from[2 * t] == to[2 * t + 1] && from[2 * t + 1] == to[2 * t]));
    }
    assert!(mirror(&lima.own("wave"), &lima.character).unwrap().provenance.captions[0].text.contains("left hand"));
}

#[test]
fn a_sequence_goes_on_where_the_last_one_ended() {
    let lima = Lima::new();
    let clips = ["walk", "turn_in_place", "walk", "wave"].map(|name| lima.own(name));
    let parts: Vec<Part> = clips.iter().map(Part::from).collect();
    let out = sequence(&parts, 0.3).unwrap();
    let seconds: f64 = clips.iter().map(MotionClip::seconds).sum();
    assert!((out.seconds() - (seconds - 3.0 * 0.3)).abs() < 1e-9);
    let limit = |f: &dyn Fn(&MotionClip, usize) -> f64| {
        clips.iter().flat_map(|c| (1..c.len()).map(move |t| f(c, t))).fold(0.0, f64::max)
    };
    let place = |c: &MotionClip, t: usize| (c.root_position[t] - c.root_position[t - 1]).xy().norm();
    let turn = |c: &MotionClip, t: usize| {
        let step = heading_angle(&c.root_orientation[t]) - heading_angle(&c.root_orientation[t - 1]);
        step.sin().atan2(step.cos()).abs()
    };
    for t in 1..out.len() {
        assert!(place(&out, t) <= limit(&place) + 1e-9, "place at frame {t}");
        assert!(turn(&out, t) <= limit(&turn) + 1e-9, "heading at frame {t}");
    }
    assert!(fastest(&out) < 12.0, "joints: {} rad/s", fastest(&out));
    // The second walk goes where the turn looked.
    let turned =
        heading_angle(clips[1].root_orientation.last().unwrap()) - heading_angle(&clips[1].root_orientation[0]);
    assert!(turned.abs() > 0.5, "the clip turns");
    let way = |from: usize, to: usize| out.root_position[to] - out.root_position[from];
    let half = clips[0].len() / 2;
    let second = out.len() - clips[3].len() - clips[2].len();
    let first = way(half, half + 20);
    let then = way(second + half, second + half + 20);
    let between = (first.x * then.y - first.y * then.x).atan2(first.dot(&then));
    let off = between - turned;
    assert!(off.sin().atan2(off.cos()).abs() < 0.3, "walks at {between} rad from before, turned by {turned}");
}

#[test]
fn an_abrupt_switch_changes_exactly_one_step() {
    let lima = Lima::new();
    let (a, b) = (lima.own("squat"), lima.own("wave"));
    let part = Part { clip: &a, start: None, end: Some(1.0) };
    let out = sequence(&[part, (&b).into()], 0.0).unwrap();
    assert_eq!(out.len(), 51 + b.len() - 1);
    for t in 0..50 {
        assert_eq!(out.joints_at(t), a.joints_at(t));
        assert_eq!(out.root_position[t], a.root_position[t]);
    }
    for t in 50..out.len() {
        assert_eq!(out.joints_at(t), b.joints_at(t - 50), "frame {t}");
        assert!((out.root_position[t].z - b.root_position[t - 50].z).abs() < 1e-12, "heights stay");
    }
    assert_ne!(a.joints_at(50), b.joints_at(0));
    // The jump of the knees is told as what it is.
    let limits = out.joint_names.iter().map(|name| (name.clone(), 12.0)).collect();
    let found = too_fast(&out, &limits);
    assert!(!found.is_empty() && found.iter().all(|f| f.frames == 1 && (f.time - 0.98).abs() < 1e-9), "{found:?}");
}

#[test]
fn a_composed_clip_has_the_bases_legs_and_the_others_arms() {
    let lima = Lima::new();
    let (base, other) = (lima.own("march"), lima.own("wave"));
    let options = Compose { joints: lima.part("arms"), offset: 0.5, length: Length::Cut, fade: 0.0 };
    let out = compose(&base, &other, &options).unwrap();
    assert_eq!(out.len(), base.len().min(other.len() + 25));
    for name in &base.joint_names {
        let (got, own) = (column(&out, name), column(&base, name));
        if options.joints.contains(name) {
            assert_eq!(got[..25], own[..25]);
            assert_eq!(got[25..], column(&other, name)[..out.len() - 25], "{name}");
            assert_ne!(got[25..], own[25..out.len()]);
        } else {
            assert_eq!(got, own[..out.len()], "{name}");
        }
    }
    assert_eq!(out.root_position, base.root_position[..out.len()]);
    let flags = |c: &MotionClip| c.contacts.as_ref().unwrap().flags[..2 * out.len()].to_vec();
    assert_eq!(flags(&out), flags(&base));
    let faded = compose(&base, &other, &Compose { fade: 0.4, ..options.clone() }).unwrap();
    let jump = |c: &MotionClip| {
        let steps = options.joints.iter().map(|name| (column(c, name)[25] - column(c, name)[24]).abs());
        steps.fold(0.0, f64::max)
    };
    assert!(jump(&faded) < 0.1 * jump(&out), "{} {}", jump(&faded), jump(&out));
}

#[test]
fn a_warp_keeps_the_path() {
    let lima = Lima::new();
    let clip = lima.own("walk");
    let to_path = |p: &Vec3| {
        let near = clip.root_position.windows(2).map(|w| {
            let (d, v) = (w[1] - w[0], p - w[0]);
            (v - d * (v.dot(&d) / d.norm_squared().max(1e-30)).clamp(0.0, 1.0)).norm()
        });
        near.fold(f64::INFINITY, f64::min)
    };
    for how in [Warp::Speed(0.7), Warp::Keys(vec![(1.0, 1.6), (2.0, 2.2)])] {
        let out = warp(&clip, &how).unwrap();
        assert!(out.root_position.iter().all(|p| to_path(p) < 1e-9), "{how:?}");
        assert_ne!(out.len(), clip.len());
        let end = out.root_position.last().unwrap() - clip.root_position.last().unwrap();
        assert!(end.norm() < 0.02, "{how:?}: ends {} m from the end", end.norm());
    }
    let keyed = warp(&clip, &Warp::Keys(vec![(1.0, 1.6), (2.0, 2.2)])).unwrap();
    assert!((keyed.root_position[80] - clip.root_position[50]).norm() < 1e-9);
    assert!((keyed.root_position[110] - clip.root_position[100]).norm() < 1e-9);
}

#[test]
fn larger_arms_leave_the_legs_and_larger_legs_stay_on_the_ground() {
    let lima = Lima::new();
    let clip = lima.own("walk");
    let change = |part: &str, gain| {
        let how = Amplify { joints: lima.part(part), gain, around: Around::Mean };
        amplify(&clip, &lima.character, &lima.anatomy, &how, &lima.options).unwrap()
    };
    let spread = |c: &MotionClip, joint: &str| {
        let v = column(c, joint);
        v.iter().copied().fold(f64::MIN, f64::max) - v.iter().copied().fold(f64::MAX, f64::min)
    };
    let arms = change("arms", 1.5);
    assert!(lima.is_within_ranges(&arms));
    let ratio = spread(&arms, "left_shoulder_pitch") / spread(&clip, "left_shoulder_pitch");
    assert!((ratio - 1.5).abs() < 1e-6, "{ratio}");
    for name in lima.part("legs") {
        assert_eq!(column(&arms, &name), column(&clip, &name));
    }
    assert_eq!(arms.root_position, clip.root_position);

    let legs = change("legs", 1.3);
    assert!(lima.is_within_ranges(&legs));
    assert!(spread(&legs, "left_knee") > 1.1 * spread(&clip, "left_knee"));
    assert_eq!(column(&legs, "left_elbow"), column(&clip, "left_elbow"));
    let lowest = |c: &MotionClip| {
        let low = lima.poses(c).iter().flat_map(|pose| lima.soles(pose)).map(|p| p.z).collect::<Vec<_>>();
        low.into_iter().fold(f64::INFINITY, f64::min)
    };
    assert!(lowest(&legs).abs() < 0.01, "a sole at {} m", lowest(&legs));
    assert!(skate(&lima, &legs) < 0.03, "{} m/s", skate(&lima, &legs));
    let calm = change("all", 0.5);
    assert!(spread(&calm, "left_shoulder_pitch") < 0.6 * spread(&clip, "left_shoulder_pitch"));
    assert!(lowest(&calm).abs() < 0.01 && skate(&lima, &calm) < 0.03, "{} {}", lowest(&calm), skate(&lima, &calm));
}

/// Mean speed of sole corners on the ground while their foot stands (m/s).
fn skate(lima: &Lima, clip: &MotionClip) -> f64 {
    let flags = &clip.contacts.as_ref().unwrap().flags;
    let soles: Vec<Vec<Vec3>> = lima.poses(clip).iter().map(|pose| lima.soles(pose)).collect();
    let half = soles[0].len() / 2;
    let mut speeds = Vec::new();
    for t in 1..clip.len() {
        for (i, (now, old)) in soles[t].iter().zip(&soles[t - 1]).enumerate() {
            let side = i / half;
            if flags[2 * t + side] && flags[2 * (t - 1) + side] && now.z.max(old.z) < 0.005 {
                speeds.push((now - old).xy().norm() * clip.fps);
            }
        }
    }
    assert!(speeds.len() > clip.len() / 4, "some corners stand: {} of {} frames", speeds.len(), clip.len());
    speeds.iter().sum::<f64>() / speeds.len() as f64
}

#[test]
fn smoothing_takes_a_tremor_away_and_keeps_the_soles_on_the_ground() {
    let lima = Lima::new();
    let clip = lima.own("walk");
    let mut shaking = clip.clone();
    let n = clip.joint_names.len();
    for (i, value) in shaking.joints.iter_mut().enumerate() {
        *value += 0.02 * (std::f64::consts::TAU * 15.0 * (i / n) as f64 / clip.fps + (i % n) as f64).sin();
    }
    let out = smooth(&shaking, &lima.character, &lima.anatomy, &lima.part("all"), 5.0, &lima.options).unwrap();
    let jerk = |c: &MotionClip| {
        let row = |t: usize| c.joints_at(t);
        let all = (3..c.len())
            .flat_map(|t| (0..n).map(move |j| row(t)[j] - 3.0 * row(t - 1)[j] + 3.0 * row(t - 2)[j] - row(t - 3)[j]));
        all.map(|v| v * v).sum::<f64>().sqrt()
    };
    assert!(jerk(&shaking) > 5.0 * jerk(&clip), "a tremor to begin with");
    assert!(jerk(&out) < 1.1 * jerk(&clip), "{} of {}", jerk(&out), jerk(&clip));
    assert!(lima.is_within_ranges(&out) && skate(&lima, &out) < 0.03, "{}", skate(&lima, &out));
}

#[test]
fn every_result_is_a_clip_like_any_other() {
    let lima = Lima::new();
    let (a, b) = (lima.own("walk"), lima.own("march"));
    let how = Compose { joints: lima.part("head"), offset: 0.0, length: Length::Hold, fade: 0.2 };
    let made = [
        compose(&a, &b, &how).unwrap(),
        sequence(&[(&a).into(), (&b).into()], 0.2).unwrap(),
        blend(&a, &b, 0.5).unwrap(),
        warp(&a, &Warp::Speed(1.2)).unwrap(),
        mirror(&a, &lima.character).unwrap(),
        trim(&a, Some(0.5), Some(1.5)).unwrap(),
    ];
    for clip in made {
        let bytes = container::to_bytes(&clip).unwrap();
        let read = container::from_bytes(&bytes, Path::new("clip")).unwrap();
        assert_eq!(read.provenance, clip.provenance);
        assert_eq!(clip.provenance.character, "lima");
        assert!(clip.provenance.source.contains("'walk'"), "{}", clip.provenance.source);
        assert!(clip.contacts.is_some());
        assert!(clip.root_orientation.windows(2).all(|w| w[0].coords.dot(&w[1].coords) > 0.0), "no sign flips");
    }
}
