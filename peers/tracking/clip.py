"""A motion clip: what is followed. Reads `NAME.motion.safetensors`."""

import json
from pathlib import Path

import numpy as np

from features import Layout, States
from robot import Robot


class Clip:
    """T frames at the policy's rate: states as MuJoCo has them, and features with what belongs to them."""

    def __init__(self, path: Path, robot: Robot, layout: Layout):
        header, arrays = read(path)
        if header["fps"] != robot.control_hz:
            raise SystemExit(f"{path}: expected {robot.control_hz} frames per second, got {header['fps']}")
        missing = set(robot.joints) - set(header["joint_names"])
        if missing:
            raise SystemExit(f"{path}: expected the robot's joints, got none named {', '.join(sorted(missing))}")
        if header.get("cyclic"):
            raise SystemExit(f"{path}: expected a clip that does not repeat")
        self.name = header["name"]
        columns = [header["joint_names"].index(j) for j in robot.joints]
        joints = arrays["joints"][:, columns]
        turns = arrays["root_orientation"] / np.linalg.norm(arrays["root_orientation"], axis=1, keepdims=True)
        fps = header["fps"]
        linear, rates = slopes(arrays["root_position"], fps), slopes(joints, fps)
        self.positions = np.concatenate([arrays["root_position"], turns, joints], 1)
        self.velocities = np.concatenate([linear, angular_velocity(turns, fps), rates], 1)
        self.states = States.of(robot, layout, self.positions, self.velocities)
        self.features = self.states.features
        self.joints = np.ascontiguousarray(self.features[:, layout.positions])
        # As the policy sees it: joints relative to the default pose.
        self.seen = self.features.copy()
        self.seen[:, layout.positions] -= robot.default_pose

    def __len__(self) -> int:
        return len(self.positions)

    @property
    def last(self) -> int:
        return len(self) - 1


def read(path: Path) -> tuple[dict, dict]:
    """Header and arrays of a motion file (safetensors: a length, a table of contents as JSON, the numbers)."""
    data = path.read_bytes()
    end = 8 + int.from_bytes(data[:8], "little")
    table = json.loads(data[8:end])
    header = json.loads(table.pop("__metadata__", {}).get("motion", "{}"))
    if (header.get("format"), header.get("version")) != ("lifelike-motion", 1):
        raise SystemExit(f"{path}: expected a motion file, version 1")
    kinds = {"F64": np.float64, "F32": np.float32, "U8": np.uint8, "BOOL": np.uint8}
    arrays = {}
    for name, entry in table.items():
        a, b = entry["data_offsets"]
        numbers = np.frombuffer(data[end + a : end + b], kinds[entry["dtype"]])
        arrays[name] = numbers.reshape(entry["shape"]).astype(np.float64)
    return header, arrays


def slopes(x: np.ndarray, fps: float) -> np.ndarray:
    """Central differences inside, one-sided ones at the ends."""
    before, after = neighbours(len(x))
    return (x[after] - x[before]) * (fps / (after - before))[:, None]


def angular_velocity(q: np.ndarray, fps: float) -> np.ndarray:
    """In the root's frame (rad/s): the two half turns to the neighbouring frames."""
    before, after = neighbours(len(q))
    turn = turn_vector(relative(q[before], q)) + turn_vector(relative(q, q[after]))
    world = turn * (fps / (after - before))[:, None]
    return rotate_back(q, world)


def neighbours(n: int) -> tuple[np.ndarray, np.ndarray]:
    i = np.arange(n)
    return np.maximum(i - 1, 0), np.minimum(i + 1, n - 1)


def relative(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """b a⁻¹, row by row (wxyz)."""
    w = (a * b).sum(1)
    x = -b[:, :1] * a[:, 1:] + a[:, :1] * b[:, 1:] - np.cross(b[:, 1:], a[:, 1:])
    return np.concatenate([w[:, None], x], 1)


def turn_vector(q: np.ndarray) -> np.ndarray:
    """Axis times angle of the shorter way."""
    q = np.where(q[:, :1] < 0, -q, q)
    size = np.linalg.norm(q[:, 1:], axis=1, keepdims=True)
    angle = 2 * np.arctan2(size, q[:, :1])
    return q[:, 1:] * np.where(size > 1e-12, angle / np.maximum(size, 1e-12), 2.0)


def rotate_back(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """World vectors in the frames of q."""
    t = 2 * np.cross(v, q[:, 1:])
    return v + q[:, :1] * t + np.cross(t, q[:, 1:])
