//! Numbers and units as people write them, in one form: "1,5", "1/2", "2-3", "two and a half", "ten feet".

use super::said::number;

/// Returns text with numbers that can be read: fractions, decimal commas and ranges (their middle) as decimals. A sign
/// stays at its number, which is none then: nobody walks minus five metres.
pub(super) fn with_plain_numbers(text: &str) -> String {
    let chars: Vec<char> = text.chars().collect();
    let digits = |from: usize| chars[from.min(chars.len())..].iter().take_while(|c| c.is_ascii_digit()).count();
    let is_digit = |at: Option<usize>| at.and_then(|at| chars.get(at)).is_some_and(char::is_ascii_digit);
    let mut out = String::new();
    let mut at = 0;
    while at < chars.len() {
        let (c, before) = (chars[at], at.checked_sub(1));
        let next = Some(at + 1);
        let share = [('\u{bd}', "5"), ('\u{bc}', "25"), ('\u{be}', "75")].into_iter().find(|(sign, _)| *sign == c);
        if let Some((_, share)) = share {
            out += if is_digit(before) { "." } else { " 0." };
            out += share;
        } else if c == ',' && is_digit(before) && is_digit(next) {
            // "1,000" is a thousand, "1,5" one and a half.
            out += if digits(at + 1) == 3 { "" } else { "." };
        } else if let Some(middle) = middle(&chars, at, &out).filter(|_| is_digit(before)) {
            let kept = out.trim_end_matches(|c: char| c.is_ascii_digit() || c == '.').len();
            out.truncate(kept);
            out += &middle;
            at += digits(at + 1);
        } else if c == '-' && !before.is_some_and(|at| chars[at].is_alphanumeric()) && is_digit(next) {
            out += "minus";
        } else if c == '/' && before.is_some_and(|at| chars[at].is_alphabetic()) {
            out += "per";
        } else if c == 'e' && is_digit(before) && is_digit(next) {
            let kept = out.trim_end_matches(|c: char| c.is_ascii_digit() || c == '.').len();
            let power = 1 + digits(at + 1);
            let whole: String = out[kept..].chars().chain(chars[at..at + power].iter().copied()).collect();
            out.truncate(kept);
            out += &whole.parse::<f64>().unwrap_or(0.0).to_string();
            at += power - 1;
        } else {
            out.push(c);
        }
        at += 1;
    }
    out
}

/// Returns the value of a fraction or the middle of a range whose sign stands at a place, after a number.
fn middle(chars: &[char], at: usize, out: &str) -> Option<String> {
    let from = out.trim_end_matches(|c: char| c.is_ascii_digit() || c == '.').len();
    let first: f64 = out[from..].parse().ok()?;
    let second: String = chars[at + 1..].iter().take_while(|c| c.is_ascii_digit()).collect();
    let second: f64 = second.parse().ok()?;
    match chars[at] {
        '/' if second > 0.0 => Some((first / second).to_string()),
        '-' | '\u{2013}' => Some((0.5 * (first + second)).to_string()),
        _ => None,
    }
}

/// Returns words in which a number of feet is a length, half of a unit a number, and a minute 60 seconds.
pub(super) fn with_units(words: Vec<String>) -> Vec<String> {
    const AWAY: [&str; 9] = ["forward", "forwards", "ahead", "backward", "backwards", "back", "away", "to", "straight"];
    const LENGTHS: [&str; 8] = ["m", "metre", "meter", "mile", "yard", "minute", "kilometre", "kilometer"];
    let word = |at: usize| words.get(at).map_or("", String::as_str);
    let mut out: Vec<String> = Vec::with_capacity(words.len());
    let mut at = 0;
    while at < words.len() {
        let value = number(word(at));
        let halves = word(at + 1) == "and" && ["a", "one"].contains(&word(at + 2)) && word(at + 3) == "half";
        if let (Some(value), true) = (value, halves) {
            out.push((value + 0.5).to_string());
            at += 4;
        } else if ["a", "an", "one", "another"].contains(&word(at)) && LENGTHS.contains(&word(at + 1)) {
            // "A metre and a half" is one and a half.
            let more = word(at + 2) == "and" && word(at + 3) == "a" && word(at + 4) == "half";
            out.extend([if more { "1.5" } else { "1" }.to_string(), word(at + 1).to_string()]);
            at += if more { 5 } else { 2 };
        } else if word(at) == "half" && ["a", "an"].contains(&word(at + 1)) && LENGTHS.contains(&word(at + 2)) {
            out.push("0.5".into());
            at += 2;
        } else if ["feet", "foot"].contains(&word(at))
            && out.last().and_then(|last| number(last)).is_some_and(|n| n > 2.0 || AWAY.contains(&word(at + 1)))
        {
            out.push("ft".into());
            at += 1;
        } else if ["minute", "minutes", "min", "mins"].contains(&word(at)) {
            if let Some(minutes) = out.last().and_then(|last| number(last)) {
                out.pop();
                out.extend([(60.0 * minutes).to_string(), "seconds".into()]);
            }
            at += 1;
        } else {
            out.push(word(at).to_string());
            at += 1;
        }
    }
    out
}

/// Returns words with numbers above twelve as digits: "a hundred and eighty" is 180, "forty five" 45.
pub(super) fn with_digits(words: Vec<String>) -> Vec<String> {
    let mut out: Vec<String> = Vec::with_capacity(words.len());
    let mut at = 0;
    while at < words.len() {
        let (mut value, mut taken) = (0, 0);
        let word = |i: usize| words.get(i).map_or("", String::as_str);
        let (hundreds, from) = match word(at) {
            "a" | "one" if word(at + 1) == "hundred" => (1, 2),
            "hundred" => (1, 1),
            "two" if word(at + 1) == "hundred" => (2, 2),
            "three" if word(at + 1) == "hundred" => (3, 2),
            // Turns: "a one-eighty", "three sixty".
            "one" if word(at + 1) == "eighty" => (1, 1),
            "two" if word(at + 1) == "seventy" => (2, 1),
            "three" if word(at + 1) == "sixty" => (3, 1),
            _ => (0, 0),
        };
        if hundreds > 0 {
            (value, taken) = (100 * hundreds, from);
        }
        let joined = usize::from(hundreds > 0 && word(at + taken) == "and");
        let tens = TENS.iter().find(|(name, _)| *name == word(at + taken + joined));
        if let Some((_, number)) = tens {
            value += number;
            taken += joined + 1;
            if number % 10 == 0
                && let Some(unit) = UNITS.iter().position(|name| *name == word(at + taken))
            {
                value += unit + 1;
                taken += 1;
            }
        }
        if taken > 0 {
            out.push(value.to_string());
            at += taken;
        } else {
            out.push(words[at].clone());
            at += 1;
        }
    }
    out
}

const UNITS: [&str; 9] = ["one", "two", "three", "four", "five", "six", "seven", "eight", "nine"];
const TENS: [(&str, usize); 15] = [
    ("thirteen", 13),
    ("fourteen", 14),
    ("fifteen", 15),
    ("sixteen", 16),
    ("seventeen", 17),
    ("eighteen", 18),
    ("nineteen", 19),
    ("twenty", 20),
    ("thirty", 30),
    ("forty", 40),
    ("fifty", 50),
    ("sixty", 60),
    ("seventy", 70),
    ("eighty", 80),
    ("ninety", 90),
];

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> String {
        let words = with_plain_numbers(text).split_whitespace().map(String::from).collect();
        with_units(with_digits(words)).join(" ")
    }

    #[test]
    fn numbers_have_one_form() {
        for (text, expected) in [
            ("1/2 metre", "0.5 metre"),
            ("1,5 m", "1.5 m"),
            ("1,000 m", "1000 m"),
            ("2-3 m", "2.5 m"),
            ("1\u{bd} m", "1.5 m"),
            ("1e3 m", "1000 m"),
            ("-5 m", "minus5 m"),
            ("2 m/s", "2 mpers"),
            ("two and a half metres", "2.5 metres"),
            ("half a metre", "0.5 metre"),
            ("a metre and a half", "1.5 metre"),
            ("another metre", "1 metre"),
            ("10 feet", "10 ft"),
            ("two feet forward", "two ft forward"),
            ("jump with two feet", "jump with two feet"),
            ("for 2 minutes", "for 120 seconds"),
            ("a hundred and eighty degrees", "180 degrees"),
            ("a one eighty", "a 180"),
            ("a three sixty", "a 360"),
            ("side-step", "side-step"),
        ] {
            assert_eq!(read(text), expected, "{text}");
        }
    }
}
