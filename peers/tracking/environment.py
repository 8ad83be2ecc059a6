"""Many episodes in which a policy follows a clip: observations, rewards, ends.

Time: the policy sees the state at t and frame t+1, acts, the simulation goes one step, and the reward compares the
state at t+1 with frame t+1. All copies at once, in float32; only MuJoCo calculates in float64.
"""

import time
from collections import deque
from dataclasses import dataclass, field

import numpy as np

from clip import Clip
from features import HEIGHT, ORIENTATION, VELOCITY, Layout, States, third_column, wrap
from robot import Robot
from starts import Starts

OUTPUT_LIMIT = 4.0
ACTION_SCALE = 0.5
# How far off its path, and how far turned from it, a policy is ever shown to be (m, rad).
REACH, TURN = 0.3, 0.5
# What ends an episode: root height (m), tilt (rad), an end effector (m).
MAX_HEIGHT, MAX_TILT, MAX_EFFECTOR = 0.12, 0.7, 0.25


@dataclass
class Noise:
    """Of the state in which an episode begins, one standard deviation."""

    joints: float = 0.03
    velocity: float = 0.09
    path: float = 0.03
    heading: float = 0.05


@dataclass
class Outcome:
    """What a step gave, `[N]`; and what the value function would see in the episodes that were cut."""

    rewards: np.ndarray
    terminated: np.ndarray
    truncated: np.ndarray
    final_critic_rows: np.ndarray


@dataclass
class Tally:
    """How episodes end while training."""

    survival: float = float("nan")
    lengths: deque = field(default_factory=lambda: deque(maxlen=100))

    def end(self, survived: bool, length: int):
        self.lengths.append(length)
        before = float(survived) if np.isnan(self.survival) else self.survival
        self.survival = before + 0.05 * (survived - before)


class Environment:
    """N copies of the robot, each in an episode of its own."""

    def __init__(
        self,
        robot: Robot,
        clip: Clip,
        physics,
        copies: int,
        rng: np.random.Generator,
        *,
        failure_share: float = 0.5,
        noise: Noise | None = None,
        seconds: float = 10.0,
        judged: bool = True,
    ):
        """`judged`: deviations end episodes, and the clip's world is drawn after a robot that leaves it."""
        self.robot, self.clip, self.physics, self.rng = robot, clip, physics, rng
        self.layout = Layout(len(robot.joints), len(robot.effectors))
        self.noise, self.judged = noise or Noise(), judged
        self.longest = round(seconds * robot.control_hz)
        self.starts = Starts(len(clip), round(0.5 * robot.control_hz), failure_share)
        self.tally = Tally()
        n, joints = copies, len(robot.joints)
        self.copies = n
        self.frame, self.begin, self.length = (np.zeros(n, int) for _ in range(3))
        # The clip's world in the simulated one: turned by `yaw` about `origin`, which lies at `place`.
        self.yaw = np.zeros(n, np.float32)
        self.origin, self.place = np.zeros((n, 2), np.float32), np.zeros((n, 2), np.float32)
        self.last, self.before, self.oldest = (np.zeros((n, joints), np.float32) for _ in range(3))
        self.physics_seconds = 0.0
        self.states = self.read()
        ids = np.arange(n)
        self.reset(ids, self.starts.draw(n, rng))
        self.actor_rows, self.critic_rows = self.observe(ids)

    # One step ---------------------------------------------------------------------------------------------------------

    def step(self, outputs: np.ndarray) -> Outcome:
        """One step of all copies with the policy's outputs `[N, J]`. Those whose episode ends begin another."""
        targets = self.aim(outputs)
        began = time.perf_counter()
        lost = self.physics.step(targets)
        self.physics_seconds += time.perf_counter() - began
        self.frame = np.minimum(self.frame + 1, self.clip.last)
        self.length += 1
        self.states = self.read()
        rewards = np.where(lost, np.float32(0), self.reward())
        terminated = lost | self.exceeds() if self.judged else lost
        truncated = ~terminated & ((self.length >= self.longest) | (self.frame >= self.clip.last))
        if self.judged:
            self.pull()
        cut = np.nonzero(truncated)[0]
        final = self.observe(cut)[1] if len(cut) else np.zeros((0, self.critic_rows.shape[1]), np.float32)
        self.end(np.nonzero(terminated | truncated)[0], terminated)
        self.actor_rows, self.critic_rows = self.observe(np.arange(self.copies))
        return Outcome(rewards, terminated, truncated, final)

    def aim(self, outputs: np.ndarray) -> np.ndarray:
        """Joint targets: the reference's next frame, corrected by the policy (rad)."""
        self.oldest, self.before = self.before, self.last
        self.last = np.clip(np.nan_to_num(outputs), -OUTPUT_LIMIT, OUTPUT_LIMIT).astype(np.float32)
        targets = self.clip.joints[self.ahead()] + ACTION_SCALE * self.last
        return np.clip(targets, self.robot.target_low, self.robot.target_high)

    def end(self, ids: np.ndarray, failed: np.ndarray):
        """Notes how episodes ended, and begins others."""
        if len(ids) == 0:
            return
        for i in ids:
            self.starts.record(self.begin[i], self.frame[i], failed[i])
            self.tally.end(not failed[i], self.length[i])
        self.reset(ids, self.starts.draw(len(ids), self.rng))

    def ahead(self) -> np.ndarray:
        return np.minimum(self.frame + 1, self.clip.last)

    def read(self, ids: np.ndarray | slice = slice(None)) -> States:
        return States.of(self.robot, self.layout, self.physics.positions[ids], self.physics.velocities[ids])

    # Beginning --------------------------------------------------------------------------------------------------------

    def reset(self, ids: np.ndarray, frames: np.ndarray):
        """Episodes from states of the clip, at the origin, with noise."""
        n, normal, noise = len(ids), self.rng.standard_normal, self.noise
        q, v = self.clip.positions[frames].copy(), self.clip.velocities[frames].copy()
        q[:, :2] = 0
        # Two millimetres of air: a foot that begins in the ground is thrown out of it.
        q[:, 2] += 0.002
        q[:, 7:] += noise.joints * normal((n, q.shape[1] - 7))
        v[:, :6] += noise.velocity * normal((n, 6))
        self.physics.reset(ids, q, v)
        self.frame[ids], self.begin[ids], self.length[ids] = frames, frames, 0
        self.yaw[ids] = noise.heading * normal(n)
        self.origin[ids] = self.clip.states.place[frames]
        self.place[ids] = noise.path * normal((n, 2))
        # Last actions that fit the pose.
        wanted = (q[:, 7:] - self.clip.joints[np.minimum(frames + 1, self.clip.last)]) / ACTION_SCALE
        for memory in (self.last, self.before, self.oldest):
            memory[ids] = np.clip(wanted, -OUTPUT_LIMIT, OUTPUT_LIMIT)
        self.states.put(ids, self.read(ids))

    # The path ---------------------------------------------------------------------------------------------------------

    def path(self, frames: np.ndarray, ids: np.ndarray | slice = slice(None)) -> tuple[np.ndarray, np.ndarray]:
        """Where the clip's root is in the simulated world (m), and its heading (rad)."""
        cos, sin = np.cos(self.yaw[ids]), np.sin(self.yaw[ids])
        x, y = (self.clip.states.place[frames] - self.origin[ids]).T
        place = self.place[ids] + np.stack([cos * x - sin * y, sin * x + cos * y], 1)
        return place, self.clip.states.heading[frames] + self.yaw[ids]

    def pull(self):
        """Draws the clip's world after robots that left it, no further than that they are within reach of it again."""
        place, heading = self.path(self.frame)
        ahead = wrap(self.states.heading - heading)
        away = self.states.place - place
        distance = np.maximum(np.hypot(away[:, 0], away[:, 1]), REACH)
        self.yaw = wrap(self.yaw + ahead - np.clip(ahead, -TURN, TURN)).astype(np.float32)
        self.origin = self.clip.states.place[self.frame]
        self.place = place + (1 - REACH / distance)[:, None] * away

    # Judgement --------------------------------------------------------------------------------------------------------

    def reward(self) -> np.ndarray:
        """Exponentials of squared errors, less penalties of actions and torques."""
        f, r, at = self.states.features, self.clip.features[self.frame], self.layout
        error = f - r
        place, heading = self.path(self.frame)
        self.effector_square = square(error[:, at.places]).reshape(len(f), -1, 3).sum(2)
        orientation = square(error[:, ORIENTATION]).sum(1) + square(third_column(f) - third_column(r)).sum(1)
        speed = square(error[:, 7:10]).sum(1) + 0.0375 * square(error[:, 10:13]).sum(1)
        kernels = (
            (0.1, 150.0, square(error[:, 0])),
            (0.15, 4.0, orientation),
            (0.2, 4.0, speed),
            (0.35, 40.0, square(error[:, at.positions]).mean(1)),
            (0.1, 0.8, square(error[:, at.velocities]).mean(1)),
            (0.2, 240.0, self.effector_square.mean(1)),
            (0.15, 10.0, square(wrap(self.states.heading - heading))),
            (0.15, 20.0, square(self.states.place - place).sum(1)),
        )
        gain = sum(weight * np.exp(-sharpness * x) for weight, sharpness, x in kernels)
        rate = ACTION_SCALE**2 * square(self.last - self.before).sum(1)
        acceleration = ACTION_SCALE**2 * square(self.last - 2 * self.before + self.oldest).sum(1)
        return (gain - 0.05 * rate - 0.015 * acceleration - 1e-5 * self.physics.torque_squared).astype(np.float32)

    def exceeds(self) -> np.ndarray:
        """Whether an episode has failed. Follows [`Environment.reward`], whose end effectors it looks at."""
        f, r = self.states.features, self.clip.features[self.frame]
        cosine = (f[:, [3, 6]] * r[:, [3, 6]]).sum(1) + third_column(f)[:, 2] * third_column(r)[:, 2]
        tilt = np.arccos(np.clip(cosine, -1, 1))
        return (
            (np.abs(f[:, 0] - r[:, 0]) > MAX_HEIGHT)
            | (tilt > MAX_TILT)
            | (self.effector_square.max(1) > MAX_EFFECTOR**2)
        )

    # Observation ------------------------------------------------------------------------------------------------------

    def observe(self, ids: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What policy and value function see, not normalised: `[ids, O]` and `[ids, P]`."""
        s, at = self.states, self.layout
        f, cos, sin = s.features[ids], s.cos[ids], s.sin[ids]
        next_frame = self.ahead()[ids]
        place, heading = self.path(next_frame, ids)
        away = place - s.place[ids]
        # The way to the reference's root, in the robot's heading frame.
        way = np.stack([cos * away[:, 0] + sin * away[:, 1], cos * away[:, 1] - sin * away[:, 0]], 1)
        share = REACH / np.maximum(np.hypot(way[:, 0], way[:, 1]), REACH)
        turn = wrap(heading - s.heading[ids])
        shown = np.clip(turn, -TURN, TURN)
        actor = [
            f[:, 1:13],
            f[:, at.positions] - self.robot.default_pose,
            f[:, at.velocities],
            self.last[ids],
            self.before[ids],
            self.clip.seen[next_frame],
            column(np.sin(shown)),
            column(np.cos(shown)),
            column(share) * way,
        ]
        error = f - self.clip.features[next_frame]
        extra = [
            f[:, HEIGHT],
            error[:, HEIGHT],
            error[:, VELOCITY],
            error[:, at.places],
            error[:, at.positions],
            -way,
            column(-turn),
            # Steps for which a deviation has lasted: of a rule for ends that is not used here.
            np.zeros((len(ids), 1), np.float32),
            self.physics.foot_loads[ids] / self.robot.weight,
        ]
        rows = np.concatenate(actor + extra, 1, dtype=np.float32)
        width = sum(part.shape[1] for part in actor)
        return np.ascontiguousarray(rows[:, :width]), rows


def column(x: np.ndarray) -> np.ndarray:
    return x[:, None]


def square(x: np.ndarray) -> np.ndarray:
    return x * x
