//! Exact checks of language, counted.

use std::collections::BTreeMap;

use lifelike_language::checks::{Fact, Finding};
use serde::Serialize;

/// Counts of requests and of fulfilled ones.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Kept {
    /// Motions of which it was asked.
    pub asked: usize,
    /// Motions that show it.
    pub passed: usize,
}

impl Kept {
    fn add(&mut self, passed: bool) {
        self.asked += 1;
        self.passed += usize::from(passed);
    }

    /// Returns the share that passed; not a number where nothing was asked.
    pub fn share(&self) -> f64 {
        self.passed as f64 / self.asked as f64
    }
}

/// Results of the checks over all motions of a method.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Checks {
    /// By kind of fact: motions that keep all facts of this kind.
    pub facts: BTreeMap<Fact, Kept>,
    /// Motions that keep everything that their sentence promises.
    pub everything: Kept,
}

impl Checks {
    /// Adds the findings of one motion; none where its entry promises nothing that can be checked.
    pub fn add(&mut self, findings: &[Finding]) {
        for fact in Fact::ALL {
            let mut of = findings.iter().filter(|finding| finding.fact == fact).peekable();
            if of.peek().is_some() {
                self.facts.entry(fact).or_default().add(of.all(|finding| finding.passed));
            }
        }
        if !findings.is_empty() {
            self.everything.add(findings.iter().all(|finding| finding.passed));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_motion_keeps_a_kind_of_fact_when_it_keeps_all_of_them() {
        let finding = |fact, passed| Finding { verb: "v".into(), fact, expected: "".into(), got: "".into(), passed };
        let mut checks = Checks::default();
        checks.add(&[finding(Fact::Limb, true), finding(Fact::Limb, false), finding(Fact::Count, true)]);
        checks.add(&[finding(Fact::Limb, true)]);
        checks.add(&[]);
        assert_eq!(checks.facts[&Fact::Limb], Kept { asked: 2, passed: 1 });
        assert_eq!(checks.facts[&Fact::Count], Kept { asked: 1, passed: 1 });
        assert_eq!((checks.everything.share(), checks.facts.len()), (0.5, 2));
    }
}
