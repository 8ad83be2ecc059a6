//! URDF in.
