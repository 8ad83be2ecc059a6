//! Robots and folders of clips as newcomers have them: spoilt, doubled, incomplete.
#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::process::{Command, Output};

fn lifelike(arguments: &[&str]) -> Output {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    Command::new(env!("CARGO_BIN_EXE_lifelike")).args(arguments).current_dir(root).output().unwrap()
}

fn err(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

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
