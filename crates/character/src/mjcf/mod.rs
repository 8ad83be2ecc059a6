//! MJCF in: MuJoCo's own description of a model, compiled as MuJoCo's compiler does.
//!
//! Unsupported elements that would change the dynamics are refused with file, line and element. Elements that are not
//! simulated (pictures, sensors, key frames) are listed in [`Character::notes`].
//!
//! Main path: `document` (XML with includes) → `defaults`, `compiler` (settings) → `bodies` (with `joints` and `geoms`)
//! → `actuators` → [`Character`] → `equality`. Frames of equalities come from the character's kinematics. `engine_text`
//! writes the text for engines that compile MJCF themselves.

mod actuators;
pub(crate) mod attributes;
mod bodies;
mod compiler;
mod coupling;
mod defaults;
pub(crate) mod document;
mod engine_text;
mod equality;
mod geoms;
mod joints;
mod keyframes;
pub(crate) mod names;
mod pose;
mod replicate;
mod solids;
mod tendons;
pub(crate) mod xml_text;

use std::collections::BTreeMap;
use std::path::Path;

use crate::error::CharacterError;
use crate::model::{Body, Character, Geom, GeomShape, JointKind};

use attributes::Attributes;
use bodies::{Reader, Tree};
use compiler::{Compiler, PhysicsOption};
use defaults::Defaults;
use document::{Document, Element};
pub(crate) use engine_text::Meshes;
use solids::Solids;

impl Character {
    /// Compiles MJCF text. `file` is what errors call the text; included files and meshes are looked for from `folder`
    /// (`None`: includes are refused and no mesh file is found).
    pub fn from_mjcf(text: &str, file: &str, folder: Option<&Path>) -> Result<Self, CharacterError> {
        let document = document::parse(text, Path::new(file), folder)?;
        if document.root.name != "mujoco" {
            return Err(document.root.invalid("root element 'mujoco'", format!("'{}'", document.root.name)));
        }
        compile_document(document, folder)
    }
}

/// Attributes of constraints that only MuJoCo obeys.
const SOFTNESS: [(&str, &str); 6] = [
    ("joint", "solreflimit"),
    ("joint", "solimplimit"),
    ("joint", "solreffriction"),
    ("joint", "solimpfriction"),
    ("joint", "margin"),
    ("geom", "solmix"),
];

/// Says which of them the text sets.
fn note_softness(root: &Element, notes: &mut Vec<String>) {
    fn count(element: &Element, name: &str, attribute: &str) -> usize {
        let own = usize::from(element.name == name && element.attribute(attribute).is_some());
        own + element.children.iter().map(|child| count(child, name, attribute)).sum::<usize>()
    }
    for (name, attribute) in SOFTNESS {
        match count(root, name, attribute) {
            0 => {}
            n => notes.push(format!("{n} <{name}> entries set {attribute}: our engine has MuJoCo's default")),
        }
    }
}

/// Contact pairs that a message lists.
const LISTED: usize = 4;

/// Sections that say nothing about the dynamics.
const PICTURES: [&str; 6] = ["visual", "statistic", "size", "custom", "sensor", "keyframe"];

/// Compiles a text from which includes may be missing: without them where the model stands on its own, which becomes a
/// line of [`Character::warnings`].
pub(crate) fn compile_document(document: Document, folder: Option<&Path>) -> Result<Character, CharacterError> {
    let Document { root, missing } = document;
    let file = |include: &Element| include.attribute("file").unwrap_or_default().to_string();
    let compiled = compile(root, folder, Meshes::Read);
    let Some(first) = missing.first() else { return compiled };
    let mut character = compiled.map_err(|cause| CharacterError::MissingInclude {
        at: first.at.clone(),
        file: file(first),
        cause: Box::new(cause),
    })?;
    if character.bodies.len() == 1 {
        return Err(
            first.invalid("a file with the bodies, which are nowhere else", format!("no file '{}'", file(first)))
        );
    }
    let warning = |include: &Element| {
        let (at, file) = (&include.at, file(include));
        format!(
            "{at}: file '{file}' is missing: loaded without it, which is right if it holds only looks (sky, colours, lights)"
        )
    };
    character.warnings.splice(0..0, missing.iter().map(warning));
    Ok(character)
}

pub(crate) fn compile(mut root: Element, folder: Option<&Path>, meshes: Meshes) -> Result<Character, CharacterError> {
    let (mut notes, mut warnings) = (Vec::new(), Vec::new());
    Attributes::own(&root).only(&["model", "noNamespaceSchemaLocation"])?;
    check_sections(&root, &mut notes)?;
    let compiler = Compiler::read(&root)?;
    replicate::expand(&mut root, &compiler)?;
    names::all_different(&root)?;
    let option = PhysicsOption::read(&root, &mut notes, &mut warnings)?;
    let defaults = Defaults::read(&root)?;
    tendons::read(&root, &defaults, compiler.autolimits, &mut notes, &mut warnings)?;
    note_softness(&root, &mut notes);

    let materials = read_materials(&root)?;
    let solids = Solids { root: &root, compiler: &compiler, defaults: &defaults, folder };
    let mut reader = Reader { compiler: &compiler, defaults: &defaults, materials, solids, tree: Tree::default() };
    reader.read_world(&root)?;
    let mut tree = reader.tree;
    if tree.mocap > 0 {
        notes.push(format!("{} mocap bodies stay where they are", tree.mocap));
    }
    if tree.pictures > 0 {
        notes.push(format!("{} lights and cameras are pictures only", tree.pictures));
    }
    let is_field =
        |geom: &Geom| matches!(geom.shape, GeomShape::HeightField(_)) && geom.contype | geom.conaffinity != 0;
    if tree.geoms.iter().any(is_field) {
        warnings.push(
            "height fields are ground in MuJoCo alone: our engine has level ground, or the hills of a plan's [terrain]"
                .into(),
        );
    }
    name_all(&mut tree);
    let (nq, nv) = count_coordinates(&mut tree);
    let stated = tree.weighs_meshes.then(|| tree.bodies.clone());
    if let Some(total) = compiler.settotalmass {
        scale_mass(&mut tree.bodies, total);
    }
    let home = keyframes::read(&root, nq, &mut notes, &mut warnings)?;
    let actuators = actuators::read(&root, &defaults, &compiler, &mut tree.joints, &mut notes, &mut warnings)?;
    let couplings = coupling::read(&root, &defaults, &mut tree.joints, &actuators, &mut warnings)?;
    let (excludes, pairs) = read_contacts(&root, &tree, &mut warnings)?;
    let name = root.attribute("model").unwrap_or("MuJoCo Model").to_string();
    if let Some(bodies) = stated {
        engine_text::state_inertia(&mut root, &bodies);
    }
    let outcome = engine_text::prepare(&mut root, meshes, &compiler, &defaults, folder, &mut notes, &mut warnings)?;
    for geom in &mut tree.geoms {
        if let GeomShape::Mesh(name) | GeomShape::HeightField(name) = &geom.shape
            && outcome.left_out.contains(name)
        {
            (geom.contype, geom.conaffinity) = (0, 0);
        }
    }
    let mut character = Character {
        name,
        mjcf: Some(root.to_xml()),
        folder: folder.map(Path::to_path_buf),
        bodies: tree.bodies,
        joints: tree.joints,
        geoms: tree.geoms,
        sites: tree.sites,
        actuators,
        excludes,
        pairs,
        equalities: Vec::new(),
        couplings,
        home,
        meshes: outcome.files,
        nq,
        nv,
        gravity: option.gravity,
        timestep: option.timestep,
        notes,
        warnings,
    };
    actuators::resolve_damping(&mut character);
    joints::resolve_springs(&mut character, &tree.spring_dampers);
    character.equalities = equality::read(&root, &defaults, &character)?;
    Ok(character)
}

/// Reads the colours of materials.
fn read_materials(root: &Element) -> Result<BTreeMap<String, [f32; 4]>, CharacterError> {
    let mut colours = BTreeMap::new();
    let materials = root.children_named("asset").flat_map(|section| section.children_named("material"));
    for material in materials {
        let a = Attributes::own(material);
        if let (Some(name), Some(_)) = (a.text("name"), a.text("rgba")) {
            colours.insert(name.to_string(), a.prefix("rgba", [0.5, 0.5, 0.5, 1.0])?.map(|x| x as f32));
        }
    }
    Ok(colours)
}

fn check_sections(root: &Element, notes: &mut Vec<String>) -> Result<(), CharacterError> {
    for section in &root.children {
        match section.name.as_str() {
            "compiler" | "option" | "default" | "asset" | "worldbody" | "contact" | "actuator" | "equality"
            | "tendon" => {}
            name if PICTURES.contains(&name) => {
                if name == "sensor" {
                    notes.push(format!("{} <{name}> entries are not used", section.children.len()));
                }
            }
            // Empty sections say nothing; anything in them would be a force or a constraint of its own.
            "extension" | "deformable" => {
                if let Some(child) = section.children.first() {
                    return Err(child.unsupported(format!("element in <{}>", section.name)));
                }
            }
            _ => return Err(section.unsupported("section of a model")),
        }
    }
    Ok(())
}

fn name_all(tree: &mut Tree) {
    for i in 0..tree.bodies.len() {
        if tree.bodies[i].name.is_empty() {
            tree.bodies[i].name = names::made_up(format!("body{i}"), tree.bodies.iter().map(|b| b.name.as_str()));
        }
    }
    for i in 0..tree.joints.len() {
        if tree.joints[i].name.is_empty() {
            let wanted = match tree.joints[i].kind {
                JointKind::Free => format!("{}_free", tree.bodies[tree.joints[i].body].name),
                _ => format!("joint{i}"),
            };
            tree.joints[i].name = names::made_up(wanted, tree.joints.iter().map(|j| j.name.as_str()));
        }
    }
    for i in 0..tree.geoms.len() {
        if tree.geoms[i].name.is_empty() {
            tree.geoms[i].name = names::made_up(format!("geom{i}"), tree.geoms.iter().map(|g| g.name.as_str()));
        }
    }
    for i in 0..tree.sites.len() {
        if tree.sites[i].name.is_empty() {
            tree.sites[i].name = names::made_up(format!("site{i}"), tree.sites.iter().map(|s| s.name.as_str()));
        }
    }
}

/// Gives each joint its coordinates; returns how many positions and velocities there are.
fn count_coordinates(tree: &mut Tree) -> (usize, usize) {
    let (mut nq, mut nv) = (0, 0);
    for joint in &mut tree.joints {
        (joint.q_index, joint.v_index) = (nq, nv);
        nq += joint.kind.nq();
        nv += joint.kind.nv();
    }
    (nq, nv)
}

fn scale_mass(bodies: &mut [Body], total: f64) {
    let now: f64 = bodies.iter().map(|b| b.inertial.mass).sum();
    if now < crate::inertia::MIN_MASS {
        return;
    }
    for body in bodies {
        body.inertial.mass *= total / now;
        body.inertial.diagonal *= total / now;
    }
}

/// Pairs of bodies that never touch, and of names of geoms that always may.
type Contacts = (Vec<(usize, usize)>, Vec<[String; 2]>);

fn read_contacts(root: &Element, tree: &Tree, warnings: &mut Vec<String>) -> Result<Contacts, CharacterError> {
    let (mut excludes, mut pairs) = (Vec::new(), Vec::new());
    for element in root.children_named("contact").flat_map(|s| &s.children) {
        let a = Attributes::own(element);
        match element.name.as_str() {
            "pair" => {
                let find = |attribute: &str| {
                    let name = a.required(attribute)?;
                    let found = tree.geoms.iter().find(|geom| geom.name == name).map(|geom| geom.name.clone());
                    found.ok_or_else(|| a.invalid(format!("the name of a geom for '{attribute}'"), format!("'{name}'")))
                };
                pairs.push([find("geom1")?, find("geom2")?]);
            }
            "exclude" => {
                a.only(&["name", "class", "body1", "body2"])?;
                let find = |attribute: &str| {
                    let name = a.required(attribute)?;
                    let found = tree.bodies.iter().position(|b| b.name == name);
                    found.ok_or_else(|| a.invalid(format!("the name of a body for '{attribute}'"), format!("'{name}'")))
                };
                excludes.push((find("body1")?, find("body2")?));
            }
            _ => return Err(element.unsupported("element in <contact>")),
        }
    }
    if !pairs.is_empty() {
        let listed = |pair: &[String; 2]| pair.join(" and ");
        let some: Vec<String> = pairs.iter().take(LISTED).map(listed).collect();
        let more = if pairs.len() > LISTED { ", ..." } else { "" };
        warnings.push(format!(
            "{} contact pairs (<pair>) act in MuJoCo alone ({}{more}): in our engine geoms touch by contype and conaffinity",
            pairs.len(),
            some.join(", ")
        ));
    }
    Ok((excludes, pairs))
}
