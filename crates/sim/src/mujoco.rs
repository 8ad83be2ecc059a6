//! MuJoCo 3.17.
