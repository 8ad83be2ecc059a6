#![no_main]

use lifelike_character::MeshFile;

// The first byte chooses the format.
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((kind, content)) = bytes.split_first() else { return };
    let ending = ["stl", "obj", "dae", "glb"][usize::from(*kind) % 4];
    let path = std::env::temp_dir().join(format!("fuzz-{}.{ending}", std::process::id()));
    if std::fs::write(&path, content).is_ok() {
        let _ = MeshFile { path, scale: [1.0; 3], collides: true }.triangles();
    }
});
