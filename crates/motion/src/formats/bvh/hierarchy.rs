//! The first half of a BVH file.

use lifelike_character::Vec3;

use crate::error::MotionError;
use crate::formats::text::Lines;
use crate::roles::{self, Tree};

/// More joints than any skeleton of a body with fingers and a face has.
const MOST_JOINTS: usize = 1000;

/// Meaning of one number of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Channel {
    /// Position along an axis (0 = x, 1 = y, 2 = z).
    Position(usize),
    /// Rotation about an axis.
    Rotation(usize),
}

impl Channel {
    fn parse(token: &str) -> Option<Self> {
        let axis = match token.as_bytes().first()? {
            b'X' | b'x' => 0,
            b'Y' | b'y' => 1,
            b'Z' | b'z' => 2,
            _ => return None,
        };
        match token.get(1..)?.to_ascii_lowercase().as_str() {
            "position" => Some(Self::Position(axis)),
            "rotation" => Some(Self::Rotation(axis)),
            _ => None,
        }
    }
}

pub(super) struct Joint {
    pub name: String,
    pub parent: Option<usize>,
    pub offset: Vec3,
    /// Empty for a joint that never moves.
    pub channels: Vec<Channel>,
}

pub(super) struct Hierarchy {
    pub joints: Vec<Joint>,
    pub ends: Vec<(usize, Vec3)>,
    /// The joint that moves as the root, see [`Hierarchy::find_root`].
    pub root: usize,
    /// The joint after the last one below the root.
    pub end: usize,
    /// True for each joint that is the root or carries it.
    pub carries_root: Vec<bool>,
}

/// Owner of an open brace.
#[derive(Clone, Copy)]
enum Open {
    Joint(usize),
    End(usize),
}

/// Statements of the first half of a file: lines, cut at braces. A brace stands on a line of its own or ends another.
struct Statements<'l, 'a> {
    lines: &'l mut Lines<'a>,
    rest: &'a str,
}

impl<'a> Statements<'_, 'a> {
    /// Returns the next statement, or an error that says what should have been there.
    fn expect(&mut self, expected: &str) -> Result<&'a str, MotionError> {
        if self.rest.is_empty() {
            self.rest = self.lines.expect(expected)?;
        }
        let end = match self.rest.find(['{', '}']) {
            Some(0) => 1,
            Some(brace) => brace,
            None => self.rest.len(),
        };
        let (statement, rest) = self.rest.split_at(end);
        self.rest = rest.trim_start();
        Ok(statement.trim_end())
    }
}

/// Removes a keyword in any case from the start of a statement; returns what follows.
fn after_keyword<'a>(statement: &'a str, keyword: &str) -> Option<&'a str> {
    let (word, rest) = statement.split_once(|c: char| c.is_ascii_whitespace()).unwrap_or((statement, ""));
    word.eq_ignore_ascii_case(keyword).then(|| rest.trim())
}

impl Hierarchy {
    /// Reads up to and with the line `MOTION`. Keywords are read in any case, names may hold spaces.
    pub(super) fn parse(lines: &mut Lines<'_>) -> Result<Self, MotionError> {
        let first = lines.expect("'HIERARCHY'")?;
        if !first.eq_ignore_ascii_case("HIERARCHY") {
            return Err(lines.error("'HIERARCHY'", first));
        }
        let mut tree = Self { joints: Vec::new(), ends: Vec::new(), root: 0, end: 0, carries_root: Vec::new() };
        let mut statements = Statements { lines, rest: "" };
        let mut open: Vec<Open> = Vec::new();
        let mut described: Option<Open> = None;
        loop {
            let statement = statements.expect("a joint, '}' or 'MOTION'")?;
            let lines = &*statements.lines;
            match (statement, described.take()) {
                ("{", Some(node)) => open.push(node),
                ("{", None) => return Err(lines.error("a joint before '{'", statement)),
                (_, Some(_)) => return Err(lines.error("'{'", statement)),
                ("}", None) if !open.is_empty() => {
                    open.pop();
                }
                _ if open.is_empty() && !tree.joints.is_empty() && after_keyword(statement, "MOTION") == Some("") => {
                    return tree.complete(lines);
                }
                _ => described = tree.describe(lines, statement, open.last().copied())?,
            }
        }
    }

    /// Reads a statement other than a brace. Returns the owner of the brace that must follow, if one must.
    fn describe(
        &mut self,
        lines: &Lines<'_>,
        statement: &str,
        open: Option<Open>,
    ) -> Result<Option<Open>, MotionError> {
        let is = |keyword| after_keyword(statement, keyword);
        match open {
            None if self.joints.is_empty() => match is("ROOT") {
                Some(name) => self.add(lines, None, name).map(Some),
                None => Err(lines.error("'ROOT <name>'", statement)),
            },
            None if is("ROOT").is_some() => {
                Err(lines.error("one skeleton (write each into a file of its own)", statement))
            }
            None => Err(lines.error("'MOTION'", statement)),
            Some(Open::Joint(joint)) => {
                if let Some(name) = is("JOINT") {
                    return self.add(lines, Some(joint), name).map(Some);
                }
                if is("End").is_some() {
                    self.ends.push((joint, Vec3::zeros()));
                    return Ok(Some(Open::End(self.ends.len() - 1)));
                }
                if let Some(numbers) = is("OFFSET") {
                    self.joints[joint].offset = offset(lines, numbers)?;
                } else if let Some(names) = is("CHANNELS") {
                    self.joints[joint].channels = channels(lines, names)?;
                } else {
                    return Err(lines.error("OFFSET, CHANNELS, JOINT, End Site or '}'", statement));
                }
                Ok(None)
            }
            Some(Open::End(end)) => {
                if let Some(numbers) = is("OFFSET") {
                    self.ends[end].1 = offset(lines, numbers)?;
                } else if is("CHANNELS").is_none_or(|names| names != "0") {
                    return Err(lines.error("OFFSET or '}'", statement));
                }
                Ok(None)
            }
        }
    }

    fn add(&mut self, lines: &Lines<'_>, parent: Option<usize>, name: &str) -> Result<Open, MotionError> {
        let name = name.split_ascii_whitespace().collect::<Vec<_>>().join(" ");
        if name.is_empty() {
            return Err(lines.error("a joint's name", ""));
        }
        if self.joints.len() == MOST_JOINTS {
            return Err(lines.error(format!("at most {MOST_JOINTS} joints"), &name));
        }
        if self.joints.iter().any(|j| j.name == name) {
            return Err(lines.error("a name that no other joint has", &name));
        }
        self.joints.push(Joint { name, parent, offset: Vec3::zeros(), channels: Vec::new() });
        Ok(Open::Joint(self.joints.len() - 1))
    }

    /// Checks that something moves.
    fn complete(mut self, lines: &Lines<'_>) -> Result<Self, MotionError> {
        if self.joints.iter().all(|joint| joint.channels.is_empty()) {
            return Err(lines.error("CHANNELS of some joint before 'MOTION'", "none in the whole hierarchy"));
        }
        self.root = self.find_root();
        let parents = self.parents();
        self.end = roles::end_of(&parents, self.root);
        let carries = |joint| joint <= self.root && self.root < roles::end_of(&parents, joint);
        self.carries_root = (0..parents.len()).map(carries).collect();
        Ok(self)
    }

    /// Finds the joint that moves as the root, see [`roles::body_root`].
    fn find_root(&self) -> usize {
        let names: Vec<String> = self.joints.iter().map(|joint| joint.name.clone()).collect();
        let parents = self.parents();
        let offsets: Vec<Vec3> = self.joints.iter().map(|joint| joint.offset).collect();
        let moves = |joint: &Joint| joint.channels.iter().any(|c| matches!(c, Channel::Position(_)));
        let moves: Vec<bool> = self.joints.iter().map(moves).collect();
        let ends: Vec<usize> = self.ends.iter().map(|(joint, _)| *joint).collect();
        roles::body_root(Tree { names: &names, parents: &parents, offsets: &offsets }, &moves, &ends)
    }

    fn parents(&self) -> Vec<Option<usize>> {
        self.joints.iter().map(|joint| joint.parent).collect()
    }
}

fn offset(lines: &Lines<'_>, numbers: &str) -> Result<Vec3, MotionError> {
    Ok(Vec3::from(lines.numbers::<3>(numbers.split_ascii_whitespace(), "three numbers of an offset")?))
}

/// Reads `<count> <name>...`
fn channels(lines: &Lines<'_>, text: &str) -> Result<Vec<Channel>, MotionError> {
    let mut tokens = text.split_ascii_whitespace();
    let stated = tokens.next().unwrap_or_default();
    let mut channels = Vec::with_capacity(6);
    for token in tokens {
        match Channel::parse(token) {
            Some(channel) if !channels.contains(&channel) => channels.push(channel),
            _ => return Err(lines.error("a channel such as Xposition or Zrotation, each once", token)),
        }
    }
    if stated.parse() == Ok(channels.len()) {
        Ok(channels)
    } else {
        Err(lines.error("the count of channels, then their names", &format!("{stated} and {} names", channels.len())))
    }
}
