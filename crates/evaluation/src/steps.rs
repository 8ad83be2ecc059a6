//! Steps of the reference that the robot takes.
//!
//! Agreement of contacts by frames hides feet that never lift: both soles of a march are down in most of its frames. A robot that stands
//! through a walk survives it, and loses a few degrees on average.

use super::accuracy::CONTACT_SHARE;
use super::rollout::Rollout;

/// Shortest swing of a foot that is a step (s).
const SHORTEST: f64 = 0.1;

/// Swings of feet between two contacts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Steps {
    /// Swings of the reference's feet, from the ground to the ground, within the frames that count.
    pub planned: usize,
    /// Those among them in which the robot's foot was off the ground for at least half of the time.
    pub taken: usize,
}

/// Counts the steps of an episode.
pub fn steps(rollout: &Rollout) -> Steps {
    let feet = rollout.names.feet.len();
    let shortest = (SHORTEST * rollout.fps).ceil() as usize;
    let mut all = Steps::default();
    for foot in 0..feet {
        let frames: Vec<usize> = rollout.counted().collect();
        let swings = frames
            .chunk_by(|a, b| rollout.planned_contact[a * feet + foot] == rollout.planned_contact[b * feet + foot]);
        // A swing that is under way at either end of the episode is no whole step.
        let whole: Vec<&[usize]> = swings.collect();
        let inner = whole.get(1..whole.len().saturating_sub(1)).unwrap_or_default();
        for swing in
            inner.iter().filter(|swing| swing.len() >= shortest && !rollout.planned_contact[swing[0] * feet + foot])
        {
            let lifted = swing.iter().filter(|frame| rollout.foot_force[*frame * feet + foot] <= CONTACT_SHARE).count();
            all.planned += 1;
            all.taken += usize::from(2 * lifted >= swing.len());
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use lifelike_character::Vec3;

    use super::super::rollout::example::{rollout, snapshot};
    use super::*;

    /// Ten frames a second; `#` is on the ground.
    fn counted(planned: &str, done: &str) -> Steps {
        let still = |_| snapshot(Vec3::z(), 0.0, 0.0);
        let mut r = rollout(planned.len(), still, still);
        r.planned_contact = planned.chars().map(|c| c == '#').collect();
        r.foot_force = done.chars().map(|c| if c == '#' { 0.5 } else { 0.0 }).collect();
        steps(&r)
    }

    #[test]
    fn a_step_is_taken_where_the_foot_is_up_for_half_of_the_swing() {
        assert_eq!(counted("##....##..##", "##...###.###"), Steps { planned: 2, taken: 2 });
        assert_eq!(counted("##....##..##", "############"), Steps { planned: 2, taken: 0 }, "it stands");
        assert_eq!(counted("##....##..##", "##.######..#"), Steps { planned: 2, taken: 1 }, "late, but half of it");
    }

    #[test]
    fn what_is_under_way_at_the_ends_is_no_whole_step() {
        assert_eq!(counted("#...##..", "#...##.."), Steps { planned: 0, taken: 0 }, "the first frame does not count");
        assert_eq!(counted("........", "########"), Steps::default());
        assert_eq!(counted("##..##", "##..##"), Steps { planned: 1, taken: 1 });
    }
}
