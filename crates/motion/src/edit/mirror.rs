//! The mirror image of a motion: what the left side did, the right side does.

use lifelike_character::{Character, Symmetry};

use super::poses::{clamp_to_ranges, positions, set_positions};
use super::story::provenance;
use crate::clip::{Caption, MotionClip};
use crate::error::MotionError;

/// Returns the clip as a mirror on the world's xz plane shows it, by the character's own symmetry: it starts on the
/// other side of the x axis and turns the other way. Contacts change feet; `left` and `right` change places in
/// captions. Joints stay within their ranges, where those are not symmetric themselves.
///
/// # Errors
/// [`MotionError::Character`] for a character that is not symmetric, [`MotionError::Mismatch`] for a clip of another.
pub fn mirror(clip: &MotionClip, character: &Character) -> Result<MotionClip, MotionError> {
    let symmetry = Symmetry::derive(character)?;
    let mirrored: Vec<Vec<f64>> =
        positions(clip, character)?.iter().map(|q| symmetry.mirror_position(character, q)).collect();
    let mut out = clip.clone();
    set_positions(&mut out, character, &mirrored);
    clamp_to_ranges(&mut out, character);
    if let (Some(to), Some(from)) = (&mut out.contacts, &clip.contacts) {
        let places = from.names.len();
        for (place, name) in from.names.iter().enumerate() {
            let image = character.body(name).map(|b| &character.bodies[symmetry.body[b]].name);
            let image = image.ok().and_then(|name| from.names.iter().position(|n| n == name)).unwrap_or(place);
            for t in 0..clip.len() {
                to.flags[t * places + image] = from.flags[t * places + place];
            }
        }
    }
    let told = clip.provenance.captions.iter().map(|c| Caption { text: other_side(&c.text), ..c.clone() });
    out.provenance = provenance(&[clip], format!("mirror image of '{}'", clip.name), told.collect());
    Ok(out)
}

/// Swaps the words left and right.
fn other_side(text: &str) -> String {
    let swap = |word: &str| match word {
        "left" => "right".to_string(),
        "right" => "left".to_string(),
        "Left" => "Right".to_string(),
        "Right" => "Left".to_string(),
        other => other.to_string(),
    };
    let mut out = String::with_capacity(text.len());
    for piece in text.split_inclusive(|c: char| !c.is_alphabetic()) {
        let word = piece.trim_end_matches(|c: char| !c.is_alphabetic());
        out += &swap(word);
        out += &piece[word.len()..];
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_change_sides() {
        assert_eq!(other_side("Left hand, right foot; bright (left)"), "Right hand, left foot; bright (right)");
        assert_eq!(other_side(&other_side("waves with the right hand")), "waves with the right hand");
    }
}
