//! Every kind of broken file gives an error that names the line.

use super::*;

/// Returns the line that an error names, and its text.
fn line_of<T: std::fmt::Debug>(result: Result<T, MotionError>) -> (usize, String) {
    let error = result.unwrap_err();
    match &error {
        MotionError::Parse { line, .. } => (*line, error.to_string()),
        _ => (0, error.to_string()),
    }
}

/// Readers by white space take the frames in any lines; a number too few or too many is refused all the same.
#[test]
fn frames_of_a_bvh_may_be_wrapped() {
    let truth = super::bvh(BVH.as_bytes()).unwrap();
    let at = BVH.find("Frame Time").unwrap();
    let (head, frames) = BVH.split_at(at + BVH[at..].find('\n').unwrap() + 1);
    let tokens: Vec<&str> = frames.split_whitespace().collect();
    for width in [7, 10, tokens.len()] {
        let lines = |tokens: &[&str]| tokens.chunks(width).map(|line| line.join(" ") + "\n").collect::<String>();
        let wrapped = super::bvh((head.to_owned() + &lines(&tokens)).as_bytes()).unwrap();
        assert_eq!((&wrapped.root_position, &wrapped.rotations), (&truth.root_position, &truth.rotations));
        super::bvh((head.to_owned() + &lines(&tokens[1..])).as_bytes()).unwrap_err();
    }
}

#[test]
fn a_root_that_jumps_is_named() {
    // 1e9 units away and back, in the second of two frames.
    let (head, last) = BVH.trim_end().rsplit_once('\n').unwrap();
    let (_, rest) = last.trim().split_once(char::is_whitespace).unwrap();
    let (line, message) = line_of(super::bvh(format!("{head}\n1000000000 {rest}\n").as_bytes()));
    assert_eq!(line, BVH.lines().count());
    assert!(message.contains("units in frame 2: correct the number"), "{message}");
}

#[test]
fn bvh() {
    let lines = BVH.lines().count();
    let motion = BVH.lines().position(|l| l == "MOTION").unwrap() + 1;
    let swap = |from: &str, to: &str| BVH.replacen(from, to, 1);
    let short = BVH.trim_end().rsplit_once('\n').unwrap().0;
    for (text, line, part) in [
        (String::new(), 1, "HIERARCHY"),
        ("garbage".to_owned(), 1, "HIERARCHY"),
        (swap("ROOT Hips", "JOINT Hips"), 2, "ROOT"),
        (swap("OFFSET 0 0 0", "OFFSET 0 nan 0"), 4, "three numbers"),
        (swap("OFFSET 0 0 0", "OFFSET 0 0"), 4, "three numbers"),
        (swap("OFFSET 0 0 0", "OFFSET 0 0 0 0"), 4, "no more"),
        (swap("OFFSET 0 0 0", "OFFSET 0 1e400 0"), 4, "three numbers"),
        (swap("CHANNELS 6", "CHANNELS 7"), 5, "count of channels"),
        (swap("Xposition", "Wposition"), 5, "a channel"),
        (swap("Yposition", "Xposition"), 5, "each once"),
        (swap("JOINT Spine", "JOINT Hips"), 6, "no other joint"),
        (swap("JOINT Spine", "JOINT"), 6, "a joint's name"),
        (swap("Frames: 2", "Frames: 999999999999"), motion + 1, "at most 1000000 frames"),
        (swap("Frames: 2", "Frames: 999999"), lines, "999999 frames"),
        (swap("Frames: 2", "Frames: 99999999999999999999999"), motion + 1, "Frames: <count>"),
        (swap("Frames: 2", "Frames: -1"), motion + 1, "Frames: <count>"),
        (swap("Frames: 2", "Frames: 0"), lines, "0 frames"),
        (swap("Frame Time: 0.0083333", "Frame Time: 0"), motion + 2, "a frame time"),
        (swap("Frame Time: 0.0083333", "Frame Time: NaN"), motion + 2, "Frame Time"),
        (format!("{short}\n1 2 3"), lines, "a number for each channel"),
        (swap(" 48.35", " inf"), lines - 1, "").to_owned(),
        (swap("MOTION", "ROOT Other"), motion, "one skeleton"),
        (format!("{} 1 2\n", BVH.trim_end()), lines, "45 numbers, one per channel, got 47 numbers"),
        (format!("{BVH}\u{1a}"), lines + 1, "got \\u{1a}"),
        (format!("{BVH}1 2 3"), lines + 1, "a number for each channel"),
        (short.to_owned(), lines - 1, "2 frames"),
        (BVH[..200].to_owned(), 0, ""),
    ] {
        if part.is_empty() {
            continue;
        }
        let (got, message) = line_of(super::bvh(text.as_bytes()));
        assert!(got == line && message.contains(part), "line {line} '{part}': {message}");
    }
    for cut in 0..BVH.trim_end().len() {
        // A number cut short is another number; all other cuts are errors with a line of the text.
        let text = &BVH[..cut];
        if let Err(error) = super::bvh(text.as_bytes()) {
            let (line, message) = line_of::<()>(Err(error));
            assert!((1..=text.lines().count() + 1).contains(&line), "{message}");
        } else {
            assert!(text.lines().count() == lines, "a cut in line {} went unseen", text.lines().count());
        }
    }
    for value in ["nan", "inf", "-inf", "1e300", "0x10", "1,5", "--3"] {
        let spoilt = BVH.replacen("Frame Time: 0.0083333\n", &format!("Frame Time: 0.0083333\n{value} "), 1);
        let (line, message) = line_of(super::bvh(spoilt.as_bytes()));
        assert!(line == motion + 3 && message.contains("a number for each channel"), "{message}");
    }
    let deep: String = (0..5000).map(|i| format!("JOINT j{i}\n{{\nCHANNELS 1 Xrotation\n")).collect();
    let (line, message) =
        line_of(super::bvh(format!("HIERARCHY\nROOT r\n{{\nCHANNELS 1 Xrotation\n{deep}").as_bytes()));
    assert!(line > 3000 && message.contains("at most 1000 joints"), "{message}");
    let (line, message) = line_of(super::bvh(b"HIERARCHY\nROOT r\n{\nOFFSET 0 0 0\n}\nMOTION"));
    assert!(line == 6 && message.contains("CHANNELS of some joint"), "{message}");
}

#[test]
fn asf() {
    let swap = |from: &str, to: &str| ASF.replacen(from, to, 1);
    let at = |part: &str| ASF.lines().position(|l| l.contains(part)).unwrap() + 1;
    for (text, line, part) in [
        (swap("length 0.45", "length 0"), at("length 0.45"), "a unit of length"),
        (swap("length 0.45", "length NaN"), at("length 0.45"), "a unit of length"),
        (swap("angle deg", "angle grad"), at("angle deg"), "deg or rad"),
        (swap("order TX TY TZ RX RY RZ", "order TX TX"), at("order"), "each once"),
        (swap("axis XYZ", "axis XYX"), at("axis XYZ"), "an order of axes"),
        (swap("direction 0.342 -0.94 0", "direction 0 0 0"), at("end"), "not zero"),
        (swap("length 7", "length seven"), at("length 7"), "a length"),
        (swap("name lfoot", "name lfemur"), 0, "no other bone"),
        (swap("     name lfoot\n", ""), 0, "name, direction and length"),
        (swap("    lfemur lfoot", "    lfemur lhand"), at("lfemur lfoot"), "a bone of :bonedata"),
        (swap("    lfemur lfoot", "    lfemur root"), at("lfemur lfoot"), "no parent yet"),
        (swap("    lfemur lfoot\n", ""), 0, "bone 'lfoot' that is not"),
        (swap("root lfemur", "root"), 0, "every bone linked"),
        (swap("dof rx rz", "dof rx qq"), at("dof rx rz"), "rx, ry or rz"),
        (ASF.split(":hierarchy").next().unwrap().to_owned(), 0, "':hierarchy'"),
        (String::new(), 0, "':root'"),
    ] {
        let (got, message) = line_of(super::asf::parse(text.as_bytes(), Path::new("x.asf")));
        assert!((line == 0 || got == line) && message.contains(part), "line {line} '{part}': {message}");
    }
    let many: String = (0..500).map(|i| format!("begin\nname b{i}\ndirection 1 0 0\nlength 1\nend\n")).collect();
    let (_, message) = line_of(super::asf::parse(format!(":bonedata\n{many}").as_bytes(), Path::new("x.asf")));
    assert!(message.contains("at most 128 bones"), "{message}");
}

#[test]
fn amc() {
    let swap = |from: &str, to: &str| AMC.replacen(from, to, 1);
    for (text, line, part) in [
        (swap("lfoot 12 -33", "lfoot 12"), 7, "each degree of freedom"),
        (swap("lfoot 12 -33", "lfoot 12 -33 4"), 7, "2 numbers for 'lfoot'"),
        (swap("lfoot 12 -33", "lfoot 12 inf"), 7, "each degree of freedom"),
        (swap("lfoot 12 -33", "lhand 12 -33"), 7, "a bone of the ASF"),
        (swap("lfoot 12 -33\n", ""), 7, "bone 'lfoot' in frame 1"),
        (swap("lfoot 12 -33", "lfemur 1 2 3"), 7, "each bone once"),
        (swap("\n2\n", "\n4\n"), 8, "a frame that follows 1"),
        (swap("\n2\n", "\n99999999999999999999999999\n"), 8, "a frame's number"),
        (swap("\n1\n", "\n"), 4, "a frame's number before"),
        (swap(":DEGREES", ":GRADS"), 3, ":RADIANS"),
        ("#".to_owned(), 1, "at least one frame"),
        (String::new(), 0, "at least one frame"),
    ] {
        let (got, message) = line_of(acclaim(ASF.as_bytes(), text.as_bytes()));
        assert!(got == line && message.contains(part), "line {line} '{part}': {message}");
    }
    let skeleton = super::asf::parse(ASF.as_bytes(), Path::new("x.asf")).unwrap();
    let options = ReadOptions { fps: Some(f64::NAN), ..ReadOptions::default() };
    assert!(super::amc::parse(AMC.as_bytes(), Path::new("x.amc"), &skeleton, &options).is_err());
}

#[test]
fn deepmimic() {
    let swap = |from: &str, to: &str| DEEPMIMIC.replacen(from, to, 1);
    for (text, part) in [
        (swap("[0.0333333,", "[0.0333333, 7,"), "13 numbers in frame 0"),
        (swap("[0.0333333,", "[0.0,"), "a duration up to 1 s of frame 0"),
        (swap("[0.0333333,", "[1e6,"), "a duration up to 1 s of frame 0"),
        (swap("0.9, 0.1, -0.2, 0.3", "0, 0, 0, 0"), "quaternions of a rotation in frame 0"),
        (swap("-0.7]", "1e300]"), "below a million in frame 0"),
        (r#"{"Loop": "none", "Frames": []}"#.to_owned(), "at least two frames"),
        (swap("-0.7]", "NaN]"), "y.txt:2:"),
        (swap("-0.7]", "1e999]"), "y.txt:2:"),
        (swap("\"Loop\"", "\"Lop\""), "missing field `Loop`"),
        (DEEPMIMIC[..60].to_owned(), "y.txt:2:"),
        ("[".repeat(100_000), "y.txt:1:"),
    ] {
        let (_, message) = line_of(super::deepmimic(CHARACTER.as_bytes(), text.as_bytes()));
        assert!(message.contains(part), "'{part}': {message}");
    }
    for (from, to, part) in [
        ("\"Parent\": 2", "\"Parent\": 3", "parents before children"),
        ("\"Parent\": 2", "\"Parent\": -1", "one root first"),
        ("\"revolute\"", "\"prismatic\"", "'prismatic'"),
        ("-0.42", "1e12", "within 100 m"),
    ] {
        let (_, message) = line_of(super::deepmimic(CHARACTER.replacen(from, to, 1).as_bytes(), DEEPMIMIC.as_bytes()));
        assert!(message.contains(part), "'{part}': {message}");
    }
}

#[test]
fn a_long_frame_does_not_make_a_huge_motion() {
    let rows: Vec<String> =
        (0..50).map(|i| format!("[{}, 0,0,0, 1,0,0,0, 1,0,0,0, 0]", if i == 0 { 0.00002 } else { 1.0 })).collect();
    let text = format!("{{\"Loop\": \"none\", \"Frames\": [{}]}}", rows.join(","));
    let (_, message) = line_of(super::deepmimic(CHARACTER.as_bytes(), text.as_bytes()));
    assert!(message.contains("about as long as the first"), "{message}");
}

#[test]
fn encodings() {
    let utf16: Vec<u8> = [0xff, 0xfe].into_iter().chain(BVH.bytes().flat_map(|b| [b, 0])).collect();
    let (line, message) = line_of(super::bvh(&utf16));
    assert!(line == 1 && message.contains("UTF-16"), "{message}");
    let unmarked: Vec<u8> = BVH.bytes().flat_map(|b| [b, 0]).collect();
    let (line, message) = line_of(super::bvh(&unmarked));
    assert!(line == 1 && message.contains("a NUL byte"), "{message}");
    let mut latin = BVH.as_bytes().to_vec();
    let at = BVH.find("JOINT Spine").unwrap() + 8;
    latin[at] = 0xe9;
    let (line, message) = line_of(super::bvh(&latin));
    assert!(line == 6 && message.contains("byte 0xe9"), "{message}");
    let marked: Vec<u8> = [0xef, 0xbb, 0xbf].into_iter().chain(BVH.bytes()).collect();
    assert_eq!(super::bvh(&marked).unwrap(), super::bvh(BVH.as_bytes()).unwrap());
    let windows = BVH.replace('\n', "\r\n");
    assert_eq!(super::bvh(windows.as_bytes()).unwrap(), super::bvh(BVH.as_bytes()).unwrap());
}
