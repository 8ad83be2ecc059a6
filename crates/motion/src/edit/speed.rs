//! Joint speeds that an actuator cannot follow.

use std::collections::BTreeMap;

use crate::clip::MotionClip;

/// A joint that is asked to be faster than it can.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct TooFast {
    /// The joint.
    pub joint: String,
    /// Its largest speed (rad/s or m/s).
    pub speed: f64,
    /// Largest speed of its actuator (rad/s or m/s).
    pub limit: f64,
    /// When it is fastest (s).
    pub time: f64,
    /// Steps between frames in which it is too fast.
    pub frames: usize,
}

/// Returns the joints that exceed their limit between two frames, the worst first. `limits` are speeds by joint name
/// (rad/s or m/s); a joint of which it says nothing has none.
pub fn too_fast(clip: &MotionClip, limits: &BTreeMap<String, f64>) -> Vec<TooFast> {
    let find = |(at, joint): (usize, &String)| {
        let limit = *limits.get(joint)?;
        // Motion that was limited to just this speed is not too fast.
        let least = limit * (1.0 + 1e-9);
        let values = super::joints::column(clip, at);
        let speeds: Vec<f64> = values.windows(2).map(|w| (w[1] - w[0]).abs() * clip.fps).collect();
        let (step, speed) = speeds.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let frames = speeds.iter().filter(|s| **s > least).count();
        let time = step as f64 / clip.fps;
        (frames > 0).then(|| TooFast { joint: joint.clone(), speed, limit, time, frames })
    };
    let mut found: Vec<TooFast> = clip.joint_names.iter().enumerate().filter_map(find).collect();
    found.sort_by(|a, b| (b.speed / b.limit).total_cmp(&(a.speed / a.limit)));
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::clip;

    #[test]
    fn the_fastest_step_is_told() {
        // 0.1 rad in the step after 0.5 s, at 50 Hz: 5 rad/s.
        let c = clip(51, |t| [if t > 0.51 { 0.1 } else { 0.0 }, t]);
        let limits = [("hinge".to_string(), 4.0), ("slide".to_string(), 1.0)].into();
        let found = too_fast(&c, &limits);
        assert_eq!(found.len(), 1, "1 m/s is what the slide can: {found:?}");
        assert!((found[0].speed - 5.0).abs() < 1e-9 && found[0].frames == 1);
        assert!((found[0].time - 0.5).abs() < 1e-9);
        assert!(too_fast(&c, &BTreeMap::new()).is_empty());
    }
}
