//! Prints the joints of a captured motion and their places, frame by frame (m), for comparison with other readers.
#![allow(clippy::unwrap_used)]
use lifelike_motion::formats::{ReadOptions, read_source};
use std::path::Path;

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    // Axes are stated, so that a body that no standing pose is found of is read too.
    let axis = |at: usize| args.get(at).map(|axis| axis.parse().unwrap());
    let options = ReadOptions { up: axis(1), forward: axis(2), ..ReadOptions::default() };
    let clip = read_source(Path::new(&args[0]), &options).unwrap_or_else(|error| {
        eprintln!("{error}");
        std::process::exit(3)
    });
    println!("{} {}", clip.fps, clip.skeleton.names.join("\t"));
    for t in 0..clip.len() {
        let places = clip.pose(t).0;
        let places: Vec<String> = places.iter().map(|p| format!("{} {} {}", p.x, p.y, p.z)).collect();
        println!("{}", places.join("\t"));
    }
}
