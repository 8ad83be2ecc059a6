"""Many copies of the robot in MuJoCo, one policy step at a time, in two ways.

`Batched` is the default: MuJoCo's own thread pool (`mujoco.batch`) steps all copies, and numpy evaluates the motors'
law for all of them before each physics step. `RolledOut` hands all physics steps of a policy step to `mujoco.rollout`
at once, which leaves no place for that law: it has the nearest that MuJoCo offers inside its model.
"""

import mujoco
import numpy as np
from mujoco import rollout
from mujoco.batch import Batch

from robot import Robot

# A copy with a velocity beyond this (m/s, rad/s) is lost.
VELOCITY_LIMIT = 1e3


class Batched:
    """Eqs. 4.9 to 4.11 as they are, at every physics step; friction as damping that MuJoCo integrates implicitly."""

    def __init__(self, robot: Robot, copies: int, threads: int):
        self.robot = robot
        self.batch = Batch(robot.model, copies, threads)
        self.positions, self.velocities = self.batch.bind("qpos"), self.batch.bind("qvel")
        self.warm_start, self.applied = self.batch.bind("qacc_warmstart"), self.batch.bind("qfrc_applied")
        self.foot_loads = self.batch.bind("sensordata")
        # Damping is part of MuJoCo's model; here each copy has its own.
        self.damping = self.batch.expand("dof_damping")
        self.model_damping = robot.model.dof_damping[6:].astype(np.float32)
        self.torque_squared = np.zeros(copies, np.float32)
        m = robot.motors
        self.steepness = 1.0 / (m["velocity_max"] - m["full_torque_velocity"])

    def reset(self, ids: np.ndarray, positions: np.ndarray, velocities: np.ndarray):
        self.positions[ids], self.velocities[ids] = positions, velocities
        self.warm_start[ids] = 0.0

    def step(self, targets: np.ndarray) -> np.ndarray:
        """One policy step with joint targets `[N, J]` (rad); which copies diverged, `[N]`: they are where they were."""
        before = self.positions.copy(), self.velocities.copy()
        self.torque_squared[:] = 0.0
        for _ in range(self.robot.substeps):
            self._drive(targets)
            self.batch.step()
        self.torque_squared /= self.robot.substeps
        return restore_lost(self.positions, self.velocities, before)

    def _drive(self, targets: np.ndarray):
        m = self.robot.motors
        q = self.positions[:, 7:].astype(np.float32)
        v = self.velocities[:, 6:].astype(np.float32)
        torque = m["kp"] * (targets - q) - m["kd"] * v
        # Driving ramps down from full_torque_velocity to nothing at velocity_max; braking has the full torque.
        ahead = np.clip((m["velocity_max"] - v) * self.steepness, 0, 1)
        behind = np.clip((m["velocity_max"] + v) * self.steepness, 0, 1)
        torque = np.clip(torque, -m["torque_max"] * behind, m["torque_max"] * ahead)
        # tanh(x) / x, which is one at zero.
        x = np.maximum(np.abs(v) / m["friction_velocity"], 1e-6)
        friction = m["static_friction"] / m["friction_velocity"] * (np.tanh(x) / x) + m["viscous_friction"]
        self.applied[:, 6:] = torque
        self.damping[:, 6:] = self.model_damping + friction
        whole = torque - friction * v
        self.torque_squared += np.einsum("nj,nj->n", whole, whole)


class RolledOut:
    """MuJoCo's position actuators with a constant limit, and its dry friction and damping of joints."""

    def __init__(self, robot: Robot, copies: int, threads: int):
        self.robot = robot
        self.model = in_model(robot)
        self.pool = rollout.Rollout(nthread=threads if threads > 1 else 0)
        self.data = [mujoco.MjData(self.model) for _ in range(threads)]
        width = mujoco.mj_stateSize(self.model, mujoco.mjtState.mjSTATE_FULLPHYSICS)
        self.initial = np.zeros((copies, width))
        nq, nv = self.model.nq, self.model.nv
        # A row is time, positions and velocities.
        self.positions, self.velocities = self.initial[:, 1 : 1 + nq], self.initial[:, 1 + nq : 1 + nq + nv]
        self.positions[:] = self.model.qpos0
        self.controls = np.zeros((copies, robot.substeps, self.model.nu))
        self.states = np.zeros((copies, robot.substeps, width))
        self.sensors = np.zeros((copies, robot.substeps, self.model.nsensordata))
        self.loads = robot.model.nsensordata
        self.foot_loads = np.zeros((copies, self.loads))
        self.torque_squared = np.zeros(copies, np.float32)

    def reset(self, ids: np.ndarray, positions: np.ndarray, velocities: np.ndarray):
        self.positions[ids], self.velocities[ids] = positions, velocities

    def step(self, targets: np.ndarray) -> np.ndarray:
        """As [`Batched.step`]."""
        before = self.positions.copy(), self.velocities.copy()
        self.controls[:] = targets[:, None]
        self.pool.rollout(
            self.model, self.data, self.initial, self.controls, state=self.states, sensordata=self.sensors
        )
        self.initial[:] = self.states[:, -1]
        self.foot_loads[:] = self.sensors[:, -1, : self.loads]
        torques = self.sensors[:, :, self.loads :]
        self.torque_squared[:] = np.einsum("nkj,nkj->n", torques, torques) / self.robot.substeps
        return restore_lost(self.positions, self.velocities, before)


def in_model(robot: Robot) -> mujoco.MjModel:
    """The robot with motors and friction that MuJoCo simulates by itself, and their torques as sensors."""
    spec, m = robot.edited(), robot.motors
    joints = {joint.name: joint for joint in spec.joints}
    for i, name in enumerate(robot.joints):
        motor = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.set_to_position(kp=float(m["kp"][i]), kv=float(m["kd"][i]))
        motor.forcelimited, motor.forcerange = True, [-m["torque_max"][i], m["torque_max"][i]]
        joints[name].frictionloss = m["static_friction"][i]
        joints[name].damping[0] += m["viscous_friction"][i]
        sensor = spec.add_sensor(name=f"{name}_torque", type=mujoco.mjtSensor.mjSENS_ACTUATORFRC)
        sensor.objtype, sensor.objname = mujoco.mjtObj.mjOBJ_ACTUATOR, name
    return spec.compile()


def restore_lost(positions: np.ndarray, velocities: np.ndarray, before: tuple) -> np.ndarray:
    """Puts copies that diverged back to where they were; which they are, `[N]`."""
    sound = np.isfinite(positions).all(1) & (np.abs(velocities) <= VELOCITY_LIMIT).all(1)
    lost = ~sound
    if lost.any():
        positions[lost], velocities[lost] = before[0][lost], before[1][lost]
    return lost
