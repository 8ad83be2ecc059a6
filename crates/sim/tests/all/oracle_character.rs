//! The compiled character is what MuJoCo's own compiler makes of the same text: tree, masses, inertia, joints, shapes,
//! poses and Jacobians.
use crate::world::{fetched, root, shared, without_pictures};
use lifelike_character::{Character, Geom, GeomShape, JointKind, Kinematics, Quat, Vec3, rotation};
use lifelike_sim::mujoco::native::{Data, Model};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Both compute in f64; masses reach 75 kg and lengths 2 m.
const TOLERANCE: f64 = 1e-9;

fn close(what: &str, ours: &[f64], theirs: &[f64]) {
    assert_eq!(ours.len(), theirs.len(), "{what}");
    for (a, b) in ours.iter().zip(theirs) {
        assert!((a - b).abs() <= TOLERANCE, "{what}: {ours:?}, MuJoCo has {theirs:?}");
    }
}

/// The same rotation, whatever the sign of the quaternion.
fn same_turn(what: &str, ours: &Quat, theirs: &[f64; 4]) {
    let ours = rotation::to_wxyz(ours);
    let sign = if ours.iter().zip(theirs).map(|(a, b)| a * b).sum::<f64>() < 0.0 { -1.0 } else { 1.0 };
    close(what, &ours, &theirs.map(|x| sign * x));
}

fn compare(ours: &Character, theirs: &Model) {
    let sizes = (ours.nq, ours.nv, ours.bodies.len(), ours.joints.len(), ours.sites.len());
    let expected = (theirs.nq(), theirs.nv(), theirs.nbody(), theirs.njnt(), theirs.nsite());
    assert_eq!(sizes, (expected.0 as _, expected.1 as _, expected.2 as _, expected.3 as _, expected.4 as _));
    close("gravity", ours.gravity.as_slice(), &theirs.opt_gravity());
    close("timestep", &[ours.timestep], &[theirs.opt_timestep()]);
    for (i, body) in ours.bodies.iter().enumerate().skip(1) {
        let name = &body.name;
        assert_eq!(body.parent, theirs.body_parentid()[i] as usize, "parent of {name}");
        close(name, body.position.as_slice(), &theirs.body_pos()[i]);
        same_turn(name, &body.orientation, &theirs.body_quat()[i]);
        close(&format!("mass of {name}"), &[body.inertial.mass], &[theirs.body_mass()[i]]);
        close(&format!("gravcomp of {name}"), &[body.gravcomp], &[theirs.body_gravcomp()[i]]);
        // Where a massless body has its centre of mass means nothing.
        if body.inertial.mass > 0.0 {
            close(&format!("centre of mass of {name}"), body.inertial.com.as_slice(), &theirs.body_ipos()[i]);
        }
        // The tensors: axes of equal moments are anybody's choice.
        let axes = rotation::from_wxyz(theirs.body_iquat()[i]).unwrap();
        let tensor = lifelike_character::inertia::tensor(&axes, &Vec3::from(theirs.body_inertia()[i]));
        close(&format!("inertia of {name}"), body.inertial.tensor().as_slice(), tensor.as_slice());
    }
    compare_joints(ours, theirs);
    for (i, site) in ours.sites.iter().enumerate() {
        assert_eq!(site.body, theirs.site_bodyid()[i] as usize, "body of {}", site.name);
        close(&site.name, site.position.as_slice(), &theirs.site_pos()[i]);
        same_turn(&site.name, &site.orientation, &theirs.site_quat()[i]);
    }
    // Geoms that are pictures are not in the text for engines.
    let geoms: Vec<&Geom> = ours.geoms.iter().filter(|g| !matches!(g.shape, GeomShape::Mesh(_))).collect();
    let meshes = theirs.geom_dataid().iter().map(|d| *d >= 0).collect::<Vec<_>>();
    let solid: Vec<usize> = (0..meshes.len()).filter(|i| !meshes[*i]).collect();
    assert_eq!(geoms.len(), solid.len(), "number of geoms");
    for (geom, i) in geoms.into_iter().zip(solid) {
        compare_geom(geom, theirs, i);
    }
    compare_poses(ours, theirs);
}

fn compare_joints(ours: &Character, theirs: &Model) {
    for (i, joint) in ours.joints.iter().enumerate() {
        let name = &joint.name;
        assert_eq!(joint.kind as i32, theirs.jnt_type()[i], "kind of {name}");
        assert_eq!(joint.q_index, theirs.jnt_qposadr()[i] as usize, "position of {name}");
        let v = joint.v_index;
        assert_eq!(v, theirs.jnt_dofadr()[i] as usize, "velocity of {name}");
        close(name, joint.position.as_slice(), &theirs.jnt_pos()[i]);
        close(&format!("armature of {name}"), &[joint.armature], &[theirs.dof_armature()[v]]);
        close(&format!("damping of {name}"), &[joint.damping], &[theirs.dof_damping()[v]]);
        close(&format!("friction of {name}"), &[joint.frictionloss], &[theirs.dof_frictionloss()[v]]);
        close(&format!("stiffness of {name}"), &[joint.stiffness], &[theirs.jnt_stiffness()[i]]);
        assert_eq!(joint.range.is_some(), theirs.jnt_limited()[i], "limits of {name}");
        if let Some((low, high)) = joint.range {
            close(&format!("range of {name}"), &[low, high], &theirs.jnt_range()[i]);
        }
        if let Some((low, high)) = joint.actuator_force_range {
            close(&format!("force range of {name}"), &[low, high], &theirs.jnt_actfrcrange()[i]);
        }
        if matches!(joint.kind, JointKind::Hinge | JointKind::Slide) {
            close(&format!("axis of {name}"), joint.axis.as_slice(), &theirs.jnt_axis()[i]);
            close(&format!("reference of {name}"), &[joint.reference], &[theirs.qpos0()[joint.q_index]]);
            close(&format!("spring of {name}"), &[joint.spring_reference], &[theirs.qpos_spring()[joint.q_index]]);
        }
    }
    close("reference position", &ours.reference_position(), theirs.qpos0());
}

fn compare_geom(ours: &Geom, theirs: &Model, i: usize) {
    let name = &ours.name;
    assert_eq!(ours.body, theirs.geom_bodyid()[i] as usize, "body of {name}");
    let (kind, size) = match &ours.shape {
        GeomShape::Plane => (0, vec![]),
        GeomShape::Sphere(r) => (2, vec![*r]),
        GeomShape::Capsule(r, half) => (3, vec![*r, *half]),
        GeomShape::Ellipsoid(h) => (4, h.as_slice().to_vec()),
        GeomShape::Cylinder(r, half) => (5, vec![*r, *half]),
        GeomShape::Box(h) => (6, h.as_slice().to_vec()),
        GeomShape::Mesh(_) | GeomShape::HeightField(_) => panic!("{name} is not a solid"),
    };
    assert_eq!(kind, theirs.geom_type()[i], "shape of {name}");
    close(&format!("size of {name}"), &size, &theirs.geom_size()[i][..size.len()]);
    close(&format!("position of {name}"), ours.position.as_slice(), &theirs.geom_pos()[i]);
    same_turn(&format!("orientation of {name}"), &ours.orientation, &theirs.geom_quat()[i]);
    close(&format!("friction of {name}"), &ours.friction, &theirs.geom_friction()[i]);
    close(&format!("solref of {name}"), &ours.solref, &theirs.geom_solref()[i]);
    close(&format!("solimp of {name}"), &ours.solimp, &theirs.geom_solimp()[i]);
    close(&format!("margin of {name}"), &[ours.margin, ours.gap], &[theirs.geom_margin()[i], theirs.geom_gap()[i]]);
    let masks = (theirs.geom_contype()[i] as u32, theirs.geom_conaffinity()[i] as u32);
    assert_eq!((ours.contype, ours.conaffinity), masks, "masks of {name}");
    let contact = (theirs.geom_condim()[i] as u32, theirs.geom_priority()[i]);
    assert_eq!((ours.condim, ours.priority), contact, "condim and priority of {name}");
}

/// Poses and Jacobians at random positions.
fn compare_poses(ours: &Character, theirs: &Model) {
    let character = ours;
    let mut data = Data::new(theirs.copy().unwrap()).unwrap();
    let mut kinematics = Kinematics::new(ours);
    let mut random = ChaCha8Rng::seed_from_u64(7);
    for _ in 0..5 {
        let mut q = ours.reference_position();
        q.iter_mut().for_each(|x| *x += random.random_range(-0.8..0.8));
        // Ours are exact where joints follow others; MuJoCo's need their positions and velocities.
        let mut v: Vec<f64> = (0..ours.nv).map(|_| random.random_range(-1.0..1.0)).collect();
        ours.follow(&mut q, &mut v);
        data.qpos_mut().copy_from_slice(&q);
        data.kinematics();
        data.com_pos();
        kinematics.update(ours, &q);
        for (i, body) in ours.bodies.iter().enumerate() {
            close(&format!("place of {}", body.name), kinematics.body_position[i].as_slice(), &data.xpos()[i]);
            same_turn(&format!("turn of {}", body.name), &kinematics.body_orientation[i], &data.xquat()[i]);
            let point = kinematics.point(i, &Vec3::new(0.1, -0.2, 0.3));
            let ours = kinematics.jacobian(ours, i, &point);
            let [linear, angular] = data.jac(&point.into(), i);
            let what = format!("Jacobian of {}", body.name);
            let nv = v.len();
            if !character.couplings.is_empty() {
                let speeds = ours * nalgebra::DVector::from_column_slice(&v);
                let dot = |row: &[f64]| row.iter().zip(&v).map(|(j, v)| j * v).sum::<f64>();
                let theirs: Vec<f64> = linear.chunks_exact(nv).chain(angular.chunks_exact(nv)).map(dot).collect();
                close(&what, speeds.as_slice(), &theirs);
                continue;
            }
            for row in 0..3 {
                let [l, a] = [row, row + 3].map(|r| ours.row(r).iter().copied().collect::<Vec<_>>());
                close(&what, &l, &linear[row * nv..(row + 1) * nv]);
                close(&what, &a, &angular[row * nv..(row + 1) * nv]);
            }
        }
    }
}

/// Compares on the original text and on the text that we hand to engines.
fn both_texts(text: &str, name: &str) {
    let ours = Character::from_mjcf(text, name, None).unwrap();
    compare(&ours, &Model::from_xml_string(text).unwrap());
    compare(&ours, &Model::from_xml_string(ours.mjcf.as_deref().unwrap()).unwrap());
}

#[test]
fn our_robots() {
    for name in ["lima", "humanoid"] {
        let path = root().join("robots").join(format!("{name}.xml"));
        both_texts(&std::fs::read_to_string(path).unwrap(), name);
    }
}

#[test]
fn humanoids_of_dm_control() {
    for name in ["humanoid.xml", "humanoid_CMU.xml"] {
        both_texts(&without_pictures(&fetched("dm_control", name)), name);
    }
}

#[test]
fn unitree_g1() {
    // Its meshes are pictures that weigh nothing, and are not fetched.
    let text = std::fs::read_to_string(fetched("unitree_g1", "g1.xml")).unwrap();
    let solid: Vec<&str> = text.lines().filter(|l| !l.contains("<mesh ") && !l.contains(" mesh=")).collect();
    both_texts(&solid.join("\n"), "g1.xml");
}

#[test]
#[ignore = "needs robots that nobody offers as one exact download: LIFELIKE_DATA"]
fn shared_robots() {
    both_texts(&without_pictures(&shared("amp_humanoid.xml")), "amp_humanoid.xml");
    // The meshes of these are absent.
    for name in ["open_duck_mini_v2/robot.xml", "open_duck_mini_v2/scene.xml", "toddlerbot_active.xml"] {
        let ours = Character::load(shared(name)).unwrap();
        compare(&ours, &Model::from_xml_string(ours.mjcf.as_deref().unwrap()).unwrap());
    }
}

/// MuJoCo's own URDF import, told to keep fixed links and to float, makes the same bodies.
#[test]
fn urdf() {
    let text = r#"<robot name="two">
      <mujoco><compiler fusestatic="false"/></mujoco>
      <link name="world"/>
      <link name="trunk">
        <inertial><origin xyz="0.1 0 0.2" rpy="0.3 -0.4 1.2"/><mass value="3.5"/>
          <inertia ixx="0.03" iyy="0.04" izz="0.05" ixy="0.002" ixz="-0.003" iyz="0.001"/></inertial>
        <collision><origin xyz="0 0.1 0" rpy="0.5 0.2 0.1"/><geometry><box size="0.1 0.2 0.3"/></geometry></collision>
      </link>
      <link name="arm">
        <collision><geometry><cylinder radius="0.02" length="0.3"/></geometry></collision>
        <collision><origin xyz="0 0 0.2"/><geometry><sphere radius="0.05"/></geometry></collision>
      </link>
      <link name="tip"><inertial><mass value="0.1"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <joint name="base" type="floating"><parent link="world"/><child link="trunk"/></joint>
      <joint name="swing" type="revolute"><origin xyz="0 0.2 0.1" rpy="0.1 0.2 0.3"/><parent link="trunk"/><child link="arm"/>
        <axis xyz="0 1 1"/><limit lower="-1" upper="2" effort="7" velocity="3"/><dynamics damping="0.3" friction="0.2"/></joint>
      <joint name="slide" type="prismatic"><origin xyz="0 0 0.3"/><parent link="arm"/><child link="tip"/>
        <limit lower="0" upper="0.1" effort="5"/></joint>
    </robot>"#;
    let ours = Character::from_urdf(text, "two.urdf", None).unwrap();
    compare(&ours, &Model::from_xml_string(text).unwrap());
    compare(&ours, &Model::from_xml_string(ours.mjcf.as_deref().unwrap()).unwrap());
}

/// What is put right of a URDF is what its text says to MuJoCo: joints held at an angle, moments, links without mass, a foot's box.
#[test]
fn urdf_put_right() {
    let folder = tempfile::tempdir().unwrap();
    let facet = "facet normal 0 0 1\nouter loop\nvertex -6 -4 -3\nvertex 14 5 1\nvertex -6 5 0\nendloop\nendfacet\n";
    std::fs::write(folder.path().join("foot.stl"), format!("solid foot\n{facet}endsolid foot\n")).unwrap();
    let inertia = r#"<inertia ixx="0.03" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/>"#;
    let joint = |name: &str, [parent, child]: [&str; 2], more: &str| {
        format!(
            r#"<joint name="{name}" type="revolute"><origin xyz="0.1 0.2 -0.3" rpy="0.4 0.5 0.6"/><parent link="{parent}"/><child link="{child}"/>
            <axis xyz="0 0.6 0.8"/><limit lower="-1" upper="1" effort="3" velocity="1"/>{more}</joint>"#
        )
    };
    let text = [
        r#"<robot name="r"><link name="trunk"><inertial><mass value="4"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link><link name="ankle"/>"#.to_string(),
        format!(r#"<link name="foot"><inertial><origin rpy="0.1 0.2 0.3"/><mass value="1"/>{inertia}</inertial><collision><origin xyz="0 0 -0.05" rpy="1 2 3"/>
            <geometry><mesh filename="foot.stl" scale="0.01 0.01 0.02"/></geometry></collision></link>"#),
        format!(r#"<link name="a"><inertial><mass value="0.1"/>{inertia}</inertial></link><link name="b"><inertial><mass value="0.2"/>{inertia}</inertial></link>"#),
        joint("ankle_z", ["trunk", "ankle"], ""),
        joint("ankle_x", ["ankle", "foot"], ""),
        joint("finger", ["trunk", "a"], ""),
        joint("thumb", ["trunk", "b"], r#"<mimic joint="finger" multiplier="-1" offset="0.3"/>"#),
        "</robot>".into(),
    ]
    .concat();
    let mut ours = Character::from_urdf(&text, "r.urdf", Some(folder.path())).unwrap();
    let foot = ours.body("foot").unwrap();
    assert_eq!(ours.fit_boxes(&[foot]).len(), 1);
    compare(&ours, &Model::from_xml_string(ours.mjcf.as_deref().unwrap()).unwrap());
}

/// Every way to write an orientation, a shape, a default, a limit.
#[test]
fn corners_of_the_format() {
    let text = r#"<mujoco model="corners">
      <compiler angle="degree" eulerseq="zYx" boundmass="0.01" boundinertia="1e-5" balanceinertia="true"/>
      <option timestep="0.004" gravity="1 2 -3"/>
      <default>
        <geom friction="0.9 0.02" solref="0.01 0.9" density="800" rgba="1 0 0 1"/>
        <joint damping="0.5" armature="0.1" limited="true" range="-10 20"/>
        <default class="outer">
          <geom friction="0.4" type="capsule" size="0.05 0.1" solimp="0.8"/>
          <joint axis="1 1 0" stiffness="3" springref="15"/>
          <default class="inner"><geom euler="10 20 30" margin="0.01" gap="0.002" condim="4" priority="2"/></default>
        </default>
      </default>
      <worldbody>
        <geom type="plane" size="1 1 1" zaxis="0.1 0 1"/>
        <geom type="box" size="0.3 0.2 0.1" pos="3 0 0"/>
        <body name="base" pos="0 0 1" euler="10 20 30">
          <freejoint/>
          <geom type="box" size="0.1 0.2 0.3" pos="0.1 0 0" euler="5 10 15"/>
          <geom type="ellipsoid" size="0.1 0.2 0.3" pos="0 0.5 0" axisangle="1 2 3 40"/>
          <geom type="cylinder" size="0.1 0.2" pos="0 -0.5 0" xyaxes="1 0.2 0 0 1 0.3" mass="2.5"/>
          <geom type="capsule" size="0.05" fromto="0 0 0 0.1 0.2 0.3"/>
          <geom type="cylinder" size="0.04" fromto="0 0 0.4 0.1 0.2 0.1"/>
          <geom type="box" size="0.04" fromto="0.5 0 0.4 0.1 0.2 0.1"/>
          <geom type="ellipsoid" size="0.03" fromto="0 0 -0.4 0 0 -0.9"/>
          <geom type="sphere" size="0.07" group="3" pos="0.3 0.3 0.3"/>
          <geom type="sphere" size="0.07" mass="0" pos="1 0 0"/>
          <site name="a" pos="0.1 0.2 0.3" zaxis="0 1 1"/>
          <site name="b" type="capsule" size="0.01" fromto="0 0 0 1 0 0"/>
          <frame pos="0.1 0.2 0.3" euler="30 0 0" childclass="outer">
            <body name="limb" pos="0.5 0 0" quat="1 2 3 4">
              <joint name="j1" pos="0 0 0.1"/>
              <joint name="j2" axis="0 0 1" type="slide" range="-0.1 0.2" springref="0.05" ref="0.02"/>
              <geom/>
              <geom class="inner" friction="0.1 0.2 0.3"/>
              <geom class="inner" quat="1 0 0 1"/>
              <frame euler="0 45 0">
                <frame pos="0 0 0.2" axisangle="1 0 0 30">
                  <joint name="j3" limited="false" pos="0.1 0 0"/>
                  <geom class="inner" type="box" size="0.1 0.1 0.2" axisangle="0 1 0 20" pos="0.1 0 0"/>
                  <site name="c"/>
                  <body name="tip" pos="0 0 0.2">
                    <joint name="ball" type="ball" range="0 60"/>
                    <inertial pos="0.01 0.02 0.03" mass="0.7" fullinertia="0.03 0.04 0.05 0.001 -0.002 0.003"/>
                  </body>
                </frame>
              </frame>
              <body name="bounded"><inertial pos="0 0 0" mass="0.001" diaginertia="1e-7 1e-7 1e-7"/></body>
              <body name="unbalanced"><inertial pos="0 0 0" euler="1 2 3" mass="1" diaginertia="1 0.1 0.1"/></body>
            </body>
          </frame>
        </body>
      </worldbody>
    </mujoco>"#;
    both_texts(text, "corners");
    both_texts(
        &text.replace("zYx", "XYZ").replace("boundmass", "settotalmass=\"12\" inertiagrouprange=\"0 2\" boundmass"),
        "corners",
    );
    both_texts(
        &text
            .replace("angle=\"degree\"", "inertiafromgeom=\"true\"")
            .replace("<body name=\"bounded\">", "<body name=\"bounded\"><geom/>")
            .replace("<body name=\"unbalanced\">", "<body name=\"unbalanced\"><geom/>")
            .replace("<body name=\"tip\" pos=\"0 0 0.2\">", "<body name=\"tip\"><geom/>"),
        "corners",
    );
}
