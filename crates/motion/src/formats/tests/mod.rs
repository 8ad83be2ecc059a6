//! Small files with known numbers, broken files, and random ones. Real captures are in `tests/captured.rs`.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::path::Path;

use lifelike_character::{Quat, Vec3};

use super::*;
use crate::source::SourceClip;

mod amass;
mod broken;
mod fbx;
mod fuzz;
mod glb;
mod humanml3d;
mod numbers;
mod robot_motion;
mod table;
mod written;

/// 14 joints with common names, orders of axes all different, random angles.
const BVH: &str = include_str!("small.bvh");

/// Two legs and two arms with the CMU names, the legs spread by 20 degrees.
const ASF: &str = "# made for a test
:version 1.10
:name TEST
:units
  mass 1.0
  length 0.45
  angle deg
:documentation
   any words : here
:root
   order TX TY TZ RX RY RZ
   axis XYZ
   position 0 0 0
   orientation 0 0 0
:bonedata
  begin
     id 1
     name lfemur
     direction 0.342 -0.94 0
     length 7
     axis 0 0 20 XYZ
    dof rx ry rz
    limits (-160.0 20.0)
           (-70.0 70.0)
           (-60.0 70.0)
  end
  begin
     id 2
     name lfoot
     direction 0 -0.2 1
     length 2
     axis -90 0 20 XYZ
    dof rx rz
  end
:hierarchy
  begin
    root lfemur
    lfemur lfoot
  end
";

const AMC: &str = "#!OML:ASF test.ASF
:FULLY-SPECIFIED
:DEGREES
1
root 1 17 -3 10 -20 35
lfemur 30 -15 25
lfoot 12 -33
2
lfoot 0 0
lfemur 0 0 0
root 0 0 0 0 0 0
";

const CHARACTER: &str = r#"{"Skeleton": {"Joints": [
{"ID": 0, "Name": "root", "Type": "none", "Parent": -1, "AttachX": 0, "AttachY": 0, "AttachZ": 0},
{"ID": 1, "Name": "right_hip", "Type": "spherical", "Parent": 0, "AttachX": 0, "AttachY": -0.1, "AttachZ": 0.085},
{"ID": 2, "Name": "right_knee", "Type": "revolute", "Parent": 1, "AttachX": 0, "AttachY": -0.42, "AttachZ": 0},
{"ID": 3, "Name": "right_ankle", "Type": "fixed", "Parent": 2, "AttachX": 0, "AttachY": -0.41, "AttachZ": 0}
]}, "BodyDefs": []}"#;

const DEEPMIMIC: &str = r#"{"Loop": "wrap", "Frames": [
[0.0333333, 1, 0.9, -0.4, 0.9, 0.1, -0.2, 0.3, 0.8, 0.3, 0.2, -0.1, -0.7],
[0.0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0]
]}"#;

fn bvh(text: &[u8]) -> Result<SourceClip, MotionError> {
    bvh::parse(text, Path::new("x.bvh"), &ReadOptions::default())
}

fn acclaim(asf: &[u8], amc: &[u8]) -> Result<SourceClip, MotionError> {
    let skeleton = asf::parse(asf, Path::new("x.asf"))?;
    amc::parse(amc, Path::new("x.amc"), &skeleton, &ReadOptions::default())
}

fn deepmimic(character: &[u8], motion: &[u8]) -> Result<SourceClip, MotionError> {
    let character = deepmimic::parse_character(character, Path::new("x.txt"))?;
    deepmimic::parse(motion, Path::new("y.txt"), &character, &ReadOptions::default())
}

/// Returns the world position of a joint by name.
fn place(clip: &SourceClip, frame: usize, name: &str) -> Vec3 {
    clip.pose(frame).0[joint(clip, name)]
}

/// Returns the world rotation of a joint by name.
fn turn(clip: &SourceClip, frame: usize, name: &str) -> Quat {
    clip.pose(frame).1[joint(clip, name)]
}

fn joint(clip: &SourceClip, name: &str) -> usize {
    clip.skeleton.names.iter().position(|n| n == name).unwrap()
}
