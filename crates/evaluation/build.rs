//! Lets this package's own programs (tests, benches, examples) find the MuJoCo library where `cargo xtask mujoco` put it.
//! Cargo passes no linker arguments on to the packages above, so each package with programs has this file.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=MUJOCO_DYNAMIC_LINK_DIR");
    if std::env::var_os("CARGO_FEATURE_MUJOCO").is_none() || std::env::var_os("CARGO_CFG_UNIX").is_none() {
        return;
    }
    let folder = std::env::var_os("MUJOCO_DYNAMIC_LINK_DIR").map(std::path::PathBuf::from);
    if let Some(folder) = folder.and_then(|folder| std::path::absolute(folder).ok()) {
        println!("cargo::rustc-link-arg=-Wl,-rpath,{}", folder.display());
    }
}
