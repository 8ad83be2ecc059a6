//! Tasks around the build, as `cargo xtask COMMAND`: fetch what is not ours to keep, run the demo, run the tests.

use std::process::ExitCode;

use lifelike_fetch::{mujoco, text_model};
use xtask::{build, dist, docs};

const HELP: &str = "\
cargo xtask COMMAND

  demo [ARGUMENTS]    build what the demo needs (no training), run `lifelike demo` with these arguments
  test [ARGUMENTS]    run every test; MuJoCo and other people's robots are fetched for it; arguments go to `cargo test`
  mujoco              fetch MuJoCo 3.17.0 into third_party/mujoco and check it (needs python3 with pip, once)
  fetch NAME          fetch somebody else's robot into third_party/robots (unitree_g1 [--without-meshes], dm_control),
                      or the text encoder of text to motion into third_party/minilm (minilm, 83 MB)
  dist                build a stripped program with completions and manual pages: a tarball, and a Debian package
                      where dpkg is there
  docs [PROGRAM]      build the documentation site into target/book/html with mdBook, which is installed into third_party
                      where it is missing; the command reference is what the program prints, built where none is named
  help                this text

Nothing else of this project touches the network. What is fetched has a fixed version and a fixed SHA-256.";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let rest = arguments.get(1..).unwrap_or_default();
    let done = match arguments.first().map(String::as_str) {
        Some("demo") => build::demo(rest),
        Some("test") => build::test(rest),
        Some("mujoco") => mujoco::ensure(&xtask::third_party()).map(|_| ()),
        Some("fetch") => fetch(rest),
        Some("dist") => dist::dist(),
        Some("docs") => docs::build(rest.first()),
        Some("help" | "--help" | "-h") => {
            println!("{HELP}");
            Ok(())
        }
        other => {
            let said = other.map_or_else(|| "no command".to_string(), |c| format!("no command '{c}'"));
            eprintln!("{said}\n\n{HELP}");
            return ExitCode::from(2);
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("cargo xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

/// `cargo xtask fetch NAME [--without-meshes]`.
fn fetch(arguments: &[String]) -> Result<(), String> {
    let meshes = !arguments.iter().any(|a| a == "--without-meshes");
    let names: Vec<&str> = arguments.iter().map(String::as_str).filter(|a| *a != "--without-meshes").collect();
    match names[..] {
        [text_model::NAME] => text_model::ensure(&xtask::third_party()).map(|_| ()),
        [name] => xtask::fetch(name, meshes),
        _ => Err(format!("expected one name, one of: {}, {}", lifelike_fetch::NAMES.join(", "), text_model::NAME)),
    }
}
