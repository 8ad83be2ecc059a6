//! Robots of other people.

use std::fs;
use std::path::{Path, PathBuf};

use crate::at;
use crate::wheel::{Wheel, unpack, verify};

/// A robot, or several of one origin.
struct Robots {
    name: &'static str,
    wheel: Wheel,
    /// Folder of the wheel that holds them.
    inside: &'static str,
    /// Models, with their digests: what is there already may be an older or edited one, and gates would measure that.
    models: &'static [(&'static str, &'static str)],
    /// Folder of the meshes.
    meshes: Option<&'static str>,
    /// Name of the profile (what a model cannot say: motors and gains), which the caller brings.
    profile: Option<&'static str>,
}

const ROBOTS: [Robots; 2] = [
    // Unitree G1 as MJCF with meshes, as mjlab ships it (BSD-3-Clause, Unitree Robotics).
    Robots {
        name: "unitree_g1",
        wheel: Wheel {
            requirement: "mjlab==1.6.0",
            selection: &["--python-version", "3.12"],
            sha256: "03d003854e2f44c48330c6dcf4c2253ff7641bb569747846825a21b9efa8540b",
        },
        inside: "mjlab/asset_zoo/robots/unitree_g1/xmls/",
        models: &[("g1.xml", "febdcbeffbbf84051556ae41a5ac1b43fb479a5d76bdb3f54824dbc2721c20aa")],
        meshes: Some("assets"),
        profile: Some("g1.toml"),
    },
    // The humanoids of dm_control's suite (Apache-2.0, DeepMind): shapes only, no meshes.
    Robots {
        name: "dm_control",
        wheel: Wheel {
            requirement: "dm_control==1.0.34",
            selection: &["--python-version", "3.12"],
            sha256: "0ecb93d28c43f7dd1b20182df2bcd3caea413d6e945669470649b49fc13cc1c5",
        },
        inside: "dm_control/suite/",
        models: &[
            ("humanoid.xml", "3aea178a6030ad10fde4889a0806085ee5d2cf69c4b5996577a7f7f8cfa39451"),
            ("humanoid_CMU.xml", "a3c1950d663225d85e2d6cf003ce1d77913877e791dba09307a125ae4f4fc5ca"),
        ],
        meshes: None,
        profile: None,
    },
];

/// Names of all of them.
pub const NAMES: [&str; 2] = ["unitree_g1", "dm_control"];

/// Makes sure that a robot is in `folder`, in a folder of its own name, and returns its models. `profile` is the text of the
/// profile to put beside a model that needs one.
///
/// # Errors
/// For a name that we do not know, a model that is there and is another one, and what [`Wheel::download`] and [`unpack`]
/// fail with.
pub fn robot(name: &str, meshes: bool, folder: &Path, profile: &str) -> Result<Vec<PathBuf>, String> {
    let known = ROBOTS.iter().find(|robots| robots.name == name);
    let robots = known.ok_or_else(|| format!("expected a robot, one of: {}; got: {name}", NAMES.join(", ")))?;
    let folder = folder.join(name);
    robots.ensure(meshes, &folder, profile)?;
    Ok(robots.models.iter().map(|(file, _)| folder.join(file)).collect())
}

impl Robots {
    fn ensure(&self, meshes: bool, folder: &Path, profile: &str) -> Result<(), String> {
        let models = self.models.iter().all(|(file, _)| folder.join(file).is_file());
        let meshes_missing = meshes && self.meshes.is_some_and(|name| !folder.join(name).is_dir());
        if models {
            // An edited model is somebody's work: it is not overwritten.
            self.verify(folder).map_err(|e| format!("{e}; move it away and fetch it again"))?;
        }
        if models && !meshes_missing {
            eprintln!("{} is there already", folder.display());
        } else {
            let wheel = self.wheel.download()?;
            let count = unpack(&wheel, folder, |name| {
                let file = name.strip_prefix(self.inside)?;
                let model = self.models.iter().any(|(model, _)| *model == file);
                let mesh = meshes && self.meshes.is_some_and(|folder| Path::new(file).starts_with(folder));
                (model || mesh).then(|| PathBuf::from(file))
            })?;
            self.verify(folder)?;
            eprintln!("{count} files are in {}", folder.display());
        }
        let Some(file) = self.profile else { return Ok(()) };
        let path = folder.join(file);
        fs::write(&path, profile).map_err(at(&path))
    }

    fn verify(&self, folder: &Path) -> Result<(), String> {
        self.models.iter().try_for_each(|(file, sha256)| {
            let path = folder.join(file);
            verify(&path.display().to_string(), &fs::read(&path).map_err(at(&path))?, sha256)
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn an_unknown_robot_is_refused_with_the_known_ones() {
        let message = robot("atlas", false, Path::new("nowhere"), "").unwrap_err();
        assert!(message.contains("unitree_g1, dm_control") && message.ends_with("got: atlas"), "{message}");
        assert_eq!(ROBOTS.map(|robots| robots.name), NAMES);
    }

    #[test]
    fn another_model_is_refused_by_its_path() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("g1.xml"), "<mujoco/>").unwrap();
        let message = ROBOTS[0].verify(folder.path()).unwrap_err();
        assert!(message.contains("g1.xml") && message.contains("SHA-256"), "{message}");
    }
}
