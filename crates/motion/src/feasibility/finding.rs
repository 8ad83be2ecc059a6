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
    /// A joint turns by half a turn or more from one frame to the next, faster than its actuator: an angle that was
    /// wrapped, or frames that do not belong together. Measured by how far (rad).
    Jump,
    /// A joint leaves its path for a single frame: a lost marker, or a damaged file. Measured by how far (rad or m).
    Spike,
    /// A joint is out of its range. Measured by how far (rad or m).
    BeyondRange,
    /// Something else than a sole is on the ground: the clip lies, rolls or crawls. Measured by how low it is below the
    /// height at which things touch (m).
    OtherParts,
    /// Something is in the ground. Measured by how deep (m).
    Underground,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Unsupported,
        Self::Unbalanced,
        Self::Slipping,
        Self::TooFast,
        Self::Jump,
        Self::Spike,
        Self::BeyondRange,
        Self::OtherParts,
        Self::Underground,
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
            Self::Jump => std::f64::consts::PI,
            // Six degrees within one frame and back; the path around it says whether the joint moves so.
            Self::Spike => 0.1,
            // Limits of simulators and gears give in by some hundredths of a radian under load, so a recorded motion is
            // beyond them now and then.
            Self::BeyondRange => 0.1,
            // What touches is told by `touch::TOUCH`; any depth counts.
            Self::OtherParts => 0.0,
            // Soft soles and captured feet are some millimetres deep now and then.
            Self::Underground => 0.03,
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
            // One frame is too many.
            Self::Jump | Self::Spike => 0.0,
            Self::BeyondRange => 0.15,
            // A stumble or a pat on the ground is no crawl.
            Self::OtherParts => 0.15,
            Self::Underground => 0.15,
        }
    }

    /// Returns the words before the numbers.
    pub fn words(self) -> &'static str {
        match self {
            Self::Unsupported => "held up by nothing",
            Self::Unbalanced => "support needed outside of the feet",
            Self::Slipping => "slips",
            Self::TooFast => "faster than the actuator",
            Self::Jump => "jumps",
            Self::Spike => "leaves its path for one frame",
            Self::BeyondRange => "beyond the range",
            Self::OtherParts => "not only the soles on the ground",
            Self::Underground => "in the ground",
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
            Kind::Jump | Kind::Spike | Kind::BeyondRange => format!("by {:.2} rad", self.worst),
            Kind::OtherParts | Kind::Underground => format!("{:.2} m", self.worst),
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
