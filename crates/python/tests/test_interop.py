"""Policies of other stacks, by the others' own programs: onnx's checker, onnxruntime, and holosoma's reader."""

import json
import subprocess
import sys
from pathlib import Path

import lifelike
import numpy as np
import pytest

onnx = pytest.importorskip("onnx")
onnxruntime = pytest.importorskip("onnxruntime")

ROOT = Path(__file__).parents[3]
PEERS = ROOT / "peers" / "interop"
STEPS = 1000


def command(*arguments):
    """Run the command in the checkout, whose fetched robots it finds; return its result."""
    words = [sys.executable, "-m", "lifelike", "--json", "-q", *map(str, arguments)]
    ran = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    return json.loads(ran.stdout)


@pytest.fixture(scope="session")
def g1(tmp_path_factory):
    """The Unitree G1, with a clip and the shipped tracker in every stack's files."""
    model = ROOT / "third_party" / "robots" / "unitree_g1" / "g1.xml"
    if not model.is_file():
        pytest.skip("the Unitree G1 was not fetched")
    folder = tmp_path_factory.mktemp("g1")
    command("motion", "retarget", "motions/walk.keys.toml", "--robot", "g1", "-o", folder)
    clip = folder / "walk.motion.safetensors"
    for stack in ["onnx", "beyondmimic", "mjlab", "holosoma", "unitree"]:
        command("export", "g1-deploy", "--robot", "g1", "--for", stack, "--motions", clip, "-o", folder / stack)
    return model, folder


def test_onnxruntime_gives_the_targets_of_recorded_steps(tmp_path, robot, controller, walk):
    command("export", "lima", "--for", "onnx", "-o", tmp_path)
    path = tmp_path / "policy.onnx"
    model = onnx.load(path)
    onnx.checker.check_model(model, full_check=True)
    constants = {array.name: onnx.numpy_helper.to_array(array) for array in model.graph.initializer}
    session = onnxruntime.InferenceSession(str(path), providers=["CPUExecutionProvider"])
    simulation, worst, rows = lifelike.Simulation(robot, 1, threads=1), 0.0, 0
    while rows < STEPS:
        run = controller.follow(walk)
        qpos, qvel = run.reference_state()
        simulation.reset(qpos=[qpos], qvel=[qvel])
        while not run.is_over and rows < STEPS:
            state = [simulation.joint_position, simulation.joint_velocity, simulation.root_orientation]
            state += [simulation.angular_velocity_w, simulation.root_position, simulation.linear_velocity_w]
            targets = run.step(*(values[0] for values in state))
            # The frame that was to be reached is now the present one. The network saw numbers after the normalizer.
            reference = np.array(run.reference_joints, np.float32)
            seen = np.asarray(run.observation) / constants["normalizer.inverse_deviation"] + constants["normalizer.mean"]
            feeds = {"obs": seen.astype(np.float32), "reference_joint_position": reference[None]}
            worst = max(worst, np.abs(session.run(["joint_targets"], feeds)[0][0] - targets).max())
            simulation.step([targets])
            rows += 1
    assert worst < 1e-5, worst


def test_a_policy_with_a_memory_is_a_gru_that_gives_its_golden_rows(tmp_path):
    run, file = tmp_path / "run", tmp_path / "onnx" / "policy.onnx"
    plan = ["track", "inputs.history=4", "network.memory=16", "ppo.environments=64", "ppo.minibatch=256"]
    command("train", "tracker", "--plan", *plan, "budget.steps=5000", "-o", run)
    command("export", run, "--for", "onnx", "-o", file.parent)
    assert [node.op_type for node in onnx.load(file).graph.node].count("GRU") == 1
    subprocess.run([sys.executable, PEERS / "replay.py", file], check=True)


def test_every_stacks_file_passes_the_checker_and_gives_its_golden_rows(g1):
    _, folder = g1
    files = sorted(folder.rglob("policy.onnx"))
    assert len(files) == 5
    for file in files:
        subprocess.run([sys.executable, PEERS / "replay.py", file], check=True)


def test_holosomas_reader_loads_our_file_and_the_robot_walks_in_mujoco(g1):
    pytest.importorskip("holosoma_inference")
    model, folder = g1
    words = [sys.executable, PEERS / "dance.py", folder / "holosoma" / "policy.onnx", model, "--reader", "--starts", "2"]
    ran = subprocess.run(words, capture_output=True, text=True, check=True)
    found = json.loads(ran.stdout.strip().splitlines()[-1])
    assert found["without_a_fall"] == 2, found
    assert found["readers_observation_differs_by"] < 1e-5, found


@pytest.mark.parametrize("name", ["ppo", "fastsac"])
def test_holosomas_released_trackers_dance_in_our_engine(tmp_path, g1, name):
    holosoma = pytest.importorskip("holosoma_inference")
    released = Path(holosoma.__file__).parent / "models" / "wbt" / f"{name}_g1_29dof_dancing.onnx"
    made = command("import", released, "--robot", "g1", "-o", tmp_path / "dance.controller.safetensors")
    report = command(
        "eval", "--policy", made["controller"], "--robot", "g1", "--motions", made["motion"], "-o", tmp_path / "report"
    )
    assert report["overall"]["survival"] == 1.0, report["overall"]
    assert report["overall"]["joint_error_deg"] < 8, report["overall"]


def test_a_wrong_order_of_a_released_tracker_is_refused(tmp_path, g1):
    holosoma = pytest.importorskip("holosoma_inference")
    released = Path(holosoma.__file__).parent / "models" / "wbt" / "ppo_g1_29dof_dancing.onnx"
    terms = "motion_command,motion_ref_ori_b,base_ang_vel,dof_pos,dof_vel,actions"
    words = ["import", str(released), "--robot", "g1", "--terms", terms, "-o", str(tmp_path / "x.controller.safetensors")]
    ran = subprocess.run([sys.executable, "-m", "lifelike", *words], cwd=ROOT, capture_output=True, text=True, check=False)
    assert ran.returncode == 3 and "contradicts" in ran.stderr, ran.stderr
