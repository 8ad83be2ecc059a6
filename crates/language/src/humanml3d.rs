//! HumanML3D's published layout: `index.csv`, `texts/ID.txt`, `train.txt`, `val.txt`, `test.txt`.
//!
//! The set names frames (20 per second) of AMASS files. The motion comes from clips of a robot that have the
//! recording's name. Clips retargeted from AMASS' own `.npz` ([`lifelike_motion::formats::amass`]) have it by default
//! (`CMU_80_80_63`), in every edition and folder. Clips of the same recordings from another source match by the file's
//! name alone (`80_63_poses`, or CMU's own `80_63`).
//!
//! HumanML3D took every ⌊rate / 20⌋th frame of a recording and counted these as 20 per second. That is exact for AMASS'
//! rates of 60, 100, 120 and 240; at other rates sentences and motion are misaligned. Clips must have the captured
//! tempo.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use lifelike_character::Character;
use lifelike_motion::clip::Caption;
use lifelike_motion::edit::{mirror, trim};
use lifelike_motion::formats::{amass, clip_name};
use lifelike_motion::{MotionClip, container};

use crate::dataset::{Entry, Split};
use crate::mirror_caption::mirror_caption;
use crate::{FromInput, LanguageError};

/// Frames per second of the index and of HumanML3D's motion.
pub const FPS: f64 = 20.0;
/// Terms of the captions and of AMASS.
const LICENCE: &str = "HumanML3D captions: MIT; AMASS motion: non-commercial research only";
/// Time that HumanML3D cuts from the beginning of files of these collections before it counts frames (s).
const LEAD: [(&str, f64); 5] = [
    ("Eyes_Japan_Dataset", 3.0),
    ("MPI_HDM05", 3.0),
    ("TotalCapture", 1.0),
    ("MPI_Limits", 1.0),
    ("Transitions_mocap", 0.5),
];

/// A sentence of a text file.
#[derive(Debug, Clone, PartialEq)]
pub struct Text {
    /// The sentence.
    pub caption: String,
    /// Its words with their kinds (`walk/VERB`).
    pub tokens: Vec<String>,
    /// Start and end within the clip (s); none where it is of the whole.
    pub stretch: Option<[f64; 2]>,
}

/// One clip of the index.
#[derive(Debug, Clone, PartialEq)]
pub struct Item {
    /// The AMASS file, as the index writes it.
    pub source: String,
    /// Frames at [`FPS`]: the first, and the one after the last.
    pub frames: [u32; 2],
    /// The identifier (`000013`).
    pub id: String,
    /// The split; none of an identifier that no list has.
    pub split: Option<Split>,
    /// Sentences.
    pub texts: Vec<Text>,
    /// Sentences of the mirrored clip (`M` and the identifier); empty where it has no file.
    pub mirrored_texts: Vec<Text>,
}

impl Item {
    /// Returns the names that the clip of the source may have, best first: the recording's
    /// ([`amass::recording`], none where the path is not AMASS'), which is one person's alone, and the file's: as the
    /// index has it, without `_poses`, and as the SMPL-X edition has it.
    pub fn clip_names(&self) -> Vec<String> {
        let source = Path::new(&self.source);
        let name = clip_name(source);
        let short = name.strip_suffix("_poses").unwrap_or(&name).to_string();
        let newer = format!("{}_stageii", short.replace(' ', "_"));
        amass::recording(source).into_iter().chain([name, short, newer]).collect()
    }

    /// Returns the stretch in the source's time (s).
    pub fn stretch(&self) -> [f64; 2] {
        let lead = LEAD.iter().find(|(name, _)| self.source.contains(name)).map_or(0.0, |(_, lead)| *lead);
        self.frames.map(|frame| lead + f64::from(frame) / FPS)
    }
}

/// Reads a folder of HumanML3D: index, texts and lists. Items that stand in no list have no split.
///
/// # Errors
/// [`LanguageError::Input`] for a file that is missing, [`LanguageError::Line`] for a line that is not of the layout.
pub fn read(folder: &Path) -> Result<Vec<Item>, LanguageError> {
    let index = folder.join("index.csv");
    let content = text_of(&index)?;
    let mut splits: BTreeMap<String, Split> = BTreeMap::new();
    for (file, split) in [("train.txt", Split::Train), ("val.txt", Split::Validation), ("test.txt", Split::Test)] {
        let path = folder.join(file);
        for (at, id) in text_of(&path)?.lines().enumerate().map(|(at, line)| (at, line.trim())) {
            if id.is_empty() {
                continue;
            }
            if let Some(other) = splits.insert(id.to_string(), split).filter(|other| *other != split) {
                let message = format!("expected '{id}' in one list, got it in that of {} too", other.name());
                return Err(LanguageError::line(&path, at + 1, message));
            }
        }
    }
    let mut lines = content.lines().enumerate();
    let header: Vec<&str> = lines.next().map(|(_, line)| line.trim().split(',').collect()).unwrap_or_default();
    let column = |name: &str| {
        header.iter().position(|h| *h == name).ok_or_else(|| {
            let message =
                format!("expected columns source_path,start_frame,end_frame,new_name, got '{}'", header.join(","));
            LanguageError::line(&index, 1, message)
        })
    };
    let columns = [column("source_path")?, column("start_frame")?, column("end_frame")?, column("new_name")?];
    let mut items = Vec::new();
    for (at, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
        let bad = |message: String| LanguageError::line(&index, at + 1, message);
        let cells: Vec<&str> = line.trim().split(',').collect();
        let cell = |which: usize| {
            cells.get(columns[which]).copied().ok_or_else(|| bad(format!("expected all columns, got '{line}'")))
        };
        let frame = |which: usize| {
            let text = cell(which)?;
            text.parse::<u32>().map_err(|_| bad(format!("expected a frame number, got '{text}'")))
        };
        // It becomes a part of file names.
        let name = cell(3)?.trim();
        let stem = name.strip_suffix(".npy").unwrap_or(name);
        if stem.is_empty() || !stem.chars().all(|c| c.is_alphanumeric() || "-_".contains(c)) {
            return Err(bad(format!("expected letters and digits as new_name, got '{name}'")));
        }
        let frames = [frame(1)?, frame(2)?];
        if frames[0] >= frames[1] {
            return Err(bad(format!("expected start_frame < end_frame, got {} and {}", frames[0], frames[1])));
        }
        let name = cell(3)?;
        let id = name.strip_suffix(".npy").unwrap_or(name).to_string();
        let texts = |id: &str| -> Result<Vec<Text>, LanguageError> {
            let path = folder.join("texts").join(format!("{id}.txt"));
            if path.is_file() { parse_texts(&text_of(&path)?, &path) } else { Ok(Vec::new()) }
        };
        let split = splits.get(&id).copied();
        let (own, mirrored) = (texts(&id)?, texts(&format!("M{id}"))?);
        items.push(Item { source: cell(0)?.to_string(), frames, id, split, texts: own, mirrored_texts: mirrored });
    }
    Ok(items)
}

/// Reads the lines `caption#tokens#start#end` of a text file.
///
/// # Errors
/// [`LanguageError::Line`] for a line that is none.
pub fn parse_texts(content: &str, path: &Path) -> Result<Vec<Text>, LanguageError> {
    let mut texts = Vec::new();
    for (at, line) in content.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let bad = |message: String| LanguageError::line(path, at + 1, message);
        let cells: Vec<&str> = line.trim().split('#').collect();
        let [caption, tokens, start, end] = cells.as_slice() else {
            return Err(bad(format!("expected caption#tokens#start#end, got {} cells", cells.len())));
        };
        // The published files have 'nan' where nobody wrote a time.
        let time = |cell: &str| {
            let value: Result<f64, _> = cell.trim().parse();
            value.map(|v| if v.is_nan() { 0.0 } else { v }).map_err(|_| bad(format!("expected seconds, got '{cell}'")))
        };
        let (start, end) = (time(start)?, time(end)?);
        texts.push(Text {
            caption: caption.trim().to_string(),
            tokens: tokens.split_whitespace().map(String::from).collect(),
            stretch: (start != 0.0 || end != 0.0).then_some([start, end]),
        });
    }
    Ok(texts)
}

/// Makes the captioned clips of an item, its mirror image too, from the robot's clip of the whole file. A sentence with
/// times of its own makes a clip of its own. None without a split, without sentences, or shorter than a second.
///
/// # Errors
/// [`LanguageError::Motion`] for frames that the clip has not.
pub fn pieces(
    item: &Item,
    whole: &MotionClip,
    character: &Character,
) -> Result<Vec<(MotionClip, Entry)>, LanguageError> {
    let Some(split) = item.split else { return Ok(Vec::new()) };
    let [start, end] = item.stretch();
    let stretches: BTreeSet<[u64; 2]> = item
        .texts
        .iter()
        .map(|text| text.stretch.unwrap_or([0.0, end - start]))
        .map(|[a, b]| [(a * 1000.0).round() as u64, (b * 1000.0).round() as u64])
        .collect();
    let mut made = Vec::new();
    for [a, b] in stretches {
        let own = [a, b].map(|ms| ms as f64 / 1000.0);
        let (from, to) = (start + own[0], (start + own[1]).min(end).min(whole.seconds()));
        if to - from < 1.0 {
            continue;
        }
        let cut = trim(whole, Some(from), Some(to))?;
        let is_whole = own[0] == 0.0 && (own[1] - (end - start)).abs() < 1e-3;
        let of = |texts: &[Text]| -> Vec<String> {
            let fits = |text: &&Text| match text.stretch {
                None => is_whole,
                Some(stretch) => stretch.iter().zip(own).all(|(x, y)| (x - y).abs() < 1e-3),
            };
            texts.iter().filter(fits).map(|text| text.caption.clone()).filter(|text| !text.is_empty()).collect()
        };
        let captions = of(&item.texts);
        let mut mirrored = of(&item.mirrored_texts);
        if mirrored.is_empty() {
            mirrored = captions.iter().map(|text| mirror_caption(text)).collect();
        }
        let suffix = if is_whole { String::new() } else { format!("_{a}") };
        for (prefix, clip, captions) in [("", cut.clone(), captions), ("M", mirror(&cut, character)?, mirrored)] {
            if !captions.is_empty() {
                made.push(named(clip, format!("{prefix}{}{suffix}", item.id), captions, split, &item.source));
            }
        }
    }
    Ok(made)
}

fn named(mut clip: MotionClip, name: String, captions: Vec<String>, split: Split, source: &str) -> (MotionClip, Entry) {
    let seconds = clip.seconds();
    clip.name = name;
    clip.cyclic = false;
    clip.provenance.licence = LICENCE.into();
    clip.provenance.captions =
        captions.iter().map(|text| Caption { start: 0.0, end: seconds, text: text.clone() }).collect();
    let file = format!("{}/{}{}", split.name(), clip.name, container::EXTENSION);
    let entry = Entry { file, split, seconds, captions, source: source.into(), licence: LICENCE.into(), facts: None };
    (clip, entry)
}

fn text_of(path: &Path) -> Result<String, LanguageError> {
    std::fs::read_to_string(path).map_err(LanguageError::io(path))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn folder() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        std::fs::create_dir(folder.path().join("texts")).unwrap();
        let rows = "./pose_data/CMU/80/80_63_poses.npy,516,716,000004.npy\n./pose_data/MPI_HDM05/dg/x_poses.npy,0,60,000005.npy\n";
        write("index.csv", &format!("source_path,start_frame,end_frame,new_name\n{rows}"));
        write("train.txt", "000004\nM000004\n");
        write("val.txt", "000005\n");
        write("test.txt", "\n");
        write(
            "texts/000004.txt",
            "a man turns left.#a/DET man/NOUN turn/VERB left/NOUN#0.0#0.0\nhe waves#he/PRON wave/VERB#1.0#4.0\n",
        );
        write("texts/000005.txt", "someone kicks#someone/NOUN kick/VERB#nan#nan\n");
        folder
    }

    #[test]
    fn the_published_layout_is_read() {
        let folder = folder();
        let items = read(folder.path()).unwrap();
        assert_eq!(items[0].clip_names(), ["CMU_80_80_63", "80_63_poses", "80_63", "80_63_stageii"]);
        assert_eq!(items[1].clip_names()[0], "HDM05_dg_x");
        assert_eq!((items[0].stretch(), items[0].split), ([25.8, 35.8], Some(Split::Train)));
        assert_eq!(items[0].texts[0].stretch, None);
        assert_eq!(items[0].texts[1].stretch, Some([1.0, 4.0]));
        assert_eq!(items[0].texts[0].tokens.len(), 4);
        assert_eq!((items[1].stretch(), items[1].split), ([3.0, 6.0], Some(Split::Validation)));
        assert_eq!(items[1].texts[0].stretch, None);
    }

    #[test]
    fn what_is_wrong_is_told_with_file_and_line() {
        for (file, text, part) in [
            ("index.csv", "source,start_frame\n", "index.csv:1: expected columns"),
            (
                "index.csv",
                "source_path,start_frame,end_frame,new_name\na,5,5,b\n",
                "index.csv:2: expected start_frame <",
            ),
            ("index.csv", "source_path,start_frame,end_frame,new_name\na,x,5,b\n", "got 'x'"),
            (
                "index.csv",
                "source_path,start_frame,end_frame,new_name\na,1,5,../../b.npy\n",
                "index.csv:2: expected letters and digits as new_name, got '../../b.npy'",
            ),
            ("texts/000004.txt", "a#b#0.0\n", "000004.txt:1: expected caption#tokens#start#end"),
            ("test.txt", "000004\n", "test.txt:1: expected '000004' in one list"),
        ] {
            let folder = folder();
            std::fs::write(folder.path().join(file), text).unwrap();
            let message = read(folder.path()).unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
    }
}
