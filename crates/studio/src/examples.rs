//! Scenes that come with the program, each made by operations.

/// Their names and texts.
pub const ALL: [(&str, &str); 10] = [
    ("hello", include_str!("../scenes/hello.scene.toml")),
    ("carry", include_str!("../scenes/carry.scene.toml")),
    ("conversation", include_str!("../scenes/conversation.scene.toml")),
    ("dance", include_str!("../scenes/dance.scene.toml")),
    ("entrance", include_str!("../scenes/entrance.scene.toml")),
    ("fall", include_str!("../scenes/fall.scene.toml")),
    ("ice", include_str!("../scenes/ice.scene.toml")),
    ("marching_wave", include_str!("../scenes/marching_wave.scene.toml")),
    ("mirror", include_str!("../scenes/mirror.scene.toml")),
    ("pushed", include_str!("../scenes/pushed.scene.toml")),
];

/// Returns the name and text of an example.
pub fn find(name: &str) -> Option<(&'static str, &'static str)> {
    ALL.into_iter().find(|(known, _)| *known == name)
}
