//! `<compiler>` and `<option>`: settings for the whole model.

use std::path::{Path, PathBuf};

use crate::error::CharacterError;
use crate::mjcf::attributes::{Attributes, Tristate};
use crate::mjcf::document::Element;
use crate::rotation::Vec3;

/// Settings of `<compiler>`, with MuJoCo's defaults.
#[derive(Debug, Clone)]
pub(crate) struct Compiler {
    /// Radians per unit of angle in the text.
    pub angle: f64,
    pub eulerseq: [char; 3],
    pub autolimits: bool,
    pub boundmass: f64,
    pub boundinertia: f64,
    pub balanceinertia: bool,
    pub settotalmass: Option<f64>,
    /// `True`: from geoms always; `Auto`: where there is no `<inertial>`; `False`: never.
    pub inertiafromgeom: Tristate,
    pub inertiagrouprange: [f64; 2],
    pub meshdir: PathBuf,
    pub strippath: bool,
}

impl Compiler {
    /// Reads every `<compiler>` section; later ones win.
    pub fn read(root: &Element) -> Result<Self, CharacterError> {
        let mut compiler = Self {
            angle: 1f64.to_radians(),
            eulerseq: ['x', 'y', 'z'],
            autolimits: true,
            boundmass: 0.0,
            boundinertia: 0.0,
            balanceinertia: false,
            settotalmass: None,
            inertiafromgeom: Tristate::Auto,
            inertiagrouprange: [0.0, 5.0],
            meshdir: PathBuf::new(),
            strippath: false,
        };
        for section in root.children_named("compiler") {
            compiler.take(&Attributes::own(section))?;
        }
        Ok(compiler)
    }

    /// Returns the file of a mesh or height field, where it is there.
    pub fn mesh_path(&self, folder: Option<&Path>, file: &str) -> Option<PathBuf> {
        let given = Path::new(file);
        let last = given.file_name().map_or(given, Path::new);
        folder?.join(&self.meshdir).join(if self.strippath { last } else { given }).canonicalize().ok()
    }

    fn take(&mut self, a: &Attributes) -> Result<(), CharacterError> {
        a.only(&[
            "angle",
            "eulerseq",
            "autolimits",
            "boundmass",
            "boundinertia",
            "balanceinertia",
            "settotalmass",
            "inertiafromgeom",
            "inertiagrouprange",
            "meshdir",
            "assetdir",
            "texturedir",
            "strippath",
            "coordinate",
            "discardvisual",
            "usethread",
            "fitaabb",
            "exactmeshinertia",
            "alignfree",
            "fusestatic",
            "saveinertial",
            "conflict",
        ])?;
        match a.text("angle") {
            None => {}
            Some("degree") => self.angle = 1f64.to_radians(),
            Some("radian") => self.angle = 1.0,
            Some(other) => return Err(a.invalid("'degree' or 'radian' for 'angle'", format!("'{other}'"))),
        }
        if let Some(text) = a.text("eulerseq") {
            let letters: Vec<char> = text.chars().collect();
            self.eulerseq = <[char; 3]>::try_from(letters)
                .ok()
                .filter(|s| s.iter().all(|c| "xyzXYZ".contains(*c)))
                .ok_or_else(|| a.invalid("three of the letters xyzXYZ for 'eulerseq'", format!("'{text}'")))?;
        }
        self.autolimits = a.boolean("autolimits", self.autolimits)?;
        self.boundmass = a.number("boundmass")?.unwrap_or(self.boundmass);
        self.boundinertia = a.number("boundinertia")?.unwrap_or(self.boundinertia);
        self.balanceinertia = a.boolean("balanceinertia", self.balanceinertia)?;
        self.settotalmass = a.number("settotalmass")?.filter(|m| *m > 0.0).or(self.settotalmass);
        if a.text("inertiafromgeom").is_some() {
            self.inertiafromgeom = a.tristate("inertiafromgeom")?;
        }
        self.inertiagrouprange = a.numbers("inertiagrouprange")?.unwrap_or(self.inertiagrouprange);
        if let Some(folder) = a.text("meshdir").or(a.text("assetdir")) {
            self.meshdir = PathBuf::from(folder);
        }
        self.strippath = a.boolean("strippath", self.strippath)?;
        if a.text("coordinate").is_some_and(|c| c != "local") {
            return Err(a.unsupported("attribute 'coordinate' other than 'local'"));
        }
        // These would merge bodies or move frames, and with them everything that refers to bodies by name.
        for refused in ["fusestatic", "alignfree"] {
            if a.boolean(refused, false)? {
                return Err(a.unsupported(format!("attribute '{refused}' that is true")));
            }
        }
        Ok(())
    }
}

/// Settings of `<option>` that a character needs.
#[derive(Debug, Clone)]
pub(crate) struct PhysicsOption {
    pub timestep: f64,
    pub gravity: Vec3,
}

impl PhysicsOption {
    /// Reads every `<option>` section; adds to `notes` what only the engine that compiles the text itself obeys.
    pub fn read(root: &Element, notes: &mut Vec<String>, warnings: &mut Vec<String>) -> Result<Self, CharacterError> {
        let mut option = Self { timestep: 0.002, gravity: Vec3::new(0.0, 0.0, -9.81) };
        for section in root.children_named("option") {
            let a = Attributes::own(section);
            a.only(&[
                "timestep",
                "gravity",
                "integrator",
                "cone",
                "jacobian",
                "solver",
                "iterations",
                "tolerance",
                "ls_iterations",
                "ls_tolerance",
                "noslip_iterations",
                "noslip_tolerance",
                "ccd_iterations",
                "ccd_tolerance",
                "mpr_iterations",
                "mpr_tolerance",
                "sdf_iterations",
                "sdf_initpoints",
                "impratio",
                "apirate",
                "wind",
                "magnetic",
                "density",
                "viscosity",
                "o_margin",
                "o_solref",
                "o_solimp",
                "o_friction",
                "actuatorgroupdisable",
                "collision",
                "sleep_tolerance",
            ])?;
            option.timestep = a.number("timestep")?.unwrap_or(option.timestep);
            if option.timestep <= 0.0 {
                return Err(a.invalid("a positive 'timestep'", option.timestep.to_string()));
            }
            option.gravity = a.numbers::<3>("gravity")?.map_or(option.gravity, Vec3::from);
            for medium in ["density", "viscosity"] {
                if a.number(medium)?.is_some_and(|x| x != 0.0) {
                    warnings.push(format!(
                        "option {medium} asks for forces of a fluid: MuJoCo has them, our engine has not"
                    ));
                }
            }
            for (attribute, own) in
                [("cone", "pyramidal"), ("impratio", "1"), ("noslip_iterations", "0"), ("integrator", "Euler")]
            {
                if let Some(value) = a.text(attribute).filter(|value| *value != own) {
                    notes.push(format!("option {attribute} is {value}: our engine has {own}"));
                }
            }
            if let Some(groups) = a.text("actuatorgroupdisable") {
                warnings.push(format!(
                    "actuators of group {groups} are off in MuJoCo and on in our engine: remove 'actuatorgroupdisable'"
                ));
            }
            for child in &section.children {
                if child.name != "flag" {
                    return Err(child.unsupported("element in <option>"));
                }
                for (flag, value) in &child.attributes {
                    match (flag.as_str(), value.as_str()) {
                        ("gravity", "disable") => {
                            option.gravity = Vec3::zeros();
                            warnings.push("gravity is off: remove <flag gravity=\"disable\"/>".into());
                        }
                        ("gravity", "enable") => {}
                        (flag, "disable") if DYNAMICS.contains(&flag) => warnings.push(format!(
                            "{flag} is off in MuJoCo and on in our engine: remove <flag {flag}=\"disable\"/>"
                        )),
                        (_, "enable" | "disable") => notes.push(format!("option flag {flag} is set to {value}")),
                        _ => return Err(child.invalid("'enable' or 'disable'", format!("{flag}='{value}'"))),
                    }
                }
            }
        }
        if option.gravity == Vec3::zeros() && warnings.iter().all(|w| !w.starts_with("gravity")) {
            warnings.push("gravity is 0 0 0: set <option gravity=\"0 0 -9.81\"/>".into());
        }
        Ok(option)
    }
}

/// Flags without which a model moves otherwise.
const DYNAMICS: [&str; 8] =
    ["contact", "constraint", "equality", "frictionloss", "limit", "passive", "spring", "damper"];
