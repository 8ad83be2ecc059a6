//! Whole-body inverse kinematics from a captured human onto a character.
