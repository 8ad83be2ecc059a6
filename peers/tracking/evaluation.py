"""How well the policy follows: deterministic episodes from starts spread over the clip."""

import numpy as np

from environment import Environment, Noise
from features import third_column
from learner import Learner

# Below this share of the reference's height, or with its up direction off by more than this (rad), a robot has fallen.
HEIGHT_SHARE, TILT = 0.6, 1.0


def evaluate(learner: Learner, physics, starts: int, seconds: float) -> dict:
    """Survival of episodes, and the joints' mean absolute error (deg) over the frames before a fall."""
    trained = learner.environment
    environment = Environment(
        trained.robot,
        trained.clip,
        physics,
        starts,
        np.random.default_rng(0),
        noise=Noise(0.0, 0.0, 0.0, 0.0),
        seconds=1e9,
        judged=False,
    )
    length, last = round(seconds * trained.robot.control_hz), trained.clip.last
    latest = max(last - length, last // 2)
    ids = np.arange(starts)
    environment.reset(ids, ids * latest // max(starts - 1, 1))
    environment.actor_rows, environment.critic_rows = environment.observe(ids)
    running, fell = np.ones(starts, bool), np.zeros(starts, bool)
    errors, frames = np.zeros(starts), np.zeros(starts)
    for _ in range(length):
        outcome = environment.step(learner.act(learner.actor_normalizer(environment.actor_rows)))
        fell |= running & outcome.terminated
        # A copy at the end of the clip has already begun another episode.
        running &= ~(outcome.terminated | outcome.truncated)
        now_fallen = fallen(environment)
        fell |= running & now_fallen
        running &= ~now_fallen
        off = np.abs(joints_off(environment)).mean(1)
        errors += np.where(running, off, 0)
        frames += running
        if not running.any():
            break
    return {
        "episodes": starts,
        "survival": float(1 - fell.mean()),
        "seconds": float(frames.mean() / trained.robot.control_hz),
        "joint_error_deg": float(np.degrees(errors.sum() / max(frames.sum(), 1))),
    }


def joints_off(environment: Environment) -> np.ndarray:
    columns = environment.layout.positions
    return environment.states.features[:, columns] - environment.clip.features[environment.frame][:, columns]


def fallen(environment: Environment) -> np.ndarray:
    f, r = environment.states.features, environment.clip.features[environment.frame]
    cosine = (f[:, [3, 6]] * r[:, [3, 6]]).sum(1) + third_column(f)[:, 2] * third_column(r)[:, 2]
    return (f[:, 0] < HEIGHT_SHARE * r[:, 0]) | (cosine < np.cos(TILT))
