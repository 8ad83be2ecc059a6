//! Bounds of options, checked while arguments are parsed.

/// Most threads: more than any machine has cores for.
const THREADS: usize = 1024;
/// Most environments of one simulation.
const ENVIRONMENTS: usize = 1 << 20;
/// Most motions to choose from.
const CANDIDATES: usize = 4096;

/// Parses a number of threads; 0 stands for one per processor.
///
/// # Errors
/// No number, or too many.
pub fn threads(text: &str) -> Result<usize, String> {
    number(text, 0, THREADS)
}

/// Parses a number of environments.
///
/// # Errors
/// No number, none, or too many.
pub fn environments(text: &str) -> Result<usize, String> {
    number(text, 1, ENVIRONMENTS)
}

/// Parses a number of motions to choose from.
///
/// # Errors
/// No number, none, or too many.
pub fn candidates(text: &str) -> Result<usize, String> {
    number(text, 1, CANDIDATES)
}

fn number(text: &str, least: usize, most: usize) -> Result<usize, String> {
    let found = text.parse().ok().filter(|number| (least..=most).contains(number));
    found.ok_or_else(|| format!("expected a number from {least} to {most}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_beyond_any_machine_are_refused() {
        assert_eq!((threads("0"), threads("1024"), environments("1")), (Ok(0), Ok(1024), Ok(1)));
        for text in ["10000000", "-1", "18446744073709551615", "18446744073709551616", "two"] {
            assert!(threads(text).is_err() && environments(text).is_err(), "{text}");
        }
        assert!(environments("0").is_err() && candidates("0").is_err() && candidates("4096") == Ok(4096));
    }
}
