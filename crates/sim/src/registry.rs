//! The engines of this build, each declared once.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use lifelike_robot::Robot;

use crate::engine::LifelikeSimulation;
use crate::error::SimError;
use crate::simulation::Simulation;
use crate::terrain::Terrain;

/// Makes a simulation as a spec asks for.
type Builder = fn(&SimulationSpec, Arc<Robot>) -> Result<Box<dyn Simulation>, SimError>;

/// A builder, or how to get a build that has it.
type Declared = Result<Builder, &'static str>;

macro_rules! engines {
    ($($(#[$doc:meta])* $kind:ident, $name:literal, $builder:expr;)+) => {
        /// A physics engine. As text, on the command line and in plans, it is its name.
        #[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
        pub enum EngineKind {
            $($(#[$doc])* #[serde(rename = $name)] $kind,)+
        }

        impl EngineKind {
            /// All engines, those that this build lacks included.
            pub const ALL: &'static [Self] = &[$(Self::$kind),+];

            /// Returns its name.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$kind => $name,)+
                }
            }

            fn declared(self) -> Declared {
                match self {
                    $(Self::$kind => $builder,)+
                }
            }
        }
    };
}

// A new engine is an entry here, and a type that is an `Engine`.
engines! {
    /// Our own: MuJoCo's model of the dynamics on vectors of environments.
    #[default]
    Lifelike, "lifelike", Ok(lifelike);

    /// MuJoCo, with the cargo feature `mujoco`.
    Mujoco, "mujoco", MUJOCO;
}

fn lifelike(spec: &SimulationSpec, robot: Arc<Robot>) -> Result<Box<dyn Simulation>, SimError> {
    let simulation = LifelikeSimulation::new(robot, spec.environments, spec.threads)?;
    Ok(Box::new(match &spec.terrain {
        Some(terrain) => simulation.with_terrain(terrain.clone()),
        None => simulation,
    }))
}

#[cfg(feature = "mujoco")]
const MUJOCO: Declared = Ok(|spec, robot| {
    let terrain = spec.terrain.as_deref();
    Ok(Box::new(crate::mujoco::MujocoSimulation::on(terrain, robot, spec.environments, spec.threads)?))
});

#[cfg(not(feature = "mujoco"))]
const MUJOCO: Declared = Err("leave the engine away for our own physics, or fetch MuJoCo once and build with it: \
         cargo xtask mujoco; cargo run --release --features mujoco --bin lifelike -- ...");

impl EngineKind {
    /// Returns an error that says how to get this engine if this build lacks it.
    ///
    /// # Errors
    /// [`SimError::EngineUnavailable`].
    pub fn available(self) -> Result<(), SimError> {
        self.checked_builder().map(|_| ())
    }

    fn checked_builder(self) -> Result<Builder, SimError> {
        self.declared().map_err(|hint| SimError::EngineUnavailable { name: self.name(), hint })
    }
}

impl fmt::Display for EngineKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for EngineKind {
    type Err = SimError;

    fn from_str(name: &str) -> Result<Self, SimError> {
        let found = Self::ALL.iter().copied().find(|kind| kind.name() == name);
        found.ok_or_else(|| {
            let names: Vec<&str> = Self::ALL.iter().map(|kind| kind.name()).collect();
            SimError::UnknownEngine { name: name.to_string(), known: names.join(", ") }
        })
    }
}

/// A simulation to be built: which engine, how many environments, on which ground, on how many threads.
///
/// ```
/// use std::sync::Arc;
/// use lifelike_robot::Robot;
/// use lifelike_sim::{EngineKind, Simulation, SimulationSpec, Terrain};
///
/// let hills = Arc::new(Terrain::hills(10.0, 0.1, 0.2, 2.0, 1)?);
/// let spec = SimulationSpec { engine: "lifelike".parse()?, terrain: Some(hills), ..SimulationSpec::new(8) };
/// let simulation = spec.build(Arc::new(Robot::load("lima")?))?;
/// assert_eq!((simulation.len(), simulation.engine()), (8, EngineKind::Lifelike.name()));
/// assert!(simulation.terrain().is_some());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SimulationSpec {
    /// The engine.
    pub engine: EngineKind,
    /// Number of environments.
    pub environments: usize,
    /// Threads that step them (0: one per processor). Results do not depend on it.
    pub threads: usize,
    /// Uneven ground; `None`: level ground.
    pub terrain: Option<Arc<Terrain>>,
}

impl SimulationSpec {
    /// So many environments of the default engine on level ground, a thread per processor.
    pub fn new(environments: usize) -> Self {
        Self { engine: EngineKind::default(), environments, threads: 0, terrain: None }
    }

    /// Builds the simulation of a robot, every environment in the robot's default pose.
    ///
    /// # Errors
    /// [`SimError::EngineUnavailable`] when this build lacks the engine, and what the engine cannot simulate.
    pub fn build(&self, robot: Arc<Robot>) -> Result<Box<dyn Simulation>, SimError> {
        self.engine.checked_builder()?(self, robot)
    }
}
