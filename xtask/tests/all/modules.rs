//! The order of modules inside of crates: none imports another that imports it back, on however long a way.
//!
//! A module is a file or folder directly below `src`. Imports are the names after `crate::`, and after `super::` in such a
//! file; a name that `lib.rs` exports counts for the module that defines it. Tests may import what they like.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use crate::sources::rust_files;

/// Circles that exist, and why each may stay for now. A circle that is gone must leave this list.
const CIRCLES: [(&str, &[&str], &str); 9] = [
    (
        "character",
        &["coupling", "inertia", "kinematics", "mesh", "mjcf", "model"],
        "meshes are compiled by MJCF's rules",
    ),
    ("evaluation", &["accuracy", "field", "rollout"], "a rollout has the fields of the errors that are read from it"),
    ("evaluation", &["score", "verdict"], "a clip's score has the verdict on its episodes' scores"),
    ("generation", &["align", "generator", "training"], "a generator's file has the plan that it was trained by"),
    ("language", &["checks", "grammar", "script"], "the grammar checks what it made, checks name its actions"),
    ("lifelike", &["cli", "commands"], "the manual is printed from the arguments of all commands"),
    (
        "motion",
        &["container", "formats", "keyframes", "lint", "plausibility", "retarget"],
        "the table of formats names readers that retarget",
    ),
    ("python", &["clip", "robot"], "Python's classes have each other's methods"),
    ("runtime", &["bus", "gate"], "a bus sends only what the gate made, the gate reads what a bus measured"),
];

/// A crate's modules, each with those that it imports.
type Imports = BTreeMap<String, BTreeSet<String>>;

/// Returns the code of a file: without comments and without its tests.
fn code(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    text.lines().map(|line| line.split("//").next().unwrap()).collect::<Vec<_>>().join("\n")
}

fn first_word(text: &str) -> String {
    text.trim_start().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
}

/// Returns the names directly below a path prefix such as `crate::`, also where they stand in braces.
fn names_after(code: &str, prefix: &str) -> Vec<String> {
    code.split(prefix)
        .skip(1)
        .flat_map(|rest| rest.strip_prefix('{').map_or_else(|| vec![first_word(rest)], in_braces))
        .collect()
}

/// Returns the first word of each part of a list, up to the brace that closes it.
fn in_braces(list: &str) -> Vec<String> {
    let (mut depth, mut parts) = (0, vec![String::new()]);
    for c in list.chars() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => parts.push(String::new()),
            _ => parts.last_mut().unwrap().push(c),
        }
    }
    parts.iter().map(|part| first_word(part)).collect()
}

/// Returns the modules that a `lib.rs` declares, and the module of each name that it exports.
fn exports(lib: &str) -> (BTreeSet<String>, BTreeMap<String, String>) {
    let lines = || lib.split([';', '\n']).map(str::trim);
    let modules: BTreeSet<String> =
        lines().filter_map(|line| line.split_once("mod ")).map(|(_, name)| first_word(name)).collect();
    let mut names = BTreeMap::new();
    for statement in lib.split(';').filter_map(|s| s.split_once("pub use ").map(|(_, path)| path)) {
        let (module, rest) = statement.split_once("::").unwrap_or((statement, ""));
        if modules.contains(module) {
            let words = rest.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|word| !word.is_empty());
            names.extend(words.map(|word| (word.to_string(), module.to_string())));
        }
    }
    (modules, names)
}

fn imports_of(source: &Path) -> Imports {
    let lib = code(&fs::read_to_string(source.join("lib.rs")).unwrap());
    let (modules, exported) = exports(&lib);
    let mut imports = Imports::new();
    for file in rust_files(source) {
        let path = file.strip_prefix(source).unwrap().to_str().unwrap().replace('\\', "/");
        let top = path.split('/').next().unwrap().trim_end_matches(".rs").to_string();
        if !modules.contains(&top) || path.contains("tests") {
            continue;
        }
        let code = code(&fs::read_to_string(&file).unwrap());
        let mut names = names_after(&code, "crate::");
        if !path.contains('/') {
            names.extend(names_after(&code, "super::"));
        }
        let own = imports.entry(top.clone()).or_default();
        for name in names {
            let module = if modules.contains(&name) { Some(&name) } else { exported.get(&name) };
            own.extend(module.filter(|module| **module != top).cloned());
        }
    }
    imports
}

/// Returns the modules that one reaches by imports, over others too.
fn reached(imports: &Imports, from: &str) -> BTreeSet<String> {
    let (mut found, mut open) = (BTreeSet::new(), vec![from.to_string()]);
    while let Some(module) = open.pop() {
        for next in imports.get(&module).into_iter().flatten() {
            if found.insert(next.clone()) {
                open.push(next.clone());
            }
        }
    }
    found
}

/// Returns the groups of modules that all reach each other.
fn circles(imports: &Imports) -> BTreeSet<Vec<String>> {
    let reached: BTreeMap<&String, BTreeSet<String>> =
        imports.keys().map(|module| (module, reached(imports, module))).collect();
    let together =
        |a: &String| imports.keys().filter(|b| reached[a].contains(*b) && reached[*b].contains(a)).cloned().collect();
    imports.keys().map(together).filter(|group: &Vec<String>| group.len() > 1).collect()
}

#[test]
fn modules_import_each_other_one_way_only() {
    let folders = fs::read_dir(xtask::root().join("crates")).unwrap().map(|entry| entry.unwrap().path());
    let mut found = BTreeMap::new();
    for folder in folders.chain([xtask::root().join("thesis")]) {
        let source = folder.join("src");
        if source.join("lib.rs").is_file() {
            let name = folder.file_name().unwrap().to_str().unwrap().to_string();
            found.extend(circles(&imports_of(&source)).into_iter().map(|group| ((name.clone(), group), ())));
        }
    }
    let known: BTreeSet<(String, Vec<String>)> = CIRCLES
        .iter()
        .map(|(name, group, _)| (name.to_string(), group.iter().map(ToString::to_string).collect()))
        .collect();
    let found: BTreeSet<(String, Vec<String>)> = found.into_keys().collect();
    let new: Vec<_> = found.difference(&known).collect();
    assert!(new.is_empty(), "modules that import each other in a circle; move what both need below them: {new:?}");
    let gone: Vec<_> = known.difference(&found).collect();
    assert!(gone.is_empty(), "no circle any more, take it out of CIRCLES: {gone:?}");
}

#[test]
fn a_circle_is_seen_and_an_order_is_none() {
    let lib = "mod a;\npub mod b;\nmod c;\npub use c::{Deep, Other};\n";
    let (modules, exported) = exports(lib);
    assert_eq!((modules.len(), exported["Deep"].as_str()), (3, "c"));
    let text = "use crate::{Deep, b::{self, X}};\nfn f() { crate::a::g() } // crate::z\n#[cfg(test)]\nmod tests { use crate::y; }";
    assert_eq!(names_after(&code(text), "crate::"), ["Deep", "b", "a"]);
    let circles_of = |pairs: &[(&str, &str)]| {
        let mut imports = Imports::new();
        for (from, to) in pairs {
            imports.entry(from.to_string()).or_default().insert(to.to_string());
        }
        circles(&imports)
    };
    assert_eq!(
        circles_of(&[("a", "b"), ("b", "c"), ("c", "a"), ("d", "a")]),
        [vec!["a".into(), "b".into(), "c".into()]].into()
    );
    assert!(circles_of(&[("a", "b"), ("b", "c"), ("a", "c")]).is_empty());
}
