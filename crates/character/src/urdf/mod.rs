//! URDF in: translated to MJCF and compiled as such.
//!
//! Differences from MuJoCo's own import:
//!
//! - Fixed links stay bodies (MuJoCo's `fusestatic` merges them), so that every link has a name.
//! - The root link floats unless it is called `world` (MuJoCo fixes it).
//! - Meshes do not collide until [`Character::fit_boxes`] replaces them by boxes: convex hulls of neighbours overlap,
//!   and URDF does not state which bodies may.
//!
//! `effort` limits become `actuatorfrcrange`. Links without `<inertial>` get the mass of their collision shapes at 1000
//! kg/m³.
//!
//! Defects of real files are repaired, with a line of [`Character::warnings`] each. Joints that
//! mimic others become equality constraints ([`mimic`]). Impossible moments of inertia are replaced ([`inertial`]). Massless moving links get a negligible
//! mass; joints whose subtree has no mass are fixed. Meshes are found without the build system of their packages
//! ([`package`]).
//!
//! Visual meshes are kept for pictures; other visuals, transmissions and simulator extensions are noted or ignored.
//! Planar joints are refused. A root with a floating joint is the world, whatever its name.

mod inertial;
mod limits;
mod mimic;
mod package;
mod tree;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::error::{CharacterError, Location};
use crate::mjcf::Meshes;
use crate::mjcf::attributes::Attributes;
use crate::mjcf::document::{self, Element, numbers};
use crate::model::Character;
use crate::rotation::{Quat, Vec3, to_wxyz};

type Isometry = nalgebra::Isometry3<f64>;

use limits::Limits;
use mimic::Mimics;
use tree::Tree;

/// Deeper chains of links than any robot has.
const MAX_DEPTH: usize = 150;
/// Angles about an axis beyond this say nothing more (rad), rounding included.
const FULL_TURN: f64 = std::f64::consts::TAU + 1e-4;

impl Character {
    /// Compiles URDF text. `file` is what errors call the text; meshes are looked for from `folder`.
    pub fn from_urdf(text: &str, file: &str, folder: Option<&Path>) -> Result<Self, CharacterError> {
        let root = document::parse(text, Path::new(file), folder)?.root;
        if root.name != "robot" {
            return Err(root.invalid("root element 'robot'", format!("'{}'", root.name)));
        }
        compile(&root, folder)
    }
}

/// Compiles the `<robot>` element.
pub(crate) fn compile(robot: &Element, folder: Option<&Path>) -> Result<Character, CharacterError> {
    let mut translation = Translation::new(robot, folder)?;
    let mjcf = translation.model(robot)?;
    let mut character = crate::mjcf::compile(mjcf, folder, Meshes::None)?;
    for joint in &mut character.joints {
        joint.velocity_limit = translation.limits.velocity(&joint.name);
    }
    character.notes.splice(0..0, translation.notes());
    character.warnings.splice(0..0, translation.warnings());
    Ok(character)
}

struct Translation<'a> {
    links: BTreeMap<&'a str, &'a Element>,
    /// Joints that hang on a link, in document order.
    joints: BTreeMap<&'a str, Vec<&'a Element>>,
    root: &'a Element,
    folder: Option<&'a Path>,
    mimics: Mimics<'a>,
    limits: Limits,
    /// Bodies that float, of which none hangs on another.
    floating: Vec<Element>,
    meshes: Vec<Element>,
    visuals: usize,
    without_inertial: usize,
    /// Links whose moments were impossible.
    balanced: Vec<&'a str>,
    /// Links whose moments lack products.
    crossless: Vec<&'a str>,
    /// Links that move, weigh nothing and carry others.
    weightless: Vec<&'a str>,
    /// Joints that move nothing that weighs.
    idle: Vec<&'a str>,
    /// Links with a shape of size 0.
    sizeless: Vec<&'a str>,
    /// Joints whose origin is turned by more than a full turn.
    turned: Vec<&'a str>,
}

impl<'a> Translation<'a> {
    fn new(robot: &'a Element, folder: Option<&'a Path>) -> Result<Self, CharacterError> {
        let Tree { links, joints, root } = Tree::read(robot)?;
        let mut translation = Self {
            links,
            joints,
            root,
            folder,
            mimics: Mimics::default(),
            limits: Limits::default(),
            floating: Vec::new(),
            meshes: Vec::new(),
            visuals: 0,
            without_inertial: 0,
            balanced: Vec::new(),
            crossless: Vec::new(),
            weightless: Vec::new(),
            idle: Vec::new(),
            sizeless: Vec::new(),
            turned: Vec::new(),
        };
        let joints: Vec<&Element> = robot.children_named("joint").collect();
        translation.mimics = Mimics::read(&joints, |joint| translation.mass_below(joint))?;
        Ok(translation)
    }

    /// The link that a joint moves.
    fn moved(&self, joint: &Element) -> Option<&'a Element> {
        self.links.get(child(joint, "child")?.attribute("link")?).copied()
    }

    /// Links at a link and below it, as far as joints are followed. Loops of links that hang on nothing end where chains do.
    fn from(&self, link: &'a Element, follow: &dyn Fn(&Element) -> bool) -> Vec<&'a Element> {
        let mut links = vec![(link, 0)];
        let mut next = 0;
        while let Some(&(link, depth)) = links.get(next) {
            next += 1;
            let joints = self.joints.get(link.attribute("name").unwrap_or_default());
            let joints = joints.into_iter().flatten().filter(|joint| depth < MAX_DEPTH && follow(joint));
            links.extend(joints.filter_map(|joint| Some((self.moved(joint)?, depth + 1))));
        }
        links.into_iter().map(|(link, _)| link).collect()
    }

    /// Returns the mass that a joint moves (kg), by the links; `None` if nothing of it weighs.
    fn mass_below(&self, joint: &Element) -> Option<f64> {
        let links = self.from(self.moved(joint)?, &|_| true);
        links.iter().any(|link| weighs(link)).then(|| links.into_iter().map(inertial::mass).sum())
    }

    fn is_fixed(&self, joint: &Element) -> bool {
        joint.attribute("type") == Some("fixed") || self.mimics.held(joint).is_some()
    }

    fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if self.visuals > 0 {
            notes.push(format!("{} visuals are not used", self.visuals));
        }
        if self.without_inertial > 0 {
            notes.push(format!("{} links have no <inertial>", self.without_inertial));
        }
        notes
    }

    fn warnings(&self) -> Vec<String> {
        let mut warnings = self.mimics.warnings.clone();
        warnings.extend(self.limits.warnings());
        let mut say = |what: &str, names: &[&str]| {
            if !names.is_empty() {
                warnings.push(format!("{what}: {}", names.join(", ")));
            }
        };
        say("moments of inertia that no body has were replaced, of links", &self.balanced);
        say("moments of inertia without ixy, ixz or iyz, which are taken for zero, of links", &self.crossless);
        say("links that move and weigh nothing weigh next to nothing now", &self.weightless);
        say("joints that move nothing that weighs are held", &self.idle);
        say("shapes of size 0 are left out, of links", &self.sizeless);
        say("origins whose rpy is more than a full turn, which looks like degrees (rpy is in rad), of", &self.turned);
        warnings
    }

    fn model(&mut self, robot: &'a Element) -> Result<Element, CharacterError> {
        let mut world = element(robot, "worldbody", &[]);
        if self.root.attribute("name") == Some("world") || self.floats_below(self.root) {
            self.fill(self.root, &mut world, Some(Isometry::identity()), 0)?;
        } else {
            let name = self.root.attribute("name").unwrap_or("").to_string();
            let mut body = element(self.root, "body", &[("name", name)]);
            body.children.push(element(self.root, "freejoint", &[]));
            self.fill(self.root, &mut body, None, 0)?;
            world.children.push(body);
        }
        world.children.append(&mut self.floating);
        let mut compiler = element(
            robot,
            "compiler",
            &[("angle", "radian".into()), ("eulerseq", "XYZ".into()), ("autolimits", "true".into())],
        );
        // MuJoCo's extension: those of its settings that still mean something here.
        for given in robot.children_named("mujoco").flat_map(|m| m.children_named("compiler")) {
            let kept = [
                "meshdir",
                "strippath",
                "balanceinertia",
                "boundmass",
                "boundinertia",
                "settotalmass",
                "inertiafromgeom",
            ];
            let kept = given.attributes.iter().filter(|(n, _)| kept.contains(&n.as_str()));
            compiler.attributes.extend(kept.cloned());
        }
        let mut assets = element(robot, "asset", &[]);
        assets.children = std::mem::take(&mut self.meshes);
        let mut model = element(robot, "mujoco", &[("model", robot.attribute("name").unwrap_or("robot").to_string())]);
        let mut moving = BTreeSet::new();
        joint_names(&world, &mut moving);
        let equality = self.mimics.constraints(robot, |joint| moving.contains(joint));
        model.children = vec![compiler, assets, world, equality];
        model.children.extend(robot.children_named("mujoco").flat_map(|m| m.children_named("option")).cloned());
        Ok(model)
    }

    /// Returns whether a floating joint hangs on a link by fixed joints only: such a root is the world, whatever its name.
    fn floats_below(&self, link: &'a Element) -> bool {
        let fixed = self.from(link, &|joint| joint.attribute("type") == Some("fixed"));
        let joints = fixed.into_iter().filter_map(|link| self.joints.get(link.attribute("name")?));
        joints.flatten().any(|joint| joint.attribute("type") == Some("floating"))
    }

    /// Puts what a link holds, and the links that hang on it, into a body. `place` is the link's pose in the world where it does
    /// not move.
    fn fill(
        &mut self,
        link: &'a Element,
        body: &mut Element,
        place: Option<Isometry>,
        depth: usize,
    ) -> Result<(), CharacterError> {
        if depth > MAX_DEPTH {
            return Err(link.invalid(format!("a chain of at most {MAX_DEPTH} links"), "more"));
        }
        if body.name == "body" {
            let moves = body.children.iter().any(|c| matches!(c.name.as_str(), "joint" | "freejoint"));
            self.weigh(link, moves, body)?;
        }
        for collision in link.children_named("collision") {
            let geom = self.geom(collision)?;
            match has_size(&geom) {
                true => body.children.push(geom),
                false => self.sizeless.push(link.attribute("name").unwrap_or_default()),
            }
        }
        let before = body.children.len();
        if body.name == "body" {
            body.children.extend(link.children_named("visual").filter_map(|visual| self.picture(visual)));
        }
        self.visuals += link.children_named("visual").count() - (body.children.len() - before);
        let name = link.attribute("name").unwrap_or("");
        for joint in self.joints.get(name).cloned().unwrap_or_default() {
            let Some(link) = self.moved(joint) else { continue };
            let mut inner = element(link, "body", &[("name", link.attribute("name").unwrap_or("").to_string())]);
            if pose(joint)?.1.amax() > FULL_TURN {
                self.turned.push(joint.attribute("name").unwrap_or_default());
            }
            let idle = !self.is_fixed(joint) && self.mass_below(joint).is_none();
            if idle {
                self.idle.push(joint.attribute("name").unwrap_or_default());
            }
            let origin = match self.mimics.held(joint) {
                Some(position) if position != 0.0 => held_at(joint, position)?,
                _ => origin(joint)?,
            };
            let floats = joint.attribute("type") == Some("floating") && !self.is_fixed(joint) && !idle;
            let here = if floats {
                place.map(|place| place * origin).ok_or_else(|| {
                    joint.invalid("a floating joint on links that do not move", "one that hangs on a moving link")
                })?
            } else {
                origin
            };
            inner.attributes.extend(placed(&here));
            if !idle && !self.is_fixed(joint) {
                inner.children.push(self.joint(joint)?);
            }
            let place = place.filter(|_| idle || self.is_fixed(joint)).map(|place| place * origin);
            self.fill(link, &mut inner, place, depth + 1)?;
            if floats { self.floating.push(inner) } else { body.children.push(inner) }
        }
        Ok(())
    }

    /// Gives a body the mass of its link.
    fn weigh(&mut self, link: &'a Element, moves: bool, body: &mut Element) -> Result<(), CharacterError> {
        let name = link.attribute("name").unwrap_or_default();
        let given = child(link, "inertial").map(inertial::translate).transpose()?;
        self.without_inertial += usize::from(given.is_none());
        if moves && !self.from(link, &|joint| self.is_fixed(joint)).into_iter().any(weighs) {
            self.weightless.push(name);
            body.children.push(inertial::nothing(link));
        } else if let Some((inertial, balanced)) = given {
            let moments = child(link, "inertial").and_then(|inertial| child(inertial, "inertia"));
            let has = |name: &&str| moments.is_some_and(|moments| moments.attribute(name).is_some());
            if !["ixy", "ixz", "iyz"].iter().all(has) {
                self.crossless.push(name);
            }
            if balanced {
                self.balanced.push(name);
            }
            body.children.push(inertial);
        }
        Ok(())
    }

    fn geom(&mut self, collision: &Element) -> Result<Element, CharacterError> {
        let geometry = child(collision, "geometry").and_then(|g| g.children.first());
        let shape = geometry.ok_or_else(|| collision.invalid("<geometry> with a shape", "none"))?;
        let a = Attributes::own(shape);
        let need = |name: &str| a.number(name)?.ok_or_else(|| a.invalid(format!("attribute '{name}'"), "none"));
        let mut geom = element(shape, "geom", &[]);
        let mut set = |name: &str, value: String| geom.attributes.push((name.to_string(), value));
        match shape.name.as_str() {
            "box" => {
                let size = a.numbers::<3>("size")?.ok_or_else(|| a.invalid("attribute 'size'", "none"))?;
                set("type", "box".into());
                set("size", numbers(&size.map(|s| 0.5 * s)));
            }
            "sphere" => {
                set("type", "sphere".into());
                set("size", numbers(&[need("radius")?]));
            }
            kind @ ("cylinder" | "capsule") => {
                set("type", kind.into());
                set("size", numbers(&[need("radius")?, 0.5 * need("length")?]));
            }
            "mesh" => {
                let name = format!("mesh{}", self.meshes.len());
                let file = a.required("filename")?;
                let file = package::path(file, self.folder);
                let mut mesh = element(shape, "mesh", &[("name", name.clone()), ("file", file)]);
                if let Some(scale) = a.numbers::<3>("scale")? {
                    mesh.attributes.push(("scale".into(), numbers(&scale)));
                }
                self.meshes.push(mesh);
                set("type", "mesh".into());
                set("mesh", name);
            }
            _ => return Err(shape.unsupported("shape")),
        }
        geom.attributes.extend(placed(&origin(collision)?));
        Ok(geom)
    }

    /// Translates a mesh that is only to be seen. It may have to stand in for a shape that is missing.
    fn picture(&mut self, visual: &Element) -> Option<Element> {
        child(child(visual, "geometry")?, "mesh")?;
        let mut geom = self.geom(visual).ok()?;
        geom.attributes.extend(["contype", "conaffinity", "mass"].map(|name| (name.to_string(), "0".to_string())));
        let colour = child(visual, "material").and_then(|material| child(material, "color"));
        if let Some(rgba) = colour.and_then(|colour| Attributes::own(colour).numbers::<4>("rgba").ok().flatten()) {
            geom.attributes.push(("rgba".into(), numbers(&rgba)));
        }
        Some(geom)
    }

    fn joint(&mut self, joint: &Element) -> Result<Element, CharacterError> {
        let a = Attributes::own(joint);
        let kind = match a.required("type")? {
            "revolute" | "continuous" => "hinge",
            "prismatic" => "slide",
            "floating" => return Ok(element(joint, "freejoint", &[("name", a.required("name")?.to_string())])),
            other => return Err(joint.unsupported(format!("joint type '{other}'"))),
        };
        let axis = axis(joint)?;
        let mut out = element(
            joint,
            "joint",
            &[("name", a.required("name")?.to_string()), ("type", kind.into()), ("axis", numbers(axis.as_slice()))],
        );
        out.attributes.extend(self.limits.read(joint)?);
        if let Some(dynamics) = child(joint, "dynamics") {
            let b = Attributes::own(dynamics);
            for (from, to) in [("damping", "damping"), ("friction", "frictionloss")] {
                if let Some(value) = b.number(from)? {
                    out.attributes.push((to.into(), numbers(&[value])));
                }
            }
        }
        Ok(out)
    }
}

/// Returns whether a geom is more than a point, line or sheet.
fn has_size(geom: &Element) -> bool {
    let sizes = geom.attribute("size").into_iter().flat_map(str::split_whitespace);
    sizes.filter_map(|size| size.parse::<f64>().ok()).all(|size| size != 0.0)
}

/// Returns whether a link has mass, of its own or of its shapes.
fn weighs(link: &Element) -> bool {
    match child(link, "inertial") {
        Some(_) => inertial::mass(link) != 0.0,
        None => child(link, "collision").is_some(),
    }
}

/// Collects the names of the joints in an element.
fn joint_names<'e>(element: &'e Element, names: &mut BTreeSet<&'e str>) {
    names.extend(element.attribute("name").filter(|_| element.name == "joint"));
    element.children.iter().for_each(|child| joint_names(child, names));
}

fn child<'a>(element: &'a Element, name: &str) -> Option<&'a Element> {
    element.children.iter().find(|c| c.name == name)
}

/// Returns a new element that stands where `source` stands.
fn element(source: &Element, name: &str, attributes: &[(&str, String)]) -> Element {
    Element {
        name: name.to_string(),
        attributes: attributes.iter().map(|(n, v)| (n.to_string(), v.clone())).collect(),
        children: Vec::new(),
        at: Location { element: source.name.clone(), ..source.at.clone() },
    }
}

/// Returns the position (m) and roll, pitch, yaw (rad, about fixed axes) of an element's `<origin>`.
fn pose(element: &Element) -> Result<(Vec3, Vec3), CharacterError> {
    let Some(origin) = child(element, "origin") else { return Ok((Vec3::zeros(), Vec3::zeros())) };
    let a = Attributes::own(origin);
    let get = |name: &str| Ok::<Vec3, CharacterError>(a.numbers::<3>(name)?.map_or_else(Vec3::zeros, Vec3::from));
    Ok((get("xyz")?, get("rpy")?))
}

/// Returns the pose of an element's `<origin>`.
fn origin(element: &Element) -> Result<Isometry, CharacterError> {
    let (position, rpy) = pose(element)?;
    Ok(Isometry::from_parts(position.into(), Quat::from_euler_angles(rpy.x, rpy.y, rpy.z)))
}

/// Returns a pose as attributes of a body or geom.
fn placed(pose: &Isometry) -> Vec<(String, String)> {
    vec![
        ("pos".into(), numbers(pose.translation.vector.as_slice())),
        ("quat".into(), numbers(&to_wxyz(&pose.rotation))),
    ]
}

/// Returns a joint's axis in its own frame.
fn axis(joint: &Element) -> Result<Vec3, CharacterError> {
    let Some(axis) = child(joint, "axis") else { return Ok(Vec3::x()) };
    let a = Attributes::own(axis);
    Ok(Vec3::from(a.numbers::<3>("xyz")?.ok_or_else(|| a.invalid("attribute 'xyz'", "none"))?))
}

/// Returns the place of a link whose joint is held at a position (rad or m).
fn held_at(joint: &Element, at: f64) -> Result<Isometry, CharacterError> {
    let origin = origin(joint)?;
    let axis = axis(joint)?.try_normalize(1e-12).unwrap_or_else(Vec3::x);
    Ok(origin
        * match joint.attribute("type") {
            Some("prismatic") => Isometry::from_parts((axis * at).into(), Quat::identity()),
            _ => Isometry::from_parts(Vec3::zeros().into(), Quat::from_scaled_axis(axis * at)),
        })
}
