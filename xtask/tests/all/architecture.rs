//! The house of ARCHITECTURE.md, held up by a test: who may import whom, who may write `unsafe`, how long a file may be.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use crate::sources::rust_files;

/// Floors: a crate may import crates on LOWER floors only.
const FLOORS: [(&str, u32); 28] = [
    ("cdr", 0),
    ("character", 0),
    ("checkpoint", 0),
    ("fetch", 0),
    ("simd", 0),
    ("dense", 1),
    ("motion", 1),
    ("robot", 2),
    ("report", 2),
    ("sim", 3),
    ("capi", 3),
    ("interop", 3),
    ("nn", 3),
    ("runtime", 3),
    ("train", 4),
    ("evaluation", 4),
    ("unitree", 4),
    ("dynamixel", 4),
    ("dds", 5),
    ("language", 5),
    ("representation", 5),
    ("tracking", 6),
    ("generation", 6),
    ("augmentation", 6),
    ("studio", 7),
    ("lifelike", 8),
    ("python", 9),
    ("thesis", 9),
];

/// Crates that stand on a floor for their use, but must know little of what is below them.
const ONLY: [(&str, &[&str]); 13] = [
    ("dds", &["cdr", "robot", "runtime", "unitree"]),
    ("unitree", &["cdr", "robot", "runtime"]),
    ("dynamixel", &["robot", "runtime"]),
    ("runtime", &["cdr", "character", "checkpoint", "motion", "robot"]),
    (
        "studio",
        &[
            "character",
            "checkpoint",
            "evaluation",
            "generation",
            "language",
            "motion",
            "report",
            "representation",
            "robot",
            "sim",
        ],
    ),
    ("capi", &["character", "motion", "robot"]),
    ("interop", &["character", "checkpoint", "motion", "robot"]),
    ("augmentation", &["cdr", "character", "checkpoint", "motion", "nn", "report", "robot", "sim", "train"]),
    ("language", &["character", "checkpoint", "motion", "nn", "train"]),
    ("nn", &["checkpoint", "dense", "simd"]),
    ("train", &["checkpoint", "dense", "nn", "report", "simd"]),
    ("report", &["character", "checkpoint", "motion"]),
    ("evaluation", &["cdr", "character", "checkpoint", "motion", "report", "robot", "sim"]),
];

/// The package of the thesis' tables: beside `crates`, and imported by nobody.
const THESIS: &str = "thesis";

/// Dependencies that no line of code names, and why they are there all the same.
const UNNAMED: [(&str, &str); 0] = [];

/// The only files with `unsafe`, and why.
const UNSAFE: [(&str, &str); 10] = [
    ("crates/capi/src/lib.rs", "C gives pointers"),
    ("crates/python/src/arrays.rs", "numpy arrays over memory that a Python object owns"),
    ("crates/python/src/simulation.rs", "the state as such arrays"),
    ("crates/python/src/environment.rs", "observations as such arrays"),
    ("crates/robot/tests/contract_controller.rs", "an allocator that counts"),
    ("crates/runtime/tests/contract_loop.rs", "an allocator that counts"),
    ("crates/sim/src/engine/native.rs", "a vector is made without its instruction set's token at hand"),
    ("crates/sim/src/mujoco/library.rs", "MuJoCo is a C library, opened at run time"),
    ("crates/sim/src/mujoco/native.rs", "its structs are read by their offsets"),
    ("crates/nn/src/memory.rs", "glibc's allocator is set by a C function"),
];

/// Crates that begin with an underscore-free name of ours, as `use` writes them.
const PREFIX: &str = "lifelike_";

fn root() -> PathBuf {
    xtask::root()
}

fn floor(name: &str) -> Option<u32> {
    FLOORS.iter().find(|(n, _)| *n == name).map(|(_, f)| *f)
}

/// Whether crate `from` may import crate `to`.
fn allowed(from: &str, to: &str) -> bool {
    let (Some(here), Some(there)) = (floor(from), floor(to)) else { return false };
    let listed = ONLY.iter().find(|(name, _)| *name == from).is_none_or(|(_, only)| only.contains(&to));
    listed && there < here
}

fn crates() -> Vec<(String, PathBuf)> {
    let mut all: Vec<_> = fs::read_dir(root().join("crates"))
        .unwrap()
        .map(|e| e.unwrap())
        .filter(|e| e.path().join("Cargo.toml").is_file())
        .map(|e| (e.file_name().into_string().unwrap(), e.path()))
        .collect();
    all.push((THESIS.into(), root().join(THESIS)));
    all.sort();
    all
}

/// Every file of ours with its path from the root.
fn sources() -> Vec<(String, String)> {
    ["crates", THESIS, "xtask"]
        .iter()
        .flat_map(|folder| rust_files(&root().join(folder)))
        .map(|f| (f.strip_prefix(root()).unwrap().to_string_lossy().replace('\\', "/"), fs::read_to_string(f).unwrap()))
        .collect()
}

/// Lines with what is code in them: no comments, no text in quotes.
fn code(text: &str) -> impl Iterator<Item = (usize, String)> {
    text.lines().enumerate().map(|(i, line)| {
        let line = line.split("//").next().unwrap_or_default();
        let outside: Vec<&str> = line.split('"').step_by(2).collect();
        (i + 1, outside.concat())
    })
}

fn words(line: &str) -> impl Iterator<Item = &str> {
    line.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|w| !w.is_empty())
}

/// Our crates that a line of code names.
fn imports(line: &str) -> Vec<String> {
    words(line).filter_map(|w| w.strip_prefix(PREFIX)).filter(|n| floor(n).is_some()).map(str::to_string).collect()
}

#[test]
fn every_crate_has_a_floor_and_every_manifest_points_down() {
    for (name, folder) in crates() {
        assert!(floor(&name).is_some(), "crate '{name}' has no floor: give it one here and in ARCHITECTURE.md");
        let text = fs::read_to_string(folder.join("Cargo.toml")).unwrap();
        let manifest: toml::Table = text.parse().unwrap();
        for table in ["dependencies", "dev-dependencies", "build-dependencies"] {
            let Some(table) = manifest.get(table).and_then(|t| t.as_table()) else { continue };
            for other in table.keys().filter_map(|k| k.strip_prefix("lifelike-")) {
                assert!(allowed(&name, other), "crates/{name}/Cargo.toml imports '{other}', which is not below it");
            }
        }
        let lints = manifest.get("lints").and_then(|l| l.get("workspace")).and_then(|w| w.as_bool());
        assert_eq!(lints, Some(true), "crates/{name} does not take the workspace's lints");
    }
}

#[test]
fn every_use_points_down() {
    for (path, text) in sources() {
        let name = path.strip_prefix("crates/").unwrap_or(&path).split('/').next().unwrap();
        if name == "xtask" {
            let others = code(&text).flat_map(|(_, l)| imports(&l)).find(|other| other != "fetch");
            assert_eq!(others, None, "{path}: xtask stands outside of the house, and imports nothing but `fetch`");
            continue;
        }
        for (line, content) in code(&text) {
            for other in imports(&content).into_iter().filter(|o| o != name) {
                assert!(allowed(name, &other), "{path}:{line}: '{name}' imports '{other}', which is not below it");
            }
        }
    }
}

#[test]
fn every_dependency_is_used() {
    for (name, folder) in crates() {
        if UNNAMED.iter().any(|(allowed, _)| *allowed == name) {
            continue;
        }
        let manifest: toml::Table = fs::read_to_string(folder.join("Cargo.toml")).unwrap().parse().unwrap();
        let all: Vec<String> = rust_files(&folder).iter().map(|f| fs::read_to_string(f).unwrap()).collect();
        for table in ["dependencies", "dev-dependencies", "build-dependencies"] {
            let Some(table) = manifest.get(table).and_then(|t| t.as_table()) else { continue };
            for key in table.keys() {
                let identifier = key.replace('-', "_");
                let used = all.iter().any(|text| code(text).any(|(_, line)| words(&line).any(|w| w == identifier)));
                assert!(used, "crates/{name}/Cargo.toml depends on '{key}', which no line of code names");
            }
        }
    }
}

/// Crates that run what was trained: a robot's computer compiles them, and none of them may pull in what trains.
const WITHOUT_TRAINING: [&str; 6] =
    ["lifelike-dense", "lifelike-robot", "lifelike-runtime", "lifelike-sim", "lifelike-report", "lifelike-evaluation"];

/// Our crates that train.
const TRAINING: [&str; 4] = ["lifelike-nn", "lifelike-train", "lifelike-representation", "lifelike-tracking"];

/// Frameworks with automatic differentiation: none is part of any build, tests included.
const FRAMEWORKS: [&str; 5] = ["burn", "candle-core", "tch", "dfdx", "tract-core"];

/// Returns the packages that a selection needs, one line for each.
fn tree(arguments: &[&str]) -> Vec<String> {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    let common = ["tree", "--offline", "--prefix", "none", "--format", "{p}"];
    let output = std::process::Command::new(cargo).args(common).args(arguments).current_dir(root()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines().filter_map(|line| line.split(' ').next()).map(str::to_string).collect()
}

#[test]
fn what_a_robot_runs_holds_nothing_that_trains() {
    for name in WITHOUT_TRAINING {
        let found: Vec<String> = tree(&["--edges", "normal", "--package", name])
            .into_iter()
            .filter(|package| TRAINING.contains(&package.as_str()))
            .collect();
        assert_eq!(found, [""; 0], "{name}");
    }
    let tracking = tree(&["--edges", "normal", "--package", "lifelike-tracking"]);
    assert!(tracking.contains(&"lifelike-nn".to_string()), "the check sees what trains");
}

#[test]
fn no_build_has_a_framework_of_automatic_differentiation() {
    let all = tree(&["--edges", "all", "--workspace"]);
    assert!(all.len() > 100, "the check sees packages: {}", all.len());
    let found: Vec<&String> = all.iter().filter(|package| FRAMEWORKS.contains(&package.as_str())).collect();
    assert!(found.is_empty(), "{found:?}");
}

#[test]
fn unsafe_stands_only_where_it_must() {
    for (path, text) in sources() {
        if UNSAFE.iter().any(|(allowed, _)| path.starts_with(allowed)) {
            continue;
        }
        for (line, content) in code(&text) {
            let found = words(&content).any(|w| w == "unsafe");
            assert!(!found, "{path}:{line}: `unsafe` outside of the files that a test lists");
        }
    }
}

#[test]
fn files_stay_readable() {
    let mut lengths = BTreeMap::new();
    for (path, text) in sources() {
        lengths.insert(path, text.lines().count());
    }
    let long: Vec<_> = lengths.iter().filter(|(_, n)| **n > 700).collect();
    assert!(long.is_empty(), "longer than 700 lines, split them: {long:?}");
}

#[test]
fn architecture_md_names_every_crate() {
    let page = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    for (name, _) in crates() {
        let path = if name == THESIS { name } else { format!("crates/{name}") };
        assert!(page.contains(&path), "ARCHITECTURE.md does not mention {path}");
    }
}

#[test]
fn architecture_md_is_read_in_a_few_minutes() {
    let page = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let words = page.split_whitespace().filter(|word| word.contains(char::is_alphabetic)).count();
    assert!(words <= 1200, "{words} words: reasons belong to docs/decisions");
}

#[test]
fn the_checks_themselves_see_what_is_wrong() {
    assert!(allowed("tracking", "sim") && allowed("lifelike", "nn") && allowed("sim", "robot"));
    assert!(!allowed("robot", "sim") && !allowed("nn", "character") && !allowed("sim", "nn") && !allowed("sim", "sim"));
    assert!(!allowed("train", "sim"), "the training loop knows no chapter");
    let text = "use lifelike_sim::Simulation; // lifelike_nn\nlet x = \"lifelike_nn\"; unsafe { }\n";
    let lines: Vec<_> = code(text).collect();
    assert_eq!(imports(&lines[0].1), ["sim"]);
    assert!(imports(&lines[1].1).is_empty());
    assert!(words(&lines[1].1).any(|w| w == "unsafe"));
}
