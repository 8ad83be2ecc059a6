//! Files as their writers write them: the same motion as the plain file, and a note where something was guessed.

use super::*;

/// Reads a variant of the small file, and checks that its motion is the small file's.
fn same(text: &str) -> Vec<String> {
    let clip = bvh(text.as_bytes()).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let plain = bvh(BVH.as_bytes()).unwrap();
    assert_eq!((&clip.root_position, &clip.rotations, clip.fps), (&plain.root_position, &plain.rotations, plain.fps));
    assert_eq!(clip.skeleton.offsets, plain.skeleton.offsets);
    clip.notes
}

#[test]
fn grammar_is_read_as_it_is_written() {
    let swap = |from: &str, to: &str| {
        assert!(BVH.contains(from), "{from}");
        BVH.replace(from, to)
    };
    let lines: Vec<&str> = BVH.lines().map(str::trim).collect();
    for text in [
        lines.join("\n").replace("\n{", " {"),
        lines.join("\n").replace("\n{\n", "{").replace("\n}", "}"),
        swap("End Site", "END SITE"),
        swap("End Site", "End Site LeftHandEnd"),
        swap("OFFSET 0 -4 12", "OFFSET 0 -4 12\nCHANNELS 0"),
        swap("Frames:", "Frames :"),
        swap("Frame Time:", "Frame time:"),
        swap("Frame Time:", "FRAMETIME:\t"),
        BVH.replace('\n', "\r"),
        swap("MOTION", "# made by hand\nMOTION\n// so was this"),
        swap("HIERARCHY", "Hierarchy").replace("ROOT", "root").replace("JOINT", "Joint").replace("OFFSET", "offset"),
    ] {
        assert_eq!(same(&text), Vec::<String>::new());
    }
}

#[test]
fn names_may_hold_spaces() {
    let text = BVH.replace("JOINT LeftUpLeg", "JOINT Bip01  L Thigh").replace("JOINT LeftLeg", "JOINT Bip01 L Calf");
    same(&text);
    assert!(bvh(text.as_bytes()).unwrap().skeleton.names.contains(&"Bip01 L Thigh".to_owned()));
}

#[test]
fn a_joint_without_channels_stays() {
    // The spine's three numbers are the seventh to ninth of a frame.
    let (head, frames) = BVH.split_once("Frame Time: 0.0083333\n").unwrap();
    let keep = |line: &str, zero: bool| {
        let numbers: Vec<&str> = line.split_whitespace().collect();
        let middle: &[&str] = if zero { &["0", "0", "0"] } else { &[] };
        [&numbers[..6], middle, &numbers[9..]].concat().join(" ")
    };
    let write = |head: &str, zero: bool| {
        let frames: Vec<String> = frames.lines().map(|line| keep(line, zero)).collect();
        format!("{head}Frame Time: 0.0083333\n{}\n", frames.join("\n"))
    };
    let spine = "OFFSET 0 20 1\n    CHANNELS 3 Zrotation Xrotation Yrotation";
    assert!(head.contains(spine));
    let still = bvh(write(&head.replace(spine, "OFFSET 0 20 1\n    CHANNELS 0"), false).as_bytes()).unwrap();
    let without = bvh(write(&head.replace(spine, "OFFSET 0 20 1"), false).as_bytes()).unwrap();
    let zero = bvh(write(head, true).as_bytes()).unwrap();
    assert_eq!(still, zero);
    assert_eq!(without, zero);
}

#[test]
fn one_frame_more_than_counted_is_read_and_said() {
    let notes = same(&BVH.replace("Frames: 2", "Frames: 1"));
    assert!(notes[0].contains("counts 1 frames, 2 were read"), "{notes:?}");
}

#[test]
fn a_rate_may_be_stated() {
    let options = ReadOptions { fps: Some(60.0), ..ReadOptions::default() };
    let read = |time: &str| {
        let text = BVH.replace("Frame Time: 0.0083333", &format!("Frame Time: {time}"));
        bvh::parse(text.as_bytes(), Path::new("x.bvh"), &options).unwrap().fps
    };
    assert_eq!((read("0.0083333"), read("0"), read("777")), (60.0, 60.0, 60.0));
    let rates = |amc: &str, options: &ReadOptions| {
        let skeleton = asf::parse(ASF.as_bytes(), Path::new("x.asf")).unwrap();
        amc::parse(amc.as_bytes(), Path::new("x.amc"), &skeleton, options).unwrap().fps
    };
    let stated = AMC.replace(":DEGREES", ":DEGREES\n:SAMPLES-PER-SECOND 60");
    assert_eq!(rates(AMC, &ReadOptions::default()), 120.0);
    assert_eq!(rates(&stated, &ReadOptions::default()), 60.0);
    assert_eq!(rates(&stated, &ReadOptions { fps: Some(30.0), ..ReadOptions::default() }), 30.0);
}

#[test]
fn acclaim_keywords_are_read_in_capitals() {
    let mut capitals = ASF.to_owned();
    for word in ["version", "name", "units", "documentation", "root", "bonedata", "hierarchy"] {
        capitals = capitals.replace(&format!(":{word}"), &format!(":{}", word.to_uppercase()));
    }
    capitals = capitals.replace("  direction", "  DIRECTION").replace("  begin", "  Begin").replace("  end", "  End");
    let plain = acclaim(ASF.as_bytes(), AMC.as_bytes()).unwrap();
    assert_eq!(acclaim(capitals.as_bytes(), AMC.as_bytes()).unwrap(), plain);
}

#[test]
fn the_cmus_unit_is_known_and_others_are_offered() {
    let scaled = |factor: f64| {
        let lines = BVH.lines().map(|line| match line.trim().strip_prefix("OFFSET ") {
            Some(rest) => {
                let values: Vec<String> =
                    rest.split_whitespace().map(|v| (v.parse::<f64>().unwrap() * factor).to_string()).collect();
                format!("OFFSET {}", values.join(" "))
            }
            None => line.to_owned(),
        });
        lines.collect::<Vec<_>>().join("\n")
    };
    // Centimetres to inches / 0.45.
    let clip = bvh(scaled(0.45 / 2.54).as_bytes()).unwrap();
    let thigh = clip.skeleton.offsets[joint(&clip, "LeftLeg")].norm();
    assert!((thigh - 0.01 * (40.0_f64.powi(2) + 4.0 + 1.0).sqrt()).abs() < 1e-9, "{thigh}");
    assert!(clip.notes[0].contains("--scale"), "{:?}", clip.notes);
    for (factor, offer) in [(1.0 / 2.54, "--scale 0.02540 if these are inches"), (0.033, "--scale 0.30480 if")] {
        let message = bvh(scaled(factor).as_bytes()).unwrap_err().to_string();
        assert!(message.contains(offer), "{message}");
    }
}
