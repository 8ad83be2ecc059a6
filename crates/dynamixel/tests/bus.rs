//! Packets against the published package, and a chain of simulated servos on a bad line.
#![allow(clippy::unwrap_used)]

use lifelike_dynamixel::{BROADCAST, Instruction, Packet, PacketReader, sync_read, sync_write, write_packet};

const GOAL: u16 = 116;
const PRESENT: u16 = 132;

fn written(write: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let mut out = vec![1, 2, 3];
    write(&mut out);
    out
}

#[test]
fn packets_are_those_of_the_package_byte_for_byte() {
    let ping = written(|out| write_packet(1, Instruction::Ping, [], out));
    assert_eq!(ping, include_bytes!("data/ping.bin"));
    assert_eq!(written(|out| sync_read(126, 10, &[3, 7, 20], out)), include_bytes!("data/sync_read.bin"));
    let goals = (0..20).map(|i: i32| (i as u8 + 1, (2048 + 100 * i).to_le_bytes()));
    assert_eq!(written(|out| sync_write(GOAL, goals, out)), include_bytes!("data/sync_write.bin"));
    let stuffed = written(|out| sync_write(GOAL, [1, 2].map(|id| (id, (-131_073i32).to_le_bytes())), out));
    assert_eq!(stuffed, include_bytes!("data/stuffed.bin"));
    let mut reader = PacketReader::default();
    reader.push(&stuffed);
    let packet = reader.next_packet().unwrap();
    assert_eq!(packet.parameters[5..9], (-131_073i32).to_le_bytes(), "read back without the stuffing");
}

/// A servo that is where it was told to be.
struct Servo {
    id: u8,
    goal: i32,
}

/// Servos on one line: they read what is sent, and answer one after the other.
struct Chain {
    servos: Vec<Servo>,
    reader: PacketReader,
}

impl Chain {
    fn hear(&mut self, bytes: &[u8]) -> Vec<u8> {
        self.reader.push(bytes);
        let (mut line, mut answer) = (Vec::new(), Vec::new());
        while let Some(Packet { id, instruction, parameters }) = self.reader.next_packet() {
            assert_eq!(id, BROADCAST);
            let address = u16::from_le_bytes([parameters[0], parameters[1]]);
            if instruction == Instruction::SyncWrite as u8 && address == GOAL {
                for item in parameters[4..].chunks_exact(5) {
                    let goal = i32::from_le_bytes(item[1..].try_into().unwrap());
                    let servo = self.servos.iter_mut().find(|servo| servo.id == item[0]);
                    servo.unwrap().goal = goal;
                }
            }
            if instruction == Instruction::SyncRead as u8 && address == PRESENT {
                for id in &parameters[4..] {
                    let servo = self.servos.iter().find(|servo| servo.id == *id).unwrap();
                    let content = std::iter::once(0).chain(servo.goal.to_le_bytes());
                    write_packet(*id, Instruction::Status, content, &mut answer);
                    line.extend_from_slice(&answer);
                }
            }
        }
        line
    }
}

fn number(seed: &mut u32) -> u32 {
    *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    *seed >> 8
}

#[test]
fn goals_come_back_as_positions_over_a_line_that_loses_and_adds_bytes() {
    let servos = (1..=20).map(|id| Servo { id, goal: 0 }).collect();
    let mut chain = Chain { servos, reader: PacketReader::default() };
    let (mut reader, mut out, mut seed) = (PacketReader::default(), Vec::new(), 7);
    let ids: Vec<u8> = (1..=20).collect();
    let (mut answers, mut damaged) = (0, 0);
    for round in 0..500 {
        // Numbers with the bytes of headers among them.
        let goals: Vec<(u8, i32)> = ids.iter().map(|id| (*id, -131_073 + number(&mut seed) as i32 % 4)).collect();
        sync_write(GOAL, goals.iter().map(|(id, goal)| (*id, goal.to_le_bytes())), &mut out);
        assert!(chain.hear(&out).is_empty());
        sync_read(PRESENT, 4, &ids, &mut out);
        let mut line = chain.hear(&out);
        if round % 5 == 4 {
            let at = number(&mut seed) as usize % line.len();
            match number(&mut seed) % 3 {
                0 => drop(line.remove(at)),
                1 => line.insert(at, 0xFF),
                _ => line[at] ^= 0x40,
            }
            damaged += 1;
        }
        // In pieces, as a port gives them.
        for piece in line.chunks(1 + number(&mut seed) as usize % 40) {
            reader.push(piece);
            while let Some(packet) = reader.next_packet() {
                let goal = goals.iter().find(|(id, _)| *id == packet.id).unwrap().1;
                assert_eq!(packet.parameters[1..], goal.to_le_bytes(), "a packet that is read is right");
                answers += 1;
            }
        }
        // A request of the next round waits for no lost answer.
        if round % 5 == 4 {
            reader = PacketReader::default();
        }
    }
    // A damaged byte costs the answer that it is in. A length that is 64 too large waits for five more of 15 bytes.
    assert!(answers >= 500 * 20 - 6 * damaged && answers < 500 * 20, "{answers}");
    assert_eq!(reader.defects(), Default::default());
}
