"""Writes messages of Unitree's published Python package as bytes, for the tests of crates/unitree.

    pip install --no-deps cyclonedds==11.0.1 unitree_dds_wrapper==2.0.9 rich-click
    python peers/unitree/fixtures.py crates/unitree/tests/data

Each file is a message as Cyclone DDS sends it (XCDR1, little-endian, with its header). The numbers are those of `fill`
in crates/unitree/tests/oracle.rs. Checksums are the package's own.
"""

import pathlib
import struct
import sys

from unitree_dds_wrapper.idl import unitree_hg
from unitree_dds_wrapper.utils.crc import crc32

hg = unitree_hg.msg.dds_


def numbers():
    """Endless numbers that f32 holds exactly."""
    i = 0
    while True:
        i += 1
        yield (i * 37 % 1009) / 8 - 60


def checksum(packed):
    return crc32([word for (word,) in struct.iter_unpack("<I", packed)][:-1])


def command():
    x = numbers()
    message = hg.LowCmd_(mode_pr=1, mode_machine=5)
    for i, motor in enumerate(message.motor_cmd):
        motor.mode = i % 2
        motor.q, motor.dq, motor.tau, motor.kp, motor.kd = (next(x) for _ in range(5))
        motor.reserve = i * 1_000_003
    message.reserve = [1, 2, 3, 4_000_000_000]
    raw = [message.mode_pr, message.mode_machine]
    for m in message.motor_cmd:
        raw += [m.mode, m.q, m.dq, m.tau, m.kp, m.kd, m.reserve]
    message.crc = checksum(struct.pack("<2B2x" + "B3x5fI" * 35 + "5I", *raw, *message.reserve, 0))
    return message


def state():
    x = numbers()
    message = hg.LowState_(version=[7, 8], mode_pr=0, mode_machine=5, tick=123_456_789)
    imu = message.imu_state
    imu.quaternion = [next(x) for _ in range(4)]
    imu.gyroscope, imu.accelerometer, imu.rpy = ([next(x) for _ in range(3)] for _ in range(3))
    imu.temperature = -7
    for i, motor in enumerate(message.motor_state):
        motor.mode = i % 2
        motor.q, motor.dq, motor.ddq, motor.tau_est = (next(x) for _ in range(4))
        motor.temperature = [i - 5, 40 + i]
        motor.vol = next(x)
        motor.sensor = [i, i + 1]
        motor.motorstate = i * 3
        motor.reserve = [i, 0, 0, 4_000_000_000]
    message.wireless_remote = list(range(40))
    message.reserve = [9, 8, 7, 6]
    raw = [*message.version, message.mode_pr, message.mode_machine, message.tick]
    raw += [*imu.quaternion, *imu.gyroscope, *imu.accelerometer, *imu.rpy, imu.temperature]
    for m in message.motor_state:
        raw += [m.mode, m.q, m.dq, m.ddq, m.tau_est, *m.temperature, m.vol, *m.sensor, m.motorstate, *m.reserve]
    layout = "<2I2B2xI" + "13fh2x" + "B3x4f2hf7I" * 35 + "40B5I"
    message.crc = checksum(struct.pack(layout, *raw, *message.wireless_remote, *message.reserve, 0))
    return message


folder = pathlib.Path(sys.argv[1])
for name, message in [("low_cmd", command()), ("low_state", state())]:
    data = message.serialize(use_version_2=False)
    (folder / f"{name}.cdr").write_bytes(data)
    print(name, len(data), "bytes, header", data[:4].hex(), "crc", hex(message.crc))
