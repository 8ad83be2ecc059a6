//! The text for engines that compile MJCF themselves: one self-contained document with the same dynamics.
//!
//! Included files are in place. Pictures (textures, materials, meshes that neither collide nor weigh anything) are
//! left out. So are meshes that are absent or that MuJoCo does not read. The files that remain are named by their full
//! path. So an engine needs no folder and no mesh that does not matter.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::error::{CharacterError, Location};
use crate::mesh::MeshFile;
use crate::mjcf::attributes::Attributes;
use crate::mjcf::compiler::Compiler;
use crate::mjcf::defaults::Defaults;
use crate::mjcf::document::{Element, numbers};
use crate::model::{Body, Inertial};
use crate::rotation::to_wxyz;

/// Endings of the mesh files that MuJoCo reads.
const READ_BY_MUJOCO: [&str; 3] = ["stl", "obj", "msh"];

/// Which meshes a text has that collide.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Meshes {
    /// Those that MuJoCo reads: whoever wrote MJCF has seen them collide.
    Read,
    /// None. Of a URDF's the convex hulls overlap, and nobody says which bodies may.
    None,
}

/// Fate of meshes and height fields.
#[derive(Debug, Default)]
pub(crate) struct Outcome {
    /// Those that would collide and that the text does not have.
    pub left_out: BTreeSet<String>,
    /// The files of meshes that are there and used as they stand in them.
    pub files: BTreeMap<String, MeshFile>,
}

/// Rewrites the tree in place; adds to `notes` what was left out, and to `warnings` what would have mattered.
pub(crate) fn prepare(
    root: &mut Element,
    meshes: Meshes,
    compiler: &Compiler,
    defaults: &Defaults,
    folder: Option<&Path>,
    notes: &mut Vec<String>,
    warnings: &mut Vec<String>,
) -> Result<Outcome, CharacterError> {
    let present = present_meshes(root, compiler, defaults, folder)?;
    let mut count = Count::of(meshes);
    for world in root.children.iter_mut().filter(|c| c.name == "worldbody") {
        cut_geoms(world, None, defaults, &present, &mut count)?;
    }
    if count.pictures > 0 {
        notes.push(format!("{} mesh geoms are pictures only", count.pictures));
    }
    if count.absent > 0 {
        let text = "mesh geoms would collide, but their files are missing: they touch nothing; put the files there, or give the \
                    bodies boxes, spheres or capsules";
        warnings.push(format!("{} {text}", count.absent));
    }
    match (count.silent, meshes) {
        (0, _) => {}
        (n, Meshes::None) => notes.push(format!("{n} mesh geoms touch nothing, but for those of feet, which get boxes")),
        (n, Meshes::Read) => warnings.push(format!(
            "{n} mesh geoms would collide, but MuJoCo does not read their files (it reads STL, OBJ and MSH): they touch nothing"
        )),
    }
    cut_assets(root, &present, &count.used);
    let mut names = BTreeSet::new();
    geom_names(root, &mut names);
    let mut dangling = 0;
    for contact in root.children.iter_mut().filter(|c| c.name == "contact") {
        let before = contact.children.len();
        let there = |pair: &Element, geom: &str| pair.attribute(geom).is_some_and(|n| names.contains(n));
        contact.children.retain(|c| c.name != "pair" || (there(c, "geom1") && there(c, "geom2")));
        dangling += before - contact.children.len();
    }
    if dangling > 0 {
        notes.push(format!("{dangling} contact pairs name geoms that are not there: left out"));
    }
    strip_materials(root);
    for section in root.children.iter_mut().filter(|c| c.name == "compiler") {
        section.attributes.retain(|(n, _)| !matches!(n.as_str(), "meshdir" | "texturedir" | "assetdir" | "strippath"));
    }
    Ok(count.outcome)
}

struct Count {
    meshes: Meshes,
    pictures: usize,
    absent: usize,
    /// There, and not in the text.
    silent: usize,
    outcome: Outcome,
    used: BTreeSet<String>,
}

impl Count {
    fn of(meshes: Meshes) -> Self {
        let (outcome, used) = (Outcome::default(), BTreeSet::new());
        Self { meshes, pictures: 0, absent: 0, silent: 0, outcome, used }
    }
}

/// Meshes and height fields that are there, by name, and the files of those that need one.
type Present = BTreeMap<String, Option<Found>>;

struct Found {
    file: MeshFile,
    /// True if its points are used as in the file, but for the scale.
    as_is: bool,
}

fn present_meshes(
    root: &Element,
    compiler: &Compiler,
    defaults: &Defaults,
    folder: Option<&Path>,
) -> Result<Present, CharacterError> {
    let mut present = Present::new();
    for asset in root.children_named("asset").flat_map(|s| &s.children) {
        if !matches!(asset.name.as_str(), "mesh" | "hfield") {
            continue;
        }
        let Some(file) = asset.attribute("file") else {
            present.extend(asset.attribute("name").map(|n| (n.to_string(), None)));
            continue;
        };
        let name = asset.attribute("name").map(str::to_string);
        let name = name.or_else(|| Path::new(file).file_stem().map(|s| s.to_string_lossy().into_owned()));
        if let (Some(name), Some(path)) = (name, compiler.mesh_path(folder, file)) {
            let a = defaults.resolve(asset, None)?;
            let as_is = asset.name == "mesh" && a.text("refpos").is_none() && a.text("refquat").is_none();
            let file = MeshFile { path, scale: a.numbers::<3>("scale")?.unwrap_or([1.0; 3]), collides: false };
            present.insert(name, Some(Found { file, as_is }));
        }
    }
    Ok(present)
}

fn cut_geoms(
    element: &mut Element,
    class: Option<&str>,
    defaults: &Defaults,
    present: &Present,
    count: &mut Count,
) -> Result<(), CharacterError> {
    let own = element.attribute("childclass").map(str::to_string);
    let class = own.as_deref().or(class);
    let mut kept = Vec::with_capacity(element.children.len());
    for mut child in std::mem::take(&mut element.children) {
        match child.name.as_str() {
            "geom" => {
                let a = defaults.resolve(&child, class)?;
                if keep(&a, present, count)? {
                    kept.push(child);
                }
            }
            "body" | "frame" => {
                cut_geoms(&mut child, class, defaults, present, count)?;
                kept.push(child);
            }
            _ => kept.push(child),
        }
    }
    element.children = kept;
    Ok(())
}

fn keep(a: &Attributes, present: &Present, count: &mut Count) -> Result<bool, CharacterError> {
    let Some(mesh) = a.text("mesh").or(a.text("hfield")) else { return Ok(true) };
    let bits = |name: &str| a.integer(name, 1, i64::MIN..i64::MAX);
    if bits("contype")? == 0 && bits("conaffinity")? == 0 {
        count.pictures += 1;
        if let Some(Some(Found { file, as_is: true })) = present.get(mesh) {
            count.outcome.files.entry(mesh.to_string()).or_insert_with(|| file.clone());
        }
        return Ok(false);
    }
    let Some(found) = present.get(mesh) else {
        count.absent += 1;
        count.outcome.left_out.insert(mesh.to_string());
        return Ok(false);
    };
    if let Some(Found { file, as_is }) = found {
        if *as_is {
            count.outcome.files.insert(mesh.to_string(), MeshFile { collides: true, ..file.clone() });
        }
        let is_read = count.meshes == Meshes::Read && file.is_one_of(&READ_BY_MUJOCO);
        if a.text("hfield").is_none() && !is_read {
            count.silent += 1;
            count.outcome.left_out.insert(mesh.to_string());
            return Ok(false);
        }
    }
    count.used.insert(mesh.to_string());
    Ok(true)
}

fn cut_assets(root: &mut Element, present: &Present, used: &BTreeSet<String>) {
    for section in root.children.iter_mut().filter(|c| c.name == "asset") {
        section.children.retain_mut(|asset| {
            if !matches!(asset.name.as_str(), "mesh" | "hfield") {
                return false;
            }
            let file = asset.attribute("file").map(Path::new).and_then(Path::file_stem).map(|s| s.to_string_lossy());
            let name = asset.attribute("name").map(str::to_string).or_else(|| file.map(|f| f.into_owned()));
            let Some((name, found)) = name.and_then(|name| present.get_key_value(&name)) else { return false };
            if let Some(Found { file, .. }) = found {
                asset.attributes.retain(|(n, _)| n != "file" && n != "name");
                asset.attributes.push(("name".into(), name.clone()));
                asset.attributes.push(("file".into(), file.path.to_string_lossy().into_owned()));
            }
            used.contains(name)
        });
    }
}

/// Writes the inertia of every body into the text, whose meshes and files may be gone. Bodies are in the text's order.
pub(crate) fn state_inertia(root: &mut Element, bodies: &[Body]) {
    fn visit(element: &mut Element, rest: &mut std::slice::Iter<'_, Body>) {
        for child in element.children.iter_mut().filter(|c| matches!(c.name.as_str(), "body" | "frame")) {
            if let Some(body) = (child.name == "body").then(|| rest.next()).flatten() {
                child.children.retain(|c| c.name != "inertial");
                if body.inertial.mass > 0.0 {
                    child.children.insert(0, inertial(&body.inertial, &child.at));
                }
            }
            visit(child, rest);
        }
    }
    let mut rest = bodies.iter();
    rest.next(); // The world.
    for section in &mut root.children {
        match section.name.as_str() {
            "worldbody" => visit(section, &mut rest),
            "compiler" => {
                section.attributes.retain(|(n, _)| !matches!(n.as_str(), "inertiafromgeom" | "inertiagrouprange"));
            }
            _ => {}
        }
    }
}

fn inertial(inertial: &Inertial, at: &Location) -> Element {
    let values = [
        ("pos", numbers(inertial.com.as_slice())),
        ("quat", numbers(&to_wxyz(&inertial.orientation))),
        ("mass", numbers(&[inertial.mass])),
        ("diaginertia", numbers(inertial.diagonal.as_slice())),
    ];
    Element {
        name: "inertial".into(),
        attributes: values.map(|(name, value)| (name.to_string(), value)).to_vec(),
        children: Vec::new(),
        at: at.clone(),
    }
}

fn geom_names(element: &Element, names: &mut BTreeSet<String>) {
    if element.name == "geom" {
        names.extend(element.attribute("name").map(str::to_string));
    }
    for child in element.children.iter().filter(|c| matches!(c.name.as_str(), "worldbody" | "body" | "frame" | "geom"))
    {
        geom_names(child, names);
    }
}

fn strip_materials(element: &mut Element) {
    element.attributes.retain(|(n, _)| n != "material");
    element.children.retain(|c| c.name != "material" && c.name != "skin");
    for child in &mut element.children {
        strip_materials(child);
    }
}
