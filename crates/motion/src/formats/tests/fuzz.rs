//! Random and spoilt files: an error or a clip, never a panic, and every line named is one of the file.

use proptest::prelude::*;

use super::*;

/// Checks an answer that any reader may give.
fn check(result: Result<SourceClip, MotionError>, bytes: &[u8]) -> Result<(), TestCaseError> {
    match result {
        Ok(clip) => {
            prop_assert!(!clip.is_empty() && clip.fps > 0.0);
            // So that a small file cannot stand for a huge motion.
            prop_assert!(clip.len() * clip.skeleton.names.len() <= 16 * bytes.len() + 128);
            let finite = clip.rotations.iter().flatten().all(|q| q.coords.iter().all(|c| c.is_finite()));
            prop_assert!(finite && clip.root_position.iter().all(|p| p.iter().all(|c| c.is_finite())));
        }
        Err(MotionError::Parse { line, expected, got, .. }) => {
            let lines = bytes.iter().filter(|b| **b == b'\n').count() + 1;
            prop_assert!(line <= lines + 1, "line {line} of {lines}");
            prop_assert!(expected.len() < 200 && got.len() < 300);
        }
        Err(MotionError::Input(_) | MotionError::Unfit { .. }) => {}
        Err(other) => prop_assert!(false, "{other}"),
    }
    Ok(())
}

fn all_readers(bytes: &[u8]) -> Result<(), TestCaseError> {
    for format in FORMATS {
        // Readers that need a file beside theirs fail for want of it; further down they have one.
        match format.reader {
            Reader::Source(read) => drop(read(bytes, Path::new("no/folder/x"), &ReadOptions::default())),
            Reader::Robot(read) => drop(read(bytes, Path::new("no/folder/x"), &ReadOptions::default())),
        }
    }
    check(bvh(bytes), bytes)?;
    check(acclaim(bytes, AMC.as_bytes()), &[bytes, AMC.as_bytes()].concat())?;
    check(acclaim(ASF.as_bytes(), bytes), bytes)?;
    check(deepmimic(bytes, DEEPMIMIC.as_bytes()), &[bytes, DEEPMIMIC.as_bytes()].concat())?;
    check(deepmimic(CHARACTER.as_bytes(), bytes), bytes)
}

/// Returns text that readers may trip over.
fn nasty() -> impl Strategy<Value = String> {
    prop_oneof![
        Just("nan".to_owned()),
        Just("-inf".to_owned()),
        Just("1e308".to_owned()),
        Just("-1e-320".to_owned()),
        Just("999999999999".to_owned()),
        Just("18446744073709551616".to_owned()),
        Just("-1".to_owned()),
        Just("\u{0}".to_owned()),
        Just("\u{fc}\u{2028}\u{feff}".to_owned()),
        Just("{".to_owned()),
        Just("}\n".to_owned()),
        Just("\n\r\n".to_owned()),
        Just("End Site".to_owned()),
        Just("MOTION\nFrames: 3\n".to_owned()),
        "[ -~]{0,12}",
    ]
}

proptest! {
    #[test]
    fn random_bytes(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        all_readers(&bytes)?;
    }

    #[test]
    fn random_words(words in prop::collection::vec("(HIERARCHY|ROOT|JOINT|End|OFFSET|CHANNELS|MOTION|Frames:|begin|end|:root|:bonedata|:hierarchy|name|[{}]|\n|[a-z]{1,3}|-?[0-9]{1,6}(\\.[0-9]{1,3})?)", 0..80)) {
        all_readers(words.join(" ").as_bytes())?;
    }

    #[test]
    fn spoilt_files(
        which in 0..5usize,
        spots in prop::collection::vec((0.0..1.0f64, 0..12usize, nasty()), 1..4),
        keep in 0.0..1.2f64,
    ) {
        let original = [BVH, ASF, AMC, CHARACTER, DEEPMIMIC][which];
        let mut bytes = original.as_bytes().to_vec();
        for (place, cut, put) in &spots {
            let from = (place * bytes.len() as f64) as usize;
            let to = (from + cut).min(bytes.len());
            bytes.splice(from..to, put.bytes());
        }
        bytes.truncate((keep * bytes.len() as f64) as usize);
        all_readers(&bytes)?;
        let _ = CaptionTable::parse(&bytes, Path::new("t.tsv"));
    }
}
