//! Mass and inertia of geoms and their sums, as MuJoCo's compiler computes them.
