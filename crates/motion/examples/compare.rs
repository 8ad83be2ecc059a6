//! Retargets files onto a robot and compares them with the first.
#![allow(clippy::unwrap_used)]
use lifelike_character::{Anatomy, Character, Kinematics};
use lifelike_motion::formats::{ReadOptions, read_source};
use lifelike_motion::retarget::{RetargetOptions, retarget};
use std::path::Path;

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let character = Character::load(Path::new(&args[0])).unwrap();
    let anatomy = Anatomy::guess(&character, &Default::default()).unwrap();
    let mut base = None;
    for path in &args[1..] {
        let short = path.rsplit('/').nth(1).unwrap_or(path);
        let made = read_source(Path::new(path), &ReadOptions::default())
            .and_then(|s| Ok((retarget(&s, &character, &anatomy, &RetargetOptions::default())?, s)));
        match made {
            Err(e) => println!("{short:32} REFUSED {}", e.to_string().chars().take(400).collect::<String>()),
            Ok(((clip, report), source)) => {
                let base = base.get_or_insert_with(|| clip.clone());
                let n = clip.len().min(base.len());
                let width = clip.joint_names.len();
                let (mut sum, mut max, mut place, mut turn) = (0.0, 0.0_f64, 0.0_f64, 0.0_f64);
                let mut body = 0.0_f64;
                let (mut ka, mut kb) = (Kinematics::new(&character), Kinematics::new(&character));
                let (mut qa, mut qb) = (character.reference_position(), character.reference_position());
                for t in 0..n {
                    for j in 0..width {
                        let d = (clip.joints[t * width + j] - base.joints[t * width + j]).abs().to_degrees();
                        sum += d;
                        max = max.max(d);
                    }
                    place = place.max((clip.root_position[t] - base.root_position[t]).norm());
                    turn = turn.max(clip.root_orientation[t].angle_to(&base.root_orientation[t]).to_degrees());
                    let columns = clip.columns_for(&character).unwrap();
                    clip.write_position(&character, &columns, t, &mut qa);
                    base.write_position(&character, &columns, t, &mut qb);
                    ka.update(&character, &qa);
                    kb.update(&character, &qb);
                    for b in 1..character.bodies.len() {
                        body = body.max((ka.body_position[b] - kb.body_position[b]).norm());
                    }
                }
                let mean = |m: &std::collections::BTreeMap<_, lifelike_motion::retarget::Spread>| {
                    m.values().map(|s| s.mean).sum::<f64>() / m.len().max(1) as f64
                };
                println!(
                    "{short:32} frames {:5} joints mean {:6.2} max {:6.2} deg, root {:.4} m {:.2} deg, bodies {:.4} m | pos {:.3} ang {:.1} skate {:.3} | {}",
                    clip.len(),
                    sum / (n * width) as f64,
                    max,
                    place,
                    turn,
                    body,
                    mean(&report.position_error),
                    mean(&report.orientation_error),
                    report.foot_skate.mean,
                    source.notes.join("; ")
                );
            }
        }
    }
}
