#![no_main]

use lifelike_dynamixel::PacketReader;
use lifelike_runtime::Measurement;
use lifelike_runtime::record::Record;
use lifelike_runtime::udp::packet::{self, Received};
use lifelike_unitree::{LowCmd, LowState};

// The first byte chooses what a machine or a file says: a packet over UDP, a message of the G1, servos, a record.
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((kind, content)) = bytes.split_first() else { return };
    match kind % 4 {
        0 => {
            let _ = packet::read_facts(content);
            packet::read_state(content, &mut Measurement::new(2));
            packet::read_command(content, &mut Received::new(2));
        }
        1 => drop((LowState::read(content), LowCmd::read(content))),
        2 => {
            let mut reader = PacketReader::default();
            reader.push(content);
            while reader.next_packet().is_some() {}
        }
        _ => {
            let path = std::env::temp_dir().join(format!("fuzz-{}.mcap", std::process::id()));
            if std::fs::write(&path, content).is_ok() {
                let _ = Record::read(&path);
            }
        }
    }
});
