//! A frozen policy gives the numbers of the trained one.

use lifelike_dense::{GruSizes, Sizes};
use lifelike_robot::controller::{ControllerHeader, PolicyWorkspace};
use lifelike_robot::{AnchorSpec, ObservationSpec};
use lifelike_train::encoder::EncoderSizes;
use lifelike_train::networks::{Actor, ActorSize};

use super::*;
use crate::Policy;
use lifelike_nn::normalizer::RunningNormalizer;

/// Hidden layers of a policy; and those of its encoder with the size of the code, where it has one. Layers that are
/// empty: a recurrent unit over its history.
type Case<'a> = (&'a [usize], Option<(&'a [usize], usize)>);

/// A policy as training would leave it, with networks of these sizes.
pub(super) fn trained(robot: &Arc<Robot>, hidden: &[usize], encoder: Option<(&[usize], usize)>) -> Policy {
    let memory = encoder.filter(|(layers, _)| layers.is_empty()).map(|(_, state)| state);
    let encoder = encoder.filter(|_| memory.is_none());
    let window = if encoder.is_some() { vec![-3, 0, 3] } else { Vec::new() };
    let history = if memory.is_some() { 4 } else { 0 };
    let reference = ReferenceSpec { frame: true, window, history, ..ReferenceSpec::default() };
    let spec = ObservationSpec::new(robot, reference, AnchorSpec { heading: true, position: true });
    let unit_code = encoder.map(|(layers, code)| {
        let widths = [spec.window_size()].into_iter().chain(layers.iter().copied()).chain([code]);
        EncoderSizes::UnitCode(Sizes::new(&widths.collect::<Vec<_>>()))
    });
    let unit = memory.map(|state| {
        EncoderSizes::Recurrent(GruSizes { inputs: spec.history_size() / history, state, steps: history })
    });
    let size = ActorSize { inputs: spec.size(), encoder: unit_code.or(unit), hidden, outputs: robot.joints() };
    let actor = Actor::init(size, 0.4, 5);
    let mut normalizer = RunningNormalizer::new(spec.size());
    normalizer.update(&rows(&spec, 50));
    let header = ControllerHeader {
        encoder: encoder.map(|(layers, code)| (layers.to_vec(), code)),
        memory,
        ..ControllerHeader::new(robot, spec, ActionSpec::Absolute, hidden.to_vec())
    };
    Policy::new(header, &actor, &normalizer, Arc::clone(robot))
}

fn rows(spec: &ObservationSpec, n: usize) -> Vec<f32> {
    (0..n * spec.size()).map(|i| ((i * 7919) % 4001) as f32 * 1e-3 - 2.0).collect()
}

#[test]
fn a_frozen_policys_outputs_are_the_trained_ones_bit_for_bit() {
    let lima = Arc::new(Robot::load("lima").unwrap());
    let cases: [Case<'_>; 5] = [
        (&[256, 256, 128], None),
        (&[512, 256, 128], None),
        (&[], None),
        (&[64, 32], Some((&[48], 8))),
        (&[64, 32], Some((&[], 32))),
    ];
    for (hidden, encoder) in cases {
        let policy = trained(&lima, hidden, encoder);
        let controller = policy.controller().unwrap();
        // One row, some, a vector of environments, and so many that several threads share the product.
        for n in [1, 2, 3, 16, 64, 200, 512] {
            let mut observations = rows(controller.observation(), n);
            let expected = policy.outputs(observations.clone()).unwrap();
            let mut got = vec![f32::NAN; expected.len()];
            controller.outputs(&mut observations, &mut PolicyWorkspace::batched(), &mut got);
            let bits = |values: &[f32]| values.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert!(bits(&expected) == bits(&got), "{hidden:?} {encoder:?}, {n} rows");

            let mut one = rows(controller.observation(), n);
            let (mut live, size) = (PolicyWorkspace::live(), controller.observation().size());
            for (row, expected) in one.chunks_exact_mut(size).zip(expected.chunks_exact(lima.joints())) {
                let mut got = vec![f32::NAN; lima.joints()];
                controller.outputs(row, &mut live, &mut got);
                assert!(bits(expected) == bits(&got), "{hidden:?} {encoder:?}, one row of {n}");
            }
        }
    }
}
