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
        let windows = plan.windows;
        Self {
            seed: windows.seed,
            frame_rate: windows.frame_rate,
            half_width: windows.half_width,
            window_seconds: windows.window_seconds,
            held_out: windows.held_out,
            floors: windows.floors,
            latent: plan.latent,
            channels: plan.channels,
            blocks: plan.blocks,
            linear_path: plan.linear_path,
            batch: plan.batch,
            iterations: plan.iterations,
            optimizer: plan.optimizer,
            learning_rate: plan.learning_rate,
            restart_first: plan.restart_first,
            restart_factor: plan.restart_factor,
            kl_weight: plan.kl_weight,
            kl_cycles: plan.kl_cycles,
            kl_ratio: plan.kl_ratio,
            max_gradient_norm: plan.max_gradient_norm,
        }
    }
}

impl From<Flat> for VaePlan {
    fn from(flat: Flat) -> Self {
        let windows = WindowPlan {
            seed: flat.seed,
            frame_rate: flat.frame_rate,
            half_width: flat.half_width,
            window_seconds: flat.window_seconds,
            held_out: flat.held_out,
            floors: flat.floors,
        };
        Self {
            windows,
            latent: flat.latent,
            channels: flat.channels,
            blocks: flat.blocks,
            linear_path: flat.linear_path,
            batch: flat.batch,
            iterations: flat.iterations,
            optimizer: flat.optimizer,
            learning_rate: flat.learning_rate,
            restart_first: flat.restart_first,
            restart_factor: flat.restart_factor,
            kl_weight: flat.kl_weight,
            kl_cycles: flat.kl_cycles,
            kl_ratio: flat.kl_ratio,
            max_gradient_norm: flat.max_gradient_norm,
        }
    }
}
