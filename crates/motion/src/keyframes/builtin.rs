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
        "fast_walk",
        "idle_breathing",
        "jog_in_place",
        "look_around",
        "march",
        "march_forward",
        "nod",
        "point",
        "proud_walk",
        "shake_head",
        "side_step",
        "sneak",
        "squat",
        "step_back",
        "step_forward",
        "step_in_place",
        "step_over",
        "stretch",
        "stumble",
        "sway_dance",
        "tired_walk",
        "turn_around_180",
        "turn_in_place",
        "turn_left_90",
        "walk",
        "walk_backward",
        "walk_curve",
        "walk_sideways",
        "wave",
        "weight_shift",
    ]
    .into_iter()
}
