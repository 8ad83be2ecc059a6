//! Policies of other stacks: which, what they see in which order, and whether their normalizers agree.

use std::path::Path;

use serde_json::json;

use crate::commands::import;
use crate::error::CliError;
use crate::next::{self, NextCommand};
use crate::output::{Output, table};

/// Prints what a foreign policy is.
///
/// # Errors
/// It is none; its layout contradicts its normalizer.
pub fn inspect(path: &Path, output: &Output) -> Result<(), CliError> {
    let (robot, imported) = import::read(path, None, None)?;
    let spec = &imported.controller.header().observation;
    let steps = [NextCommand::new("import").word(path.display())];
    let parts: Vec<(String, usize, usize)> =
        spec.parts().into_iter().map(|part| (part.name, part.range.start, part.range.end)).collect();
    let found: Vec<String> = imported.contradictions.iter().map(ToString::to_string).collect();
    let value = json!({
        "kind": "foreign policy", "stack": imported.dialect.name(), "terms": imported.terms, "observation": parts,
        "robot": robot.name, "joints": spec.joints, "notes": imported.notes, "contradictions": found,
        "motion_seconds": imported.clip.as_ref().map(lifelike_motion::MotionClip::seconds), "next": next::texts(&steps),
    });
    output.result(&value, || {
        let rows = parts.iter().map(|(name, from, to)| vec![name.clone(), from.to_string(), to.to_string()]);
        let rows: Vec<Vec<String>> = rows.collect();
        let mut text = format!("{}: {}", path.display(), import::said(&imported));
        text += &format!("robot: {} ({} joints)\n", robot.name, robot.joints());
        if let Some(clip) = &imported.clip {
            text += &format!("motion inside: {:.1} s\n", clip.seconds());
        }
        text += &format!("\n{}\n", table(&["our observation", "from", "to"], &rows));
        if found.is_empty() {
            if !imported.notes.iter().any(|note| note.starts_with("the file has no normalizer")) {
                text += "nothing contradicts the normalizer's statistics\n";
            }
            return text + &next::lines(&steps);
        }
        found.iter().for_each(|line| text += &format!("contradiction: {line}\n"));
        text
    })?;
    match found.len() {
        0 => Ok(()),
        n => Err(CliError::Input(format!("{}: {n} contradictions between layout and normalizer", path.display()))),
    }
}
