"""The tracking environments as an environment of rsl_rl 5.

    from rsl_rl.runners import OnPolicyRunner
    environment = TrackingVecEnv(environments=1024)
    runner = OnPolicyRunner(environment, config, device="cpu")

Set `obs_groups` of the configuration to `{"actor": ["policy"], "critic": ["critic"]}`.
"""

from __future__ import annotations

from typing import Any

import torch
from rsl_rl.env import VecEnv
from tensordict import TensorDict

from lifelike import TrackingEnvironment

__all__ = ["TrackingVecEnv"]


class TrackingVecEnv(VecEnv):
    """Many robots that follow references, on the CPU.

    Args:
        arguments: The arguments of `lifelike.TrackingEnvironment`, such as `environments`, `plan` and `robot`.

    Observations are copies: `policy [N, O]` and `critic [N, P]`, float32. `extras["time_outs"]` marks truncated episodes.
    """

    def __init__(self, **arguments: Any) -> None:
        self.environment = TrackingEnvironment(**arguments)
        self.cfg = {name: str(value) for name, value in arguments.items()}
        self.device = "cpu"
        self.num_envs = len(self.environment)
        self.num_actions = self.environment.action_size
        self.max_episode_length = self.environment.max_episode_steps
        self.episode_length_buf = torch.zeros(self.num_envs, dtype=torch.long)

    def get_observations(self) -> TensorDict:
        """Return the present observations."""
        rows = {"policy": self.environment.observations, "critic": self.environment.critic_observations}
        return TensorDict({name: torch.from_numpy(row.copy()) for name, row in rows.items()}, [self.num_envs])

    def step(self, actions: torch.Tensor) -> tuple[TensorDict, torch.Tensor, torch.Tensor, dict[str, Any]]:
        """Make one step with actions `[N, J]`. Episodes that end begin anew within it."""
        rewards, terminated, truncated = map(torch.from_numpy, self.environment.step(actions.detach().cpu().numpy()))
        dones = terminated | truncated
        # The environments count their steps themselves; this is for the runner's log.
        self.episode_length_buf = torch.where(dones, 0, self.episode_length_buf + 1)
        return self.get_observations(), rewards, dones, {"time_outs": truncated}
