//! Plain baselines of sequence autoencoders: what a few numbers say of a sequence without any network.
//!
//! A network that does not beat them has learned nothing of use, whatever it is first among. Each is told with how many numbers it
//! keeps of a sequence ([`Plain::numbers`]), as a network is ([`Method::numbers`](super::Method::numbers)).

use nalgebra::DMatrix;

use super::sequences::Sequences;
use crate::RepresentationError;
use crate::components::{Components, Rows, Subspace};

/// Training sequences that mean and components are made of, the first batches of a training. A curve's family has endless ones.
const SEQUENCES: usize = 8192;
/// Sequences that are drawn at a time.
const DRAWN: usize = 512;
/// Iterations after which components no longer change.
const ITERATIONS: usize = 20;

/// A plain baseline of sequences of one shape.
#[derive(Debug, Clone)]
pub struct Plain {
    /// Name, without its numbers.
    pub name: &'static str,
    /// Numbers that it keeps of a sequence.
    pub numbers: usize,
    kind: Kind,
}

#[derive(Debug, Clone)]
enum Kind {
    /// Mean of all training sequences.
    Mean(Vec<f32>),
    /// Each channel a cubic polynomial of time, by least squares: the matrix `[tokens, tokens]` that gives its values.
    Cubic(DMatrix<f64>),
    /// Principal components of whole sequences.
    Components(Components),
    /// Principal components of single frames, each a cubic polynomial of time as above: what a curve with four control points in their
    /// space can be, read by a linear map.
    ComponentCubics(DMatrix<f64>, Components),
}

impl Plain {
    /// Returns the plain baselines of a source: the mean, a cubic polynomial for each channel, and principal
    /// components of as many numbers as asked for. If a frame has more than `latent` channels, there is also a cubic
    /// for each of `latent` components.
    ///
    /// # Errors
    /// Rows that cannot be made.
    pub fn all(data: &impl Sequences, latent: usize, counts: &[usize]) -> Result<Vec<Self>, RepresentationError> {
        let (tokens, width) = (data.tokens(), data.width());
        let sample = Sample::of(data);
        let components = sample.components(counts.iter().copied().max().unwrap_or(0))?;
        let mean = Self { name: "mean", numbers: 0, kind: Kind::Mean(components.mean().to_vec()) };
        let cubic_each = Self { name: "cubic", numbers: 4 * width, kind: Kind::Cubic(cubic(tokens)) };
        let pca = counts.iter().map(|count| {
            let components = components.first(*count);
            Self { name: "PCA", numbers: components.len(), kind: Kind::Components(components) }
        });
        let mut all: Vec<Self> = [mean, cubic_each].into_iter().chain(pca).collect();
        if latent < width {
            let frames = Sample { size: width, ..sample }.components(latent)?;
            let kind = Kind::ComponentCubics(cubic(tokens), frames);
            all.push(Self { name: "cubic of components", numbers: 4 * latent, kind });
        }
        Ok(all)
    }

    /// Returns what comes back of whole sequences.
    ///
    /// # Shapes
    /// `[B, tokens, width]` to the same, row-major.
    ///
    /// # Errors
    /// Rows that cannot be made.
    pub fn reconstruct(&self, x: &[f32]) -> Result<Vec<f32>, RepresentationError> {
        match &self.kind {
            Kind::Mean(mean) => Ok(mean.iter().copied().cycle().take(x.len()).collect()),
            Kind::Cubic(values) => Ok(self.cubics(values, x)),
            Kind::Components(components) => Ok(components.decode(&components.encode(x))),
            Kind::ComponentCubics(values, frames) => Ok(frames.decode(&self.cubics(values, &frames.encode(x)))),
        }
    }

    /// Each of the channels that four numbers are kept of as the cubic `values` makes of it.
    fn cubics(&self, values: &DMatrix<f64>, x: &[f32]) -> Vec<f32> {
        let (tokens, width) = (values.nrows(), self.numbers / 4);
        let fitted = x.chunks_exact(tokens * width).flat_map(|sequence| {
            let rows = DMatrix::from_row_iterator(tokens, width, sequence.iter().map(|x| f64::from(*x)));
            let fitted = (values * rows).transpose();
            fitted.iter().map(|y| *y as f32).collect::<Vec<_>>()
        });
        fitted.collect()
    }
}

/// Returns the matrix that makes values of a channel those of the cubic polynomial nearest to them: V (Vᵀ V)⁻¹ Vᵀ, by an orthonormal
/// basis of the polynomials.
fn cubic(tokens: usize) -> DMatrix<f64> {
    let time = |i: usize| 2.0 * i as f64 / (tokens.max(2) - 1) as f64 - 1.0;
    let basis = DMatrix::from_fn(tokens, tokens.min(4), |i, power| time(i).powi(power as i32)).qr().q();
    &basis * basis.transpose()
}

/// Training sequences, drawn once, in rows of `size` numbers: whole ones, or their frames.
struct Sample {
    rows: Vec<f32>,
    size: usize,
}

impl Sample {
    fn of(data: &impl Sequences) -> Self {
        let batches = (0..SEQUENCES / DRAWN).map(|i| data.batch(i as u64, DRAWN));
        Self { rows: batches.flatten().collect(), size: data.tokens() * data.width() }
    }

    /// The principal components of the rows, `count` or as many as there can be.
    fn components(&self, count: usize) -> Result<Components, RepresentationError> {
        let mut subspace = Subspace::new(self, count.min(self.size.min(self.len())), self.size, 0)?;
        for _ in 0..ITERATIONS {
            subspace.iterate(self)?;
        }
        Ok(subspace.components())
    }
}

impl Rows for Sample {
    fn len(&self) -> usize {
        self.rows.len() / self.size
    }

    fn gather(&self, rows: &[usize]) -> Result<Vec<f32>, RepresentationError> {
        Ok(rows.iter().flat_map(|row| &self.rows[row * self.size..][..self.size]).copied().collect())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::ops::Range;

    use super::super::sequences::HeldOut;
    use super::*;

    /// Sequences a·u + b·w + c, u a cubic and w not, of two channels.
    struct Known;

    fn sequence(number: usize) -> Vec<f32> {
        let [a, b] = [3, 7].map(|prime| (number * prime % 11) as f32 - 5.0);
        let row = |i: usize| {
            let t = i as f32 / 15.0;
            [1.0 + a * t * t * t, 2.0 - a * t + b * (9.0 * t).sin()]
        };
        (0..16).flat_map(row).collect()
    }

    impl Sequences for Known {
        fn describe(&self) -> String {
            "known".into()
        }

        fn width(&self) -> usize {
            2
        }

        fn tokens(&self) -> usize {
            16
        }

        fn batch(&self, iteration: u64, count: usize) -> Vec<f32> {
            (0..count).flat_map(|i| sequence(i + iteration as usize)).collect()
        }

        fn held_out_len(&self, _: HeldOut) -> usize {
            33
        }

        fn held_out(&self, _: HeldOut, range: Range<usize>) -> Vec<f32> {
            range.flat_map(|i| sequence(i + 1)).collect()
        }
    }

    #[test]
    fn each_is_exact_where_it_can_be_and_not_elsewhere() {
        let all = Plain::all(&Known, 1, &[1, 2]).unwrap();
        let told: Vec<_> = all.iter().map(|plain| (plain.name, plain.numbers)).collect();
        assert_eq!(told, [("mean", 0), ("cubic", 8), ("PCA", 1), ("PCA", 2), ("cubic of components", 4)]);
        assert_eq!(Plain::all(&Known, 2, &[1]).unwrap().len(), 3, "two components of two channels are the channels");
        let x = Known.held_out(HeldOut::Test, 0..33);
        let mse = |plain: &Plain| -> f64 {
            let squares = x.iter().zip(plain.reconstruct(&x).unwrap()).map(|(x, y)| f64::from(x - y).powi(2));
            squares.sum::<f64>() / x.len() as f64
        };
        let mse: Vec<f64> = all.iter().map(mse).collect();
        assert!(mse[0] > mse[2] && mse[2] > 0.1, "one component says more than none: {mse:?}");
        assert!(mse[3] < 1e-8, "two directions are two components: {mse:?}");
        assert!(mse[1] < mse[4] && mse[4] < mse[0], "a cubic of one channel of two: {mse:?}");
        let x = sequence(4);
        let fitted = all[1].reconstruct(&x).unwrap();
        let off = |channel: usize| -> f32 {
            x.iter().zip(&fitted).skip(channel).step_by(2).map(|(x, y)| (x - y).abs()).sum()
        };
        assert!(off(0) < 1e-4, "a cubic comes back");
        assert!(off(1) > 1.0, "a wave does not");
    }

    #[test]
    fn the_cubic_is_least_squares() {
        let values = cubic(9);
        assert!((&values * &values - &values).norm() < 1e-12, "what is fitted once stays");
        let x = DMatrix::from_fn(9, 1, |i, _| f64::from([1, -2, 4, 0, 3, 3, -1, 2, 5][i]));
        let rest = &x - &values * &x;
        for power in 0..4 {
            let against: f64 = rest.iter().enumerate().map(|(i, r)| r * (i as f64).powi(power)).sum();
            assert!(against.abs() < 1e-9, "nothing of t^{power} is left: {against}");
        }
    }
}
