//! A joint that sets out early enough to be in time.

use crate::retarget::smooth::limit_speed;

/// Limits how far a joint goes in one frame (`step`) without changing it where it must be as it is: at home, outside
/// of all windows, and in the keys' frames. If the way to a key is too long for the step, the joint comes as near to
/// it as it can. The frames at home must keep the step among themselves.
pub(super) fn pace(values: &mut [f64], step: f64, home: &[bool], keys: &[usize]) {
    let before = values.to_vec();
    let mut room: Vec<(f64, f64)> = values
        .iter()
        .zip(home)
        .map(|(v, home)| if *home { (*v, *v) } else { (f64::NEG_INFINITY, f64::INFINITY) })
        .collect();
    spread(&mut room, step);
    for &key in keys {
        let pinned = values[key].max(room[key].0).min(room[key].1);
        room[key] = (pinned, pinned);
        spread(&mut room, step);
    }
    // Within these bounds, limiting meets all fixed frames: they are reached from wherever it may be before them.
    for (value, (low, high)) in values.iter_mut().zip(&room) {
        *value = value.max(*low).min(*high);
    }
    limit_speed(values, step);
    // Home is met up to rounding; it is to be untouched.
    for ((value, old), _) in values.iter_mut().zip(&before).zip(home).filter(|(_, home)| **home) {
        *value = *old;
    }
}

/// Narrows each frame's bounds to what its neighbours' leave to it.
fn spread(room: &mut [(f64, f64)], step: f64) {
    for t in 1..room.len() {
        let (low, high) = room[t - 1];
        room[t] = (room[t].0.max(low - step), room[t].1.min(high + step));
    }
    for t in (1..room.len()).rev() {
        let (low, high) = room[t];
        room[t - 1] = (room[t - 1].0.max(low - step), room[t - 1].1.min(high + step));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_late_rise_begins_earlier_and_meets_its_key() {
        let home: Vec<bool> = (0..11).map(|t| t == 0 || t == 10).collect();
        // To 0.4 in one step and back in one.
        let mut values = vec![0.0; 11];
        values[5] = 0.4;
        pace(&mut values, 0.1, &home, &[5]);
        let expected = [0.0, 0.0, 0.1, 0.2, 0.3, 0.4, 0.3, 0.2, 0.1, 0.0, 0.0];
        assert!(values.iter().zip(expected).all(|(v, e)| (v - e).abs() < 1e-12), "{values:?}");
    }

    #[test]
    fn what_is_too_far_is_approached_and_what_is_slow_is_untouched() {
        let home: Vec<bool> = (0..7).map(|t| t == 0 || t == 6).collect();
        let mut far = vec![0.0, 0.0, 0.0, 9.0, 0.0, 0.0, 0.0];
        pace(&mut far, 0.1, &home, &[3]);
        assert!((far[3] - 0.3).abs() < 1e-12 && far[6] == 0.0, "{far:?}");
        let slow = vec![0.0, 0.03, 0.06, 0.1, 0.06, 0.03, 0.0];
        let mut same = slow.clone();
        pace(&mut same, 0.1, &home, &[3]);
        assert_eq!(same, slow);
    }
}
