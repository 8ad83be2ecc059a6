//! The table of formats: what holds for each of them, whichever they are.

use std::path::PathBuf;

use super::*;
use crate::container;
use crate::fixtures;

/// Returns a file of this name and content in a folder of its own.
fn file(name: &str, content: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, content).unwrap();
    (folder, path)
}

#[test]
fn every_ending_leads_to_one_format_and_is_listed() {
    let listed = supported(|_| true);
    for format in FORMATS {
        assert!(listed.contains(format.name), "{listed}");
        for ending in format.suffixes.iter().chain(format.shared_suffixes) {
            assert!(ending.starts_with('.') && *ending == ending.to_lowercase(), "{ending}");
            assert!(listed.contains(ending), "{listed}");
        }
        for ending in format.suffixes {
            let (_folder, path) = file(&format!("Walk 1.b{}", ending.to_uppercase()), b"");
            assert_eq!(of_found(&path).unwrap().name, format.name, "{ending}");
            assert_eq!(clip_name(&path), "Walk 1.b");
            let others = FORMATS.iter().filter(|other| other.suffixes.iter().any(|e| e.ends_with(ending))).count();
            assert_eq!(others, 1, "{ending} is the end of another format's");
        }
    }
}

#[test]
fn content_tells_a_format_under_any_name() {
    let robot = container::to_bytes(&fixtures::clip(8, |t| [t, 0.0])).unwrap();
    let recorded = amass::sample();
    let samples: [(&str, &[u8]); 5] = [
        (bvh::FORMAT.name, BVH.as_bytes()),
        (amc::FORMAT.name, AMC.as_bytes()),
        (deepmimic::FORMAT.name, DEEPMIMIC.as_bytes()),
        (super::super::amass::FORMAT.name, &recorded),
        (container::FORMAT.name, &robot),
    ];
    for (name, content) in samples {
        for lead in [&b""[..], &[0xef, 0xbb, 0xbf], b"\r\n "] {
            let is_text = ![container::FORMAT.name, super::super::amass::FORMAT.name].contains(&name);
            if !is_text && !lead.is_empty() {
                continue;
            }
            let (_folder, path) = file("take.7", &[lead, content].concat());
            assert_eq!(of_file(&path).unwrap().name, name);
            assert!(of_found(&path).is_none(), "a folder's files are looked into only where their ending is known");
        }
    }
    let (_folder, path) = file("r", &robot);
    assert!(matches!(read(&path, &ReadOptions::default()), Ok(FileMotion::Robot(_))));
    let refused = read_source(&path, &ReadOptions::default()).unwrap_err().to_string();
    assert!(refused.contains("motion of robot 'swing'"), "{refused}");
}

#[test]
fn shared_endings_are_motion_only_when_the_content_is() {
    let found = |name: &str, content: &str| {
        let (_folder, path) = file(name, content.as_bytes());
        of_found(&path).is_some()
    };
    assert!(found("a.txt", DEEPMIMIC) && found("a.JSON", DEEPMIMIC));
    assert!(!found("humanoid3d.txt", CHARACTER) && !found("readme.txt", "The \"Frames\" are ours."));
    assert!(!found("LICENSE", "MIT") && !found("plan.toml", "") && !found("table.csv", DEEPMIMIC));
}

#[test]
fn an_unknown_format_is_refused_with_all_that_are_known() {
    let (_folder, path) = file("a.abc", b"Kaydara Alembic");
    let message = read(&path, &ReadOptions::default()).unwrap_err().to_string();
    for expected in ["a.abc", "Kaydara"].into_iter().chain(FORMATS.iter().map(|format| format.name)) {
        assert!(message.contains(expected), "{message}");
    }
}
