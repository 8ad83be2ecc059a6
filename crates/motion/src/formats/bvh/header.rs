//! The lines between hierarchy and frames: count and rate, as they are found in the wild.

use crate::error::MotionError;
use crate::formats::raw;
use crate::formats::text::Lines;

/// Rates that cameras, suits and exporters have (frames per second).
const USUAL_RATES: [f64; 19] = [
    24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 72.0, 75.0, 90.0, 96.0, 100.0, 120.0, 144.0, 150.0, 180.0, 200.0, 240.0, 250.0,
    300.0,
];
/// Longer frames (s) are no motion: the number has another unit.
const LONGEST_FRAME: f64 = 1.0;

/// Longer frames (s) do not show steps of a walk.
const SLOW_FRAME: f64 = 0.1;

/// Count and rate of the frames.
pub(super) struct Header {
    pub frames: usize,
    /// Line of the count.
    pub line: usize,
    pub fps: f64,
}

impl Header {
    /// Reads `Frames:` and `Frame Time:`. At most `most_frames` are allowed. `fps` overrides the file's rate.
    pub(super) fn parse(
        lines: &mut Lines<'_>,
        most_frames: usize,
        fps: Option<f64>,
        notes: &mut Vec<String>,
    ) -> Result<Self, MotionError> {
        const COUNT: &str = "'Frames: <count>'";
        const TIME: &str = "'Frame Time: <seconds>'";
        let text = lines.expect(COUNT)?;
        let Some(Ok(frames)) = value_of(text, &["frames"]).map(str::parse::<usize>) else {
            return Err(lines.error(COUNT, text));
        };
        if frames > most_frames {
            return Err(lines.error(format!("at most {most_frames} frames of this skeleton"), text));
        }
        let line = lines.number();
        let text = lines.expect(TIME)?;
        let Some(value) = value_of(text, &["frame", "time"]) else { return Err(lines.error(TIME, text)) };
        if let Some(fps) = fps {
            return Ok(Self { frames, line, fps });
        }
        let time = lines.number_in(Some(value), TIME)?;
        if time <= 1e-5 {
            return Err(lines.error("a frame time above 0.00001 s, or --fps RATE", &time.to_string()));
        }
        if time <= LONGEST_FRAME {
            if time > SLOW_FRAME {
                let fps = raw::rate(time);
                notes.push(format!(
                    "line {}: {fps:.3} frames per second: motion between frames is interpolated (--fps RATE if it was faster)",
                    lines.number()
                ));
            }
            return Ok(Self { frames, line, fps: raw::rate(time) });
        }
        let (fps, unit) = match (usual_rate(1000.0 / time), usual_rate(time)) {
            (Some(fps), None) => (fps, "milliseconds"),
            (None, Some(fps)) => (fps, "a rate"),
            _ => {
                let expected = format!("a frame time of at most {LONGEST_FRAME} s, or --fps RATE");
                return Err(lines.error(expected, text));
            }
        };
        notes.push(format!(
            "line {}: the frame time {value} was read as {unit}: {fps} frames per second (--fps overrides it)",
            lines.number()
        ));
        Ok(Self { frames, line, fps })
    }
}

/// Returns the usual rate within 0.5%.
fn usual_rate(fps: f64) -> Option<f64> {
    USUAL_RATES.into_iter().find(|usual| (fps - usual).abs() < 5e-3 * usual)
}

/// Returns what follows these words and a colon, in any case and with or without spaces.
fn value_of<'a>(line: &'a str, words: &[&str]) -> Option<&'a str> {
    let mut rest = line;
    for word in words {
        let start = rest.get(..word.len())?;
        if !start.eq_ignore_ascii_case(word) {
            return None;
        }
        rest = rest.get(word.len()..)?.trim_start();
    }
    Some(rest.strip_prefix(':').unwrap_or(rest).trim())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::path::Path;

    fn rate(time: &str) -> Result<f64, String> {
        let text = format!("FRAMES : 3\nframe time:{time}");
        let mut lines = Lines::new(&text, Path::new("x.bvh"));
        let mut notes = Vec::new();
        let header = Header::parse(&mut lines, 10, None, &mut notes).map_err(|e| e.to_string())?;
        assert_eq!(header.frames, 3);
        assert_eq!(notes.len(), usize::from(time.parse::<f64>().unwrap() > SLOW_FRAME), "{notes:?}");
        Ok(header.fps)
    }

    #[test]
    fn frame_times_in_other_units_are_told_apart() {
        for (time, fps) in [
            ("0.0083333", 120.0),
            ("0.5", 2.0),
            ("30", 30.0),
            ("120", 120.0),
            ("60.0", 60.0),
            ("33.333333", 30.0),
            ("8.33333", 120.0),
            ("16.6667", 60.0),
            ("41.7", 24.0),
        ] {
            assert_eq!(rate(time), Ok(fps), "{time}");
        }
        // No usual rate either way.
        for time in ["7", "1000", "1.5"] {
            assert!(rate(time).unwrap_err().contains("--fps"), "{time}");
        }
    }
}
