//! Windows of motion that are alike: the nearest codes by cosine similarity (thesis 4.3.2, Fig. 4.3).

use super::codes::Codes;
use crate::{FromInput, RepresentationError};

/// Criteria of a search: what counts as another hit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SearchSpec {
    /// Most hits.
    pub count: usize,
    /// Hits of one clip are at least so far apart (s): the window one frame later is hardly another one.
    pub apart: f64,
}

impl Default for SearchSpec {
    fn default() -> Self {
        Self { count: 5, apart: 0.5 }
    }
}

/// A frame whose window is not to be found: the query's own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Origin {
    /// Its clip, as a number in the codes.
    pub clip: usize,
    /// Its time (s).
    pub time: f64,
    /// Length of a window (s): frames nearer than that overlap the query.
    pub window: f64,
}

/// A window that was found.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Hit {
    /// The clip.
    pub clip: String,
    /// The window's centre (s).
    pub time: f64,
    /// Cosine of the angle between the codes.
    pub similarity: f64,
}

/// Returns the frames whose codes are most similar to the query's, best first.
///
/// # Shapes
/// `query: [d]`.
///
/// # Errors
/// A query of another size than the codes.
pub fn search(
    codes: &Codes,
    query: &[f32],
    origin: Option<Origin>,
    spec: &SearchSpec,
) -> Result<Vec<Hit>, RepresentationError> {
    if query.len() != codes.dimension() {
        let expected = format!("{} numbers", codes.dimension());
        return Err(RepresentationError::mismatch("code to search for", expected, query.len()));
    }
    let mut frames: Vec<(usize, usize, f64)> = Vec::with_capacity(codes.len());
    for (clip, rows) in codes.clips().enumerate() {
        let start = rows.start;
        frames.extend(rows.map(|row| (clip, row - start, cosine(query, codes.row(row)))));
    }
    // The sort is stable: of equals the first clip's first frame comes first.
    frames.sort_by(|a, b| b.2.total_cmp(&a.2));
    let mut found: Vec<(usize, f64, f64)> = Vec::new();
    for (clip, frame, similarity) in frames {
        if found.len() >= spec.count {
            break;
        }
        let time = frame as f64 / codes.fps();
        let own = origin.is_some_and(|o| o.clip == clip && near(time, o.time, o.window));
        if !own && !found.iter().any(|f| f.0 == clip && near(time, f.1, spec.apart)) {
            found.push((clip, time, similarity));
        }
    }
    let hit = |(clip, time, similarity): (usize, f64, f64)| Hit { clip: codes.names()[clip].clone(), time, similarity };
    Ok(found.into_iter().map(hit).collect())
}

/// Returns whether two times are less than `apart` from each other; rounding does not make them so.
fn near(a: f64, b: f64, apart: f64) -> bool {
    (a - b).abs() < apart - 1e-9
}

/// Returns the cosine of the angle between two codes; 0 where one of them has no direction.
pub fn cosine(a: &[f32], b: &[f32]) -> f64 {
    let dot = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum::<f64>();
    let lengths = (dot(a, a) * dot(b, b)).sqrt();
    if lengths > 0.0 { dot(a, b) / lengths } else { 0.0 }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Directions (deg) as codes of different lengths.
    fn codes(clips: &[&[f32]]) -> Codes {
        let names = (0..clips.len()).map(|i| format!("clip_{i}")).collect();
        let mut starts = vec![0];
        clips.iter().for_each(|c| starts.push(starts[starts.len() - 1] + c.len()));
        let code = |(i, angle): (usize, &f32)| {
            let (s, c) = angle.to_radians().sin_cos();
            [c * (i + 1) as f32, s * (i + 1) as f32]
        };
        let rows = clips.iter().flat_map(|c| c.iter()).enumerate().flat_map(code).collect();
        Codes::new(names, starts, rows, 2, 10.0).unwrap()
    }

    fn places(hits: &[Hit]) -> Vec<(String, f64)> {
        hits.iter().map(|h| (h.clip.clone(), h.time)).collect()
    }

    #[test]
    fn by_hand() {
        assert_eq!(cosine(&[3.0, 0.0], &[0.0, 2.0]), 0.0);
        assert!((cosine(&[1.0, 1.0], &[2.0, 0.0]) - 0.5_f64.sqrt()).abs() < 1e-12);
        assert_eq!(cosine(&[0.0, 0.0], &[1.0, 0.0]), 0.0);
    }

    #[test]
    fn neighbours_of_a_hit_are_no_other_hits() {
        // 10 codes per second, at least 0.3 s apart: frame 1 takes frames 0, 2 and 3 with it, and not frame 4.
        let codes = codes(&[&[5.0, 1.0, 2.0, 3.0, 6.0, 90.0], &[4.0, 180.0]]);
        let spec = SearchSpec { count: 4, apart: 0.3 };
        let hits = search(&codes, &[7.0, 0.0], None, &spec).unwrap();
        let expected = [("clip_0", 0.1), ("clip_1", 0.0), ("clip_0", 0.4), ("clip_1", 0.1)];
        // The last one is too near to clip_1's first; only three remain.
        assert_eq!(places(&hits), expected[..3].iter().map(|(n, t)| (n.to_string(), *t)).collect::<Vec<_>>());
        assert!((hits[0].similarity - 1.0_f64.to_radians().cos()).abs() < 1e-6);
        assert!(hits.windows(2).all(|w| w[0].similarity >= w[1].similarity));
    }

    #[test]
    fn the_query_does_not_find_itself() {
        let codes = codes(&[&[0.0, 1.0, 2.0, 3.0], &[50.0]]);
        let origin = Origin { clip: 0, time: 0.0, window: 0.2 };
        let hits = search(&codes, codes.row(0), Some(origin), &SearchSpec { count: 1, apart: 0.1 }).unwrap();
        assert_eq!(places(&hits), [("clip_0".to_string(), 0.2)], "0.1 s away overlaps, 0.2 s away does not");
        assert!(search(&codes, &[1.0], None, &SearchSpec::default()).is_err());
    }
}
