//! `<default>`: classes of attribute values that elements inherit.

use std::collections::BTreeMap;

use crate::error::CharacterError;
use crate::mjcf::attributes::{Attributes, overlay};
use crate::mjcf::document::Element;

/// Kinds of elements in a class. All actuators share one kind: `<general>` values reach a `<motor>`, as in MuJoCo.
const ACTUATORS: [&str; 12] = [
    "general",
    "motor",
    "position",
    "velocity",
    "intvelocity",
    "damper",
    "cylinder",
    "muscle",
    "adhesion",
    "plugin",
    "dcmotor",
    "pid",
];
const OTHERS: [&str; 10] =
    ["joint", "geom", "site", "camera", "light", "mesh", "material", "pair", "equality", "tendon"];

/// All equality constraints share one kind: `<default>` knows `<equality>` only.
const EQUALITIES: [&str; 2] = ["connect", "weld"];

/// So do all tendons.
const TENDONS: [&str; 2] = ["fixed", "spatial"];

/// One class.
#[derive(Debug, Clone, Default)]
struct Class {
    /// For each kind of element, the attribute values.
    values: BTreeMap<&'static str, Vec<(String, String)>>,
    /// Its own elements of actuators.
    actuators: Vec<Element>,
    /// Name of the class around it.
    outer: Option<String>,
}

/// All default classes by name. The outermost is `main`.
#[derive(Debug)]
pub(crate) struct Defaults {
    classes: BTreeMap<String, Class>,
}

fn kind(tag: &str) -> Option<&'static str> {
    if ACTUATORS.contains(&tag) {
        return Some("actuator");
    }
    if EQUALITIES.contains(&tag) {
        return Some("equality");
    }
    if TENDONS.contains(&tag) {
        return Some("tendon");
    }
    OTHERS.into_iter().find(|k| *k == tag)
}

impl Defaults {
    /// Reads every `<default>` section of the model.
    pub fn read(root: &Element) -> Result<Self, CharacterError> {
        let mut defaults = Self { classes: BTreeMap::from([("main".to_string(), Class::default())]) };
        for section in root.children_named("default") {
            // The outermost class may be given a name; it is the one class that may be continued.
            let name = section.attribute("class").unwrap_or("main").to_string();
            if name != "main" && !defaults.classes.contains_key(&name) {
                let main = defaults.classes.get("main").cloned().unwrap_or_default();
                defaults.classes.insert(name.clone(), main);
            }
            defaults.fill(section, &name)?;
            if name != "main" {
                let filled = defaults.classes.get(&name).cloned().unwrap_or_default();
                defaults.classes.insert("main".to_string(), filled);
            }
        }
        Ok(defaults)
    }

    /// Reads the elements of one class, then the classes inside it, which start as copies of it.
    fn fill(&mut self, section: &Element, name: &str) -> Result<(), CharacterError> {
        Attributes::own(section).only(&["class"])?;
        let mut class = self.classes.get(name).cloned().unwrap_or_default();
        for element in section.children.iter().filter(|c| c.name != "default") {
            let Some(kind) = kind(&element.name) else {
                return Err(element.unsupported("element in <default>"));
            };
            let values = class.values.entry(kind).or_default();
            *values = overlay(values, &element.attributes);
            if kind == "actuator" {
                class.actuators.push(element.clone());
            }
        }
        self.classes.insert(name.to_string(), class.clone());
        for child in section.children_named("default") {
            let inner = child
                .attribute("class")
                .ok_or_else(|| child.invalid("attribute 'class' of a nested default", "none"))?;
            if self.classes.contains_key(inner) {
                return Err(child.invalid("a class name that is not taken", format!("'{inner}'")));
            }
            let start = Class { values: class.values.clone(), actuators: Vec::new(), outer: Some(name.to_string()) };
            self.classes.insert(inner.to_string(), start);
            self.fill(child, inner)?;
        }
        Ok(())
    }

    /// Returns the attributes in force for `element`: its own over those of its class (its `class`, else `childclass`
    /// of the bodies around it, else `main`).
    pub fn resolve(&self, element: &Element, childclass: Option<&str>) -> Result<Attributes, CharacterError> {
        let name = element.attribute("class").or(childclass).unwrap_or("main");
        let class = self.classes.get(name).ok_or_else(|| {
            let known = self.classes.keys().cloned().collect::<Vec<_>>().join(", ");
            element.invalid(format!("a default class (there are: {known})"), format!("'{name}'"))
        })?;
        let inherited = kind(&element.name).and_then(|k| class.values.get(k)).map_or(&[][..], Vec::as_slice);
        Ok(Attributes::over(inherited, element))
    }

    /// Returns the actuators' elements in an actuator's class and in the classes around it, from the inside out.
    pub fn actuators(&self, element: &Element) -> Vec<&[Element]> {
        let mut class = self.classes.get(element.attribute("class").unwrap_or("main"));
        let mut all = Vec::new();
        while let Some(own) = class {
            all.push(own.actuators.as_slice());
            class = own.outer.as_ref().and_then(|outer| self.classes.get(outer));
        }
        all
    }

    /// Returns whether there is a class of this name.
    pub fn contains(&self, name: &str) -> bool {
        self.classes.contains_key(name)
    }
}
