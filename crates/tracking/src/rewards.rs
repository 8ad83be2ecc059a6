//! What a tracker is rewarded for: one small pure function per term.
//!
//! Two families, as data: the thesis' weighted squares of normalised errors (eqs. 4.5-4.8), and the exponentials of
//! Peng et al. 2018 in the form that learned to walk in minutes on two cores. Both see the same [`Errors`].

use lifelike_motion::FeatureLayout;

/// Names of the terms, in the order of [`Terms`].
pub const TERMS: [&str; 12] = [
    "height",
    "orientation",
    "velocity",
    "joint_position",
    "joint_velocity",
    "effectors",
    "alive",
    "heading",
    "path",
    "action_rate",
    "action_acceleration",
    "torque",
];

/// Where the penalties of actions and torques are among [`TERMS`].
pub const SMOOTHNESS: std::ops::Range<usize> = 9..12;

/// The value of each term of [`TERMS`], weighted; their sum is the reward.
pub type Terms = [f32; TERMS.len()];

/// Differences between a simulated state and its reference: simulation less reference.
#[derive(Debug, Clone, Copy)]
pub struct Errors<'a> {
    /// Where the parts of the features lie.
    pub layout: &'a FeatureLayout,
    /// Features of the simulated state (eq. 4.1) in its own heading frame.
    pub simulated: &'a [f32],
    /// Features of the reference in ITS own heading frame.
    pub reference: &'a [f32],
    /// Heading against the anchored reference (rad, in −π..π).
    pub heading: f32,
    /// Position on the ground against the anchored reference (m).
    pub path: f32,
}

/// What the policy did: offsets of the joint targets from their base (rad), `[J]` each.
#[derive(Debug, Clone, Copy)]
pub struct Effort<'a> {
    /// Now.
    pub action: &'a [f32],
    /// One step ago.
    pub previous: &'a [f32],
    /// Two steps ago.
    pub before: &'a [f32],
    /// Σ τ² over the joints (N² m²).
    pub torque_squared: f32,
}

/// Weights of eqs. 4.6-4.8 (Table 4.1), and what makes them learnable with little data.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ThesisReward {
    /// c^h.
    pub height: f32,
    /// c^θ.
    pub orientation: f32,
    /// c^v.
    pub velocity: f32,
    /// c^q.
    pub joint_position: f32,
    /// c^q̇.
    pub joint_velocity: f32,
    /// c^p.
    pub effectors: f32,
    /// c^alive.
    pub alive: f32,
    /// c^Δa.
    pub action_rate: f32,
    /// c^Δ²a.
    pub action_acceleration: f32,
    /// c^τ.
    pub torque: f32,
    /// Weight of the squared heading error (rad²); not in the thesis, whose reward does not see where the robot goes.
    #[serde(default)]
    pub heading: f32,
    /// Weight of the squared position error on the ground (m²); likewise.
    #[serde(default)]
    pub path: f32,
    /// Factor on the whole reward: brings it near one, which the value function learns sooner.
    pub scale: f32,
    /// Each tracking term loses at most this (before `scale`); `inf` is the thesis.
    pub term_limit: f32,
    /// Smallest standard deviations that errors are divided by.
    pub floors: Floors,
}

/// Smallest standard deviations for normalising features: a data set of calm clips has tiny ones, whose squares punish
/// every movement out of proportion (`term_limit` and these floors made the thesis' form learn at all on few clips).
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Floors {
    /// Root height (m).
    pub height: f32,
    /// Root velocities (m/s and rad/s).
    pub velocity: f32,
    /// Joint positions (rad).
    pub joint_position: f32,
    /// Joint velocities (rad/s).
    pub joint_velocity: f32,
    /// End-effector positions (m).
    pub effectors: f32,
}

impl Floors {
    /// The divisor of every feature: the data's standard deviation, not below the floor; 1 for the orientation, which
    /// the thesis leaves as it is.
    pub fn apply(&self, layout: &FeatureLayout, deviation: &[f32]) -> Vec<f32> {
        let mut out = deviation.to_vec();
        out[FeatureLayout::HEIGHT] = out[FeatureLayout::HEIGHT].max(self.height);
        out[FeatureLayout::ORIENTATION].fill(1.0);
        let parts = [
            (FeatureLayout::VELOCITY, self.velocity),
            (layout.joint_positions(), self.joint_position),
            (layout.joint_velocities(), self.joint_velocity),
            (layout.effectors(), self.effectors),
        ];
        for (range, floor) in parts {
            out[range].iter_mut().for_each(|s| *s = s.max(floor));
        }
        out
    }
}

/// `weight · exp(−sharpness · error)`.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Kernel {
    /// Reward at no error.
    pub weight: f32,
    /// How fast it falls with the squared error.
    pub sharpness: f32,
}

impl Kernel {
    fn of(self, squared_error: f32) -> f32 {
        self.weight * (-self.sharpness * squared_error).exp()
    }
}

/// The exponential family. Errors over several joints or places are MEANS of squares, so the same numbers serve robots
/// with more or fewer of them.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExponentialReward {
    /// Of (m²).
    pub height: Kernel,
    /// Of ‖R − R'‖²_F, heading removed.
    pub orientation: Kernel,
    /// Of ‖Δv‖² + `angular_share` ‖Δω‖² (m²/s²).
    pub velocity: Kernel,
    /// What a squared angular velocity error counts against a linear one (m²).
    pub angular_share: f32,
    /// Of the mean over joints (rad²).
    pub joint_position: Kernel,
    /// Of the mean over joints (rad²/s²).
    pub joint_velocity: Kernel,
    /// Of the mean over end effectors of their squared distance (m²).
    pub effectors: Kernel,
    /// Of the squared heading error against the anchored reference (rad²).
    pub heading: Kernel,
    /// Of the squared distance on the ground from the anchored reference (m²).
    pub path: Kernel,
    /// Per step survived.
    pub alive: f32,
    /// Weight of Σ (Δa)² (1/rad²).
    pub action_rate: f32,
    /// Weight of Σ (Δ²a)² (1/rad²).
    pub action_acceleration: f32,
    /// Weight of Σ τ² (1/(N m)²).
    pub torque: f32,
}

/// One of the two families.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Reward {
    /// Eqs. 4.5-4.8.
    Thesis(ThesisReward),
    /// Exponentials of squared errors.
    Exponential(ExponentialReward),
}

impl Reward {
    /// All terms. `divisor` is [`Floors::apply`]'s (only the thesis' family reads it), `[F]`.
    pub fn terms(&self, errors: &Errors<'_>, effort: &Effort<'_>, divisor: &[f32]) -> Terms {
        match self {
            Self::Thesis(reward) => reward.terms(errors, effort, divisor),
            Self::Exponential(reward) => reward.terms(errors, effort),
        }
    }
}

impl ThesisReward {
    fn terms(&self, errors: &Errors<'_>, effort: &Effort<'_>, divisor: &[f32]) -> Terms {
        let (a, b, layout) = (errors.simulated, errors.reference, errors.layout);
        let square =
            |range: std::ops::Range<usize>| normalised_square(&a[range.clone()], &b[range.clone()], &divisor[range]);
        let track = |weight: f32, error: f32| -(weight * error).min(self.term_limit);
        [
            track(self.height, square(FeatureLayout::HEIGHT..FeatureLayout::HEIGHT + 1)),
            track(self.orientation, orientation_square(a, b)),
            track(self.velocity, square(FeatureLayout::VELOCITY)),
            track(self.joint_position, square(layout.joint_positions())),
            track(self.joint_velocity, square(layout.joint_velocities())),
            track(self.effectors, square(layout.effectors())),
            self.alive,
            track(self.heading, errors.heading * errors.heading),
            track(self.path, errors.path * errors.path),
            -self.action_rate * rate_square(effort),
            -self.action_acceleration * acceleration_square(effort),
            -self.torque * effort.torque_squared,
        ]
        .map(|term| term * self.scale)
    }
}

impl ExponentialReward {
    fn terms(&self, errors: &Errors<'_>, effort: &Effort<'_>) -> Terms {
        let (a, b, layout) = (errors.simulated, errors.reference, errors.layout);
        let square = |range: std::ops::Range<usize>| squared_distance(&a[range.clone()], &b[range]);
        let joints = layout.joints.len().max(1) as f32;
        let places = layout.end_effectors.len().max(1) as f32;
        let velocity = FeatureLayout::VELOCITY.start;
        let speed = square(velocity..velocity + 3) + self.angular_share * square(velocity + 3..velocity + 6);
        [
            self.height.of(square(FeatureLayout::HEIGHT..FeatureLayout::HEIGHT + 1)),
            self.orientation.of(orientation_square(a, b)),
            self.velocity.of(speed),
            self.joint_position.of(square(layout.joint_positions()) / joints),
            self.joint_velocity.of(square(layout.joint_velocities()) / joints),
            self.effectors.of(square(layout.effectors()) / places),
            self.alive,
            self.heading.of(errors.heading * errors.heading),
            self.path.of(errors.path * errors.path),
            -self.action_rate * rate_square(effort),
            -self.action_acceleration * acceleration_square(effort),
            -self.torque * effort.torque_squared,
        ]
    }
}

/// ‖x − y‖².
pub fn squared_distance(x: &[f32], y: &[f32]) -> f32 {
    x.iter().zip(y).map(|(x, y)| (x - y) * (x - y)).sum()
}

/// ‖(x − y) / divisor‖²: the difference of two normalised vectors (the mean cancels).
pub fn normalised_square(x: &[f32], y: &[f32], divisor: &[f32]) -> f32 {
    x.iter().zip(y).zip(divisor).map(|((x, y), s)| ((x - y) / s).powi(2)).sum()
}

/// ‖R(θ) − R(θ')‖²_F of two feature vectors: the 6D representation holds two columns, the third is their cross product.
pub fn orientation_square(a: &[f32], b: &[f32]) -> f32 {
    let (a, b) = (&a[FeatureLayout::ORIENTATION], &b[FeatureLayout::ORIENTATION]);
    squared_distance(a, b) + squared_distance(&third_column(a), &third_column(b))
}

fn third_column(d: &[f32]) -> [f32; 3] {
    [d[1] * d[5] - d[2] * d[4], d[2] * d[3] - d[0] * d[5], d[0] * d[4] - d[1] * d[3]]
}

/// ‖a_t − a_{t−1}‖² (eq. 4.8).
pub fn rate_square(effort: &Effort<'_>) -> f32 {
    squared_distance(effort.action, effort.previous)
}

/// ‖a_t − 2 a_{t−1} + a_{t−2}‖² (eq. 4.8).
pub fn acceleration_square(effort: &Effort<'_>) -> f32 {
    let triples = effort.action.iter().zip(effort.previous).zip(effort.before);
    triples.map(|((a, b), c)| (a - 2.0 * b + c).powi(2)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout() -> FeatureLayout {
        FeatureLayout { joints: vec!["knee".into(), "hip".into()], end_effectors: vec!["foot".into()] }
    }

    /// h, R = 1, v, q, q̇, p.
    fn rest() -> Vec<f32> {
        let mut f = vec![0.0; layout().size()];
        f[1] = 1.0;
        f[5] = 1.0;
        f
    }

    const STILL: Effort<'_> = Effort { action: &[0.0; 2], previous: &[0.0; 2], before: &[0.0; 2], torque_squared: 0.0 };

    fn table_4_1() -> ThesisReward {
        ThesisReward {
            height: 0.5,
            orientation: 1.0,
            velocity: 2.0,
            joint_position: 7.0,
            joint_velocity: 0.1,
            effectors: 1.0,
            alive: 30.0,
            action_rate: 1.5,
            action_acceleration: 0.45,
            torque: 1e-4,
            heading: 0.0,
            path: 0.0,
            scale: 1.0,
            term_limit: f32::INFINITY,
            floors: Floors { height: 0.0, velocity: 0.0, joint_position: 0.0, joint_velocity: 0.0, effectors: 0.0 },
        }
    }

    fn term(terms: &Terms, name: &str) -> f32 {
        TERMS.iter().position(|t| *t == name).map_or(f32::NAN, |i| terms[i])
    }

    #[test]
    fn a_curriculum_of_smoothness_scales_the_penalties_and_nothing_else() {
        assert_eq!(TERMS[SMOOTHNESS], ["action_rate", "action_acceleration", "torque"]);
    }

    #[test]
    fn the_thesis_terms_by_hand() {
        let layout = layout();
        let reference = rest();
        let mut simulated = rest();
        simulated[0] = 0.2; // height error 0.2
        simulated[7] = 0.5; // vx error 0.5
        simulated[13] = 0.1; // knee error 0.1
        simulated[16] = 2.0; // hip velocity error 2
        simulated[18] = 0.3; // foot error 0.3 in y
        let mut divisor = vec![1.0; layout.size()];
        divisor[0] = 0.1;
        divisor[13] = 0.5;
        let errors = Errors { layout: &layout, simulated: &simulated, reference: &reference, heading: 1.0, path: 1.0 };
        let effort = Effort { action: &[0.3, 0.0], previous: &[0.1, 0.0], before: &[0.0, 0.2], torque_squared: 400.0 };
        let terms = Reward::Thesis(table_4_1()).terms(&errors, &effort, &divisor);
        let expected = [
            ("height", -0.5 * 4.0),
            ("orientation", 0.0),
            ("velocity", -2.0 * 0.25),
            ("joint_position", -7.0 * 0.04),
            ("joint_velocity", -0.1 * 4.0),
            ("effectors", -0.09),
            ("alive", 30.0),
            ("heading", 0.0),
            ("path", 0.0),
            ("action_rate", -1.5 * 0.04),
            // (0.3 − 0.2 + 0)² + (0 − 0 + 0.2)²
            ("action_acceleration", -0.45 * (0.01 + 0.04)),
            ("torque", -0.04),
        ];
        for (name, value) in expected {
            assert!((term(&terms, name) - value).abs() < 1e-5, "{name}: {} not {value}", term(&terms, name));
        }
    }

    #[test]
    fn a_quarter_turn_is_four_in_the_frobenius_norm() {
        // ‖R − R'‖²_F = 4 (1 − cos φ) for an angle φ; the third column counts: without it the answer for a turn about x
        // would be 2.
        let mut turned = rest();
        turned[FeatureLayout::ORIENTATION].copy_from_slice(&[1.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
        assert!((orientation_square(&turned, &rest()) - 4.0).abs() < 1e-6);
    }

    #[test]
    fn a_term_limit_bounds_each_term_and_scale_multiplies_all() {
        let layout = layout();
        let mut simulated = rest();
        simulated[13] = 10.0;
        let reference = rest();
        let errors = Errors { layout: &layout, simulated: &simulated, reference: &reference, heading: 0.0, path: 0.0 };
        let reward = ThesisReward { term_limit: 5.0, scale: 0.5, ..table_4_1() };
        let terms = Reward::Thesis(reward).terms(&errors, &STILL, &vec![1.0; layout.size()]);
        assert_eq!((term(&terms, "joint_position"), term(&terms, "alive")), (-2.5, 15.0));
    }

    #[test]
    fn floors_raise_small_deviations_and_leave_the_orientation_alone() {
        let floors = Floors { height: 0.1, velocity: 1.0, joint_position: 0.5, joint_velocity: 3.0, effectors: 0.12 };
        let mut deviation = vec![0.01; layout().size()];
        deviation[7] = 2.0;
        let out = floors.apply(&layout(), &deviation);
        assert_eq!((out[0], out[1], out[7], out[8], out[13], out[15], out[17]), (0.1, 1.0, 2.0, 1.0, 0.5, 3.0, 0.12));
    }

    #[test]
    fn the_exponential_terms_by_hand() {
        let k = |weight, sharpness| Kernel { weight, sharpness };
        let reward = Reward::Exponential(ExponentialReward {
            height: k(0.1, 150.0),
            orientation: k(0.15, 4.0),
            velocity: k(0.2, 4.0),
            angular_share: 0.5,
            joint_position: k(0.35, 40.0),
            joint_velocity: k(0.1, 0.8),
            effectors: k(0.2, 160.0),
            heading: k(0.3, 2.0),
            path: k(0.4, 3.0),
            alive: 0.05,
            action_rate: 0.05,
            action_acceleration: 0.015,
            torque: 1e-5,
        });
        let layout = layout();
        let reference = rest();
        let errors = Errors { layout: &layout, simulated: &reference, reference: &reference, heading: 0.0, path: 0.0 };
        let best = reward.terms(&errors, &STILL, &[]);
        assert!((best.iter().sum::<f32>() - 1.85).abs() < 1e-6, "all kernels at their weight");
        let mut simulated = rest();
        simulated[0] = 0.1;
        simulated[7] = 0.5;
        simulated[10] = 1.0;
        simulated[13] = 0.2;
        simulated[15] = 1.0;
        simulated[17] = 0.1;
        let errors = Errors { simulated: &simulated, heading: 0.5, path: 2.0, ..errors };
        let effort = Effort { action: &[1.0, 0.0], torque_squared: 100.0, ..STILL };
        let terms = reward.terms(&errors, &effort, &[]);
        let e = |x: f32| x.exp();
        let expected = [
            ("height", 0.1 * e(-1.5)),
            ("velocity", 0.2 * e(-4.0 * (0.25 + 0.5))),
            ("joint_position", 0.35 * e(-40.0 * 0.02)),
            ("joint_velocity", 0.1 * e(-0.8 * 0.5)),
            ("effectors", 0.2 * e(-1.6)),
            ("heading", 0.3 * e(-0.5)),
            ("path", 0.4 * e(-12.0)),
            ("alive", 0.05),
            ("action_rate", -0.05),
            ("action_acceleration", -0.015),
            ("torque", -1e-3),
        ];
        for (name, value) in expected {
            assert!((term(&terms, name) - value).abs() < 1e-6, "{name}: {} not {value}", term(&terms, name));
        }
    }
}
