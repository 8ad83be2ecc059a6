//! The pages in a browser: no console error, something on the canvas, curves that can be told apart, and exports that are files.
//!
//! Needs Chromium (`apt install chromium`) and is skipped, with a word, where there is none.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::expect_used)]

#[path = "pages/browser.rs"]
mod browser;

use std::path::{Path, PathBuf};
use std::process::Command;

use browser::{Browser, within};
use serde_json::json;

/// Sizes and themes in which every page is opened.
const SCREENS: [(u32, u32, &str); 2] = [(1280, 800, "light"), (390, 844, "dark")];
/// Number of colours, in 32 steps a channel, on the canvas of 64 x 64 pixels that the scene is drawn on again.
const COLOURS: &str = r#"(() => {
    const small = document.createElement("canvas");
    [small.width, small.height] = [64, 64];
    const context = small.getContext("2d");
    context.drawImage(document.querySelector("[data-is=canvas]"), 0, 0, 64, 64);
    const { data } = context.getImageData(0, 0, 64, 64);
    const seen = new Set();
    for (let i = 0; i < data.length; i += 4) seen.add(data[i] >> 3 << 10 | data[i + 1] >> 3 << 5 | data[i + 2] >> 3);
    return seen.size;
})()"#;
/// Colours of the lines in the first plot of joints.
const STROKES: &str = r#"(() => {
    const lines = document.querySelector("[data-is=plots] svg").querySelectorAll("path.bold");
    return [...lines].map((line) => getComputedStyle(line).stroke);
})()"#;

fn lifelike(folder: &Path, arguments: &[&str]) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lifelike"));
    let output =
        command.args(arguments).current_dir(folder).env("XDG_CACHE_HOME", folder.join("cache")).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
}

fn repository(path: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path).display().to_string()
}

/// Opens a page that plays motion in every size and theme, with WebGL and without.
fn plays(browser: &mut Browser, page: &Path) {
    for (width, height, theme) in SCREENS {
        for query in ["", "?flat"] {
            browser.open(page, query, (width, height), theme);
            let place = format!("{}{query} at {width}x{height}", page.display());
            // A canvas that nothing was drawn on has one colour.
            within(40, &format!("{place}: a picture on the canvas"), || browser.number(COLOURS) > 8.0);
            let over = browser.number("document.documentElement.scrollWidth - innerWidth");
            assert!(over <= 0.0, "{place}: {over} pixels wider than the screen");
            assert!(browser.errors().is_empty(), "{place}: {:?}", browser.errors());
        }
    }
}

/// Clicks a button of the player, and returns the file that it leaves in the folder of downloads.
fn export(browser: &mut Browser, button: &str, endings: &[&str]) -> Vec<u8> {
    browser.evaluate(&format!("document.querySelector('[data-is={button}]').click()"));
    let mut found: Option<PathBuf> = None;
    within(120, &format!("a file of {endings:?}"), || {
        // What is still being written has another ending.
        let files = std::fs::read_dir(browser.downloads()).unwrap().map(|file| file.unwrap().path());
        let is_whole = |file: &PathBuf| file.extension().is_some_and(|e| endings.iter().any(|ending| e == *ending));
        found = files.filter(is_whole).last();
        browser.evaluate("1");
        found.is_some()
    });
    std::fs::read(found.unwrap()).unwrap()
}

#[test]
fn results_play_and_are_exported() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut browser) = Browser::start(folder.path()) else { return };
    let at = |page: &str| folder.path().join(page);
    lifelike(folder.path(), &["motion", "trim", "builtin:wave", "--end", "1", "-o", "clips"]);
    lifelike(folder.path(), &["eval", "--policy", "lima", "--motions", "clips", "--starts", "1", "-o", "eval"]);
    let keys = repository("crates/motion/motions/wave.keys.toml");
    lifelike(folder.path(), &["motion", "retarget", &keys, "--robot", "lima", "-o", "retargeted", "--look"]);

    plays(&mut browser, &at("retargeted/report.html"));
    let legend = browser.evaluate("[...document.querySelectorAll('.legend span')].map((part) => part.textContent)");
    assert_eq!(legend, json!(["robot", "human"]));
    let note = browser.evaluate("document.querySelector('[data-is=note]').textContent");
    assert!(note.as_str().is_some_and(|note| note.contains(" · ") && note.contains(" cm")), "{note}");

    plays(&mut browser, &at("eval/report.html"));
    browser.open(&at("eval/report.html"), "?joints", (1280, 800), "light");
    let strokes = browser.evaluate(STROKES);
    let strokes: Vec<&str> = strokes.as_array().unwrap().iter().map(|s| s.as_str().unwrap()).collect();
    assert!(strokes.len() == 2 && strokes[0] != strokes[1], "physics and reference on one axis: {strokes:?}");
    let picture = export(&mut browser, "picture", &["png"]);
    assert!(picture.starts_with(b"\x89PNG\r\n\x1a\n") && picture.len() > 5_000, "{} bytes", picture.len());
    let video = export(&mut browser, "video", &["mp4", "webm"]);
    // The first element of every WebM file, and the first box of every mp4 file.
    let is_film = video.starts_with(&[0x1a, 0x45, 0xdf, 0xa3]) || video[4..].starts_with(b"ftyp");
    assert!(is_film && video.len() > 5_000, "{} bytes", video.len());
    assert!(browser.errors().is_empty(), "{:?}", browser.errors());
}

#[test]
fn a_robot_is_looked_at_and_moved() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut browser) = Browser::start(folder.path()) else { return };
    lifelike(folder.path(), &["inspect", "lima", "--look", "-o", "look"]);
    let page = folder.path().join("look/report.html");
    plays(&mut browser, &page);
    for layers in ["visual,sides,contacts", "visual,masses,frames"] {
        browser.open(&page, &format!("?layers={layers}"), (1280, 800), "light");
        within(40, &format!("{layers} on the canvas"), || browser.number(COLOURS) > 8.0);
    }
    assert_eq!(browser.number("document.querySelectorAll('.joints input').length") as u64, 20);
    let knee = |at: &str| {
        format!(
            "[...document.querySelectorAll('.joints label')].find((row) => row.querySelector('b').textContent === 'left_knee').{at}"
        )
    };
    let picture = "document.querySelector('[data-is=canvas]').toDataURL()";
    let before = browser.evaluate(picture);
    browser.evaluate(&format!(
        "(() => {{ const input = {}; input.value = 1.2; input.dispatchEvent(new Event('input')); }})()",
        knee("querySelector('input')")
    ));
    assert_eq!(browser.evaluate(&knee("querySelector('span').textContent")), json!("68.8°"));
    let moved = browser.evaluate("document.querySelector('[data-is=pointed]').textContent");
    assert_eq!(moved, json!("left_knee moves left_shank"));
    within(40, "another picture", || browser.evaluate(picture) != before);
    browser.evaluate("document.querySelector('[data-is=zero]').click()");
    assert_eq!(browser.evaluate(&knee("querySelector('span').textContent")), json!("0.0°"));
    assert!(browser.errors().is_empty(), "{:?}", browser.errors());
}

#[test]
fn a_training_and_a_sentence_can_be_watched() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut browser) = Browser::start(folder.path()) else { return };
    let plan = ["train", "tracker", "--plan", "track", "-o", "run", "--watch", "clips=[\"builtin:wave\"]"];
    lifelike(folder.path(), &[&plan[..], &["budget.steps=20000", "checkpoint_every=2"]].concat());
    lifelike(folder.path(), &["generate", "a person waves", "--physics", "-o", "wave.motion.safetensors"]);

    plays(&mut browser, &folder.path().join("wave-physics/report.html"));
    let live = folder.path().join("run/live.html");
    browser.open(&live, "", (1280, 800), "light");
    within(40, "the robot moved by the newest policy", || {
        let shown = browser.evaluate("!document.querySelector('#playback').hidden") == json!(true);
        shown && browser.number(COLOURS) > 8.0
    });
    let headlines =
        "[...document.querySelectorAll('.headline figcaption b')].slice(0, 3).map((name) => name.textContent)";
    assert_eq!(browser.evaluate(headlines), json!(["survival", "mean_step_reward", "joint_error_deg"]));
    let facts = browser.evaluate("document.querySelector('[data-is=facts]').textContent");
    assert!(facts.as_str().is_some_and(|facts| facts.contains("steps")), "{facts}");
    assert!(browser.errors().is_empty(), "{:?}", browser.errors());

    let report = folder.path().join("run/report.html");
    browser.open(&report, "", (390, 844), "dark");
    assert!(browser.number("document.querySelectorAll('figure svg path.bold').length") > 2.0);
    assert!(browser.errors().is_empty(), "{:?}", browser.errors());
}

#[test]
fn errors_of_a_page_and_an_empty_canvas_are_seen() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut browser) = Browser::start(folder.path()) else { return };
    let page = folder.path().join("broken.html");
    let text =
        "<canvas data-is=canvas></canvas><script>document.documentElement.dataset.ready = '1'; missing();</script>";
    std::fs::write(&page, text).unwrap();
    browser.open(&page, "", (1280, 800), "light");
    assert_eq!(browser.number(COLOURS) as u64, 1);
    assert!(browser.errors().iter().any(|error| error.contains("missing is not defined")), "{:?}", browser.errors());
}

/// Mean difference of two PNG files of one size (0 to 255).
fn difference(pictures: [&Path; 2]) -> f64 {
    let [a, b] = pictures.map(|path| {
        let mut decoder = png::Decoder::new(std::io::Cursor::new(std::fs::read(path).unwrap()));
        decoder.set_transformations(png::Transformations::STRIP_16);
        let mut reader = decoder.read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        assert_eq!((info.width, info.height), (480, 270));
        let channels = info.color_type.samples();
        bytes.chunks_exact(channels).flat_map(|p| [p[0], p[1], p[2]]).collect::<Vec<u8>>()
    });
    a.iter().zip(&b).map(|(p, q)| f64::from(p.abs_diff(*q))).sum::<f64>() / a.len() as f64
}

#[test]
fn motion_is_rendered_by_the_page_and_without_it() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut browser) = Browser::start(folder.path()) else { return };
    let run = |arguments: &[&str]| lifelike(folder.path(), arguments);
    run(&["eval", "--policy", "lima", "--motions", "builtin:walk", "--starts", "1", "-o", "report"]);
    let size = ["--size", "480x270"];
    run(&[&["render", "report", "-o", "film.mp4", "--to", "1", "--fps", "20"], &size[..]].concat());
    // The browser is an independent reader of the file.
    let page = folder.path().join("player.html");
    std::fs::write(&page, "<html data-ready=1><video src=film.mp4 muted></video></html>").unwrap();
    browser.open(&page, "", (640, 480), "light");
    let known = r#"(() => {
        const { readyState, duration, videoWidth, videoHeight } = document.querySelector("video");
        return readyState >= 2 ? [duration, videoWidth, videoHeight] : null;
    })()"#;
    within(40, "the film is decoded", || !browser.evaluate(known).is_null());
    assert_eq!(browser.evaluate(known), json!([1, 480, 270]));

    run(&[&["render", "report", "-o", "page.png", "--at", "1"], &size[..]].concat());
    run(&[&["render", "report", "-o", "raster.png", "--at", "1", "--software"], &size[..]].concat());
    run(&[&["render", "report", "-o", "later.png", "--at", "1.5", "--software"], &size[..]].concat());
    let file = |name: &str| folder.path().join(name);
    let same = difference([&file("page.png"), &file("raster.png")]);
    let other = difference([&file("later.png"), &file("raster.png")]);
    // Half a second of walking changes the picture more than another renderer does.
    assert!(same < 2.0 && same < 0.7 * other, "{same} between renderers, {other} between instants");

    run(&["render", "report", "-o", "film.gif", "--to", "0.3", "--size", "160x90", "--software"]);
    let gif = std::fs::read(file("film.gif")).unwrap();
    assert!(gif.starts_with(b"GIF89a") && gif.windows(11).any(|w| w == b"NETSCAPE2.0"));
}
