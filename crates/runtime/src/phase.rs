//! The state machine of a run.
//!
//! ```text
//! idle → stand → blend in → run → blend out → damp → idle
//!                          ↑                    ↓
//!                          └────── get up ──────┘
//! ```
//! Every phase goes to `damp` at once when the gate trips. A stop in `run` or `blend in` goes to `blend out`. A robot that fell
//! and has a script for it gets up once it lies still.

/// Part of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// Motors are off.
    Idle,
    /// Joints move to the pose in which the motion begins, slowly.
    Stand,
    /// Targets go over from the pose to the policy's.
    BlendIn,
    /// The policy drives.
    Run,
    /// Targets go over from the policy's to the pose in which it was stopped.
    BlendOut,
    /// Motors only brake.
    Damp,
    /// A script gets up.
    GetUp,
}

/// Request of the operator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Request {
    /// Begin, or go on.
    Run,
    /// Come to an end: blend out, then damp.
    Stop,
    /// Brake now.
    Damp,
}

/// Everything that decides a transition.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Situation {
    /// Request of the operator or of the robot's remote.
    pub request: Request,
    /// The gate has tripped.
    pub tripped: bool,
    /// A valid measurement has arrived.
    pub measured: bool,
    /// The reference has ended.
    pub over: bool,
    /// The robot fell, and may get up.
    pub fallen: bool,
    /// The robot hardly turns.
    pub still: bool,
    /// The robot that gets up is on its feet.
    pub up: bool,
    /// Time in this phase (s).
    pub elapsed: f64,
}

/// Lengths of the phases (s).
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Durations {
    /// Ramp to the standing pose.
    pub stand: f64,
    /// From the pose to the policy.
    pub blend_in: f64,
    /// From the policy to the pose in which it was stopped.
    pub blend_out: f64,
    /// Braking before motors are off, or before a robot that fell gets up.
    pub damp: f64,
    /// Longest try to get up, of three.
    pub get_up: f64,
}

impl Default for Durations {
    fn default() -> Self {
        Self { stand: 2.0, blend_in: 0.2, blend_out: 0.2, damp: 2.0, get_up: 20.0 }
    }
}

impl Phase {
    /// All phases.
    pub const ALL: [Self; 7] =
        [Self::Idle, Self::Stand, Self::BlendIn, Self::Run, Self::BlendOut, Self::Damp, Self::GetUp];

    /// Returns the phase that follows in a situation; this one where nothing changes.
    #[must_use]
    pub fn next(self, now: Situation, durations: &Durations) -> Self {
        let must_damp = now.tripped || now.request == Request::Damp;
        let is_stopped = now.request == Request::Stop;
        match self {
            Self::Idle if must_damp || is_stopped || now.over || !now.measured => Self::Idle,
            Self::Idle => Self::Stand,
            Self::Damp if now.fallen && now.request == Request::Run => {
                if now.still && now.elapsed >= durations.damp {
                    Self::GetUp
                } else {
                    Self::Damp
                }
            }
            Self::Damp if now.elapsed >= durations.damp => Self::Idle,
            Self::Damp => Self::Damp,
            _ if must_damp => Self::Damp,
            Self::GetUp if is_stopped || now.elapsed >= durations.get_up => Self::Damp,
            Self::GetUp if now.up => Self::Run,
            Self::Stand if is_stopped => Self::Damp,
            Self::Stand if now.elapsed >= durations.stand => Self::BlendIn,
            Self::BlendIn if is_stopped || now.over => Self::BlendOut,
            Self::BlendIn if now.elapsed >= durations.blend_in => Self::Run,
            Self::Run if is_stopped || now.over => Self::BlendOut,
            Self::BlendOut if now.elapsed >= durations.blend_out => Self::Damp,
            same => same,
        }
    }

    /// Returns its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Idle => "idle",
            Self::Stand => "stand",
            Self::BlendIn => "blend in",
            Self::Run => "run",
            Self::BlendOut => "blend out",
            Self::Damp => "damp",
            Self::GetUp => "get up",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOING: Situation = Situation {
        request: Request::Run,
        tripped: false,
        measured: true,
        over: false,
        fallen: false,
        still: true,
        up: false,
        elapsed: 0.0,
    };
    const DURATIONS: Durations = Durations { stand: 2.0, blend_in: 0.2, blend_out: 0.3, damp: 1.0, get_up: 5.0 };

    fn next(phase: Phase, now: Situation) -> Phase {
        phase.next(now, &DURATIONS)
    }

    #[test]
    fn a_run_goes_through_every_phase() {
        use Phase::{BlendIn, BlendOut, Damp, Idle, Run, Stand};
        let steps = [
            (Idle, GOING, Stand),
            (Stand, Situation { elapsed: 1.99, ..GOING }, Stand),
            (Stand, Situation { elapsed: 2.0, ..GOING }, BlendIn),
            (BlendIn, Situation { elapsed: 0.19, ..GOING }, BlendIn),
            (BlendIn, Situation { elapsed: 0.2, ..GOING }, Run),
            (Run, Situation { elapsed: 1e9, ..GOING }, Run),
            (Run, Situation { over: true, ..GOING }, BlendOut),
            (BlendIn, Situation { over: true, ..GOING }, BlendOut),
            (BlendOut, Situation { elapsed: 0.29, ..GOING }, BlendOut),
            (BlendOut, Situation { elapsed: 0.3, ..GOING }, Damp),
            (Damp, Situation { elapsed: 0.99, ..GOING }, Damp),
            (Damp, Situation { elapsed: 1.0, ..GOING }, Idle),
        ];
        for (phase, now, expected) in steps {
            assert_eq!(next(phase, now), expected, "{phase:?} {now:?}");
        }
    }

    #[test]
    fn a_stop_is_heard_in_every_phase() {
        use Phase::{BlendIn, BlendOut, Damp, Idle, Run, Stand};
        let stop = Situation { request: Request::Stop, ..GOING };
        let expected = [(Idle, Idle), (Stand, Damp), (BlendIn, BlendOut), (Run, BlendOut), (BlendOut, BlendOut)];
        for (phase, expected) in expected.into_iter().chain([(Damp, Damp), (Phase::GetUp, Damp)]) {
            assert_eq!(next(phase, stop), expected, "{phase:?}");
        }
    }

    #[test]
    fn a_trip_and_an_emergency_stop_brake_at_once() {
        for phase in Phase::ALL {
            let expected = if phase == Phase::Idle { Phase::Idle } else { Phase::Damp };
            for elapsed in [0.0, 0.5] {
                assert_eq!(next(phase, Situation { tripped: true, elapsed, ..GOING }), expected);
                assert_eq!(next(phase, Situation { request: Request::Damp, elapsed, ..GOING }), expected);
            }
        }
    }

    #[test]
    fn a_robot_that_fell_lies_still_gets_up_and_goes_on() {
        use Phase::{Damp, GetUp, Idle, Run};
        let fell = Situation { fallen: true, tripped: true, ..GOING };
        let up = Situation { fallen: true, ..GOING };
        let steps = [
            (Run, fell, Damp),
            (Damp, Situation { elapsed: 0.9, ..fell }, Damp),
            (Damp, Situation { elapsed: 9.0, still: false, ..fell }, Damp),
            (Damp, Situation { elapsed: 1.0, ..fell }, GetUp),
            (Damp, Situation { elapsed: 1.0, request: Request::Stop, ..fell }, Idle),
            (GetUp, Situation { elapsed: 4.9, ..up }, GetUp),
            (GetUp, Situation { elapsed: 4.9, up: true, ..up }, Run),
            (GetUp, Situation { elapsed: 5.0, ..up }, Damp),
            // A defect is no fall.
            (GetUp, Situation { tripped: true, ..GOING }, Damp),
            (Damp, Situation { tripped: true, elapsed: 1.0, ..GOING }, Idle),
        ];
        for (phase, now, expected) in steps {
            assert_eq!(next(phase, now), expected, "{phase:?} {now:?}");
        }
    }

    #[test]
    fn nothing_begins_before_the_robot_was_measured() {
        assert_eq!(next(Phase::Idle, Situation { measured: false, ..GOING }), Phase::Idle);
        assert_eq!(next(Phase::Idle, Situation { over: true, ..GOING }), Phase::Idle, "nor after the motion");
    }
}
