//! A warning for trainings that get nowhere: survival that has not risen for millions of steps.

/// Steps without a rise after which it is said.
const PATIENCE: u64 = 2_000_000;
/// Rise of survival that counts.
const RISE: f64 = 0.02;
/// Survival from which a plateau is no reason to worry.
const GOOD: f64 = 0.8;

/// Survival of a training so far.
#[derive(Debug, Default)]
pub struct Stall {
    /// The highest survival, and the steps after which it was reached.
    best: (f64, u64),
    told: bool,
}

impl Stall {
    /// Notes the survival after some steps, and returns a warning the first time that it has stopped rising too low.
    pub fn note(&mut self, done: u64, survival: f64) -> Option<String> {
        if survival > self.best.0 + RISE {
            self.best = (survival, done);
        }
        let stands_still = done >= self.best.1 + PATIENCE && self.best.0 < GOOD && !survival.is_nan();
        if self.told || !stands_still {
            return None;
        }
        self.told = true;
        Some(format!(
            "survival has not risen above {:.0}% for {} million steps. Are the legs too weak (`lifelike inspect` compares their \
             torque with the weight), or the clips impossible (`lifelike motion check`)? A plan with fewer clips shows which.",
            100.0 * self.best.0,
            PATIENCE / 1_000_000
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps after which a course of survival, one point per 500,000 steps, is warned of.
    fn warned(course: &[f64]) -> Option<u64> {
        let mut stall = Stall::default();
        let points = course.iter().enumerate().map(|(i, survival)| (500_000 * (i as u64 + 1), *survival));
        points.filter_map(|(done, survival)| stall.note(done, survival).map(|_| done)).next()
    }

    #[test]
    fn only_a_low_plateau_is_warned_of_and_once() {
        assert_eq!(warned(&[0.0, 0.1, 0.1, 0.11, 0.1, 0.1]), Some(3_000_000), "two million after 0.1 was reached");
        assert_eq!(warned(&[0.0, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]), None, "it rises");
        assert_eq!(warned(&[0.9; 10]), None, "high enough");
        assert_eq!(warned(&[f64::NAN; 10]), None, "no episode has ended yet");
        let mut stall = Stall::default();
        let told = (1..10).filter(|i| stall.note(i * 1_000_000, 0.1).is_some()).count();
        assert_eq!(told, 1);
    }
}
