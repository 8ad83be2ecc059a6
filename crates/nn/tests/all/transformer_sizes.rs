//! Parameter counts against thesis Table A.1 (in millions, two or three digits), and what a network refuses.

use lifelike_nn::spline::CubicBezier;
use lifelike_nn::transformer::{AutoencoderConfig, LatentTokens, NetworkError};

fn count(config: &AutoencoderConfig) -> usize {
    config.init(0, "test").unwrap().parameters().len()
}

fn millions(count: usize) -> f64 {
    count as f64 / 1e6
}

/// Numbers of an element, and d, n, h, c of a row; the largest d, as the table counts it.
fn row(inputs: usize, latent: usize, layers: usize, heads: usize, width: usize) -> usize {
    count(&AutoencoderConfig::new(inputs, latent, layers, heads, width))
}

#[test]
fn curves_strands_and_small_images_have_the_tables_counts_to_its_last_digit() {
    for (name, got, table) in [
        ("Lissajous", row(2, 3, 4, 4, 64), 0.20),
        ("hypotrochoids", row(2, 4, 4, 4, 64), 0.20),
        ("Bezier (2D)", row(2, 2, 4, 4, 64), 0.20),
        ("strands", row(3, 32, 4, 8, 64), 0.21),
        ("CIFAR-10, patches of 4", row(4 * 4 * 3, 128, 4, 8, 128), 0.85),
    ] {
        println!("{name}: {got}");
        assert!((millions(got) - table).abs() <= 0.005, "{name}: {got}, the table has {table} million");
    }
}

#[test]
fn large_images_are_within_two_percent() {
    let got = row(32 * 32 * 3, 128, 4, 8, 128);
    println!("AFHQ, face images: {got}");
    assert!((millions(got) / 1.65 - 1.0).abs() < 0.02, "{got}");
}

#[test]
fn faces_have_the_tables_count_at_5800_vertices() {
    // "Around 5000 vertices": each costs 2 · 3 · 256 parameters, and the table's count asks for some 5800.
    let got = row(3 * 5800, 256, 4, 8, 256);
    println!("faces: {got}");
    assert!((millions(got) - 12.3).abs() <= 0.05, "{got}");
    assert!(millions(row(3 * 5000, 256, 4, 8, 256)) > 10.9);
}

#[test]
fn two_rows_have_fewer_parameters_than_their_own_blocks() {
    // 2 n blocks of 6 c² and nothing else.
    let blocks = 2 * 4 * 6 * 128 * 128;
    assert!(millions(blocks) > 0.78);
    let (bezier, motion) = (row(2, 64, 4, 4, 128), row(22 * 3, 64, 4, 8, 128));
    println!("Bezier (64D): {bezier} for n = 4, {} for n = 2", row(2, 64, 2, 4, 128));
    println!("motion of 22 joints: {motion} for n = 4, {} for n = 3", row(22 * 3, 64, 3, 8, 128));
    assert!(millions(bezier) / 0.43 > 1.8 && millions(motion) / 0.63 > 1.3);
    // What does fit.
    assert!((millions(row(2, 64, 2, 4, 128)) - 0.43).abs() <= 0.005);
    assert!((millions(row(22 * 3, 64, 3, 8, 128)) / 0.63 - 1.0).abs() < 0.02);
}

#[test]
fn baselines_differ_by_their_latent_tokens_only() {
    let spline = AutoencoderConfig::new(2, 4, 4, 4, 64);
    let names = |config: &AutoencoderConfig| -> Vec<(String, Vec<usize>)> {
        let network = config.init(0, "test").unwrap();
        network.parameters().layout().entries().iter().map(|e| (e.name.clone(), e.shape.clone())).collect()
    };
    let (a, b, c) = (
        names(&spline),
        names(&spline.clone().with_tokens(LatentTokens::Alibi)),
        names(&spline.clone().with_tokens(LatentTokens::AlibiCat)),
    );
    let differing = |x: &[(String, Vec<usize>)], y: &[(String, Vec<usize>)]| -> Vec<String> {
        assert_eq!(x.len(), y.len());
        x.iter().zip(y).filter(|(x, y)| x != y).map(|(x, _)| x.0.clone()).collect()
    };
    assert_eq!(differing(&a, &b), ["control"]);
    assert_eq!(differing(&b, &c), ["from_latent.weight"]);
}

/// By hand, Lissajous' row: n = 4, c = 64, d = 3, elements of 2 numbers.
#[test]
fn a_decoder_twice_as_wide_has_the_parameters_counted_by_hand() {
    let narrow = AutoencoderConfig::new(2, 3, 4, 4, 64).with_tokens(LatentTokens::AlibiCat);
    let wide = narrow.clone().with_tokens(LatentTokens::AlibiCatWide);
    let encoder = (2 * 64 + 64) + (64 * 64 + 64) + 64 + 4 * (6 * 64 * 64 + 2 * 64) + 64 + (64 * 3 + 3);
    assert_eq!(count(&narrow), encoder + (6 * 64 + 64) + 4 * (6 * 64 * 64 + 2 * 64) + 64 + (64 * 2 + 2));
    assert_eq!(count(&wide), encoder + (6 * 128 + 128) + 4 * (6 * 128 * 128 + 2 * 128) + 128 + (128 * 2 + 2));
    assert_eq!([count(&narrow), count(&wide)], [202_949, 499_013]);
    // Table A.1's count, 0.20 million, is that of the narrow decoder.
    assert!((millions(count(&narrow)) - 0.20).abs() <= 0.005 && millions(count(&wide)) > 2.0 * 0.20);
}

#[test]
fn the_same_seed_gives_the_same_network_and_another_one_another() {
    let config = AutoencoderConfig::new(2, 3, 1, 2, 8);
    let control = |seed| config.init(seed, "test").unwrap().forward(&[1.0; 8], 4).unwrap();
    assert_eq!(control(1), control(1));
    assert_ne!(control(1), control(2));
}

#[test]
fn sizes_that_make_no_network_are_refused() {
    let good = AutoencoderConfig::new(2, 3, 1, 4, 8);
    let error = |config: AutoencoderConfig| config.init(0, "test").unwrap_err();
    assert_eq!(error(AutoencoderConfig { heads: 3, ..good.clone() }), NetworkError::Heads { heads: 3, width: 8 });
    for (config, name) in [
        (AutoencoderConfig { inputs: 0, ..good.clone() }, "inputs"),
        (AutoencoderConfig { heads: 0, ..good.clone() }, "heads"),
        (AutoencoderConfig { layers: 0, ..good.clone() }, "layers"),
    ] {
        assert_eq!(error(config), NetworkError::Zero(name));
    }
    let text = serde_json::to_string(&good).unwrap();
    assert_eq!(serde_json::from_str::<AutoencoderConfig>(&text).unwrap(), good);
    assert_eq!(good.tokens, LatentTokens::Spline(CubicBezier));
}
