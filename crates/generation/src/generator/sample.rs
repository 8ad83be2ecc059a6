//! From a sentence to motions.

use lifelike_checkpoint::rng::stream;
use lifelike_motion::{Caption, MotionClip, Provenance};
use lifelike_robot::Robot;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use super::{Generator, Given, grounded};
use crate::align::by_tokens;
use crate::critic::RewardSurrogate;
use crate::denoiser::{Denoiser, DenoiserInput};
use crate::diffusion::{Sampler, Schedule, guide};
use crate::representation::FeatureMatrix;
use crate::space::MotionSpace;
use crate::{FromInput, GenerationError};

/// Motions that pass through the network at once on one core: a single one is told and free on two.
const PART: usize = 1;
/// Shortest motion (s).
pub(super) const MIN_SECONDS: f64 = 0.5;

/// Settings of sampling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampleOptions {
    /// Duration (s); none takes what the sentence's words say ([`Generator::seconds`]).
    pub seconds: Option<f64>,
    /// Key of the noise.
    pub seed: u64,
    /// Weight of classifier-free guidance: 0 ignores the prompt, 1 takes it as it is.
    pub guidance: f64,
    /// Denoising steps; none takes all of the schedule.
    pub steps: Option<usize>,
    /// Noise that is added again in each step: 0 is DDIM, 1 is DDPM.
    pub eta: f64,
    /// Number of motions.
    pub candidates: usize,
}

impl Default for SampleOptions {
    /// MDM's guidance (2.5) and DDPM.
    fn default() -> Self {
        Self { seconds: None, seed: 0, guidance: 2.5, steps: None, eta: 1.0, candidates: 1 }
    }
}

/// One motion made from a sentence.
#[derive(Debug, Clone, PartialEq)]
pub struct Generated {
    /// Rows as the network made them.
    pub rows: FeatureMatrix,
    /// Number among the candidates.
    pub candidate: usize,
}

impl Generator {
    /// Returns the space of its tokens.
    pub fn space(&self) -> MotionSpace {
        MotionSpace::new(self.header().spec.clone(), self.header().space)
    }

    /// Returns motions of a sentence. Candidate i is the same whatever their number.
    ///
    /// # Errors
    /// [`GenerationError::Prompt`] for a text that is no sentence, [`GenerationError::Input`] for a duration,
    /// number of steps, weight or number of candidates out of range.
    pub fn sample(&self, prompt: &str, options: &SampleOptions) -> Result<Vec<Generated>, GenerationError> {
        self.sample_towards(prompt, options, None)
    }

    /// Returns motions of a sentence, every clean prediction on the way moved towards what a surrogate promises well of:
    /// `M + strength · ∇ Σ v(m_t)`, in the standardized numbers of the tokens.
    ///
    /// # Errors
    /// As [`Self::sample`]; a surrogate of another robot.
    pub fn sample_towards(
        &self,
        prompt: &str,
        options: &SampleOptions,
        surrogate: Option<(&dyn RewardSurrogate, f64)>,
    ) -> Result<Vec<Generated>, GenerationError> {
        self.sample_given(prompt, options, surrogate, &[])
    }

    /// Returns motions of a sentence of which something is given, one [`Given`] for each candidate; none where nothing is.
    ///
    /// # Errors
    /// As [`Self::sample_towards`]; what is given does not fit the motion.
    pub fn sample_given(
        &self,
        prompt: &str,
        options: &SampleOptions,
        surrogate: Option<(&dyn RewardSurrogate, f64)>,
        given: &[Given],
    ) -> Result<Vec<Generated>, GenerationError> {
        let header = self.header();
        let condition = header.pieces.encode(prompt)?;
        let seconds = options.seconds.unwrap_or_else(|| self.seconds(prompt));
        let within = |what: &str, value: f64, low: f64, high: f64| {
            if (low..=high).contains(&value) {
                return Ok(());
            }
            Err(GenerationError::mismatch(what, format!("{low} to {high}"), value))
        };
        within("seconds", seconds, MIN_SECONDS, header.max_seconds)?;
        within("guidance", options.guidance, 0.0, 100.0)?;
        within("eta", options.eta, 0.0, 1.0)?;
        within("strength of the critic", surrogate.map_or(0.0, |(_, strength)| strength), 0.0, 100.0)?;
        within("candidates", options.candidates as f64, 1.0, 4096.0)?;
        let schedule = Schedule::cosine(header.diffusion_steps);
        let steps = options.steps.unwrap_or(schedule.len());
        within("steps", steps as f64, 1.0, schedule.len() as f64)?;
        if !(given.is_empty() || given.len() == options.candidates) {
            let expected = format!("none, or one for each of {} candidates", options.candidates);
            return Err(GenerationError::mismatch("given motions", expected, given.len()));
        }
        let (space, spec) = (self.space(), &header.spec);
        let rows = (seconds * spec.fps).round() as usize + 1;
        let size = space.tokens(rows) * space.width();
        let noise = |candidate: usize, step: usize, out: &mut [f32]| {
            let mut rng = stream(options.seed, "generator.sample", candidate as u64, step as u64);
            out.iter_mut().for_each(|x| *x = StandardNormal.sample(&mut rng));
        };
        let mut motions = vec![vec![0.0; size]; options.candidates];
        motions.iter_mut().enumerate().for_each(|(i, motion)| noise(i, schedule.len(), motion));
        let denoiser = Denoiser::new(header.sizes, &self.layout, &self.values);
        let told = [Some(condition.as_slice()), None];
        // A weight of 1 takes the prompt as it is.
        let told = if options.guidance == 1.0 { &told[..1] } else { &told[..] };
        let clean = |motions: &[Vec<f32>], step: usize| -> Result<Vec<Vec<f32>>, GenerationError> {
            let of = |condition| motions.iter().map(move |motion| DenoiserInput { motion, step, condition });
            let inputs: Vec<_> = told.iter().flat_map(|condition| of(*condition)).collect();
            let parts = inputs.par_chunks(PART).map(|part| Ok(denoiser.forward(part)?.0));
            let mut all = parts.collect::<Result<Vec<_>, GenerationError>>()?.concat();
            let (told, free) = all.split_at_mut(motions.len() * size);
            if !free.is_empty() {
                guide(told, free, options.guidance as f32);
            }
            let towards = |motion: &[f32]| -> Result<Vec<f32>, GenerationError> {
                let mut motion = motion.to_vec();
                if let Some((surrogate, strength)) = surrogate {
                    let (_, by) = by_tokens(surrogate, &space, &self.standardizer, &motion, rows)?;
                    motion.iter_mut().zip(by).for_each(|(x, by)| *x += strength as f32 * by);
                }
                Ok(motion)
            };
            told.par_chunks_exact(size).map(towards).collect()
        };
        let sampler = Sampler { steps, eta: options.eta };
        let known = given.iter().map(|given| given.known(self, rows).map(Some)).collect::<Result<Vec<_>, _>>()?;
        let motions = sampler.sample(&schedule, motions, &known, noise, clean)?;
        let finish = |(candidate, mut tokens): (usize, Vec<f32>)| {
            self.standardizer.restore(&mut tokens);
            let mut rows = space.decode(&tokens, rows)?;
            if let Some(given) = given.get(candidate) {
                given.put(&mut rows);
            }
            Ok(Generated { rows, candidate })
        };
        motions.into_iter().enumerate().map(finish).collect()
    }

    /// Returns a generated motion as a clip of the robot at its policy's rate, soles on the ground, captioned with the
    /// prompt.
    ///
    /// # Errors
    /// Another robot than the generator's.
    pub fn clip(&self, generated: &Generated, prompt: &str, robot: &Robot) -> Result<MotionClip, GenerationError> {
        self.check_robot(robot)?;
        let raw = generated.rows.to_clip(&self.header().spec, prompt, robot.control_hz)?;
        let mut clip = grounded(&raw, robot)?;
        let captions = vec![Caption { start: 0.0, end: clip.seconds(), text: prompt.to_string() }];
        clip.provenance = Provenance {
            character: robot.name.clone(),
            source: format!("generated, candidate {}", generated.candidate),
            licence: self.header().licences.join("; "),
            captions,
        };
        Ok(clip)
    }
}
