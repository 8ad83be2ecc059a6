"""Steps per second of vector environments and of bare physics, all on one body in one run; and memory over many steps.

    pip install lifelike gymnasium mujoco
    python peers/python/rates.py rates 256 2      # environments, threads
    python peers/python/rates.py memory 1000000   # steps

The body is gymnasium's humanoid (17 actuators), which our engine reads as it is. Every figure is the median of three
rounds of `SECONDS` of wall time.
"""

import gc
import os
import statistics
import sys
import time

import gymnasium
import mujoco
import numpy as np
from mujoco.batch import Batch

import lifelike
from lifelike.gymnasium import TrackingVectorEnv

SECONDS = float(os.environ.get("SECONDS", "5"))
MODEL = os.path.join(gymnasium.__path__[0], "envs", "mujoco", "assets", "humanoid.xml")


def rate(step, per_call):
    """Return the median of three rounds, in units of `per_call` per second."""
    step()
    rounds = []
    for _ in range(3):
        calls, began = 0, time.perf_counter()
        while time.perf_counter() - began < SECONDS:
            step()
            calls += 1
        rounds.append(calls * per_call / (time.perf_counter() - began))
    return statistics.median(rounds)


def environment_rate(envs):
    """Environment steps per second under random actions, the policy's usual size."""
    envs.reset(seed=1)
    limit = min(0.4, float(envs.single_action_space.high[0]))
    rng = np.random.default_rng(1)
    pool = [rng.uniform(-limit, limit, envs.action_space.shape).astype(np.float32) for _ in range(16)]
    count = iter(range(10**9))
    found = rate(lambda: envs.step(pool[next(count) % 16]), envs.num_envs)
    envs.close()
    return found


def physics_rates(environments, threads):
    """Physics steps per second of MuJoCo's batch and of our engine: same body, torques, time step and episodes."""
    robot = lifelike.Robot(MODEL)
    model = mujoco.MjModel.from_xml_path(MODEL)
    model.opt.timestep, model.opt.integrator = robot.timestep, mujoco.mjtIntegrator.mjINT_EULER
    batch = Batch(model, nsim=environments, nthread=threads)
    qpos, qvel, ctrl = batch.bind("qpos"), batch.bind("qvel"), batch.bind("ctrl")
    simulation = lifelike.Simulation(robot, environments, threads=threads)
    columns = [robot.joint_names.index(model.joint(model.actuator(i).trnid[0]).name) for i in range(model.nu)]
    rng = np.random.default_rng(1)
    controls = [rng.uniform(-0.4, 0.4, (environments, model.nu)) for _ in range(16)]
    torques = [np.zeros((environments, model.nu), np.float32) for _ in controls]
    for torque, control in zip(torques, controls):
        torque[:, columns] = control * model.actuator_gear[:, 0]
    start = robot.default_qpos
    period, count = round(robot.control_hz), [0, 0]

    def theirs():
        if count[0] % period == 0:
            qpos[:], qvel[:] = start, 0
        ctrl[:] = controls[count[0] % 16]
        batch.step(nstep=robot.substeps)
        count[0] += 1

    def ours():
        if count[1] % period == 0:
            simulation.reset()
        simulation.step(torques=torques[count[1] % 16])
        count[1] += 1

    while count[0] < period // 2:
        theirs(), ours()
    heights = [np.mean(qpos[:, 2]), np.mean(simulation.root_position[:, 2])]
    print(f"root height after {period // 2} steps: mujoco.batch {heights[0]:.3f} m, lifelike {heights[1]:.3f} m")
    per_call = environments * robot.substeps
    assert not simulation.diverged.any() and abs(heights[0] - heights[1]) < 2e-3, "the same physics"
    return rate(theirs, per_call), rate(ours, per_call)


def rates(environments, threads):
    """Print the table of `docs/results/python.md`."""
    print(f"gymnasium {gymnasium.__version__}, MuJoCo {mujoco.__version__}, lifelike {lifelike.__version__}")
    theirs, ours = physics_rates(environments, threads)
    print(f"physics steps/s, {environments} bodies, {threads} threads: mujoco.batch {theirs:.0f}, lifelike {ours:.0f}")
    tracking = TrackingVectorEnv(environments, robot=MODEL, clips=lifelike.load_clips("builtin", MODEL), threads=threads)
    print(f"environment steps/s, {environments} environments: lifelike {environment_rate(tracking):.0f}")
    for mode, number in (("async", threads), ("async", 16 * threads), ("sync", environments)):
        envs = gymnasium.make_vec("Humanoid-v5", num_envs=number, vectorization_mode=mode)
        print(f"environment steps/s, {number} environments: gymnasium Humanoid-v5 {mode} {environment_rate(envs):.0f}")
    lima = TrackingVectorEnv(environments, threads=threads)
    print(f"environment steps/s, {environments} environments: lifelike, robot lima {environment_rate(lima):.0f}")


def resident():
    """Resident memory of this process (MiB)."""
    gc.collect()
    pages = int(open("/proc/self/statm").read().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def memory(steps):
    """Print resident memory while one environment takes many steps, all outputs read at each."""
    envs = TrackingVectorEnv(1, threads=1)
    simulation = lifelike.Simulation("lima", 1, threads=1)
    envs.reset(seed=1)
    actions = np.zeros(envs.action_space.shape, np.float32)
    targets = lifelike.Robot("lima").default_pose[None]
    for step in range(steps + 1):
        if step % (steps // 10) == 0:
            print(f"{step:8d} steps: {resident():.1f} MiB", flush=True)
        envs.step(actions)
        simulation.step(targets)
        if simulation.joint_position[0, 0] > 3 or step % 100 == 0:
            simulation.reset()


if __name__ == "__main__":
    command, *numbers = sys.argv[1:]
    {"rates": rates, "memory": memory}[command](*map(int, numbers))
