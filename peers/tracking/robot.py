"""The robot: MuJoCo's model of it, and what its profile says of motors, end effectors and default pose."""

import tomllib
from fnmatch import fnmatch
from pathlib import Path

import mujoco
import numpy as np

# Joint targets may lie this far beyond a joint's range (rad).
TARGET_MARGIN = 0.5
MOTOR_KEYS = (
    "kp kd friction_velocity static_friction viscous_friction torque_max full_torque_velocity velocity_max".split()
)


class Robot:
    """A robot from `NAME.xml` (MJCF) and `NAME.toml` (profile) in one folder. J joints, E end effectors."""

    def __init__(self, folder: Path, name: str):
        self.path = folder / f"{name}.xml"
        self.profile = tomllib.loads((folder / f"{name}.toml").read_text())
        self.spec = mujoco.MjSpec.from_file(str(self.path))
        self.substeps = round(self.profile["physics_hz"] / self.profile["control_hz"])
        self.control_hz = self.profile["control_hz"]
        self.model = model = self.edited().compile()
        if model.jnt_type[0] != mujoco.mjtJoint.mjJNT_FREE or (model.jnt_type[1:] != mujoco.mjtJoint.mjJNT_HINGE).any():
            raise SystemExit(f"{self.path}: expected a free joint and hinges after it")
        self.joints = [model.joint(j).name for j in range(1, model.njnt)]
        self.motors = {key: self._per_joint(key) for key in MOTOR_KEYS}
        pose = self.profile.get("default_pose", {})
        self.default_pose = np.array([pose.get(j, 0.0) for j in self.joints], np.float32)
        low, high = model.jnt_range[1:].T
        self.target_low = (low - TARGET_MARGIN).astype(np.float32)
        self.target_high = (high + TARGET_MARGIN).astype(np.float32)
        self.weight = float(mujoco.mj_getTotalmass(model) * np.linalg.norm(model.opt.gravity))
        self.effectors = self.profile["end_effectors"]
        self.chains = Chains(model, [model.site(e).id for e in self.effectors])

    def edited(self) -> mujoco.MjSpec:
        """The model without motors, with the load of each foot as a sensor: a site a little larger than its sole."""
        spec = self.spec.copy()
        for actuator in list(spec.actuators):
            spec.delete(actuator)
        for foot in self.feet():
            body = spec.body(foot)
            for i, geom in enumerate(body.geoms):
                site = body.add_site(name=f"{foot}_load_{i}", type=geom.type, pos=geom.pos, size=geom.size + 0.01)
                sensor = spec.add_sensor(name=f"{foot}_load_{i}", type=mujoco.mjtSensor.mjSENS_TOUCH)
                sensor.objtype, sensor.objname = mujoco.mjtObj.mjOBJ_SITE, site.name
        spec.option.timestep = 1.0 / self.profile["physics_hz"]
        # A simulation that diverges must be seen to diverge.
        spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
        return spec

    def feet(self) -> list[str]:
        return [e for e in self.profile["end_effectors"] if "foot" in e]

    def _per_joint(self, key: str) -> np.ndarray:
        out = []
        for joint in self.joints:
            groups = [
                group["parameters"][key]
                for group in self.profile["actuator"].values()
                if any(fnmatch(joint, pattern) for pattern in group["joints"])
            ]
            if len(groups) != 1:
                raise SystemExit(f"joint '{joint}': expected one group of actuators, got {len(groups)}")
            out.append(groups[0])
        return np.array(out, np.float32)


class Chains:
    """Places of the end effectors in the frame of the root, for many poses at once.

    Cheaper than asking MuJoCo, which would need another pass of its whole position stage: each place is a point that is
    turned by its joints from the tip inwards, all places of all poses together.
    """

    def __init__(self, model: mujoco.MjModel, sites: list[int]):
        chains = [self._chain(model, site) for site in sites]
        self.length = max(len(chain) for chain in chains)
        self.tips = np.array([model.site_pos[s] for s in sites], np.float32)
        joints = model.njnt - 1
        # Shorter chains go on with a joint that is always at zero: column J.
        self.columns = np.full((self.length, len(sites)), joints)
        self.cross = np.zeros((self.length, len(sites), 3, 3), np.float32)
        self.offsets = np.zeros((self.length, len(sites), 3), np.float32)
        for e, chain in enumerate(chains):
            for k, (column, axis, offset) in enumerate(chain):
                x, y, z = axis
                self.columns[k, e] = column
                self.cross[k, e] = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
                self.offsets[k, e] = offset

    @staticmethod
    def _chain(model: mujoco.MjModel, site: int) -> list:
        chain, body = [], model.site_bodyid[site]
        root = model.jnt_bodyid[0]
        while body != root:
            joint = model.body_jntadr[body]
            plain = model.body_jntnum[body] == 1 and model.body_quat[body][0] == 1 and not model.jnt_pos[joint].any()
            if not plain:
                raise SystemExit(f"body '{model.body(body).name}': expected one hinge at its origin and no turn")
            chain.append((joint - 1, model.jnt_axis[joint], model.body_pos[body]))
            body = model.body_parentid[body]
        return chain

    def places(self, joints: np.ndarray) -> np.ndarray:
        """`[N, J]` (rad) → `[N, E, 3]` (m, root's frame)."""
        padded = np.concatenate([joints, np.zeros((len(joints), 1), joints.dtype)], 1)[:, self.columns]
        sin, rest = np.sin(padded)[..., None], (1 - np.cos(padded))[..., None]
        p = np.broadcast_to(self.tips, (len(joints), *self.tips.shape))
        for k in range(self.length):
            across = turn(self.cross[k], p)
            p = p + sin[:, k] * across + rest[:, k] * turn(self.cross[k], across) + self.offsets[k]
        return p


def turn(matrices: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Matrices `[E, 3, 3]` times points `[N, E, 3]`."""
    return np.matmul(matrices, points.transpose(1, 2, 0)).transpose(2, 0, 1)
