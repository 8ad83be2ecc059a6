//! Promises of the checkpoint file: exact, reproducible, whole or refused.

use lifelike_checkpoint::{Checkpoint, CheckpointError};
use lifelike_nn::mlp::MlpConfig;
use lifelike_nn::parameters::{ParameterList, Parameters};

fn perceptron(inputs: usize, hidden: &[usize], outputs: usize, seed: u64) -> Parameters {
    let mut list = ParameterList::default();
    MlpConfig::new(inputs, hidden, outputs).add_to(&mut list, "value", seed, "net");
    list.finish()
}

fn network(seed: u64) -> Parameters {
    perceptron(3, &[8, 4], 2, seed)
}

fn bits(parameters: &Parameters) -> Vec<u32> {
    parameters.values().iter().copied().map(f32::to_bits).collect()
}

fn filled() -> Checkpoint {
    let mut c = Checkpoint::new();
    c.put_f32("a", &[2, 2], vec![1.5, f32::NAN, -0.0, f32::MIN_POSITIVE / 4.0]).unwrap();
    c.put_f64("b", &[1], vec![std::f64::consts::PI]).unwrap();
    c.put_u64("c", &[2], vec![u64::MAX, 0]).unwrap();
    c.put_u8("d", &[3], vec![0, 127, 255]).unwrap();
    c.put_f32("empty", &[0, 5], vec![]).unwrap();
    c.set_meta("names", &["left", "right"]).unwrap();
    c.set_meta("rate", &0.1_f64).unwrap();
    network(1).save_into(&mut c, "net").unwrap();
    c
}

#[test]
fn what_was_saved_is_what_is_loaded_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.safetensors");
    filled().save(&path).unwrap();
    let back = Checkpoint::load(&path).unwrap();
    let a = back.f32s("a", &[2, 2]).unwrap();
    assert_eq!(a.iter().map(|x| x.to_bits()).collect::<Vec<_>>()[1..3], [f32::NAN.to_bits(), (-0.0_f32).to_bits()]);
    assert_eq!(a[3].to_bits(), (f32::MIN_POSITIVE / 4.0).to_bits(), "denormal numbers survive");
    assert_eq!(back.f64s("b", &[1]).unwrap(), [std::f64::consts::PI]);
    assert_eq!(back.u64s("c", &[2]).unwrap(), [u64::MAX, 0]);
    assert_eq!(back.u8s("d", &[3]).unwrap(), [0, 127, 255]);
    assert!(back.f32s("empty", &[0, 5]).unwrap().is_empty());
    assert_eq!(back.meta::<Vec<String>>("names").unwrap(), ["left", "right"]);
    assert_eq!(back.meta::<f64>("rate").unwrap(), 0.1);
    let loaded = network(2).load_from(&back, "net").unwrap();
    assert_ne!(bits(&network(2)), bits(&network(1)));
    assert_eq!(bits(&loaded), bits(&network(1)));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary file stays behind");
}

#[test]
fn equal_contents_give_equal_bytes() {
    let bytes = filled().to_bytes().unwrap();
    for _ in 0..20 {
        assert_eq!(filled().to_bytes().unwrap(), bytes);
    }
}

#[test]
fn every_truncation_is_refused_and_none_panics() {
    let bytes = filled().to_bytes().unwrap();
    let path = std::path::Path::new("cut.safetensors");
    for length in 0..bytes.len() {
        let error = Checkpoint::from_bytes(&bytes[..length], path).unwrap_err();
        let CheckpointError::Length { expected, got, .. } = error else { panic!("{length}: {error}") };
        assert_eq!(got, length as u64);
        assert!(expected > got && expected <= bytes.len() as u64, "{length}: {expected}");
    }
    let mut longer = bytes;
    longer.push(0);
    assert!(matches!(Checkpoint::from_bytes(&longer, path), Err(CheckpointError::Length { .. })));
}

#[test]
fn every_changed_bit_is_noticed() {
    let bytes = filled().to_bytes().unwrap();
    let path = std::path::Path::new("rotten.safetensors");
    let mut digests = 0;
    for at in 0..bytes.len() {
        let mut rotten = bytes.clone();
        rotten[at] ^= 1 << (at % 8);
        match Checkpoint::from_bytes(&rotten, path) {
            Err(CheckpointError::Digest { .. }) => digests += 1,
            Err(_) => {}
            // White space inside the header's own JSON says nothing.
            Ok(read) => assert!(rotten[at] == b' ' || bytes[at] == b' ', "byte {at} of {}: {read:?}", bytes.len()),
        }
    }
    assert!(digests > bytes.len() / 4, "the digest, not only the format, must have noticed: {digests}");
}

#[test]
fn enormous_headers_are_refused_without_allocating() {
    for header in [u64::MAX, 1 << 40, 99_999_999] {
        let mut bytes = header.to_le_bytes().to_vec();
        bytes.extend(b"{}");
        assert!(Checkpoint::from_bytes(&bytes, std::path::Path::new("x")).is_err());
    }
}

#[test]
fn a_wrong_structure_is_named() {
    let c = filled();
    let message = perceptron(3, &[9, 4], 2, 0).load_from(&c, "net").unwrap_err().to_string();
    let named = ["net.value.layers.0.weight", "[3, 9]", "[3, 8]"];
    assert!(named.iter().all(|part| message.contains(part)), "{message}");
    let deeper = perceptron(3, &[8, 4, 4], 2, 0).load_from(&c, "net").unwrap_err();
    let CheckpointError::Missing { names, .. } = deeper else { panic!("{deeper}") };
    assert_eq!(names, ["net.value.layers.3.weight", "net.value.layers.3.bias"]);
    let shallower = perceptron(3, &[8], 4, 0).load_from(&c, "net").unwrap_err();
    let CheckpointError::Unexpected { names, .. } = shallower else { panic!("{shallower}") };
    assert_eq!(names, ["net.value.layers.2.bias", "net.value.layers.2.weight"]);
    assert!(c.f64s("a", &[2, 2]).is_err(), "another type");
    assert!(c.f32s("a", &[4]).is_err(), "another shape");
    assert!(c.meta::<u64>("names").is_err() && c.meta::<u64>("nothing").is_err());
    let mut c = c;
    assert!(c.put_u8("a", &[1], vec![1]).is_err(), "a name taken");
    assert!(c.put_u8("short", &[2], vec![1]).is_err(), "too few numbers");
}

#[test]
fn a_failed_save_leaves_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.safetensors");
    filled().save(&path).unwrap();
    assert!(filled().save(&folder.path().join("nowhere/run.safetensors")).is_err());
    assert!(Checkpoint::load(&path).is_ok());
    assert!(matches!(Checkpoint::load(&folder.path().join("other")), Err(CheckpointError::Input(_))));
}
