//! A take of a scene, sampled at one rate.

use std::collections::BTreeMap;

use lifelike_character::{Quat, Vec3};
use ufbx::{AnimStack, Node, Scene};

use super::Motion;
use super::joints::{Joints, rotation, vector};
use crate::formats::raw;

/// Most rotations of a clip, all joints and frames together (1 GB).
const MOST_ROTATIONS: f64 = 30e6;
/// Rates that a file may say (frames per second).
const RATES: std::ops::RangeInclusive<f64> = 1.0..=10_000.0;
/// Difference of a scale's three parts, as a part of the scale, up to which bones turn without shear.
const UNEVEN: f64 = 1e-3;

/// A take, and the rate of its scene.
pub(super) struct Take<'a> {
    stack: &'a AnimStack,
    rate: f64,
}

impl<'a> Take<'a> {
    /// Takes the first one that moves something; the notes name the others.
    ///
    /// # Errors
    /// Expected and got, for a scene where nothing moves.
    pub(super) fn choose(scene: &'a Scene, notes: &mut Vec<String>) -> Result<Self, (String, String)> {
        let moves = |stack: &&AnimStack| {
            stack.time_end > stack.time_begin && stack.layers.into_iter().any(|layer| layer.anim_values.count > 0)
        };
        let takes: Vec<&AnimStack> = scene.anim_stacks.into_iter().filter(moves).collect();
        let Some((stack, others)) = takes.split_first() else {
            let got = format!("{} takes without motion: export the animation", scene.anim_stacks.count);
            return Err(("a take that moves bones".to_owned(), got));
        };
        if !others.is_empty() {
            let names: Vec<&str> = others.iter().take(5).map(|other| &*other.element.name).collect();
            let (count, names) = (others.len(), names.join(", "));
            notes.push(format!("take '{}' was read; {count} more were not: {names}", &*stack.element.name));
        }
        Ok(Self { stack, rate: raw::rate(scene.settings.frames_per_second.recip()) })
    }

    /// Evaluates the joints at each frame.
    ///
    /// # Errors
    /// Expected and got, for too many frames and for bones that are scaled unevenly.
    pub(super) fn sample(&self, joints: &Joints<'_>, fps: Option<f64>) -> Result<Motion, (String, String)> {
        let fps = fps.unwrap_or(self.rate);
        if !RATES.contains(&fps) {
            return Err(("1 to 10000 frames per second (--fps)".to_owned(), fps.to_string()));
        }
        let (begin, end) = (self.stack.time_begin, self.stack.time_end);
        let frames = ((end - begin) * fps + 1e-3).floor() + 1.0;
        let most = (MOST_ROTATIONS / joints.nodes.len() as f64).floor();
        if !(2.0..=most).contains(&frames) {
            return Err((format!("2 to {most} frames of {} joints", joints.nodes.len()), frames.to_string()));
        }
        let mut motion = Motion { fps, places: Vec::new(), turns: Vec::new() };
        for frame in 0..frames as usize {
            let mut pose = Pose { take: self.stack, time: begin + frame as f64 / fps, known: BTreeMap::new() };
            let mut places = Vec::with_capacity(joints.nodes.len());
            let mut turns = Vec::with_capacity(joints.nodes.len());
            for node in &joints.nodes {
                let world = pose.of(node).map_err(|got| ("numbers of an even scale".to_owned(), got))?;
                places.push(world.place);
                turns.push(world.turn);
            }
            motion.places.push(places);
            motion.turns.push(turns);
        }
        Ok(motion)
    }
}

/// Place, rotation and even scale of a node in the world.
#[derive(Clone, Copy)]
struct World {
    place: Vec3,
    turn: Quat,
    scale: f64,
}

/// The nodes at one time.
struct Pose<'a> {
    take: &'a AnimStack,
    time: f64,
    known: BTreeMap<u32, World>,
}

impl Pose<'_> {
    /// Returns a node in the world; what is wrong with it where it cannot be told.
    fn of(&mut self, node: &Node) -> Result<World, String> {
        let mut chain = Vec::new();
        let mut world = World { place: Vec3::zeros(), turn: Quat::identity(), scale: 1.0 };
        let mut next = Some(node);
        while let Some(node) = next {
            if let Some(known) = self.known.get(&node.element.element_id) {
                world = *known;
                break;
            }
            chain.push(node);
            next = node.parent.as_deref();
        }
        for node in chain.into_iter().rev() {
            world = self.step(world, node)?;
            self.known.insert(node.element.element_id, world);
        }
        Ok(world)
    }

    fn step(&self, above: World, node: &Node) -> Result<World, String> {
        let local = node.evaluate_transform(&self.take.anim, self.time);
        let (place, scale) = (vector(local.translation), vector(local.scale));
        let wrong = |what: &str| format!("{what} of '{}' at {:.3} s", &*node.element.name, self.time);
        if !place.iter().chain(scale.iter()).all(|x| x.is_finite()) || place.amax() > 1e9 {
            return Err(wrong("a broken number"));
        }
        let mean = scale.mean();
        // 3ds Max writes ends of mirrored limbs with a scale of -1 in all directions, which is even too.
        if !(1e-9..1e9).contains(&mean.abs()) || scale.iter().any(|s| (s - mean).abs() > UNEVEN * mean.abs()) {
            return Err(wrong(&format!("scale {} {} {}", scale.x, scale.y, scale.z)));
        }
        let turn = rotation(local.rotation).ok_or_else(|| wrong("a rotation without direction"))?;
        Ok(World {
            place: above.place + above.turn * (above.scale * place),
            turn: above.turn * turn,
            scale: above.scale * mean,
        })
    }
}
