//! Findings in a clip, and those that rule it out.

/// Kind of finding in a clip.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Nothing touches the ground, and the centre of mass does not fall freely: it climbs, sits or hangs on what is not
    /// there. Measured by what is missing to free fall (m/s²).
    Unsupported,
    /// The force would have to act outside of what touches the ground. Measured by how far (m).
    Unbalanced,
    /// The ground would have to be rougher. Measured by the friction coefficient needed.
    Slipping,
    /// A joint is faster than its actuator. Measured as a share of the largest speed.
    TooFast,
    /// Something else than a sole is on the ground: the clip lies, rolls or crawls. Measured by how low it is below the
    /// height at which things touch (m).
    OtherParts,
    /// Something is in the ground. Measured by how deep (m).
    Underground,
    /// A joint is beyond its range. Measured by how far (rad or m).
    OutOfRange,
    /// A joint jumps, as an angle does that is kept within one turn. Measured from one frame to the next (rad or m).
    Jumping,
    /// The root goes backwards with its orientation as it is, and forwards with the quaternion's parts in the order
    /// `x y z w`. Measured by the share of the way.
    QuaternionOrder,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Unsupported,
        Self::Unbalanced,
        Self::Slipping,
        Self::TooFast,
        Self::OtherParts,
        Self::Underground,
        Self::OutOfRange,
        Self::Jumping,
        Self::QuaternionOrder,
    ];

    /// Returns the limit beyond which a frame counts.
    pub fn limit(self) -> f64 {
        match self {
            // A third of gravity. A jump shrunk onto a robot half as tall falls half as fast, which no body does and this
            // finds; the smoothing blends so much into the short flights of running.
            Self::Unsupported => 3.0,
            // Half the width of a foot of our robots: a body leans that far to one side of where its reference is.
            Self::Unbalanced => 0.05,
            // Rubber on a dry floor holds this much, and our robots' soles a little less.
            Self::Slipping => 1.0,
            Self::TooFast => 1.0,
            // What touches is told by `touch::TOUCH`; any depth counts.
            Self::OtherParts => 0.0,
            // Soft soles and captured feet are some millimetres deep now and then.
            Self::Underground => 0.03,
            // Calibrations of captures and other models of a robot differ by a few degrees.
            Self::OutOfRange => 0.1,
            // No joint turns by this much from one frame to the next, at any usual rate.
            Self::Jumping => 2.0,
            Self::QuaternionOrder => 0.8,
        }
    }

    /// Returns a stretch of at least this length (s) rules a clip out; shorter ones are told.
    pub fn patience(self) -> f64 {
        match self {
            // Free fall for so long goes 11 cm down: more than a leg can make up for.
            Self::Unsupported => 0.15,
            // A body that is let fall from upright for this long is hardly tilted (a tenth of a radian at 0.4 m); one that
            // falls for longer must step.
            Self::Unbalanced => 0.4,
            Self::Slipping => 0.15,
            Self::TooFast => 0.05,
            // A stumble or a pat on the ground is no crawl.
            Self::OtherParts => 0.15,
            Self::Underground => 0.15,
            Self::OutOfRange => 0.15,
            Self::Jumping => 0.0,
            // People do walk backwards: told, and no reason by itself.
            Self::QuaternionOrder => f64::INFINITY,
        }
    }

    /// Returns the words before the numbers.
    pub fn words(self) -> &'static str {
        match self {
            Self::Unsupported => "held up by nothing",
            Self::Unbalanced => "support needed outside of the feet",
            Self::Slipping => "slips",
            Self::TooFast => "faster than the actuator",
            Self::OtherParts => "not only the soles on the ground",
            Self::Underground => "in the ground",
            Self::OutOfRange => "beyond its range",
            Self::Jumping => "jumps",
            Self::QuaternionOrder => "goes backwards, forwards if its quaternions are x y z w",
        }
    }

    /// Returns the unit of the measure; empty where it has none.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Unsupported => "m/s²",
            Self::Unbalanced | Self::OtherParts | Self::Underground => "m",
            Self::Slipping | Self::TooFast | Self::QuaternionOrder => "",
            Self::OutOfRange | Self::Jumping => "rad or m",
        }
    }
}

/// A stretch of a clip in which one thing is wrong.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Finding {
    /// Kind of finding.
    pub kind: Kind,
    /// The joint or body, where it is one.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub part: String,
    /// First frame of the stretch (s).
    pub from: f64,
    /// Its length (s): frames over rate.
    pub seconds: f64,
    /// The worst of it, in the unit of the kind.
    pub worst: f64,
}

impl Finding {
    /// Returns whether it rules the clip out by itself.
    pub fn rules_out(&self) -> bool {
        // Lengths are multiples of a frame; a patience of the same length is one.
        self.seconds >= self.kind.patience() - 1e-9
    }

    /// Returns a sentence.
    pub fn words(&self) -> String {
        let part = if self.part.is_empty() { String::new() } else { format!(" ({})", self.part) };
        let worst = match self.kind {
            Kind::Unsupported => format!("{:.1} m/s² off free fall", self.worst),
            Kind::Unbalanced => format!("by {:.2} m", self.worst),
            Kind::Slipping => format!("needs a friction of {:.1}", self.worst),
            Kind::TooFast => format!("{:.1} times its largest speed", self.worst),
            Kind::OtherParts | Kind::Underground => format!("{:.2} m", self.worst),
            Kind::OutOfRange => format!("by {:.2} rad", self.worst),
            Kind::Jumping => format!("by {:.2} rad from one frame to the next", self.worst),
            Kind::QuaternionOrder => format!("{:.0}% of the way", 100.0 * self.worst),
        };
        format!("{}{part} for {:.2} s from {:.2} s: {worst}", self.kind.words(), self.seconds, self.from)
    }
}

/// Findings in a clip.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Feasibility {
    /// The clip.
    pub clip: String,
    /// Its length (s).
    pub seconds: f64,
    /// Nothing rules it out.
    pub trackable: bool,
    /// Everything found, the longest first.
    pub findings: Vec<Finding>,
}

impl Feasibility {
    /// Returns the findings that rule the clip out.
    pub fn reasons(&self) -> impl Iterator<Item = &Finding> {
        self.findings.iter().filter(|f| f.rules_out())
    }

    /// Returns the findings within `margin` seconds of an instant (s).
    pub fn around(&self, second: f64, margin: f64) -> impl Iterator<Item = &Finding> {
        self.findings.iter().filter(move |f| f.from <= second + margin && f.from + f.seconds >= second - margin)
    }
}
