"""Proximal policy optimisation (Schulman et al. 2017) in PyTorch: Gaussian policy, value function, ELU perceptrons."""

import math
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import torch
from torch import nn

from environment import Environment

# Rows on which the KL divergence is measured after each epoch.
DIVERGENCE_ROWS = 2048
# An iteration's epochs end early when the divergence exceeds the target this many times.
STOP = 4.0


@dataclass
class Settings:
    """As `[ppo]` and `[network]` of a training plan."""

    steps: int
    epochs: int
    minibatch: int
    hidden: list[int]
    gamma: float
    lam: float
    clip: float
    target_divergence: float
    rate: float
    rate_bounds: tuple[float, float]
    critic_rate: float
    gradient_norm: float
    initial_std: float
    std_bounds: tuple[float, float]
    threads: int


class Normalizer:
    """Mean and variance of everything seen (Chan et al. 1979), in float64; clips to ±5."""

    def __init__(self, size: int):
        self.mean, self.variance, self.count = np.zeros(size), np.ones(size), 0.0

    def update(self, rows: np.ndarray):
        rows = rows.reshape(-1, rows.shape[-1])
        n, mean = len(rows), rows.mean(0, dtype=np.float64)
        total, delta = self.count + n, mean - self.mean
        # The mean is taken off first: float32 is exact enough for what is left.
        variance = np.square(rows - mean.astype(np.float32)).mean(0, dtype=np.float64)
        self.variance = (self.variance * self.count + variance * n + delta**2 * self.count * n / total) / total
        self.mean = self.mean + delta * n / total
        self.count = total

    def __call__(self, rows: np.ndarray) -> np.ndarray:
        # What never changes is only centred.
        scale = np.where(self.variance > 1e-8, 1 / np.sqrt(np.maximum(self.variance, 1e-8)), 1.0).astype(np.float32)
        out = (rows - self.mean.astype(np.float32)) * scale
        return np.clip(out, -5, 5, out=out)


class Actor(nn.Module):
    """Mean from a network, spread a parameter of its own."""

    def __init__(self, inputs: int, hidden: list[int], outputs: int, std: float):
        super().__init__()
        self.mean = perceptron(inputs, hidden, outputs)
        self.log_std = nn.Parameter(torch.full((outputs,), math.log(std)))


def perceptron(inputs: int, hidden: list[int], outputs: int) -> nn.Sequential:
    """Orthogonal weights; the last layer near zero, for first actions and first values near zero."""
    sizes, layers = [inputs, *hidden, outputs], []
    for i in range(len(sizes) - 1):
        last = i == len(sizes) - 2
        layer = nn.Linear(sizes[i], sizes[i + 1])
        nn.init.orthogonal_(layer.weight, 0.01 if last else math.sqrt(2))
        nn.init.zeros_(layer.bias)
        layers += [layer] if last else [layer, nn.ELU(inplace=True)]
    return nn.Sequential(*layers)


@dataclass
class Rollout:
    """`[steps, N, ...]`, observations normalised. The critic's rows have one step more."""

    actor_rows: np.ndarray
    critic_rows: np.ndarray
    actions: np.ndarray
    means: np.ndarray
    log_probabilities: np.ndarray
    rewards: np.ndarray
    terminated: np.ndarray
    truncated: np.ndarray
    final_rows: list
    final_steps: list


class Learner:
    def __init__(self, settings: Settings, environment: Environment, joints: int):
        self.settings, self.environment = settings, environment
        o, p = environment.actor_rows.shape[1], environment.critic_rows.shape[1]
        self.actor = Actor(o, settings.hidden, joints, settings.initial_std)
        self.critic = perceptron(p, settings.hidden, 1)
        self.actor_adam = torch.optim.Adam(self.actor.parameters(), settings.rate, fused=True)
        self.critic_adam = torch.optim.Adam(self.critic.parameters(), settings.critic_rate, fused=True)
        self.rate = settings.rate
        self.actor_normalizer, self.critic_normalizer = Normalizer(o), Normalizer(p)
        self.actor_normalizer.update(environment.actor_rows)
        self.critic_normalizer.update(environment.critic_rows)
        # Values count in units of what a reward of one per step is worth for ever.
        self.value_scale = 1 / max(1 - settings.gamma, 1e-3)
        # Policy and value function share nothing, so with two threads or more they learn at the same time.
        self.pool = ThreadPoolExecutor(1) if settings.threads > 1 else None
        self.seconds = {"policy": 0.0, "environment": 0.0, "learning": 0.0}

    def iterate(self):
        """Collect, value, estimate advantages, learn."""
        # A policy step is too little work to share: threads would cost more than they bring.
        torch.set_num_threads(1)
        rollout = self.collect()
        began = time.perf_counter()
        torch.set_num_threads(self.settings.threads)
        values, next_values = self.value(rollout)
        gains = self.advantages(rollout, values, next_values)
        targets = torch.from_numpy(((gains + values) / self.value_scale).reshape(-1))
        gains = torch.from_numpy(gains.reshape(-1))
        gains = (gains - gains.mean()) / (gains.std(correction=0) + 1e-8)
        # Drawn before the threads part, so that a seed gives one run.
        orders = [torch.randperm(len(gains)).split(self.settings.minibatch) for _ in range(self.settings.epochs)]
        if self.pool is None:
            self.improve_policy(rollout, gains, orders)
            self.fit_value(rollout, targets, orders)
        else:
            half = self.settings.threads // 2
            value = self.pool.submit(with_threads, half, self.fit_value, rollout, targets, orders)
            with_threads(self.settings.threads - half, self.improve_policy, rollout, gains, orders)
            value.result()
        self.environment.starts.refresh()
        self.seconds["learning"] += time.perf_counter() - began

    @torch.inference_mode()
    def act(self, rows: np.ndarray) -> np.ndarray:
        """The mean of the policy for normalised observations."""
        return self.actor.mean(torch.from_numpy(rows)).numpy()

    def collect(self) -> Rollout:
        """The policy acts. Normalizers stay as they are until the rollout is over, then take in all that was seen."""
        s, e = self.settings, self.environment
        shape, joints = (s.steps, e.copies), len(self.actor.log_std)
        actor_rows = np.empty((*shape, e.actor_rows.shape[1]), np.float32)
        critic_rows = np.empty((s.steps + 1, e.copies, e.critic_rows.shape[1]), np.float32)
        rollout = Rollout(
            np.empty_like(actor_rows),
            critic_rows,
            *(np.empty((*shape, joints), np.float32) for _ in range(2)),
            *(np.empty(shape, np.float32) for _ in range(2)),
            *(np.empty(shape, bool) for _ in range(2)),
            [],
            [],
        )
        log_std = self.actor.log_std.detach().numpy().copy()
        began = time.perf_counter()
        for k in range(s.steps):
            actor_rows[k], critic_rows[k] = e.actor_rows, e.critic_rows
            rollout.actor_rows[k] = self.actor_normalizer(e.actor_rows)
            noise = e.rng.standard_normal((e.copies, joints), np.float32)
            rollout.means[k] = self.act(rollout.actor_rows[k])
            rollout.actions[k] = rollout.means[k] + np.exp(log_std) * noise
            rollout.log_probabilities[k] = -0.5 * np.square(noise).sum(1) - log_std.sum()
            self.seconds["policy"] -= began - (began := time.perf_counter())
            outcome = e.step(rollout.actions[k])
            rollout.rewards[k] = outcome.rewards
            rollout.terminated[k], rollout.truncated[k] = outcome.terminated, outcome.truncated
            if len(outcome.final_critic_rows):
                rollout.final_rows.append(self.critic_normalizer(outcome.final_critic_rows))
                rollout.final_steps += [(k, i) for i in np.nonzero(outcome.truncated)[0]]
            self.seconds["environment"] -= began - (began := time.perf_counter())
        critic_rows[s.steps] = e.critic_rows
        rollout.critic_rows = self.critic_normalizer(critic_rows)
        self.actor_normalizer.update(actor_rows)
        self.critic_normalizer.update(critic_rows[:-1])
        self.seconds["policy"] += time.perf_counter() - began
        return rollout

    @torch.inference_mode()
    def value(self, rollout: Rollout) -> tuple[np.ndarray, np.ndarray]:
        """V(s_t) and V(s_t+1) of every step; the latter of what was reached, where an episode was cut."""
        values = self.critic(torch.from_numpy(rollout.critic_rows))[..., 0].numpy() * self.value_scale
        next_values = values[1:].copy()
        if rollout.final_rows:
            final = self.critic(torch.from_numpy(np.concatenate(rollout.final_rows)))[:, 0].numpy()
            next_values[tuple(np.array(rollout.final_steps).T)] = final * self.value_scale
        return values[:-1], next_values

    def advantages(self, rollout: Rollout, values: np.ndarray, next_values: np.ndarray) -> np.ndarray:
        """Generalised advantage estimation (Schulman et al. 2016)."""
        s = self.settings
        errors = rollout.rewards + s.gamma * np.where(rollout.terminated, 0, next_values) - values
        going = s.gamma * s.lam * ~(rollout.terminated | rollout.truncated)
        out, later = np.empty_like(values), np.zeros(values.shape[1], np.float32)
        for k in reversed(range(s.steps)):
            later = out[k] = (errors[k] + going[k] * later).astype(np.float32)
        return out

    def improve_policy(self, rollout: Rollout, gains: torch.Tensor, orders: list):
        """The epochs of the policy, and the steering of its learning rate by the divergence from the old one."""
        s, actor = self.settings, self.actor
        rows, actions, means, old = (
            torch.from_numpy(x.reshape(gains.shape[0], -1))
            for x in (rollout.actor_rows, rollout.actions, rollout.means, rollout.log_probabilities)
        )
        old = old[:, 0]
        old_log_std = actor.log_std.detach().clone()
        probe = slice(None, None, -(-len(gains) // DIVERGENCE_ROWS))
        low, high = (math.log(x) for x in s.std_bounds)
        rate = self.rate
        for epoch, order in enumerate(orders):
            for batch in order:
                z = (actions[batch] - actor.mean(rows.index_select(0, batch))) * torch.exp(-actor.log_std)
                ratio = torch.exp(-0.5 * z.square().sum(1) - actor.log_std.sum() - old[batch])
                gain = gains[batch]
                loss = -torch.min(ratio * gain, ratio.clamp(1 - s.clip, 1 + s.clip) * gain).mean()
                self.descend(actor, self.actor_adam, loss, rate)
                with torch.no_grad():
                    actor.log_std.clamp_(low, high)
            with torch.no_grad():
                log_ratio = actor.log_std - old_log_std
                shift = (actor.mean(rows[probe]) - means[probe]) * torch.exp(-actor.log_std)
                spread = torch.exp(-2 * log_ratio) + shift.square()
                divergence = float((log_ratio + 0.5 * spread - 0.5).sum(1).mean())
            if divergence > 2 * s.target_divergence:
                rate = max(rate / 1.5, s.rate_bounds[0])
            elif epoch + 1 == s.epochs and divergence < 0.5 * s.target_divergence:
                rate = min(rate * 1.5, s.rate_bounds[1])
            if divergence > STOP * s.target_divergence:
                break
        self.rate = rate

    def fit_value(self, rollout: Rollout, targets: torch.Tensor, orders: list):
        """The epochs of the value function."""
        rows = torch.from_numpy(rollout.critic_rows[:-1].reshape(len(targets), -1))
        for order in orders:
            for batch in order:
                loss = 0.5 * (self.critic(rows.index_select(0, batch))[:, 0] - targets[batch]).square().mean()
                self.descend(self.critic, self.critic_adam, loss, self.settings.critic_rate)

    def descend(self, network: nn.Module, adam: torch.optim.Adam, loss: torch.Tensor, rate: float):
        """One gradient step, left out when the gradient is not finite."""
        adam.param_groups[0]["lr"] = rate
        adam.zero_grad(set_to_none=True)
        loss.backward()
        norm = nn.utils.clip_grad_norm_(network.parameters(), self.settings.gradient_norm)
        if torch.isfinite(norm):
            adam.step()


def warm_up():
    """PyTorch loads its compiler when an optimizer steps for the first time: seconds that are no part of training."""
    x = torch.zeros(1, requires_grad=True)
    adam = torch.optim.Adam([x], fused=True)
    x.square().sum().backward()
    nn.utils.clip_grad_norm_([x], 1.0)
    adam.step()


def with_threads(threads: int, work, *arguments):
    """Does the work with so many threads inside PyTorch's own operations."""
    torch.set_num_threads(max(threads, 1))
    return work(*arguments)
