//! The known name that a mistyped one is nearest to.

use strsim::osa_distance;

/// Returns the candidate that differs from a word by the fewest edits, where these are at most a third of its letters.
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let limit = (word.chars().count() / 3).max(1);
    let distances = candidates.into_iter().map(|candidate| (osa_distance(word, candidate), candidate));
    distances.filter(|(distance, _)| *distance <= limit).min_by_key(|(distance, _)| *distance).map(|(_, name)| name)
}

/// Returns `; did you mean 'NAME'?`, or nothing where no candidate is near.
pub fn hint<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    nearest(word, candidates).map_or_else(String::new, |name| format!("; did you mean '{name}'?"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_near_names_are_proposed() {
        let names = ["lima", "humanoid", "g1"];
        assert_eq!(nearest("limma", names), Some("lima"));
        assert_eq!(nearest("humaniod", names), Some("humanoid"), "a swap is one edit");
        assert_eq!(nearest("toddlerbot", names), None);
        assert_eq!(hint("g2", names), "; did you mean 'g1'?");
    }
}
