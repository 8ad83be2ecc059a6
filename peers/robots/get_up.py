"""Getting up in MuJoCo: the script and the tracking policy, in physics that is not ours, judged by its own contacts.

    pip install lifelike mujoco
    python peers/robots/get_up.py 100

The script's player and the motors (thesis eqs. 4.9-4.11) are written here once more; only the policy is the package's.
"""

import fnmatch
import sys
import tomllib
from pathlib import Path

import lifelike
import mujoco
import numpy as np

ROOT = Path(__file__).parents[2]
STEP, DROP, SECONDS, HOLD = 0.02, 100, 11, 50
script = tomllib.loads((ROOT / "robots/lima.get-up.toml").read_text())
profile = tomllib.loads((ROOT / "robots/lima.toml").read_text())
model = mujoco.MjModel.from_xml_path(str(ROOT / "robots/lima.xml"))
# Motors are limited below, by their speed too.
model.actuator_ctrlrange[:] *= 10
names = [model.joint(i).name for i in range(1, model.njnt)]
low, high = model.jnt_range[1:].T
stand = np.array([profile["default_pose"].get(name, 0.0) for name in names])
partner = [names.index(n.replace("left", "?").replace("right", "left").replace("?", "right")) for n in names]
sign = np.array([-1.0 if "roll" in n or "yaw" in n else 1.0 for n in names])
feet = {model.geom("left_foot").id, model.geom("right_foot").id}
controller = lifelike.Controller(ROOT / "crates/lifelike/assets/lima-blind.controller.safetensors")
frames = SECONDS * 50 + 3
at_rest = np.tile([[0.0, 0.0, 0.44]], (frames, 1)), np.tile([[1.0, 0.0, 0.0, 0.0]], (frames, 1))
clip = lifelike.Clip("stand", 50.0, names, *at_rest, np.tile(stand, (frames, 1)))


def parameter(key):
    def of(name):
        groups = (g for g in profile["actuator"].values() if any(fnmatch.fnmatch(name, p) for p in g["joints"]))
        return next(groups)["parameters"][key]

    return np.array([of(name) for name in names])


kp, kd, most = parameter("kp"), parameter("kd"), parameter("torque_max")
full, fastest = parameter("full_torque_velocity"), parameter("velocity_max")
static, viscous, slow = parameter("static_friction"), parameter("viscous_friction"), parameter("friction_velocity")


def ramp(velocity):
    return np.clip((fastest - velocity) / (fastest - full), 0, 1)


def advance(data, targets):
    for _ in range(round(STEP / model.opt.timestep)):
        q, v = data.qpos[7:], data.qvel[6:]
        data.ctrl[:] = np.clip(kp * (targets - q) - kd * v, -most * ramp(-v), most * ramp(v))
        speed = np.maximum(np.abs(v), 1e-9)
        model.dof_damping[6:] = static * np.tanh(speed / slow) / speed + viscous
        mujoco.mj_step(model, data)


def axes(data):
    """Vertical parts of the root's axes: forward, left, up."""
    w, x, y, z = data.qpos[3:7]
    return 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)


class Player:
    """Plays the script: lie, then rise from the belly, else roll first."""

    def __init__(self, joints):
        self.mirrored = False
        self.enter("lie", joints)

    def enter(self, stage, before):
        self.stage, self.key, self.elapsed, self.before = stage, 0, 0.0, before.copy()

    def pose(self):
        pose = np.array(script[self.stage][self.key]["pose"])
        return (pose * sign)[partner] if self.mirrored and self.stage == "roll" else pose

    def step(self, data):
        forward, left, _ = axes(data)
        if self.stage == "rise" and forward > 0.7:
            self.enter("lie", data.qpos[7:])
        self.elapsed += STEP
        while self.elapsed > (seconds := script[self.stage][self.key]["seconds"]):
            left_over, self.before, self.key = self.elapsed - seconds, self.pose(), self.key + 1
            self.elapsed = left_over
            if self.key == len(script[self.stage]):
                ready = forward < -0.6 and self.stage != "rise"
                following = "rise" if ready else "roll" if self.stage == "lie" else "lie"
                self.mirrored = left < 0 and self.stage != "rise"
                self.enter(following, self.before)
                self.elapsed = left_over
        share = min(1.0, self.elapsed / script[self.stage][self.key]["seconds"])
        return self.before + (self.pose() - self.before) * (share * share * (3 - 2 * share))


def stands(data):
    """Upright, high enough, on both feet and nothing else."""
    touching = [set(contact.geom) for contact in data.contact]
    alone = all(pair & feet for pair in touching) and all(any(foot in pair for pair in touching) for foot in feet)
    return alone and axes(data)[2] > np.cos(0.349) and data.qpos[2] > 0.85 * 0.44


def policy_targets(run, data):
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, data.qpos[3:7])
    rates = turn.reshape(3, 3) @ data.qvel[3:6]
    parts = data.qpos[7:], data.qvel[6:], data.qpos[3:7], rates
    return run.step(*(part.astype(np.float32) for part in parts)).astype(float)


def episode(rng):
    """Drops one robot; returns whether it stood, step by step."""
    data = mujoco.MjData(model)
    turn = rng.standard_normal(4)
    data.qpos[2], data.qpos[3:7], data.qpos[7:] = 0.7, turn / np.linalg.norm(turn), rng.uniform(low, high)
    for _ in range(DROP):
        advance(data, data.qpos[7:].copy())
    player, run, stood = Player(data.qpos[7:]), None, []
    for _ in range(SECONDS * 50):
        up = axes(data)[2]
        if run is not None and up < np.cos(1.0):
            player, run = Player(data.qpos[7:]), None
        if run is None and player.stage == "rise" and up > 0.9 and data.qpos[2] > 0.75 * 0.44:
            run = controller.follow(clip)
        advance(data, player.step(data) if run is None else policy_targets(run, data))
        stood.append(stands(data))
    return np.array(stood)


rng, times, last = np.random.default_rng(5), [], []
for number in range(int(sys.argv[1])):
    stood = episode(rng)
    held = [i for i in range(len(stood) - HOLD + 1) if stood[i : i + HOLD].all()]
    times.append(held[0] * STEP if held else np.inf)
    last.append(stood[-HOLD:].all())
    if (number + 1) % 25 == 0 or number + 1 == int(sys.argv[1]):
        up = np.array(times)
        shares = [100 * np.mean(up <= limit) for limit in (5, 10)] + [100 * np.mean(last)]
        text = "MuJoCo {}, {} dropped: up in 5 s {:.1f}%, in 10 s {:.1f}%, stand at end {:.1f}%, median {:.1f} s"
        print(text.format(mujoco.__version__, number + 1, *shares, np.median(up)), flush=True)
