//! Spaces of codes side by side: thesis Table 4.2.

use super::codes::Codes;
use super::lda::{LdaScore, lda};
use super::mutual_information::{Information, information};
use crate::RepresentationError;
use lifelike_report::{Cell, Column, Table};

/// Table 4.2: name, LDA accuracy, mutual information. On another robot and other data (CALM's, two-second windows).
const THESIS: [(&str, f64, f64); 2] = [("thesis: CALM", 0.687, 0.121), ("thesis: Ours", 0.854, 0.341)];

/// Codes that an encoder made of clips. A motion prior's are made by [`Codes::of_prior`]. Those of an encoder inside
/// of a policy come from wherever that encodes its reference, with the same clips' features beside them.
#[derive(Debug, Clone)]
pub struct Encoded {
    /// Name of the row.
    pub name: String,
    /// The codes.
    pub codes: Codes,
    /// Features of the same frames, each in its own heading frame, `[T, F]`.
    pub features: Vec<f32>,
}

/// A row of the table.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct LatentScore {
    /// Name of the row.
    pub name: String,
    /// Size of a code.
    pub dimension: usize,
    /// Codes in all.
    pub frames: usize,
    /// Linear discriminant analysis.
    pub lda: LdaScore,
    /// Mutual information.
    pub information: Information,
}

/// Scores each space of codes. `seed` is for what shuffled codes give.
///
/// # Errors
/// Too little motion for classes, or features that are not those of the codes; the row is named.
pub fn compare(spaces: &[Encoded], seed: u64) -> Result<Vec<LatentScore>, RepresentationError> {
    let score = |space: &Encoded| -> Result<LatentScore, RepresentationError> {
        Ok(LatentScore {
            name: space.name.clone(),
            dimension: space.codes.dimension(),
            frames: space.codes.len(),
            lda: lda(&space.codes)?,
            information: information(&space.features, &space.codes, seed)?,
        })
    };
    spaces.iter().map(score).collect()
}

/// Returns Table 4.2 with the thesis' rows above ours.
pub fn table(scores: &[LatentScore]) -> Table {
    let columns = vec![
        Column::text("codes"),
        Column::number("size", ""),
        Column::number("classes", ""),
        Column::number("LDA acc.", ""),
        Column::number("held out", ""),
        Column::number("MI", "nats"),
        Column::number("shuffled", "nats"),
        Column::number("best", "nats"),
    ];
    let mut table = Table::new("Latent spaces (thesis Table 4.2)", columns);
    table.caption = "LDA acc.: share of codes given back to their class of 2 s, by a classifier fitted to the same codes; held out: \
                     fitted to every other 0.25 s. MI: mutual information of a feature and a code dimension in 100 bins \
                     each, mean over all pairs; shuffled: the same for codes dealt to frames at random, the estimate's bias; \
                     best: mean over features of their most telling dimension. The thesis' numbers are of another robot \
                     and other data."
        .into();
    let dash = || Cell::number(f64::NAN, 0);
    for (name, accuracy, mi) in THESIS {
        let known = [Cell::text(name), dash(), dash(), Cell::number(accuracy, 3), dash(), Cell::number(mi, 3)];
        table.rows.push(known.into_iter().chain([dash(), dash()]).collect());
    }
    for score in scores {
        table.rows.push(vec![
            Cell::text(score.name.as_str()),
            Cell::number(score.dimension as f64, 0),
            Cell::number(score.lda.classes as f64, 0),
            Cell::number(score.lda.accuracy, 3),
            Cell::number(score.lda.held_out_accuracy, 3),
            Cell::number(score.information.mean, 3),
            Cell::number(score.information.shuffled, 3),
            Cell::number(score.information.best, 3),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use lifelike_checkpoint::rng::stream;
    use rand::Rng;

    /// Slow random walks of four features, and codes that are made of them by `code`.
    fn space(code: impl Fn(&[f32], &[f32]) -> Vec<f32>) -> Encoded {
        let (frames, mut rng) = (4000, stream(3, "test", 0, 0));
        let mut noise = |n: usize| -> Vec<f32> { (0..n).map(|_| rng.random_range(-1.0..1.0)).collect() };
        let mut features: Vec<f32> = Vec::new();
        let mut rows = Vec::new();
        for i in 0..frames {
            let step = noise(4);
            let last = if i > 0 { features[4 * i - 4..].to_vec() } else { vec![0.0; 4] };
            features.extend(last.iter().zip(&step).map(|(x, dx)| 0.99 * x + dx));
            rows.extend(code(&features[4 * i..], &noise(4)));
        }
        let dimension = rows.len() / frames;
        let codes = Codes::new(vec!["walk".into()], vec![0, frames], rows, dimension, 50.0).unwrap();
        Encoded { name: "test".into(), codes, features }
    }

    #[test]
    fn codes_that_know_the_motion_score_high_and_codes_dealt_at_random_are_chance() {
        let knowing = space(|x, _| x.iter().map(|x| 2.0 * x + 1.0).collect());
        let ignorant = space(|_, noise| noise.to_vec());
        let scores = compare(&[knowing, ignorant], 1).unwrap();
        let (knows, not) = (&scores[0], &scores[1]);
        assert_eq!((knows.lda.classes, knows.frames, knows.dimension), (20, 4000, 4));
        assert!(knows.lda.held_out_accuracy > 0.4, "{knows:?}");
        assert!(knows.information.mean > 1.5 * knows.information.shuffled, "{knows:?}");
        // 20 classes, 1000 held-out codes: 0.05 with a deviation of 0.007.
        assert!((not.lda.held_out_accuracy - 0.05).abs() < 0.03, "{not:?}");
        // Five deviations of a fit to 2000 codes with five parameters per class stay below this.
        assert!(not.lda.accuracy < 0.15, "{not:?}");
        assert!((not.information.mean / not.information.shuffled - 1.0).abs() < 0.05, "{not:?}");
        assert!(knows.information.best > 2.0 && not.information.best < 1.5, "{knows:?} {not:?}");
        let text = table(&scores).to_text();
        assert!(text.contains("0.854") && text.contains("0.341") && text.contains("test"), "{text}");
    }
}
