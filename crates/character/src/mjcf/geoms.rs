//! `<geom>`, `<site>` and the shapes they have.

use crate::error::CharacterError;
use crate::inertia;
use crate::mjcf::attributes::Attributes;
use crate::mjcf::compiler::Compiler;
use crate::mjcf::pose::{POSE, Pose, from_to};
use crate::model::{Geom, GeomShape, Inertial, Site};
use crate::rotation::Vec3;

/// A geom and what only the compiler needs to know of it.
#[derive(Debug)]
pub(crate) struct ReadGeom {
    pub geom: Geom,
    /// Its share of the body's mass, or that it has one which is unknown (a mesh).
    pub weight: Weight,
    pub group: i64,
}

/// Mass of a geom.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Weight {
    /// Mass and inertia in the body frame.
    Known(Inertial),
    /// A mesh with this mass (kg), or else this density (kg/m³).
    OfMesh { mass: Option<f64>, density: f64 },
}

/// Reads a geom of `body`. Its name may be empty.
pub(crate) fn read(a: &Attributes, body: usize, frame: &Pose, compiler: &Compiler) -> Result<ReadGeom, CharacterError> {
    let mut known = vec![
        "name",
        "class",
        "type",
        "contype",
        "conaffinity",
        "condim",
        "group",
        "priority",
        "size",
        "material",
        "friction",
        "mass",
        "density",
        "shellinertia",
        "solmix",
        "solref",
        "solimp",
        "margin",
        "gap",
        "fromto",
        "hfield",
        "mesh",
        "fitscale",
        "rgba",
        "fluidshape",
        "fluidcoef",
        "user",
    ];
    known.extend(POSE);
    a.only(&known)?;
    let (shape, own) = shape_and_pose(a, compiler)?;
    let pose = frame.then(&own);
    let mask = |name: &str, otherwise: i64| -> Result<u32, CharacterError> {
        // MuJoCo reads a signed number and uses its 32 bits.
        Ok(a.integer(name, otherwise, i64::from(i32::MIN)..i64::from(u32::MAX) + 1)? as u32)
    };
    let rgba = a.prefix("rgba", [0.5, 0.5, 0.5, 1.0])?.map(|x| x as f32);
    let geom = Geom {
        name: a.text("name").unwrap_or("").to_string(),
        body,
        position: pose.position,
        orientation: pose.orientation,
        contype: mask("contype", 1)?,
        conaffinity: mask("conaffinity", 1)?,
        condim: a.integer("condim", 3, 1..7)? as u32,
        friction: a.prefix("friction", [1.0, 0.005, 0.0001])?,
        solref: a.prefix("solref", [0.02, 1.0])?,
        solimp: a.prefix("solimp", [0.9, 0.95, 0.001, 0.5, 2.0])?,
        margin: a.number("margin")?.unwrap_or(0.0),
        gap: a.number("gap")?.unwrap_or(0.0),
        priority: a.integer("priority", 0, -1000..1001)? as i32,
        rgba,
        shape,
    };
    if !matches!(geom.condim, 1 | 3 | 4 | 6) {
        return Err(a.invalid("1, 3, 4 or 6 for 'condim'", geom.condim.to_string()));
    }
    let weight = weight(a, &geom)?;
    Ok(ReadGeom { geom, weight, group: a.integer("group", 0, -1000..1000)? })
}

fn weight(a: &Attributes, geom: &Geom) -> Result<Weight, CharacterError> {
    let given = a.number("mass")?;
    let density = a.number("density")?.unwrap_or(1000.0);
    if given.is_some_and(|m| m < 0.0) || density < 0.0 {
        return Err(a.invalid("a mass and density that are not negative", "a negative one"));
    }
    let none = given == Some(0.0) || (given.is_none() && density == 0.0);
    let is_shell = a.boolean("shellinertia", false)?;
    if matches!(geom.shape, GeomShape::Mesh(_)) && !none {
        if is_shell {
            return Err(a.unsupported("'shellinertia' of a mesh; give its <mesh> inertia=\"shell\""));
        }
        return Ok(Weight::OfMesh { mass: given, density });
    }
    let volume = if is_shell { inertia::area(&geom.shape) } else { inertia::volume(&geom.shape) };
    let mass =
        given.filter(|_| volume > inertia::MIN_MASS).unwrap_or(if given.is_some() { 0.0 } else { density * volume });
    Ok(Weight::Known(Inertial {
        mass,
        com: geom.position,
        orientation: geom.orientation,
        diagonal: if is_shell { inertia::of_shell(&geom.shape, mass) } else { inertia::moments(&geom.shape, mass) },
    }))
}

fn shape_and_pose(a: &Attributes, compiler: &Compiler) -> Result<(GeomShape, Pose), CharacterError> {
    let kind = a.text("type").unwrap_or("sphere");
    if let Some(mesh) = a.text("mesh") {
        if kind != "mesh" {
            return Err(a.unsupported(format!("a {kind} fitted to a mesh; give 'size' in its place")));
        }
        return Ok((GeomShape::Mesh(mesh.to_string()), Pose::read(a, compiler)?));
    }
    let size = a.prefix("size", [0.0; 3])?;
    let stretched = if matches!(kind, "capsule" | "cylinder" | "box" | "ellipsoid") { from_to(a)? } else { None };
    if a.text("fromto").is_some() && stretched.is_none() {
        return Err(a.invalid("a capsule, cylinder, box or ellipsoid for 'fromto'", kind));
    }
    let (pose, half) = match stretched {
        Some((pose, half)) => (pose, Some(half)),
        None => (Pose::read(a, compiler)?, None),
    };
    let sizes = |needed: usize| -> Result<(), CharacterError> {
        match size.iter().take(needed).all(|s| *s > 0.0) {
            true => Ok(()),
            false => Err(a.invalid(
                format!("{needed} positive number(s) for 'size' of a {kind}"),
                format!("'{}'", a.text("size").unwrap_or("")),
            )),
        }
    };
    let shape = match kind {
        "plane" => GeomShape::Plane,
        "sphere" => {
            sizes(1)?;
            GeomShape::Sphere(size[0])
        }
        "capsule" | "cylinder" => {
            sizes(if half.is_some() { 1 } else { 2 })?;
            let half = half.unwrap_or(size[1]);
            if kind == "capsule" { GeomShape::Capsule(size[0], half) } else { GeomShape::Cylinder(size[0], half) }
        }
        "box" | "ellipsoid" => {
            sizes(if half.is_some() { 1 } else { 3 })?;
            // Stretched between two points MuJoCo takes the first number for both sides.
            let h = half.map_or(Vec3::from(size), |half| Vec3::new(size[0], size[0], half));
            if kind == "box" { GeomShape::Box(h) } else { GeomShape::Ellipsoid(h) }
        }
        "hfield" => GeomShape::HeightField(a.required("hfield")?.to_string()),
        "mesh" => return Err(a.invalid("attribute 'mesh'", "none")),
        other => return Err(a.unsupported(format!("geom type '{other}'"))),
    };
    Ok((shape, pose))
}

/// Reads a site of `body`. Its name may be empty.
pub(crate) fn read_site(
    a: &Attributes,
    body: usize,
    frame: &Pose,
    compiler: &Compiler,
) -> Result<Site, CharacterError> {
    let mut known = vec!["name", "class", "type", "group", "material", "size", "fromto", "rgba", "user"];
    known.extend(POSE);
    a.only(&known)?;
    let own = match from_to(a)? {
        Some((pose, _)) => pose,
        None => Pose::read(a, compiler)?,
    };
    let pose = frame.then(&own);
    Ok(Site {
        name: a.text("name").unwrap_or("").to_string(),
        body,
        position: pose.position,
        orientation: pose.orientation,
    })
}
