//! Tests of representation at its public interface: one program, so that it is linked once.

#![allow(clippy::unwrap_used, clippy::expect_used)]

mod contract_pca;
mod contract_prior;
mod contract_spline_prior;
mod frozen_prior;
mod oracle_latent;
mod swings;
