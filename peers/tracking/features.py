"""The kinematic state of thesis eq. 4.1, for many states at once; one builder for clips and for simulated states.

Features, F numbers: root height, root orientation (first two columns of its matrix), root velocity (linear, angular),
joint positions, joint velocities, end effectors relative to the root. All but the height in the state's own heading
frame.
"""

from dataclasses import dataclass

import numpy as np

from robot import Robot

HEIGHT, ORIENTATION, VELOCITY = slice(0, 1), slice(1, 7), slice(7, 13)


@dataclass
class Layout:
    """Where the parts lie that depend on the robot."""

    joints: int
    effectors: int

    def __post_init__(self):
        self.positions = slice(13, 13 + self.joints)
        self.velocities = slice(13 + self.joints, 13 + 2 * self.joints)
        self.places = slice(13 + 2 * self.joints, 13 + 2 * self.joints + 3 * self.effectors)
        self.size = self.places.stop


@dataclass
class States:
    """N states: place on the ground `[N, 2]` (m), heading `[N]` (rad) with its cosine and sine, features `[N, F]`."""

    place: np.ndarray
    heading: np.ndarray
    cos: np.ndarray
    sin: np.ndarray
    features: np.ndarray

    @staticmethod
    def of(robot: Robot, layout: Layout, positions: np.ndarray, velocities: np.ndarray) -> "States":
        """From MuJoCo's positions `[N, nq]` and velocities `[N, nv]` (angular velocity in the root's frame)."""
        q, v = positions.astype(np.float32), velocities.astype(np.float32)
        matrices = rotation_matrices(q[:, 3:7])
        heading = heading_of(matrices)
        cos, sin = np.cos(heading), np.sin(heading)
        # Rows of the orientation with the heading taken off.
        upright = np.empty_like(matrices)
        upright[:, 0] = cos[:, None] * matrices[:, 0] + sin[:, None] * matrices[:, 1]
        upright[:, 1] = cos[:, None] * matrices[:, 1] - sin[:, None] * matrices[:, 0]
        upright[:, 2] = matrices[:, 2]
        f = np.empty((len(q), layout.size), np.float32)
        f[:, 0] = q[:, 2]
        f[:, 1:4], f[:, 4:7] = upright[:, :, 0], upright[:, :, 1]
        f[:, 7] = cos * v[:, 0] + sin * v[:, 1]
        f[:, 8] = cos * v[:, 1] - sin * v[:, 0]
        f[:, 9] = v[:, 2]
        f[:, 10:13] = np.matmul(upright, v[:, 3:6, None])[..., 0]
        f[:, layout.positions], f[:, layout.velocities] = q[:, 7:], v[:, 6:]
        places = np.matmul(robot.chains.places(q[:, 7:]), upright.transpose(0, 2, 1))
        f[:, layout.places] = places.reshape(len(q), -1)
        return States(q[:, :2], heading, cos, sin, f)

    def put(self, ids: np.ndarray, others: "States"):
        """Writes others in the place of some."""
        for name in ("place", "heading", "cos", "sin", "features"):
            getattr(self, name)[ids] = getattr(others, name)


def rotation_matrices(q: np.ndarray) -> np.ndarray:
    """Quaternions `[N, 4]` (wxyz, of any length) → `[N, 3, 3]`."""
    w, x, y, z = (q / np.linalg.norm(q, axis=1, keepdims=True)).T
    out = np.empty((len(q), 3, 3), q.dtype)
    out[:, 0, 0], out[:, 0, 1], out[:, 0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
    out[:, 1, 0], out[:, 1, 1], out[:, 1, 2] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
    out[:, 2, 0], out[:, 2, 1], out[:, 2, 2] = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
    return out


def heading_of(matrices: np.ndarray) -> np.ndarray:
    """Where the root's x axis points on the ground (rad); looking straight up or down, its z axis takes the place."""
    x, z = matrices[:, :, 0], matrices[:, :, 2]
    heading = np.arctan2(x[:, 1], x[:, 0])
    steep = x[:, 0] ** 2 + x[:, 1] ** 2 <= 1e-6
    if steep.any():
        sign = np.where(x[:, 2] > 0, -1, 1)
        heading = np.where(steep, np.arctan2(sign * z[:, 1], sign * z[:, 0]), heading)
    return heading


def third_column(f: np.ndarray) -> np.ndarray:
    """Of the orientation, whose features are the other two."""
    a, b = f[:, 1:4], f[:, 4:7]
    return a[:, [1, 2, 0]] * b[:, [2, 0, 1]] - a[:, [2, 0, 1]] * b[:, [1, 2, 0]]


def wrap(angle: np.ndarray) -> np.ndarray:
    """The same angle within ±π."""
    return angle - 2 * np.pi * np.round(angle / (2 * np.pi))
