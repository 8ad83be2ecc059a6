//! URDF in: translated to MJCF and compiled as such.
//!
//! As MuJoCo's own import, except: fixed links stay bodies (MuJoCo's `fusestatic` merges them), so that every link can
//! be referred to by name; and the root link floats, as it does for every legged robot, unless it is called `world`
//! (MuJoCo fixes it). `effort` limits become `actuatorfrcrange`. Links without `<inertial>` get the mass of their
//! collision shapes at 1000 kg/m³.
//!
//! Visuals, velocity limits, transmissions and simulator extensions are noted or left out; joints that mimic others and
//! planar joints are refused.

use std::collections::BTreeMap;
use std::path::Path;

use crate::error::{CharacterError, Location};
use crate::inertia;
use crate::mjcf::attributes::Attributes;
use crate::mjcf::document::{self, Element};
use crate::model::Character;
use crate::rotation::{Mat3, Quat, Vec3};

/// Deeper chains of links than any robot has.
const MAX_DEPTH: usize = 150;

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
    let mut translation = Translation::new(robot)?;
    let mjcf = translation.model(robot)?;
    let mut character = crate::mjcf::compile(mjcf, folder)?;
    let notes = translation.notes();
    character.notes.splice(0..0, notes);
    Ok(character)
}

struct Translation<'a> {
    links: BTreeMap<&'a str, &'a Element>,
    /// Joints that hang on a link, in document order.
    joints: BTreeMap<&'a str, Vec<&'a Element>>,
    root: &'a Element,
    meshes: Vec<Element>,
    visuals: usize,
    without_inertial: usize,
}

impl<'a> Translation<'a> {
    fn new(robot: &'a Element) -> Result<Self, CharacterError> {
        let mut links = BTreeMap::new();
        for link in robot.children_named("link") {
            let name = link.attribute("name").ok_or_else(|| link.invalid("attribute 'name'", "none"))?;
            if links.insert(name, link).is_some() {
                return Err(link.invalid("a link name that is not taken", format!("'{name}'")));
            }
        }
        let mut joints: BTreeMap<&str, Vec<&Element>> = BTreeMap::new();
        let mut parents: BTreeMap<&str, &Element> = BTreeMap::new();
        for joint in robot.children_named("joint") {
            let end = |tag: &'static str| {
                let name = child(joint, tag).and_then(|c| c.attribute("link"));
                let name = name.ok_or_else(|| joint.invalid(format!("<{tag} link=...>"), "none"))?;
                let known = links.contains_key(name);
                if known {
                    Ok(name)
                } else {
                    Err(joint.invalid(format!("a known link for <{tag}>"), format!("'{name}'")))
                }
            };
            let (parent, below) = (end("parent")?, end("child")?);
            if parents.insert(below, joint).is_some() {
                return Err(joint.invalid("a child link that no other joint moves", format!("'{below}'")));
            }
            joints.entry(parent).or_default().push(joint);
        }
        let mut roots = links.iter().filter(|(name, _)| !parents.contains_key(*name)).map(|(_, link)| *link);
        let root = roots.next().ok_or_else(|| robot.invalid("a link that is no joint's child", "none"))?;
        if let Some(second) = roots.next() {
            return Err(second.invalid("one link that is no joint's child", "a second one"));
        }
        Ok(Self { links, joints, root, meshes: Vec::new(), visuals: 0, without_inertial: 0 })
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

    fn model(&mut self, robot: &'a Element) -> Result<Element, CharacterError> {
        let mut world = element(robot, "worldbody", &[]);
        if self.root.attribute("name") == Some("world") {
            self.fill(self.root, &mut world, 0)?;
        } else {
            let name = self.root.attribute("name").unwrap_or("").to_string();
            let mut body = element(self.root, "body", &[("name", name)]);
            body.children.push(element(self.root, "freejoint", &[]));
            self.fill(self.root, &mut body, 0)?;
            world.children.push(body);
        }
        let mut compiler = element(
            robot,
            "compiler",
            &[("angle", "radian".into()), ("eulerseq", "XYZ".into()), ("autolimits", "true".into())],
        );
        // MuJoCo's extension: those of its settings that still mean something here.
        for given in robot.children_named("mujoco").flat_map(|m| m.children_named("compiler")) {
            let kept = ["meshdir", "strippath", "balanceinertia", "boundmass", "boundinertia", "settotalmass"];
            let kept = given.attributes.iter().filter(|(n, _)| kept.contains(&n.as_str()));
            compiler.attributes.extend(kept.cloned());
        }
        let mut assets = element(robot, "asset", &[]);
        assets.children = std::mem::take(&mut self.meshes);
        let mut model = element(robot, "mujoco", &[("model", robot.attribute("name").unwrap_or("robot").to_string())]);
        model.children = vec![compiler, assets, world];
        Ok(model)
    }

    /// Puts what a link holds, and the links that hang on it, into a body.
    fn fill(&mut self, link: &'a Element, body: &mut Element, depth: usize) -> Result<(), CharacterError> {
        if depth > MAX_DEPTH {
            return Err(link.invalid(format!("a chain of at most {MAX_DEPTH} links"), "more"));
        }
        match child(link, "inertial") {
            Some(inertial) if body.name == "body" => body.children.push(Self::inertial(inertial)?),
            Some(_) => {}
            None => self.without_inertial += 1,
        }
        for collision in link.children_named("collision") {
            let geom = self.geom(collision)?;
            body.children.push(geom);
        }
        self.visuals += link.children_named("visual").count();
        let name = link.attribute("name").unwrap_or("");
        for joint in self.joints.get(name).cloned().unwrap_or_default() {
            let below = child(joint, "child").and_then(|c| c.attribute("link")).unwrap_or("");
            let Some(link) = self.links.get(below).copied() else { continue };
            let mut inner = element(link, "body", &[("name", below.to_string())]);
            inner.attributes.extend(origin(joint)?);
            inner.children.extend(Self::joint(joint)?);
            self.fill(link, &mut inner, depth + 1)?;
            body.children.push(inner);
        }
        Ok(())
    }

    fn inertial(inertial: &Element) -> Result<Element, CharacterError> {
        let mass = child(inertial, "mass").ok_or_else(|| inertial.invalid("<mass>", "none"))?;
        let mass = Attributes::own(mass).required("value")?.to_string();
        let moments = child(inertial, "inertia").ok_or_else(|| inertial.invalid("<inertia>", "none"))?;
        let a = Attributes::own(moments);
        let get = |name: &str| a.number(name)?.ok_or_else(|| a.invalid(format!("attribute '{name}'"), "none"));
        let (xx, yy, zz) = (get("ixx")?, get("iyy")?, get("izz")?);
        let cross = |name: &str| Ok::<f64, CharacterError>(a.number(name)?.unwrap_or(0.0));
        let (xy, xz, yz) = (cross("ixy")?, cross("ixz")?, cross("iyz")?);
        let local = Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let (position, rpy) = pose(inertial)?;
        let turn = Quat::from_euler_angles(rpy.x, rpy.y, rpy.z).to_rotation_matrix().into_inner();
        let (orientation, diagonal) = inertia::principal(&(turn * local * turn.transpose()));
        if diagonal.min() < -1e-12 * diagonal.max().abs() {
            return Err(a.invalid("a positive definite inertia", "another"));
        }
        let diagonal = diagonal.map(|x| x.max(0.0));
        let q = crate::rotation::to_wxyz(&orientation);
        Ok(element(
            inertial,
            "inertial",
            &[
                ("pos", numbers(position.as_slice())),
                ("quat", numbers(&q)),
                ("mass", mass),
                ("diaginertia", numbers(diagonal.as_slice())),
            ],
        ))
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
                let file = ["package://", "file://"].iter().find_map(|p| file.strip_prefix(p)).unwrap_or(file);
                let mut mesh = element(
                    shape,
                    "mesh",
                    &[("name", name.clone()), ("file", file.trim_start_matches('/').to_string())],
                );
                if let Some(scale) = a.numbers::<3>("scale")? {
                    mesh.attributes.push(("scale".into(), numbers(&scale)));
                }
                self.meshes.push(mesh);
                set("type", "mesh".into());
                set("mesh", name);
            }
            _ => return Err(shape.unsupported("shape")),
        }
        geom.attributes.extend(origin(collision)?);
        Ok(geom)
    }

    fn joint(joint: &Element) -> Result<Option<Element>, CharacterError> {
        let a = Attributes::own(joint);
        if let Some(mimic) = child(joint, "mimic") {
            return Err(mimic.unsupported("joint that mimics another"));
        }
        let kind = match a.required("type")? {
            "fixed" => return Ok(None),
            "revolute" | "continuous" => "hinge",
            "prismatic" => "slide",
            "floating" => {
                return Ok(Some(element(joint, "freejoint", &[("name", a.required("name")?.to_string())])));
            }
            other => return Err(joint.unsupported(format!("joint type '{other}'"))),
        };
        let axis = match child(joint, "axis") {
            None => [1.0, 0.0, 0.0],
            Some(axis) => {
                let b = Attributes::own(axis);
                b.numbers::<3>("xyz")?.ok_or_else(|| b.invalid("attribute 'xyz'", "none"))?
            }
        };
        let mut out = element(
            joint,
            "joint",
            &[("name", a.required("name")?.to_string()), ("type", kind.into()), ("axis", numbers(&axis))],
        );
        if let Some(limit) = child(joint, "limit") {
            let b = Attributes::own(limit);
            let (low, high) = (b.number("lower")?.unwrap_or(0.0), b.number("upper")?.unwrap_or(0.0));
            if a.text("type") != Some("continuous") && low < high {
                out.attributes.push(("range".into(), numbers(&[low, high])));
            }
            if let Some(effort) = b.number("effort")?.filter(|e| *e > 0.0) {
                out.attributes.push(("actuatorfrcrange".into(), numbers(&[-effort, effort])));
            }
        }
        if let Some(dynamics) = child(joint, "dynamics") {
            let b = Attributes::own(dynamics);
            for (from, to) in [("damping", "damping"), ("friction", "frictionloss")] {
                if let Some(value) = b.number(from)? {
                    out.attributes.push((to.into(), numbers(&[value])));
                }
            }
        }
        Ok(Some(out))
    }
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

fn numbers(values: &[f64]) -> String {
    values.iter().map(|v| format!("{v:e}")).collect::<Vec<_>>().join(" ")
}

/// Returns the position (m) and roll, pitch, yaw (rad, about fixed axes) of an element's `<origin>`.
fn pose(element: &Element) -> Result<(Vec3, Vec3), CharacterError> {
    let Some(origin) = child(element, "origin") else { return Ok((Vec3::zeros(), Vec3::zeros())) };
    let a = Attributes::own(origin);
    let get = |name: &str| Ok::<Vec3, CharacterError>(a.numbers::<3>(name)?.map_or_else(Vec3::zeros, Vec3::from));
    Ok((get("xyz")?, get("rpy")?))
}

fn origin(element: &Element) -> Result<Vec<(String, String)>, CharacterError> {
    let (position, rpy) = pose(element)?;
    Ok(vec![("pos".into(), numbers(position.as_slice())), ("euler".into(), numbers(rpy.as_slice()))])
}
