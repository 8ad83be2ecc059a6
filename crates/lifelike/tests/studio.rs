//! The studio in a browser: type, play, pull, pose, edit, undo, drop a capture, film, export, reload. Every error of a module fails.
//!
//! Needs Chromium (`apt install chromium`) and is skipped, with a word, where there is none.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::expect_used)]

#[path = "studio/page.rs"]
mod page;

#[path = "pages/browser.rs"]
mod browser;

use std::path::Path;
use std::process::Command;

use browser::{Browser, within};
use lifelike_studio::Scene;
use page::{Page, Served};
use serde_json::json;

#[test]
fn a_scene_is_directed_from_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let Some(browser) = Browser::start(folder.path()) else { return };
    let served = Served::start(folder.path(), "a.scene.toml");
    let mut page = Page::open(browser, &served.address);

    // Type, and it plays.
    page.say("a person walks forward");
    page.until("it plays", "studio.view.scene.motion.length === 1 && studio.head.playing && studio.head.frame > 20");
    // Talk to it: the next sentence joins while it plays.
    page.say("a person waves with the right hand");
    page.until("two blocks", "studio.view.spans.length === 2 && !studio.view.building");
    assert_eq!(page.value("studio.view.falls.length"), json!(0));

    // Pull it by hand: the pull becomes pushes of the scene.
    page.run("studio.link.send({ play: false }); studio.link.send({ seek: 0 })");
    page.until("the start", "studio.head.frame === 0 && !studio.head.playing && !studio.scene.dirty");
    page.pull(90.0);
    page.until("pushes", "studio.view.scene.push.length > 0 && studio.head.force === 0");
    let force =
        page.value("Math.max(...studio.view.scene.push.map((p) => Math.hypot(...p.newtons)))").as_f64().unwrap();
    assert!(force > 10.0, "{force} N");
    page.act("undo");
    page.until("the pull is undone", "studio.view.scene.push.length === 0");

    // Edit with keys.
    page.run("studio.link.send({ play: false }); studio.link.send({ seek: 1.5 })");
    // Not a frame that only passes by: the split and the block under the needle are those of one instant.
    page.until("the needle", "studio.head.frame === 75 && !studio.head.playing");
    page.act("split");
    page.until("a split", "studio.view.spans.length === 3");
    page.act("mirror");
    page.until("a mirror image", "studio.view.scene.motion[1].mirror === true");
    page.act("undo");
    page.act("undo");
    page.until("both are undone", "studio.view.spans.length === 2 && !studio.view.scene.motion[0].mirror");
    page.act("redo");
    page.until("redone", "studio.view.spans.length === 3");
    page.act("slippery");
    page.until("a switch", "studio.view.scene.switch.length === 1");

    // Drop a capture: it is read, and its layout is said.
    page.drop("wave.bvh", &capture(folder.path()));
    page.until("the capture", "studio.view.spans.some((s) => s.source.startsWith('BVH'))");
    page.drop("broken.bvh", "HIERARCHY nonsense");
    page.until("a refusal", "document.querySelector('[data-is=told].bad')?.textContent.includes('broken.bvh')");
    assert!(!folder.path().join("dropped/broken.bvh").exists());

    // Export: a page in one file, a clip, the scene.
    for (what, begins) in [("page", "<!doctype html>"), ("scene", "robot = \"lima\"")] {
        let text = page.value(&format!("fetch('export/{what}').then((a) => a.text())"));
        assert!(text.as_str().unwrap().starts_with(begins), "{what}");
    }
    let length = page.value("fetch('export/clip').then((a) => a.arrayBuffer()).then((b) => b.byteLength)");
    assert!(length.as_u64().unwrap() > 50_000, "{length}");

    // Run on the robot: the scene is saved, and the command works as it is shown.
    page.act("robot");
    page.until("the command", "document.querySelector('[data-is=robot]').open");
    let command = page.value("document.querySelector('[data-is=command]').textContent");
    let scene = folder.path().join("a.scene.toml");
    let policy = "lifelike run lima-path --bus sim:127.0.0.1:9870 --scene";
    assert_eq!(command, json!(format!("{policy} {}", scene.display())));
    assert!(Scene::load(&scene).unwrap().motion.len() >= 3);
    let words = command.as_str().unwrap().split(' ').skip(1).map(|word| word.replace(":9870", ":9"));
    let ran = Command::new(env!("CARGO_BIN_EXE_lifelike")).args(words).output().unwrap();
    let said = String::from_utf8_lossy(&ran.stderr).into_owned();
    assert!(said.contains("expected the robot's facts") && said.contains("friction (s1)"), "{said}");
    page.run("document.querySelector('[data-is=robot]').close()");

    // Reload: nothing is lost, and the file is what is on the page.
    let before = page.value("JSON.stringify(studio.view.scene)");
    let mut page = Page::open(page.browser, &served.address);
    assert_eq!(page.value("JSON.stringify(studio.view.scene)"), before);
    let saved = std::fs::read_to_string(folder.path().join("a.scene.toml")).unwrap();
    assert!(saved.contains("a person walks forward") && saved.contains("dropped/wave.bvh"), "{saved}");
    page.no_errors();
}

#[test]
fn the_page_is_drawn_in_both_themes_and_by_every_key() {
    let folder = tempfile::tempdir().unwrap();
    let Some(browser) = Browser::start(folder.path()) else { return };
    let served = Served::start(folder.path(), "examples/hello");
    let mut page = Page::open(browser, &served.address);
    within(40, "a picture on the canvas", || page.colours() > 8.0);
    let all = page.value("Object.keys(studio.actions)");
    for name in all.as_array().unwrap().iter().map(|name| name.as_str().unwrap()).filter(|name| *name != "help") {
        page.act(name);
    }
    within(40, "a picture on the canvas", || page.colours() > 8.0);
    page.no_errors();
    // One that only watches, on a phone.
    let watch = served.watch.clone();
    page.browser.open_address(&format!("{watch}?flat"), (390, 844), "dark");
    within(40, "a picture without WebGL", || page.colours() > 4.0);
    let over = page.value("document.documentElement.scrollWidth - innerWidth").as_f64().unwrap();
    assert!(over <= 0.0, "{over} pixels wider than the screen");
    page.run("studio.link.operate({ do: 'seed', value: 9 })");
    page.until("a refusal", "document.querySelector('[data-is=told].bad')?.textContent.includes('may only watch')");
    page.no_errors();
}

#[test]
fn a_pose_is_dragged_compared_and_filmed() {
    const HAND: &str = "studio.scene.project(studio.scene.handlePlace(\
        studio.scene.robot.handles.find((h) => h.name === 'right_hand')))";
    const READY: &str = "!studio.view.building && studio.head.known + 1 >= studio.head.frames && !studio.scene.dirty";
    let folder = tempfile::tempdir().unwrap();
    let Some(browser) = Browser::start(folder.path()) else { return };
    let served = Served::start(folder.path(), "examples/hello");
    let mut page = Page::open(browser, &served.address);
    // Physics first: the needle goes no further than what is known.
    page.until("physics", &format!("studio.head?.frames > 120 && {READY}"));
    page.run("studio.link.send({ seek: 2.3 })");
    page.until("the needle", &format!("studio.head.frame === 115 && {READY}"));
    let before = page.value("JSON.stringify(studio.view.scene)");

    // A hand goes where the mouse takes it, and the take before stays as a ghost.
    page.act("handles");
    let (x, y) = (page.browser.number(&format!("{HAND}.x")), page.browser.number(&format!("{HAND}.y")));
    page.browser.mouse("mouseMoved", x, y);
    page.browser.mouse("mousePressed", x, y);
    for step in 1..=5 {
        page.browser.mouse("mouseMoved", x + 4.0 * f64::from(step), y - 12.0 * f64::from(step));
    }
    page.browser.mouse("mouseReleased", x + 20.0, y - 60.0);
    page.until("an edit", &format!("studio.view.scene.motion[0].edits?.length === 1 && studio.view.kept && {READY}"));
    page.until("the ghost", "studio.scene.kept !== null");
    let off =
        [page.browser.number(&format!("{HAND}.x")) - x - 20.0, page.browser.number(&format!("{HAND}.y")) - y + 60.0];
    // A pixel is 2 mm here, and an edit is written in whole millimetres.
    assert!(off.iter().all(|pixels| pixels.abs() < 3.0), "{off:?} pixels off");

    // Style, control points, repair, parts of another sentence: each is an operation that is undone.
    for (operation, holds) in [
        ("{ do: 'style', id: 'm2', gain: 1.4 }", "studio.view.scene.motion[1].gain === 1.4"),
        ("{ do: 'point', id: 'm3', at: 2, gain: 1.6 }", "studio.view.scene.motion[2]?.points?.length === 1"),
        ("{ do: 'feasible', id: 'm2', value: true }", "(studio.view.spans[1]?.changed ?? '') !== ''"),
        (
            "{ do: 'lay', text: 'a person waves with the left hand', at: 6, parts: ['left_arm'] }",
            "studio.view.scene.over.length === 1",
        ),
    ] {
        page.run(&format!("studio.link.operate({operation})"));
        page.until(operation, &format!("{holds} && !studio.view.building"));
        assert_eq!(page.value("studio.view.problem"), json!(""), "{operation}");
    }
    for _ in 0..5 {
        page.act("undo");
    }
    page.until("the scene as it was", &format!("JSON.stringify(studio.view.scene) === {before}"));
    page.act("keep");
    page.until("no ghost", "!studio.view.kept && studio.scene.kept === null");

    // A film of the scene, in a quarter of its time.
    page.run("studio.link.send({ rate: 4 })");
    page.act("video");
    page.until("a film", "studio.video");
    let film = page.value("studio.video");
    assert!(["video/mp4", "video/webm"].contains(&film["type"].as_str().unwrap()), "{film}");
    assert!(film["size"].as_u64().unwrap() > 20_000, "{film}");
    page.no_errors();
}

#[test]
fn another_policy_like_clips_and_control_points_are_at_hand() {
    const READY: &str = "!studio.view.building && studio.head.known + 1 >= studio.head.frames";
    let folder = tempfile::tempdir().unwrap();
    let Some(browser) = Browser::start(folder.path()) else { return };
    let served = Served::start(folder.path(), "examples/hello");
    let mut page = Page::open(browser, &served.address);
    page.until("physics", &format!("studio.head?.frames > 120 && {READY}"));

    // Another policy performs; the take of the first is a ghost beside it.
    page.run("const s = document.querySelector('.panel select'); s.value = 'lima-blind'; s.dispatchEvent(new Event('change'))");
    page.until(
        "the other policy",
        &format!("studio.view.scene.policy === 'lima-blind' && studio.view.kept && {READY}"),
    );
    page.until("two robots", "studio.scene.kept !== null");
    assert_eq!(page.value("studio.view.problem"), json!(""));

    // The second block is a walk: what is found is like it, and joins behind it.
    page.run("studio.link.send({ seek: (studio.view.spans[1].from + studio.view.spans[1].to) / 2 })");
    page.until("the needle", "studio.head.frame / studio.view.hz > studio.view.spans[1].from");
    page.act("similar");
    page.until("clips", "document.querySelectorAll('.panel .hit').length === 6");
    let first = page.value("studio.view.similar[1][0].clip");
    assert!(first.as_str().unwrap().contains("walk") || first.as_str().unwrap().contains("step"), "{first}");
    page.run("document.querySelector('.panel .hit').click()");
    page.until("the clip", &format!("studio.view.scene.motion[2]?.clip === {first} && {READY}"));

    // A control point of the chosen block is dragged up.
    let dots = page.value("document.querySelectorAll('.block.selected .point').length").as_u64().unwrap();
    assert!(dots > 3, "{dots} control points");
    let place = |axis: &str| {
        format!(
            "(() => {{ const r = document.querySelectorAll('.block.selected .point')[2].getBoundingClientRect(); return r.{axis} + 4; }})()"
        )
    };
    let (x, y) = (page.browser.number(&place("x")), page.browser.number(&place("y")));
    page.browser.mouse("mouseMoved", x, y);
    page.browser.mouse("mousePressed", x, y);
    page.browser.mouse("mouseMoved", x, y - 12.0);
    page.browser.mouse("mouseReleased", x, y - 12.0);
    page.until("a changed point", &format!("studio.view.scene.motion[1].points?.[0]?.gain > 1.1 && {READY}"));
    assert_eq!(page.value("studio.view.problem"), json!(""));
    assert_eq!(page.value("document.querySelectorAll('.block.selected .point.changed').length"), json!(1));
    page.no_errors();
}

#[test]
fn a_module_that_throws_is_seen() {
    let folder = tempfile::tempdir().unwrap();
    let Some(browser) = Browser::start(folder.path()) else { return };
    let served = Served::start(folder.path(), "a.scene.toml");
    let mut page = Page::open(browser, &served.address);
    page.run("setTimeout(() => studio.missing.part, 0), 1");
    within(10, "the error", || {
        page.value("1");
        page.browser.errors().iter().any(|error| error.contains("Cannot read properties of undefined"))
    });
}

/// Times on the screen of this machine, printed for `docs/results/studio.md`; nothing is asserted of them.
#[test]
#[ignore = "measures the machine"]
fn times_on_the_screen() {
    // Until the first picture after the answer is complete: pixels that are read wait for it.
    const PUSH: &str =
        "(async () => { const { scene, link } = studio; const take = scene.frame.bind(scene); let at = null;
        scene.frame = (packet) => { const head = take(packet); if (head.force > 0) at ??= scene.drawn; return head; };
        while (scene.head.force > 0) await new Promise((next) => requestAnimationFrame(next));
        const began = performance.now();
        scene.push('pelvis', [20, 0, 0]);
        do await new Promise((next) => requestAnimationFrame(next)); while (at === null || scene.drawn <= at);
        const { gl } = scene.stage;
        gl?.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
        const took = performance.now() - began; delete scene.frame; link.send('release'); return took; })()";
    const SAY: &str = "(async () => { const began = performance.now(); const { length } = studio.view.spans;
        studio.link.operate({ do: 'say', text: 'a person waves' });
        do await new Promise((next) => requestAnimationFrame(next));
        while (studio.view.spans.length === length || studio.head.building || studio.head.known <= studio.head.frame);
        return performance.now() - began; })()";
    let folder = tempfile::tempdir().unwrap();
    let Some(browser) = Browser::start(folder.path()) else { return };
    let served = Served::start(folder.path(), "a.scene.toml");
    let mut page = Page::open(browser, &served.address);
    let sorted = |mut times: Vec<f64>| {
        times.sort_by(f64::total_cmp);
        times
    };
    let said = sorted((0..10).map(|_| page.browser.number(SAY)).collect());
    println!("sentence to its motion on the screen: median {:.0} ms, worst {:.0} ms", said[5], said[9]);
    let mut pushed = Vec::new();
    for i in 0..40 {
        if i % 10 == 0 {
            page.run("studio.link.send({ seek: 0 }); studio.link.send({ play: true })");
            page.until("the start", "studio.head.playing && studio.head.frame < 50");
        }
        pushed.push(page.browser.number(PUSH));
    }
    let pushed = sorted(pushed);
    println!("push to a changed picture: median {:.0} ms, p95 {:.0} ms", pushed[20], pushed[38]);
    page.run("studio.link.send({ seek: 0 }); studio.link.send({ play: true })");
    std::thread::sleep(std::time::Duration::from_secs(3));
    let before = page.browser.number("studio.scene.drawn");
    std::thread::sleep(std::time::Duration::from_secs(5));
    let drawn = (page.browser.number("studio.scene.drawn") - before) / 5.0;
    let scale = page.browser.number("studio.scene.scale");
    println!("pictures a second at 1280 x 720: {drawn:.1}, drawn at {scale:.2} of the width");
}

/// Returns a BVH file of a person of 1.56 m: a wave of lima, twice as large.
fn capture(folder: &Path) -> String {
    for arguments in [
        &["motion", "trim", "builtin:wave", "--end", "3", "-o", "clips"][..],
        &["motion", "convert", "clips/wave-trimmed.motion.safetensors", "small.bvh"],
    ] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lifelike"));
        let output = command.args(arguments).current_dir(folder).env("XDG_CACHE_HOME", folder.join("cache")).output();
        assert!(output.unwrap().status.success(), "{arguments:?}");
    }
    let text = std::fs::read_to_string(folder.join("small.bvh")).unwrap();
    let twice = |word: &str| word.parse::<f64>().map_or(word.to_string(), |number| (2.0 * number).to_string());
    let mut moves = false;
    let line = |line: &str| {
        let words: Vec<&str> = line.split_whitespace().collect();
        let places = match words.first() {
            Some(&"OFFSET") => 4,
            Some(_) if moves => 3,
            _ => 0,
        };
        moves |= line.starts_with("Frame Time");
        let words =
            words.iter().enumerate().map(|(i, word)| if i < places { twice(word) } else { (*word).to_string() });
        words.collect::<Vec<_>>().join(" ") + "\n"
    };
    text.lines().map(line).collect()
}
