//! Motion from sentences.

use std::path::PathBuf;

use lifelike::shipped::{self, Kind};
use lifelike_generation::generator::{Generator, SampleOptions};
use pyo3::prelude::*;

use crate::clip::Clip;
use crate::error::{Error, Raise};
use crate::robot::RobotLike;

/// Makes motions of a robot from a sentence, one clip per candidate.
///
/// `generator` is a name or file; the robot's own that comes with the package where not given. `seconds` is the duration;
/// what the sentence asks for where not given. The same sentence, seed and settings give the same motions. `guidance` is
/// the weight of the sentence, `steps` the number of denoising steps (all where not given).
/// `Robot.check` tells which candidates are feasible. Raises `Error` for a text that is no sentence, settings out of
/// range, and a robot without a generator. Ctrl-C acts after the sampling, which lasts seconds.
#[pyfunction]
#[pyo3(signature = (prompt, robot, *, candidates=1, seconds=None, seed=0, guidance=None, steps=None, generator=None))]
#[allow(clippy::too_many_arguments)]
pub fn generate(
    py: Python<'_>,
    prompt: String,
    robot: RobotLike<'_>,
    candidates: usize,
    seconds: Option<f64>,
    seed: u64,
    guidance: Option<f64>,
    steps: Option<usize>,
    generator: Option<PathBuf>,
) -> PyResult<Vec<Clip>> {
    let robot = robot.load()?;
    let defaults = SampleOptions::default();
    let guidance = guidance.unwrap_or(defaults.guidance);
    let options = SampleOptions { seconds, seed, guidance, steps, candidates, ..defaults };
    let clips: PyResult<Vec<Clip>> = py.detach(|| {
        let file = match &generator {
            Some(generator) => shipped::file(generator, Kind::Generator),
            None => {
                let own = shipped::of_robot(&robot, Kind::Generator);
                let none =
                    || Error::new_err(format!("no pretrained generator for '{}' comes with the package", robot.name));
                own.ok_or_else(none)?.file()
            }
        };
        let generator = Generator::load(&file.or_raise()?).or_raise()?;
        generator.check_robot(&robot).or_raise()?;
        let made = generator.sample(&prompt, &options).or_raise()?;
        made.iter().map(|one| Ok(Clip(generator.clip(one, &prompt, &robot).or_raise()?))).collect()
    });
    py.check_signals()?;
    clips
}
