//! `lifelike dataset captures`: captured motion with its descriptions.

use std::collections::BTreeMap;
use std::path::PathBuf;

use lifelike_language::captures::{Options, is_commercial, pieces, table_name};
use lifelike_language::{CaptionedSet, Entry, LanguageError};
use lifelike_motion::container;
use lifelike_motion::formats::CaptionTable;
use lifelike_robot::Robot;
use rayon::prelude::*;
use serde_json::json;

use super::{extent, extent_table, make_folders, rejected_table};
use crate::commands::clips;
use crate::error::CliError;
use crate::output::Output;
use crate::progress::Progress;

/// Make a captioned data set of captured motion: cut into pieces, mirrored with left and right exchanged, split by
/// subject.
///
/// Captions are those of the clips (`motion retarget --captions`) or of a table; DeepMimic's clips are described by
/// their names. A clip of which nothing is said is left out. Bandai's motion is for non-commercial use only: it is
/// refused unless asked for, and every clip of it is marked.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike dataset captures data/lima/cmu_amc data/lima/cmu_bvh_daz --captions cmu_clips.tsv \\
      -o data/lima/captures
  lifelike dataset captures data/lima/bandai --captions bandai_clips.tsv \\
      --non-commercial -o data/lima/bandai_captions
  lifelike dataset captures data/lima/cmu_amc data/lima/bandai --captions cmu_clips.tsv \\
      --captions bandai_clips.tsv \\
      --non-commercial -o data/lima/captures

The test split is that of the tracker: CMU subjects 02, 07, 10 and 12.")]
pub struct Args {
    /// Clips of the robot: files, folders, patterns, or @list.txt.
    #[arg(required = true)]
    pub motions: Vec<PathBuf>,
    /// Layout of the motion.
    #[command(flatten)]
    pub layout: clips::LayoutArgument,
    /// The robot: a name, or an MJCF or URDF file.
    #[arg(short, long, default_value = "lima")]
    pub robot: String,
    /// Folder of the data set.
    #[arg(short, long, value_parser = crate::destination::folder)]
    pub output: PathBuf,
    /// A table of captions (tab-separated) instead of the clips' own; given more than once, a clip takes those of the first
    /// that knows it.
    #[arg(long)]
    pub captions: Vec<PathBuf>,
    /// CMU subjects whose clips are for testing only.
    #[arg(long, value_delimiter = ',', default_value = "02,07,10,12")]
    pub test_subjects: Vec<String>,
    /// Take motion for non-commercial use too; whatever is trained on it must not be sold.
    #[arg(long)]
    pub non_commercial: bool,
    /// Without mirror images.
    #[arg(long)]
    pub no_mirror: bool,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let robot = Robot::load(&args.robot)?;
    let tables = args.captions.iter().map(|file| CaptionTable::load(file)).collect::<Result<Vec<_>, _>>()?;
    let motions = clips::load_as(&args.motions, args.layout, &robot)?;
    let options =
        Options { test_subjects: args.test_subjects.clone(), mirrored: !args.no_mirror, ..Options::default() };
    make_folders(&args.output)?;
    let progress = Progress::new(output, "cutting", motions.len() as u64);
    let bar = progress.shared();
    let made: Vec<Result<Result<Vec<Entry>, &str>, LanguageError>> = motions
        .par_iter()
        .map(|clip| {
            bar.inc(1);
            if !args.non_commercial && !is_commercial(clip) {
                return Ok(Err("for non-commercial use only"));
            }
            let mut found = tables.iter().map(|table| table.find(&table_name(clip), clip.seconds()));
            let found = found.find(|captions| !captions.is_empty()).unwrap_or_default();
            let cut = pieces(clip, &found, &robot.character, &options)?;
            cut.iter().try_for_each(|(piece, entry)| container::write(&args.output.join(&entry.file), piece))?;
            Ok(if cut.is_empty() {
                Err("without caption, or too short")
            } else {
                Ok(cut.into_iter().map(|(_, entry)| entry).collect())
            })
        })
        .collect();
    progress.finish();
    let mut set = CaptionedSet { folder: args.output.clone(), entries: Vec::new() };
    let mut left_out: BTreeMap<String, usize> = BTreeMap::new();
    for entries in made {
        match entries? {
            Ok(entries) => set.entries.extend(entries),
            Err(reason) => *left_out.entry(reason.into()).or_default() += 1,
        }
    }
    if set.entries.is_empty() {
        let message = format!(
            "expected clips with captions (motion retarget --captions, or --captions here), got none of {}\n{}",
            motions.len(),
            rejected_table(&left_out, motions.len())
        );
        return Err(CliError::Input(message));
    }
    set.write()?;
    let non_commercial = set.entries.iter().filter(|entry| entry.licence.contains("non-commercial")).count();
    let value = json!({ "splits": extent(&set), "left_out": left_out, "non_commercial": non_commercial });
    output.result(&value, || {
        format!(
            "{}\n{}\npieces for non-commercial use only: {non_commercial}\n",
            extent_table(&set),
            rejected_table(&left_out, motions.len())
        )
    })
}
