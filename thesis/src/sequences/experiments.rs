//! The rows of thesis Table A.1 whose data there is.

use lifelike_representation::spline_transformer::SequencePlan;

/// An experiment of thesis chapter 3.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Experiment {
    /// 3.3.1.
    Lissajous,
    /// 3.3.1.
    Hypotrochoids,
    /// 3.3.1, two numbers.
    Bezier2,
    /// 3.3.1, 64 numbers.
    Bezier64,
    /// 3.3.2, patches of 4.
    Cifar10,
    /// 3.3.3, full-body motion.
    Motion,
    /// 3.3.4.
    Strands,
}

impl Experiment {
    /// Returns latent dimensions that the table lists.
    pub fn latents(self) -> &'static [usize] {
        match self {
            Self::Lissajous => &[3],
            Self::Hypotrochoids => &[4],
            Self::Bezier2 => &[2],
            Self::Bezier64 => &[64],
            Self::Cifar10 => &[32, 64, 128],
            Self::Motion => &[16, 32, 64],
            Self::Strands => &[8, 16, 32],
        }
    }

    /// Returns the row as a plan, with the smallest of its latent dimensions. The table has neither the length of training nor
    /// clipping: both are [`SequencePlan::default`]'s.
    pub fn plan(self) -> SequencePlan {
        let (heads, width, batch, learning_rate) = match self {
            Self::Lissajous | Self::Hypotrochoids => (4, 64, 256, 1e-3),
            Self::Bezier2 => (4, 64, 1024, 1e-3),
            // Four layers, as the table says; its 0.43M parameters are those of two.
            Self::Bezier64 => (4, 128, 1024, 1e-3),
            Self::Cifar10 => (8, 128, 512, 3e-4),
            Self::Motion => (8, 128, 1024, 3e-4),
            Self::Strands => (8, 64, 128, 1e-3),
        };
        let latent = self.latents()[0];
        SequencePlan { latent, layers: 4, heads, width, factor: 1, batch, learning_rate, ..SequencePlan::default() }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn rows_are_the_tables() {
        let row = |e: Experiment| {
            let p = e.plan();
            p.check().unwrap();
            (p.latent, p.layers, p.heads, p.width, p.factor, p.batch, p.learning_rate)
        };
        assert_eq!(row(Experiment::Lissajous), (3, 4, 4, 64, 1, 256, 1e-3));
        assert_eq!(row(Experiment::Hypotrochoids), (4, 4, 4, 64, 1, 256, 1e-3));
        assert_eq!(row(Experiment::Bezier2), (2, 4, 4, 64, 1, 1024, 1e-3));
        assert_eq!(row(Experiment::Bezier64), (64, 4, 4, 128, 1, 1024, 1e-3));
        assert_eq!(row(Experiment::Cifar10), (32, 4, 8, 128, 1, 512, 3e-4));
        assert_eq!(row(Experiment::Motion), (16, 4, 8, 128, 1, 1024, 3e-4));
        assert_eq!(row(Experiment::Strands), (8, 4, 8, 64, 1, 128, 1e-3));
    }
}
