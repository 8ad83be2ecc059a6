//! The engines, each declared once.

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

macro_rules! engines {
    ($($(#[$doc:meta])* $kind:ident, $name:literal, $builder:expr, $available:expr;)+) => {
        /// A physics engine. As text, on the command line and in plans, it is its name.
        #[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
        pub enum EngineKind {
            $($(#[$doc])* #[serde(rename = $name)] $kind,)+
        }

        impl EngineKind {
            /// All engines, those whose library is missing included.
            pub const ALL: &'static [Self] = &[$(Self::$kind),+];

            /// Returns its name.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$kind => $name,)+
                }
            }

            fn builder(self) -> Builder {
                match self {
                    $(Self::$kind => $builder,)+
                }
            }

            /// Returns an error that says how to get this engine if its library is missing.
            ///
            /// # Errors
            /// [`SimError::EngineUnavailable`].
            pub fn available(self) -> Result<(), SimError> {
                match self {
                    $(Self::$kind => $available,)+
                }
            }
        }
    };
}

// A new engine is an entry here, and a type that is an `Engine`.
engines! {
    /// Our own: MuJoCo's model of the dynamics on vectors of environments.
    #[default]
    Lifelike, "lifelike", lifelike, Ok(());

    /// MuJoCo, whose library is opened at run time.
    Mujoco, "mujoco", mujoco, crate::mujoco::library().map(|_| ());
}

fn lifelike(spec: &SimulationSpec, robot: Arc<Robot>) -> Result<Box<dyn Simulation>, SimError> {
    let simulation = LifelikeSimulation::new(robot, spec.environments, spec.threads)?;
    Ok(Box::new(match &spec.terrain {
        Some(terrain) => simulation.with_terrain(terrain.clone()),
        None => simulation,
    }))
}

fn mujoco(spec: &SimulationSpec, robot: Arc<Robot>) -> Result<Box<dyn Simulation>, SimError> {
    let terrain = spec.terrain.as_deref();
    Ok(Box::new(crate::mujoco::MujocoSimulation::on(terrain, robot, spec.environments, spec.threads)?))
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
    /// [`SimError::EngineUnavailable`] when the engine's library is missing, and what the engine cannot simulate.
    pub fn build(&self, robot: Arc<Robot>) -> Result<Box<dyn Simulation>, SimError> {
        self.engine.builder()(self, robot)
    }
}
