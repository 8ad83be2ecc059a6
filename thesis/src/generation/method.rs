//! Generators to measure, by their names.

use std::collections::BTreeSet;
use std::path::PathBuf;

use lifelike_generation::generator::Generator;
use lifelike_robot::Robot;

use lifelike::CliError;
use lifelike::commands::best_of::By;
use lifelike::shipped::{self, Kind};

/// A generator's file as the command line names it.
#[derive(Debug, Clone, PartialEq)]
pub struct Named {
    name: String,
    file: PathBuf,
    strength: Option<f64>,
    projected: bool,
    best_of: Option<(usize, By)>,
}

impl Named {
    /// Returns the same generator as a row of the best of several motions.
    pub fn best_of(&self, count: usize, by: By) -> Self {
        let name = format!("{} best of {count} by {}", self.name, by.name());
        Self { name, best_of: Some((count, by)), ..self.clone() }
    }
}

/// A loaded generator.
#[derive(Debug)]
pub struct Method {
    /// Name in the tables, and of its folder.
    pub name: String,
    /// The generator.
    pub generator: Generator,
    /// Strength of the critic's guidance, where it guides.
    pub strength: Option<f64>,
    /// Flag: what physics makes of its motions takes their place.
    pub projected: bool,
    /// Number of motions of which one is kept, and who chooses.
    pub best_of: Option<(usize, By)>,
}

impl Method {
    /// Loads generators of a robot, whose names must differ.
    pub fn load_all<'a>(all: impl Iterator<Item = &'a Named>, robot: &Robot) -> Result<Vec<Self>, CliError> {
        let mut names = BTreeSet::new();
        let load = |named: &Named| {
            if !names.insert(named.name.clone()) {
                return Err(CliError::Usage(format!("expected every name once, got '{}' again", named.name)));
            }
            let generator = Generator::load(&shipped::file(&named.file, Kind::Generator)?)?;
            generator.check_robot(robot)?;
            let Named { name, strength, projected, best_of, .. } = named.clone();
            Ok(Self { name, generator, strength, projected, best_of })
        };
        all.map(load).collect()
    }

    /// Returns the longest motion that it makes (s).
    pub fn max_seconds(&self) -> f64 {
        self.generator.header().max_seconds
    }
}

/// Reads `NAME=FILE`.
pub fn named(text: &str) -> Result<Named, String> {
    let (name, file) = text.split_once('=').ok_or_else(|| format!("expected NAME=FILE, got '{text}'"))?;
    let plain = name.chars().all(|c| c.is_alphanumeric() || "-_+. ".contains(c)) && !name.starts_with('.');
    if name.trim().is_empty() || !plain || file.is_empty() {
        return Err(format!("expected NAME=FILE with a name of letters, digits, spaces and -_+., got '{text}'"));
    }
    Ok(Named { name: name.into(), file: file.into(), strength: None, projected: false, best_of: None })
}

/// Reads `NAME=FILE` of a generator whose motions are projected.
pub fn projected(text: &str) -> Result<Named, String> {
    Ok(Named { projected: true, ..named(text)? })
}

/// Reads `NAME=FILE@STRENGTH`.
pub fn guided(text: &str) -> Result<Named, String> {
    let (rest, strength) = text.rsplit_once('@').ok_or_else(|| format!("expected NAME=FILE@STRENGTH, got '{text}'"))?;
    let strength = strength.parse().map_err(|_| format!("expected a number after @, got '{strength}'"))?;
    Ok(Named { strength: Some(strength), ..named(rest)? })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn names_files_and_strengths_are_told_apart() {
        let found = guided("critic guidance=runs@2/a=b.safetensors@0.02").unwrap();
        let file = PathBuf::from("runs@2/a=b.safetensors");
        assert_eq!(
            found,
            Named { name: "critic guidance".into(), file, strength: Some(0.02), projected: false, best_of: None }
        );
        assert!(projected("a=b").unwrap().projected);
        assert_eq!(named("MDM=x").unwrap().best_of(8, By::Physics).name, "MDM best of 8 by physics");
        assert_eq!(named("MDM=x").unwrap().strength, None);
        for text in ["MDM", "=x", "../up=x", "a/b=x", "..=x", "MDM="] {
            assert!(named(text).unwrap_err().contains("expected NAME=FILE"), "{text}");
        }
        assert!(guided("a=b").unwrap_err().contains("NAME=FILE@STRENGTH"));
        assert!(guided("a=b@much").unwrap_err().contains("'much'"));
    }
}
