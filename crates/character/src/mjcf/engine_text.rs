//! The text for engines that compile MJCF themselves: one self-contained document with the same dynamics.
//!
//! Included files are in place, pictures (textures, materials, meshes that neither collide nor weigh anything) are left
//! out, and so are meshes whose files are absent; the files that remain are named by their full path. So an engine needs no folder and
//! no mesh that does not matter.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::error::CharacterError;
use crate::mjcf::attributes::Attributes;
use crate::mjcf::compiler::Compiler;
use crate::mjcf::defaults::Defaults;
use crate::mjcf::document::Element;

/// Rewrites the tree in place; adds to `notes` what was left out, and to `warnings` what would have mattered. Returns
/// the meshes and height fields that would collide and whose files are absent.
pub(crate) fn prepare(
    root: &mut Element,
    compiler: &Compiler,
    defaults: &Defaults,
    folder: Option<&Path>,
    notes: &mut Vec<String>,
    warnings: &mut Vec<String>,
) -> Result<BTreeSet<String>, CharacterError> {
    let present = present_meshes(root, compiler, folder);
    let mut count = Count::default();
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
    Ok(count.absent_names)
}

#[derive(Default)]
struct Count {
    pictures: usize,
    absent: usize,
    absent_names: BTreeSet<String>,
    used: BTreeSet<String>,
}

/// Returns the name and full path of the meshes and height fields whose files are there, or that need no file.
fn present_meshes(root: &Element, compiler: &Compiler, folder: Option<&Path>) -> Vec<(String, Option<PathBuf>)> {
    let mut present = Vec::new();
    for asset in root.children_named("asset").flat_map(|s| &s.children) {
        if !matches!(asset.name.as_str(), "mesh" | "hfield") {
            continue;
        }
        let Some(file) = asset.attribute("file") else {
            present.extend(asset.attribute("name").map(|n| (n.to_string(), None)));
            continue;
        };
        let Some(folder) = folder else { continue };
        let given = Path::new(file);
        let name = asset.attribute("name").map(str::to_string);
        let name = name.or_else(|| given.file_stem().map(|s| s.to_string_lossy().into_owned()));
        let last = given.file_name().map_or(given, Path::new);
        let path = folder.join(&compiler.meshdir).join(if compiler.strippath { last } else { given });
        if let (Some(name), Ok(path)) = (name, path.canonicalize()) {
            present.push((name, Some(path)));
        }
    }
    present
}

fn cut_geoms(
    element: &mut Element,
    class: Option<&str>,
    defaults: &Defaults,
    present: &[(String, Option<PathBuf>)],
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

fn keep(a: &Attributes, present: &[(String, Option<PathBuf>)], count: &mut Count) -> Result<bool, CharacterError> {
    let Some(mesh) = a.text("mesh").or(a.text("hfield")) else { return Ok(true) };
    let bits = |name: &str| a.integer(name, 1, i64::MIN..i64::MAX);
    if bits("contype")? == 0 && bits("conaffinity")? == 0 {
        count.pictures += 1;
        return Ok(false);
    }
    if !present.iter().any(|(name, _)| name == mesh) {
        count.absent += 1;
        count.absent_names.insert(mesh.to_string());
        return Ok(false);
    }
    count.used.insert(mesh.to_string());
    Ok(true)
}

fn cut_assets(root: &mut Element, present: &[(String, Option<PathBuf>)], used: &BTreeSet<String>) {
    for section in root.children.iter_mut().filter(|c| c.name == "asset") {
        section.children.retain_mut(|asset| {
            if !matches!(asset.name.as_str(), "mesh" | "hfield") {
                return false;
            }
            let file = asset.attribute("file").map(Path::new).and_then(Path::file_stem).map(|s| s.to_string_lossy());
            let name = asset.attribute("name").map(str::to_string).or_else(|| file.map(|f| f.into_owned()));
            let Some((name, path)) = present.iter().find(|(n, _)| Some(n) == name.as_ref()) else { return false };
            if let Some(path) = path {
                asset.attributes.retain(|(n, _)| n != "file" && n != "name");
                asset.attributes.push(("name".into(), name.clone()));
                asset.attributes.push(("file".into(), path.to_string_lossy().into_owned()));
            }
            used.contains(name)
        });
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
