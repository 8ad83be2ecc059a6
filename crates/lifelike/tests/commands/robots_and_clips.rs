//! Robots and folders of clips as newcomers have them: spoilt, doubled, incomplete; and files that are made to do harm.
#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::in_checkout::{err, lifelike};
use lifelike_motion::container;

fn json(output: &Output) -> serde_json::Value {
    assert!(output.status.success(), "{}", err(output));
    serde_json::from_slice(&output.stdout).unwrap()
}

const BROKEN: &str = "HIERARCHY\nROOT Hips\n{\n  OFFSET 0 0 zero\n";

/// Two of our clips, one of them in two folders, and a broken file.
fn folder(root: &Path) -> std::path::PathBuf {
    let clips = root.join("clips");
    let copy = |name: &str, to: &str| {
        let to = clips.join(to);
        std::fs::create_dir_all(to.parent().unwrap()).unwrap();
        let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../motions").join(name);
        std::fs::copy(from, to).unwrap();
    };
    copy("nod.keys.toml", "a/nod.keys.toml");
    copy("nod.keys.toml", "b/nod.keys.toml");
    copy("wave.keys.toml", "b/wave.keys.toml");
    std::fs::write(clips.join("b/broken.bvh"), BROKEN).unwrap();
    clips
}

#[test]
fn one_bad_clip_and_one_doubled_do_not_stop_an_evaluation() {
    let root = tempfile::tempdir().unwrap();
    let (clips, report) = (folder(root.path()), root.path().join("report"));
    let (clips, report) = (clips.to_str().unwrap(), report.to_str().unwrap());
    let policy = ["eval", "--policy", "lima"];
    let rest = ["--starts", "1", "--seconds", "0.2", "-o", report];
    let output = lifelike(&[&["--json"], &policy[..], &["--motions", clips], &rest].concat());
    let names: Vec<String> = json(&output)["clips"]
        .as_array()
        .unwrap()
        .iter()
        .map(|clip| clip["clip"].as_str().unwrap().to_string())
        .collect();
    assert_eq!(names.len(), 2, "{names:?}");
    let told = err(&output);
    assert!(told.contains("broken.bvh:4") && told.contains("left out 2"), "{told}");
    assert!(told.contains("b/nod.keys.toml") && told.contains("a/nod.keys.toml"), "both of one name: {told}");

    let broken = format!("{clips}/b/broken.bvh");
    let output = lifelike(&[&policy[..], &["--motions", &broken], &rest].concat());
    assert_eq!(output.status.code(), Some(3), "named alone, it is an error");
    assert!(err(&output).contains("broken.bvh:4"), "{}", err(&output));

    let to = root.path().join("directed");
    let output = lifelike(&["motion", "sequence", clips, "motions/nod.keys.toml", "-o", to.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(3), "a sequence without one of its parts would be another motion");
}

/// A biped whose geoms are `geom`, with an include that is missing.
fn robot(root: &Path, geom: &str) -> String {
    let leg = |side: &str, y: f64| {
        format!(
            r#"<body name="{side}_thigh" pos="0 {y} -.1"><joint name="{side}_hip" axis="0 1 0"/>
            <inertial pos="0 0 -.1" mass="1" diaginertia=".01 .01 .01"/><geom {geom}/>
            <body name="{side}_shank" pos="0 0 -.2"><joint name="{side}_knee" axis="0 1 0"/>
            <inertial pos="0 0 -.1" mass="1" diaginertia=".01 .01 .01"/><geom {geom}/>
            <body name="{side}_foot" pos="0 0 -.2"><joint name="{side}_ankle" axis="0 1 0"/>
            <inertial pos="0 0 0" mass=".5" diaginertia=".001 .001 .001"/><geom {geom}/></body></body></body>"#
        )
    };
    let text = format!(
        r#"<mujoco model="duck"><include file="common/sky.xml"/><asset><mesh name="part" file="part.stl"/></asset><worldbody>
        <body name="trunk" pos="0 0 .6"><freejoint/><inertial pos="0 0 0" mass="3" diaginertia=".02 .02 .02"/>{}{}</body>
        </worldbody></mujoco>"#,
        leg("left", 0.1),
        leg("right", -0.1)
    );
    let file = root.join("duck.xml");
    std::fs::write(&file, text).unwrap();
    file.to_str().unwrap().to_string()
}

#[test]
fn a_robot_that_nothing_holds_up_is_refused_before_it_trains() {
    let root = tempfile::tempdir().unwrap();
    let duck = robot(root.path(), r#"type="mesh" mesh="part""#);
    let seen = lifelike(&["inspect", &duck]);
    let text = String::from_utf8(seen.stdout).unwrap();
    let first = text.lines().next().unwrap();
    assert!(first.starts_with("duck: cannot be trained: nothing of it can touch the ground: "), "{first}");
    assert!(text.contains("6 mesh geoms would collide, but their files are missing"), "{text}");

    let out = root.path().join("run");
    let plan = root.path().join("plan.toml");
    std::fs::write(
        &plan,
        format!("robot = \"{duck}\"\nclips = [\"builtin\"]\n[budget]\nsteps = 128\n[ppo]\nenvironments = 4\nminibatch = 16\n"),
    )
    .unwrap();
    let train = ["train", "tracker", "--plan", plan.to_str().unwrap(), "-o", out.to_str().unwrap()];
    let check = ["motion", "check", "motions/nod.keys.toml", "--robot", &duck];
    let commands: &[&[&str]] = &[&train, &check];
    for command in commands {
        let output = lifelike(command);
        assert_eq!(output.status.code(), Some(3), "{command:?}: {}", err(&output));
        assert!(err(&output).contains("nothing of it can touch the ground"), "{command:?}: {}", err(&output));
    }
}

#[test]
fn a_missing_include_of_looks_is_told_and_no_more() {
    let root = tempfile::tempdir().unwrap();
    let duck = robot(root.path(), r#"type="box" size=".08 .04 .01""#);
    let output = lifelike(&["--json", "inspect", &duck]);
    let value = json(&output);
    assert_eq!(value["verdict"], "ready to train, with 1 warning");
    let warning = value["warnings"][0].as_str().unwrap();
    assert!(warning.contains("duck.xml:1: <include>: file 'common/sky.xml' is missing"), "{warning}");
    assert!(err(&output).contains("common/sky.xml"), "{}", err(&output));
    let sound = lifelike(&["inspect", "lima"]);
    assert!(String::from_utf8(sound.stdout).unwrap().starts_with("lima: ready to train\n"));
}

/// Runs a command that must be refused; returns what it says.
#[track_caller]
fn refused(arguments: &[&str], code: i32) -> String {
    let output = lifelike(arguments);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {}", err(&output));
    err(&output) + &String::from_utf8_lossy(&output.stdout)
}

/// Our wave on Lima, as a file in a folder.
fn wave(root: &Path) -> PathBuf {
    let to = root.join("wave");
    let output = lifelike(&["motion", "retarget", "motions/wave.keys.toml", "-o", to.to_str().unwrap()]);
    assert!(output.status.success(), "{}", err(&output));
    to.join("wave.motion.safetensors")
}

/// Names of all files and folders below a folder.
fn tree(root: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(root).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(tree(&path));
        }
        found.push(path);
    }
    found.sort();
    found
}

#[test]
fn names_inside_of_files_lead_nowhere() {
    let root = tempfile::tempdir().unwrap();
    let inside = root.path().join("a/b/c");
    std::fs::create_dir_all(&inside).unwrap();
    let file = wave(&inside);
    let mut clip = container::read(&file).unwrap();
    let published = inside.join("HumanML3D");
    std::fs::create_dir_all(published.join("texts")).unwrap();
    for (split, names) in [("train.txt", "000004\n"), ("val.txt", ""), ("test.txt", "")] {
        std::fs::write(published.join(split), names).unwrap();
    }
    let before = tree(root.path());
    let to = inside.join("out");
    let to = to.to_str().unwrap();
    for name in ["../../../escape", "..", "/tmp/lifelike-escape", ".hidden", "a\\b"] {
        clip.name = name.into();
        container::write(&file, &clip).unwrap();
        let motion = file.to_str().unwrap();
        let message = refused(&["motion", "convert", motion, "--to", "csv", "-o", to], 3);
        assert!(message.contains("expected a name that a file can have"), "{name}: {message}");
        // A file of HumanML3D gives the name of its clip and of its texts.
        let row = format!("./pose_data/CMU/80/80_63_poses.npy,0,50,{name}.npy\n");
        let index = format!("source_path,start_frame,end_frame,new_name\n{row}");
        std::fs::write(published.join("index.csv"), index).unwrap();
        let message = refused(&["dataset", "humanml3d", published.to_str().unwrap(), motion, "-o", to], 3);
        assert!(message.contains("index.csv:2: expected letters and digits as new_name"), "{name}: {message}");
        std::fs::remove_file(published.join("index.csv")).unwrap();
        let now: Vec<PathBuf> = tree(root.path()).into_iter().filter(|path| !path.starts_with(to)).collect();
        assert_eq!(now, before, "{name}");
        assert!(!Path::new("/tmp/lifelike-escape.csv").exists());
        if Path::new(to).exists() {
            assert!(tree(Path::new(to)).iter().all(|path| path.is_dir()), "{name}: {:?}", tree(Path::new(to)));
            std::fs::remove_dir_all(to).unwrap();
        }
    }
}

#[test]
fn a_file_of_which_one_bit_is_another_is_refused() {
    let root = tempfile::tempdir().unwrap();
    let motion = std::fs::read(wave(root.path())).unwrap();
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets");
    let controller = std::fs::read(assets.join("lima-path.controller.safetensors")).unwrap();
    let spoilt = |name: &str, bytes: &[u8], bit: usize| {
        let mut bytes = bytes.to_vec();
        bytes[bit / 8] ^= 1 << (bit % 8);
        let file = root.path().join(name);
        std::fs::write(&file, bytes).unwrap();
        file.to_str().unwrap().to_string()
    };
    for share in [0.05, 0.3, 0.6, 0.999] {
        let bit = |bytes: &[u8]| (8.0 * bytes.len() as f64 * share) as usize;
        let file = spoilt("x.motion.safetensors", &motion, bit(&motion));
        for command in [&["motion", "check"][..], &["inspect"]] {
            let message = refused(&[command, &[&file]].concat(), 3);
            assert!(message.contains("x.motion.safetensors"), "{message}");
        }
        let file = spoilt("x.controller.safetensors", &controller, bit(&controller));
        let message = refused(&["inspect", &file], 3);
        assert!(message.contains("x.controller.safetensors"), "{message}");
    }
}

#[cfg(unix)]
#[test]
fn what_stands_at_the_place_of_an_output_is_not_written_through() {
    let root = tempfile::tempdir().unwrap();
    let file = wave(root.path());
    let (precious, to) = (root.path().join("precious"), root.path().join("out"));
    std::fs::write(&precious, "old").unwrap();
    std::fs::create_dir(&to).unwrap();
    let (link, pipe) = (to.join("wave.csv"), to.join("wave.motion.safetensors"));
    std::os::unix::fs::symlink(&precious, &link).unwrap();
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    for (format, got) in [("csv", "a symbolic link, which is not followed"), ("motion", "a pipe or device")] {
        let convert = ["motion", "convert", file.to_str().unwrap(), "--to", format, "-o", to.to_str().unwrap()];
        let message = refused(&convert, 3);
        assert!(message.contains(got), "{message}");
    }
    assert_eq!(std::fs::read_to_string(&precious).unwrap(), "old");
    assert_eq!(tree(&to), [link, pipe]);
}

#[test]
fn numbers_beyond_any_machine_are_refused_at_once() {
    let root = tempfile::tempdir().unwrap();
    let at = |name: &str| root.path().join(name).to_str().unwrap().to_string();
    let (options, to) = (at("options.toml"), at("out"));
    std::fs::write(&options, "fps = 1e7\n").unwrap();
    let file = wave(root.path());
    let motion = file.to_str().unwrap();
    let retarget = ["motion", "retarget", "motions/wave.keys.toml", "-o", &to];
    for (arguments, code, part) in [
        (&[&retarget[..], &["--options", &options]].concat()[..], 3, "it must be from 1 to 1000 Hz"),
        (&[&retarget[..], &["--threads", "1000000"]].concat(), 2, "expected a number from 0 to 1024"),
        (
            &["motion", "convert", motion, "--fps", "1e9", "-o", &to],
            3,
            "expected 0.01 to 10000 frames per second, got 1000000000",
        ),
        (&["bench", "engine", "--environments", "18446744073709551615"], 2, "expected a number from 1 to 1048576"),
        (&["bench", "engine", "--seconds", "1e30"], 2, "at most 3600"),
        (&["dataset", "grammar", "--hours", "1e12", "-o", &to], 2, "at most 1000"),
        (
            &["eval", "--policy", "lima", "--motions", "builtin:wave", "--starts", "999999999", "-o", &to],
            2,
            "from 1 to 10000",
        ),
    ] {
        let message = refused(arguments, code);
        assert!(message.contains(part), "{arguments:?}: {message}");
    }
}

#[test]
fn files_that_are_no_text_are_bad_input() {
    let root = tempfile::tempdir().unwrap();
    let at = |name: &str| root.path().join(name).to_str().unwrap().to_string();
    for name in ["walk.bvh", "wave.keys.toml", "robot.xml", "robot.urdf", "options.toml", "list.txt"] {
        std::fs::write(at(name), b"\xff\x00\xfe = \xc3\x28\n").unwrap();
    }
    let to = at("out");
    let list = format!("@{}", at("list.txt"));
    for (arguments, named) in [
        (&["inspect", &at("walk.bvh")][..], "walk.bvh"),
        (&["motion", "retarget", &at("walk.bvh"), "-o", &to], "walk.bvh"),
        (&["motion", "retarget", &at("wave.keys.toml"), "-o", &to], "wave.keys.toml"),
        (
            &["motion", "retarget", "motions/wave.keys.toml", "--options", &at("options.toml"), "-o", &to],
            "options.toml",
        ),
        (&["motion", "check", &list], "list.txt"),
        (&["inspect", &at("robot.xml")], "robot.xml"),
        (&["inspect", &at("robot.urdf")], "robot.urdf"),
    ] {
        let message = refused(arguments, 3);
        assert!(message.contains(named), "{arguments:?}: {message}");
    }
}
