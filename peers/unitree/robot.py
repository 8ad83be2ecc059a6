"""Plays a G1 over DDS by Unitree's published Python package, for the test of crates/dds.

    pip install cyclonedds==11.0.1 unitree_dds_wrapper==2.0.9 numpy pygame
    python peers/unitree/robot.py --seconds 5

It stands upright on a gantry. Enabled motors move to their targets by at most 10 rad/s, in 500 states a second. At
the end it prints, as one line of JSON, what it was told. Checksums of both messages are computed by the package.
"""

import argparse
import json
import os
import struct
import sys
import time

from cyclonedds.internal import InvalidSample
from unitree_dds_wrapper.robots.g1 import g1_pub, g1_sub
from unitree_dds_wrapper.utils.crc import crc32

STATE = "<2I2B2xI" + "13fh2x" + "B3x4f2hf7I" * 35 + "40B5I"
COMMAND = "<2B2x" + "B3x5fI" * 35 + "5I"


def checksum(layout, raw):
    packed = struct.pack(layout, *raw, 0)
    return crc32([word for (word,) in struct.iter_unpack("<I", packed)][:-1])


def checksum_of_state(message):
    imu = message.imu_state
    raw = [*message.version, message.mode_pr, message.mode_machine, message.tick]
    raw += [*imu.quaternion, *imu.gyroscope, *imu.accelerometer, *imu.rpy, imu.temperature]
    for m in message.motor_state:
        raw += [m.mode, m.q, m.dq, m.ddq, m.tau_est, *m.temperature, m.vol, *m.sensor, m.motorstate, *m.reserve]
    return checksum(STATE, [*raw, *message.wireless_remote, *message.reserve])


def checksum_of_command(message):
    raw = [message.mode_pr, message.mode_machine]
    for m in message.motor_cmd:
        raw += [m.mode, m.q, m.dq, m.tau, m.kp, m.kd, m.reserve]
    return checksum(COMMAND, [*raw, *message.reserve])


options = argparse.ArgumentParser()
options.add_argument("--seconds", type=float, default=5.0)
options.add_argument("--mode-machine", type=int, default=5)
options.add_argument("--stop-after", type=float, help="press L2 and B so long after the first command (s)")
options.add_argument("--rival", action="store_true", help="another program sends rt/lowcmd")
options = options.parse_args()

publisher, subscriber = g1_pub.LowState(), g1_sub.LowCmd(autospin=False)
rival = g1_pub.LowCmd() if options.rival else None
state = publisher.msg
state.mode_machine = options.mode_machine
state.imu_state.quaternion = [1.0, 0.0, 0.0, 0.0]
state.imu_state.accelerometer = [0.0, 0.0, 9.81]
told = {"commands": 0, "damaged": 0, "other_mode_machine": 0, "enabled": 0, "braking": 0, "last_enabled": None}
gap, newest, first = 0.0, None, None
begin = time.monotonic()
count = 0
while time.monotonic() - begin < options.seconds:
    for message in subscriber._reader.take(N=100):
        if isinstance(message, InvalidSample):
            continue  # the other end has gone
        now = time.monotonic()
        if newest is not None:
            gap = max(gap, now - newest)
        newest, first = now, first or now
        told["commands"] += 1
        if checksum_of_command(message) != message.crc:
            told["damaged"] += 1
        told["other_mode_machine"] += message.mode_machine != options.mode_machine
        enabled = [m for m in message.motor_cmd if m.mode == 1]
        told["last_enabled"] = len(enabled)
        told["enabled"] = max(told["enabled"], len(enabled))
        told["braking"] += bool(enabled) and all(m.kp == 0.0 and m.kd > 0.0 for m in enabled)
        subscriber.msg = message
    if rival is not None:
        rival.write()
    # A robot's clock goes on where the computer does not come along.
    due = int(500 * (time.monotonic() - begin))
    if due > count:
        count = due
        state.tick = 2 * count
        for i, motor in enumerate(state.motor_state):
            target = subscriber.msg.motor_cmd[i] if subscriber.msg is not None else None
            step = 0.1 * (target.q - motor.q) if target is not None and target.mode == 1 and target.kp > 0 else 0.0
            step = min(max(step, -0.02), 0.02)
            motor.q, motor.dq, motor.vol, motor.temperature = motor.q + step, step * 500, 52.0, [35, 36]
        if options.stop_after is not None and first is not None and time.monotonic() - first > options.stop_after:
            state.wireless_remote = [0, 0, 0b10_0000, 0b10] + [0] * 36
        state.crc = checksum_of_state(state)
        publisher.write()
    time.sleep(0.0005)
told["longest_gap_ms"] = round(1e3 * gap, 1)
told["states"] = count
told["pose"] = [round(m.q, 3) for m in state.motor_state[:29]]
print(json.dumps(told), flush=True)
sys.stdout.close()
os._exit(0)
