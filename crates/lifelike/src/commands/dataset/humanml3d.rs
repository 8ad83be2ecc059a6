//! `lifelike dataset humanml3d`: HumanML3D's sentences on a robot's motion.

use std::collections::BTreeMap;
use std::path::PathBuf;

use lifelike_language::humanml3d::{pieces, read};
use lifelike_language::{CaptionedSet, Entry, LanguageError};
use lifelike_motion::container;
use lifelike_robot::Robot;
use rayon::prelude::*;
use serde_json::json;

use super::{extent, extent_table, make_folders, rejected_table};
use crate::commands::clips;
use crate::error::CliError;
use crate::output::Output;
use crate::progress::Progress;

/// Make a captioned data set of HumanML3D's index, texts and splits, and a robot's clips of the same recordings.
///
/// HumanML3D says which frames of which AMASS file a sentence is of. The motion comes from clips of the robot:
/// retargeted from AMASS' .npz files, or from another source of the same recordings, named as AMASS' files are, such as
/// CMU's (80_63).
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  # AMASS/CMU/80/80_63_poses.npz and so on
  lifelike motion retarget AMASS --robot lima -o data/lima/amass
  lifelike dataset humanml3d HumanML3D data/lima/amass --robot lima -o data/lima/humanml3d
  lifelike dataset humanml3d HumanML3D data/lima/cmu_amc --robot lima -o data/lima/humanml3d_cmu

HumanML3D is the folder with index.csv, texts/, train.txt, val.txt and test.txt. AMASS is the folder with its
collections as unpacked (CMU, KIT, BMLrub, ...), the edition SMPL+H G or SMPL-X. Keep the names of its folders: they
identify the recordings. Clips must have the captured tempo.")]
pub struct Args {
    /// HumanML3D's folder.
    pub humanml3d: PathBuf,
    /// Clips of the robot: files, folders, patterns, or @list.txt.
    #[arg(required = true)]
    pub motions: Vec<PathBuf>,
    /// The robot: a name, or an MJCF or URDF file.
    #[arg(short, long, default_value = "lima")]
    pub robot: String,
    /// Folder of the data set.
    #[arg(short, long, value_parser = crate::destination::folder)]
    pub output: PathBuf,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let robot = Robot::load(&args.robot)?;
    let items = read(&args.humanml3d)?;
    let motions = clips::load(&args.motions, &robot)?;
    let by_name: BTreeMap<&str, _> = motions.iter().map(|clip| (clip.name.as_str(), clip)).collect();
    make_folders(&args.output)?;
    let progress = Progress::new(output, "cutting", items.len() as u64);
    let bar = progress.shared();
    let made: Vec<Result<Option<Vec<Entry>>, LanguageError>> = items
        .par_iter()
        .map(|item| {
            bar.inc(1);
            let names = item.clip_names();
            let Some(clip) = names.iter().find_map(|name| by_name.get(name.as_str())) else { return Ok(None) };
            let cut = pieces(item, clip, &robot.character)?;
            cut.iter().try_for_each(|(piece, entry)| container::write(&args.output.join(&entry.file), piece))?;
            Ok(Some(cut.into_iter().map(|(_, entry)| entry).collect()))
        })
        .collect();
    progress.finish();
    let mut set = CaptionedSet { folder: args.output.clone(), entries: Vec::new() };
    let (mut without_motion, mut without_text) = (0, 0);
    for entries in made {
        match entries? {
            None => without_motion += 1,
            Some(entries) if entries.is_empty() => without_text += 1,
            Some(entries) => set.entries.extend(entries),
        }
    }
    if set.entries.is_empty() {
        let message = format!(
            "expected clips named as the AMASS files of the index, got none of {} with sentences; \
             retarget the recordings first (lifelike motion retarget)",
            items.len()
        );
        return Err(CliError::Input(message));
    }
    set.write()?;
    let value = json!({ "splits": extent(&set), "without_motion": without_motion, "without_text": without_text });
    output.result(&value, || {
        let left_out = [("without motion", without_motion), ("without sentences, split or length", without_text)];
        let left_out = left_out.map(|(reason, count)| (reason.to_string(), count)).into();
        format!("{}\n{}", extent_table(&set), rejected_table(&left_out, items.len()))
    })
}
