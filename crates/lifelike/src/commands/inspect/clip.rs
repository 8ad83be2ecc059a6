//! Motion: as it was captured, and of a robot.

use std::path::Path;

use lifelike_motion::{MotionClip, SourceClip};
use serde_json::json;

use super::next_steps;
use crate::error::CliError;
use crate::next;
use crate::output::{Output, table};

/// Prints captured motion.
pub fn inspect_source(path: &Path, clip: &SourceClip, output: &Output) -> Result<(), CliError> {
    let skeleton = &clip.skeleton;
    let steps = next_steps::of_captured(path);
    let value = json!({
        "kind": "captured motion", "name": clip.name, "fps": clip.fps, "frames": clip.len(), "seconds": clip.seconds(),
        "cyclic": clip.cyclic, "joints": skeleton.names, "captions": clip.captions, "provenance": clip.provenance,
        "next": next::texts(&steps),
    });
    output.result(&value, || {
        let mut text = format!(
            "{}: captured motion, {:.2} s, {} frames at {} Hz{}\n\n",
            clip.name,
            clip.seconds(),
            clip.len(),
            clip.fps,
            if clip.cyclic { ", cyclic" } else { "" }
        );
        let rows: Vec<Vec<String>> = (0..skeleton.names.len())
            .map(|i| {
                let parent = skeleton.parents[i].map_or("", |p| skeleton.names[p].as_str());
                let o = skeleton.offsets[i];
                vec![skeleton.names[i].clone(), parent.into(), format!("{:.3} {:.3} {:.3}", o.x, o.y, o.z)]
            })
            .collect();
        text += &table(&["joint", "parent", "offset at rest (m)"], &rows);
        for caption in &clip.captions {
            text += &format!("{:.1} to {:.1} s: {}\n", caption.start, caption.end, caption.text);
        }
        text + &format!("from: {}\n{}", clip.provenance, next::lines(&steps))
    })
}

/// Prints the motion of a robot.
pub fn inspect_motion(path: &Path, clip: &MotionClip, output: &Output) -> Result<(), CliError> {
    let steps = next_steps::of_motion(path, clip);
    let n = clip.joint_names.len();
    let column = |j: usize| (0..clip.len()).map(move |i| clip.joints_at(i)[j]);
    let extent = |j: usize| column(j).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    let fastest = |j: usize| {
        let steps = clip.joints.iter().skip(j).step_by(n.max(1)).zip(clip.joints.iter().skip(j + n).step_by(n.max(1)));
        steps.map(|(a, b)| (b - a).abs() * clip.fps).fold(0.0, f64::max)
    };
    let path: f64 = clip.root_position.windows(2).map(|w| (w[1] - w[0]).xy().norm()).sum();
    let joints = (0..n).map(|j| {
        let (low, high) = extent(j);
        json!({ "name": clip.joint_names[j], "min": low, "max": high, "max_speed": fastest(j) })
    });
    let contacts = clip.contacts.as_ref().map(|c| {
        let share = |p: usize| {
            let flags = c.flags.iter().skip(p).step_by(c.names.len());
            flags.filter(|f| **f).count() as f64 / clip.len() as f64
        };
        (0..c.names.len()).map(|p| (c.names[p].clone(), share(p))).collect::<Vec<_>>()
    });
    let value = json!({
        "kind": "motion", "name": clip.name, "fps": clip.fps, "frames": clip.len(), "seconds": clip.seconds(),
        "cyclic": clip.cyclic, "path_m": path, "joints": joints.collect::<Vec<_>>(), "contact_share": contacts,
        "provenance": clip.provenance, "next": next::texts(&steps),
    });
    output.result(&value, || {
        let mut text = format!(
            "{}: motion of '{}', {:.2} s, {} frames at {} Hz{}, {path:.2} m of path\n\n",
            clip.name,
            clip.provenance.character,
            clip.seconds(),
            clip.len(),
            clip.fps,
            if clip.cyclic { ", cyclic" } else { "" }
        );
        let rows: Vec<Vec<String>> = (0..n)
            .map(|j| {
                let (low, high) = extent(j);
                vec![
                    clip.joint_names[j].clone(),
                    format!("{:.1} .. {:.1}", low.to_degrees(), high.to_degrees()),
                    format!("{:.1}", fastest(j)),
                ]
            })
            .collect();
        text += &table(&["joint", "range (deg)", "fastest (rad/s)"], &rows);
        for (name, share) in contacts.iter().flatten() {
            text += &format!("{name} on the ground {:.0}% of the time\n", share * 100.0);
        }
        for caption in &clip.provenance.captions {
            text += &format!("{:.1} to {:.1} s: {}\n", caption.start, caption.end, caption.text);
        }
        let (source, licence) = (&clip.provenance.source, &clip.provenance.licence);
        text + &format!("from: {source}\nterms: {licence}\n{}", next::lines(&steps))
    })
}
