//! The clips that come with the program: the texts of `motions/`, so that nothing needs to be fetched.

macro_rules! clips {
    ($($name:literal),* $(,)?) => {
        [$(($name, include_str!(concat!("../../motions/", $name, ".keys.toml")))),*]
    };
}

/// Returns the name and text of every clip in `motions/`. Make a clip of one with [`super::parse`].
pub fn builtin() -> impl Iterator<Item = (&'static str, &'static str)> {
    clips![
        "bow",
        "idle_breathing",
        "look_around",
        "march",
        "nod",
        "point",
        "shake_head",
        "side_step",
        "squat",
        "step_in_place",
        "stretch",
        "sway_dance",
        "turn_in_place",
        "walk",
        "wave",
        "weight_shift",
    ]
    .into_iter()
}
