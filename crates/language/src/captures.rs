//! Captured clips with their descriptions, as a captioned set: cut into pieces, mirrored, split by subject.
//!
//! The clips are a robot's, already retargeted. Captions are the clip's own, or those of a table
//! ([`lifelike_motion::formats::CaptionTable`]: CMU's descriptions with KIT-ML's sentences, Bandai's contents and
//! styles); DeepMimic's clips are described by their names.

use lifelike_character::Character;
use lifelike_motion::clip::Caption;
use lifelike_motion::edit::{mirror, trim};
use lifelike_motion::formats::clip_name;
use lifelike_motion::{MotionClip, container};

use crate::dataset::{Entry, Split};
use crate::error::LanguageError;
use crate::mirror_caption::mirror_caption;

/// Options of cutting and splitting.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Shortest and longest piece (s).
    pub seconds: [f64; 2],
    /// CMU subjects whose clips are for testing only.
    pub test_subjects: Vec<String>,
    /// Flag: every piece comes a second time, mirrored.
    pub mirrored: bool,
}

impl Default for Options {
    fn default() -> Self {
        let test_subjects = ["02", "07", "10", "12"].map(String::from).to_vec();
        Self { seconds: [2.0, 10.0], test_subjects, mirrored: true }
    }
}

/// Returns the sentence of a Bandai clip: its caption is `content, style`.
fn bandai_sentence(content: &str, style: &str) -> String {
    let verb = match content {
        "bow" => "bows",
        "bye" => "waves goodbye",
        "call" => "calls somebody over",
        "dance long" | "dance short" => "dances",
        "dash" => "dashes forward",
        "guide" => "shows the way",
        "kick" => "kicks",
        "punch" => "punches",
        "raise up both hands" => "raises both hands",
        "raise up left hand" => "raises the left hand",
        "raise up right hand" => "raises the right hand",
        "respond" => "responds",
        "run" => "runs",
        "slash" => "slashes",
        "walk" => "walks",
        "walk back" => "walks backward",
        "walk left" => "walks to the left",
        "walk right" => "walks to the right",
        "walk turn left" => "walks and turns left",
        "walk turn right" => "walks and turns right",
        other => return format!("a person does this: {other}, in a {style} way"),
    };
    match style {
        "normal" => format!("a person {verb}"),
        style if style.starts_with(['a', 'e', 'i', 'o', 'u']) => format!("a person {verb} in an {style} way"),
        style => format!("a person {verb} in a {style} way"),
    }
}

/// Returns the sentence of a DeepMimic clip, from its name.
fn deepmimic_sentence(name: &str) -> Option<String> {
    let what = name.strip_prefix("humanoid3d_")?;
    let words: Vec<&str> = what
        .split('_')
        .filter(|w| !["long", "mirror", "a", "b"].contains(w))
        .map(|w| w.trim_end_matches(|c: char| c.is_ascii_digit()))
        .collect();
    Some(format!("a person does this: {}", words.join(" ")))
}

/// Returns whether a clip may be used for commercial purposes, as far as its origin tells; Bandai's may not.
pub fn is_commercial(clip: &MotionClip) -> bool {
    let origin = format!("{} {} {}", clip.name, clip.provenance.source, clip.provenance.licence).to_lowercase();
    !["bandai", "dataset-1", "dataset-2", "by-nc", "non-commercial"].iter().any(|mark| origin.contains(mark))
}

/// Returns the sentences of a clip as they are to be learned.
fn sentences(clip: &MotionClip, captions: &[Caption]) -> Vec<Caption> {
    if clip.name.starts_with("dataset-") {
        let said = |caption: &Caption| {
            let (content, style) = caption.text.split_once(", ").unwrap_or((caption.text.as_str(), "normal"));
            Caption { text: bandai_sentence(content, style), ..caption.clone() }
        };
        return captions.iter().map(said).collect();
    }
    match deepmimic_sentence(&clip.name) {
        Some(text) if captions.is_empty() => vec![Caption { start: 0.0, end: clip.seconds(), text }],
        _ => captions.iter().filter(|caption| !caption.text.trim().is_empty()).cloned().collect(),
    }
}

/// Cuts a clip into captioned pieces with their lines of the index. `captions` are those of a table; without any the
/// clip's own are taken. A clip of which nothing is said gives no piece.
///
/// # Errors
/// As [`trim()`] and [`mirror()`].
pub fn pieces(
    clip: &MotionClip,
    captions: &[Caption],
    character: &Character,
    options: &Options,
) -> Result<Vec<(MotionClip, Entry)>, LanguageError> {
    let own = if captions.is_empty() { &clip.provenance.captions } else { captions };
    let told = sentences(clip, own);
    let subject = clip.name.split('_').next().unwrap_or_default();
    let split = match options.test_subjects.iter().any(|s| s == subject) {
        true => Split::Test,
        // One subject in twelve, by its number.
        false if subject.parse::<u32>().is_ok_and(|number| number % 12 == 5) => Split::Validation,
        false => Split::Train,
    };
    let licence = match (is_commercial(clip), clip.provenance.licence.as_str()) {
        (true, licence) => licence.to_string(),
        (false, _) => "CC BY-NC 4.0: non-commercial only".to_string(),
    };
    let mut made = Vec::new();
    for [start, end] in cuts(clip.seconds(), &told, options.seconds) {
        let mut piece = trim(clip, Some(start), Some(end))?;
        piece.cyclic = false;
        let length = piece.seconds();
        piece.name = format!("{}_{:05}", clip.name, (start * 100.0).round() as u32);
        let mut texts: Vec<String> = Vec::new();
        for caption in &told {
            // A sentence is of a piece that is mostly inside of it, and it mostly inside of the piece or of the clip.
            let shared = caption.end.min(end) - caption.start.max(start);
            if shared > 0.6 * (end - start) && !texts.contains(&caption.text) {
                texts.push(caption.text.clone());
            }
        }
        if texts.is_empty() || length < options.seconds[0] - 0.1 {
            continue;
        }
        piece.provenance.captions =
            texts.iter().map(|text| Caption { start: 0.0, end: length, text: text.clone() }).collect();
        piece.provenance.licence.clone_from(&licence);
        let entry = |piece: &MotionClip| Entry {
            file: format!("{}/{}{}", split.name(), file_name(&piece.name), container::EXTENSION),
            split,
            seconds: length,
            captions: piece.provenance.captions.iter().map(|caption| caption.text.clone()).collect(),
            source: clip.name.clone(),
            licence: licence.clone(),
            facts: None,
        };
        if options.mirrored {
            let mut image = mirror(&piece, character)?;
            image.name = format!("{}_mirror", piece.name);
            image.provenance.captions = piece.provenance.captions.clone();
            for caption in &mut image.provenance.captions {
                caption.text = mirror_caption(&caption.text);
            }
            made.push((image.clone(), entry(&image)));
        }
        made.push((piece.clone(), entry(&piece)));
    }
    Ok(made)
}

/// Returns a name that is one file's.
fn file_name(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' }).collect()
}

/// Returns the stretches into which a clip is cut: those of captions that have times of their own, else equal parts of
/// the whole, none longer than allowed.
fn cuts(seconds: f64, captions: &[Caption], [shortest, longest]: [f64; 2]) -> Vec<[f64; 2]> {
    let part = |c: &&Caption| c.start > 0.05 || c.end < seconds - 0.05;
    let mut stretches: Vec<[f64; 2]> =
        captions.iter().filter(part).map(|c| [c.start.max(0.0), c.end.min(seconds)]).collect();
    stretches.dedup();
    if stretches.is_empty() {
        stretches.push([0.0, seconds]);
    }
    let mut found = Vec::new();
    for [start, end] in stretches {
        let length = end - start;
        if length.is_nan() || length < shortest {
            continue;
        }
        let parts = (length / longest).ceil().max(1.0);
        let each = length / parts;
        found.extend((0..parts as usize).map(|i| [start + i as f64 * each, start + (i + 1) as f64 * each]));
    }
    found
}

/// Returns a clip's name as captions tables have it.
pub fn table_name(clip: &MotionClip) -> std::path::PathBuf {
    let name = clip.name.strip_suffix("-bvh").or_else(|| clip.name.strip_suffix("-amc")).unwrap_or(&clip.name);
    clip_name(std::path::Path::new(name)).into()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn said(start: f64, end: f64, text: &str) -> Caption {
        Caption { start, end, text: text.into() }
    }

    #[test]
    fn captions_with_times_of_their_own_cut_the_clip() {
        let whole = [said(0.0, 25.0, "walk")];
        assert_eq!(cuts(25.0, &whole, [2.0, 10.0]).len(), 3);
        assert_eq!(cuts(1.9, &whole, [2.0, 10.0]).len(), 0);
        let parts = [said(0.0, 25.0, "all"), said(1.0, 5.0, "a"), said(5.0, 17.0, "b"), said(20.0, 21.0, "c")];
        assert_eq!(cuts(25.0, &parts, [2.0, 10.0]), [[1.0, 5.0], [5.0, 11.0], [11.0, 17.0]]);
    }

    #[test]
    fn labels_become_sentences() {
        assert_eq!(bandai_sentence("walk turn left", "angry"), "a person walks and turns left in an angry way");
        assert_eq!(bandai_sentence("bow", "normal"), "a person bows");
        assert_eq!(deepmimic_sentence("humanoid3d_long_walk1_mirror").unwrap(), "a person does this: walk");
        assert!(deepmimic_sentence("02_01").is_none());
    }
}
