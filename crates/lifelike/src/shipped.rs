//! Pretrained networks that are part of the program, by name: `lima`, `g1`, `humanoid`, `toddlerbot`.
//!
//! A network is found by its name, or for a robot by the robot's joints (never by the name in the robot's file).
//! It is written to the cache once, because everything else reads networks from files.

use std::path::{Path, PathBuf};

use lifelike_checkpoint::Checkpoint;
use lifelike_robot::nearest::hint;
use lifelike_robot::{ControllerFile, Robot};
use sha2::{Digest, Sha256};

use crate::error::CliError;
use crate::folders;
use crate::next::NextCommand;

/// Kind of a network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Kind {
    Controller,
    Generator,
    Critic,
    Evaluator,
    Prior,
    Spline,
}

impl Kind {
    /// Returns the kind as in the names of files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Controller => "controller",
            Self::Generator => "generator",
            Self::Critic => "critic",
            Self::Evaluator => "evaluator",
            Self::Prior => "prior",
            Self::Spline => "spline",
        }
    }
}

/// A network that is part of the program.
#[derive(Debug, Clone, Copy)]
pub struct Shipped {
    /// Name of its robot, by which it is asked for.
    pub name: &'static str,
    /// Kind.
    pub kind: Kind,
    /// Name of its file in `assets/`; without its extension it is another name.
    pub file: &'static str,
    /// Terms that restrict its use.
    pub terms: Option<&'static str>,
    /// Content.
    pub bytes: &'static [u8],
}

const NON_COMMERCIAL: Option<&str> = Some("trained on motion under CC BY-NC 4.0: not for commercial use");

macro_rules! shipped {
    ($name:literal, $kind:ident, $file:literal, $terms:expr) => {
        Shipped {
            name: $name,
            kind: Kind::$kind,
            file: $file,
            terms: $terms,
            bytes: include_bytes!(concat!("../assets/", $file)),
        }
    };
}

/// The best of each kind for each robot.
static ALL: &[Shipped] = &[
    shipped!("lima", Controller, "lima-path.controller.safetensors", None),
    shipped!("humanoid", Controller, "humanoid.controller.safetensors", None),
    shipped!("g1", Controller, "g1-nc.controller.safetensors", NON_COMMERCIAL),
    // With a G1's own sensors, for other stacks; the best by its joints is the one above.
    shipped!("g1", Controller, "g1-deploy.controller.safetensors", None),
    shipped!("toddlerbot", Controller, "toddlerbot_active.controller.safetensors", None),
    // With a robot's own sensors, for `lifelike run`.
    shipped!("lima", Controller, "lima-blind.controller.safetensors", None),
    shipped!("lima", Generator, "lima.generator.safetensors", None),
    shipped!("g1", Generator, "g1.generator.safetensors", None),
    shipped!("lima", Critic, "lima.critic.safetensors", None),
    shipped!("g1", Critic, "g1.critic.safetensors", None),
    shipped!("lima", Evaluator, "lima.evaluator.safetensors", None),
    shipped!("lima", Prior, "lima.prior.safetensors", None),
    shipped!("lima", Spline, "lima.spline.safetensors", None),
];

/// Returns all of them.
pub fn all() -> impl Iterator<Item = &'static Shipped> {
    ALL.iter()
}

/// Returns the network of this kind and name: the robot's (`lima`), or the file's (`lima-path`, `lima-path.controller`).
pub fn named(name: &Path, kind: Kind) -> Option<&'static Shipped> {
    let name = name.to_str()?;
    all().filter(|network| network.kind == kind).find(|network| {
        let whole = network.file.trim_end_matches(".safetensors");
        [network.name, network.stem(), whole].contains(&name) || name == format!("{}.{}", network.name, kind.name())
    })
}

/// Returns the network of a full name such as `lima.generator` or `g1-nc.controller`.
pub fn with_full_name(name: &Path) -> Option<&'static Shipped> {
    let kind = name.extension()?.to_str()?;
    all().find(|network| network.kind.name() == kind).and_then(|network| named(name, network.kind))
}

/// Returns the file of a network: of the path itself, else of the network that has this name.
///
/// # Errors
/// [`CliError::Input`] where there is neither, with the names of this kind; [`CliError::Failed`] where it cannot be
/// written.
pub fn file(given: &Path, kind: Kind) -> Result<PathBuf, CliError> {
    if given.exists() {
        return Ok(given.to_path_buf());
    }
    match named(given, kind) {
        Some(network) => network.file(),
        None => {
            let text = given.display().to_string();
            let names: Vec<&str> = all().filter(|network| network.kind == kind).map(|network| network.name).collect();
            let near = hint(&text, names.iter().copied());
            let kind = kind.name();
            Err(CliError::Input(format!(
                "{text}: expected a file, or the name of a {kind} that comes with the program ({}), got neither{near}",
                names.join(", ")
            )))
        }
    }
}

impl Shipped {
    /// Returns its file in the cache, written there where it is not yet, and warns of its terms.
    ///
    /// # Errors
    /// [`CliError::Failed`] where it cannot be written.
    pub fn file(&self) -> Result<PathBuf, CliError> {
        if let Some(terms) = self.terms {
            tracing::warn!("{} '{}' was {terms}", self.kind.name(), self.name);
        }
        let digest: String = Sha256::digest(self.bytes).iter().map(|b| format!("{b:02x}")).collect();
        let folder = folders::cache().join("networks").join(&digest[..16]);
        self.write(&folder).or_else(|_| self.write(&std::env::temp_dir().join("lifelike-networks").join(&digest[..16])))
    }

    fn write(&self, folder: &Path) -> Result<PathBuf, CliError> {
        let path = folder.join(self.file);
        if std::fs::read(&path).is_ok_and(|bytes| bytes == self.bytes) {
            return Ok(path);
        }
        std::fs::create_dir_all(folder).map_err(CliError::write(folder))?;
        crate::output::write(&path, self.bytes)?;
        Ok(path)
    }

    /// Returns the name of its file without its kind, such as `lima-blind`.
    pub fn stem(&self) -> &'static str {
        self.file.trim_end_matches(".safetensors").trim_end_matches(self.kind.name()).trim_end_matches('.')
    }

    /// Returns whether it is a controller for the robot's joints, gains and limits.
    pub fn fits(&self, robot: &Robot) -> bool {
        self.controller().is_ok_and(|file| file.check(robot).is_ok())
    }

    /// Returns the controller that it is.
    fn controller(&self) -> Result<ControllerFile, CliError> {
        let checkpoint = Checkpoint::from_bytes(self.bytes, Path::new(self.file))?;
        Ok(ControllerFile::from_checkpoint(&checkpoint, self.file)?)
    }
}

/// Returns the name under which networks of a robot with these joints come with the program.
pub fn name_of(robot: &Robot) -> Option<&'static str> {
    let controllers = all().filter(|network| network.kind == Kind::Controller);
    let fits = |network: &&Shipped| {
        let joints = network.controller().ok().map(|file| file.header().observation.joints.clone());
        joints.is_some_and(|joints| joints == robot.layout.joints)
    };
    controllers.into_iter().find(fits).map(|network| network.name)
}

/// Returns the network of this kind for a robot, by its joints.
pub fn of_robot(robot: &Robot, kind: Kind) -> Option<&'static Shipped> {
    name_of(robot).and_then(|name| named(Path::new(name), kind))
}

/// Returns whether a controller for the robot comes with the program.
pub fn has_controller(robot: &Robot) -> bool {
    fitting_controller(robot).is_ok()
}

/// Returns the controller for the robot's joints, gains and limits, or the reason that there is none.
fn fitting_controller(robot: &Robot) -> Result<&'static Shipped, String> {
    let network = of_robot(robot, Kind::Controller).ok_or("none has its joints")?;
    let file = network.controller().map_err(|error| error.to_string())?;
    let fits = file.robot().check(robot);
    fits.map(|()| network).map_err(|mismatch| format!("'{}' has its joints, but: {mismatch}", network.name))
}

/// Returns the file of a robot's controller: the given one, or the one that comes with the program.
///
/// # Errors
/// [`CliError::Input`] where there is none for the robot's joints, gains and limits, with the commands that make one
/// and use it. `again` is the beginning of the second.
pub fn controller(
    given: Option<&Path>,
    robot: &Robot,
    robot_file: &str,
    again: impl FnOnce() -> NextCommand,
) -> Result<PathBuf, CliError> {
    if let Some(given) = given {
        return file(given, Kind::Controller);
    }
    let reason = match fitting_controller(robot) {
        Ok(network) => return network.file(),
        Err(reason) => reason,
    };
    let names: Vec<&str> = all().filter(|n| n.kind == Kind::Controller).map(|n| n.name).collect();
    let train = NextCommand::new("train tracker").word("--plan").word("track").word("--robot").word(robot_file);
    let run = "runs/own";
    Err(CliError::Input(format!(
        "no pretrained controller for '{}': of those that come with the program ({}) {reason}. Train one and name it:\n\
         \x20 {}\n\
         \x20 {}",
        robot.name,
        names.join(", "),
        train.word("-o").word(run).word("budget.minutes=5"),
        again().robot(robot_file).word("--policy").word(run)
    )))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_network_has_the_names_of_its_robot_and_of_its_file() {
        for name in ["lima", "lima-path", "lima-path.controller", "lima.controller"] {
            assert_eq!(named(Path::new(name), Kind::Controller).unwrap().file, "lima-path.controller.safetensors");
        }
        assert_eq!(with_full_name(Path::new("g1-nc.controller")).unwrap().name, "g1");
        assert!(with_full_name(Path::new("lima")).is_none() && named(Path::new("lim"), Kind::Controller).is_none());
        let told = file(Path::new("limma"), Kind::Controller).unwrap_err().to_string();
        assert!(told.contains("limma") && told.contains("did you mean 'lima'?"), "{told}");
    }

    #[test]
    fn every_network_of_the_folder_that_is_published_is_in_the_program() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
        for network in all() {
            assert_eq!(std::fs::read(folder.join(network.file)).unwrap(), network.bytes, "{}", network.file);
        }
    }

    #[test]
    fn robots_are_told_by_their_joints_and_not_by_their_names() {
        let mut robot = Robot::load("lima").unwrap();
        robot.name = "humanoid".into();
        assert_eq!(name_of(&robot), Some("lima"));
        robot.layout.joints.swap(0, 1);
        assert_eq!(name_of(&robot), None);
    }
}
