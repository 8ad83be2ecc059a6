//! Path of the centre of mass: over the standing foot in time, by the linear inverted pendulum.
//!
//! The steps say which foot carries the body when, hence where the pressure under the feet (the zero-moment point,
//! ZMP) should be: under the standing foot while the other is in the air, moving from one to the other in between. It
//! is in the middle long before and after. A body whose centre of mass stays at height `h` obeys `c'' = (g / h) (c -
//! p)` with `p` the ZMP (Kajita et al. 2003). Taken as a boundary value problem over the whole clip, discretised in
//! time, that is one tridiagonal system per direction. Its solution neither runs away nor comes late.

use super::feet::{self, LEFT, Step};

/// Height of the centre of mass of the standing figure (m).
const HEIGHT: f64 = 0.95;
/// Gravity (m/s^2), where a text says no other.
pub(super) const GRAVITY: f64 = 9.81;
/// Time over which the weight goes from the middle to a foot before the first step, and back after the last (s).
const SHIFT: f64 = 0.8;

/// A stretch of time in which the pressure rests at a point, or moves on to the next stretch's.
struct Rest {
    from: f64,
    to: f64,
    point: [f64; 2],
}

/// Returns the stretches in which one foot carries the body, and the instants at which both leave the ground or meet it.
fn carried(steps: &[Step], middle: &dyn Fn(f64) -> [f64; 2]) -> Vec<Rest> {
    let mut times: Vec<f64> = steps.iter().flat_map(|step| [step.start, step.end]).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let in_air = |foot: usize, time: f64| steps.iter().any(|s| s.foot == foot && s.start < time && time < s.end);
    let up: Vec<[bool; 2]> = times.windows(2).map(|t| [0, 1].map(|foot| in_air(foot, 0.5 * (t[0] + t[1])))).collect();
    let on_both = |at: Option<usize>| at.and_then(|at| up.get(at)).is_none_or(|up| *up == [false, false]);
    let mut rests = Vec::new();
    for (at, (pair, up)) in times.windows(2).zip(&up).enumerate() {
        let (from, to) = (pair[0], pair[1]);
        match up {
            [false, false] => {}
            [true, true] => {
                if on_both(at.checked_sub(1)) {
                    rests.push(Rest { from, to: from, point: middle(from) });
                }
                if on_both(Some(at + 1)) {
                    rests.push(Rest { from: to, to, point: middle(to) });
                }
            }
            [left, _] => {
                let foot = if *left { 1 - LEFT } else { LEFT };
                rests.push(Rest { from, to, point: feet::standing_place(steps, foot, from).centre() });
            }
        }
    }
    rests
}

/// Returns the pressure point wished for at each frame.
pub(super) fn pressure(steps: &[Step], fps: f64, frames: usize) -> Vec<[f64; 2]> {
    let seconds = (frames - 1) as f64 / fps;
    let middle = |time: f64| {
        let [a, b] = [LEFT, 1 - LEFT].map(|foot| feet::standing_place(steps, foot, time).centre());
        [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
    };
    let mut rests: Vec<Rest> = vec![Rest { from: 0.0, to: 0.0, point: middle(0.0) }];
    let mut before = 0.0;
    for (at, rest) in carried(steps, &middle).into_iter().enumerate() {
        let gap = rest.from - before;
        if at == 0 {
            rests[0].to = (rest.from - SHIFT).max(0.0);
        } else if gap > 2.0 * SHIFT {
            rests.push(Rest { from: before + SHIFT, to: rest.from - SHIFT, point: middle(before) });
        }
        before = rest.to;
        rests.push(rest);
    }
    if !steps.is_empty() {
        let from = (before + SHIFT).min(seconds.max(before));
        rests.push(Rest { from, to: f64::INFINITY, point: middle(before) });
    }
    (0..frames).map(|frame| point_at(&rests, frame as f64 / fps)).collect()
}

fn point_at(rests: &[Rest], time: f64) -> [f64; 2] {
    let next = rests.partition_point(|rest| rest.from <= time);
    let now = &rests[next.max(1) - 1];
    match rests.get(next) {
        Some(then) if time > now.to => {
            let way = super::curve::minimum_jerk((time - now.to) / (then.from - now.to));
            [0, 1].map(|axis| now.point[axis] + way * (then.point[axis] - now.point[axis]))
        }
        _ => now.point,
    }
}

/// Returns the path of the centre of mass that has this pressure point, at rest over it at both ends. `rises` are height
/// above standing and upward acceleration per frame: in the air nothing pushes, and the path is straight.
pub(super) fn centre_path(pressure: &[[f64; 2]], rises: &[[f64; 2]], fps: f64, gravity: f64) -> Vec<[f64; 2]> {
    let n = pressure.len();
    // Rows: (w + 2k) c_i - k c_{i-1} - k c_{i+1} = w p_i inside, c_i = p_i at both ends. Thomas' algorithm.
    let mut upper = vec![0.0; n];
    let mut path = pressure.to_vec();
    for at in 1..n.saturating_sub(1) {
        let [height, acceleration] = rises[at];
        let (w, k) = (1.0 + acceleration / gravity, (HEIGHT + height) / gravity * fps * fps);
        let pivot = w + 2.0 * k - k * upper[at - 1];
        upper[at] = k / pivot;
        path[at] = [0, 1].map(|axis| (w * pressure[at][axis] + k * path[at - 1][axis]) / pivot);
    }
    for at in (1..n.saturating_sub(1)).rev() {
        path[at] = [0, 1].map(|axis| path[at][axis] + upper[at] * path[at + 1][axis]);
    }
    path
}

/// Returns the pressure point of a path of the centre of mass: `p = c - (h / g) c''`, by central differences; at the
/// ends `c`.
#[cfg(test)]
pub(super) fn pressure_of(path: &[[f64; 2]], height: f64, fps: f64) -> Vec<[f64; 2]> {
    let k = height / GRAVITY * fps * fps;
    (0..path.len())
        .map(|at| match (at.checked_sub(1).and_then(|b| path.get(b)), path.get(at + 1)) {
            (Some(a), Some(b)) => [0, 1].map(|i| path[at][i] - k * (a[i] - 2.0 * path[at][i] + b[i])),
            _ => path[at],
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::feet::Place;
    use super::*;

    #[test]
    fn the_path_has_the_pressure_it_was_made_for() {
        let fps = 50.0;
        let to = Place { x: 0.3, y: 0.09, yaw: 0.0 };
        let steps = [Step { foot: LEFT, start: 1.5, end: 2.0, to, height: 0.05, via: Vec::new(), flies: false }];
        let wished = pressure(&steps, fps, 201);
        assert_eq!(wished[0], [0.03, 0.0]);
        assert_eq!(wished[87], [0.03, -0.09], "on the right foot while the left is in the air");
        assert!(
            (wished[200][0] - 0.18).abs() < 1e-12 && wished[200][1].abs() < 1e-12,
            "in the middle: {:?}",
            wished[200]
        );
        let path = centre_path(&wished, &[[0.0; 2]; 201], fps, GRAVITY);
        for (got, want) in pressure_of(&path, HEIGHT, fps).iter().zip(&wished) {
            assert!((got[0] - want[0]).abs() < 1e-9 && (got[1] - want[1]).abs() < 1e-9, "{got:?} {want:?}");
        }
    }
}
