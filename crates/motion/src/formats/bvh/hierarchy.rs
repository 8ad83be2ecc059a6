//! The first half of a BVH file.

use lifelike_character::Vec3;

use crate::error::MotionError;
use crate::formats::text::Lines;

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
    pub channels: Vec<Channel>,
}

pub(super) struct Hierarchy {
    pub joints: Vec<Joint>,
    pub ends: Vec<(usize, Vec3)>,
}

/// Owner of an open brace.
#[derive(Clone, Copy)]
enum Open {
    Joint(usize),
    End(usize),
}

impl Hierarchy {
    /// Reads up to and with the line `MOTION`.
    pub(super) fn parse(lines: &mut Lines<'_>) -> Result<Self, MotionError> {
        let first = lines.expect("'HIERARCHY'")?;
        if first != "HIERARCHY" {
            return Err(lines.error("'HIERARCHY'", first));
        }
        let mut tree = Self { joints: Vec::new(), ends: Vec::new() };
        let mut open: Vec<Open> = Vec::new();
        let mut described: Option<Open> = None;
        loop {
            let line = lines.expect("a joint, '}' or 'MOTION'")?;
            let mut tokens = line.split_ascii_whitespace();
            match (tokens.next().unwrap_or_default(), open.last().copied()) {
                ("{", _) => match described.take() {
                    Some(node) => open.push(node),
                    None => return Err(lines.error("a joint before '{'", line)),
                },
                (_, _) if described.is_some() => return Err(lines.error("'{'", line)),
                ("}", Some(node)) => {
                    tree.check_complete(lines, node)?;
                    open.pop();
                }
                ("ROOT", None) if tree.joints.is_empty() => {
                    described = Some(tree.add(lines, None, tokens.next())?);
                }
                ("JOINT", Some(Open::Joint(parent))) => {
                    described = Some(tree.add(lines, Some(parent), tokens.next())?);
                }
                ("End", Some(Open::Joint(parent))) => {
                    tree.ends.push((parent, Vec3::zeros()));
                    described = Some(Open::End(tree.ends.len() - 1));
                }
                ("OFFSET", Some(node)) => {
                    let offset = Vec3::from(lines.numbers::<3>(tokens, "three numbers of an offset")?);
                    match node {
                        Open::Joint(joint) => tree.joints[joint].offset = offset,
                        Open::End(end) => tree.ends[end].1 = offset,
                    }
                }
                ("CHANNELS", Some(Open::Joint(joint))) => tree.joints[joint].channels = channels(lines, tokens)?,
                ("MOTION", None) if !tree.joints.is_empty() => return Ok(tree),
                _ => {
                    let expected = match open.last() {
                        None if tree.joints.is_empty() => "'ROOT <name>'",
                        None => "'MOTION'",
                        Some(Open::Joint(_)) => "OFFSET, CHANNELS, JOINT, End Site or '}'",
                        Some(Open::End(_)) => "OFFSET or '}'",
                    };
                    return Err(lines.error(expected, line));
                }
            }
        }
    }

    fn add(&mut self, lines: &Lines<'_>, parent: Option<usize>, name: Option<&str>) -> Result<Open, MotionError> {
        let Some(name) = name else { return Err(lines.error("a joint's name", "")) };
        if self.joints.len() == MOST_JOINTS {
            return Err(lines.error(format!("at most {MOST_JOINTS} joints"), name));
        }
        if self.joints.iter().any(|j| j.name == name) {
            return Err(lines.error("a name that no other joint has", name));
        }
        self.joints.push(Joint { name: name.to_owned(), parent, offset: Vec3::zeros(), channels: Vec::new() });
        Ok(Open::Joint(self.joints.len() - 1))
    }

    /// Checks that every joint has a number per frame, so that a small file cannot stand for a huge motion.
    fn check_complete(&self, lines: &Lines<'_>, node: Open) -> Result<(), MotionError> {
        match node {
            Open::Joint(joint) if self.joints[joint].channels.is_empty() => {
                Err(lines.error(format!("CHANNELS of joint '{}'", self.joints[joint].name), "'}'"))
            }
            _ => Ok(()),
        }
    }

    /// Returns the joint that moves as the root: the first of the chain on top that has a branch below it, or whose
    /// child has no position channels.
    pub(super) fn root(&self) -> usize {
        let mut root = 0;
        loop {
            let mut children = (root + 1..self.joints.len()).filter(|j| self.joints[*j].parent == Some(root));
            match (children.next(), children.next()) {
                (Some(only), None)
                    if self.joints[only].channels.iter().any(|c| matches!(c, Channel::Position(_)))
                        && !self.ends.iter().any(|(j, _)| *j == root) =>
                {
                    root = only;
                }
                _ => return root,
            }
        }
    }
}

/// Reads `CHANNELS <count> <name>...`
fn channels(lines: &Lines<'_>, mut tokens: std::str::SplitAsciiWhitespace<'_>) -> Result<Vec<Channel>, MotionError> {
    let stated = tokens.next().unwrap_or_default();
    let mut channels = Vec::with_capacity(6);
    for token in tokens {
        match Channel::parse(token) {
            Some(channel) if !channels.contains(&channel) => channels.push(channel),
            _ => return Err(lines.error("a channel such as Xposition or Zrotation, each once", token)),
        }
    }
    if stated.parse() == Ok(channels.len()) && !channels.is_empty() {
        Ok(channels)
    } else {
        Err(lines.error("the count of channels, then their names", &format!("{stated} and {} names", channels.len())))
    }
}
