//! MJCF in.
