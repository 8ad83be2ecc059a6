//! The clips that come with the program: the texts of `motions/`, so that nothing needs to be fetched.

macro_rules! clips {
    ($($name:literal),* $(,)?) => {
        [$(($name, include_str!(concat!("../../motions/", $name, ".keys.toml")))),*]
    };
}

/// Returns the name and text of every clip in `motions/`. Make a clip of one with [`super::parse`].
pub fn builtin() -> impl Iterator<Item = (&'static str, &'static str)> {
    clips![
        "balance_on_one_leg",
        "bounce",
        "bow",
        "crouch",
        "fast_walk",
        "idle_breathing",
        "jog_in_place",
        "kick",
        "lift",
        "look_around",
        "lunge",
        "march",
        "march_forward",
        "nod",
        "pick_up",
        "point",
        "proud_walk",
        "pull",
        "punch",
        "push",
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
        "throw",
        "tired_walk",
        "turn_around_180",
        "turn_in_place",
        "turn_left_90",
        "uppercut",
        "walk",
        "walk_backward",
        "walk_curve",
        "walk_sideways",
        "wave",
        "weight_shift",
    ]
    .into_iter()
}
