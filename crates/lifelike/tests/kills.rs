//! Commands that are killed at any moment: files are whole or not there, and the same command again gives the same bytes.

#![cfg(unix)]
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Every command that writes, with what it is asked for; `OUT` is the folder of its results. Those that go on by `--resume` are
/// marked with `+`.
const COMMANDS: &str = "
motion retarget MOTIONS/wave.keys.toml MOTIONS/nod.keys.toml --robot lima --threads 1 -o OUT
motion lint IN --fix -o OUT
motion convert IN --fps 100 -o OUT
motion convert IN --to csv -o OUT
motion convert IN --to glb --robot lima -o OUT
motion repair IN --robot lima -o OUT
motion mirror IN/wave.motion.safetensors -o OUT
motion sequence IN/wave.motion.safetensors IN/nod.motion.safetensors -o OUT
inspect lima --look -o OUT
eval --policy lima --motions builtin:wave --starts 1 --seconds 1 -o OUT
generate a%person%waves -o OUT/wave.motion.safetensors
dataset captures IN -o OUT
motion blend IN/wave.motion.safetensors IN/nod.motion.safetensors -o OUT
motion compose IN/wave.motion.safetensors IN/nod.motion.safetensors --joints right_arm -o OUT
motion warp IN/wave.motion.safetensors --speed 0.8 -o OUT
motion place IN/wave.motion.safetensors --key right_hand@1.6+=0.05,0,0.05 -o OUT
motion stylize IN/wave.motion.safetensors --gain 1.2 -o OUT
motion trim IN/wave.motion.safetensors --end 2 -o OUT
motion edit IN/wave.motion.safetensors --gain 1.4 -o OUT
motion interpolate IN/wave.motion.safetensors IN/nod.motion.safetensors --prior lima -o OUT
render IN/wave.motion.safetensors -o OUT/wave.gif --size 160x120 --fps 10
play examples/hello -o OUT
man -o OUT
+dataset grammar --robot lima --hours 0.003 -o OUT
";

struct Folder {
    temporary: tempfile::TempDir,
}

impl Folder {
    fn at(&self, name: &str) -> PathBuf {
        self.temporary.path().join(name)
    }

    fn start(&self, line: &str, output: &Path, more: &[&str]) -> Child {
        let motions = Path::new(env!("CARGO_MANIFEST_DIR")).join("../motion/motions");
        let places = [("MOTIONS", motions.as_path()), ("IN", &self.at("in")), ("OUT", output)]
            .map(|(name, path)| (name, path.display().to_string()));
        let word = |word: &str| {
            let place = places.iter().find_map(|(name, path)| Some(format!("{path}{}", word.strip_prefix(name)?)));
            place.unwrap_or_else(|| word.replace('%', " "))
        };
        if line.starts_with("render") {
            std::fs::create_dir_all(output).unwrap();
        }
        let mut command = Command::new(env!("CARGO_BIN_EXE_lifelike"));
        command.arg("-q").args(line.trim_start_matches('+').split_whitespace().map(word)).args(more);
        // Without a browser, which would outlive the kill.
        command.env("XDG_CACHE_HOME", self.at("cache")).env("LIFELIKE_BROWSER", "").current_dir(self.temporary.path());
        command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
    }

    fn run(&self, line: &str, output: &Path, more: &[&str]) -> BTreeMap<PathBuf, Vec<u8>> {
        let done = self.start(line, output, more).wait_with_output().unwrap();
        assert!(done.status.success(), "{line}: {}", String::from_utf8_lossy(&done.stderr));
        files(output)
    }
}

/// Returns the files below a folder; those that are still being written have names that begin with a dot.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(here) = open.pop() {
        for entry in std::fs::read_dir(&here).into_iter().flatten() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else if !path.file_name().unwrap().to_string_lossy().starts_with('.') {
                found.insert(path.strip_prefix(folder).unwrap().to_path_buf(), std::fs::read(&path).unwrap());
            }
        }
    }
    found
}

/// Kills each command until a number of kills met a living process, within ten times as many tries; returns the number of kills.
fn kill(lines: &[&str], times: usize) -> usize {
    let folder = Folder { temporary: tempfile::tempdir().unwrap() };
    folder.run(COMMANDS.lines().nth(1).unwrap(), &folder.at("in"), &[]);
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut kills = 0;
    for line in lines {
        let begin = Instant::now();
        let first = folder.run(line, &folder.at("first"), &[]);
        let seconds = begin.elapsed().as_secs_f64();
        let second = folder.run(line, &folder.at("second"), &[]);
        // Names of folders and times of day are in some files.
        let same: Vec<&PathBuf> = first.keys().filter(|name| first.get(*name) == second.get(*name)).collect();
        assert!(!same.is_empty(), "{line}: no file is the same twice");
        let mut met = 0;
        for _ in 0..10 * times {
            if met == times {
                break;
            }
            let output = folder.at("killed");
            let _ = std::fs::remove_dir_all(&output);
            let mut child = folder.start(line, &output, &[]);
            std::thread::sleep(Duration::from_secs_f64(seconds * rng.random_range(0.0..1.0)));
            met += usize::from(child.try_wait().unwrap().is_none());
            let _ = child.kill();
            child.wait().unwrap();
            let left = files(&output);
            for name in same.iter().filter(|name| left.contains_key(**name)) {
                // Lines are appended one by one; a file of another kind is whole.
                let is_lines = name.extension().is_some_and(|ending| ending == "jsonl");
                let whole = if is_lines { first[*name].starts_with(&left[*name]) } else { first[*name] == left[*name] };
                assert!(whole, "{line}: half of {}", name.display());
            }
            let resumes = line.starts_with('+') && left.contains_key(Path::new("unfinished.json"));
            if line.starts_with('+') && !resumes && !left.is_empty() {
                // It was done, and there is nothing to go on with.
                assert!(same.iter().all(|name| left.get(*name) == first.get(*name)), "{line}");
                continue;
            }
            if line.contains("dataset captures") {
                let _ = std::fs::remove_dir_all(&output);
            }
            let again = folder.run(line, &output, if resumes { &["--resume"] } else { &[] });
            for name in &same {
                assert_eq!(again.get(*name), first.get(*name), "{line}: {} after the second run", name.display());
            }
        }
        println!("{line}: {seconds:.1} s, {} files, {met} kills", first.len());
        kills += met;
        for name in ["first", "second", "killed"] {
            let _ = std::fs::remove_dir_all(folder.at(name));
        }
    }
    kills
}

#[test]
fn killed_commands_leave_whole_files() {
    let lines: Vec<&str> = COMMANDS.lines().filter(|l| l.contains("retarget") || l.contains("--to csv")).collect();
    kill(&lines, 2);
}

/// 100 kills: minutes. `cargo test --release --workspace --test kills -- --ignored --nocapture`
#[test]
#[ignore = "takes minutes"]
fn a_hundred_kills() {
    let lines: Vec<&str> = COMMANDS.lines().filter(|line| !line.is_empty()).collect();
    let kills = kill(&lines, 8);
    println!("{kills} kills");
    assert!(kills >= 100, "{kills}");
}
