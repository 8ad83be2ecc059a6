//! ASF (Acclaim skeleton file): bones with directions, lengths and the axes of their degrees of freedom.
//!
//! A bone's joint is at its start and has the bone's name. Lengths are in inches over `length` (0.45 in the CMU
//! files), so one unit is `0.0254 / length` m. A bone's frame is turned from the world by `axis`, the turn `C`. Its
//! rotation in the world's axes is `C M C^-1` with `M` the product of its degrees of freedom, the first applied first.

use std::path::Path;

use lifelike_character::{Quat, Vec3};

use super::raw;
use super::text::{self, Lines};
use crate::error::MotionError;

/// More bones than any Acclaim skeleton has (CMU: 30).
const MOST_BONES: usize = 128;

/// One degree of freedom of a bone or the root.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dof {
    /// Translation along an axis (0 = x, 1 = y, 2 = z), in units of length.
    Translation(usize),
    /// Rotation about an axis of the bone's frame.
    Rotation(usize),
}

impl Dof {
    fn parse(token: &str) -> Option<Self> {
        Some(match token.to_ascii_lowercase().as_str() {
            "tx" => Self::Translation(0),
            "ty" => Self::Translation(1),
            "tz" => Self::Translation(2),
            "rx" => Self::Rotation(0),
            "ry" => Self::Rotation(1),
            "rz" => Self::Rotation(2),
            _ => return None,
        })
    }
}

/// One bone, with the joint at its start. The root is a bone without length.
#[derive(Debug, Clone, PartialEq)]
pub struct Bone {
    /// Its name; `root` for the root.
    pub name: String,
    /// The bone that it hangs on.
    pub parent: Option<usize>,
    /// From its start to its end (m, the file's axes: y up).
    pub vector: Vec3,
    /// The turn from the world to the bone's frame.
    pub axis: Quat,
    /// Its degrees of freedom, in the order of the numbers of an AMC line.
    pub dofs: Vec<Dof>,
}

/// An Acclaim skeleton.
#[derive(Debug, Clone, PartialEq)]
pub struct AsfSkeleton {
    /// The bones, parents before children, the root first.
    pub bones: Vec<Bone>,
    /// Metres per unit of length.
    pub scale: f64,
    /// Radians per unit of angle.
    pub angle: f64,
    /// The root's place when all its degrees of freedom are zero (m).
    pub root_position: Vec3,
}

/// Reads a skeleton. `file` is for messages only.
///
/// # Errors
/// [`MotionError::Parse`] with the line.
pub fn parse(bytes: &[u8], file: &Path) -> Result<AsfSkeleton, MotionError> {
    let mut lines = Lines::new(text::decode(bytes, file)?, file);
    let mut skeleton = AsfSkeleton {
        bones: vec![Bone {
            name: "root".to_owned(),
            parent: None,
            vector: Vec3::zeros(),
            axis: Quat::identity(),
            dofs: Vec::new(),
        }],
        scale: 0.0254,
        angle: 1.0_f64.to_radians(),
        root_position: Vec3::zeros(),
    };
    let mut section = String::new();
    let mut linked = false;
    let (mut order, mut orientation) = ([0, 1, 2], [0.0; 3]);
    while let Some(line) = lines.next_line() {
        if line.starts_with('#') {
            continue;
        }
        if let Some(keyword) = line.strip_prefix(':') {
            section = keyword.split_ascii_whitespace().next().unwrap_or_default().to_ascii_lowercase();
            if section == "hierarchy" {
                linked = true;
            }
            continue;
        }
        let mut tokens = line.split_ascii_whitespace();
        let word = tokens.next().unwrap_or_default();
        // Keywords are read in any case; in the hierarchy words are names.
        let keyword = if section == "hierarchy" { word.to_owned() } else { word.to_ascii_lowercase() };
        match (section.as_str(), keyword.as_str()) {
            ("units", "length") => {
                let [length] = lines.numbers::<1>(tokens, "a unit of length")?;
                if !(1e-3..=1e3).contains(&length) {
                    return Err(lines.error("a unit of length between 0.001 and 1000", line));
                }
                skeleton.scale = 0.0254 / length;
            }
            ("units", "angle") => skeleton.angle = angle_unit(&lines, tokens.next())?,
            ("root", "order") => skeleton.bones[0].dofs = dofs(&lines, tokens)?,
            ("root", "axis") => order = axis_order(&lines, tokens.next())?,
            ("root", "position") => {
                let place = lines.numbers::<3>(tokens, "three numbers of the root's position")?;
                skeleton.root_position = Vec3::from(place);
            }
            ("root", "orientation") => orientation = lines.numbers(tokens, "three angles of the root")?,
            ("bonedata", "begin") => bone(&mut lines, &mut skeleton)?,
            ("hierarchy", word) if ["begin", "end"].iter().any(|k| word.eq_ignore_ascii_case(k)) => {}
            ("hierarchy", parent) => link(&lines, &mut skeleton, parent, tokens)?,
            ("units" | "documentation" | "version" | "name" | "skin", _) => {}
            _ => return Err(lines.error("the keywords of an ASF file", line)),
        }
    }
    if skeleton.bones[0].dofs.is_empty() {
        return Err(lines.error("':root' with 'order TX TY TZ RX RY RZ'", "none in the whole file"));
    }
    if !linked {
        return Err(lines.error("':hierarchy'", "the end of the file"));
    }
    skeleton.bones[0].axis = turn(order, orientation.map(|a| a * skeleton.angle));
    skeleton.root_position *= skeleton.scale;
    sorted(&lines, skeleton)
}

/// Reads one `begin` ... `end` of `:bonedata`.
fn bone(lines: &mut Lines<'_>, skeleton: &mut AsfSkeleton) -> Result<(), MotionError> {
    let (mut name, mut direction, mut length, mut axis) = (None, None, None, Quat::identity());
    let mut freedom = Vec::new();
    loop {
        let line = lines.expect("'end' of a bone")?;
        let mut tokens = line.split_ascii_whitespace();
        match tokens.next().unwrap_or_default().to_ascii_lowercase().as_str() {
            "name" => name = tokens.next().map(str::to_owned),
            "direction" => direction = Some(Vec3::from(lines.numbers::<3>(tokens, "three numbers of a direction")?)),
            "length" => length = Some(lines.numbers::<1>(tokens, "a length")?[0]),
            "axis" => {
                let mut angles = [0.0; 3];
                for angle in &mut angles {
                    *angle = lines.number_in(tokens.next(), "three angles and their order")? * skeleton.angle;
                }
                axis = turn(axis_order(lines, tokens.next())?, angles);
            }
            "dof" => freedom = dofs(lines, tokens)?,
            "end" => break,
            // Limits go on over several lines that start with a parenthesis.
            "id" | "limits" | "bodymass" | "cofmass" => {}
            word if word.starts_with('(') => {}
            _ => return Err(lines.error("the keywords of a bone", line)),
        }
    }
    let (Some(name), Some(direction), Some(length)) = (name, direction, length) else {
        return Err(lines.error("name, direction and length before a bone's end", "end"));
    };
    if skeleton.bones.len() == MOST_BONES {
        return Err(lines.error(format!("at most {MOST_BONES} bones"), &name));
    }
    if skeleton.bones.iter().any(|b| b.name == name) {
        return Err(lines.error("a name that no other bone has", &name));
    }
    let Some(direction) = direction.try_normalize(1e-9) else {
        return Err(lines.error("a direction that is not zero", "zero"));
    };
    // The parent is known only after :hierarchy; until then a bone has none.
    let vector = direction * (length * skeleton.scale);
    skeleton.bones.push(Bone { name, parent: None, vector, axis, dofs: freedom });
    Ok(())
}

/// Reads `parent child child ...` of `:hierarchy`.
fn link(
    lines: &Lines<'_>,
    skeleton: &mut AsfSkeleton,
    parent: &str,
    children: std::str::SplitAsciiWhitespace<'_>,
) -> Result<(), MotionError> {
    let find = |skeleton: &AsfSkeleton, name: &str| {
        skeleton.bones.iter().position(|b| b.name == name).ok_or_else(|| lines.error("a bone of :bonedata", name))
    };
    let parent = find(skeleton, parent)?;
    for name in children {
        let child = find(skeleton, name)?;
        if child == 0 || skeleton.bones[child].parent.is_some() {
            return Err(lines.error("a bone that has no parent yet", name));
        }
        skeleton.bones[child].parent = Some(parent);
    }
    Ok(())
}

/// Parents before children, and every bone linked to the root.
fn sorted(lines: &Lines<'_>, skeleton: AsfSkeleton) -> Result<AsfSkeleton, MotionError> {
    let mut order = vec![0_usize];
    let mut at = 0;
    while at < order.len() {
        let parent = order[at];
        order.extend((0..skeleton.bones.len()).filter(|b| skeleton.bones[*b].parent == Some(parent)));
        at += 1;
    }
    if let Some(lost) = (0..skeleton.bones.len()).find(|b| !order.contains(b)) {
        let name = &skeleton.bones[lost].name;
        return Err(lines.error("every bone linked to the root in :hierarchy", &format!("bone '{name}' that is not")));
    }
    let new_index = |old: usize| order.iter().position(|b| *b == old);
    let bones = order
        .iter()
        .map(|old| {
            let bone = &skeleton.bones[*old];
            Bone { parent: bone.parent.and_then(new_index), ..bone.clone() }
        })
        .collect();
    Ok(AsfSkeleton { bones, ..skeleton })
}

fn dofs(lines: &Lines<'_>, tokens: std::str::SplitAsciiWhitespace<'_>) -> Result<Vec<Dof>, MotionError> {
    let mut dofs = Vec::with_capacity(6);
    for token in tokens {
        match Dof::parse(token) {
            Some(dof) if !dofs.contains(&dof) => dofs.push(dof),
            _ => return Err(lines.error("tx, ty, tz, rx, ry or rz, each once", token)),
        }
    }
    Ok(dofs)
}

fn angle_unit(lines: &Lines<'_>, token: Option<&str>) -> Result<f64, MotionError> {
    match token.unwrap_or_default().to_ascii_lowercase() {
        unit if unit.starts_with("deg") => Ok(1.0_f64.to_radians()),
        unit if unit.starts_with("rad") => Ok(1.0),
        unit => Err(lines.error("deg or rad", &unit)),
    }
}

/// Reads `XYZ` and the like.
fn axis_order(lines: &Lines<'_>, token: Option<&str>) -> Result<[usize; 3], MotionError> {
    let token = token.unwrap_or_default();
    let axes: Vec<usize> =
        token.bytes().filter_map(|b| b"XYZ".iter().position(|a| *a == b.to_ascii_uppercase())).collect();
    match axes.as_slice() {
        [a, b, c] if token.len() == 3 && a != b && b != c && a != c => Ok([*a, *b, *c]),
        _ => Err(lines.error("an order of axes such as XYZ", token)),
    }
}

/// Returns the rotation about fixed axes in this order; the angles are named in the order's sequence too.
fn turn(order: [usize; 3], angles: [f64; 3]) -> Quat {
    order.iter().zip(angles).fold(Quat::identity(), |so_far, (axis, angle)| raw::about(*axis, angle) * so_far)
}
