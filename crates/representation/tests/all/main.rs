//! Tests of representation at its public interface: one program, so that it is linked once.

mod contract_pca;
mod contract_prior;
mod contract_spline_prior;
mod frozen_prior;
mod oracle_latent;
mod swings;
