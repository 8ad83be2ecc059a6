//! Keys of a β-VAE's plan in files: those of the windows and of the network side by side, as the first priors have them.

use lifelike_nn::adam::Rule;
use serde::{Deserialize, Serialize};

use super::plan::VaePlan;
use crate::prior::statistics::StdFloors;
use crate::prior::window_plan::WindowPlan;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Flat {
    seed: u64,
    frame_rate: f64,
    half_width: usize,
    window_seconds: f64,
    latent: usize,
    channels: usize,
    blocks: usize,
    linear_path: bool,
    batch: usize,
    iterations: u64,
    optimizer: Rule,
    learning_rate: f64,
    restart_first: u64,
    restart_factor: u64,
    kl_weight: f64,
    kl_cycles: u64,
    kl_ratio: f64,
    max_gradient_norm: f64,
    held_out: f64,
    floors: StdFloors,
}

impl Default for Flat {
    fn default() -> Self {
        VaePlan::default().into()
    }
}

impl From<VaePlan> for Flat {
    fn from(plan: VaePlan) -> Self {
        let WindowPlan { seed, frame_rate, half_width, window_seconds, held_out, floors } = plan.windows;
        let VaePlan {
            latent,
            channels,
            blocks,
            linear_path,
            batch,
            iterations,
            optimizer,
            learning_rate,
            restart_first,
            restart_factor,
            kl_weight,
            kl_cycles,
            kl_ratio,
            max_gradient_norm,
            ..
        } = plan;
        Self {
            seed,
            frame_rate,
            half_width,
            window_seconds,
            held_out,
            floors,
            latent,
            channels,
            blocks,
            linear_path,
            batch,
            iterations,
            optimizer,
            learning_rate,
            restart_first,
            restart_factor,
            kl_weight,
            kl_cycles,
            kl_ratio,
            max_gradient_norm,
        }
    }
}

impl From<Flat> for VaePlan {
    fn from(flat: Flat) -> Self {
        let Flat {
            seed,
            frame_rate,
            half_width,
            window_seconds,
            held_out,
            floors,
            latent,
            channels,
            blocks,
            linear_path,
            batch,
            iterations,
            optimizer,
            learning_rate,
            restart_first,
            restart_factor,
            kl_weight,
            kl_cycles,
            kl_ratio,
            max_gradient_norm,
        } = flat;
        let windows = WindowPlan { seed, frame_rate, half_width, window_seconds, held_out, floors };
        Self {
            windows,
            latent,
            channels,
            blocks,
            linear_path,
            batch,
            iterations,
            optimizer,
            learning_rate,
            restart_first,
            restart_factor,
            kl_weight,
            kl_cycles,
            kl_ratio,
            max_gradient_norm,
        }
    }
}
