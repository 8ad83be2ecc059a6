//! `<equality>`: what closes kinematic loops. Welds and ball joints (`connect`) between bodies or sites; for `joint` see
//! [`super::coupling`].

use crate::error::CharacterError;
use crate::kinematics::Kinematics;
use crate::mjcf::attributes::Attributes;
use crate::mjcf::defaults::Defaults;
use crate::mjcf::document::Element;
use crate::mjcf::names::made_up;
use crate::mjcf::pose::Pose;
use crate::model::{Character, Equality, EqualityKind};
use crate::rotation::{Quat, Vec3, from_wxyz};

/// MuJoCo's defaults.
pub(crate) const SOLREF: [f64; 2] = [0.02, 1.0];
pub(crate) const SOLIMP: [f64; 5] = [0.9, 0.95, 0.001, 0.5, 2.0];

/// Reads every equality constraint of a character that is complete but for them. Frames that a constraint does not
/// name are as in the reference position.
pub(crate) fn read(
    root: &Element,
    defaults: &Defaults,
    character: &Character,
) -> Result<Vec<Equality>, CharacterError> {
    let elements: Vec<&Element> = root.children_named("equality").flat_map(|section| &section.children).collect();
    if elements.is_empty() {
        return Ok(Vec::new());
    }
    let reader = Reader { character, kinematics: Kinematics::new(character) };
    let mut equalities = Vec::new();
    for element in elements {
        let a = defaults.resolve(element, None)?;
        equalities.push(match element.name.as_str() {
            "connect" => reader.connect(&a)?,
            "weld" => reader.weld(&a)?,
            "joint" => continue,
            _ => return Err(element.unsupported("element in <equality>")),
        });
    }
    for i in 0..equalities.len() {
        if equalities[i].name.is_empty() {
            equalities[i].name = made_up(format!("equality{i}"), equalities.iter().map(|e| e.name.as_str()));
        }
    }
    Ok(equalities)
}

/// The two bodies, and a frame on each.
type Held = ([usize; 2], [Pose; 2]);

struct Reader<'a> {
    character: &'a Character,
    /// In the reference position.
    kinematics: Kinematics,
}

impl Reader<'_> {
    fn connect(&self, a: &Attributes) -> Result<Equality, CharacterError> {
        a.only(&["name", "class", "body1", "body2", "anchor", "site1", "site2", "active", "solref", "solimp"])?;
        if let Some((bodies, frames)) = self.sites(a, &["body1", "body2", "anchor"])? {
            return equality(a, EqualityKind::Connect, bodies, frames);
        }
        let bodies = self.bodies(a)?;
        let anchor = a.numbers::<3>("anchor")?.ok_or_else(|| a.invalid("attribute 'anchor'", "none"))?;
        let frame = at(anchor);
        equality(a, EqualityKind::Connect, bodies, [frame, self.seen_from(bodies[1], bodies[0], &frame)])
    }

    /// Of a weld the anchor is in the SECOND body.
    fn weld(&self, a: &Attributes) -> Result<Equality, CharacterError> {
        a.only(&[
            "name",
            "class",
            "body1",
            "body2",
            "anchor",
            "relpose",
            "torquescale",
            "site1",
            "site2",
            "active",
            "solref",
            "solimp",
        ])?;
        let kind = EqualityKind::Weld { torque_scale: a.number("torquescale")?.unwrap_or(1.0) };
        if let Some((bodies, frames)) = self.sites(a, &["body1", "body2", "anchor", "relpose"])? {
            return equality(a, kind, bodies, frames);
        }
        let bodies = self.bodies(a)?;
        let second = at(a.numbers::<3>("anchor")?.unwrap_or_default());
        let [x, y, z, quaternion @ ..] = a.numbers::<7>("relpose")?.unwrap_or_default();
        // All zero says nothing, and then the position beside it is not used either.
        let first = if quaternion == [0.0; 4] {
            self.seen_from(bodies[0], bodies[1], &second)
        } else {
            let orientation = from_wxyz(quaternion)
                .ok_or_else(|| a.invalid("'relpose' with an orientation", format!("{quaternion:?}")))?;
            Pose { position: Vec3::new(x, y, z), orientation }
        };
        equality(a, kind, bodies, [first, second])
    }

    /// Returns the two bodies; the second is the world where none is named.
    fn bodies(&self, a: &Attributes) -> Result<[usize; 2], CharacterError> {
        let find = |attribute: &str, name: &str| {
            let found = self.character.bodies.iter().position(|b| b.name == name);
            found.ok_or_else(|| a.invalid(format!("the name of a body for '{attribute}'"), format!("'{name}'")))
        };
        Ok([find("body1", a.required("body1")?)?, a.text("body2").map_or(Ok(0), |name| find("body2", name))?])
    }

    /// Returns the bodies and the frames of two sites, where the constraint is between sites and so says nothing of `others`.
    fn sites(&self, a: &Attributes, others: &[&str]) -> Result<Option<Held>, CharacterError> {
        if a.text("site1").is_none() && a.text("site2").is_none() {
            return Ok(None);
        }
        if let Some(other) = others.iter().find(|other| a.text(other).is_some()) {
            return Err(a.invalid("sites or bodies", format!("'{other}' beside a site")));
        }
        let find = |attribute: &str| {
            let name = a.required(attribute)?;
            let found = self.character.sites.iter().find(|s| s.name == name);
            found.ok_or_else(|| a.invalid(format!("the name of a site for '{attribute}'"), format!("'{name}'")))
        };
        let sites = [find("site1")?, find("site2")?];
        let frames = sites.map(|site| Pose { position: site.position, orientation: site.orientation });
        Ok(Some((sites.map(|site| site.body), frames)))
    }

    /// Returns a frame of body `other` as body `body` sees it in the reference position.
    fn seen_from(&self, body: usize, other: usize, frame: &Pose) -> Pose {
        let k = &self.kinematics;
        let turn = k.body_orientation[body].inverse();
        Pose {
            position: turn * (k.point(other, &frame.position) - k.body_position[body]),
            orientation: turn * k.body_orientation[other] * frame.orientation,
        }
    }
}

/// The frame of a body, moved.
fn at(position: [f64; 3]) -> Pose {
    Pose { position: position.into(), orientation: Quat::identity() }
}

fn equality(
    a: &Attributes,
    kind: EqualityKind,
    bodies: [usize; 2],
    frames: [Pose; 2],
) -> Result<Equality, CharacterError> {
    Ok(Equality {
        name: a.text("name").unwrap_or("").to_string(),
        kind,
        bodies,
        anchors: [frames[0].position, frames[1].position],
        orientations: [frames[0].orientation, frames[1].orientation],
        solref: a.prefix("solref", SOLREF)?,
        solimp: a.prefix("solimp", SOLIMP)?,
        active: a.boolean("active", true)?,
    })
}
