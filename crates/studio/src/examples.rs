//! Scenes that come with the program, each made by operations.

/// Their names and texts.
pub const ALL: [(&str, &str); 1] = [("hello", include_str!("../scenes/hello.scene.toml"))];

/// Returns the name and text of an example.
pub fn find(name: &str) -> Option<(&'static str, &'static str)> {
    ALL.into_iter().find(|(known, _)| *known == name)
}
