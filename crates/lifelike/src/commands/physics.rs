//! Which physics this build has.

use crate::error::CliError;

/// The engine where none is named.
pub const DEFAULT: &str = "lifelike";

/// Whether the engine is in this build; if not, how to get it.
pub fn available(engine: &str) -> Result<(), CliError> {
    match engine {
        "lifelike" => Ok(()),
        "mujoco" if cfg!(feature = "mujoco") => Ok(()),
        "mujoco" => Err(CliError::Unavailable(
            "this build has no MuJoCo. Leave --engine away for our own physics, or fetch MuJoCo once and build with it:\n\
             \x20 cargo xtask mujoco\n\
             \x20 cargo run --release --features mujoco --bin lifelike -- ..."
                .into(),
        )),
        other => Err(CliError::Usage(format!("no engine '{other}'; there are: lifelike, mujoco"))),
    }
}
