//! Hardware of a training: cores for the physics, a processor for the networks.

use lifelike_nn::device::{Device, Processor};

use crate::commands::physics::Physics;
use crate::error::CliError;

/// Processor of the networks.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct Networks {
    /// Processor on which networks learn: cpu, cuda:N or wgpu (any card with Vulkan, Metal or DirectX 12). A card needs a build with
    /// --features cuda or wgpu, and is meant for large networks and minibatches.
    #[arg(long, default_value_t, value_name = "DEVICE")]
    pub device: Processor,
}

impl Networks {
    /// The device, tried.
    ///
    /// # Errors
    /// This build or this machine has none.
    pub fn open(&self) -> Result<Device, CliError> {
        let device = self.device.open()?;
        if self.device != Processor::Cpu {
            tracing::info!("networks learn on {}: {device:?}", self.device);
        }
        Ok(device)
    }
}

/// Hardware of a tracker's training.
#[derive(Debug, Clone, clap::Args)]
pub struct Hardware {
    /// Engine and threads.
    #[command(flatten)]
    pub physics: Physics,
    /// Processor of the networks.
    #[command(flatten)]
    pub networks: Networks,
}
