//! Qualifiers of an action: side, direction, numbers, adverbs.

use crate::facts::{Direction, Mood, Side, Size, Speed};

/// Numbers in words.
const NUMBERS: [&str; 13] =
    ["zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve"];
/// Most repetitions that are taken for a number of something.
pub(super) const MAX_COUNT: f64 = 50.0;

/// Qualifiers in a piece of text.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Said {
    pub side: Option<Side>,
    pub direction: Option<Direction>,
    pub count: Option<u32>,
    pub degrees: Option<u32>,
    /// Angle from hanging down of arms at a height that is named (degrees).
    pub level: Option<u32>,
    pub seconds: Option<f64>,
    pub metres: Option<f64>,
    /// True where a length is called a radius.
    pub is_radius: bool,
    /// Pace over the ground (m/s).
    pub pace: Option<f64>,
    /// True for "a bit": of what travels a short way, of the rest a small size.
    pub few: bool,
    /// True where the seconds are those of a way: "within two seconds", "take two seconds to".
    pub is_way: bool,
    /// True for "hold it" and its kin.
    pub holds: bool,
    /// True for "one arm" and its kin.
    pub one_hand: bool,
    /// True for "the same amount" as before.
    pub same: bool,
    /// True for "for a bit".
    pub briefly: bool,
    /// True for "for a while" and "again and again".
    pub many: bool,
    /// True for "in turn": one repetition of each side after the other, not all of one side first.
    pub alternates: bool,
    pub speed: Option<Speed>,
    pub size: Option<Size>,
    pub mood: Option<Mood>,
    /// Side of a hand or an arm, of a foot or a leg, and of another part of the body.
    pub sides: [Option<Side>; 3],
    /// Side of the first of those that alternate.
    pub first: Option<Side>,
    /// True for a count of each side: "eight times each".
    pub of_each: bool,
    /// True if left and right are named apart, not as "both".
    pub in_turn: bool,
    /// True for hands or arms in the plural without a side.
    pub plural: bool,
    /// True for a hand or an arm in the singular without a side.
    pub singular: bool,
    /// Words that are explained by this.
    pub used: Vec<String>,
}

impl Said {
    /// Returns whether one hand was named.
    pub fn names_one_hand(&self) -> bool {
        matches!(self.sides[0], Some(Side::Left | Side::Right))
    }
}

/// Returns the number that a word is.
pub(super) fn number(word: &str) -> Option<f64> {
    if let Some(at) = NUMBERS.iter().position(|known| *known == word) {
        return Some(at as f64);
    }
    word.parse().ok().filter(|n: &f64| n.is_finite() && *n >= 0.0)
}

/// Reads a piece of text.
pub(super) fn said(words: &[String]) -> Said {
    let mut out = Said::default();
    for (at, word) in words.iter().enumerate() {
        let next = words.get(at + 1).map_or("", String::as_str);
        if adverb(&mut out, word) || numbered(&mut out, words, at) || way(&mut out, &words[..at], word, next) {
            out.used.push(word.clone());
        }
    }
    // "The left knee with the right hand": the hand acts.
    let [hand, foot, part] = out.sides;
    out.side = hand.or(foot).or(out.side).or(part);
    let heights = ["height", "level", "high"];
    let height = words.windows(2).find(|two| heights.contains(&two[1].as_str()));
    out.level = height.and_then(|two| match two[0].as_str() {
        "hip" | "waist" | "hips" => Some(40),
        "belly" | "navel" | "stomach" => Some(52),
        "chest" => Some(75),
        "shoulder" | "shoulders" => Some(90),
        "chin" | "neck" => Some(100),
        "mouth" | "nose" => Some(106),
        "head" | "eye" | "face" | "ear" => Some(115),
        _ => None,
    });
    if let Some(two) = height.filter(|_| out.level.is_some()) {
        out.used.extend(two.iter().cloned());
    }
    if let Some(at) = words.iter().position(|word| word == "halfway") {
        if words.get(at + 1).is_some_and(|next| next.ends_with("round")) {
            out.degrees.get_or_insert(180);
        } else {
            out.level.get_or_insert(80);
            out.size.get_or_insert(Size::Small);
        }
        out.used.push("halfway".into());
    }
    let has = |pair: [&str; 2]| words.windows(2).any(|two| two[0] == pair[0] && two[1] == pair[1]);
    if has(["other", "way"])
        || has(["other", "direction"])
        || has(["u", "turn"])
        || has(["about", "face"])
        || has(["about", "turn"])
    {
        out.degrees.get_or_insert(180);
    }
    if has(["turn", "back"]) || has(["turns", "back"]) || has(["turning", "back"]) {
        out.degrees.get_or_insert(180);
    }
    let of_half = words.windows(2).any(|two| two[0] == "half" && two[1] == "of") && words.iter().any(|w| w == "turn");
    if of_half
        || has(["turn", "round"])
        || has(["turn", "around"])
        || has(["turns", "around"])
        || has(["turns", "round"])
        || has(["turning", "round"])
        || has(["turning", "around"])
    {
        out.degrees.get_or_insert(180);
    }
    let has_word = |all: &[&str]| words.iter().any(|word| all.contains(&word.as_str()));
    extent(&mut out, words);
    out.is_radius = has_word(&["radius"]);
    if out.metres.is_some() {
        out.used.extend(["radius", "diameter", "wide", "across", "size"].map(String::from));
    }
    out.holds = has_word(&["hold", "holds", "holding"]);
    if out.holds {
        out.used.extend(["hold", "holds", "holding"].map(String::from));
    }
    out.is_way =
        words.windows(4).any(|four| {
            let takes = four[3] == "to" && four[2] == "seconds";
            takes || ["within", "over"].contains(&four[0].as_str()) && four[2] == "seconds"
        }) || words.windows(3).any(|three| ["within", "over"].contains(&three[0].as_str()) && three[2] == "seconds");
    out.one_hand = [["one", "arm"], ["one", "hand"], ["an", "arm"], ["a", "hand"]].into_iter().any(has);
    if out.is_way {
        out.used.push("within".into());
    }
    if has(["turns", "round"]) || has(["turning", "round"]) || has(["turn", "round"]) {
        out.used.push("round".into());
    }
    let each = ["hand", "arm", "foot", "leg", "knee", "side"].iter().any(|limb| has(["each", limb]));
    if each {
        out.side = Some(Side::Both);
    }
    if has(["way", "around"]) && has_word(&["all"]) || has(["way", "round"]) && has_word(&["all"]) {
        out.degrees = Some(360);
    }
    let alternates = words.iter().any(|word| word.starts_with("alternat"));
    if alternates {
        // "Alternating, left first".
        out.first = out.sides[0].or(out.sides[1]).or(out.side).filter(|side| *side != Side::Both);
        out.side = Some(Side::Both);
        out.sides = [None; 3];
        out.used.extend(words.iter().filter(|word| word.starts_with("alternat")).cloned());
    }
    (out.alternates, out.of_each) = (alternates, each);
    let named = has_word(&["left"]) && has_word(&["right"]);
    out.in_turn = named && out.side == Some(Side::Both) || alternates || each;
    // "Left right left right": each once, in this order.
    let sides: Vec<&String> = words.iter().filter(|word| *word == "left" || *word == "right").collect();
    if sides.len() > 2 && sides.windows(2).all(|two| two[0] != two[1]) {
        (out.in_turn, out.alternates, out.of_each) = (true, true, false);
        (out.side, out.direction) = (Some(Side::Both), None);
        out.first = Some(if sides[0] == "left" { Side::Left } else { Side::Right });
        out.count = Some(sides.len() as u32);
    }
    let respects = has_word(&["respectfully", "reverently"]) && has_word(&["bow", "bows", "bowing"]);
    if respects {
        out.size.get_or_insert(Size::Big);
    }
    // "Bow real low".
    if has_word(&["low", "lower"]) && has_word(&["bow", "bows", "bowing", "curtsy", "squat", "squats", "crouch"]) {
        out.size.get_or_insert(Size::Big);
        out.used.extend(["low", "lower", "real"].map(String::from));
    }
    // "A high kick", "kick low".
    if has_word(&["kick", "kicks", "kicking"]) && has_word(&["high", "higher", "low", "lower"]) {
        let is_high = has_word(&["high", "higher"]);
        out.size.get_or_insert(if is_high { Size::Big } else { Size::Small });
        out.used.extend(["high", "higher", "low", "lower"].map(String::from));
    }
    let turns_back = words.windows(3).any(|three| three[0].starts_with("turn") && three[2] == "back");
    if turns_back {
        out.degrees.get_or_insert(180);
    }
    // Circles of a limb are no way: "make circles with both arms".
    let of_limb = has_word(&["arm", "arms", "hand", "hands", "hip", "hips", "shoulders"]);
    let walks_round = has_word(&["circle", "circles"]) && !of_limb;
    if has_word(&["twirl", "twirls", "twirling", "spin", "spins", "spinning", "pirouette", "whirl", "whirls"])
        || walks_round
    {
        out.degrees.get_or_insert(360);
    }
    if has(["right", "angle"]) {
        out.degrees.get_or_insert(90);
        (out.side, out.direction) =
            (None, out.direction.filter(|_| words.iter().any(|word| word.contains("clockwise"))));
        out.used.push("angle".into());
    }
    const HEAD_DOWN: [&str; 5] = ["head", "down", "low", "hanging", "bowed"];
    const HEAD_UP: [&str; 4] = ["head", "high", "up", "raised"];
    for (posture, mood) in [(&HEAD_DOWN[..], Mood::Sad), (&HEAD_UP[..], Mood::Proud)] {
        let is_so = |word: &&str| has(["head", word]) || has(["head", "held"]) && has(["held", word]);
        if posture[1..].iter().any(is_so) {
            out.used.push("held".into());
            out.mood.get_or_insert(mood);
            out.used.extend(posture.iter().map(ToString::to_string));
        }
    }
    out.singular = out.side.is_none() && words.iter().any(|word| word == "hand" || word == "arm");
    out.plural = out.side.is_none() && words.iter().any(|word| word == "hands" || word == "arms");
    out
}

/// Words after "a little" that are no thing: not "a little wave".
const AFTER: [&str; 14] = [
    "",
    "to",
    "forward",
    "forwards",
    "backward",
    "backwards",
    "back",
    "left",
    "right",
    "closer",
    "nearer",
    "further",
    "ahead",
    "away",
];

/// Reads how far or how long, where no number says it: "a bit", "for a while", "over and over".
fn extent(out: &mut Said, words: &[String]) {
    let word = |at: usize| words.get(at).map_or("", String::as_str);
    for (at, own) in words.iter().enumerate() {
        let before = |n: usize| at.checked_sub(n).map_or("", &word);
        match own.as_str() {
            // "Jog for a bit" is as long as anybody jogs.
            "bit" | "tad" | "smidge" if before(1) == "a" && before(2) == "for" => out.briefly = true,
            // "A bit of a show" is no size.
            "bit" if word(at + 1) == "of" => {}
            "bit" | "tad" | "smidge" if ["a", "little"].contains(&before(1)) => out.few = true,
            // "A little" at the end, or before what is no thing.
            "little" if before(1) == "a" && AFTER.contains(&word(at + 1)) => out.few = true,
            "awhile" | "repeatedly" | "continuously" | "constantly" | "nonstop" | "endlessly" | "applaud"
            | "applauds" | "applauding" | "applause" => out.many = true,
            "forever" | "ages" => out.many = true,
            "occasionally" => {}
            "amount" | "distance" | "number" if before(1) == "same" => out.same = true,
            _ => continue,
        }
        out.used.push(own.clone());
    }
    if out.few {
        out.size = None;
    }
}

fn adverb(out: &mut Said, word: &str) -> bool {
    // Tempo and size at once.
    match word {
        "gently" | "softly" | "delicately" | "tenderly" | "gentle" => out.speed = out.speed.or(Some(Speed::Slow)),
        "sarcastically" | "sarcastic" | "ironically" | "mockingly" | "theatrically" | "dramatically" => {
            out.speed = out.speed.or(Some(Speed::Slow));
        }
        "unsure" | "uncertain" | "uncertainly" | "hesitant" | "hesitantly" | "hesitating" | "doubtfully"
        | "doubtful" | "indecisive" | "unconvinced" => out.speed = out.speed.or(Some(Speed::Slow)),
        "gusto" | "vigorously" | "heartily" | "forcefully" | "powerfully" | "vigorous" | "hard" | "harder"
        | "eagerly" | "eager" => {
            out.speed = out.speed.or(Some(Speed::Fast));
        }
        _ => {}
    }
    match word {
        "slowly" | "slow" | "slower" | "leisurely" | "unhurriedly" | "calmly" | "gradually" | "sluggishly"
        | "lazily" | "amble" | "ambles" | "ambling" | "saunter" | "saunters" | "sauntering" | "stroll" | "strolls"
        | "strolling" | "dawdle" | "dawdles" | "dawdling" | "mosey" | "gingerly" | "patiently" | "serenely"
        | "carefully" | "careful" | "solemnly" | "solemnity" | "solemn" | "ceremoniously" | "reverently"
        | "respectfully" | "smoothly" | "relaxed" | "casually" | "thoughtfully" | "chill" | "struggling" | "lazy"
        | "unhurried" | "dreamy" | "legato" | "mellow" | "flowing" | "stately" => {
            out.speed = Some(Speed::Slow);
        }
        "quickly" | "fast" | "rapidly" | "briskly" | "hastily" | "swiftly" | "quick" | "hurriedly" | "speedily"
        | "faster" | "brisk" | "rapid" | "hurry" | "frantically" | "wildly" | "energetic" | "scurry" | "scurries"
        | "scurrying" | "scamper" | "scampers" | "scampering" | "hustle" | "hustles" | "hustling" | "rush"
        | "rushes" | "rushing" | "snappy" | "abruptly" | "suddenly" | "sharply" | "urgently" | "hasty" | "sharp"
        | "crisp" | "crisply" | "jerky" | "jerkily" | "jerking" | "brusque" | "brusquely" | "zippy" | "frantic"
        | "hectic" | "feverishly" | "explosively" | "panic" | "panicky" | "surprised" | "startled" => {
            out.speed = Some(Speed::Fast)
        }
        "widely" | "wide" | "wider" | "large" | "larger" | "big" | "bigger" | "huge" | "giant" | "gigantic"
        | "enormous" | "massive" | "vigorous" | "exaggerated" | "broadly" | "deeply" | "deep" | "far"
        | "expansively" | "hugely" | "vigorously" | "generously" | "dramatically" | "gusto" | "sarcastically"
        | "sarcastic" | "ironically" | "mockingly" | "heartily" | "forcefully" | "theatrically" | "powerfully"
        | "hard" | "harder" | "deeper" => out.size = Some(Size::Big),
        "slightly" | "gently" | "gentle" | "tenderly" | "softly" | "lightly" | "delicately" | "smaller" | "shorter"
        | "faintly" | "coldly" | "stiffly" | "discreetly" | "small" | "tiny" | "barely" | "subtly" | "little"
        | "modestly" | "short" | "subtle" => {
            out.size = Some(Size::Small);
        }
        "sadly" | "sad" | "sulky" | "moody" | "gloomy" | "melancholic" | "melancholically" | "wistfully"
        | "regretfully" | "dejectedly" | "dejected" | "gloomily" | "depressed" | "unhappily" | "sorrowfully"
        | "unhappy" | "miserably" | "miserable" | "heartbroken" | "sorrow" | "grief" | "mournfully" | "glum"
        | "glumly" | "downcast" | "disappointed" | "crestfallen" | "hopelessly" | "sadness" | "sulkily" | "despair" => {
            out.mood = Some(Mood::Sad)
        }
        "proudly" | "proud" | "confidently" | "haughtily" | "triumphantly" | "confident" | "arrogantly"
        | "arrogant" | "smugly" | "smug" | "cocky" | "pride" | "majestically" | "regally" | "pompously" | "boldly"
        | "swagger" | "swaggers" | "swaggering" | "triumphant" | "dignified" | "dignity" | "bossy" | "bossily"
        | "sassy" | "sassily" | "haughty" | "snooty" | "defiantly" | "defiant" | "commandingly" | "authoritatively"
        | "nobly" => {
            out.mood = Some(Mood::Proud);
        }
        "angrily" | "angry" | "furiously" | "furious" | "aggressively" | "aggressive" | "fiercely" | "madly"
        | "mad" | "annoyed" | "irritably" | "violently" | "rage" | "anger" | "grumpy" | "grumpily" | "frustrated"
        | "fury" | "enraged" | "irate" | "menacingly" | "menacing" | "threateningly" | "resentfully" | "hostile"
        | "sternly" | "stern" | "fuming" | "crossly" | "livid" | "impatiently" => out.mood = Some(Mood::Angry),
        "happily" | "happy" | "joyfully" | "joyful" | "cheerfully" | "cheerful" | "excitedly" | "excited"
        | "enthusiastically" | "enthusiastic" | "merrily" | "gleefully" | "delighted" | "playfully" | "playful"
        | "energetically" | "lively" | "mischievously" | "mischievous" | "cheekily" | "cheeky" | "joy" | "joyous"
        | "joyously" | "glee" | "delight" | "enthusiasm" | "ecstatic" | "ecstatically" | "thrilled" | "elated"
        | "overjoyed" | "bouncy" | "bubbly" | "jolly" | "upbeat" | "eagerly" | "eager" | "perky" | "peppy"
        | "jaunty" | "jauntily" | "chirpy" | "giddy" | "giddily" | "frisky" | "exuberantly" | "exuberant"
        | "zestfully" | "cheery" | "excitement" | "happiness" | "lightheartedly" => out.mood = Some(Mood::Happy),
        "tiredly" | "tired" | "wearily" | "weary" | "exhausted" | "exhaustedly" | "sleepily" | "sleepy"
        | "drowsily" | "fatigued" | "listlessly" | "halfheartedly" | "halfhearted" | "reluctantly" | "bored"
        | "unenthusiastically" | "limply" | "lethargically" | "lethargic" | "languidly" | "languid" | "groggily"
        | "groggy" | "sluggish" | "droopy" | "drained" | "exhaustion" | "apathetically" | "grudgingly" => {
            out.mood = Some(Mood::Tired)
        }
        "elegantly" | "elegant" | "elegance" | "gracefully" | "graceful" | "grace" | "fluidly" | "daintily" => {
            out.mood = Some(Mood::Graceful);
        }
        "frail" | "frailly" | "feebly" | "feeble" | "infirm" | "doddering" | "decrepit" | "stooped" | "stooping"
        | "hunched" | "hunching" | "arthritic" | "elderly" => out.mood = Some(Mood::Frail),
        "unsure" | "uncertain" | "uncertainly" | "hesitant" | "hesitating" | "doubtfully" | "doubtful"
        | "indecisive" | "unconvinced" | "guiltily" | "guilty" | "embarrassedly" | "submissively" | "meekly"
        | "fearfully" | "afraid" | "scared" | "nervously" | "nervous" | "timidly" | "timid" | "anxiously"
        | "anxious" | "frightened" | "shyly" | "shy" | "hesitantly" | "terrified" | "suspicious" | "suspiciously"
        | "warily" | "cautiously" | "cautious" | "sheepishly" | "embarrassed" | "awkwardly" | "worried" | "fear"
        | "insecurely" | "jittery" | "twitchy" | "edgy" | "jumpy" | "coyly" | "apprehensively" | "furtively"
        | "bashfully" | "uneasily" | "tentatively" => out.mood = Some(Mood::Afraid),
        _ => return false,
    }
    true
}

/// Reads the number at a place, with the unit after it.
fn numbered(out: &mut Said, words: &[String], at: usize) -> bool {
    let word = words[at].as_str();
    let next = words.get(at + 1).map_or("", String::as_str);
    match (word, next) {
        // "With all ten fingers".
        (_, "fingers" | "finger" | "toes") => {}
        ("once", _) => out.count = Some(1),
        ("twice", _) => out.count = Some(2),
        ("thrice", _) => out.count = Some(3),
        ("couple", _) => out.count = Some(2),
        ("few", "steps" | "times") => out.count = Some(3),
        ("several", "steps" | "times") => out.count = Some(4),
        // "One and a half turns".
        (_, "turn" | "turns" | "rotation" | "rotations" | "spin" | "spins" | "pirouettes") if is_part(word) => {
            out.degrees = number(word).map(|turns| (360.0 * turns).round() as u32);
        }
        ("quarter", _) => out.degrees = Some(90),
        ("half", "turn" | "circle" | "way") => out.degrees = Some(180),
        ("half", "a") if words.get(at + 2).is_some_and(|w| w == "turn" || w == "circle") => out.degrees = Some(180),
        ("dozen", _) => out.count = Some(if words[..at].contains(&"half".to_string()) { 6 } else { 12 }),
        ("full", "turn" | "circle" | "rotation") | ("complete", "turn" | "circle") | ("all", "around") => {
            out.degrees = Some(360);
        }
        _ => {
            let Some(value) = number(word) else { return false };
            let whole = value.round();
            // An adjective may stand between number and unit: "two big steps".
            let is_way = unit_of_length(next).is_some() || unit_of_pace(next).is_some();
            let unit = words[at + 1..]
                .iter()
                .filter(|_| !is_way)
                .take(3)
                .map(String::as_str)
                .find(|w| ["degrees", "seconds"].contains(w));
            match unit {
                Some("degrees") => out.degrees = Some(whole as u32),
                Some("seconds") if is_decade(words, at) => return false,
                Some("seconds") => out.seconds = Some(value),
                _ if unit_of_length(next).is_some() => {
                    out.metres = unit_of_length(next).map(|unit| (1e3 * value * unit).round() / 1e3);
                    out.used.push(next.to_string());
                }
                _ if unit_of_pace(next).is_some() => {
                    out.pace = unit_of_pace(next).map(|unit| (1e3 * value * unit).round() / 1e3);
                    out.used.push(next.to_string());
                }
                // "Turn your head 45 to the left".
                _ if is_angle(words, at) => out.degrees = Some(whole as u32),
                // "Do a 360": more than anybody counts is an angle.
                _ if (60.0..=1080.0).contains(&whole) => out.degrees = Some(whole as u32),
                // Half a time, or two of a unit that is not known, is no count.
                _ if (whole - value).abs() > 1e-6 || UNITS.contains(&next) => return false,
                _ if (1.0..=MAX_COUNT).contains(&whole) && !is_article(words, at) => out.count = Some(whole as u32),
                _ => return false,
            }
        }
    }
    true
}

/// Returns whether a number that ends its words, or stands before a side, is an angle.
fn is_angle(words: &[String], at: usize) -> bool {
    const TURNS: [&str; 8] = ["turn", "rotate", "tilt", "lean", "twist", "look", "bend", "pivot"];
    let is_round = number(&words[at]).is_some_and(|n| (15.0..60.0).contains(&n) && n % 5.0 == 0.0);
    let turns = words[..at].iter().any(|word| TURNS.contains(&word.as_str()));
    let next = words.get(at + 1).map_or("", String::as_str);
    is_round && turns && ["", "to", "left", "right", "clockwise", "counterclockwise"].contains(&next)
}

/// Returns whether a word is a number that is not whole.
fn is_part(word: &str) -> bool {
    number(word).is_some_and(|value| (value - value.round()).abs() > 1e-6)
}

/// Returns whether a number with seconds is a decade: "like in the 80s", "an 80s dance".
fn is_decade(words: &[String], at: usize) -> bool {
    let is_round = words[at].parse::<u32>().is_ok_and(|n| n.is_multiple_of(10) && (20..=90).contains(&n));
    let has = |word: Option<&String>, all: &[&str]| word.is_some_and(|word| all.contains(&word.as_str()));
    let styles =
        ["style", "dance", "disco", "music", "move", "moves", "song", "aerobics", "pop", "rock", "party", "vibe"];
    is_round && (at > 0 && has(words.get(at - 1), &["the", "an", "like"]) || has(words.get(at + 2), &styles))
}

/// Units that nothing here has.
const UNITS: [&str; 8] = ["hz", "radians", "rad", "percent", "hours", "hour", "kg", "newtons"];

/// Returns a unit of pace (m/s).
fn unit_of_pace(word: &str) -> Option<f64> {
    match word {
        "mpers" | "mps" => Some(1.0),
        "kmperh" | "kmh" | "kph" => Some(1.0 / 3.6),
        "mph" => Some(0.44704),
        _ => None,
    }
}

/// Returns a unit of length (m).
fn unit_of_length(word: &str) -> Option<f64> {
    match word {
        "m" | "metre" | "metres" | "meter" | "meters" => Some(1.0),
        "cm" | "centimetre" | "centimetres" | "centimeter" | "centimeters" => Some(0.01),
        "km" | "kilometre" | "kilometres" | "kilometer" | "kilometers" => Some(1e3),
        "mile" | "miles" => Some(1609.344),
        "inch" | "inches" => Some(0.0254),
        "ft" => Some(0.3048),
        "yard" | "yards" => Some(0.9144),
        _ => None,
    }
}

/// Returns whether a number stands for something else: "one leg", "one another", "a high five".
fn is_article(words: &[String], at: usize) -> bool {
    let next = words.get(at + 1).map_or("", String::as_str);
    let is_other = at > 0 && words[at - 1] == "other";
    if words[at] == "eight" && words[..at].iter().rev().take(2).any(|word| word == "figure") {
        return true;
    }
    // "Give me five jumping jacks" counts.
    let ends = next.is_empty() || ["|", ",", "and", "then", "please", "buddy", "robot"].contains(&next);
    if words[at] == "five"
        && ends
        && at > 0
        && (words[at - 1].starts_with("high") || ["me", "us", "gimme"].contains(&words[at - 1].as_str()))
    {
        return true;
    }
    // "Warrior 2" is a name.
    if at > 0 && words[at - 1] == "warrior" {
        return true;
    }
    let of_one = ["leg", "foot", "hand", "arm", "knee", "another", "side", "way", "of"].contains(&next);
    let is_pair =
        words[at] == "two" && ["knee", "knees", "hand", "hands", "arm", "arms", "legs", "leg"].contains(&next);
    words[at] == "one" && (is_other || of_one) || is_pair
}

/// Returns whether words before a limb make it the aim of another one: "on the", "holding your".
fn is_aim(before: &[String]) -> bool {
    const AIMS: [&str; 15] = [
        "on", "onto", "to", "against", "behind", "over", "touch", "touches", "touching", "hold", "holding", "holds",
        "grabs", "grab", "across",
    ];
    let mut words = before.iter().rev().skip_while(|word| ["the", "your", "his", "her"].contains(&word.as_str()));
    words.next().is_some_and(|word| AIMS.contains(&word.as_str()))
}

/// Reads sides and directions.
fn way(out: &mut Said, before: &[String], word: &str, next: &str) -> bool {
    const LIMBS: [&[&str]; 3] = [
        &["hand", "hands", "arm", "arms", "fist", "elbow"],
        &["foot", "feet", "leg", "legs", "knee", "heel"],
        &["shoulder", "ear", "hip", "eye", "cheek", "wrist", "thigh"],
    ];
    let limb = LIMBS.iter().position(|limb| limb.contains(&next));
    if let ("left" | "right", Some(limb)) = (word, limb) {
        // "The right foot on the left knee": the first one acts.
        if out.sides[limb].is_some() && is_aim(before) {
            return true;
        }
        let own = if word == "left" { Side::Left } else { Side::Right };
        out.sides[limb] = Some(if out.sides[limb] == Some(own.mirrored()) { Side::Both } else { own });
        return true;
    }
    match word {
        "left" | "lefthand" | "leftward" | "leftwards" => {
            // "Left and right" is both ways.
            out.side = Some(if out.side == Some(Side::Right) { Side::Both } else { Side::Left });
            out.direction = Some(Direction::Left);
        }
        "right" | "rightward" | "rightwards" if next != "now" => {
            out.side = Some(if out.side == Some(Side::Left) { Side::Both } else { Side::Right });
            out.direction = Some(Direction::Right);
        }
        "both" => out.side = Some(Side::Both),
        "clockwise" => out.direction = Some(Direction::Right),
        "counterclockwise" | "anticlockwise" => out.direction = Some(Direction::Left),
        _ => return false,
    }
    true
}
