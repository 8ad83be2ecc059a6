#![no_main]

use lifelike_augmentation::logs::table::{self, TableMap};
use lifelike_augmentation::logs::BenchLog;

const MAP: &str = "time = \"stamp\"\nrate = 100.0\n[block.knee]\nclass = \"a\"\n\
    reference.position = { column = \"/goals/knee.position\" }\nmeasured.position = { column = \"knee.position\" }\n";

// The first byte chooses the format: a bag of ROS 2, a table of a robot, a bench's table, a bench's JSON.
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((kind, content)) = bytes.split_first() else { return };
    let ending = ["mcap", "csv", "csv", "json"][usize::from(*kind) % 4];
    let path = std::env::temp_dir().join(format!("fuzz-{}.{ending}", std::process::id()));
    let Ok(map) = toml::from_str::<TableMap>(MAP) else { return };
    if std::fs::write(&path, content).is_err() {
        return;
    }
    match kind % 4 {
        0 | 1 => drop(table::read(&path, &map)),
        _ => drop(BenchLog::read(&path)),
    }
});
