//! Names of AMASS' recordings, the same ones in all editions.
//!
//! A file's own name is not enough: `0005_walking1_poses.npz` is there a hundred times, for each person of BMLrub. The
//! editions differ in the collections' names, in the file's ending and in spaces.

use std::path::{Component, Path};

/// Collections as the newest edition names them, and their names in older ones and in HumanML3D's index.
const COLLECTIONS: [&[&str]; 24] = [
    &["ACCAD"],
    &["BMLhandball"],
    &["BMLmovi"],
    &["BMLrub", "BioMotionLab_NTroje"],
    &["CMU"],
    &["CNRS"],
    &["DanceDB"],
    &["DFaust", "DFaust_67", "DFaust67"],
    &["EKUT"],
    &["EyesJapanDataset", "Eyes_Japan_Dataset"],
    &["GRAB"],
    &["HDM05", "MPI_HDM05"],
    &["HUMAN4D"],
    &["HumanEva"],
    &["KIT"],
    &["MoSh", "MPI_mosh"],
    &["PosePrior", "MPI_Limits"],
    &["SFU"],
    &["SOMA"],
    &["SSM", "SSM_synced"],
    &["TCDHands", "TCD_handMocap"],
    &["TotalCapture"],
    &["Transitions", "Transitions_mocap"],
    &["WEIZMANN"],
];
/// Ends of the names of motion files, before their extension.
const ENDINGS: [&str; 2] = ["_poses", "_stageii"];

/// Returns a recording's name, `CMU_80_80_63` for `.../CMU/80/80_63_poses.npz`: its collection, person and take; none of
/// a path whose folders are not AMASS'. Whatever the edition, one recording has one name.
pub fn recording(path: &Path) -> Option<String> {
    let stem = path.file_stem()?.to_string_lossy();
    let take = ENDINGS.iter().find_map(|ending| stem.strip_suffix(ending)).unwrap_or(&stem);
    let mut folders = path.parent()?.components().rev().filter_map(|component| match component {
        Component::Normal(name) => Some(name.to_string_lossy()),
        _ => None,
    });
    let (person, folder) = (folders.next()?, folders.next()?);
    let names = COLLECTIONS.iter().find(|names| names.iter().any(|name| name.eq_ignore_ascii_case(&folder)))?;
    Some(format!("{}_{person}_{take}", names.first()?).replace(' ', "_"))
}
