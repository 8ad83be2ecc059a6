//! Tables and figures of thesis chapter 2 on twins: a network learns on KickBot that is attached at its pelvis, from random motions, and is
//! tested on authored motions of it, of KickBot attached at a foot, and of DanceBot.
//!
//! `cargo run --release -p lifelike-augmentation --example twin_tables -- WHAT [iterations] [seeds] [runs]`, WHAT one of gap, architectures,
//! modular, outputs, current, bodies, speed, perturbed, attention, losses.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use lifelike_augmentation::model::{Backbone, SatSizes, merged, split};
use lifelike_augmentation::references::random::RandomSpec;
use lifelike_augmentation::references::{authored, coverage, random};
use lifelike_augmentation::replay::{Measuring, on_twin};
use lifelike_augmentation::training::{AugmentationPlan, AugmentationTrainer, FeedbackShares, LossKind};
use lifelike_augmentation::{Augmentation, AugmentationError, Feedback, gap};
use lifelike_checkpoint::rng::stream;
use lifelike_robot::Robot;
use lifelike_sim::trace::Trace;
use lifelike_sim::twin::TwinSpec;
use rand::Rng;
use rand_distr::StandardNormal;

const SERVO: &str = "xm430";
const BODY: &str = "body";
/// Length of a run (s), as in the thesis.
const SECONDS: f64 = 30.0;

type Outcome<T> = Result<T, Box<dyn Error>>;

fn robot(name: &str) -> Result<Arc<Robot>, Box<dyn Error>> {
    let file = format!("{}/../robot/robots/{name}.xml", env!("CARGO_MANIFEST_DIR"));
    Ok(Arc::new(Robot::load(&file)?))
}

/// The twin of a robot: KickBot is one robot wherever it is attached, DanceBot another.
fn twin(name: &str) -> TwinSpec {
    TwinSpec { seed: if name == "dancebot" { 2 } else { 1 }, ..TwinSpec::default() }
}

fn measuring(bodies: bool) -> Measuring {
    Measuring { bodies: bodies.then(|| BODY.into()), ..Measuring::default() }
}

/// Random motions of KickBot: what is learned from.
fn random_runs(runs: usize, seed: u64, bodies: bool) -> Outcome<Vec<Trace>> {
    let robot = robot("kickbot")?;
    let spec = RandomSpec { seed, runs, seconds: SECONDS, ..RandomSpec::default() };
    Ok(on_twin(&random::draw(&robot, &spec)?, &robot, &robot, &twin("kickbot"), &measuring(bodies))?)
}

/// Authored motions of a robot, in the nominal simulation of `nominal`.
fn authored_runs(name: &str, nominal: &Arc<Robot>, speed: f64, bodies: bool) -> Outcome<Vec<Trace>> {
    let robot = robot(name)?;
    let folder = format!("{}/../../experiments/poses/{name}", env!("CARGO_MANIFEST_DIR"));
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(Path::new(&folder))?.map(|entry| Ok(entry?.path())).collect::<Result<_, std::io::Error>>()?;
    files.sort();
    let load = |file: &PathBuf| authored::load(file, &robot, SECONDS, speed);
    let references = files.iter().map(load).collect::<Result<Vec<_>, _>>()?;
    Ok(on_twin(&references, nominal, &robot, &twin(name), &measuring(bodies))?)
}

/// MAE and largest error of a column, in the mean over blocks and runs, with standard deviations; CCC.
#[derive(Debug, Clone, Copy)]
struct Numbers {
    mae: [f64; 2],
    max: [f64; 2],
    ccc: f64,
}

fn numbers(traces: &[Trace], class: &str, column: &str) -> Numbers {
    let gaps: Vec<gap::Gap> = traces.iter().flat_map(gap::gaps).filter(|gap| gap.class == class).collect();
    let summary = gap::summary(&gaps);
    let factor = match column {
        gap::PLACE => 1e3,
        "current" => 1.0,
        _ => 1_f64.to_degrees(),
    };
    summary.iter().find(|own| own.column == column).map_or(
        Numbers { mae: [f64::NAN; 2], max: [f64::NAN; 2], ccc: f64::NAN },
        |own| Numbers { mae: own.mae.map(|x| factor * x), max: own.max.map(|x| factor * x), ccc: own.ccc[0] },
    )
}

fn corrected(
    augmentation: &Augmentation,
    traces: &[Trace],
    feedback: Feedback,
) -> Result<Vec<Trace>, AugmentationError> {
    use rayon::prelude::*;
    traces.par_iter().map(|trace| augmentation.corrected(trace, feedback)).collect()
}

struct Settings {
    iterations: u64,
    seeds: u64,
    runs: usize,
}

fn plan(class: &str, outputs: &[&str], settings: &Settings, seed: u64) -> AugmentationPlan {
    AugmentationPlan {
        seed,
        class: class.into(),
        outputs: outputs.iter().map(|name| (*name).to_string()).collect(),
        iterations: settings.iterations,
        validate_every: (settings.iterations / 5).max(1),
        ..AugmentationPlan::default()
    }
}

fn train(plan: &AugmentationPlan, learn: &[Trace], validation: &[Trace]) -> Outcome<Augmentation> {
    let mut trainer = AugmentationTrainer::new(plan, learn, validation)?;
    for _ in 0..plan.iterations {
        trainer.iterate();
        if trainer.iteration().is_multiple_of(plan.validate_every) {
            trainer.validate_once();
        }
    }
    Ok(trainer.augmentation())
}

/// A row: mean and standard deviation over seeds of what each seed has in the mean over blocks and runs.
fn row(name: &str, tests: &[(&str, Numbers)]) {
    print!("{name:<28}");
    for (test, n) in tests {
        print!("  {test}: {:.3} ±{:.3} max {:.3} ±{:.3} CCC {:.3}", n.mae[0], n.mae[1], n.max[0], n.max[1], n.ccc);
    }
    println!();
}

fn over_seeds(all: &[Numbers]) -> Numbers {
    let spread = |of: fn(&Numbers) -> f64| {
        let mean = all.iter().map(of).sum::<f64>() / all.len() as f64;
        [mean, (all.iter().map(|n| (of(n) - mean).powi(2)).sum::<f64>() / all.len() as f64).sqrt()]
    };
    let ccc = all.iter().map(|n| n.ccc).sum::<f64>() / all.len() as f64;
    Numbers { mae: spread(|n| n.mae[0]), max: spread(|n| n.max[0]), ccc }
}

/// Tests by name.
type Tests = Vec<(&'static str, Vec<Trace>)>;

fn tests(bodies: bool) -> Outcome<Tests> {
    let own = |name: &'static str| Ok((name, authored_runs(name, &robot(name)?, 1.0, bodies)?));
    match bodies {
        true => ["kickbot", "kickbot_foot"].into_iter().map(own).collect(),
        false => ["kickbot", "kickbot_foot", "dancebot"].into_iter().map(own).collect(),
    }
}

fn architectures() -> [(&'static str, SatSizes); 4] {
    let own = |backbone, attention| SatSizes { backbone, attention, ..SatSizes::default() };
    [
        ("LSTM", own(Backbone::Lstm, false)),
        ("attention", own(Backbone::None, true)),
        ("attention + dense", own(Backbone::Dense, true)),
        ("SAT", own(Backbone::Lstm, true)),
    ]
}

fn simulation_row(tests: &Tests, class: &str, column: &str) {
    let all: Vec<_> = tests.iter().map(|(name, traces)| (*name, numbers(traces, class, column))).collect();
    row("simulation", &all);
}

/// Trains with every seed and prints what each test says.
fn report(
    name: &str,
    plans: &[AugmentationPlan],
    learn: &[Trace],
    validation: &[Trace],
    tests: &Tests,
    column: &str,
    feedback: Feedback,
) -> Outcome<()> {
    let mut all: BTreeMap<&str, Vec<Numbers>> = BTreeMap::new();
    for plan in plans {
        let augmentation = train(plan, learn, validation)?;
        for (test, traces) in tests {
            let traces = corrected(&augmentation, traces, feedback)?;
            all.entry(test).or_default().push(numbers(&traces, &plan.class, column));
        }
    }
    let rows: Vec<_> = tests.iter().map(|(test, _)| (*test, over_seeds(&all[test]))).collect();
    row(name, &rows);
    Ok(())
}

fn main() -> Outcome<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, default: u64| arguments.get(i).map_or(Ok(default), |text| text.parse());
    let settings = Settings { iterations: number(1, 1000)?, seeds: number(2, 3)?, runs: number(3, 60)? as usize };
    let what = arguments.first().map_or("gap", String::as_str);
    let start = std::time::Instant::now();
    match what {
        "gap" => gaps(&settings)?,
        "architectures" => table_2_1(&settings)?,
        "modular" => not_modular_rows(&settings)?,
        "outputs" => figure_2_5(&settings)?,
        "current" => figure_2_6(&settings)?,
        "bodies" => figure_2_8(&settings)?,
        "speed" => figure_2_9(&settings)?,
        "perturbed" => figure_2_10(&settings)?,
        "attention" => figure_2_11(&settings)?,
        "losses" => figure_2_12(&settings)?,
        other => return Err(format!("expected gap, architectures, modular, outputs, current, bodies, speed, perturbed, attention or losses, got '{other}'").into()),
    }
    println!("{what}: {:.0} s", start.elapsed().as_secs_f64());
    Ok(())
}

fn seeds(settings: &Settings, one: impl Fn(u64) -> AugmentationPlan) -> Vec<AugmentationPlan> {
    (0..settings.seeds).map(one).collect()
}

/// The plain simulation, and what the random motions reach.
fn gaps(settings: &Settings) -> Outcome<()> {
    let robot = robot("kickbot")?;
    let spec = RandomSpec { runs: settings.runs, seconds: SECONDS, ..RandomSpec::default() };
    for own in coverage::coverage(&robot, &random::draw(&robot, &spec)?)? {
        println!(
            "{:<22} reached {:3.0}%  visited {:3.0}%  speed {:.2} and {:.2} rad/s  {:.2} reversals a second",
            own.joint,
            100.0 * own.reached,
            100.0 * own.visited,
            own.speed[0],
            own.speed[1],
            own.reversals
        );
    }
    let mut all = tests(true)?;
    all.push(("dancebot", authored_runs("dancebot", &self::robot("dancebot")?, 1.0, false)?));
    all.push(("random", random_runs(settings.runs, 1, true)?));
    for (name, traces) in &all {
        for (class, column) in
            [(SERVO, "position"), (SERVO, "velocity"), (SERVO, "current"), (BODY, gap::PLACE), (BODY, gap::ORIENTATION)]
        {
            row(&format!("{name} {column}"), &[("", numbers(traces, class, column))]);
        }
        let told: Vec<Trace> = traces.iter().map(told_the_error_before).collect();
        for column in ["position", "velocity"] {
            let name = format!("{name} {column}, told the error of the step before");
            row(&name, &[("", numbers(&told, SERVO, column))]);
        }
    }
    Ok(())
}

/// The plainest use of measurements: the error of the step before is taken for this one's.
fn told_the_error_before(trace: &Trace) -> Trace {
    let mut told = trace.clone();
    for (own, block) in told.blocks.iter_mut().zip(&trace.blocks).filter(|(own, _)| own.class == SERVO) {
        let (errors, width, measured) = (block.error(), own.simulated.names.len(), own.measured.names.len());
        // Position and velocity are the first columns of both.
        for (row, error) in own.simulated.values.chunks_exact_mut(width).skip(1).zip(errors.chunks_exact(measured)) {
            row[..2].iter_mut().zip(error).for_each(|(x, error)| *x += error);
        }
    }
    told
}

fn table_2_1(settings: &Settings) -> Outcome<()> {
    for (class, bodies) in [(SERVO, false), (BODY, true)] {
        let (learn, validation) = (random_runs(settings.runs, 1, bodies)?, random_runs(5, 2, bodies)?);
        let tests = tests(bodies)?;
        let (outputs, column): (&[&str], _) = match bodies {
            true => (&["position_x", "position_y", "position_z"], gap::PLACE),
            false => (&["position"], "position"),
        };
        println!("{class}: {column}");
        simulation_row(&tests, class, column);
        for (name, model) in architectures() {
            let plans = seeds(settings, |seed| AugmentationPlan { model, ..plan(class, outputs, settings, seed) });
            report(name, &plans, &learn, &validation, &tests, column, Feedback::None)?;
        }
        if !bodies {
            let plans = seeds(settings, |seed| {
                let plan = plan(class, outputs, settings, seed);
                AugmentationPlan { hysteresis: Vec::new(), ..plan }
            });
            report("SAT without hysteresis", &plans, &learn, &validation, &tests, column, Feedback::None)?;
        }
    }
    Ok(())
}

/// Position and velocity together with the physics-informed loss.
fn figure_2_5(settings: &Settings) -> Outcome<()> {
    let (learn, validation) = (random_runs(settings.runs, 1, false)?, random_runs(5, 2, false)?);
    let tests = tests(false)?;
    let plans = seeds(settings, |seed| plan(SERVO, &["position", "velocity"], settings, seed));
    let mut trained = Vec::new();
    for plan in &plans {
        trained.push(train(plan, &learn, &validation)?);
    }
    for column in ["position", "velocity"] {
        println!("{column}");
        simulation_row(&tests, SERVO, column);
        for (name, feedback) in [
            ("SAT", Feedback::None),
            ("SAT told its own", Feedback::Predicted),
            ("SAT told measurements", Feedback::Measured),
        ] {
            let mut rows = Vec::new();
            for (test, traces) in &tests {
                let all: Vec<Numbers> = trained
                    .iter()
                    .map(|own| Ok(numbers(&corrected(own, traces, feedback)?, SERVO, column)))
                    .collect::<Result<_, AugmentationError>>()?;
                rows.push((*test, over_seeds(&all)));
            }
            row(name, &rows);
        }
    }
    Ok(())
}

/// The non-modular form beside the modular one's rows of Table 2.1.
fn not_modular_rows(settings: &Settings) -> Outcome<()> {
    for (class, stem, column, bodies) in [(SERVO, "position", "position", false), (BODY, "position", gap::PLACE, true)]
    {
        let all = |traces: &[Trace]| traces.iter().map(|trace| merged(trace, class)).collect::<Vec<_>>();
        let learn = (all(&random_runs(settings.runs, 1, bodies)?), all(&random_runs(5, 2, bodies)?));
        let tests = tests(bodies)?;
        println!("{class}: {column}");
        simulation_row(&tests, class, column);
        not_modular(settings, class, (stem, column), learn, &tests)?;
    }
    Ok(())
}

/// One network for all blocks at once; it cannot be asked about a robot with other blocks.
fn not_modular(
    settings: &Settings,
    class: &str,
    (stem, column): (&str, &str),
    (learn, validation): (Vec<Trace>, Vec<Trace>),
    tests: &Tests,
) -> Outcome<()> {
    let Some(first) = learn.first().and_then(|trace| trace.blocks.first()) else { return Ok(()) };
    let wanted = |name: &&String| name.contains(&format!(".{stem}"));
    let outputs: Vec<&str> = first.measured.names.iter().filter(wanted).map(String::as_str).collect();
    let mut all: BTreeMap<&str, Vec<Numbers>> = BTreeMap::new();
    for seed in 0..settings.seeds {
        // Twice as wide, and two stretches of twelve blocks where the modular network has sixteen of one.
        let model = SatSizes { width: 2 * SatSizes::default().width, ..SatSizes::default() };
        let plan = AugmentationPlan { model, batch: 2, part: 1, ..plan(class, &outputs, settings, seed) };
        let augmentation = train(&plan, &learn, &validation)?;
        // DanceBot has other blocks, and KickBot has another fixed body where it is attached at a foot.
        for (test, traces) in
            tests.iter().filter(|(test, _)| *test == "kickbot" || (class == SERVO && *test != "dancebot"))
        {
            let merged: Vec<Trace> = traces.iter().map(|trace| merged(trace, class)).collect();
            let mut back = traces.clone();
            for (merged, own) in corrected(&augmentation, &merged, Feedback::None)?.iter().zip(&mut back) {
                split(merged, own);
            }
            all.entry(test).or_default().push(numbers(&back, class, column));
        }
    }
    let rows: Vec<_> = all.iter().map(|(test, n)| (*test, over_seeds(n))).collect();
    row("not modular", &rows);
    Ok(())
}

fn figure_2_6(settings: &Settings) -> Outcome<()> {
    let (learn, validation) = (random_runs(settings.runs, 1, false)?, random_runs(5, 2, false)?);
    let tests = tests(false)?;
    simulation_row(&tests, SERVO, "current");
    let plans = seeds(settings, |seed| plan(SERVO, &["current"], settings, seed));
    report("SAT", &plans, &learn, &validation, &tests, "current", Feedback::None)
}

fn figure_2_8(settings: &Settings) -> Outcome<()> {
    let (learn, validation) = (random_runs(settings.runs, 1, true)?, random_runs(5, 2, true)?);
    let tests = tests(true)?;
    let place = ["position_x", "position_y", "position_z"];
    let turn = ["a_x", "a_y", "a_z", "b_x", "b_y", "b_z"].map(|axis| format!("orientation_{axis}"));
    let turn: Vec<&str> = turn.iter().map(String::as_str).collect();
    for (outputs, column) in [(&turn[..], gap::ORIENTATION), (&place[..], gap::PLACE)] {
        println!("{column}");
        simulation_row(&tests, BODY, column);
        let plans = seeds(settings, |seed| plan(BODY, outputs, settings, seed));
        report("SAT", &plans, &learn, &validation, &tests, column, Feedback::None)?;
    }
    Ok(())
}

fn figure_2_9(settings: &Settings) -> Outcome<()> {
    let (learn, validation) = (random_runs(settings.runs, 1, false)?, random_runs(5, 2, false)?);
    let augmentation = train(&plan(SERVO, &["position", "velocity"], settings, 0), &learn, &validation)?;
    for speed in [1.0, 2.0, 3.0, 5.0, 10.0, 20.0] {
        let traces = authored_runs("kickbot_foot", &robot("kickbot_foot")?, speed, false)?;
        let after = corrected(&augmentation, &traces, Feedback::None)?;
        for column in ["position", "velocity"] {
            let (before, after) = (numbers(&traces, SERVO, column), numbers(&after, SERVO, column));
            let gained = 100.0 * (1.0 - after.mae[0] / before.mae[0]);
            println!("speed {speed:>4} {column:<9} {:.3} -> {:.3} ({gained:.0}% less)", before.mae[0], after.mae[0]);
        }
    }
    Ok(())
}

/// What is wrong with a nominal model, as shares of the largest wrong.
const WRONGS: [&str; 5] = ["mass", "centre of mass", "joint places", "all three", "resistance"];

/// A nominal robot with wrong numbers: masses by a factor, centres of mass and joints by a distance, resistance by a factor; the largest
/// standard deviations are 0.5, 0.02 m, 0.005 m and 0.5.
fn perturbed(robot: &Robot, wrong: &str, share: f64, seed: u64) -> Robot {
    let mut draw = stream(seed, &format!("wrong {wrong}"), 0, 0);
    let mut normal = || draw.sample::<f64, _>(StandardNormal);
    let mut own = robot.clone();
    let mut character = (*robot.character).clone();
    let is = |what: &str| wrong == what || (wrong == "all three" && what != "resistance");
    for body in character.bodies.iter_mut().skip(1) {
        if is("mass") {
            let factor = (1.0 + 0.5 * share * normal()).max(0.05);
            body.inertial.mass *= factor;
            body.inertial.diagonal *= factor;
        }
        if is("centre of mass") {
            body.inertial.com.iter_mut().for_each(|x| *x += 0.02 * share * normal());
        }
        if is("joint places") && body.parent != 0 {
            body.position.iter_mut().for_each(|x| *x += 0.005 * share * normal());
        }
    }
    if is("resistance") {
        for actuator in &mut own.actuators.parameters {
            let factor = (1.0 + 0.5 * share * normal()).max(0.2);
            // The same duty drives less current: gains, back-EMF's damping included, and stall torque fall alike.
            actuator.kp /= factor;
            actuator.kd /= factor;
            actuator.torque_max /= factor;
        }
    }
    own.character = character.into();
    own
}

/// Networks of the right nominal model, asked about simulations of wrong ones.
fn figure_2_10(settings: &Settings) -> Outcome<()> {
    let kickbot = robot("kickbot")?;
    let (learn, validation) = (random_runs(settings.runs, 1, true)?, random_runs(5, 2, true)?);
    let place = plan(BODY, &["position_x", "position_y", "position_z"], settings, 0);
    let (bodies, servos) =
        (train(&place, &learn, &validation)?, train(&plan(SERVO, &["position"], settings, 0), &learn, &validation)?);
    for wrong in WRONGS {
        for share in [0.0, 0.25, 0.5, 0.75, 1.0] {
            let mut sums = [[0.0; 2]; 2];
            for seed in 0..settings.seeds {
                let nominal = Arc::new(perturbed(&kickbot, wrong, share, seed));
                let traces = authored_runs("kickbot", &nominal, 1.0, true)?;
                for (i, (own, class, column)) in
                    [(&bodies, BODY, gap::PLACE), (&servos, SERVO, "position")].into_iter().enumerate()
                {
                    let after = corrected(own, &traces, Feedback::None)?;
                    sums[i][0] += numbers(&traces, class, column).mae[0] / settings.seeds as f64;
                    sums[i][1] += numbers(&after, class, column).mae[0] / settings.seeds as f64;
                }
            }
            let less = |[before, after]: [f64; 2]| 100.0 * (1.0 - after / before);
            println!(
                "{wrong:<15} {share:.2}  bodies {:.2} -> {:.2} mm ({:.0}% less)  actuators {:.3} -> {:.3} deg ({:.0}% less)",
                sums[0][0],
                sums[0][1],
                less(sums[0]),
                sums[1][0],
                sums[1][1],
                less(sums[1])
            );
        }
    }
    Ok(())
}

/// Where attention looks: latest step, ten latest, twenty or more steps back.
fn figure_2_11(settings: &Settings) -> Outcome<()> {
    let (learn, validation) = (random_runs(settings.runs, 1, false)?, random_runs(5, 2, false)?);
    let test = authored_runs("kickbot_foot", &robot("kickbot_foot")?, 1.0, false)?;
    for (name, model) in architectures().into_iter().filter(|(_, model)| model.attention) {
        let augmentation =
            train(&AugmentationPlan { model, ..plan(SERVO, &["position"], settings, 0) }, &learn, &validation)?;
        let header = augmentation.header();
        let (mut mean, mut count) = (Vec::new(), 0.0);
        for trace in &test {
            for block in trace.blocks.iter().filter(|block| block.class == SERVO) {
                let sequence = header.inputs.sequence("", block, &header.scales)?;
                let steps = sequence.error.len();
                let (_, pass) = augmentation.network().forward(&sequence.rows, &vec![0.0; 2 * steps], 1);
                let Some(profile) = augmentation.network().profile(&pass) else { continue };
                mean.resize(profile.len(), 0.0);
                mean.iter_mut().zip(profile).for_each(|(sum, x)| *sum += x);
                count += 1.0;
            }
        }
        mean.iter_mut().for_each(|x| *x *= 100.0 / count);
        let back = &mean[..mean.len() - 1];
        println!(
            "{name:<20} itself {:.1}%  1 step back {:.1}%  1-10 {:.1}%  11-19 {:.1}%  20 and more {:.1}%",
            mean[mean.len() - 1],
            back[0],
            back[..10].iter().sum::<f64>(),
            back[10..19].iter().sum::<f64>(),
            back[19..].iter().sum::<f64>()
        );
        let every: Vec<String> = back.iter().step_by(8).map(|x| format!("{x:.2}")).collect();
        println!("  1, 9, 17, ... back: {}", every.join(" "));
    }
    Ok(())
}

/// MAE on unseen motions while learning, with three losses.
fn figure_2_12(settings: &Settings) -> Outcome<()> {
    let learn = random_runs(settings.runs, 1, false)?;
    let tests = tests(false)?;
    let [(_, first), ..] = &tests[..] else { return Ok(()) };
    for (name, loss) in
        [("quantile", LossKind::Quantile), ("L1", LossKind::L1), ("physics-informed L1", LossKind::Physics)]
    {
        let plan = AugmentationPlan {
            loss,
            feedback: FeedbackShares { measured: 0.0, predicted: 0.0 },
            ..plan(SERVO, &["position", "velocity"], settings, 0)
        };
        let mut trainer = AugmentationTrainer::new(&plan, &learn, &[])?;
        let every = (settings.iterations / 10).max(1);
        for _ in 0..settings.iterations {
            trainer.iterate();
            if trainer.iteration().is_multiple_of(every) {
                let after = corrected(&trainer.augmentation(), first, Feedback::None)?;
                let [position, velocity] = ["position", "velocity"].map(|column| numbers(&after, SERVO, column).mae[0]);
                println!("{name:<20} {:>6}  {position:.3} deg  {velocity:.2} deg/s", trainer.iteration());
            }
        }
    }
    Ok(())
}
