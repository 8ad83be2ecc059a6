//! Folders of generated motion: clips as a robot plays them, and beside them the rows that a network made.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use lifelike_checkpoint::Checkpoint;
use lifelike_generation::critic::OtherRows;
use lifelike_generation::generator::Generated;
use lifelike_generation::representation::{FeatureMatrix, RepresentationSpec};
use lifelike_motion::{MotionClip, container};

use crate::commands::motion::container_in;
use crate::error::CliError;

/// In a folder of generated clips.
const ROWS: &str = "generated.rows.safetensors";
/// In that file.
const KEY: &str = "rows";

/// Writes clips and the rows they were made of.
pub fn write(folder: &Path, spec: &RepresentationSpec, made: &[(Generated, MotionClip)]) -> Result<(), CliError> {
    let mut file = Checkpoint::new();
    file.set_meta(KEY, spec)?;
    for (generated, clip) in made {
        container::write(&container_in(folder, &clip.name)?, clip)?;
        let rows = &generated.rows;
        file.put_f32(&clip.name, &[rows.n, rows.width], rows.rows.clone())?;
    }
    Ok(file.save(&folder.join(ROWS))?)
}

/// Reads the rows in those of these folders that have them, for clips by name. Clips without rows are left alone.
pub fn rows_of(
    folders: &[PathBuf],
    spec: &RepresentationSpec,
    clips: &[MotionClip],
) -> Result<Vec<OtherRows>, CliError> {
    let numbers: BTreeMap<&str, usize> = clips.iter().enumerate().map(|(i, clip)| (clip.name.as_str(), i)).collect();
    let mut all = Vec::new();
    for path in folders.iter().map(|folder| folder.join(ROWS)).filter(|path| path.is_file()) {
        let file = Checkpoint::load(&path)?;
        spec.expect(&format!("{}: rows", path.display()), &file.meta(KEY)?)?;
        for (name, entry) in file.entries() {
            let (Some(&sequence), &[n, width]) = (numbers.get(name.as_str()), entry.shape()) else { continue };
            let rows = FeatureMatrix::new(file.f32s(name, &[n, width])?, width)?;
            all.push(OtherRows { sequence, rows });
        }
    }
    all.sort_by_key(|other| other.sequence);
    Ok(all)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use lifelike_robot::{Robot, clips};

    #[test]
    fn rows_come_back_by_their_clips_names_and_are_no_motion_files() {
        let robot = Robot::load("lima").unwrap();
        let spec = RepresentationSpec::of(&robot.layout);
        let clip = clips::load_one(Path::new("builtin:walk"), &robot).unwrap();
        let rows = FeatureMatrix::from_clip(&clip, &spec).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let folders = [folder.path().to_path_buf()];
        write(folder.path(), &spec, &[(Generated { rows: rows.clone(), candidate: 0 }, clip)]).unwrap();
        let loaded = clips::load(&folders, &robot).unwrap();
        assert_eq!((loaded.clips.len(), loaded.left_out.len()), (1, 0));
        let found = rows_of(&folders, &spec, &loaded.clips).unwrap();
        assert_eq!((found.len(), found[0].sequence, &found[0].rows), (1, 0, &rows));
        assert!(rows_of(&folders, &spec, &[]).unwrap().is_empty());
        let other = RepresentationSpec::new(vec!["knee".into()]);
        assert!(rows_of(&folders, &other, &loaded.clips).unwrap_err().to_string().contains("knee"));
    }
}
