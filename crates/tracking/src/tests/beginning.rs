//! Contracts of trainings that begin with the networks of others.

use lifelike_robot::controller::{ControllerHeader, KIND};

use super::*;
use crate::TrackerError;

fn trainer(plan: &TrackerPlan) -> Trainer {
    let robot = robot();
    let simulation = Box::new(Followers::new(plan.ppo.environments));
    Trainer::new(plan, Arc::clone(&robot), library(&robot), simulation).unwrap()
}

/// A training that begins with the networks that its plan names.
fn begun(plan: &TrackerPlan) -> Result<(Trainer, crate::trainer::Beginning), TrackerError> {
    trainer(plan).initialised(plan.init.as_deref().unwrap())
}

/// A policy that learned for an iteration, as a file.
fn learned(plan: &TrackerPlan, folder: &std::path::Path) -> (Policy, std::path::PathBuf) {
    let mut trainer = trainer(plan);
    trainer.iterate().unwrap();
    let path = folder.join("other.controller.safetensors");
    trainer.policy().save(&path).unwrap();
    (trainer.policy(), path)
}

#[test]
fn a_policy_file_brings_its_value_function_where_the_layers_are_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let (other, path) = learned(&plan(3), folder.path());
    let same = TrackerPlan { init: Some(path), ..plan(3) };
    let (begun, beginning) = self::begun(&same).unwrap();
    assert!(beginning.value_function && beginning.new_parts.is_empty());
    let (begun, other) = (begun.policy().to_checkpoint().unwrap(), other.to_checkpoint().unwrap());
    assert_eq!(begun.entries(), other.entries(), "both networks and both normalizers, bit for bit");
    let mut wider = same;
    wider.network.critic = vec![24];
    assert!(!self::begun(&wider).unwrap().1.value_function);
}

#[test]
fn what_is_written_is_the_average_and_what_learns_is_the_last_policy() {
    let plan = plan(3);
    let mut run = trainer(&plan);
    for _ in 0..6 {
        run.iterate().unwrap();
    }
    let (checkpoint, policy) = (run.checkpoint().unwrap(), run.policy().to_checkpoint().unwrap());
    let of = |name: &str| checkpoint.entry(&format!("learner.{name}.mean.layers.0.weight")).unwrap();
    assert_eq!(of("average"), policy.entry("actor.mean.layers.0.weight").unwrap());
    assert_ne!(of("average"), of("actor"));
    let mut last = plan.clone();
    last.ppo.averaging = 0.0;
    let mut other = trainer(&last);
    for _ in 0..6 {
        other.iterate().unwrap();
    }
    let (other, raw) = (other.checkpoint().unwrap(), "learner.actor.mean.layers.0.weight");
    assert_eq!(other.entry(raw).unwrap(), of("actor"), "averaging changes nothing of the training");

    // A training that begins with the run's folder begins as one that begins with its file.
    let folder = tempfile::tempdir().unwrap();
    let at = RunFolder::create(folder.path().join("run"), &plan).unwrap();
    let mut begun = trainer(&TrackerPlan { budget: crate::plan::Budget { steps: 48, minutes: None }, ..plan.clone() });
    let training = TrainingRun { folder: &at, stop: &AtomicBool::new(false), collective: &Alone };
    training.run(&mut begun, |_| ()).unwrap();
    let policy = begun.policy().to_checkpoint().unwrap();
    let next = TrackerPlan { init: Some(at.path().into()), ..plan };
    let next = self::begun(&next).unwrap().0.policy().to_checkpoint().unwrap();
    assert_eq!(next.entries(), policy.entries());
}

#[test]
fn a_policy_that_sees_more_acts_at_first_as_the_one_it_began_with() {
    let folder = tempfile::tempdir().unwrap();
    let (other, path) = learned(&plan(3), folder.path());
    let mut more = TrackerPlan { init: Some(path), ..plan(3) };
    more.inputs.future = vec![2, 5, 9];
    let (begun, beginning) = self::begun(&more).unwrap();
    assert!(beginning.value_function);
    assert_eq!(beginning.new_parts, ["reference+2", "reference+9"]);
    let parts = begun.environment().observation().parts();
    let rows = begun.environment().actor_rows();
    let known = |part: &&Part| !beginning.new_parts.contains(&part.name);
    let less = |row: &[f32]| -> Vec<f32> {
        parts.iter().filter(known).flat_map(|part| row[part.range.clone()].to_vec()).collect()
    };
    let seen: Vec<f32> = rows.chunks_exact(begun.environment().actor_size()).flat_map(less).collect();
    let expected = other.outputs(seen).unwrap();
    let got = begun.policy().outputs(rows.to_vec()).unwrap();
    for (got, expected) in got.iter().zip(&expected) {
        assert!((got - expected).abs() < 1e-6, "{got} {expected}");
    }
    assert!(expected.iter().any(|x| x.abs() > 1e-4), "the outputs say something");
}

#[test]
fn a_policy_that_saw_what_the_plan_does_not_show_is_refused_by_the_parts_name() {
    let folder = tempfile::tempdir().unwrap();
    let (_, path) = learned(&plan(3), folder.path());
    let mut less = TrackerPlan { init: Some(path), ..plan(3) };
    less.inputs.future = vec![];
    let error = self::begun(&less).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("'reference+5'") && error.contains("other.controller.safetensors"), "{error}");
    less.inputs.future = vec![5];
    less.action = ActionSpec::Absolute;
    let error = self::begun(&less).map(|_| ()).unwrap_err().to_string();
    assert!(error.starts_with("action of the policy"), "{error}");

    // Numbers of the same size that mean something else.
    let mut checkpoint = Checkpoint::load(&folder.path().join("other.controller.safetensors")).unwrap();
    let mut header: ControllerHeader = checkpoint.meta(KIND).unwrap();
    header.control_hz = 30.0;
    checkpoint.set_meta(KIND, &header).unwrap();
    let path = folder.path().join("slow.controller.safetensors");
    checkpoint.save(&path).unwrap();
    let slow = TrackerPlan { init: Some(path), ..plan(3) };
    let error = self::begun(&slow).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("policy rate") && error.contains("expected 30"), "{error}");
}
