//! Words that point back: "again but harder", "slow down", "then the other side".

use super::said::said;

/// Words that divide a sentence.
const JOINS: [&str; 7] = [",", "|", "and", "then", "while", "but", "after"];
/// Words of a piece that asks for the last action once more.
const AGAIN: [&str; 14] =
    ["again", "this", "time", "times", "but", "even", "much", "a", "bit", "with", "the", "your", "on", "more"];
/// Limbs and sides that such a piece may name.
const LIMBS: [&str; 10] = ["hand", "arm", "leg", "foot", "fist", "knee", "elbow", "side", "one", "limb"];

/// Returns words in which every piece says its own action.
pub(super) fn done_again(words: Vec<String>) -> Vec<String> {
    let mut out: Vec<String> = Vec::with_capacity(words.len());
    let mut last: Vec<String> = Vec::new();
    let mut pieces = pieces(&words).into_iter().peekable();
    while let Some((joins, mut piece)) = pieces.next() {
        // "Again, but harder" is one piece.
        while says_again(&piece) && pieces.peek().is_some_and(says_how) {
            piece.extend(pieces.next().map(|(_, next)| next).unwrap_or_default());
        }
        let begins_now = piece.len() > 1 && piece[0] == "now";
        if begins_now {
            piece.remove(0);
        }
        if comes_back(&piece) {
            name_side(&mut out, &mut last);
        }
        if let Some(again) = again(&last, &piece) {
            piece = again;
        }
        out.extend(joins);
        out.extend(piece.iter().cloned());
        if !piece.is_empty() {
            last = piece;
        }
    }
    out
}

/// Returns whether a piece after a comma or "but" only says how.
fn says_how((joins, piece): &(Vec<String>, Vec<String>)) -> bool {
    joins.iter().all(|join| join == "but" || join == ",") && is_manner(piece)
}

/// Divides words into pieces, each with the words that join it.
fn pieces(words: &[String]) -> Vec<(Vec<String>, Vec<String>)> {
    let mut out: Vec<(Vec<String>, Vec<String>)> = vec![Default::default()];
    for word in words {
        let is_join = JOINS.contains(&word.as_str());
        if let Some((joins, piece)) = out.last_mut() {
            match (is_join, piece.is_empty()) {
                (true, true) => joins.push(word.clone()),
                (false, _) => piece.push(word.clone()),
                (true, false) => out.push((vec![word.clone()], Vec::new())),
            }
        }
    }
    out
}

/// Returns whether a piece asks for the way back.
fn comes_back(piece: &[String]) -> bool {
    let words: Vec<&str> = piece.iter().map(String::as_str).collect();
    matches!(words[..], ["come" | "comes" | "go" | "goes" | "step" | "steps", "back"] | ["return" | "returns"])
}

/// Names the side of "two steps to the side" at the end of words, so that the way back has another.
fn name_side(words: &mut Vec<String>, last: &mut Vec<String>) {
    let names = last.iter().any(|word| word == "left" || word == "right");
    let is_side = |word: &String| word == "side" || word == "sideways";
    if let Some(at) = last.iter().position(is_side).filter(|_| !names) {
        let from_end = last.len() - at;
        words.insert(words.len() - from_end, "right".into());
        last.insert(at, "right".into());
    }
}

/// Returns whether a piece asks for the last action once more.
fn says_again(piece: &[String]) -> bool {
    let has_again = piece.iter().any(|word| word == "again") || piece.windows(2).any(|two| two == ["once", "more"]);
    has_again && is_manner(piece)
}

/// Returns whether a piece names no action: only how, or by which limb.
fn is_manner(piece: &[String]) -> bool {
    let said = said(piece);
    piece.iter().all(|word| {
        let known =
            [&AGAIN[..], &LIMBS, &["once", "other", "left", "right"]].into_iter().flatten().any(|known| known == word);
        known || is_adverb(word) || said.used.contains(word) && said.count.is_none()
    })
}

/// Returns whether a word says how fast, how far or in which mood.
fn is_adverb(word: &String) -> bool {
    let said = said(std::slice::from_ref(word));
    said.speed.is_some() || said.size.is_some() || said.mood.is_some()
}

/// Returns the piece in full that points back to the last one; nothing for one that does not.
fn again(last: &[String], piece: &[String]) -> Option<Vec<String>> {
    if last.is_empty() {
        return None;
    }
    let words: Vec<&str> = piece.iter().map(String::as_str).collect();
    let pace = match words[..] {
        ["slow", "down"] | ["slower"] | ["slowing", "down"] | ["slows", "down"] => Some("slowly"),
        ["speed", "up"] | ["faster"] | ["accelerate"] | ["speeding", "up"] | ["speeds", "up"] => Some("quickly"),
        _ => None,
    };
    // "Step right twice, then come back": the same way to the other side.
    let steps = ["step", "steps", "sidestep", "shuffle", "slide", "walk", "walks", "move"];
    if comes_back(piece) && last.iter().any(|word| steps.contains(&word.as_str())) {
        let back: Vec<String> = last.iter().map(|word| mirrored(word)).collect();
        return (back != last).then_some(back);
    }
    if pace.is_none() && !says_again(piece) {
        return None;
    }
    let more: Vec<String> = match pace {
        Some(pace) => vec![pace.into()],
        None => piece.iter().filter(|word| is_adverb(word)).cloned().collect(),
    };
    let is_other = piece.iter().any(|word| word == "other");
    let side = piece.iter().find(|word| *word == "left" || *word == "right");
    let on_side = |word: &String| match side {
        _ if is_other => mirrored(word),
        Some(side) if word == "left" || word == "right" => side.clone(),
        _ => word.clone(),
    };
    let names_side = last.iter().any(|word| word == "left" || word == "right");
    // What was said of manner is said anew; "once" stays.
    let kept = last.iter().filter(|word| more.is_empty() || !is_adverb(word));
    let mut out: Vec<String> = kept.map(on_side).collect();
    out.extend(more);
    if !names_side && (is_other || side.is_some()) {
        let which = side.map_or("left", String::as_str);
        let with = match piece.iter().find(|word| LIMBS.contains(&word.as_str()) && *word != "side" && *word != "one") {
            Some(limb) => format!("with the {which} {limb}"),
            None => which.to_string(),
        };
        out.extend(with.split(' ').map(str::to_string));
    }
    Some(out)
}

/// Returns "left" for "right", and the other way round.
fn mirrored(word: &str) -> String {
    match word {
        "left" => "right".into(),
        "right" => "left".into(),
        _ => word.into(),
    }
}

/// "Turn around, walk off": who has turned walks ahead.
pub(super) fn off_after_turn(mut words: Vec<String>) -> Vec<String> {
    const GOES: [&str; 8] = ["walk", "walks", "go", "goes", "run", "runs", "march", "jog"];
    let is_off = |at: usize| {
        let goes = GOES.contains(&words[at - 1].as_str()) && ["off", "away"].contains(&words[at].as_str());
        let ends = words.get(at + 1).is_none_or(|word| JOINS.contains(&word.as_str()));
        let before = words[..at - 1].iter().rev().skip_while(|word| JOINS.contains(&word.as_str()));
        let turns: Vec<&str> = before.take(2).map(String::as_str).collect();
        goes && ends && matches!(turns[..], ["around" | "round", "turn" | "turns"])
    };
    if let Some(at) = (1..words.len()).find(|at| is_off(*at)) {
        words[at] = "forward".into();
    }
    words
}

/// Divides "four steps forward two steps back".
pub(super) fn steps_apart(words: Vec<String>) -> Vec<String> {
    const WAYS: [&str; 8] = ["forward", "forwards", "back", "backward", "backwards", "left", "right", "ahead"];
    let mut out: Vec<String> = Vec::with_capacity(words.len());
    for (at, word) in words.iter().enumerate() {
        let follows_way = out.last().is_some_and(|last| WAYS.contains(&last.as_str()));
        let is_step = words.get(at + 1).is_some_and(|next| next == "steps" || next == "step");
        if follows_way && is_step && super::said::number(word).is_some() {
            out.push(",".into());
        }
        out.push(word.clone());
    }
    out
}

/// Divides "left arm up right arm out".
pub(super) fn limbs_apart(words: Vec<String>) -> Vec<String> {
    const ENDS: [&str; 10] = ["up", "down", "out", "forward", "forwards", "back", "side", "high", "straight", "ahead"];
    let mut out: Vec<String> = Vec::with_capacity(words.len());
    for (at, word) in words.iter().enumerate() {
        let begin = out.iter().rposition(|word| JOINS.contains(&word.as_str())).map_or(0, |join| join + 1);
        let is_side = word == "left" || word == "right";
        let is_limb = |word: &String| LIMBS[..7].contains(&word.as_str());
        let ends = out.last().is_some_and(|last| ENDS.contains(&last.as_str()));
        if is_side && ends && words.get(at + 1).is_some_and(is_limb) && out[begin..].iter().any(is_limb) {
            out.push(",".into());
        }
        out.push(word.clone());
    }
    out
}

/// "First nod, after you bow", "nod, after bow, after wave": one after the other.
pub(super) fn first_and_after(mut words: Vec<String>) -> Vec<String> {
    let follows = |words: &[String], at: usize| words[at] == "after" && JOINS.contains(&words[at - 1].as_str());
    let is_row = (1..words.len()).filter(|at| follows(&words, *at)).count() > 1;
    if is_row || words.first().is_some_and(|word| word == "first" || word == "firstly") {
        for at in 1..words.len() {
            if follows(&words, at) {
                words[at] = "then".into();
            }
        }
    }
    words
}

/// "Right knee up, left elbow touches it" is one movement of both.
pub(super) fn elbow_to_knee(words: Vec<String>) -> Vec<String> {
    let side_of = |limb: &str| {
        let at = words.iter().position(|word| word == limb)?;
        words[..at].last().filter(|word| ["left", "right"].contains(&word.as_str())).cloned()
    };
    let touches = ["touch", "touches", "touching", "meet", "meets", "meeting", "tap", "taps"];
    let (knee, elbow) = (side_of("knee"), side_of("elbow"));
    let is_one = words.len() <= 16 && words.iter().any(|word| touches.contains(&word.as_str()));
    match (knee, elbow) {
        (Some(knee), Some(elbow))
            if is_one && knee != elbow && words.iter().any(|word| word == "it" || word == "up") =>
        {
            format!("touch the {elbow} elbow to the {knee} knee").split(' ').map(str::to_string).collect()
        }
        _ => words,
    }
}

#[cfg(test)]
mod tests {
    use super::super::split::normal;

    #[test]
    fn what_points_back_is_said_in_full() {
        for (text, plain) in [
            ("punch left, again but harder", "punch left , punch left harder"),
            (
                "punch with the right hand, then again with the other hand",
                "punch with the right hand , then punch with the left hand",
            ),
            ("bow, once more, slowly", "bow , bow slowly"),
            ("kick, again on the left", "kick , kick left"),
            ("run, slow down, then stop", "run , run slowly , then stop"),
            ("walk, speed up, run", "walk , walk quickly , run"),
            ("turn left, now turn back", "turn left , turn back"),
            ("4 steps forward 2 steps back", "4 steps forward , 2 steps back"),
            ("right knee up, left elbow touches it", "touch the left elbow to the right knee"),
            ("wave, turn around, walk off", "wave , turn around , walk forward"),
            ("two steps to the side, then come back", "two steps to the right side , then two steps to the left side"),
            ("left arm up right arm out, both together", "left arm up , right arm out , both together"),
            ("first nod, after bow", "first nod , then bow"),
            ("step right twice, then come back", "step right twice , then step left twice"),
            ("nod again and again", "nod repeatedly"),
            ("stand up again", "stand up again"),
            ("wave, then wave again", "wave , then wave again"),
        ] {
            assert_eq!(normal(text).join(" "), plain, "{text}");
        }
    }
}
