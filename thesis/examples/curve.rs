//! Trains a small Spline-based Transformer on Lissajous curves and prints how one that it never saw comes back: `curve
//! [ITERATIONS]`.

use lifelike_nn::adam::Rule;
use lifelike_representation::spline_transformer::{HeldOut, SequencePlan, SequenceTrainer, Sequences};
use lifelike_thesis::sequences::{CurveSequences, CurvesPlan, Family};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let iterations = std::env::args().nth(1).map_or(Ok(300), |text| text.parse())?;
    let of_the_thesis = CurvesPlan::new(Family::Lissajous);
    let training = SequencePlan {
        layers: 2,
        heads: 2,
        width: 32,
        batch: 32,
        part: 16,
        optimizer: Rule::Adam,
        iterations,
        learning_rate: 3e-3,
        ..of_the_thesis.training
    };
    let plan = CurvesPlan { samples: 32, validation: 64, test: 64, training, ..of_the_thesis };
    let mut trainer = SequenceTrainer::new(plan.training.clone(), CurveSequences::new(&plan)?)?;
    while !trainer.is_done() {
        trainer.step()?;
    }
    println!("mean squared error of 64 held-out curves: {:.4}", trainer.errors(HeldOut::Test)?.mse);
    let curve = trainer.data().held_out(HeldOut::Test, 0..1);
    let (control_points, back) = trainer.reconstruct(&curve)?;
    println!("one of them as {} numbers of 4 control points:", control_points.len());
    println!("      x       y    and back");
    for (point, back) in curve.chunks_exact(2).zip(back.chunks_exact(2)).step_by(4) {
        println!("{:7.3} {:7.3}    {:7.3} {:7.3}", point[0], point[1], back[0], back[1]);
    }
    Ok(())
}
