//! `<worldbody>` and the bodies in it.

use std::collections::BTreeMap;

use crate::error::CharacterError;
use crate::inertia::{self, MIN_MASS};
use crate::mjcf::attributes::{Attributes, Tristate};
use crate::mjcf::compiler::Compiler;
use crate::mjcf::defaults::Defaults;
use crate::mjcf::document::Element;
use crate::mjcf::geoms::{self, ReadGeom, Weight};
use crate::mjcf::joints;
use crate::mjcf::pose::{POSE, Pose};
use crate::mjcf::solids::Solids;
use crate::model::{Body, Geom, GeomShape, Inertial, Joint, JointKind, Site, welded};
use crate::rotation::{Mat3, Quat, Vec3};

/// The bodies read so far, in document order.
#[derive(Debug, Default)]
pub(crate) struct Tree {
    pub bodies: Vec<Body>,
    pub joints: Vec<Joint>,
    pub geoms: Vec<Geom>,
    pub sites: Vec<Site>,
    /// Bodies that a program moves.
    pub mocap: usize,
    /// Lights and cameras.
    pub pictures: usize,
    /// Flag that a body's inertia is that of meshes, which may be missing from the text for other engines.
    pub weighs_meshes: bool,
    /// Joints whose spring is given by its time constant (s) and damping ratio.
    pub spring_dampers: Vec<(usize, [f64; 2])>,
}

/// Content of a body before its children are read.
struct Parts<'a> {
    joints: Vec<Joint>,
    /// Those of `joints` with a time constant and a damping ratio.
    spring_dampers: Vec<(usize, [f64; 2])>,
    geoms: Vec<ReadGeom>,
    sites: Vec<Site>,
    /// Child bodies with the frame and class that surround them.
    children: Vec<(&'a Element, Pose, Option<&'a str>)>,
    inertial: Option<Inertial>,
}

pub(crate) struct Reader<'a> {
    pub compiler: &'a Compiler,
    pub defaults: &'a Defaults,
    /// Colours of materials by name.
    pub materials: BTreeMap<String, [f32; 4]>,
    pub solids: Solids<'a>,
    pub tree: Tree,
}

impl<'a> Reader<'a> {
    /// Reads all `<worldbody>` sections as body 0.
    pub fn read_world(&mut self, root: &'a Element) -> Result<(), CharacterError> {
        let mut parts = Parts::new();
        for world in root.children_named("worldbody") {
            Attributes::own(world).only(&["name", "childclass"])?;
            let class = self.childclass(world, None)?;
            self.collect(world, 0, class, &Pose::identity(), &mut parts)?;
        }
        if let Some(joint) = parts.joints.first() {
            let world = root.children_named("worldbody").next().unwrap_or(root);
            return Err(world.invalid("no joint in the world body", format!("'{}'", joint.name)));
        }
        self.tree.bodies.push(Body {
            name: "world".into(),
            parent: 0,
            position: Vec3::zeros(),
            orientation: Quat::identity(),
            inertial: inertia::sum(&[]),
            joints: 0..0,
            gravcomp: 0.0,
        });
        self.finish(0, parts)
    }

    fn childclass(&self, element: &'a Element, outer: Option<&'a str>) -> Result<Option<&'a str>, CharacterError> {
        match element.attribute("childclass") {
            None => Ok(outer),
            Some(name) if self.defaults.contains(name) => Ok(Some(name)),
            Some(name) => Err(element.invalid("a default class for 'childclass'", format!("'{name}'"))),
        }
    }

    fn read_body(
        &mut self,
        element: &'a Element,
        parent: usize,
        class: Option<&'a str>,
        frame: &Pose,
    ) -> Result<(), CharacterError> {
        let a = Attributes::own(element);
        let mut known = vec!["name", "childclass", "mocap", "gravcomp", "user", "sleep"];
        known.extend(POSE);
        a.only(&known)?;
        let mocap = a.boolean("mocap", false)?;
        let class = self.childclass(element, class)?;
        let index = self.tree.bodies.len();
        let mut parts = Parts::new();
        self.collect(element, index, class, &Pose::identity(), &mut parts)?;
        if mocap && (parent != 0 || !parts.joints.is_empty()) {
            return Err(a.invalid("a mocap body in the world, without joints", "another arrangement"));
        }
        self.tree.mocap += usize::from(mocap);
        if parts.joints.iter().any(|j| j.kind == JointKind::Free) && (parent != 0 || parts.joints.len() > 1) {
            return Err(a.invalid("a free joint as the only joint of a body in the world", "another arrangement"));
        }
        let pose = frame.then(&Pose::read(&a, self.compiler)?);
        let inertial = self.mass(&a, &mut parts)?;
        let first = self.tree.joints.len();
        self.tree.bodies.push(Body {
            name: a.text("name").unwrap_or("").to_string(),
            parent,
            position: pose.position,
            orientation: pose.orientation,
            inertial,
            joints: first..first + parts.joints.len(),
            gravcomp: a.number("gravcomp")?.unwrap_or(0.0),
        });
        self.finish(index, parts)?;
        self.moving_has_mass(index, &a)
    }

    /// Hands the parts over and reads the child bodies.
    fn finish(&mut self, index: usize, parts: Parts<'a>) -> Result<(), CharacterError> {
        let first = self.tree.joints.len();
        self.tree.joints.extend(parts.joints);
        self.tree.spring_dampers.extend(parts.spring_dampers.iter().map(|(joint, given)| (first + joint, *given)));
        self.tree.geoms.extend(parts.geoms.into_iter().map(|g| g.geom));
        self.tree.sites.extend(parts.sites);
        for (child, frame, class) in parts.children {
            self.read_body(child, index, class, &frame)?;
        }
        Ok(())
    }

    /// Reads what stands in a body, or in a `<frame>` within it.
    fn collect(
        &mut self,
        element: &'a Element,
        body: usize,
        class: Option<&'a str>,
        frame: &Pose,
        parts: &mut Parts<'a>,
    ) -> Result<(), CharacterError> {
        for child in &element.children {
            match child.name.as_str() {
                "body" => parts.children.push((child, *frame, class)),
                "frame" => {
                    let a = Attributes::own(child);
                    let mut known = vec!["name", "childclass"];
                    known.extend(POSE);
                    a.only(&known)?;
                    let inner = frame.then(&Pose::read(&a, self.compiler)?);
                    let class = self.childclass(child, class)?;
                    self.collect(child, body, class, &inner, parts)?;
                }
                "inertial" => {
                    if parts.inertial.is_some() || element.name != "body" {
                        return Err(child.invalid("one <inertial> directly in a body", "another"));
                    }
                    parts.inertial = Some(read_inertial(&Attributes::own(child), self.compiler)?);
                }
                "joint" => {
                    let a = self.defaults.resolve(child, class)?;
                    let given = a.numbers::<2>("springdamper")?.filter(|given| *given != [0.0; 2]);
                    if let Some(wrong) = given.filter(|given| given.iter().any(|x| *x <= 0.0)) {
                        return Err(a.invalid("two positive numbers for 'springdamper'", format!("{wrong:?}")));
                    }
                    parts.spring_dampers.extend(given.map(|given| (parts.joints.len(), given)));
                    parts.joints.push(joints::read(&a, false, body, frame, self.compiler)?);
                }
                "freejoint" => {
                    let a = Attributes::own(child);
                    // MuJoCo aligns bodies without children alone.
                    if a.text("align") == Some("true") && element.children_named("body").next().is_none() {
                        return Err(a.unsupported("attribute 'align' that is true: it would move the body's frame"));
                    }
                    parts.joints.push(joints::read(&a, true, body, frame, self.compiler)?);
                }
                "geom" => {
                    let a = self.defaults.resolve(child, class)?;
                    let mut read = geoms::read(&a, body, frame, self.compiler)?;
                    let material = a.text("material").filter(|_| a.text("rgba").is_none());
                    if let Some(colour) = material.and_then(|name| self.materials.get(name)) {
                        read.geom.rgba = *colour;
                    }
                    parts.geoms.push(read);
                }
                "site" => {
                    let a = self.defaults.resolve(child, class)?;
                    parts.sites.push(geoms::read_site(&a, body, frame, self.compiler)?);
                }
                "light" | "camera" => self.tree.pictures += 1,
                "attach" => {
                    let cure = "(spec = mujoco.MjSpec.from_file(FILE); spec.compile(); spec.to_xml())";
                    return Err(child.unsupported(format!("element in a body; MuJoCo writes the whole model {cure}")));
                }
                _ => return Err(child.unsupported("element in a body")),
            }
        }
        Ok(())
    }

    /// Returns the mass and inertia of a body: as said, or from its geoms.
    fn mass(&mut self, a: &Attributes, parts: &mut Parts<'a>) -> Result<Inertial, CharacterError> {
        let from_geoms = match self.compiler.inertiafromgeom {
            Tristate::True => true,
            Tristate::False => false,
            Tristate::Auto => parts.inertial.is_none(),
        };
        let mut inertial = parts.inertial.take().unwrap_or_else(|| inertia::sum(&[]));
        let [low, high] = self.compiler.inertiagrouprange;
        let chosen: Vec<&ReadGeom> = parts.geoms.iter().filter(|g| (low..=high).contains(&(g.group as f64))).collect();
        if from_geoms && !chosen.is_empty() {
            let mut weights = Vec::with_capacity(chosen.len());
            for read in chosen {
                match &read.weight {
                    Weight::Known(weight) => weights.push(weight.clone()),
                    Weight::OfMesh { mass, density } => {
                        self.tree.weighs_meshes = true;
                        weights.push(self.solid(a, &read.geom, *mass, *density)?);
                    }
                }
            }
            inertial = inertia::sum(&weights);
        }
        inertial.mass = inertial.mass.max(self.compiler.boundmass);
        inertial.diagonal = inertial.diagonal.map(|x| x.max(self.compiler.boundinertia));
        balance(a, &mut inertial, self.compiler.balanceinertia)?;
        Ok(inertial)
    }

    /// Returns the mass and inertia of a mesh in the frame of its body.
    fn solid(&self, a: &Attributes, geom: &Geom, mass: Option<f64>, density: f64) -> Result<Inertial, CharacterError> {
        let GeomShape::Mesh(name) = &geom.shape else { return Ok(inertia::sum(&[])) };
        let solid = self.solids.of(name).map_err(|why| {
            let body = a.text("name").unwrap_or("");
            a.invalid(format!("<inertial> in body '{body}', as the inertia of its meshes is unknown"), why)
        })?;
        let factor = mass.map_or(density, |mass| mass / solid.mass);
        Ok(Inertial {
            mass: solid.mass * factor,
            com: geom.position + geom.orientation * solid.com,
            orientation: geom.orientation * solid.orientation,
            diagonal: solid.diagonal * factor,
        })
    }

    /// Checks that a body with joints has mass in itself or in what is welded to it.
    fn moving_has_mass(&self, index: usize, a: &Attributes) -> Result<(), CharacterError> {
        let body = &self.tree.bodies[index];
        if body.joints.is_empty() {
            return Ok(());
        }
        let weighs = |inertial: &Inertial| inertial.mass >= MIN_MASS && inertial.diagonal.min() >= 0.0;
        let mut parts = welded(&self.tree.bodies, index).into_iter().zip(&self.tree.bodies);
        if parts.any(|(is_part, body)| is_part && weighs(&body.inertial)) {
            return Ok(());
        }
        Err(a.invalid(format!("mass in the moving body '{}'", body.name), "none"))
    }
}

impl Parts<'_> {
    fn new() -> Self {
        Self {
            joints: Vec::new(),
            spring_dampers: Vec::new(),
            geoms: Vec::new(),
            sites: Vec::new(),
            children: Vec::new(),
            inertial: None,
        }
    }
}

/// Checks the moments: no mass distribution has a moment larger than the two others together.
fn balance(a: &Attributes, inertial: &mut Inertial, fix: bool) -> Result<(), CharacterError> {
    let d = inertial.diagonal;
    if inertia::balanced(&d) {
        return Ok(());
    }
    if !fix {
        let name = a.text("name").unwrap_or("");
        return Err(a.invalid(
            format!("moments of inertia of body '{name}' of which none exceeds the others together (or compiler balanceinertia)"),
            format!("{} {} {}", d.x, d.y, d.z),
        ));
    }
    inertial.diagonal = Vec3::repeat(d.sum() / 3.0);
    Ok(())
}

fn read_inertial(a: &Attributes, compiler: &Compiler) -> Result<Inertial, CharacterError> {
    let mut known = vec!["mass", "diaginertia", "fullinertia"];
    known.extend(POSE);
    a.only(&known)?;
    a.required("pos")?;
    let pose = Pose::read(a, compiler)?;
    let mass = a.number("mass")?.ok_or_else(|| a.invalid("attribute 'mass'", "none"))?;
    if mass < 0.0 {
        return Err(a.invalid("a mass that is not negative", mass.to_string()));
    }
    let com = pose.position;
    if let Some([xx, yy, zz, xy, xz, yz]) = a.numbers::<6>("fullinertia")? {
        if a.text("diaginertia").is_some() || POSE[1..].iter().any(|o| a.text(o).is_some()) {
            return Err(a.invalid("'fullinertia' without 'diaginertia' and orientation", "both"));
        }
        let (orientation, diagonal) = inertia::principal(&Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz));
        if diagonal.min() < 0.0 {
            return Err(a.invalid("a positive definite 'fullinertia'", a.text("fullinertia").unwrap_or("").to_string()));
        }
        return Ok(Inertial { mass, com, orientation, diagonal });
    }
    let diagonal = a
        .numbers::<3>("diaginertia")?
        .map(Vec3::from)
        .ok_or_else(|| a.invalid("attribute 'diaginertia' or 'fullinertia'", "none"))?;
    if diagonal.min() < 0.0 {
        return Err(a.invalid("moments that are not negative", a.text("diaginertia").unwrap_or("").to_string()));
    }
    Ok(Inertial { mass, com, orientation: pose.orientation, diagonal })
}
