//! Paths in plans: located from the plan's file, and asked for before anything starts.

use std::path::{Path, PathBuf};

use lifelike_robot::load::NAMES;
use toml::{Table, Value};

use crate::error::CliError;
use crate::shipped::{self, Kind};
use lifelike_robot::clips::is_builtin;

/// Keys whose values are motion: files, folders, patterns, `@list.txt`, built-in clips.
const MOTION: [&str; 4] = ["clips", "generated", "validation", "test"];
/// Keys whose values are trained networks.
const NETWORKS: [&str; 6] = ["prior", "init", "controller", "generator", "critic", POLICY];
/// Key of a list of trained networks, and what the file of each is under.
const TEACHERS: &str = "teachers";
const POLICY: &str = "policy";
/// Key whose value is a folder of captioned clips.
const DATASET: &str = "dataset";

/// Returns a plan's path as the working directory has it: in the plan's folder, in the one above, or as it is written; the
/// first at which there is something.
pub fn located(path: &Path, folder: &Path) -> PathBuf {
    let near = [Some(folder), folder.parent()].into_iter().flatten().map(|folder| folder.join(path));
    near.into_iter().find(|candidate| exists(candidate)).unwrap_or_else(|| path.to_path_buf())
}

/// Locates all paths of a plan whose file is in this folder.
pub(super) fn locate_all(tree: &mut Table, folder: &Path) {
    for key in MOTION {
        let texts = tree.get_mut(key).and_then(Value::as_array_mut).into_iter().flatten();
        for text in texts.filter_map(text_mut).filter(|text| !is_builtin(Path::new(text.as_str()))) {
            *text = match text.strip_prefix('@') {
                Some(list) => format!("@{}", located(Path::new(list), folder).display()),
                None => located(Path::new(text.as_str()), folder).display().to_string(),
            };
        }
    }
    let locate = |text: &mut String| *text = located(Path::new(text.as_str()), folder).display().to_string();
    for key in ["robot", DATASET].into_iter().chain(NETWORKS) {
        tree.get_mut(key).and_then(text_mut).filter(|text| !NAMES.contains(&text.as_str())).map(locate);
    }
    let teachers = tree.get_mut(TEACHERS).and_then(Value::as_array_mut).into_iter().flatten();
    teachers.filter_map(|teacher| teacher.get_mut(POLICY).and_then(text_mut)).for_each(locate);
}

/// Puts the files of networks that come with the program in the place of their names.
///
/// # Errors
/// As [`shipped::Shipped::file`].
pub(super) fn name_networks(tree: &mut Table) -> Result<(), CliError> {
    for key in NETWORKS {
        if let Some(text) = tree.get_mut(key).and_then(text_mut) {
            put_file(text, kind_of(key))?;
        }
    }
    let teachers = tree.get_mut(TEACHERS).and_then(Value::as_array_mut).into_iter().flatten();
    let mut policies = teachers.filter_map(|teacher| teacher.get_mut(POLICY).and_then(text_mut));
    policies.try_for_each(|text| put_file(text, Kind::Controller))
}

fn put_file(text: &mut String, kind: Kind) -> Result<(), CliError> {
    let path = Path::new(text.as_str());
    if let Some(network) = shipped::named(path, kind).filter(|_| !path.exists()) {
        *text = network.file()?.display().to_string();
    }
    Ok(())
}

/// Returns the kind of network that a key of a plan names.
fn kind_of(key: &str) -> Kind {
    match key {
        "prior" => Kind::Prior,
        "generator" => Kind::Generator,
        "critic" => Kind::Critic,
        _ => Kind::Controller,
    }
}

/// Checks that what a plan names is there.
///
/// # Errors
/// [`CliError::Input`] with the first that is not, and how to get it or do without.
pub(super) fn check(tree: &Table, source: &str) -> Result<(), CliError> {
    let robot = tree.get("robot").and_then(Value::as_str).unwrap_or("lima");
    let mut missing = Vec::new();
    for key in MOTION {
        let texts = tree.get(key).and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_str);
        missing.extend(texts.filter(|text| !has_motion(text)).map(|text| (key, text)));
    }
    if let Some((key, first)) = missing.first() {
        let others = match missing.len() - 1 {
            0 => String::new(),
            1 => " (and at 1 other)".into(),
            others => format!(" (and at {others} others)"),
        };
        let without: Vec<String> = MOTION
            .iter()
            .filter(|key| missing.iter().any(|(k, _)| k == *key))
            .map(|key| if *key == "clips" { "'clips=[\"builtin\"]'".into() } else { format!("'{key}=[]'") })
            .collect();
        let folder = fixed(Path::new(first.trim_start_matches('@')));
        return Err(CliError::Input(format!(
            "{source}: {key}: expected motion at '{first}', got nothing there{others}. Captured motion does not \
             come with the program. Use its own clips:\n\
             \x20 {}\n\
             or make clips of yours (BVH, ASF/AMC, DeepMimic; the plan's first lines say of which) by\n\
             \x20 lifelike motion retarget CAPTURES --robot {robot} -o {}",
            without.join(" "),
            if folder.as_os_str().is_empty() { Path::new("data") } else { folder.as_path() }.display(),
        )));
    }
    let teachers = tree.get(TEACHERS).and_then(Value::as_array).into_iter().flatten();
    let teachers = teachers.filter_map(|teacher| Some((TEACHERS, teacher.get(POLICY)?.as_str()?)));
    let networks = NETWORKS.iter().filter_map(|key| Some((*key, tree.get(*key)?.as_str()?)));
    if let Some((key, file)) = networks.chain(teachers).find(|(_, file)| !Path::new(file).exists()) {
        return Err(CliError::Input(format!(
            "{source}: {key}: expected a file or folder of a training, got nothing at '{file}'; train it first, as \
             the plan's comments say, or name another with {key}=..."
        )));
    }
    if let Some(folder) = tree.get(DATASET).and_then(Value::as_str).filter(|folder| !Path::new(folder).is_dir()) {
        return Err(CliError::Input(format!(
            "{source}: {DATASET}: expected a folder of captioned clips, got nothing at '{folder}'; name another with \
             {DATASET}=FOLDER"
        )));
    }
    Ok(())
}

fn text_mut(value: &mut Value) -> Option<&mut String> {
    match value {
        Value::String(text) => Some(text),
        _ => None,
    }
}

fn has_motion(text: &str) -> bool {
    is_builtin(Path::new(text)) || exists(Path::new(text.strip_prefix('@').unwrap_or(text)))
}

/// Returns whether there is a file or folder, or of a pattern the folder that it begins in.
fn exists(path: &Path) -> bool {
    let fixed = fixed(path);
    if fixed == path { path.exists() } else { fixed.as_os_str().is_empty() || fixed.is_dir() }
}

/// Returns the path up to the first component with a wildcard.
fn fixed(path: &Path) -> PathBuf {
    path.components().take_while(|part| !part.as_os_str().to_string_lossy().contains(['*', '?', '['])).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_plan_means_the_same_from_any_folder() {
        let home = tempfile::tempdir().unwrap();
        let make = |path: &str| std::fs::create_dir_all(home.path().join(path)).unwrap();
        make("plans/near");
        make("data/lima/keys");
        let folder = home.path().join("plans");
        let text = "robot = \"humanoid\"\nclips = [\"builtin\", \"near\", \"data/lima/k*\", \"none/here\"]\n[prior]\nbatch = 2\n";
        let mut tree: Table = text.parse().unwrap();
        locate_all(&mut tree, &folder);
        let clips: Vec<String> =
            tree["clips"].as_array().unwrap().iter().map(|v| v.as_str().unwrap().to_string()).collect();
        let at = |path: &str| home.path().join(path).display().to_string();
        assert_eq!(clips, ["builtin".into(), at("plans/near"), at("data/lima/k*"), "none/here".to_string()]);
        assert_eq!(tree["robot"].as_str(), Some("humanoid"));
        let mut tree: Table = "[[teachers]]\npolicy = \"near\"\nclips = [\"near\"]".parse().unwrap();
        locate_all(&mut tree, &folder);
        assert_eq!(tree["teachers"][0]["policy"].as_str(), Some(at("plans/near").as_str()));
        assert_eq!(tree["teachers"][0]["clips"][0].as_str(), Some("near"), "a clip's name is no path");
    }

    #[test]
    fn missing_motion_is_told_with_what_to_do() {
        let tree: Table =
            "robot = \"my.xml\"\nclips = [\"none/a*.bvh\", \"builtin\"]\ntest = [\"@none.txt\"]".parse().unwrap();
        let error = check(&tree, "plan 'x'").unwrap_err().to_string();
        for part in [
            "plan 'x': clips",
            "'none/a*.bvh'",
            "at 1 other)",
            "--robot my.xml -o none",
            "'clips=[\"builtin\"]' 'test=[]'",
        ] {
            assert!(error.contains(part), "{part}: {error}");
        }
        assert!(check(&"clips = [\"builtin:walk\"]".parse().unwrap(), "").is_ok());
        let error = check(&"prior = \"none/p\"".parse().unwrap(), "x").unwrap_err().to_string();
        assert!(error.contains("prior=..."), "{error}");
        let error = check(&"[[teachers]]\npolicy = \"none/p\"".parse().unwrap(), "x").unwrap_err().to_string();
        assert!(error.contains("x: teachers: ") && error.contains("'none/p'"), "{error}");
    }
}
