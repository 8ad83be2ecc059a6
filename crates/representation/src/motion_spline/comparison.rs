//! A motion spline beside plain baselines, on the same windows: what the same number of numbers says without a network.

use super::poses::Poses;
use super::space::PoseSpace;
use crate::RepresentationError;
use crate::spline_transformer::{HeldOut, Plain, RecordingWindows, SequenceTrainer, Sequences};

/// Windows that are measured at a time.
const MEASURED: usize = 64;

/// Errors of one way to keep windows as a few numbers.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct WindowErrors {
    /// `spline`, or a plain baseline's name.
    pub name: &'static str,
    /// Numbers that it keeps of a window.
    pub numbers: usize,
    /// Root mean square error of the joints (deg).
    pub joints_deg: f64,
}

impl WindowErrors {
    /// Returns the errors on the test windows, which stand end to end: plain baselines of the training windows first, principal
    /// components as many as the spline's numbers; then the network. Nothing where no clips are tested on.
    ///
    /// # Errors
    /// Rows that cannot be made.
    pub fn all(
        trainer: &SequenceTrainer<RecordingWindows>,
        space: &PoseSpace,
    ) -> Result<Vec<Self>, RepresentationError> {
        let data = trainer.data();
        if data.held_out_len(HeldOut::Test) == 0 {
            return Ok(Vec::new());
        }
        let (method, latent) = (trainer.plan().method, trainer.plan().latent);
        let numbers = method.numbers(latent);
        let mut all = Vec::new();
        for plain in Plain::all(data, latent, &[numbers])? {
            let joints_deg = error(data, space, |x| plain.reconstruct(x))?;
            all.push(Self { name: plain.name, numbers: plain.numbers, joints_deg });
        }
        let joints_deg = error(data, space, |x| Ok(trainer.reconstruct(x)?.1))?;
        all.push(Self { name: method.name(), numbers, joints_deg });
        Ok(all)
    }
}

/// Root mean square error (deg) of the joints in what comes `back` of all test windows.
fn error(
    data: &RecordingWindows,
    space: &PoseSpace,
    back: impl Fn(&[f32]) -> Result<Vec<f32>, RepresentationError>,
) -> Result<f64, RepresentationError> {
    let count = data.held_out_len(HeldOut::Test);
    let (mut squares, mut numbers) = (0.0, 0.0);
    for first in (0..count).step_by(MEASURED) {
        let x = data.held_out(HeldOut::Test, first..(first + MEASURED).min(count));
        let y = back(&x)?;
        let (x, y) = (space.denormalized(&x), space.denormalized(&y));
        for (x, y) in x.chunks_exact(space.width()).zip(y.chunks_exact(space.width())) {
            let joints = x.iter().zip(y).skip(Poses::ROOT);
            squares += joints.map(|(x, y)| (x - y).to_degrees().powi(2)).sum::<f64>();
            numbers += space.joints().len() as f64;
        }
    }
    Ok((squares / numbers).sqrt())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::model::{MotionSpline, SplitClips};
    use super::super::testing::{model, walk};
    use super::*;

    #[test]
    fn plain_baselines_stand_before_the_network_and_keep_the_numbers_they_say() {
        let plan = model().plan().clone();
        let clips = |test| SplitClips { training: vec![walk("walk", 300, 50.0)], test, ..SplitClips::default() };
        let compared = |test| {
            let (data, space) = MotionSpline::data(&plan, &clips(test)).unwrap();
            WindowErrors::all(&SequenceTrainer::new(plan.training.clone(), data).unwrap(), &space).unwrap()
        };
        assert_eq!(compared(Vec::new()), []);
        let all = compared(vec![walk("again", 200, 50.0)]);
        let told: Vec<_> = all.iter().map(|row| (row.name, row.numbers)).collect();
        assert_eq!(told, [("mean", 0), ("cubic", 4 * 9), ("PCA", 20), ("cubic of components", 20), ("spline", 20)]);
        // Joints are sines of 3 t, up to a radian, all of the same phases as in training.
        assert!(all[0].joints_deg > 20.0, "{all:?}");
        assert!((1.0..10.0).contains(&all[1].joints_deg), "most of a wave is a cubic: {all:?}");
        assert!(all[2].joints_deg < 0.5, "two directions hold a sine of any phase: {all:?}");
        assert!((1.0..10.0).contains(&all[3].joints_deg), "joints of one phase are few components: {all:?}");
        assert!(all[4].joints_deg > 20.0, "it never learned: {all:?}");
    }
}
