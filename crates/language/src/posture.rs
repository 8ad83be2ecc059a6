//! Postures: where limbs go, and how long they stay there, in the figure of keyframed texts.

use serde::{Deserialize, Serialize};

use crate::facts::Side;
use crate::touch::Touch;

/// Angle from which an arm is away from the body (degrees).
const AWAY: f64 = 30.0;
/// Hold from which it was asked for (s).
const HELD: f64 = 1.95;
/// Angle from which an elbow is bent (degrees).
const BENT: f64 = 40.0;
/// Largest angle (degrees), place of a foot (m) and hold (s).
const MOST_DEGREES: f64 = 180.0;
const MOST_WAY: f64 = 0.6;
const MOST_HOLD: f64 = 120.0;

/// A posture: the parts of the body that it moves. Every other part stays where the posture before left it.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Posture {
    /// Left and right arm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub left_arm: Option<Arm>,
    /// Right arm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub right_arm: Option<Arm>,
    /// Head, seen from the chest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub head: Option<Turn>,
    /// Trunk.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trunk: Option<Turn>,
    /// Left foot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub left_foot: Option<Foot>,
    /// Right foot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub right_foot: Option<Foot>,
    /// Depth to which bent knees lower the pelvis (m, of the keyframed figure).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sink: Option<f64>,
    /// Place that the hands touch.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub touches: Option<Touch>,
    /// Place that the left hand touches, where the right one touches another.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub left_touches: Option<Touch>,
    /// Duration of the hold (s).
    pub hold: f64,
    /// Duration of the way there (s); the usual one where nothing is said.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub way: Option<f64>,
    /// True for a movement that takes its time.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub slow: bool,
}

/// Angles of an arm (degrees), as in a keyframed text.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Arm {
    /// Lift ahead; below 0 it goes back.
    pub raise: f64,
    /// Lift to its own side.
    pub aside: f64,
    /// Turn about its own length, inward.
    #[serde(default)]
    pub turn: f64,
    /// Bend of the elbow.
    pub elbow: f64,
}

impl Arm {
    /// The arm of somebody who stands.
    pub const HANGING: Self = Self { raise: 0.0, aside: 8.0, turn: 0.0, elbow: 15.0 };

    /// Returns the angle of the upper arm from hanging down (degrees): that of the direction which `raise` and then `aside`
    /// give it.
    pub fn elevation(&self) -> f64 {
        (self.raise.to_radians().cos() * self.aside.to_radians().cos()).clamp(-1.0, 1.0).acos().to_degrees()
    }

    /// Returns the arm in words.
    fn words(&self) -> String {
        let lifted = self.elevation();
        let way = match () {
            () if self.raise < -AWAY => "behind",
            () if self.aside > AWAY && self.aside >= self.raise => "to the side",
            () if self.raise > 140.0 => "up",
            () if self.raise > AWAY => "ahead",
            () => "down",
        };
        let degrees = if way == "down" { String::new() } else { format!(" {lifted:.0} degrees") };
        let elbow = if self.elbow > BENT { format!(", elbow bent {:.0}", self.elbow) } else { String::new() };
        let forearm = match self.aside > 80.0 && (70.0..110.0).contains(&self.elbow) {
            true if self.turn > BENT => ", forearm down",
            true if self.turn < -BENT => ", forearm up",
            _ => "",
        };
        format!("{way}{degrees}{elbow}{forearm}")
    }
}

/// Rotation of head or trunk (degrees).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Turn {
    /// Forward is positive.
    pub pitch: f64,
    /// To the right is positive.
    pub roll: f64,
    /// To the left is positive.
    pub yaw: f64,
}

impl Turn {
    /// Returns the rotation in words.
    fn words(&self) -> String {
        let ways = [
            (self.pitch, "forward", "back"),
            (self.roll, "to the right", "to the left"),
            (self.yaw, "turned left", "turned right"),
        ];
        let said = ways.iter().filter(|(angle, ..)| angle.abs() > 1.0);
        let all: Vec<String> = said
            .map(|(angle, plus, minus)| format!("{} {:.0}", if *angle > 0.0 { plus } else { minus }, angle.abs()))
            .collect();
        if all.is_empty() { "straight".into() } else { all.join(", ") }
    }
}

/// Place of a foot.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Foot {
    /// Way from where it stands, ahead and to the left (m, of the keyframed figure).
    pub to: [f64; 2],
    /// Height (m); 0 on the ground.
    pub height: f64,
}

impl Foot {
    /// The foot where it stands.
    pub const STANDING: Self = Self { to: [0.0, 0.0], height: 0.0 };

    /// Returns the place in words.
    fn words(&self) -> String {
        let [ahead, left] = self.to;
        let way = match () {
            () if left.abs() > 0.08 => " to the side",
            () if ahead > 0.2 => " ahead",
            () if ahead < -0.1 => " behind",
            () => "",
        };
        match self.height > 0.0 {
            true => format!("up{way}"),
            false if way.is_empty() => "down".into(),
            false => format!("on the ground{way}"),
        }
    }
}

impl Posture {
    /// Returns the posture with feet and trunk a share of the way, which are easier to stand in.
    #[must_use]
    pub fn gentler(&self, share: f64) -> Self {
        let less = |turn: Turn| Turn { pitch: share * turn.pitch, roll: share * turn.roll, yaw: share * turn.yaw };
        let nearer = |foot: Foot| Foot { to: foot.to.map(|way| share * way), height: share * foot.height };
        let slower = self.way.map(|way| way / share);
        Self {
            trunk: self.trunk.map(less),
            left_foot: self.left_foot.map(nearer),
            right_foot: self.right_foot.map(nearer),
            way: slower,
            slow: true,
            ..self.clone()
        }
    }

    /// Returns an arm's place in the posture.
    pub fn arm(&mut self, side: Side) -> [Option<&mut Option<Arm>>; 2] {
        [(side != Side::Right).then_some(&mut self.left_arm), (side != Side::Left).then_some(&mut self.right_arm)]
    }

    /// Returns whether it moves nothing.
    pub fn is_empty(&self) -> bool {
        let Self { left_arm, right_arm, head, trunk, left_foot, right_foot, sink, .. } = self;
        left_arm.is_none()
            && right_arm.is_none()
            && head.is_none()
            && trunk.is_none()
            && left_foot.is_none()
            && right_foot.is_none()
            && sink.is_none()
    }

    /// Returns whether it moves an arm and a foot, or both arms each its own way: what no single verb does.
    pub fn is_combined(&self) -> bool {
        let arms = [self.left_arm, self.right_arm];
        let feet = self.left_foot.is_some() || self.right_foot.is_some();
        arms.iter().any(Option::is_some) && feet || arms.iter().all(Option::is_some) && arms[0] != arms[1]
    }

    /// Returns whether it moves arms and nothing else.
    pub fn moves_only_arms(&self) -> bool {
        let arms = Self { left_arm: None, right_arm: None, ..self.clone() };
        !self.is_empty() && arms.is_empty()
    }

    /// Returns whether it moves something, and no foot.
    pub fn leaves_feet(&self) -> bool {
        !self.is_empty() && self.left_foot.is_none() && self.right_foot.is_none()
    }

    /// Returns whether it leans the trunk forward and does nothing else.
    pub fn is_lean(&self) -> bool {
        let rest = Self { trunk: None, ..self.clone() };
        self.trunk.is_some_and(|turn| turn.pitch > 0.0) && rest.is_empty()
    }

    /// Adds the parts of another posture, which replace its own.
    pub fn extend(&mut self, other: &Self) {
        let only =
            |posture: &Self, left: bool| posture.left_arm.is_some() == left && posture.right_arm.is_some() != left;
        let (left, right) = match () {
            () if only(self, true) && only(other, false) => (self.touches, other.touches),
            () if only(self, false) && only(other, true) => (other.touches, self.touches),
            () => (None, None),
        };
        self.left_arm = other.left_arm.or(self.left_arm);
        self.right_arm = other.right_arm.or(self.right_arm);
        self.head = other.head.or(self.head);
        self.trunk = other.trunk.or(self.trunk);
        self.left_foot = other.left_foot.or(self.left_foot);
        self.right_foot = other.right_foot.or(self.right_foot);
        self.sink = other.sink.or(self.sink);
        let moves_arms = other.left_arm.is_some() || other.right_arm.is_some();
        self.left_touches = if moves_arms { None } else { self.left_touches };
        self.touches = other.touches.or(self.touches);
        if left.is_some() && right.is_some() && left != right {
            (self.left_touches, self.touches) = (left, right);
        }
        self.hold = self.hold.max(other.hold);
        self.way = other.way.or(self.way);
        self.slow |= other.slow;
    }

    /// Returns whether a foot is up.
    pub(crate) fn is_on_one_foot(&self) -> bool {
        self.left_foot.iter().chain(&self.right_foot).any(|foot| foot.height > 0.0)
    }

    /// Returns whether another posture moves a part that this one moves, too, or both need the other foot.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.is_on_one_foot() && other.is_on_one_foot()
            || self.left_arm.is_some() && other.left_arm.is_some()
            || self.right_arm.is_some() && other.right_arm.is_some()
            || self.head.is_some() && other.head.is_some()
            || self.trunk.is_some() && other.trunk.is_some()
            || self.left_foot.is_some() && other.left_foot.is_some()
            || self.right_foot.is_some() && other.right_foot.is_some()
    }

    /// Checks the numbers of a posture that a person wrote.
    ///
    /// # Errors
    /// The number that is out of range, with the range.
    pub fn check(&self) -> Result<(), String> {
        let within = |what: &str, value: f64, most: f64| match value.abs() <= most {
            true => Ok(()),
            false => Err(format!("expected {what} of a posture from {} to {most}, got {value}", -most)),
        };
        for arm in self.left_arm.iter().chain(&self.right_arm) {
            for angle in [arm.raise, arm.aside, arm.turn, arm.elbow] {
                within("an angle", angle, MOST_DEGREES)?;
            }
        }
        for turn in self.head.iter().chain(&self.trunk) {
            for angle in [turn.pitch, turn.roll, turn.yaw] {
                within("an angle", angle, 0.5 * MOST_DEGREES)?;
            }
        }
        for foot in self.left_foot.iter().chain(&self.right_foot) {
            for way in [foot.to[0], foot.to[1], foot.height] {
                within("a foot's way", way, MOST_WAY)?;
            }
        }
        within("the depth", self.sink.unwrap_or(0.0), MOST_WAY)?;
        within("the way", self.way.unwrap_or(0.0), MOST_HOLD)?;
        within("the hold", self.hold, MOST_HOLD)
    }

    /// Returns the posture in words: `left arm up 165 degrees, held 3 s`.
    pub fn words(&self) -> String {
        let mut all = Vec::new();
        match (self.left_arm, self.right_arm) {
            (Some(left), Some(right)) if left == right => all.push(format!("both arms {}", left.words())),
            (left, right) => {
                all.extend(left.map(|arm| format!("left arm {}", arm.words())));
                all.extend(right.map(|arm| format!("right arm {}", arm.words())));
            }
        }
        let hand = if self.left_touches.is_some() { "right hand " } else { "" };
        all.extend(self.left_touches.map(|touch| format!("left hand touching the {}", touch.words())));
        all.extend(self.touches.map(|touch| format!("{hand}touching the {}", touch.words())));
        all.extend(self.head.map(|turn| format!("head {}", turn.words())));
        all.extend(self.trunk.map(|turn| format!("trunk {}", turn.words())));
        all.extend(self.left_foot.map(|foot| format!("left foot {}", foot.words())));
        all.extend(self.right_foot.map(|foot| format!("right foot {}", foot.words())));
        all.extend(
            self.sink
                .filter(|sink| *sink > 0.0)
                .map(|sink| if sink > 0.1 { "knees bent" } else { "knees a little bent" }.to_string()),
        );
        all.extend(self.way.map(|way| format!("{way} s to get there")));
        if self.hold >= HELD {
            all.push(format!("held {} s", self.hold));
        }
        all.join(", ")
    }
}
