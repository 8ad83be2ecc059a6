//! The XML as a tree of our own that remembers where each element stood, with `<include>` already expanded.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::error::{CharacterError, Location};
use crate::mjcf::xml_text;

/// Deeper nesting than any robot has; keeps recursion within the stack whatever the file says.
const MAX_DEPTH: usize = 200;
/// More elements, texts and comments than any robot's file has.
const MOST_NODES: u32 = 5_000_000;
/// Start of the text that stands for a file which Git LFS keeps.
pub(crate) const POINTER: &str = "version https://git-lfs";
/// More included files than any model has.
const MAX_FILES: usize = 200;

/// One XML element.
#[derive(Debug, Clone)]
pub(crate) struct Element {
    pub name: String,
    pub attributes: Vec<(String, String)>,
    pub children: Vec<Element>,
    pub at: Location,
}

impl Element {
    /// Returns the value of an attribute as written.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(n, _)| n == name).map(|(_, v)| v.as_str())
    }

    /// Returns the children with this tag.
    pub fn children_named<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Element> {
        self.children.iter().filter(move |c| c.name == name)
    }

    /// Returns the error "expected this, got that" at this element.
    pub fn invalid(&self, expected: impl Into<String>, got: impl Into<String>) -> CharacterError {
        CharacterError::Invalid { at: self.at.clone(), expected: expected.into(), got: got.into() }
    }

    /// Returns the error "unsupported" at this element.
    pub fn unsupported(&self, what: impl Into<String>) -> CharacterError {
        CharacterError::Unsupported { at: self.at.clone(), what: what.into() }
    }

    /// Returns the tree as XML text.
    pub fn to_xml(&self) -> String {
        let mut out = String::new();
        self.write_xml(&mut out, 0);
        out
    }

    fn write_xml(&self, out: &mut String, depth: usize) {
        let indent = "  ".repeat(depth);
        out.push_str(&indent);
        out.push('<');
        out.push_str(&self.name);
        for (name, value) in &self.attributes {
            out.push_str(&format!(" {name}=\"{}\"", escape(value)));
        }
        if self.children.is_empty() {
            out.push_str("/>\n");
            return;
        }
        out.push_str(">\n");
        for child in &self.children {
            child.write_xml(out, depth + 1);
        }
        out.push_str(&format!("{indent}</{}>\n", self.name));
    }
}

/// Returns numbers as the value of an attribute, without loss.
pub(crate) fn numbers(values: &[f64]) -> String {
    values.iter().map(|v| format!("{v:e}")).collect::<Vec<_>>().join(" ")
}

fn escape(value: &str) -> String {
    value.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;").replace('\n', "&#10;")
}

/// A text with all that it includes.
#[derive(Debug)]
pub(crate) struct Document {
    pub root: Element,
    /// Includes whose files are missing and may be no more than looks ([`LOOKS`]).
    pub missing: Vec<Element>,
}

/// Elements in which a missing include may be no more than looks: models share files of sky, colours and lights, and
/// travel without them. Anywhere else it would be bodies, joints or defaults.
const LOOKS: [&str; 3] = ["mujoco", "asset", "visual"];

/// Parses `text`; `file` is what errors call it, `folder` is where `<include file>` starts from (`None`: includes are
/// refused).
pub(crate) fn parse(text: &str, file: &Path, folder: Option<&Path>) -> Result<Document, CharacterError> {
    let mut includes = Includes::default();
    let mut roots = parse_file(text, file, folder, &mut includes, None, 0)?;
    match roots.pop() {
        Some(root) if roots.is_empty() => Ok(Document { root, missing: includes.missing }),
        _ => Err(CharacterError::Xml { file: file.to_path_buf(), line: 1, message: "no root element".into() }),
    }
}

/// Included files so far.
#[derive(Default)]
struct Includes {
    seen: Vec<PathBuf>,
    missing: Vec<Element>,
}

/// Returns the root element, in a vector of one. Its children will stand in an element called `place`, if it is
/// included.
fn parse_file(
    text: &str,
    file: &Path,
    folder: Option<&Path>,
    includes: &mut Includes,
    place: Option<&str>,
    depth: usize,
) -> Result<Vec<Element>, CharacterError> {
    let text = &xml_text::without_late_declaration(text);
    // Entities are expanded, but not without end: the parser bounds their depth and number.
    let options = roxmltree::ParsingOptions { allow_dtd: true, nodes_limit: MOST_NODES, ..Default::default() };
    let document = roxmltree::Document::parse_with_options(text, options).map_err(|e| match e {
        _ if text.starts_with(POINTER) => CharacterError::Xml {
            file: file.to_path_buf(),
            line: 1,
            message: "a pointer of Git LFS in place of the file; fetch it with `git lfs pull`".into(),
        },
        _ if text.starts_with("#usda") => CharacterError::Xml {
            file: file.to_path_buf(),
            line: 1,
            message: "expected MJCF or URDF, got USD, which is not read: export the robot as MJCF or URDF".into(),
        },
        roxmltree::Error::UnknownNamespace(prefix, at) if prefix == "xacro" => xacro(file, at.row, &prefix),
        _ => CharacterError::Xml { file: file.to_path_buf(), line: e.pos().row, message: e.to_string() },
    })?;
    let root = document.root_element();
    if let Some((node, what)) = root.descendants().find_map(|node| Some((node, macro_in(&node)?))) {
        return Err(xacro(file, document.text_pos_at(node.range().start).row, &what));
    }
    let place = place.unwrap_or(root.tag_name().name());
    let mut roots = Vec::new();
    Builder { document: &document, file, folder, includes, place }.add(root, "", depth, &mut roots)?;
    Ok(roots)
}

/// Returns what is left of the macro language of ROS in an element.
fn macro_in(node: &roxmltree::Node<'_, '_>) -> Option<String> {
    let (tag, namespace) = (node.tag_name().name(), node.tag_name().namespace());
    let value = || node.attributes().map(|a| a.value()).find(|value| value.contains("${") || value.contains("$("));
    match namespace.filter(|name| name.contains("xacro")) {
        Some(_) => Some(format!("<xacro:{tag}>")),
        None => value().map(|value| format!("'{value}'")),
    }
}

/// Returns the error for a file that is to be expanded first.
fn xacro(file: &Path, line: u32, got: &str) -> CharacterError {
    let at = Location { file: file.to_path_buf(), line, element: "xacro".into() };
    let expected = format!(
        "URDF without macros; this is xacro, so expand it (`xacro {} > robot.urdf`) and give robot.urdf",
        file.display()
    );
    CharacterError::Invalid { at, expected, got: got.into() }
}

struct Builder<'a, 'input> {
    document: &'a roxmltree::Document<'input>,
    file: &'a Path,
    folder: Option<&'a Path>,
    includes: &'a mut Includes,
    /// Name of the element in which the root's children will stand.
    place: &'a str,
}

impl Builder<'_, '_> {
    fn add(
        &mut self,
        node: roxmltree::Node<'_, '_>,
        parent: &str,
        depth: usize,
        into: &mut Vec<Element>,
    ) -> Result<(), CharacterError> {
        let name = node.tag_name().name().to_string();
        let line = self.document.text_pos_at(node.range().start).row;
        let mut element = Element {
            at: Location { file: self.file.to_path_buf(), line, element: name.clone() },
            name,
            attributes: node.attributes().map(|a| (a.name().to_string(), a.value().to_string())).collect(),
            children: Vec::new(),
        };
        if depth > MAX_DEPTH {
            return Err(element.invalid(format!("at most {MAX_DEPTH} levels of elements"), "more"));
        }
        if element.name == "include" {
            return self.include(element, parent, depth, into);
        }
        let own = if node == self.document.root_element() { self.place } else { &element.name };
        for child in node.children().filter(roxmltree::Node::is_element) {
            self.add(child, own, depth + 1, &mut element.children)?;
        }
        into.push(element);
        Ok(())
    }

    /// Puts the children of the included file's root where the `<include>` stands, as MuJoCo does. Remembers a file
    /// that is missing and may be no more than looks.
    fn include(
        &mut self,
        element: Element,
        parent: &str,
        depth: usize,
        into: &mut Vec<Element>,
    ) -> Result<(), CharacterError> {
        let name = element.attribute("file").ok_or_else(|| element.invalid("attribute 'file'", "none"))?;
        let folder = self.folder.ok_or_else(|| element.unsupported("include in a text without a folder"))?;
        let path = folder.join(name);
        if self.includes.seen.contains(&path) || self.includes.seen.len() >= MAX_FILES {
            return Err(element.invalid("a file that was not included before", name));
        }
        self.includes.seen.push(path.clone());
        let text = match xml_text::read(&path) {
            Ok(text) => text,
            Err(CharacterError::Io { source, .. })
                if source.kind() == ErrorKind::NotFound && LOOKS.contains(&parent) =>
            {
                self.includes.missing.push(element);
                return Ok(());
            }
            Err(CharacterError::Io { source, .. }) => {
                return Err(element.invalid("a file that can be read", format!("'{}': {source}", path.display())));
            }
            Err(error) => return Err(error),
        };
        // MuJoCo resolves nested includes from the folder of the MAIN file, so the folder stays the same.
        for root in parse_file(&text, &path, self.folder, self.includes, Some(parent), depth + 1)? {
            into.extend(root.children);
        }
        Ok(())
    }
}
