//! Figs. 2.9 to 2.12, with the thesis' feedback and beside it our form.

use std::sync::Arc;

use lifelike_augmentation::training::{AugmentationPlan, AugmentationTrainer, LossKind};
use lifelike_augmentation::{Augmentation, Feedback, gap};
use lifelike_checkpoint::rng::stream;
use lifelike_robot::Robot;
use rand::Rng;
use rand_distr::StandardNormal;

use crate::common::*;
use crate::sheet::{Cells, Sheet};

/// Networks of the thesis' form and of ours, and what they are asked with.
fn both(sheet: &Sheet, class: &str, outputs: &[&str]) -> Outcome<Vec<(Form, Vec<Augmentation>)>> {
    let settings = sheet.settings();
    let data = training(settings, class == BODY)?;
    let one = |form| Ok((form, trained(form, settings, &data, |seed| plan(class, outputs, settings, seed))?));
    [Form::Thesis, Form::Ours].into_iter().map(one).collect()
}

/// KickBot (foot) with its motions played faster.
pub fn figure_2_9(sheet: &mut Sheet) -> Outcome<()> {
    let networks = both(sheet, SERVO, &["position", "velocity"])?;
    for speed in [1.0, 2.0, 3.0, 5.0, 10.0, 20.0] {
        let tests = vec![("kickbot_foot", authored_runs("kickbot_foot", &robot("kickbot_foot")?, speed, false)?)];
        for column in ["position", "velocity"] {
            let part = format!("{column} x{speed}");
            sheet.rows(&part, &["simulation".into()], || Ok(vec![simulation(&tests, SERVO, column)?]))?;
            asked(sheet, &part, &networks, &tests, SERVO, column)?;
        }
    }
    Ok(())
}

/// A row for each form and feedback.
fn asked(
    sheet: &mut Sheet,
    part: &str,
    networks: &[(Form, Vec<Augmentation>)],
    tests: &Tests,
    class: &str,
    column: &str,
) -> Outcome<()> {
    for (form, networks) in networks {
        for feedback in form.feedbacks(class) {
            let name = format!("{}: SAT, {}", form.name(), fed(feedback));
            sheet.rows(part, &[name], || Ok(vec![tested(networks, tests, feedback, class, column)?]))?;
        }
    }
    Ok(())
}

/// Errors of a nominal model, as shares of the largest.
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

/// Networks of the right nominal model, asked about simulations of wrong ones. Each seed is a network and a draw of the wrong model.
pub fn figure_2_10(sheet: &mut Sheet) -> Outcome<()> {
    let kickbot = robot("kickbot")?;
    let kinds = [(BODY, &PLACE[..], gap::PLACE), (SERVO, &["position"][..], "position")];
    for (class, outputs, column) in kinds {
        let networks = both(sheet, class, outputs)?;
        for wrong in WRONGS {
            for share in [0.0, 0.25, 0.5, 0.75, 1.0] {
                let part = format!("{class}, {wrong}, {share}");
                if networks.iter().all(|(form, _)| {
                    form.feedbacks(class).iter().all(|own| sheet.row(&part, &asked_name(*form, *own)).is_some())
                }) {
                    continue;
                }
                wrong_model(sheet, &part, &networks, &kickbot, (wrong, share), (class, column))?;
            }
        }
    }
    Ok(())
}

fn asked_name(form: Form, feedback: Feedback) -> String {
    format!("{}: SAT, {}", form.name(), fed(feedback))
}

/// Rows of one wrong model.
fn wrong_model(
    sheet: &mut Sheet,
    part: &str,
    networks: &[(Form, Vec<Augmentation>)],
    kickbot: &Arc<Robot>,
    (wrong, share): (&str, f64),
    (class, column): (&str, &str),
) -> Outcome<()> {
    let seeds = sheet.settings().seeds;
    let traces = (0..seeds).map(|seed| {
        let nominal = Arc::new(perturbed(kickbot, wrong, share, seed));
        authored_runs("kickbot", &nominal, 1.0, class == BODY)
    });
    let traces = traces.collect::<Outcome<Vec<_>>>()?;
    let cells = |all: &[Numbers]| Cells::from([("kickbot".to_string(), over_seeds(all))]);
    sheet.rows(part, &["simulation".into()], || {
        let all = traces.iter().map(|own| numbers(own, class, column)).collect::<Outcome<Vec<_>>>()?;
        Ok(vec![cells(&all)])
    })?;
    for (form, networks) in networks {
        for feedback in form.feedbacks(class) {
            sheet.rows(part, &[asked_name(*form, feedback)], || {
                let own = networks.iter().zip(&traces);
                let all = own.map(|(network, own)| numbers(&corrected(network, own, feedback)?, class, column));
                Ok(vec![cells(&all.collect::<Outcome<Vec<_>>>()?)])
            })?;
        }
    }
    Ok(())
}

/// Places in the history, in per cent of the attention: the present step, the step before, the ten before, and those 20 or more back.
const PARTS: [&str; 4] = ["present", "1 back", "1 to 10 back", "20 and more back"];

/// Attention with the errors that are fed back, of networks in the thesis' form.
pub fn figure_2_11(sheet: &mut Sheet) -> Outcome<()> {
    let settings = sheet.settings();
    let data = training(settings, false)?;
    let test = authored_runs("kickbot_foot", &robot("kickbot_foot")?, 1.0, false)?;
    for form in Form::ALL {
        for (name, model) in architectures().into_iter().filter(|(_, model)| model.attention) {
            let feedbacks = form.feedbacks(SERVO);
            let names: Vec<String> = feedbacks.iter().map(|own| format!("{name}, {}", fed(*own))).collect();
            sheet.rows(form.name(), &names, || {
                let one = |seed| AugmentationPlan { model, ..plan(SERVO, &["position"], settings, seed) };
                let networks = trained(form, settings, &data, one)?;
                feedbacks.iter().map(|feedback| attention(&networks, &test, *feedback)).collect()
            })?;
        }
    }
    Ok(())
}

/// Shares of the attention, mean and deviation over seeds, and every eighth step of the profile.
fn attention(networks: &[Augmentation], test: &[lifelike_sim::trace::Trace], feedback: Feedback) -> Outcome<Cells> {
    let mut shares: std::collections::BTreeMap<String, Vec<Numbers>> = std::collections::BTreeMap::new();
    for network in networks {
        let (mut mean, mut count) = (Vec::new(), 0.0);
        for block in test.iter().flat_map(|trace| &trace.blocks).filter(|block| block.class == SERVO) {
            let Some(profile) = network.attention(block, feedback)? else { continue };
            mean.resize(profile.len(), 0.0);
            mean.iter_mut().zip(profile).for_each(|(sum, x)| *sum += 100.0 * x);
            count += 1.0;
        }
        let back = &mean[..mean.len() - 1];
        let sums = [mean[mean.len() - 1], back[0], back[..10].iter().sum(), back[19..].iter().sum()];
        let single = back.iter().enumerate().step_by(8).map(|(i, x)| (format!("step {:03}", i + 1), *x));
        for (part, sum) in PARTS.iter().map(|part| (*part).to_string()).zip(sums).chain(single) {
            let n = Numbers { mae: [sum / count, 0.0], max: [0.0; 2], ccc: 0.0 };
            shares.entry(part).or_default().push(n);
        }
    }
    Ok(shares.into_iter().map(|(part, all)| (part, over_seeds(&all))).collect())
}

/// MAE on unseen motions while learning, with three losses, in the thesis' form.
pub fn figure_2_12(sheet: &mut Sheet) -> Outcome<()> {
    let settings = sheet.settings();
    let [learn, _] = training(settings, false)?;
    let tests = tests(false)?;
    let every = (settings.iterations / 10).max(1);
    for (name, loss) in
        [("quantile", LossKind::Quantile), ("L1", LossKind::L1), ("physics-informed L1", LossKind::Physics)]
    {
        for seed in 0..settings.seeds {
            let names: Vec<String> = (1..=settings.iterations / every).map(|i| format!("{:>6}", i * every)).collect();
            sheet.rows(&format!("{name}, seed {seed}"), &names, || {
                let plan = AugmentationPlan { loss, ..plan(SERVO, &["position", "velocity"], settings, seed) };
                let mut trainer = AugmentationTrainer::new(&Form::Thesis.of(plan), &learn, &[])?;
                let mut rows = Vec::new();
                while trainer.iteration() < every * (settings.iterations / every) {
                    trainer.iterate();
                    if trainer.iteration().is_multiple_of(every) {
                        rows.push(look(&trainer.augmentation(), &tests)?);
                    }
                }
                Ok(rows)
            })?;
        }
    }
    Ok(())
}

/// KickBot's position and velocity with both feedbacks.
fn look(network: &Augmentation, tests: &Tests) -> Outcome<Cells> {
    let mut cells = Cells::new();
    let Some((_, traces)) = tests.first() else { return Ok(cells) };
    for feedback in Form::Thesis.feedbacks(SERVO) {
        let after = corrected(network, traces, feedback)?;
        for column in ["position", "velocity"] {
            cells.insert(format!("{column}, {}", fed(feedback)), numbers(&after, SERVO, column)?);
        }
    }
    Ok(cells)
}
