//! The machine, as `lifelike inspect --machine` tells of it, and instruction sets that are asked for.
#![allow(clippy::unwrap_used)]

use std::process::{Command, Output};

use lifelike_simd::{InstructionSet, VARIABLE};

fn lifelike(arguments: &[&str], set: Option<&str>) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lifelike"));
    command.args(arguments).env_remove(VARIABLE);
    if let Some(set) = set {
        command.env(VARIABLE, set);
    }
    command.output().unwrap()
}

#[test]
fn every_instruction_set_of_the_machine_can_be_forced_and_is_measured() {
    let available: Vec<&str> = InstructionSet::available().into_iter().map(InstructionSet::name).collect();
    let best = InstructionSet::best().name();
    for (forced, chosen) in [(None, best)].into_iter().chain(available.iter().map(|set| (Some(*set), *set))) {
        let output = lifelike(&["--json", "inspect", "--machine"], forced);
        assert!(output.status.success(), "{forced:?}: {}", String::from_utf8_lossy(&output.stderr));
        let told: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(told["machine"]["instruction_set"], chosen);
        assert_eq!(told["instruction_sets"], serde_json::json!(available));
        assert!(told["machine"]["cores"].as_u64().unwrap() > 0);
        // At most two multiply-adds of 16 numbers in each of 8e9 cycles: what the compiler leaves out shows as more.
        let rate = told["peak_operations_per_second"].as_f64().unwrap();
        assert!((1e7..5.2e11).contains(&rate), "{chosen}: {rate}");
    }
    let text = String::from_utf8(lifelike(&["inspect", "--machine"], None).stdout).unwrap();
    assert!(text.contains(VARIABLE) && text.contains("Gflop/s") && text.contains(best), "{text}");
}

#[test]
fn an_instruction_set_that_the_machine_has_not_is_refused_before_anything_is_done() {
    for arguments in [&["robots"][..], &["inspect", "--machine"]] {
        let output = lifelike(arguments, Some("altivec"));
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{error}");
        let sets = InstructionSet::available().iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
        assert_eq!(error.trim(), format!("lifelike: {VARIABLE}: this machine has {sets}, got 'altivec'"));
    }
    // Whoever asks for help gets it.
    assert!(lifelike(&["inspect", "--help"], Some("altivec")).status.success());
}

#[test]
fn a_machine_or_something_else_is_inspected_but_not_both_and_not_nothing() {
    for arguments in [&["inspect"][..], &["inspect", "lima", "--machine"]] {
        assert_eq!(lifelike(arguments, None).status.code(), Some(2), "{arguments:?}");
    }
}
