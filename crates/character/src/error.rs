//! Errors of reading and using a description of a character.

use std::path::PathBuf;

/// Location in a text: file, line and element.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Location {
    /// The file, or a name such as `<text>` for a string.
    pub file: PathBuf,
    /// Line, counted from 1.
    pub line: u32,
    /// The element, such as `joint`.
    pub element: String,
}

impl std::fmt::Display for Location {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}: <{}>", self.file.display(), self.line, self.element)
    }
}

/// Everything that reading or using a character can fail with.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CharacterError {
    /// The file cannot be read.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Cause.
        source: std::io::Error,
    },
    /// Not well-formed XML.
    #[error("{file}:{line}: not well-formed XML: {message}")]
    Xml {
        /// The file.
        file: PathBuf,
        /// Line, counted from 1.
        line: u32,
        /// Message of the XML reader.
        message: String,
    },
    /// An element or attribute that we do not understand and therefore refuse.
    #[error("{at}: unsupported {what}")]
    Unsupported {
        /// Location.
        at: Location,
        /// The element or attribute, such as `attribute 'fluidcoef'`.
        what: String,
    },
    /// A value that is not what it should be.
    #[error("{at}: expected {expected}, got {got}")]
    Invalid {
        /// Location.
        at: Location,
        /// Expected content.
        expected: String,
        /// Actual content.
        got: String,
    },
    /// A text that does not stand on its own, and from which an included file is missing.
    #[error("{cause} (file '{file}', which {at} includes, is missing: put it there)")]
    MissingInclude {
        /// The include.
        at: Location,
        /// The missing file as the include names it.
        file: String,
        /// Error of compiling without it.
        cause: Box<CharacterError>,
    },
    /// A name that the character does not have.
    #[error("{character}: no {kind} named '{name}'; there are: {available}")]
    UnknownName {
        /// The character.
        character: String,
        /// `joint`, `body`, ...
        kind: &'static str,
        /// The name asked for.
        name: String,
        /// The names there are.
        available: String,
    },
    /// The character cannot be used for this.
    #[error("{character}: {message}")]
    Unfit {
        /// The character.
        character: String,
        /// Cause.
        message: String,
    },
}
