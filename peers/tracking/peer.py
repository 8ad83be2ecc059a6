"""The training of `lifelike train tracker` with PyTorch, numpy and MuJoCo's Python bindings, to compare speeds.

    python peer.py --threads 2

See README.md for what is the same and what is not.
"""

import argparse
import json
import os
import sys
import time
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
MARKS = (0.5, 0.8, 0.9)


def arguments() -> argparse.Namespace:
    """Defaults are those of experiments/track-walk.toml."""
    p = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add = p.add_argument
    default = REPOSITORY / "data/lima/deepmimic/humanoid3d_long_walk1.motion.safetensors"
    add("--clip", type=Path, default=default, help="a *.motion.safetensors of the robot")
    add("--robot", default="lima", help="NAME.xml and NAME.toml in --robots")
    add("--robots", type=Path, default=REPOSITORY / "robots")
    add("--physics", choices=("batch", "rollout"), default="batch", help="see README.md")
    add("--threads", type=int, default=1, help="of MuJoCo and of PyTorch; numpy has one")
    add("--steps", type=int, default=3_000_000, help="environment steps")
    add("--minutes", type=float, default=float("inf"), help="wall time, if it ends before the steps do")
    add("--seed", type=int, default=1)
    add("--environments", type=int, default=256)
    add("--rollout", type=int, default=12, help="steps of each environment per iteration")
    add("--epochs", type=int, default=4)
    add("--minibatch", type=int, default=1536)
    add("--hidden", type=int, nargs="+", default=[256, 128])
    add("--gamma", type=float, default=0.97)
    add("--lambda", dest="lam", type=float, default=0.95)
    add("--clip-range", type=float, default=0.2)
    add("--target-divergence", type=float, default=0.05)
    add("--learning-rate", type=float, default=1e-3)
    add("--learning-rate-bounds", type=float, nargs=2, default=[2e-5, 3e-3])
    add("--critic-learning-rate", type=float, default=1e-3)
    add("--gradient-norm", type=float, default=1.0)
    add("--initial-std", type=float, default=0.4)
    add("--std-bounds", type=float, nargs=2, default=[0.2, 1.6])
    add("--failure-share", type=float, default=0.5, help="share of starts drawn by failure rate")
    add("--evaluation-starts", type=int, default=24)
    add("--evaluation-seconds", type=float, default=10.0)
    return p.parse_args()


def main():
    args = arguments()
    # Before numpy and PyTorch are loaded: they read it once.
    for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ[name] = str(args.threads)
    import numpy as np
    import torch

    import physics
    from clip import Clip
    from environment import Environment
    from evaluation import evaluate
    from features import Layout
    from learner import Learner, Settings, warm_up
    from robot import Robot

    torch.manual_seed(args.seed)
    rng = np.random.default_rng(args.seed)
    robot = Robot(args.robots, args.robot)
    clip = Clip(args.clip, robot, Layout(len(robot.joints), len(robot.effectors)))
    simulate = {"batch": physics.Batched, "rollout": physics.RolledOut}[args.physics]
    world = simulate(robot, args.environments, args.threads)
    environment = Environment(robot, clip, world, args.environments, rng, failure_share=args.failure_share)
    settings = Settings(
        steps=args.rollout,
        epochs=args.epochs,
        minibatch=args.minibatch,
        hidden=args.hidden,
        gamma=args.gamma,
        lam=args.lam,
        clip=args.clip_range,
        target_divergence=args.target_divergence,
        rate=args.learning_rate,
        rate_bounds=tuple(args.learning_rate_bounds),
        critic_rate=args.critic_learning_rate,
        gradient_norm=args.gradient_norm,
        initial_std=args.initial_std,
        std_bounds=tuple(args.std_bounds),
        threads=args.threads,
    )
    learner = Learner(settings, environment, len(robot.joints))
    sizes = f"{environment.actor_rows.shape[1]} and {environment.critic_rows.shape[1]} observations"
    print(f"{robot.path.stem} follows {clip.name}: {len(clip)} frames, {sizes}", file=sys.stderr)
    warm_up()
    result = train(learner, args)
    fresh = simulate(robot, args.evaluation_starts, args.threads)
    result["evaluation"] = evaluate(learner, fresh, args.evaluation_starts, args.evaluation_seconds)
    print(json.dumps(rounded(result)))


def train(learner, args: argparse.Namespace) -> dict:
    """Until the budget is spent; how long it took and for what."""
    steps, iteration, reached = 0, 0, {}
    began, began_cpu = time.perf_counter(), time.process_time()
    tally = learner.environment.tally
    while steps < args.steps and time.perf_counter() - began < 60 * args.minutes:
        learner.iterate()
        iteration += 1
        steps += args.environments * args.rollout
        wall = time.perf_counter() - began
        for mark in MARKS:
            if tally.survival >= mark and mark not in reached:
                reached[mark] = {"seconds": wall, "steps": steps}
        if iteration % 25 == 0:
            length = sum(tally.lengths) / max(len(tally.lengths), 1) / learner.environment.robot.control_hz
            print(
                f"{wall:6.1f} s {steps:9,} steps {steps / wall:7,.0f}/s survival {tally.survival:.2f} "
                f"episode {length:5.2f} s std {learner.actor.log_std.exp().mean():.2f} rate {learner.rate:.1e}",
                file=sys.stderr,
            )
    wall, cpu = time.perf_counter() - began, time.process_time() - began_cpu
    physics = learner.environment.physics_seconds
    seconds = {**learner.seconds, "physics": physics, "environment": learner.seconds["environment"] - physics}
    return {
        "physics": args.physics,
        "threads": args.threads,
        "seed": args.seed,
        "steps": steps,
        "wall_seconds": wall,
        "cpu_seconds": cpu,
        "steps_per_second": steps / wall,
        "steps_per_cpu_second": steps / cpu,
        "seconds": seconds,
        "training_survival": tally.survival,
        "reached": {f"{mark:.0%}": reached.get(mark) for mark in MARKS},
    }


def rounded(value):
    """Numbers short enough to read."""
    if isinstance(value, dict):
        return {key: rounded(x) for key, x in value.items()}
    return float(f"{value:.4g}") if isinstance(value, float) else value


if __name__ == "__main__":
    main()
