//! Which parts of a body are inside of each other, and when.

use lifelike_character::{Character, Kinematics};

use crate::clip::MotionClip;
use crate::error::MotionError;
use crate::retarget::shapes::Shapes;

/// A stretch of a clip in which two parts overlap.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Collision {
    /// Names of the two bodies where they overlap most.
    pub parts: [String; 2],
    /// First frame of the stretch (s).
    pub from: f64,
    /// Its length (s): frames over rate.
    pub seconds: f64,
    /// Deepest overlap (m).
    pub deepest: f64,
}

/// Returns the stretches in which two parts overlap by more than `overlap` (m), in their order. Shapes are those of
/// [`super::Plausibility::self_collision`].
///
/// # Errors
/// As [`MotionClip::check`] and [`MotionClip::columns_for`].
pub fn collisions(clip: &MotionClip, character: &Character, overlap: f64) -> Result<Vec<Collision>, MotionError> {
    clip.check()?;
    let columns = clip.columns_for(character)?;
    let shapes = Shapes::new(character);
    let mut kinematics = Kinematics::new(character);
    let mut q = character.reference_position();
    let mut deepest = Vec::with_capacity(clip.len());
    for frame in 0..clip.len() {
        clip.write_position(character, &columns, frame, &mut q);
        kinematics.update(character, &q);
        deepest.push(shapes.deepest(&kinematics).filter(|(depth, _)| *depth > overlap));
    }
    let flags: Vec<bool> = deepest.iter().map(Option::is_some).collect();
    let stretches = crate::contacts::runs(&flags, true).into_iter().filter_map(|(start, end)| {
        let (depth, bodies) = deepest[start..end].iter().flatten().max_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(Collision {
            parts: bodies.map(|body| character.bodies[body].name.clone()),
            from: start as f64 / clip.fps,
            seconds: (end - start) as f64 / clip.fps,
            deepest: *depth,
        })
    });
    Ok(stretches.collect())
}
