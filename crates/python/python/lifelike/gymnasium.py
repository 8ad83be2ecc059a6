"""The tracking environments as a `gymnasium.vector.VectorEnv`.

    import gymnasium, lifelike.gymnasium
    envs = gymnasium.make_vec("lifelike/Tracking-v0", num_envs=256)

Episodes begin anew within the step that ends them (`AutoresetMode.SAME_STEP`).
"""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from lifelike import TrackingEnvironment

__all__ = ["TrackingVectorEnv"]


class TrackingVectorEnv(VectorEnv[np.ndarray, np.ndarray, np.ndarray]):
    """Many robots that follow references, stepped together.

    Args:
        num_envs: Number of environments N.
        copy: Return copies of observations. Without, they are read-only views that the next step overwrites.
        seed: Seed until `reset` gets another.
        arguments: The other arguments of `lifelike.TrackingEnvironment`: `plan`, `robot`, `clips`, `threads`, `changes`.

    Observations are `[N, O]` float32, not normalised; actions `[N, J]` float32. `info` of a step has `final_obs` and
    `_final_obs` as gymnasium defines them, for truncated episodes. Terminated ones have none: nothing follows them.
    """

    metadata = {"autoreset_mode": AutoresetMode.SAME_STEP, "render_modes": []}

    def __init__(self, num_envs: int = 64, *, copy: bool = True, seed: int = 0, **arguments: Any) -> None:
        self._copy = copy
        self.num_envs = num_envs
        self.environment = TrackingEnvironment(environments=num_envs, seed=seed, **arguments)
        limit = self.environment.action_limit
        observation, action = self.environment.observation_size, self.environment.action_size
        self.single_observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (observation,), np.float32)
        self.single_action_space = gymnasium.spaces.Box(-limit, limit, (action,), np.float32)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin new episodes everywhere; with a seed, as new environments of that seed do."""
        if seed is not None:
            super().reset(seed=seed)
            self.environment = self.environment.with_seed(seed)
        else:
            self.environment.reset()
        return self._observations(), {}

    def step(
        self, actions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Make one step with actions `[N, J]`."""
        rewards, terminated, truncated = self.environment.step(actions)
        info: dict[str, Any] = {}
        if truncated.any():
            rows = self.environment.final_critic_observations()[:, : self.environment.observation_size]
            final = np.full(self.num_envs, None, dtype=object)
            for index, row in zip(np.flatnonzero(truncated), rows, strict=True):
                final[index] = row
            info = {"final_obs": final, "_final_obs": truncated.copy()}
        return self._observations(), rewards, terminated, truncated, info

    def _observations(self) -> np.ndarray:
        observations = self.environment.observations
        return observations.copy() if self._copy else observations


gymnasium.register("lifelike/Tracking-v0", vector_entry_point="lifelike.gymnasium:TrackingVectorEnv")
