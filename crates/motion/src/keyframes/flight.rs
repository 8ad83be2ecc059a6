//! Both feet in the air: the centre of mass on a parabola, with a push before it and legs that give way after it.
//!
//! A body that is in the air for a time T leaves the ground with speed g T / 2 and meets it as fast. Before and after, the
//! force of the ground goes from nothing at take-off to its greatest in the crouch: acceleration is a polynomial of time,
//! and it is continuous everywhere. All of it is proportional to gravity, which a figure of another size has other units of.

use super::feet::{LEFT, Step};

/// Time of the push from the deepest crouch to take-off, and from touch-down to the deepest crouch (s).
const PUSH: f64 = 0.12;
/// Time from standing to the crouch, and back (s), where there is as much.
const CROUCH: f64 = 0.4;

/// Time between two crouches (s) that is too short to rise in.
const SHORT: f64 = 0.12;

/// A time without any foot on the ground (s).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Flight {
    pub start: f64,
    pub end: f64,
}

/// Returns the time in the air (s) for a rise of the centre of mass (m).
pub(super) fn seconds(height: f64, gravity: f64) -> f64 {
    2.0 * (2.0 * height / gravity).sqrt()
}

/// Returns the flights of some steps: where one of the left foot and one of the right foot overlap.
pub(super) fn flights(steps: &[Step]) -> Vec<Flight> {
    let steps_of = |left: bool| steps.iter().filter(move |step| (step.foot == LEFT) == left);
    let mut found: Vec<Flight> = steps_of(true)
        .flat_map(|a| steps_of(false).map(|b| Flight { start: a.start.max(b.start), end: a.end.min(b.end) }))
        .filter(|flight| flight.end - flight.start > 1e-6)
        .collect();
    found.sort_by(|a, b| a.start.total_cmp(&b.start));
    found
}

/// Returns height above standing (m) and acceleration (m/s^2) of the centre of mass.
pub(super) fn rise(flights: &[Flight], time: f64, gravity: f64) -> [f64; 2] {
    let next = flights.partition_point(|flight| flight.end <= time);
    let speed = |flight: &Flight| 0.5 * gravity * (flight.end - flight.start);
    let (before, after) = (next.checked_sub(1).map(|at| &flights[at]), flights.get(next));
    if let Some(now) = after.filter(|flight| flight.start <= time) {
        let t = time - now.start;
        return [speed(now) * t - 0.5 * gravity * t * t, -gravity];
    }
    // Where there is no time to stand up between landing and the next push: one bounce, or crouch, rise a little, crouch.
    if let (Some(a), Some(b)) = (before, after) {
        let (gap, since) = (b.start - a.end, time - a.end);
        if gap < 2.0 * PUSH + SHORT {
            return bounce(gap, since / gap, [speed(a), speed(b)], gravity);
        }
        let span = gap - 2.0 * PUSH;
        if span < CROUCH && (PUSH..gap - PUSH).contains(&since) {
            let ends = [a, b].map(|flight| CrouchOf::of(speed(flight), gravity));
            let [from, to] = ends.map(|end| [-end.depth, end.acceleration]);
            return between(from, to, span, (since - PUSH) / span);
        }
    }
    let crouch = |flight: &Flight, away: f64, room: f64| {
        let CrouchOf { depth, acceleration } = CrouchOf::of(speed(flight), gravity);
        if away < PUSH {
            // From the crouch (0) to the air (1): a = A - (A + g) s^2.
            let s = 1.0 - away / PUSH;
            let all = acceleration + gravity;
            let height = PUSH * PUSH * (0.5 * acceleration * s * s - all * s.powi(4) / 12.0) - depth;
            return [height, acceleration - all * s * s];
        }
        let span = room.clamp(1e-9, CROUCH);
        between([-depth, acceleration], [0.0, 0.0], span, ((away - PUSH) / span).min(1.0))
    };
    match (before, after) {
        (Some(a), Some(b)) => {
            let room = 0.5 * (b.start - a.end) - PUSH;
            let (since, until) = (time - a.end, b.start - time);
            if since < until { crouch(a, since, room) } else { crouch(b, until, room) }
        }
        (Some(a), None) => crouch(a, time - a.end, CROUCH),
        (None, Some(b)) => crouch(b, b.start - time, (b.start - PUSH).max(0.0)),
        (None, None) => [0.0, 0.0],
    }
}

/// The crouch from which a push of [`PUSH`] seconds takes off: its depth (m), and the acceleration there (m/s^2).
struct CrouchOf {
    depth: f64,
    acceleration: f64,
}

impl CrouchOf {
    fn of(speed: f64, gravity: f64) -> Self {
        // The mean of A - (A + g) s^2 is the speed over the time.
        let acceleration = 1.5 * speed / PUSH + 0.5 * gravity;
        Self { depth: PUSH * PUSH * (0.5 * acceleration - (acceleration + gravity) / 12.0), acceleration }
    }
}

/// Returns height and acceleration at a share of the way from one height and acceleration to another: the quintic that
/// is at rest at both ends.
fn between([low, a]: [f64; 2], [high, b]: [f64; 2], span: f64, s: f64) -> [f64; 2] {
    let (way, a, b) = (high - low, 0.5 * a * span * span, 0.5 * b * span * span);
    let [c3, c4, c5] = [10.0 * way - 3.0 * a + b, 3.0 * a - 15.0 * way - 2.0 * b, 6.0 * way - a + b];
    let height = low + a * s * s + s.powi(3) * (c3 + s * (c4 + s * c5));
    [height, (2.0 * a + s * (6.0 * c3 + s * (12.0 * c4 + s * 20.0 * c5))) / (span * span)]
}

/// Returns height and acceleration on the ground between two flights, at a share of its time: as a spring does, without
/// a pause. A cubic acceleration that is that of free fall at both ends.
fn bounce(gap: f64, s: f64, [fell, leaves]: [f64; 2], gravity: f64) -> [f64; 2] {
    // With a(s) = -g + 4 (m + n s) s (1 - s): both speeds, and the same height at both ends.
    let (rise, ground) = ((fell + leaves) / gap + gravity, fell / gap + 0.5 * gravity);
    // Integrals of 4 s (1 - s), and with another s: 2/3, 1/3; twice: 1/3, 2/15.
    let n = (rise / 2.0 - ground) / (1.0 / 6.0 - 2.0 / 15.0);
    let m = 1.5 * (rise - n / 3.0);
    let twice = |s: f64| 4.0 * (m * (s.powi(3) / 6.0 - s.powi(4) / 12.0) + n * (s.powi(4) / 12.0 - s.powi(5) / 20.0));
    let height = -fell * gap * s + gap * gap * (twice(s) - 0.5 * gravity * s * s);
    [height, 4.0 * (m + n * s) * s * (1.0 - s) - gravity]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn both(start: f64, end: f64) -> Flight {
        Flight { start, end }
    }

    #[test]
    fn the_way_is_smooth_and_its_acceleration_the_one_that_is_told() {
        let air = seconds(0.06, 20.0);
        for gap in [0.2, 0.29, 0.5, 0.66, 0.9, 2.0] {
            let second = 1.0 + air + gap;
            let all = [both(1.0, 1.0 + air), both(second, second + 0.8 * air)];
            let h = 1e-4;
            for at in 0..4000 {
                let t = f64::from(at) * 1e-3 + 0.000_37;
                let height = |t: f64| rise(&all, t, 20.0)[0];
                let bend = (height(t + h) - 2.0 * height(t) + height(t - h)) / (h * h);
                assert!((bend - rise(&all, t, 20.0)[1]).abs() < 0.5, "{gap} {t}: {bend} {:?}", rise(&all, t, 20.0));
                assert!(rise(&all, t, 20.0)[1] > -20.0 - 1e-9, "{t}: the ground pulls");
            }
        }
    }

    #[test]
    fn a_flight_rises_as_high_as_asked_for() {
        let air = seconds(0.05, 9.81);
        let all = [both(1.0, 1.0 + air)];
        assert!((rise(&all, 1.0 + 0.5 * air, 9.81)[0] - 0.05).abs() < 1e-12);
        assert!(rise(&all, 1.0 + air, 9.81)[0].abs() < 1e-12 && rise(&all, 0.0, 9.81)[0].abs() < 1e-12);
    }
}
