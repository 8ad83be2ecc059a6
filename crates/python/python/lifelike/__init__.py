"""Lifelike motion for robots and physics-based characters.

The main path: `Robot` -> `load_clips` or `retarget` -> `Controller` in a `Simulation` -> `evaluate`. Policies learn in
`TrackingEnvironment` (`lifelike.gymnasium`, `lifelike.rsl_rl`) or by `train_tracker`. `generate` makes motion from
sentences. SI units, radians, z up, x forward, quaternions `wxyz`. Whatever is wrong with an input is an `Error`.
"""

from lifelike._lifelike import (
    Clip,
    Controller,
    ControllerRun,
    Error,
    Robot,
    SavedState,
    Simulation,
    TrackingEnvironment,
    __version__,
    evaluate,
    generate,
    load_clips,
    retarget,
    train_tracker,
)

__all__ = [
    "Clip",
    "Controller",
    "ControllerRun",
    "Error",
    "Robot",
    "SavedState",
    "Simulation",
    "TrackingEnvironment",
    "__version__",
    "evaluate",
    "generate",
    "load_clips",
    "retarget",
    "train_tracker",
]
