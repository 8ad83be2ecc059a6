//! The processes that a training was started in.

use std::sync::Arc;

use lifelike_train::collective::{Alone, Collective};

use crate::error::CliError;

/// Environment variables in which Open MPI, MPICH and Slurm tell a process their number.
const SIZES: [&str; 3] = ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS"];

/// Returns the number of processes that learn together, before any of them has met another.
pub fn count() -> usize {
    let number = |name: &str| std::env::var(name).ok()?.parse::<usize>().ok();
    SIZES.iter().find_map(|name| number(name)).unwrap_or(1).max(1)
}

/// All processes of this run: this one alone, or those that `mpirun` started.
///
/// # Errors
/// There are several, and this build cannot bring them together; or MPI does not start.
pub fn all() -> Result<Arc<dyn Collective>, CliError> {
    match count() {
        1 => Ok(Arc::new(Alone)),
        size => together(size),
    }
}

#[cfg(feature = "mpi")]
fn together(_: usize) -> Result<Arc<dyn Collective>, CliError> {
    Ok(Arc::new(super::mpi::Mpi::start()?))
}

#[cfg(not(feature = "mpi"))]
fn together(size: usize) -> Result<Arc<dyn Collective>, CliError> {
    Err(CliError::Unavailable(format!(
        "this is one of {size} processes, and this build cannot bring them together; build with --features mpi"
    )))
}
