//! Stages of a physics step, and the observer that is told when they end.

/// A part of a physics step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Places and axes of all bodies.
    Kinematics,
    /// Bias forces and composite inertias.
    Bias,
    /// The mass matrix.
    MassMatrix,
    /// Actuators, damping, springs, pushes.
    Forces,
    /// Factors of the mass matrix, twice: constraints see it without damping.
    Factors,
    /// Joint limits and dry friction, detection of contacts, and the rows of both.
    Rows,
    /// The solver's iterations.
    Iterations,
    /// Velocities and positions.
    Integration,
}

impl Stage {
    /// All of them, in the order of a step.
    pub const ALL: [Self; 8] = [
        Self::Kinematics,
        Self::Bias,
        Self::MassMatrix,
        Self::Forces,
        Self::Factors,
        Self::Rows,
        Self::Iterations,
        Self::Integration,
    ];

    /// Returns its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Kinematics => "kinematics",
            Self::Bias => "bias forces",
            Self::MassMatrix => "mass matrix",
            Self::Forces => "actuators",
            Self::Factors => "factorisation",
            Self::Rows => "constraint rows",
            Self::Iterations => "solver iterations",
            Self::Integration => "integration",
        }
    }
}

/// An observer of the stages of a step. The engine's own is `()`, which costs nothing.
pub trait Profiler {
    /// Begins a step: the work before it belongs to no stage.
    fn begin(&mut self);
    /// Ends a stage: the work since the last call was this.
    fn end_stage(&mut self, stage: Stage);
}

impl Profiler for () {
    #[inline(always)]
    fn begin(&mut self) {}
    #[inline(always)]
    fn end_stage(&mut self, _: Stage) {}
}
