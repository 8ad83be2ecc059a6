//! Table 2.1 and Figs. 2.5, 2.6 and 2.8.

use lifelike_augmentation::gap;
use lifelike_augmentation::model::{Frame, SatSizes, in_parents, merged, split};
use lifelike_augmentation::references::coverage;
use lifelike_augmentation::references::random::{self, RandomSpec};
use lifelike_augmentation::training::AugmentationPlan;
use lifelike_sim::trace::Trace;

use crate::common::*;
use crate::sheet::{Cells, Sheet};

/// The plain simulation, the plainest use of measurements, and what the random motions reach.
pub fn gaps(sheet: &mut Sheet) -> Outcome<()> {
    let settings = sheet.settings();
    let kickbot = robot("kickbot")?;
    let spec = RandomSpec { runs: settings.runs, ..RandomSpec::default() };
    for own in coverage::coverage(&kickbot, &random::draw(&kickbot, &spec)?)? {
        let (reached, visited) = (100.0 * own.reached, 100.0 * own.visited);
        let [mean, most] = own.speed;
        println!(
            "{:<22} reached {reached:3.0}%  visited {visited:3.0}%  speed {mean:.2} and {most:.2} rad/s  {:.2} reversals a second",
            own.joint, own.reversals
        );
    }
    let mut servos = tests(false)?;
    servos.push(("random", random_runs("kickbot", settings.runs, 1, false)?));
    for column in ["position", "velocity", "current"] {
        sheet.rows(column, &["simulation".into()], || Ok(vec![simulation(&servos, SERVO, column)?]))?;
    }
    let told: Tests = servos.iter().map(|(name, traces)| (*name, traces.iter().map(step_before).collect())).collect();
    for column in ["position", "velocity"] {
        sheet.rows(column, &[STEP_BEFORE.into()], || Ok(vec![simulation(&told, SERVO, column)?]))?;
    }
    let bodies = tests(true)?;
    for column in [gap::PLACE, gap::ORIENTATION] {
        sheet.rows(column, &["simulation".into()], || Ok(vec![simulation(&bodies, BODY, column)?]))?;
    }
    Ok(())
}

const STEP_BEFORE: &str = "error of the step before, measured";

/// The plainest use of measurements: the error of the step before is taken for this one's.
fn step_before(trace: &Trace) -> Trace {
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

/// Four architectures in three forms, with the feedback of the thesis.
pub fn table_2_1(sheet: &mut Sheet, class: &str) -> Outcome<()> {
    let (settings, bodies) = (sheet.settings(), class == BODY);
    let (data, tests) = (training(settings, bodies)?, tests(bodies)?);
    let (outputs, column): (&[&str], _) = if bodies { (&PLACE, gap::PLACE) } else { (&["position"], "position") };
    sheet.rows(class, &["simulation".into()], || Ok(vec![simulation(&tests, class, column)?]))?;
    if !bodies {
        let told: Tests =
            tests.iter().map(|(name, traces)| (*name, traces.iter().map(step_before).collect())).collect();
        sheet.rows(class, &[STEP_BEFORE.into()], || Ok(vec![simulation(&told, class, column)?]))?;
    }
    for form in Form::ALL {
        for (name, model) in architectures() {
            let feedbacks = form.feedbacks(class);
            let name_of = |feedback| format!("{}: {name}, {}", form.name(), fed(feedback));
            let names: Vec<String> = feedbacks.iter().copied().map(name_of).collect();
            sheet.rows(class, &names, || {
                let one = |seed| AugmentationPlan { model, ..plan(class, outputs, settings, seed) };
                let networks = trained(form, settings, &data, one)?;
                feedbacks.iter().map(|feedback| tested(&networks, &tests, *feedback, class, column)).collect()
            })?;
        }
    }
    if !bodies {
        let name = "ours without play operators: SAT, nothing fed back".to_string();
        sheet.rows(class, &[name], || {
            let one = |seed| AugmentationPlan { hysteresis: Vec::new(), ..plan(class, outputs, settings, seed) };
            let networks = trained(Form::Ours, settings, &data, one)?;
            Ok(vec![tested(&networks, &tests, lifelike_augmentation::Feedback::None, class, column)?])
        })?;
    }
    Ok(())
}

/// Position and velocity together with the physics-informed loss.
pub fn figure_2_5(sheet: &mut Sheet) -> Outcome<()> {
    let settings = sheet.settings();
    let (data, tests) = (training(settings, false)?, tests(false)?);
    for column in ["position", "velocity"] {
        sheet.rows(column, &["simulation".into()], || Ok(vec![simulation(&tests, SERVO, column)?]))?;
    }
    for form in [Form::Thesis, Form::Ours] {
        let feedbacks = form.feedbacks(SERVO);
        let names: Vec<String> = feedbacks.iter().map(|own| format!("{}: SAT, {}", form.name(), fed(*own))).collect();
        if ["position", "velocity"].iter().all(|column| names.iter().all(|name| sheet.row(column, name).is_some())) {
            continue;
        }
        let networks = trained(form, settings, &data, |seed| plan(SERVO, &["position", "velocity"], settings, seed))?;
        for column in ["position", "velocity"] {
            let cells = || feedbacks.iter().map(|own| tested(&networks, &tests, *own, SERVO, column)).collect();
            sheet.rows(column, &names, cells)?;
        }
    }
    Ok(())
}

pub fn figure_2_6(sheet: &mut Sheet) -> Outcome<()> {
    one_column(sheet, SERVO, &["current"], "current")
}

pub fn figure_2_8(sheet: &mut Sheet) -> Outcome<()> {
    let turn = ["a_x", "a_y", "a_z", "b_x", "b_y", "b_z"].map(|axis| format!("orientation_{axis}"));
    one_column(sheet, BODY, &turn.iter().map(String::as_str).collect::<Vec<_>>(), gap::ORIENTATION)?;
    one_column(sheet, BODY, &PLACE, gap::PLACE)
}

/// A network for some outputs in the thesis' form and in ours; of bodies ours in the world's axes, too.
fn one_column(sheet: &mut Sheet, class: &str, outputs: &[&str], column: &str) -> Outcome<()> {
    let settings = sheet.settings();
    let (data, tests) = (training(settings, class == BODY)?, tests(class == BODY)?);
    sheet.rows(column, &["simulation".into()], || Ok(vec![simulation(&tests, class, column)?]))?;
    let world = (class == BODY).then_some((Form::Ours, Frame::World));
    for (form, frame) in [(Form::Thesis, Frame::Parent), (Form::Ours, Frame::Parent)].into_iter().chain(world) {
        let axes = if frame == Frame::World { " in the world's axes" } else { "" };
        let feedbacks = form.feedbacks(class);
        let names: Vec<String> =
            feedbacks.iter().map(|own| format!("{}: SAT{axes}, {}", form.name(), fed(*own))).collect();
        sheet.rows(column, &names, || {
            let one = |seed| AugmentationPlan { frame, ..plan(class, outputs, settings, seed) };
            let networks = trained(form, settings, &data, one)?;
            feedbacks.iter().map(|feedback| tested(&networks, &tests, *feedback, class, column)).collect()
        })?;
    }
    Ok(())
}

/// The non-modular form beside the modular one: one network for all blocks at once. It cannot be asked about DanceBot, whose blocks are others;
/// of KickBot's bodies it learns those that move wherever the robot is attached.
pub fn not_modular(sheet: &mut Sheet, class: &str) -> Outcome<()> {
    let (settings, bodies) = (sheet.settings(), class == BODY);
    let mut tests = tests(bodies)?;
    tests.truncate(2);
    let common: Vec<String> = tests[1].1[0].blocks.iter().map(|block| block.name.clone()).collect();
    let local =
        |traces: &[Trace]| traces.iter().map(|trace| chosen(trace, class, &common)).collect::<Outcome<Vec<_>>>();
    let [learn, validation] = training(settings, bodies)?;
    let data = [local(&learn)?, local(&validation)?];
    let tests: Tests = tests.iter().map(|(name, own)| Ok((*name, local(own)?))).collect::<Outcome<_>>()?;
    let column = if bodies { gap::PLACE } else { "position" };
    let whole: [Vec<Trace>; 2] = data.each_ref().map(|own| own.iter().map(|trace| merged(trace, class)).collect());
    let outputs: Vec<&str> = match whole[0].first().and_then(|trace| trace.blocks.first()) {
        Some(first) => {
            let names = first.measured.names.iter().map(String::as_str);
            names.filter(|name| name.rsplit('.').next().is_some_and(|own| own.starts_with("position"))).collect()
        }
        None => return Err(format!("expected blocks of class '{class}', got none").into()),
    };
    sheet.rows(class, &["simulation".into()], || Ok(vec![simulation(&tests, class, column)?]))?;
    for form in [Form::Thesis, Form::Ours] {
        let feedbacks = form.feedbacks(class);
        let names = |kind: &str| -> Vec<String> {
            feedbacks.iter().map(|own| format!("{}: {kind}, {}", form.name(), fed(*own))).collect()
        };
        sheet.rows(class, &names("modular"), || {
            let outputs: &[&str] = if bodies { &PLACE } else { &["position"] };
            let one = |seed| AugmentationPlan { frame: Frame::World, ..plan(class, outputs, settings, seed) };
            let networks = trained(form, settings, &data, one)?;
            feedbacks.iter().map(|feedback| tested(&networks, &tests, *feedback, class, column)).collect()
        })?;
        sheet.rows(class, &names("not modular"), || {
            // Twice as wide, and two stretches of all blocks where the modular network has sixteen of one.
            let model = SatSizes { width: 2 * SatSizes::default().width, ..SatSizes::default() };
            let one = |seed| AugmentationPlan {
                model,
                batch: 2,
                part: 1,
                frame: Frame::World,
                ..plan(class, &outputs, settings, seed)
            };
            let networks = trained(form, settings, &whole, one)?;
            feedbacks.iter().map(|feedback| tested_whole(&networks, &tests, *feedback, class, column)).collect()
        })?;
    }
    Ok(())
}

/// Blocks of a class with these names; bodies in their parents' frames, where errors are as long as in the world.
fn chosen(trace: &Trace, class: &str, names: &[String]) -> Outcome<Trace> {
    let mut local = in_parents(trace, class)?;
    local.blocks.retain(|block| block.class == class && names.contains(&block.name));
    Ok(local)
}

/// As [`tested`], of networks for all blocks at once.
fn tested_whole(
    networks: &[lifelike_augmentation::Augmentation],
    tests: &Tests,
    feedback: lifelike_augmentation::Feedback,
    class: &str,
    column: &str,
) -> Outcome<Cells> {
    let mut cells = Cells::new();
    for (test, traces) in tests {
        let whole: Vec<Trace> = traces.iter().map(|trace| merged(trace, class)).collect();
        let mut all = Vec::new();
        for network in networks {
            let mut back = traces.clone();
            let after = corrected(network, &whole, feedback)?;
            after.iter().zip(&mut back).for_each(|(merged, own)| split(merged, own));
            all.push(numbers(&back, class, column)?);
        }
        cells.insert((*test).to_string(), over_seeds(&all));
    }
    Ok(cells)
}
