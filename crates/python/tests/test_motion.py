"""Robots, clips, retargeting, lint, generation."""

import json
import subprocess
import sys
from pathlib import Path

import lifelike
import numpy as np
import pytest

KEYFRAMES = Path(__file__).parents[2] / "motion" / "motions" / "bow.keys.toml"


def command(*arguments):
    return subprocess.run([sys.executable, "-m", "lifelike", *map(str, arguments)], capture_output=True, text=True)


def test_the_robot_is_the_commands(robot):
    listed = json.loads(command("--json", "robots").stdout)
    lima = next(entry for entry in listed if entry["name"] == "lima")
    assert (len(robot.joint_names), robot.control_hz) == (lima["dof"], lima["control_hz"])
    assert robot.mass == pytest.approx(lima["mass_kg"])
    assert robot.default_qpos.shape == (robot.nq,) == (7 + len(robot.joint_names),)
    assert robot.timestep * robot.substeps == pytest.approx(1 / robot.control_hz)


def test_the_motor_is_a_pd_controller_with_limits(robot):
    zero = np.zeros(len(robot.joint_names))
    assert robot.motor_torque(zero + 0.01, zero, zero) == pytest.approx(0.01 * robot.kp)
    assert robot.motor_torque(zero, zero, zero + 0.01) == pytest.approx(-0.01 * robot.kd)
    assert robot.motor_torque(zero + 100, zero, zero) == pytest.approx(robot.torque_limit)


@pytest.mark.parametrize("changes", [[], ["fps=30", "smoothing=0.03"]])
def test_retargeting_is_the_commands_bit_for_bit(tmp_path, changes):
    done = command("motion", "retarget", KEYFRAMES, "--robot", "lima", "-o", tmp_path, *changes)
    assert done.returncode == 0, done.stderr
    clip, report = lifelike.retarget(KEYFRAMES, "lima", changes=changes)
    clip.save(tmp_path / "ours.motion.safetensors")
    assert (tmp_path / "ours.motion.safetensors").read_bytes() == (tmp_path / "bow.motion.safetensors").read_bytes()
    theirs = json.loads((tmp_path / "retarget.json").read_text())["clips"][0]["report"]
    # The only measure of time in it.
    assert report | {"frames_per_second": 0} == theirs | {"frames_per_second": 0}


def test_motion_of_one_robot_goes_to_another(tmp_path, walk):
    walk.save(tmp_path / "walk.motion.safetensors")
    clip, _ = lifelike.retarget(tmp_path / "walk.motion.safetensors", "humanoid", source_robot="lima")
    assert clip.joint_names == lifelike.Robot("humanoid").joint_names
    with pytest.raises(lifelike.Error, match="expected source_robot"):
        lifelike.retarget(tmp_path / "walk.motion.safetensors", "humanoid")


def test_a_clip_of_arrays_is_the_clip(tmp_path, walk):
    again = lifelike.Clip("walk", walk.fps, walk.joint_names, walk.root_position, walk.root_orientation, walk.joints)
    again.save(tmp_path / "again.motion.safetensors")
    loaded = lifelike.Clip.load(tmp_path / "again.motion.safetensors")
    for field in ("root_position", "root_orientation", "joints"):
        assert np.array_equal(getattr(loaded, field), getattr(walk, field)), field
    assert (len(loaded), loaded.seconds) == (len(walk), walk.seconds)
    assert walk.provenance["character"] == "lima"


def test_lint_finds_an_exchanged_quaternion_order(robot, walk):
    mistakes, same = robot.lint(walk)
    assert mistakes == [] and np.array_equal(same.joints, walk.joints)
    xyzw = np.roll(walk.root_orientation, -1, axis=1)
    wrong = lifelike.Clip("wrong", walk.fps, walk.joint_names, walk.root_position, xyzw, walk.joints)
    mistakes, fixed = robot.lint(wrong)
    assert [mistake["mistake"] for mistake in mistakes] == ["QuaternionOrder"] or "quaternion" in str(mistakes).lower()
    # The product of two quaternions that differ in sign only is 1 in magnitude.
    assert np.abs((fixed.root_orientation * walk.root_orientation).sum(axis=1)) == pytest.approx(1)


def test_a_clip_that_no_joint_can_follow_is_not_trackable(robot, walk):
    assert robot.check(walk)["trackable"]
    fast = lifelike.Clip(
        "fast", 20 * walk.fps, walk.joint_names, walk.root_position, walk.root_orientation, walk.joints
    )
    found = robot.check(fast)
    assert not found["trackable"] and found["findings"]


def test_a_sentence_becomes_motion(robot):
    first, second = lifelike.generate("a person waves", robot, candidates=2, steps=10, seed=3)
    again = lifelike.generate("a person waves", robot, candidates=1, steps=10, seed=3)[0]
    assert np.array_equal(first.joints, again.joints) and not np.array_equal(first.joints, second.joints)
    assert first.joint_names == robot.joint_names
    with pytest.raises(lifelike.Error, match="no pretrained generator for 'humanoid'"):
        lifelike.generate("a person waves", "humanoid")


def wrong_shape(robot, walk):
    lifelike.Clip("x", 50, walk.joint_names, walk.root_position, walk.root_orientation, walk.joints[:, 1:])


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda robot, walk: lifelike.Robot("limma"), "did you mean 'lima'?"),
        (lambda robot, walk: lifelike.load_clips("nowhere.bvh", robot), "nowhere.bvh"),
        (lambda robot, walk: lifelike.Clip.load("nowhere.motion.safetensors"), "nowhere.motion.safetensors"),
        (lambda robot, walk: lifelike.Controller("lim"), "did you mean 'lima'?"),
        (lambda robot, walk: lifelike.Controller("lima", "humanoid"), "humanoid"),
        (lambda robot, walk: lifelike.retarget(KEYFRAMES, robot, changes=["smothing=1"]), "smoothing"),
        (wrong_shape, r"joints: expected shape \[391, 20\], got \[391, 19\]"),
        (lambda robot, walk: lifelike.TrackingEnvironment("trak"), "did you mean 'track'"),
    ],
)
def test_bad_input_is_an_error_that_says_what_to_do(call, text, robot, walk):
    with pytest.raises(lifelike.Error, match=text.replace("?", r"\?")) as raised:
        call(robot, walk)
    assert isinstance(raised.value, ValueError)


def test_the_text_of_an_error_is_the_commands():
    done = command("motion", "check", "builtin", "--robot", "limma")
    with pytest.raises(lifelike.Error) as raised:
        lifelike.Robot("limma")
    assert done.stderr.strip() == f"lifelike: {raised.value}"
    assert (done.returncode, command("frobnicate").returncode) == (3, 2)
