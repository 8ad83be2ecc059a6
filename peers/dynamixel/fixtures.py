"""Writes packets of ROBOTIS' published Python package as bytes, for the tests of crates/dynamixel.

    pip install dynamixel-sdk==4.1.0
    python peers/dynamixel/fixtures.py crates/dynamixel/tests/data

Stuffing and checksum are the package's own. They are called one after the other here, because the package's txPacket
drops the packet that addStuffing returns.
"""

import pathlib
import sys

from dynamixel_sdk.protocol2_packet_handler import Protocol2PacketHandler

handler = Protocol2PacketHandler()


def packet(ident, instruction, parameters):
    length = len(parameters) + 3
    raw = [0xFF, 0xFF, 0xFD, 0, ident, length & 0xFF, length >> 8, instruction, *parameters, 0, 0]
    stuffed = handler.addStuffing(raw)
    crc = handler.updateCRC(0, stuffed, len(stuffed) - 2)
    return bytes([*stuffed[:-2], crc & 0xFF, crc >> 8])


def word(x, size):
    return list(x.to_bytes(size, "little", signed=True))


targets = [(i + 1, 2048 + 100 * i) for i in range(20)]
packets = {
    "ping": packet(1, 0x01, []),
    # Present current, velocity, position of three servos.
    "sync_read": packet(0xFE, 0x82, [*word(126, 2), *word(10, 2), 3, 7, 20]),
    # Goal positions of twenty.
    "sync_write": packet(0xFE, 0x83, [*word(116, 2), *word(4, 2)] + [b for i, x in targets for b in [i, *word(x, 4)]]),
    # Goal position -131073 has the bytes of a header: FF FF FD FF.
    "stuffed": packet(0xFE, 0x83, [*word(116, 2), *word(4, 2), 1, *word(-131073, 4), 2, *word(-131073, 4)]),
}
folder = pathlib.Path(sys.argv[1])
for name, data in packets.items():
    (folder / f"{name}.bin").write_bytes(data)
    print(name, data.hex(" "))
