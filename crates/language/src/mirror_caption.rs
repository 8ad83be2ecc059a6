//! A caption of the mirrored motion: left and right, clockwise and counterclockwise change places.

/// Words and what they are in a mirror. Those that are longer than others they contain stand alone: words are whole.
const PAIRS: [(&str, &str); 9] = [
    ("left", "right"),
    ("lefts", "rights"),
    ("leftward", "rightward"),
    ("leftwards", "rightwards"),
    ("lefthand", "righthand"),
    ("leftmost", "rightmost"),
    ("clockwise", "counterclockwise"),
    ("lefthanded", "righthanded"),
    ("lefty", "righty"),
];

/// Returns the caption of the mirrored motion. Capital letters stay, `counter-clockwise` and `anti-clockwise` are
/// known, and "right" that is no side (`right away`, `right after`, `upright`, `all right`) stays.
///
/// ```
/// use lifelike_language::mirror_caption;
///
/// assert_eq!(mirror_caption("Turn right, then wave the left hand"), "Turn left, then wave the right hand");
/// assert_eq!(mirror_caption("turns anti-clockwise right away"), "turns clockwise right away");
/// ```
pub fn mirror_caption(caption: &str) -> String {
    let mut text = caption.to_string();
    // One word for each sense, so that words can be exchanged.
    for hyphened in ["counter-clockwise", "anti-clockwise", "anticlockwise", "counter clockwise"] {
        text = text.replace(hyphened, "counterclockwise");
    }
    let words = pieces(&text);
    let mut out = String::with_capacity(text.len());
    for (at, word) in words.iter().enumerate() {
        let neighbour = |step: isize| {
            let place = at as isize + 2 * step;
            let spaced = words.get((at as isize + step).max(0) as usize).is_some_and(|space| *space == " ");
            usize::try_from(place).ok().filter(|_| spaced).and_then(|p| words.get(p)).map(|w| w.to_lowercase())
        };
        let idiom = word.eq_ignore_ascii_case("right")
            && (["away", "after", "before", "now", "then", "when"].contains(&neighbour(1).as_deref().unwrap_or(""))
                || neighbour(-1).as_deref() == Some("all"));
        out += &if idiom { (*word).to_string() } else { swapped(word) };
    }
    out
}

/// Returns the text as words and what is between them.
fn pieces(text: &str) -> Vec<&str> {
    let mut found = Vec::new();
    let mut start = 0;
    let mut in_word = None;
    for (at, c) in text.char_indices() {
        let letter = c.is_alphabetic();
        if in_word.is_some_and(|was| was != letter) {
            found.push(&text[start..at]);
            start = at;
        }
        in_word = Some(letter);
    }
    found.push(&text[start..]);
    found
}

fn swapped(word: &str) -> String {
    let lower = word.to_lowercase();
    let other = PAIRS.iter().find_map(|(a, b)| {
        if lower == *a {
            Some(*b)
        } else if lower == *b {
            Some(*a)
        } else {
            None
        }
    });
    match other {
        None => word.to_string(),
        Some(other) if word.len() > 1 && word.chars().all(char::is_uppercase) => other.to_uppercase(),
        Some(other) if word.starts_with(char::is_uppercase) => {
            let mut letters = other.chars();
            letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
        }
        Some(other) => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mirror_in_a_mirror_shows_the_sentence() {
        for text in [
            "a person waves with the left hand, then the RIGHT one",
            "Left foot forward; turns clockwise twice to the right",
            "she stands upright and brightly lifts her right arm",
        ] {
            assert_ne!(mirror_caption(text), text);
            assert_eq!(mirror_caption(&mirror_caption(text)), text);
        }
        assert_eq!(mirror_caption("UP LEFT. Right-handed"), "UP RIGHT. Left-handed");
        assert_eq!(
            mirror_caption("stands upright, all right, right after that"),
            "stands upright, all right, right after that"
        );
        assert_eq!(mirror_caption(""), "");
    }
}
