//! Roles of a captured skeleton's joints: guessed from names and topology, overridable by text.

use std::collections::BTreeMap;
use std::str::FromStr;

use lifelike_character::Role;

use crate::error::MotionError;
use crate::roles;
use crate::source::SourceClip;

/// Joints of roles, and those at the balls of the feet (left, right).
type RolesAndToes = (BTreeMap<Role, usize>, [Option<usize>; 2]);

/// Overrides of the guess, as TOML:
///
/// ```toml
/// left_toe = "LeftToeBase"
/// [roles]
/// left_thigh = "LeftUpLeg"
/// ```
///
/// A role's joint is the one whose rotation moves that segment: `left_thigh` is the hip joint, `left_shank` the knee,
/// `left_foot` the ankle, `left_hand` the wrist.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Correspondence {
    /// Source joint of each role.
    pub roles: BTreeMap<Role, String>,
    /// Source joint at the ball of the left foot.
    pub left_toe: Option<String>,
    /// Source joint at the ball of the right foot.
    pub right_toe: Option<String>,
}

impl Correspondence {
    /// Adds roles, which replace the ones that are there.
    pub fn merge(&mut self, other: &Self) {
        self.roles.extend(other.roles.iter().map(|(role, name)| (*role, name.clone())));
        let toes = [(&mut self.left_toe, &other.left_toe), (&mut self.right_toe, &other.right_toe)];
        for (toe, other) in toes.into_iter().filter(|(_, other)| other.is_some()) {
            toe.clone_from(other);
        }
    }

    /// Returns the named joints' indices: those of roles, and the toes (left, right).
    pub(crate) fn joints(&self, names: &[String]) -> Result<RolesAndToes, String> {
        let named = |name: &String| {
            let joint = names.iter().position(|n| n == name);
            joint.ok_or_else(|| {
                format!("the correspondence names joint '{name}', but there are only: {}", names.join(", "))
            })
        };
        let roles = self.roles.iter().map(|(role, name)| Ok((*role, named(name)?))).collect::<Result<_, String>>()?;
        let toe = |name: &Option<String>| name.as_ref().map(named).transpose();
        Ok((roles, [toe(&self.left_toe)?, toe(&self.right_toe)?]))
    }
}

/// Reads `left_thigh=LeftUpLeg,left_toe=LeftToeBase,...`.
impl FromStr for Correspondence {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut table = toml::Table::new();
        let mut joints = toml::Table::new();
        for pair in text.split(',') {
            let (role, name) = pair.split_once('=').ok_or_else(|| format!("expected ROLE=JOINT,..., got '{pair}'"))?;
            let (role, name) = (role.trim().to_owned(), toml::Value::from(name.trim()));
            let joints = if role.ends_with("_toe") { &mut table } else { &mut joints };
            joints.insert(role, name);
        }
        table.insert("roles".into(), joints.into());
        table.try_into().map_err(|e: toml::de::Error| e.message().to_owned())
    }
}

/// Says that a leg is missing, and how to name its joints.
fn no_leg(side: &str, names: &[String]) -> String {
    format!(
        "no {side} leg (hip, knee, ankle) among the joints: {}. Name both legs: \
         --roles left_thigh=JOINT,left_shank=JOINT,left_foot=JOINT,right_thigh=JOINT,right_shank=JOINT,right_foot=JOINT",
        names.join(", ")
    )
}

/// The roles of a source skeleton, as joint indices.
#[derive(Debug, Clone, PartialEq)]
pub struct SourceRoles {
    /// Joint of each role.
    pub joints: BTreeMap<Role, usize>,
    /// Joints at the balls of the feet (left, right), where there are any.
    pub toes: [Option<usize>; 2],
}

impl SourceRoles {
    /// Guesses the roles of a clip's skeleton and applies the overrides.
    ///
    /// # Errors
    /// [`MotionError::Unfit`] when an override names no joint, or when there are no two legs: without them nothing can
    /// be retargeted.
    pub fn guess(clip: &SourceClip, overrides: &Correspondence) -> Result<Self, MotionError> {
        let skeleton = &clip.skeleton;
        let unfit = |message: String| MotionError::Unfit { clip: clip.name.clone(), message };
        let (given, toes) = overrides.joints(&skeleton.names).map_err(unfit)?;
        let mut found = roles::find(skeleton.tree(), &given);
        if found.unsided && skeleton.is_mirrored(&found) {
            found.mirror();
        }
        for (toe, given) in found.toes.iter_mut().zip(toes) {
            *toe = given.or(*toe);
        }
        for (side, leg) in ["left", "right"].into_iter().zip(roles::LEGS) {
            if !found.limb(leg).is_some_and(|leg| roles::goes_outwards(&skeleton.parents, &leg)) {
                return Err(unfit(no_leg(side, &skeleton.names)));
            }
        }
        // An arm that is not a chain, or lacks a joint, is no arm.
        for arm in roles::ARMS {
            if !found.limb(arm).is_some_and(|arm| roles::goes_outwards(&skeleton.parents, &arm)) {
                arm.iter().for_each(|role| {
                    found.joints.remove(role);
                });
            }
        }
        Ok(Self { joints: found.joints, toes: found.toes })
    }

    /// Returns the joint of a role.
    pub fn get(&self, role: Role) -> Option<usize> {
        self.joints.get(&role).copied()
    }
}

#[cfg(test)]
mod tests;
