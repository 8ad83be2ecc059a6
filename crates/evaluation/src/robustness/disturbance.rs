//! Kinds of disturbances and their sizes.

use lifelike_character::Role;
use lifelike_robot::Robot;

/// Which bodies are pushed (thesis 4.2.2 pushes "root, head, hands, and feet").
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Part {
    /// The floating base.
    Root,
    /// The head.
    Head,
    /// Either hand.
    Hands,
    /// Either foot.
    Feet,
}

impl Part {
    /// The robot's bodies of this part; none where it lacks them.
    pub fn bodies(self, robot: &Robot) -> Vec<usize> {
        let roles: &[Role] = match self {
            Self::Root => return robot.character.root_joint().map(|joint| joint.body).into_iter().collect(),
            Self::Head => &[Role::Head],
            Self::Hands => &[Role::LeftHand, Role::RightHand],
            Self::Feet => &[Role::LeftFoot, Role::RightFoot],
        };
        roles.iter().filter_map(|role| robot.anatomy.places.get(role)).map(|place| place.body).collect()
    }
}

/// One kind of disturbance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Disturbance {
    /// Horizontal pushes.
    Push(Part),
    /// Short punches at random bodies from any direction, harder and harder.
    Punches,
    /// Another sliding friction of the ground.
    Friction,
    /// All masses and inertias times a factor.
    Mass,
    /// Encoders that are off.
    Calibration,
    /// Hills that no policy of ours was trained on.
    Hills,
    /// A reference that climbs stairs in the air, over level ground.
    Stairs,
    /// A reference that jumps from clip to clip.
    Switches,
}

/// Forces of pushes, in units of the weight.
const PUSHES: [f64; 14] = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.5, 2.0, 3.0, 5.0, 8.0];

impl Disturbance {
    /// All of them, in the order in which they are reported.
    pub const ALL: [Self; 11] = [
        Self::Push(Part::Root),
        Self::Push(Part::Head),
        Self::Push(Part::Hands),
        Self::Push(Part::Feet),
        Self::Punches,
        Self::Friction,
        Self::Mass,
        Self::Calibration,
        Self::Hills,
        Self::Stairs,
        Self::Switches,
    ];

    /// A short name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Push(Part::Root) => "push root",
            Self::Push(Part::Head) => "push head",
            Self::Push(Part::Hands) => "push hands",
            Self::Push(Part::Feet) => "push feet",
            Self::Punches => "punches",
            Self::Friction => "friction",
            Self::Mass => "mass",
            Self::Calibration => "calibration",
            Self::Hills => "hills",
            Self::Stairs => "stairs in the air",
            Self::Switches => "switches",
        }
    }

    /// Returns the unit of its size.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Push(_) | Self::Punches => "body weights",
            Self::Friction => "coefficient",
            Self::Mass => "factor",
            Self::Calibration => "rad",
            Self::Hills => "m high",
            Self::Stairs => "m a step",
            Self::Switches => "per second",
        }
    }

    /// Returns a description of the disturbance, a sentence.
    pub fn words(self) -> &'static str {
        match self {
            Self::Push(_) => {
                "every two seconds (in shorter episodes once in the first half) a horizontal force at the body's centre of mass, \
                                for 0.1 to 0.2 s"
            }
            Self::Punches => {
                "every five seconds a force for 0.08 s at a random joint's body, from any direction; the largest grows from a third of the \
                 size to all of it within 60 s, and each is half to all of the largest"
            }
            Self::Friction => "sliding friction of the ground",
            Self::Mass => "mass and inertia of every body times the factor; the actuators stay",
            Self::Calibration => "each joint's encoder off by a random angle of at most this size",
            Self::Hills => "hills of at most this height, wavelengths from 0.75 to 3 m; the policy cannot see them",
            Self::Stairs => "the reference rises by a step at every footfall; the ground stays level",
            Self::Switches => "the reference jumps to a random frame of a random clip, without a transition",
        }
    }

    /// Sizes from the mildest to the hardest where there is such an order. `few` for a quick look.
    pub fn sizes(self, few: bool) -> Vec<f64> {
        let (all, some): (&[f64], &[f64]) = match self {
            Self::Push(_) | Self::Punches => (&PUSHES, &[0.0, 0.3, 1.0]),
            Self::Friction => (&[1.0, 0.8, 0.6, 0.5, 0.4, 0.3, 0.2], &[0.8, 0.4, 0.2]),
            Self::Mass => (&[0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3], &[0.7, 1.0, 1.3]),
            Self::Calibration => (&[0.0, 0.025, 0.05, 0.1, 0.15, 0.2, 0.3], &[0.0, 0.05, 0.2]),
            Self::Hills => (&[0.0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6], &[0.0, 0.1, 0.3]),
            Self::Stairs => (&[0.0, 0.02, 0.05, 0.1, 0.15, 0.2, 0.3], &[0.0, 0.05, 0.2]),
            Self::Switches => (&[0.0, 0.2, 0.5, 1.0, 2.0, 4.0], &[0.0, 0.5, 2.0]),
        };
        if few { some.to_vec() } else { all.to_vec() }
    }

    /// Returns true where every size is harder than the one before it: the curve may stop where nothing survives.
    pub fn grows(self) -> bool {
        self != Self::Mass
    }
}
