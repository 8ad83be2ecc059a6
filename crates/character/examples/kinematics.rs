//! Loads a robot (MJCF or URDF) and prints where every body is: `kinematics [FILE] [ANGLE]`. All hinges are turned by the
//! angle (rad), within their limits.

use lifelike_character::{Character, Kinematics, Symmetry};

const PENDULUM: &str = r#"<mujoco model="pendulum"><worldbody><body name="arm" pos="0 0 1">
    <joint name="swing" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 -.5" size=".02"/>
    <body name="tip" pos="0 0 -.5"><geom size=".05"/></body></body></worldbody></mujoco>"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let character = match arguments.next() {
        Some(file) => Character::load(file)?,
        None => Character::from_mjcf(PENDULUM, "pendulum.xml", None)?,
    };
    let angle: f64 = arguments.next().map_or(Ok(0.3), |text| text.parse())?;
    let mut q = character.reference_position();
    for joint in character.scalar_joints() {
        let (low, high) = joint.range.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        q[joint.q_index] = angle.max(low).min(high);
    }
    let mut kinematics = Kinematics::new(&character);
    kinematics.update(&character, &q);
    println!("{}: {:.3} kg, {} joints", character.name, character.mass(), character.scalar_joints().count());
    for (body, position) in character.bodies.iter().zip(&kinematics.body_position).skip(1) {
        println!("{:24} {:8.3} {:8.3} {:8.3} m", body.name, position.x, position.y, position.z);
    }
    match Symmetry::derive(&character) {
        Ok(_) => println!("left and right are mirror images"),
        Err(error) => println!("{error}"),
    }
    Ok(())
}
