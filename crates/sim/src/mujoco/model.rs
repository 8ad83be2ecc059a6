//! The model that MuJoCo compiles, and where in it the robot's parts are.

use std::ffi::CStr;

use lifelike_character::{Character, GeomShape, Quat, Vec3};
use lifelike_robot::{ActuatorParameters, Robot};

use super::ENGINE;
use super::library::library;
use super::native::{
    DSBL_ACTUATION, DSBL_AUTORESET, DSBL_DAMPER, DSBL_EULERDAMP, DSBL_SENSOR, GEOM_HFIELD, GEOM_PLANE, Geom, INT_EULER,
    INT_RK4, Model, OBJ_BODY, OBJ_JOINT, Spec,
};
use crate::engine::{SOLIMP, SOLREF};
use crate::error::SimError;
use crate::terrain::Terrain;

/// Name of the height field.
const TERRAIN: &CStr = c"lifelike_terrain";

/// One joint as the actuator model needs it.
#[derive(Debug, Clone)]
pub(super) struct DrivenJoint {
    /// Index of its position.
    pub q: usize,
    /// Index of its velocity.
    pub v: usize,
    /// Its actuator.
    pub actuator: ActuatorParameters,
    /// Damping that the model itself gives it (N m s/rad).
    pub damping: f64,
    /// Dry friction that the model itself gives it (N m).
    pub frictionloss: f64,
}

/// Indices of the robot's parts in MuJoCo's arrays, and in an environment's row of numbers.
///
/// The row is `[time, positions, velocities, warm start, pushes (6 per body), diverged, outer torques]`.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    pub nv: usize,
    pub bodies: usize,
    /// First position and velocity of the free root.
    pub root: Option<(usize, usize)>,
    /// Pose of a root that is fixed to the world.
    pub fixed_base: (Vec3, Quat),
    pub joints: Vec<DrivenJoint>,
    /// End effectors, then key bodies: body and point in its frame.
    pub sites: Vec<(usize, Vec3)>,
    /// Scalar joint of each MuJoCo joint, and of each velocity.
    pub scalar_of_joint: Vec<Option<usize>>,
    pub scalar_of_dof: Vec<Option<usize>>,
    /// True for each geom that is part of the ground: fixed to the world.
    pub ground: Vec<bool>,
    /// The foot that each geom belongs to.
    pub foot_of_geom: Vec<Option<usize>>,
    pub substeps: usize,
    pub positions: usize,
    pub velocities: usize,
    pub warm_start: usize,
    pub pushes: usize,
    pub diverged: usize,
    /// Torque on each actuator from outside; nothing where no actuator has friction under load.
    pub outside: usize,
    pub width: usize,
}

impl Layout {
    /// A row at rest of forces, in the given state, the root's quaternion normalised.
    pub fn fresh_row(&self, position: &[f64], velocity: &[f64]) -> Vec<f64> {
        let mut row = vec![0.0; self.width];
        row[self.positions..self.velocities].copy_from_slice(position);
        row[self.velocities..self.warm_start].copy_from_slice(velocity);
        row
    }
}

/// Compiles the character's text. See [`super::MujocoSimulation::new`] for what is changed in it.
pub(super) fn compile(robot: &Robot, terrain: Option<&Terrain>) -> Result<(Model, Layout), SimError> {
    library()?;
    let character = &robot.character;
    let fail = |message: String| SimError::Model { engine: ENGINE, character: character.name.clone(), message };
    let text = character.mjcf.as_deref().ok_or_else(|| fail("it was not read from MJCF text".into()))?;
    let mut spec = Spec::from_xml_string(text).map_err(fail)?;
    // A profile may know rotors that the text does not (`ActuatorGroup::armature`), and springs of the text may be gains.
    for joint in character.scalar_joints() {
        spec.set_joint(&joint.name, joint.armature, joint.stiffness, joint.damping);
    }
    if let Some(terrain) = terrain {
        add_terrain(&mut spec, character, terrain).map_err(fail)?;
    } else if !has_ground(character) {
        let mut floor = spec.add_geom(c"lifelike_floor").map_err(fail)?;
        *floor.type_mut() = GEOM_PLANE;
        *floor.size_mut() = [0.0, 0.0, 1.0];
        surface(&mut floor, character);
    }
    let mut model = spec.compile().map_err(fail)?;
    let mut edited = model.edit();
    if terrain.is_some() {
        let is_plane = |g: &usize| edited.geom_bodyid()[*g] == 0 && edited.geom_type()[*g] == GEOM_PLANE;
        let planes: Vec<usize> = (0..edited.ngeom() as usize).filter(is_plane).collect();
        for plane in planes {
            edited.geom_contype_mut()[plane] = 0;
            edited.geom_conaffinity_mut()[plane] = 0;
        }
    }
    // MuJoCo notes at compile time which frames coincide and which bodies are simple. Both end when an environment moves
    // a centre of mass.
    edited.forbid_shortcuts();
    *edited.opt_timestep_mut() = robot.timestep();
    if edited.opt_integrator() == INT_RK4 {
        *edited.opt_integrator_mut() = INT_EULER;
    }
    *edited.opt_disableflags_mut() |= DSBL_ACTUATION | DSBL_SENSOR | DSBL_AUTORESET;
    // Friction is a damping that is integrated implicitly: the switch that makes it explicit stays off.
    *edited.opt_disableflags_mut() &= !(DSBL_EULERDAMP | DSBL_DAMPER);
    check_names(character, &model).map_err(fail)?;
    let layout = layout(robot, &model);
    Ok((model, layout))
}

/// Returns true when something fixed to the world can be stood on.
fn has_ground(character: &Character) -> bool {
    character.geoms.iter().any(|g| g.body == 0 && matches!(g.shape, GeomShape::Plane | GeomShape::HeightField(_)))
}

/// The terrain as a height field with the surface of the character's own plane, which it takes the place of.
fn add_terrain(spec: &mut Spec, character: &Character, terrain: &Terrain) -> Result<(), String> {
    let (heights, spacing) = (terrain.heights(), terrain.spacing());
    let low = heights.iter().copied().fold(f64::INFINITY, f64::min);
    let half = |n: usize| 0.5 * spacing * (n - 1) as f64;
    // MuJoCo brings heights into 0..1 itself.
    let size = [half(terrain.columns()), half(terrain.rows()), (terrain.top() - low).max(1e-6), 1.0];
    let above: Vec<f32> = heights.iter().map(|h| (h - low) as f32).collect();
    spec.add_hfield(TERRAIN, [terrain.rows(), terrain.columns()], size, &above)?;
    let mut geom = spec.add_geom(TERRAIN)?;
    *geom.type_mut() = GEOM_HFIELD;
    geom.set_hfieldname(TERRAIN);
    geom.pos_mut()[2] = low;
    surface(&mut geom, character);
    Ok(())
}

/// Gives ground that is added the surface of the character's own plane, or MuJoCo's default where it has none: never what the
/// character's defaults say of its own parts.
fn surface(geom: &mut Geom<'_>, character: &Character) {
    let plane = character.geoms.iter().find(|g| g.body == 0 && g.shape == GeomShape::Plane);
    let masks = plane.map_or((1, 1, 3), |p| (p.contype, p.conaffinity, p.condim));
    *geom.contype_mut() = masks.0 as i32;
    *geom.conaffinity_mut() = masks.1 as i32;
    *geom.condim_mut() = masks.2 as i32;
    *geom.priority_mut() = plane.map_or(0, |p| p.priority);
    *geom.margin_mut() = plane.map_or(0.0, |p| p.margin);
    *geom.gap_mut() = plane.map_or(0.0, |p| p.gap);
    *geom.friction_mut() = plane.map_or([1.0, 0.005, 0.0001], |p| p.friction);
    *geom.solref_mut() = plane.map_or(SOLREF, |p| p.solref);
    *geom.solimp_mut() = plane.map_or(SOLIMP, |p| p.solimp);
}

/// Bodies and joints must be the character's, in its order; names that it made up itself are not compared.
fn check_names(character: &Character, model: &Model) -> Result<(), String> {
    let sizes = (model.nbody() as usize, model.njnt() as usize, model.nq() as usize, model.nv() as usize);
    let expected = (character.bodies.len(), character.joints.len(), character.nq, character.nv);
    if sizes != expected {
        return Err(format!("expected (bodies, joints, nq, nv) = {expected:?}, MuJoCo has {sizes:?}"));
    }
    let differs = |kind, id, own: &str| {
        model.id_to_name(kind, id).filter(|name| !name.is_empty() && *name != own).map(|name| {
            format!("expected '{own}' at {} {id}, MuJoCo has '{name}'", if id == 0 { "position" } else { "index" })
        })
    };
    let bodies = character.bodies.iter().enumerate().skip(1);
    let body = bodies.map(|(i, b)| differs(OBJ_BODY, i, &b.name)).find_map(|m| m);
    let joints = character.joints.iter().enumerate();
    let joint = joints.map(|(i, j)| differs(OBJ_JOINT, i, &j.name)).find_map(|m| m);
    body.or(joint).map_or(Ok(()), Err)
}

fn layout(robot: &Robot, model: &Model) -> Layout {
    let character = &robot.character;
    let (nq, nv, bodies) = (character.nq, character.nv, character.bodies.len());
    let joints: Vec<DrivenJoint> = character
        .scalar_joints()
        .zip(&robot.actuators.parameters)
        .map(|(j, &actuator)| DrivenJoint {
            q: j.q_index,
            v: j.v_index,
            actuator,
            damping: model.dof_damping()[j.v_index],
            frictionloss: model.dof_frictionloss()[j.v_index],
        })
        .collect();
    let mut scalar_of_dof = vec![None; nv];
    let mut scalar_of_joint = vec![None; character.joints.len()];
    let scalars = character.joints.iter().enumerate().filter(|(_, j)| j.is_scalar());
    for (scalar, (index, joint)) in scalars.enumerate() {
        scalar_of_joint[index] = Some(scalar);
        scalar_of_dof[joint.v_index] = Some(scalar);
    }
    let geom_bodies: Vec<usize> = model.geom_bodyid().iter().map(|&b| b.max(0) as usize).collect();
    let positions = 1;
    let velocities = positions + nq;
    let warm_start = velocities + nv;
    let pushes = warm_start + nv;
    let diverged = pushes + 6 * bodies;
    let outside = diverged + 1;
    let is_loaded = robot.actuators.parameters.iter().any(|actuator| actuator.extended_friction.is_some());
    Layout {
        nv,
        bodies,
        root: character.root_joint().map(|j| (j.q_index, j.v_index)),
        fixed_base: character.fixed_base().unwrap_or_default(),
        joints,
        sites: robot.effectors.iter().chain(&robot.key_bodies).copied().collect(),
        scalar_of_joint,
        scalar_of_dof,
        ground: geom_bodies.iter().map(|&b| model.body_weldid()[b] == 0).collect(),
        foot_of_geom: geom_bodies.iter().map(|&b| robot.anatomy.foot_of(character, b)).collect(),
        substeps: robot.substeps,
        positions,
        velocities,
        warm_start,
        pushes,
        diverged,
        outside,
        width: outside + if is_loaded { robot.actuators.parameters.len() } else { 0 },
    }
}
