//! Motion of a robot as a source, so that it goes to another robot as a human's does.

use lifelike_character::{Anatomy, Character, Kinematics, Quat, Role, Vec3};

use super::Correspondence;
use crate::clip::MotionClip;
use crate::error::MotionError;
use crate::formats::raw::RawClip;
use crate::formats::{Hints, Known, ReadOptions};
use crate::source::SourceClip;

/// Returns a robot's motion as a source, with the roles of its joints: a joint for each body, roles by the robot's
/// anatomy, the reference pose at rest.
///
/// # Errors
/// [`MotionError::Mismatch`] where clip and robot name different joints; [`MotionError::Unfit`] for a robot without
/// legs that are known.
pub fn source_of_robot(
    clip: &MotionClip,
    robot: &Character,
    anatomy: &Anatomy,
) -> Result<(SourceClip, Correspondence), MotionError> {
    clip.check()?;
    let columns = clip.columns_for(robot)?;
    let root = robot.root_body();
    let is_below = |body: usize| {
        std::iter::successors(Some(body), |&b| (b != 0).then(|| robot.bodies[b].parent)).any(|b| b == root)
    };
    // The root comes first, and parents before their children.
    let bodies: Vec<usize> = (1..robot.bodies.len()).filter(|body| is_below(*body)).collect();
    let place_of = |body: usize| bodies.iter().position(|other| *other == body);
    let mut kinematics = Kinematics::new(robot);
    let rest: Vec<Quat> = bodies.iter().map(|body| kinematics.body_orientation[*body]).collect();
    let (mut root_position, mut rotations) = (Vec::with_capacity(clip.len()), Vec::with_capacity(clip.len()));
    let mut q = robot.reference_position();
    for frame in 0..clip.len() {
        clip.write_position(robot, &columns, frame, &mut q);
        kinematics.update(robot, &q);
        let turn = |body: usize| kinematics.body_orientation[body];
        let local = |body: usize| {
            if body == root { turn(body) } else { turn(robot.bodies[body].parent).inverse() * turn(body) }
        };
        root_position.push(kinematics.body_position[root]);
        rotations.push(bodies.iter().map(|body| local(*body)).collect());
    }
    let toes = anatomy.soles.values().filter_map(|sole| Some((place_of(sole.body)?, front(&sole.corners))));
    let raw = RawClip {
        name: clip.name.clone(),
        provenance: clip.provenance.source.clone(),
        fps: clip.fps,
        cyclic: clip.cyclic,
        names: bodies.iter().map(|body| robot.bodies[*body].name.clone()).collect(),
        parents: bodies.iter().map(|body| place_of(robot.bodies[*body].parent)).collect(),
        offsets: bodies
            .iter()
            .map(|body| if *body == root { Vec3::zeros() } else { robot.bodies[*body].position })
            .collect(),
        ends: toes.collect(),
        known: Some(Known { basis: Quat::identity(), rest }),
        hints: Hints::default(),
        root_position,
        rotations,
        notes: Vec::new(),
    };
    let names =
        |(role, place): (&Role, &lifelike_character::anatomy::Place)| (*role, robot.bodies[place.body].name.clone());
    let correspondence =
        Correspondence { roles: anatomy.places.iter().map(names).collect(), ..Correspondence::default() };
    let mut source = raw.finish(&ReadOptions { correspondence: correspondence.clone(), ..ReadOptions::default() })?;
    source.captions.clone_from(&clip.provenance.captions);
    Ok((source, correspondence))
}

/// Returns the middle of a sole's corners that lie farthest forward.
fn front(corners: &[Vec3]) -> Vec3 {
    let most = corners.iter().map(|corner| corner.x).fold(f64::NEG_INFINITY, f64::max);
    let front: Vec<&Vec3> = corners.iter().filter(|corner| corner.x > most - 0.01).collect();
    front.iter().copied().sum::<Vec3>() / front.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::path::Path;

    use lifelike_character::anatomy::Overrides;

    use super::*;
    use crate::keyframes;
    use crate::retarget::{RetargetOptions, retarget};

    #[test]
    fn motion_of_a_robot_goes_back_to_itself() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/lima.xml");
        let robot = Character::load(&path).unwrap();
        let anatomy = Anatomy::guess(&robot, &Overrides::default()).unwrap();
        let mut options = RetargetOptions { fps: 50.0, ..RetargetOptions::default() };
        let (_, text) = keyframes::builtin().find(|(name, _)| *name == "walk").unwrap();
        let human = keyframes::parse(text.as_bytes(), Path::new("walk")).unwrap();
        let clip = retarget(&human, &robot, &anatomy, &options).unwrap().0;

        let (source, roles) = source_of_robot(&clip, &robot, &anatomy).unwrap();
        let (places, _) = source.pose(30);
        let mut kinematics = Kinematics::new(&robot);
        let (columns, mut q) = (clip.columns_for(&robot).unwrap(), robot.reference_position());
        clip.write_position(&robot, &columns, 30, &mut q);
        kinematics.update(&robot, &q);
        let foot = robot.body("left_foot").unwrap();
        let joint = source.skeleton.names.iter().position(|name| name == "left_foot").unwrap();
        assert!((places[joint] - kinematics.body_position[foot]).norm() < 1e-9, "joints are where the bodies are");

        options.correspondence.merge(&roles);
        let (back, report) = retarget(&source, &robot, &anatomy, &options).unwrap();
        assert_eq!(back.len(), clip.len());
        let apart =
            clip.joints.iter().zip(&back.joints).map(|(a, b)| (a - b).abs()).sum::<f64>() / clip.joints.len() as f64;
        println!(
            "mean difference {apart} rad, {:.4} m, {:.2} deg",
            report.mean_position_error(),
            report.mean_orientation_error()
        );
        assert!(apart < 0.1, "{apart} rad");
    }
}
