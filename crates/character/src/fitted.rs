//! Boxes around meshes of bodies that have no other collision shape.
//!
//! Most robots' feet are meshes only. A box around a foot has its sole, and every engine supports boxes. The text for
//! engines that compile MJCF themselves has the box instead of the mesh.

use std::collections::BTreeMap;
use std::path::Path;

use crate::kinematics::Kinematics;
use crate::mjcf::document::{self, Element, numbers};
use crate::model::{Character, Geom, GeomShape, welded};
use crate::rotation::{Vec3, to_wxyz};

/// Least half length (m): a plate has no volume, and engines want some.
const LEAST: f64 = 5e-4;

/// A geom that has become the box around its mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Fitted {
    /// Its index in [`Character::geoms`].
    pub geom: usize,
    /// The mesh.
    pub mesh: String,
    /// Lengths of the box (m).
    pub size: Vec3,
}

/// Purpose of a mesh: those that come first are taken for what touches the ground.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Purpose {
    Collides,
    /// It collides in the text that it comes from, and not in the engines'.
    Silenced,
    Picture,
}

impl Character {
    /// Gives each of these bodies, with what is fixed to it, boxes for its [`Self::meshes`], unless it has another
    /// shape that collides. Pictures count only where nothing of the whole character collides. A mesh that cannot be
    /// read, or is larger than the whole character (a missing scale), becomes a line of [`Self::warnings`] instead.
    pub fn fit_boxes(&mut self, bodies: &[usize]) -> Vec<Fitted> {
        let mut fitted = Vec::new();
        for geom in bodies.iter().flat_map(|body| self.stand_ins(*body)).collect::<Vec<usize>>() {
            match self.box_around(geom) {
                Ok(one) => fitted.push(one),
                Err(problem) => self.warnings.push(format!("{problem}: it touches nothing")),
            }
        }
        self.rewrite(&fitted);
        fitted
    }

    /// Returns the meshes of a body, and of what is fixed to it, that have to stand in for the shapes that it lacks.
    fn stand_ins(&self, body: usize) -> Vec<usize> {
        let parts = welded(&self.bodies, body);
        let on_it = || (0..self.geoms.len()).filter(|geom| parts[self.geoms[*geom].body]);
        let purpose = |geom: usize| self.purpose(&self.geoms[geom]);
        if on_it().any(|geom| self.geoms[geom].collides() && purpose(geom).is_none()) {
            return Vec::new();
        }
        let seen_only = |g: &Geom| {
            g.body == 0 || (!g.collides() && self.purpose(g).is_none_or(|purpose| purpose == Purpose::Picture))
        };
        match on_it().filter_map(purpose).min() {
            Some(Purpose::Picture) if !self.geoms.iter().all(seen_only) => Vec::new(),
            best => on_it().filter(|geom| best.is_some() && purpose(*geom) == best).collect(),
        }
    }

    /// Makes a mesh the box around it, or says why not.
    fn box_around(&mut self, geom: usize) -> Result<Fitted, String> {
        let GeomShape::Mesh(mesh) = self.geoms[geom].shape.clone() else { return Err("no mesh".into()) };
        let file = self.meshes.get(&mesh).ok_or_else(|| format!("mesh '{mesh}' has no file"))?;
        let (middle, half) = file.bounds()?;
        let (length, extent) = (2.0 * half.max(), self.extent());
        if length > extent {
            let path = file.path.display();
            return Err(format!(
                "mesh '{path}' is {length:.2} m long and the whole robot {extent:.2} m (is its scale missing?)"
            ));
        }
        let half = half.map(|x| x.max(LEAST));
        let shape = &mut self.geoms[geom];
        shape.position += shape.orientation * middle;
        shape.shape = GeomShape::Box(half);
        if !shape.collides() {
            (shape.contype, shape.conaffinity) = (1, 1);
        }
        Ok(Fitted { geom, mesh, size: half * 2.0 })
    }

    /// Returns what a geom is if it is a mesh whose file is there.
    fn purpose(&self, geom: &Geom) -> Option<Purpose> {
        let GeomShape::Mesh(mesh) = &geom.shape else { return None };
        Some(match self.meshes.get(mesh)? {
            _ if geom.collides() => Purpose::Collides,
            file if file.collides => Purpose::Silenced,
            _ => Purpose::Picture,
        })
    }

    /// Distance of the two bodies that are farthest apart (m), at the reference position.
    fn extent(&self) -> f64 {
        let at = Kinematics::new(self).body_position;
        let places = at.get(1..).unwrap_or_default();
        places.iter().flat_map(|a| places.iter().map(move |b| (a - b).norm())).fold(0.0, f64::max)
    }

    /// Puts the boxes into the text, in place of their meshes.
    fn rewrite(&mut self, fitted: &[Fitted]) {
        let Some(text) = self.mjcf.as_deref().filter(|_| !fitted.is_empty()) else { return };
        // Our own text, which was read before.
        let Ok(document) = document::parse(text, Path::new("text"), None) else { return };
        let mut boxes: BTreeMap<usize, Vec<&Fitted>> = BTreeMap::new();
        for one in fitted {
            boxes.entry(self.geoms[one.geom].body).or_default().push(one);
        }
        let (mut root, mut body) = (document.root, 0);
        for world in root.children.iter_mut().filter(|c| c.name == "worldbody") {
            self.replace(world, &mut body, &boxes);
        }
        self.mjcf = Some(root.to_xml());
    }

    /// Goes through the bodies in their order, which is the text's.
    fn replace(&self, element: &mut Element, body: &mut usize, boxes: &BTreeMap<usize, Vec<&Fitted>>) {
        for child in element.children.iter_mut().filter(|c| matches!(c.name.as_str(), "body" | "frame")) {
            if child.name == "body" {
                *body += 1;
                for one in boxes.get(body).into_iter().flatten() {
                    remove(child, &one.mesh);
                    child.children.push(self.box_geom(child, &self.geoms[one.geom]));
                }
            }
            self.replace(child, body, boxes);
        }
    }

    fn box_geom(&self, body: &Element, geom: &Geom) -> Element {
        let size = if let GeomShape::Box(half) = geom.shape { half } else { Vec3::zeros() };
        let attributes = [
            ("name", geom.name.clone()),
            ("type", "box".into()),
            ("size", numbers(size.as_slice())),
            ("pos", numbers(geom.position.as_slice())),
            ("quat", numbers(&to_wxyz(&geom.orientation))),
            // The body says its mass: one that is a mesh's is refused.
            ("mass", "0".into()),
            ("contype", geom.contype.to_string()),
            ("conaffinity", geom.conaffinity.to_string()),
            ("condim", geom.condim.to_string()),
            ("priority", geom.priority.to_string()),
            ("friction", numbers(&geom.friction)),
            ("solref", numbers(&geom.solref)),
            ("solimp", numbers(&geom.solimp)),
            ("margin", numbers(&[geom.margin])),
            ("gap", numbers(&[geom.gap])),
        ];
        Element {
            name: "geom".into(),
            attributes: attributes.map(|(name, value)| (name.to_string(), value)).to_vec(),
            children: Vec::new(),
            at: body.at.clone(),
        }
    }
}

/// Removes the geoms of a mesh from a body, and from frames in it.
fn remove(element: &mut Element, mesh: &str) {
    element.children.retain(|c| c.name != "geom" || c.attribute("mesh") != Some(mesh));
    for frame in element.children.iter_mut().filter(|c| c.name == "frame") {
        remove(frame, mesh);
    }
}
