//! Described postures: limbs that go somewhere and stay there, without the name of any action.
//!
//! "Raise the left hand, then the right one, hold it, put both down" is three postures in a row. A piece of a sentence is
//! a posture if each of its words is known here and it says a limb and a place. An unknown word makes it none.

mod arms;
mod legs;
mod trunk;
mod words;

use arms::{arms, flare};
use legs::legs;
use trunk::{head, trunk};
use words::{ARMS, ELBOWS, FILLERS, FOREARMS, LEGS, MOVES, OTHERS, PLACES, RETURNS, STATES, TRUNK};

use super::Clause;
use super::beside::without_negations;
use super::phrases::Phrases;
use super::said::{Said, said};
use super::spelling::spelt;
use super::split::{Join, is_participle, normal, pieces};
use crate::facts::{Direction, Mood, Side, Speed};
use crate::posture::{Arm, Foot, Posture, Turn};
use crate::touch::Touch;

/// Duration of a hold on the way (s), of the last one, and of one that is said without a time.
const ON_THE_WAY: f64 = 0.6;
pub(super) const AT_THE_END: f64 = 1.9;
const HELD: f64 = 3.0;
/// Share of a head's roll that the trunk shows: most necks of robots do not roll.
const LEANS: f64 = 0.8;
/// Lean forward of hanging shoulders, and back of a chest that is stuck out (degrees).
const SLUMP: f64 = 10.0;
const CHEST_OUT: f64 = 6.0;
/// Lean of a trunk whose hips go to the other side (degrees).
const HIPS: f64 = 10.0;

/// Fewest movements in a row that are postures beside other actions.
const IN_A_ROW: usize = 2;
/// Fewest that are so beside words that mean nothing.
const SURELY: usize = 3;

/// A piece of a sentence as a posture.
struct Read {
    posture: Posture,
    /// True where a verb says that it is a movement of its own.
    moves: bool,
    /// True where no phrase of a verb says as much: a bent elbow, one that is held.
    is_detailed: bool,
}

/// Limbs and the posture before, which words such as "them" and "the other" refer to.
#[derive(Default)]
struct Context {
    arms: Option<Side>,
    legs: Option<Side>,
    before: Posture,
    last_verb: String,
    /// True where the last limbs were legs.
    of_legs: bool,
    /// True where "look left" may be of the same row.
    looks: bool,
}

/// Words of a piece with what they say.
struct Words<'a> {
    words: &'a [String],
    bases: Vec<String>,
    said: Said,
}

impl Words<'_> {
    fn has(&self, all: &[&str]) -> bool {
        self.words.iter().chain(&self.bases).any(|word| all.contains(&word.as_str()))
    }

    /// Returns whether two or three words stand in a row.
    fn has_row(&self, row: &[&str]) -> bool {
        self.words.windows(row.len()).any(|words| words.iter().zip(row).all(|(a, b)| a == b))
    }

    /// Returns the number before "degrees", where it is not that of an elbow.
    fn degrees(&self) -> Option<f64> {
        self.said.degrees.map(f64::from)
    }

    fn names_limb(&self) -> bool {
        [&ARMS[..], &ELBOWS, &FOREARMS, &LEGS].into_iter().any(|limbs| self.has(limbs))
    }

    /// Returns whether something goes there and back again and again.
    fn repeats(&self) -> bool {
        let from = self.words.iter().position(|word| word == "from");
        let swings = from.is_some_and(|at| self.words[at..].iter().any(|word| word == "to"));
        self.said.many || self.has_row(&["side", "to", "side"]) || swings
    }

    fn is_known(&self, word: &str, base: &str) -> bool {
        let lists: [&[&str]; 9] = [&ARMS, &ELBOWS, &FOREARMS, &LEGS, &TRUNK, &MOVES, &PLACES, &FILLERS, &OTHERS];
        let known = lists.iter().any(|list| list.contains(&word) || list.contains(&base));
        let is_number = word.parse::<f64>().is_ok() || word == "seconds" || word == "for";
        known || is_number || RETURNS.contains(&base) || self.said.used.iter().any(|used| used == word)
    }
}

/// A part of a sentence: postures, or words for phrases and rules.
pub(super) enum Segment {
    Postures(Clause),
    Words(String),
}

/// Postures in a row.
#[derive(Default)]
struct Row {
    postures: Vec<Posture>,
    context: Context,
    moves: usize,
    is_detailed: bool,
    /// True where a later piece puts limbs down again: each goes up by itself.
    returns: bool,
}

impl Row {
    /// Adds a piece. Returns false for one that is no posture.
    fn add(&mut self, join: Join, piece: &Words<'_>) -> bool {
        self.context.looks = join != Join::Then;
        let Some(read) = read(piece, &mut self.context, !self.postures.is_empty()) else { return false };
        self.is_detailed |= read.is_detailed;
        let is_height =
            piece.degrees().is_some() || piece.said.level.is_some() || piece.has(&["horizontal", "parallel"]);
        let is_more =
            piece.has(&ELBOWS) || piece.has(&FOREARMS) || piece.has(&["upper"]) || is_height && !piece.names_limb();
        let is_along = match join {
            Join::While | Join::With => true,
            Join::Comma => !read.moves && !self.returns && !self.steps_on(&read.posture),
            // "Raise the left arm and lift the right knee": limbs that both go somewhere do so at once.
            Join::And => !read.moves || self.goes_along(&read.posture) && !piece.has(&["then", "both", "them", "it"]),
            Join::Then => false,
        };
        let is_pair = self.postures.last().is_some_and(|last| last.touches.is_some() && read.posture.touches.is_some());
        let flares = is_along && self.postures.last_mut().is_some_and(|last| flare(last, &read.posture));
        match self.postures.last_mut() {
            Some(last) if flares => last.hold = last.hold.max(read.posture.hold),
            // "Palms together, elbows out": as they are by then.
            Some(last) if last.touches == Some(Touch::Hands) && piece.has(&ELBOWS) && is_along => {
                last.hold = last.hold.max(read.posture.hold);
            }
            Some(last) if read.posture.is_empty() => last.hold = last.hold.max(read.posture.hold),
            // "Hand behind the head, elbow out": as it is by then.
            Some(last) if is_along && piece.has(&ELBOWS) && rests(last, &read.posture) => {}
            // "Hands on the thighs, leaning forward": as the trunk does by then.
            Some(last) if is_along && last.trunk.is_some() && read.posture.is_lean() && last.touches.is_some() => {}
            // "Until the thigh is level": the same again.
            Some(last) if Posture { hold: last.hold, ..read.posture.clone() } == *last => {
                last.hold = last.hold.max(read.posture.hold);
            }
            // "The arms out, the elbows bent": the second says more about the first.
            Some(last) if is_along && (is_more || refines(last, &read.posture) || !last.overlaps(&read.posture)) => {
                // Hands at two places are what no verb does.
                self.is_detailed |= is_pair;
                last.extend(&read.posture);
            }
            _ => {
                self.moves += 1;
                self.postures.push(read.posture);
            }
        }
        let sum = &mut self.context.before;
        *sum = Posture::default();
        self.postures.iter().for_each(|posture| sum.extend(posture));
        true
    }

    /// Returns whether one foot steps after the other: both do not at once.
    fn steps_on(&self, posture: &Posture) -> bool {
        let steps = |foot: Option<Foot>| foot.is_some_and(|foot| foot.height == 0.0 && foot.to[0] != 0.0);
        let stepped = self.postures.last().is_some_and(|last| steps(last.left_foot) || steps(last.right_foot));
        let ahead = |posture: &Posture| posture.left_foot.or(posture.right_foot).is_some_and(|foot| foot.to[0] > 0.0);
        let is_other_way = self.postures.last().is_some_and(|last| ahead(last) != ahead(posture));
        stepped && (steps(posture.left_foot) || steps(posture.right_foot)) && !is_other_way
    }

    /// Returns whether a posture is there at once with the last one: of limbs, or of the trunk above a lifted leg.
    fn goes_along(&self, posture: &Posture) -> bool {
        let bends = |posture: &Posture| posture.trunk.is_some() || posture.head.is_some();
        let last = self.postures.last();
        let is_along = last.is_some_and(|last| !bends(last) && (!bends(posture) || last.is_on_one_foot()));
        is_along && !is_down(posture)
    }

    /// Returns the postures as a clause.
    fn clause(mut self) -> Clause {
        let last = self.postures.len().saturating_sub(1);
        for (number, posture) in self.postures.iter_mut().enumerate() {
            let is_held = number == last && !is_down(posture);
            posture.hold = posture.hold.max(if is_held { AT_THE_END } else { ON_THE_WAY });
        }
        Clause::of_postures(self.postures)
    }
}

/// Divides a sentence into described postures and the rest; nothing where it has none that phrases do not say as well.
/// `is_open`: phrases and rules left something of it over. `understood` says whether they
/// understand a text.
pub(super) fn segments(
    phrases: &Phrases,
    text: &str,
    is_open: bool,
    understood: impl Fn(&str) -> bool,
) -> Option<Vec<Segment>> {
    let words = spelt(phrases, normal(text), &mut Vec::new());
    let words = without_negations(words, &mut Vec::new());
    let pieces = with_limbs(pieces(&words));
    let mut out: Vec<Segment> = Vec::new();
    let mut at = 0;
    let mut surely = false;
    while at < pieces.len() {
        let returns = pieces.iter().skip(at + 1).any(|(_, piece)| puts_back(piece));
        let mut row = Row { returns, ..Row::default() };
        let mut end = at;
        while let Some((join, words)) = pieces.get(end) {
            let bases = words.iter().map(|word| base(phrases, word)).collect();
            // "OK so:", "like Julie Andrews on the hill": what asks for nothing.
            let opens = end == 0 && only_stands(words, pieces.get(1));
            let says_nothing = words.iter().all(|word| phrases.filler.contains(word)) || likens(words) || opens;
            let is_posture = row.add(*join, &Words { words, bases, said: said(words) });
            if !is_posture && !(says_nothing && (!row.postures.is_empty() || end + 1 < pieces.len())) {
                break;
            }
            end += 1;
        }
        surely |= row.moves >= SURELY || row.moves >= IN_A_ROW && row.postures.iter().any(is_down);
        let is_whole = at == 0 && end == pieces.len() && !row.postures.is_empty();
        let follows =
            |place: usize| pieces.get(place).is_none_or(|(join, _)| !matches!(join, Join::While | Join::With));
        let stands = match is_whole {
            true => row.moves > 1 || row.is_detailed || is_open || row.postures.iter().any(Posture::is_combined),
            false => row.moves >= IN_A_ROW && follows(at) && follows(end),
        };
        if stands {
            out.push(Segment::Postures(row.clause()));
            at = end;
            continue;
        }
        let (join, words) = &pieces[at];
        match out.last_mut() {
            Some(Segment::Words(text)) => *text += &format!(" {} {}", join.word(), words.join(" ")),
            _ => out.push(Segment::Words(words.join(" "))),
        }
        at += 1;
    }
    // Beside words that only a guess reads, a description is one of some action.
    let is_sure = |segment: &Segment| match segment {
        Segment::Words(text) => surely || understood(text),
        Segment::Postures(_) => true,
    };
    (out.iter().any(|one| matches!(one, Segment::Postures(_))) && out.iter().all(is_sure)).then_some(out)
}

/// A description of limbs as it was read.
pub(super) struct Described {
    /// Its postures.
    pub clause: Clause,
    /// Pieces that are no posture.
    pub open: Vec<String>,
    /// Words that no rule knows.
    pub left_out: Vec<String>,
}

/// Reads words that describe limbs, by the network, with those that no rule knows left out; nothing where no posture is read.
pub(super) fn described(phrases: &Phrases, words: &[String]) -> Option<Described> {
    let pieces = with_limbs(pieces(words));
    let returns = pieces.iter().skip(1).any(|(_, piece)| puts_back(piece));
    let mut row = Row { returns, ..Row::default() };
    let (mut open, mut left_out) = (Vec::new(), Vec::new());
    for (join, piece) in pieces {
        let bases: Vec<String> = piece.iter().map(|word| base(phrases, word)).collect();
        let whole = Words { words: &piece, bases, said: said(&piece) };
        let is_known = |(word, base): &(&String, &String)| whole.is_known(word, base);
        let (known, unknown): (Vec<_>, Vec<_>) = piece.iter().zip(&whole.bases).partition(is_known);
        let [known, unknown] = [known, unknown].map(|words| words.into_iter().map(|(word, _)| word.clone()).collect());
        let (known, unknown): (Vec<String>, Vec<String>) = (known, unknown);
        let bases = known.iter().map(|word| base(phrases, word)).collect();
        let is_read = !known.is_empty() && row.add(join, &Words { words: &known, bases, said: said(&known) });
        if is_read {
            left_out.extend(unknown.into_iter().filter(|word| !phrases.filler.contains(word)));
        } else {
            let rest: Vec<&str> =
                piece.iter().map(String::as_str).filter(|word| !phrases.filler.contains(*word)).collect();
            open.extend((!rest.is_empty()).then(|| rest.join(" ")));
        }
    }
    (!row.postures.is_empty()).then(|| Described { clause: row.clause(), open, left_out })
}

/// Returns the base form of a word, verbs of limbs included that no phrase has: "tipping" is "tip".
fn base(phrases: &Phrases, word: &str) -> String {
    let base = phrases.base(word);
    let stem = word.strip_suffix("ing").or(word.strip_suffix("ed")).filter(|_| base == word);
    let forms = stem.into_iter().flat_map(|stem| {
        let mut undoubled = stem.to_string();
        undoubled.pop();
        [stem.to_string(), format!("{stem}e"), undoubled]
    });
    forms.into_iter().find(|form| MOVES.contains(&form.as_str())).unwrap_or(base)
}

/// Returns whether a piece puts limbs back that others moved: "both down". Commas before it are one after the other.
fn puts_back(piece: &[String]) -> bool {
    let has = |all: &[&str]| piece.iter().any(|word| all.contains(&word.as_str()));
    has(&["down", "lower", "drop"]) && has(&["both", "them", "all", "everything"])
}

/// Returns whether words before a description only say that somebody stands: "stand with", "from standing,".
fn only_stands(words: &[String], next: Option<&(Join, Vec<String>)>) -> bool {
    const STANDS: [&str; 8] = ["stand", "standing", "from", "straight", "tall", "upright", "still", "up"];
    let describes = next.is_some_and(|(join, _)| matches!(join, Join::With | Join::Comma | Join::Then));
    describes
        && words.iter().all(|word| STANDS.contains(&word.as_str()))
        && words.iter().any(|w| w.starts_with("stand"))
}

/// Returns whether a posture says more about arms that the last one describes: a bent elbow whose hand points up, raised
/// arms whose hands meet.
fn refines(last: &Posture, next: &Posture) -> bool {
    let bends = |next: Option<Arm>, last: Option<Arm>| match (next, last) {
        (None, _) => true,
        (Some(next), Some(last)) => next.elbow > 60.0 && last.elbow > 60.0,
        (Some(_), None) => false,
    };
    // "Stand on the left leg, the right foot behind": where it is held.
    let lifts = |foot: Option<Foot>| foot.is_some_and(|foot| foot.height > 0.0);
    let only_feet = Posture { left_foot: None, right_foot: None, sink: None, ..next.clone() }.is_empty();
    let is_left = lifts(next.left_foot) && lifts(last.left_foot);
    if only_feet && (is_left || lifts(next.right_foot) && lifts(last.right_foot)) {
        return true;
    }
    let meets = next.touches == Some(Touch::Hands) && last.left_arm.is_some() && last.left_arm == last.right_arm;
    let is_bent = bends(next.left_arm, last.left_arm) && bends(next.right_arm, last.right_arm);
    next.moves_only_arms() && last.touches.is_none() && (meets || is_bent)
}

/// Returns whether a posture moves arms alone that already rest somewhere.
fn rests(last: &Posture, next: &Posture) -> bool {
    let within = |next: Option<Arm>, last: Option<Arm>| next.is_none() || last.is_some();
    last.touches.is_some()
        && next.moves_only_arms()
        && next.touches.is_none()
        && within(next.left_arm, last.left_arm)
        && within(next.right_arm, last.right_arm)
}

/// Puts the limb of "reach up with the left arm" beside its verb, and that of "point with your arm at the floor".
fn with_limbs(pieces: Vec<(Join, Vec<String>)>) -> Vec<(Join, Vec<String>)> {
    const ARTICLES: [&str; 10] = ["the", "your", "ur", "my", "his", "her", "both", "one", "left", "right"];
    let is_limb = |words: &[String]| {
        let one_of = |word: &String, all: &[&str]| all.contains(&word.as_str());
        let Some((last, before)) = words.split_last() else { return false };
        (one_of(last, &ARMS) || one_of(last, &LEGS)) && before.iter().all(|word| one_of(word, &ARTICLES))
    };
    let mut out: Vec<(Join, Vec<String>)> = Vec::with_capacity(pieces.len());
    for (join, words) in pieces {
        let is_verb =
            |last: &[String]| matches!(last, [verb] if ["point", "reach", "stretch"].contains(&verb.as_str()));
        let names = words.iter().any(|word| ARMS.contains(&word.as_str()));
        let belongs = |last: &[String]| is_limb(&words) && !last.is_empty() || is_verb(last) && names;
        match out.last_mut().filter(|(_, last)| join == Join::With && belongs(last)) {
            Some((_, last)) => last.extend([join.word().to_string()].into_iter().chain(words)),
            None => out.push((join, words)),
        }
    }
    out
}

/// Finds arms that are somewhere during another action: "squat with your arms straight out in front", "a hand on the hip and
/// one up as you walk". Returns the words of the action, the posture, and whether no verb's phrase says as much.
pub(super) fn overlaid(phrases: &Phrases, text: &str) -> Option<(String, Posture, bool)> {
    let words = spelt(phrases, normal(text), &mut Vec::new());
    let pieces = with_limbs(pieces(&without_negations(words, &mut Vec::new())));
    let mut rest: Vec<String> = Vec::new();
    let mut found: Option<Posture> = None;
    let mut is_detailed = false;
    for (number, (join, words)) in pieces.iter().enumerate() {
        let bases: Vec<String> = words.iter().map(|word| base(phrases, word)).collect();
        if number > 0 && likens(words) {
            continue;
        }
        let piece = Words { words, bases, said: said(words) };
        let keeps = piece.has(&["hold", "keep"]) || piece.words.iter().any(|word| is_participle(word));
        let leads = rest.is_empty();
        let is_along = match join {
            Join::With | Join::While => true,
            // In a row of actions a posture is one more.
            Join::Comma => pieces.len() == 2 || leads,
            Join::And => keeps || leads,
            Join::Then => number == 0,
        };
        let posture = read(&piece, &mut Context::default(), false).filter(|read| leads || !read.moves || keeps);
        let posture = posture.filter(|read| is_along && read.posture.moves_only_arms());
        is_detailed |= posture.as_ref().is_some_and(|read| read.is_detailed && read.posture.touches.is_none());
        match (posture.map(|read| read.posture), &mut found) {
            (Some(posture), Some(found)) if found.overlaps(&posture) => return None,
            (Some(posture), Some(found)) => {
                is_detailed = true;
                found.extend(&posture);
            }
            (Some(posture), None) => found = Some(posture),
            // What the arms do first goes on only "while" something else is done.
            (None, Some(_)) if leads && *join != Join::While => return None,
            (None, _) if leads => rest.extend(words.iter().cloned()),
            (None, _) => rest.extend([join.word().to_string()].iter().chain(words).cloned()),
        }
    }
    Some((rest.join(" "), found?, is_detailed)).filter(|(rest, ..)| !rest.is_empty())
}

/// Reads a piece; nothing for one that is no posture.
fn read(whole: &Words<'_>, context: &mut Context, follows: bool) -> Option<Read> {
    // "Hands up like somebody is robbing you": the first words say it.
    let end = whole.words.iter().skip(2).position(|word| word == "like").map_or(whole.words.len(), |at| at + 2);
    let piece =
        &Words { words: &whole.words[..end], bases: whole.bases[..end].to_vec(), said: said(&whole.words[..end]) };
    if !piece.words.iter().zip(&piece.bases).all(|(word, base)| piece.is_known(word, base)) {
        return None;
    }
    let said = &piece.said;
    if piece.repeats() || said.count.is_some_and(|count| count > 1) || said.metres.is_some() || said.pace.is_some() {
        return None;
    }
    // "Step your left foot back" is a description, "step back with your left foot" an action.
    if piece.has(&["step"]) && !steps_foot(piece) {
        return None;
    }
    let hold = said.seconds.or(piece.has(&["hold", "keep", "stay", "balance"]).then_some(HELD));
    let verb = piece.bases.iter().find(|base| MOVES.contains(&base.as_str())).cloned();
    let mut posture = Posture { slow: said.speed == Some(Speed::Slow), ..Posture::default() };
    let mut detail = false;
    let names_limb = piece.names_limb();
    // "A few inches off the floor": as it is already.
    if follows && !names_limb && piece.has(&["off"]) {
        return Some(Read { posture, moves: false, is_detailed: false });
    }
    // "Wait two seconds": it stays as it is.
    if follows && !names_limb && ["wait", "pause", "freeze"].contains(&piece.bases[0].as_str()) {
        let hold = said.seconds.unwrap_or(HELD);
        return Some(Read { posture: Posture { hold, ..posture }, moves: false, is_detailed: true });
    }
    // A way that takes its time is one of a verb.
    if said.is_way && said.seconds.is_some() {
        return None;
    }
    // "Palms down": how hands are turned.
    if follows && piece.has(&["palm", "palms"]) && !piece.has(&["raise", "lift", "together", "on", "to", "chest"]) {
        return Some(Read { posture, moves: false, is_detailed: false });
    }
    // "Come back up": the trunk and the knees, not what was lifted.
    let rises = ["come", "comes", "get", "go", "back", "up", "straighten", "again", "then", "upright", "and"];
    let comes = piece.has(&["up", "upright"]) || piece.has(&["come", "go", "get"]) && piece.has(&["back"]);
    if follows && comes && piece.words.iter().all(|word| rises.contains(&word.as_str())) {
        // Hands that reach down come along.
        if context.before.sink.is_some() && context.before.touches.is_some() {
            posture = standing(&context.before);
        }
        posture.trunk = context.before.trunk.map(|_| Turn::default());
        posture.sink = context.before.sink.map(|_| 0.0);
        return (!posture.is_empty()).then_some(Read { posture, moves: true, is_detailed: false });
    }
    let refers = follows && (piece.has(&["it", "them", "both", "other"]) || !names_limb);
    // "Bend down", "turn around" are actions.
    let is_action = piece.has(&["bend", "turn", "twist", "rotate", "stand", "reach", "stretch"]) && !names_limb;
    if is_action && !piece.has(&TRUNK) && !piece.has(&["head", "chin"]) && !piece.has_row(&["stand", "straight"]) {
        return None;
    }
    // "Keep it up": where it is.
    let only_up =
        piece.has(&["up"]) && piece.bases.iter().filter(|word| PLACES[..24].contains(&word.as_str())).count() == 1;
    let only_holds = hold.is_some() && !names_limb && (!places(piece) || only_up);
    if only_holds {
        if !follows {
            return None;
        }
        let hold = hold.unwrap_or(HELD);
        return Some(Read { posture: Posture { hold, ..posture }, moves: false, is_detailed: true });
    }
    let is_of_head = piece.has(&["head", "chin"])
        && (!on_the_head(piece) || turns_over_shoulder(piece))
        && !piece.has(&["height", "level"]);
    if on_the_head(piece) && !names_limb && !refers && !turns_over_shoulder(piece) {
        return None;
    }
    let mentions_arms = piece.has(&ARMS) || piece.has(&ELBOWS) || piece.has(&FOREARMS);
    // "Lean back until your hands touch the floor".
    if piece.has(&["lean"]) && mentions_arms && !piece.has(&TRUNK) {
        return None;
    }
    let mentions_legs = piece.has(&LEGS);
    let returns = follows && !names_limb && (piece.has(&["relax", "return"]) || piece.has_row(&["stand", "straight"]));
    let lowers = follows
        && !names_limb
        && piece.has(&["lower", "down", "drop"])
        && piece.has(&["both", "them", "everything", "all"]);
    let has_both = context.arms.is_some() && context.legs.is_some();
    // "Lean left, then right by twenty degrees".
    let leans_on = follows
        && !names_limb
        && verb.is_none()
        && ["lean", "tilt"].contains(&context.last_verb.as_str())
        && said.side.is_some();
    if let Some(turn) = hips_aside(piece).filter(|_| !names_limb) {
        posture.trunk = Some(turn);
        detail = true;
    } else if returns || lowers && has_both {
        posture = standing(&context.before);
    } else if slumps(piece) && !piece.names_limb() {
        posture.trunk = Some(Turn { pitch: SLUMP, ..Turn::default() });
        detail = true;
    } else if follows && said.mood == Some(Mood::Proud) && !names_limb && verb.as_deref().is_none_or(|v| v == "stick") {
        // "Chest out", which is read as a manner before. A trunk that leans over bent knees stays.
        let is_free = context.before.trunk.is_none();
        posture.trunk = is_free.then_some(Turn { pitch: -CHEST_OUT, ..Turn::default() });
        detail = true;
    } else if follows && context.looks && piece.has(&["look"]) && !names_limb && !piece.has(&["head"]) {
        posture.head = Some(head(piece)?);
    } else if is_of_head && !mentions_arms {
        posture.head = Some(head(piece)?);
        // The trunk rolls with the head, and comes back where it did.
        let roll = LEANS * posture.head.map_or(0.0, |head| head.roll);
        let is_rolled = context.before.trunk.is_some_and(|trunk| trunk.roll != 0.0);
        posture.trunk = (roll != 0.0 || is_rolled).then(|| Turn { roll, ..Turn::default() });
        detail |= hold.is_some() || piece.degrees().is_some();
    } else if (piece.has(&["lean", "tilt", "tip"]) || leans_on) && !mentions_arms
        || piece.has(&["bend", "twist", "turn", "rotate", "go", "goes", "come"]) && piece.has(&TRUNK) && !names_limb
    {
        posture.trunk = Some(trunk(piece)?);
        let is_aside = posture.trunk.is_some_and(|turn| turn.roll != 0.0 || turn.yaw != 0.0);
        detail |= hold.is_some() || is_aside && piece.degrees().is_some();
    } else if mentions_legs && !mentions_arms {
        context.of_legs = true;
        detail |= legs(piece, context, &mut posture)? || hold.is_some();
    } else if mentions_arms || refers && context.arms.is_some() && !mentions_legs && !spreads(piece, context) {
        context.of_legs = false;
        detail |= arms(piece, context, &mut posture)?;
    } else if refers && (context.legs.is_some() || spreads(piece, context)) {
        detail |= legs(piece, context, &mut posture)?;
    } else {
        return None;
    }
    // "Holding the right elbow" is a grip.
    let is_grip = posture.touches == Some(Touch::Forearm) && said.seconds.is_none();
    posture.hold = hold.filter(|_| !is_grip).unwrap_or(0.0);
    let goes = |(word, base): (&String, &String)| {
        let is_verb = MOVES.contains(&base.as_str()) && !STATES.contains(&base.as_str());
        is_verb && !is_participle(word) && !word.ends_with("ed") && word != "bent"
    };
    let moves = !begins_with_limb(piece) && piece.words.iter().zip(&piece.bases).any(goes)
        || is_down(&posture) && puts_down(&posture, &context.before);
    context.last_verb = verb.unwrap_or_else(|| std::mem::take(&mut context.last_verb));
    Some(Read { posture, moves, is_detailed: detail })
}

/// Returns whether "wide" is said of legs: "knees bent and wide".
fn spreads(piece: &Words<'_>, context: &Context) -> bool {
    context.of_legs && !piece.names_limb() && piece.has(&["apart", "wide", "wider"])
}

/// Returns whether a limb is what a piece is about: "the hands come together", not "bring the hands together".
fn begins_with_limb(piece: &Words<'_>) -> bool {
    const BEFORE: [&str; 7] = ["the", "your", "both", "left", "right", "ur", "one"];
    let first = piece.words.iter().find(|word| !BEFORE.contains(&word.as_str()));
    let is_limb = |word: &&String| {
        let word = word.as_str();
        ARMS.contains(&word)
            || ELBOWS.contains(&word)
            || FOREARMS.contains(&word)
            || LEGS.contains(&word)
            || word == "head"
    };
    first.is_some_and(|word| is_limb(&word)) && piece.bases.iter().any(|base| MOVES.contains(&base.as_str()))
}

/// Returns whether a foot is the object of a step.
fn steps_foot(piece: &Words<'_>) -> bool {
    let Some(at) = piece.bases.iter().position(|base| base == "step") else { return false };
    let objects =
        piece.words[at + 1..].iter().skip_while(|word| ["your", "the", "left", "right"].contains(&word.as_str()));
    objects.take(1).any(|word| word == "foot" || word == "leg")
}

/// Returns the lean of a trunk whose hips go to a side: to the other one.
fn hips_aside(piece: &Words<'_>) -> Option<Turn> {
    let goes = piece.has(&["hip", "hips", "pelvis"])
        && piece.has(&["push", "pushed", "shift", "shifted", "out", "jut", "stick"]);
    let side = piece.said.direction.filter(|_| goes && !piece.has(&["on", "at", "height"]))?;
    let roll = if side == Direction::Right { -HIPS } else { HIPS };
    matches!(side, Direction::Left | Direction::Right).then(|| Turn { roll, ..Turn::default() })
}

/// Returns whether a piece lets the shoulders drop.
fn slumps(piece: &Words<'_>) -> bool {
    const DROPS: [&str; 9] = ["drop", "hang", "sink", "fall", "relax", "round", "hunch", "rolled", "slumped"];
    piece.has(&["shoulders"]) && piece.has(&DROPS) && !piece.has(&["height", "level"])
}

/// Returns whether a head turns over a shoulder.
fn turns_over_shoulder(piece: &Words<'_>) -> bool {
    piece.has(&["turn", "rotate", "look"]) && piece.has(&["over"]) && piece.has(&["shoulder"])
}

/// Returns whether words only say what something is like.
fn likens(words: &[String]) -> bool {
    words.first().is_some_and(|word| word == "like") || words.len() > 1 && words[0] == "as" && words[1] == "if"
}

/// Returns whether a piece names a place or a way.
fn places(piece: &Words<'_>) -> bool {
    piece.has(&PLACES[..24]) || piece.degrees().is_some()
}

/// Returns whether a posture only puts limbs down.
fn is_down(posture: &Posture) -> bool {
    let arms: Vec<&Arm> = posture.left_arm.iter().chain(&posture.right_arm).collect();
    let feet: Vec<&Foot> = posture.left_foot.iter().chain(&posture.right_foot).collect();
    let has_limbs = !arms.is_empty() || !feet.is_empty();
    has_limbs && arms.iter().all(|arm| **arm == Arm::HANGING) && feet.iter().all(|foot| **foot == Foot::STANDING)
}

/// Returns whether a posture puts something down that was up, or both arms at a time.
fn puts_down(posture: &Posture, before: &Posture) -> bool {
    let were = |now: Option<Arm>, before: Option<Arm>| now.is_some() && before.is_some_and(|arm| arm != Arm::HANGING);
    let stood = |now: Option<Foot>, before: Option<Foot>| now.is_some() && before.is_some_and(|f| f != Foot::STANDING);
    let is_first = before.is_empty();
    is_first
        || were(posture.left_arm, before.left_arm)
        || were(posture.right_arm, before.right_arm)
        || stood(posture.left_foot, before.left_foot)
        || stood(posture.right_foot, before.right_foot)
}

/// Returns the posture of standing, of the parts that another one moved.
fn standing(before: &Posture) -> Posture {
    Posture {
        left_arm: before.left_arm.map(|_| Arm::HANGING),
        right_arm: before.right_arm.map(|_| Arm::HANGING),
        head: before.head.map(|_| Turn::default()),
        trunk: before.trunk.map(|_| Turn::default()),
        left_foot: before.left_foot.map(|_| Foot::STANDING),
        right_foot: before.right_foot.map(|_| Foot::STANDING),
        sink: before.sink.map(|_| 0.0),
        ..Posture::default()
    }
}

/// Returns whether the head is only a place for hands.
fn on_the_head(piece: &Words<'_>) -> bool {
    piece.has(&["overhead", "above", "over", "behind", "top", "on"]) && piece.has(&["head"])
}

/// Returns the side of limbs that a piece names: as said, of the plural both, else the one before.
fn side_of(piece: &Words<'_>, plural: bool, before: Option<Side>) -> Option<Side> {
    if piece.has(&["other"]) {
        return before.map(Side::mirrored);
    }
    if piece.has(&["both"]) || plural {
        return Some(Side::Both);
    }
    piece.said.side
}
