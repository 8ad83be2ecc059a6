//! Facts of a sentence: what it promises about a motion, in a form that can be checked on a clip.

use serde::{Deserialize, Serialize};

/// A side of the body, or of the way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// The left one.
    Left,
    /// The right one.
    Right,
    /// Both at once.
    Both,
}

impl Side {
    /// Returns the side in a mirror.
    pub fn mirrored(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Right => Self::Left,
            Self::Both => Self::Both,
        }
    }

    /// Returns the word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
            Self::Both => "both",
        }
    }
}

/// A direction over the ground, in the heading frame of the first frame; of a turn: left is counterclockwise from
/// above.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// Ahead.
    Forward,
    /// Back.
    Backward,
    /// To the left.
    Left,
    /// To the right.
    Right,
    /// On the spot.
    InPlace,
}

impl Direction {
    /// Returns the direction in a mirror.
    pub fn mirrored(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Right => Self::Left,
            other => other,
        }
    }
}

/// A class of speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Speed {
    /// At most 0.8 of the robot's own normal tempo.
    Slow,
    /// At least 1.25 times the normal tempo.
    Fast,
}

/// A class of amplitude.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Size {
    /// At most 0.8 of the normal amplitude.
    Small,
    /// At least 1.25 times the normal amplitude; of steps 1.12, as legs end.
    Big,
}

/// A mood, by posture, tempo and size.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mood {
    /// Slumped, the head down.
    Sad,
    /// Upright, the head up.
    Proud,
    /// Faster and larger, leaning ahead.
    Angry,
    /// Faster and larger, the head up.
    Happy,
    /// Slower and smaller, the head down.
    Tired,
    /// Smaller, ducked, looking to both sides.
    Afraid,
    /// Slower and larger, the arms a little aside.
    Graceful,
    /// Bent forward, slow and small.
    Frail,
}

/// Changes of a motion that show a mood.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Manner {
    /// Factor of the speed.
    pub speed: f64,
    /// Factor of the amplitude.
    pub size: f64,
    /// Factor of the lift of arms.
    pub lift: f64,
    /// Pitch of the chest (degrees, ahead is positive).
    pub chest: f64,
    /// Pitch of the head (degrees, down is positive).
    pub head: f64,
    /// Arms that the action leaves free: raised ahead, aside and bent by so much (degrees).
    pub arms: [f64; 3],
    /// Yaw of a head that looks to both sides again and again (degrees).
    pub glances: f64,
}

impl Mood {
    /// Returns the word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Sad => "sad",
            Self::Proud => "proud",
            Self::Angry => "angry",
            Self::Happy => "happy",
            Self::Tired => "tired",
            Self::Afraid => "afraid",
            Self::Graceful => "graceful",
            Self::Frail => "frail",
        }
    }

    /// Returns the changes that show it.
    pub fn manner(self) -> Manner {
        match self {
            Self::Sad => manner([0.82, 0.9, 0.85], [11.0, 18.0], [8.0, -4.0, 0.0], 0.0),
            Self::Proud => manner([1.0, 1.15, 1.05], [-6.0, -12.0], [-8.0, 20.0, 48.0], 0.0),
            Self::Angry => manner([1.35, 1.2, 1.05], [7.0, 10.0], [4.0, 14.0, 60.0], 0.0),
            Self::Happy => manner([1.28, 1.3, 1.08], [-4.0, -10.0], [10.0, 22.0, 55.0], 0.0),
            Self::Tired => manner([0.68, 0.8, 0.85], [11.0, 18.0], [14.0, -4.0, -8.0], 0.0),
            Self::Afraid => manner([0.88, 0.62, 0.72], [9.0, 13.0], [30.0, -6.0, 80.0], 28.0),
            Self::Graceful => manner([0.75, 1.15, 1.05], [-3.0, -10.0], [4.0, 26.0, 18.0], 0.0),
            Self::Frail => manner([0.6, 0.62, 0.72], [32.0, -4.0], [28.0, 2.0, 40.0], 0.0),
        }
    }
}

/// Returns a manner of speed, size and lift, of the pitch of chest and head, of free arms, and of glances.
fn manner([speed, size, lift]: [f64; 3], [chest, head]: [f64; 2], arms: [f64; 3], glances: f64) -> Manner {
    Manner { speed, size, lift, chest, head, arms, glances }
}

/// Normal values of one action on one robot.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Nominal {
    /// Tempo: duration of one repetition or of the whole action (s), or for a walk its pace (m/s).
    pub tempo: f64,
    /// Range of the action's signal (m or rad).
    pub amplitude: f64,
    /// Pitch of the head (rad, down is positive), mean over the middle of the clip.
    pub head_pitch: f64,
}

/// One action of a sentence, with what is said of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Action {
    /// The verb, by its name in the grammar.
    pub verb: String,
    /// The acting limb's side.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub side: Option<Side>,
    /// The direction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<Direction>,
    /// The number of repetitions or steps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub count: Option<u32>,
    /// The angle of a turn (degrees, positive).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub degrees: Option<u32>,
    /// The way over the ground (m).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub metres: Option<f64>,
    /// The class of speed; normal where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed: Option<Speed>,
    /// The class of amplitude; normal where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<Size>,
    /// The mood.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mood: Option<Mood>,
    /// Values that speed, size and mood are relative to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nominal: Option<Nominal>,
}

impl Action {
    /// Returns an action of which nothing is said.
    pub fn of(verb: &str) -> Self {
        Self {
            verb: verb.into(),
            side: None,
            direction: None,
            count: None,
            degrees: None,
            metres: None,
            speed: None,
            size: None,
            mood: None,
            nominal: None,
        }
    }

    /// Returns the action in a mirror.
    pub fn mirrored(&self) -> Self {
        Self { side: self.side.map(Side::mirrored), direction: self.direction.map(Direction::mirrored), ..self.clone() }
    }

    /// Returns a text that is the same for all draws of this combination.
    pub fn key(&self) -> String {
        let rest = (self.direction, self.count, self.degrees, self.speed, self.size, self.mood);
        format!("{} {:?} {rest:?}", self.verb, self.side)
    }
}

/// Relation of the actions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Relation {
    /// There is one action.
    Single,
    /// The second follows the first.
    Then,
    /// The first is done by the arms during the second.
    While,
}

/// Reason for which an entry is held out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HeldOut {
    /// Its combination is never trained on; its words are.
    Combination,
    /// Its words are never trained on; its combination is.
    Words,
}

/// Promises of a sentence.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// Relation of the actions.
    pub relation: Relation,
    /// One action, or two.
    pub actions: Vec<Action>,
    /// Why it is held out, if it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held_out: Option<HeldOut>,
}

impl Facts {
    /// Returns the facts of the mirrored motion.
    pub fn mirrored(&self) -> Self {
        Self { actions: self.actions.iter().map(Action::mirrored).collect(), ..self.clone() }
    }
}
