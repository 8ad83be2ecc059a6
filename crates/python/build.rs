//! Lets `cargo build` link the extension on macOS, where symbols of Python must be declared as open. maturin does the same.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    pyo3_build_config::add_extension_module_link_args();
}
