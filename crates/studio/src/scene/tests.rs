//! Tests of scenes.

#![allow(clippy::unwrap_used)]
use super::*;

fn error(text: &str) -> String {
    Scene::parse(text, "a.scene.toml").unwrap_err().to_string()
}

#[test]
fn errors_name_file_and_line() {
    assert!(error("robot = \"lima\"\nrobbot = 3\n").starts_with("a.scene.toml:2: unknown field `robbot`"));
    let text = "[[motion]]\nid = \"m1\"\nclip = \"a\"\n\n[[motion]]\nid = \"m2\"\nclip = \"a\"\nspeed = 99\n";
    assert_eq!(error(text), "a.scene.toml:6: speed: expected 0.1 to 10, got 99");
    assert!(error("[[motion]]\nid = \"m1\"\n").contains("a.scene.toml:2: expected either"));
    assert!(error("[[push]]\nid = \"p\"\nat = nan\nseconds = 1\nbody = \"b\"\nnewtons = [0, 0, 0]\n").contains("at"));
    let twice = "[[motion]]\nid = \"m\"\nclip = \"a\"\n[[motion]]\nid = \"m\"\nclip = \"a\"\n";
    assert!(error(twice).contains("duplicate id 'm'"));
}

#[test]
fn a_scene_is_written_as_it_is_read() {
    let text = "robot = \"lima\"\n[[motion]]\nid = \"m1\"\nsentence = \"a person walks\"\nspeed = 1.5\n\
                [[over]]\nid = \"o1\"\nclip = \"builtin:wave\"\nat = 1\nparts = [\"arms\"]\n\
                [[switch]]\nid = \"s1\"\nat = 2\nfriction = 0.2\n";
    let scene = Scene::parse(text, "x").unwrap();
    assert_eq!(Scene::parse(&scene.to_toml().unwrap(), "x").unwrap(), scene);
}
