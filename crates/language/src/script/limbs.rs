//! Limbs and ways that words leave open: which leg, which hand, which way back, which action above which.

use super::Clause;
use super::said::Said;
use crate::facts::{Action, Direction, Side};
use crate::grammar::{Acts, Show, Synth, Verb};
use crate::touch::Touch;

/// Returns the turn that undoes the last one, where "back" is said of a turn after one: "turn 45 degrees left, then turn
/// back".
pub(super) fn back_again(verb: &Verb, words: &[String], said: Said, last: Option<&Clause>) -> Said {
    let is_turn = verb.synth == Some(Synth::Turn) && words.iter().any(|word| word == "back" || word == "front");
    let says_no_way = said.direction.is_none() && !words.iter().any(|word| word.parse::<f64>().is_ok());
    let mut clauses = last.iter().flat_map(|clause| &clause.actions).filter(|action| action.verb == verb.name);
    match clauses.next() {
        Some(turn) if is_turn && says_no_way => {
            Said { direction: turn.direction.map(Direction::mirrored), degrees: turn.degrees, ..said }
        }
        _ => said,
    }
}

/// Exchanges the side of a verb of the foot where the supporting leg is named, and of a hand that touches the other arm.
pub(super) fn of_supporting_leg(verb: &Verb, words: &[String], said: Said) -> Said {
    let is_leg = |word: &String| ["leg", "foot"].contains(&word.as_str());
    let stands_on = words.iter().position(|word| word == "on").is_some_and(|at| words[at..].iter().take(4).any(is_leg));
    let lifts = verb.acts == Acts::Foot && !verb.shows.contains(&Show::Low);
    // "Scratch the left arm": the right hand does.
    let is_touched = |pair: &[String]| {
        let part = ["arm", "forearm", "elbow", "shoulder"].contains(&pair[1].as_str());
        part && ["left", "right"].contains(&pair[0].as_str())
    };
    let names_hand = words.iter().any(|word| ["hand", "finger", "fist"].contains(&word.as_str()));
    let crosses = matches!(verb.touches, Some(Touch::Shoulder | Touch::Forearm))
        && !names_hand
        && words.windows(2).any(is_touched);
    // "The left elbow to the right knee": the knee's side is that of a verb of the foot.
    let of_foot = said.sides[1].filter(|_| verb.acts == Acts::Foot && said.sides[0].is_some());
    let said = Said { side: of_foot.or(said.side), ..said };
    // "Stretch to the left": the right arm goes over the head.
    let to_side = verb.name == "side_bend" && said.sides[0].is_none() && words.iter().any(|word| word == "to");
    match said.side {
        Some(side) if lifts && stands_on || crosses || to_side => Said { side: Some(side.mirrored()), ..said },
        _ => said,
    }
}

/// Returns whether the upper action can be laid over the lower one: by the head, or by arms that the lower one leaves free.
pub(super) fn is_above((upper, above): (&Verb, &Action), (lower, below): (&Verb, &Action)) -> bool {
    let stands = |verb: &Verb| !verb.shows.iter().any(|show| matches!(show, Show::Low | Show::Bent));
    match (upper.acts, lower.acts) {
        // "Swat with both hands in turn": each hand its own.
        (Acts::Hand, Acts::Hand) if upper.name == lower.name => {
            matches!((above.side, below.side), (Some(one), Some(other)) if one != other)
        }
        _ if upper.name == lower.name => false,
        (Acts::Head, Acts::Head) => false,
        (Acts::Head, _) => true,
        (Acts::Hand | Acts::Hands, Acts::Feet | Acts::Foot | Acts::Body) => stands(upper),
        (Acts::Hand, Acts::Hand) => stands(upper) && above.side != below.side,
        // "One arm circles forward, the other one backward".
        (Acts::Hands, Acts::Hands) => {
            matches!((above.side, below.side), (Some(one), Some(other)) if one.mirrored() == other && one != Side::Both)
        }
        // "One arm circles, the other hand on the hip".
        (Acts::Hand, Acts::Hands) if matches!(below.side, Some(Side::Left | Side::Right)) => {
            stands(upper) && above.side != below.side
        }
        // One hand leaves a pose of both: "one hand on the hip, the other waves".
        (Acts::Hand, Acts::Hands) => stands(upper) && lower.cycle.is_none(),
        _ => false,
    }
}
