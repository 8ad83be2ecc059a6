//! LDA against scikit-learn and mutual information against numpy and scipy: `fixtures/latent.py` writes what they say.

use lifelike_representation::latent::lda::{Discriminant, classes, lda};
use lifelike_representation::latent::mutual_information::{information, pairs};
use lifelike_representation::latent::{Codes, Encoded, comparison};
use serde::Deserialize;

#[derive(Deserialize)]
struct Oracle {
    fps: f64,
    lengths: Vec<usize>,
    codes: Vec<Vec<f32>>,
    features: Vec<Vec<f32>>,
    classes: usize,
    accuracy: f64,
    held_out_accuracy: f64,
    predicted: Vec<usize>,
    margins: Vec<Vec<f64>>,
    information: Vec<Vec<f64>>,
}

fn oracle() -> (Oracle, Codes) {
    let oracle: Oracle = serde_json::from_str(include_str!("../fixtures/latent.json")).unwrap();
    let names = (0..oracle.lengths.len()).map(|i| format!("clip_{i}")).collect();
    let mut starts = vec![0];
    oracle.lengths.iter().for_each(|n| starts.push(starts.last().unwrap() + n));
    let codes = Codes::new(names, starts, oracle.codes.concat(), oracle.codes[0].len(), oracle.fps).unwrap();
    (oracle, codes)
}

#[test]
fn lda_agrees_with_scikit_learn_even_where_the_covariance_is_singular() {
    let (oracle, codes) = oracle();
    let score = lda(&codes).unwrap();
    assert_eq!(score.classes, oracle.classes);
    assert!((score.accuracy - oracle.accuracy).abs() < 1e-12, "{score:?} {}", oracle.accuracy);
    assert!(
        (score.held_out_accuracy - oracle.held_out_accuracy).abs() < 1e-12,
        "{score:?} {}",
        oracle.held_out_accuracy
    );

    let rows: Vec<Vec<usize>> = classes(&codes).into_iter().map(|c| c.collect()).collect();
    let found = Discriminant::fit(&codes, &rows).unwrap();
    let predicted: Vec<usize> = (0..codes.len()).map(|row| found.classify(codes.row(row))).collect();
    assert_eq!(predicted, oracle.predicted, "every single code");
    for (row, margins) in oracle.margins.iter().enumerate() {
        let scores = found.scores(codes.row(row));
        for (got, expected) in scores.iter().map(|s| s - scores[0]).zip(margins) {
            // Both are eigenvectors in double precision of a matrix whose condition is about 10.
            assert!((got - expected).abs() < 1e-9 * (1.0 + expected.abs()), "row {row}: {got} {expected}");
        }
    }
}

#[test]
fn mutual_information_agrees_with_histograms_of_numpy() {
    let (oracle, codes) = oracle();
    let features = oracle.features.concat();
    let got = pairs(&features, &codes).unwrap();
    let expected = oracle.information.concat();
    assert_eq!(got.len(), expected.len());
    for (i, (g, e)) in got.iter().zip(&expected).enumerate() {
        assert!((g - e).abs() < 1e-9, "pair {i}: {g} {e}");
    }
    let mean = expected.iter().sum::<f64>() / expected.len() as f64;
    assert!((information(&features, &codes, 0).unwrap().mean - mean).abs() < 1e-9);
}

#[test]
fn a_row_of_the_table_is_what_the_parts_say() {
    let (oracle, codes) = oracle();
    let space = Encoded { name: "oracle's".into(), codes, features: oracle.features.concat() };
    let scores = comparison::compare(&[space], 0).unwrap();
    assert_eq!((scores[0].lda.accuracy, scores[0].dimension), (oracle.accuracy, 5));
    let text = comparison::table(&scores).to_text();
    assert!(text.contains("thesis: CALM") && text.contains(&format!("{:.3}", oracle.accuracy)), "{text}");
}
