"""Simulation and controller, against MuJoCo, golden vectors and the evaluation."""

import json
import threading
from pathlib import Path

import lifelike
import mujoco
import numpy as np
import pytest

ASSETS = Path(__file__).parents[2] / "lifelike" / "assets"


def test_a_passive_fall_is_mujocos(robot):
    model = mujoco.MjModel.from_xml_string(robot.mjcf)
    model.opt.timestep = robot.timestep
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_ACTUATION
    data = mujoco.MjData(model)
    columns = [model.joint(name).qposadr[0] for name in robot.joint_names]
    simulation = lifelike.Simulation(robot)
    qpos = robot.default_qpos
    qpos[2] += 0.1
    simulation.reset(qpos=[qpos])
    data.qpos[:] = qpos
    for step in range(15):
        simulation.step(torques=np.zeros((1, len(columns))))
        mujoco.mj_step(model, data, robot.substeps)
        joints = np.sqrt(np.mean((simulation.joint_position[0] - data.qpos[columns]) ** 2))
        root = np.abs(simulation.root_position[0] - data.qpos[:3]).max()
        # 0.1 s of flight, then the feet hit the ground. The bounds are twice what was measured against MuJoCo 4.0.
        bounds = (1e-7, 1e-7) if step < 5 else (1.3e-3, 5e-4)
        assert joints < bounds[0] and root < bounds[1], (step, joints, root)
    assert simulation.root_position[0, 2] < 0.25, "it fell"


def test_views_follow_the_simulation_without_copies(robot):
    simulation = lifelike.Simulation(robot, 3, threads=1)
    view, kept = simulation.joint_position, simulation.joint_position.copy()
    address = view.ctypes.data
    saved = simulation.save()
    targets = np.tile(robot.default_pose + 0.1, (3, 1))
    for _ in range(5):
        simulation.step(targets)
    assert not np.array_equal(view, kept), "the view shows the new state"
    assert np.shares_memory(view, simulation.joint_position) and simulation.joint_position.ctypes.data == address
    moved = view.copy()
    simulation.restore(saved)
    assert np.array_equal(view, kept), "and the restored one"
    for _ in range(5):
        simulation.step(targets)
    assert np.array_equal(view, moved), "from which it continues bit for bit"
    simulation.reset()
    assert view[0] == pytest.approx(robot.default_pose)
    with pytest.raises(ValueError, match="read-only"):
        view[0] = 0
    with pytest.raises(ValueError, match="WRITEABLE"):
        view.flags.writeable = True
    assert np.shares_memory(np.from_dlpack(view), view)
    del simulation
    assert view[0] == pytest.approx(robot.default_pose), "a view keeps its simulation alive"


def test_state_has_the_documented_shapes(robot):
    simulation = lifelike.Simulation(robot, 2)
    joints, bodies = len(robot.joint_names), len(robot.body_names)
    shapes = {
        "root_position": (2, 3),
        "root_orientation": (2, 4),
        "linear_velocity_w": (2, 3),
        "angular_velocity_w": (2, 3),
        "joint_position": (2, joints),
        "joint_velocity": (2, joints),
        "body_position": (2, bodies, 3),
        "body_orientation": (2, bodies, 4),
        "torque": (2, joints),
        "foot_force": (2, 2),
        "diverged": (2,),
    }
    for name, shape in shapes.items():
        assert getattr(simulation, name).shape == shape, name
    assert simulation.site_position.shape[::2] == (2, 3)


def test_pushes_and_parameters_change_one_environment(robot):
    simulation = lifelike.Simulation(robot, 3)
    simulation.push(1, robot.body_names[1], [40, 0, 0])
    simulation.set_parameters(2, gravity=[0, 0, -20])
    targets = np.tile(robot.default_pose, (3, 1))
    for _ in range(10):
        simulation.step(targets)
    plain, pushed, heavy = simulation.root_position
    assert pushed[0] > plain[0] + 0.01 and heavy[2] < plain[2]
    for call in (
        lambda: simulation.push(3, robot.body_names[1], [1, 0, 0]),
        lambda: simulation.push(0, "head_", [1, 0, 0]),
        lambda: simulation.set_parameters(0, gravitation=1),
        lambda: simulation.clear_pushes(3),
        lambda: simulation.step(targets[:2]),
        lambda: simulation.step(),
        lambda: simulation.reset([0], [[np.nan] * robot.nq]),
        lambda: lifelike.Simulation(robot, 0),
        lambda: lifelike.Simulation(robot, engine="bullet"),
    ):
        with pytest.raises(lifelike.Error):
            call()


def test_golden_vectors_of_the_file_are_reproduced():
    data = (ASSETS / "lima-path.controller.safetensors").read_bytes()
    size = int.from_bytes(data[:8], "little")
    header = json.loads(data[8 : 8 + size])

    def entry(name):
        begin, end = header[name]["data_offsets"]
        return np.frombuffer(data[8 + size :][begin:end], np.float32).reshape(header[name]["shape"])

    outputs = lifelike.Controller(ASSETS / "lima-path.controller.safetensors").outputs(entry("golden.observations"))
    assert outputs == pytest.approx(entry("golden.outputs"), rel=1e-5, abs=1e-5)


def test_a_loop_of_steps_is_the_evaluation(controller, walk):
    episode = lifelike.evaluate(controller, [walk], starts=1)["episodes"][0]
    run, simulation = controller.follow(walk), lifelike.Simulation(controller.robot)
    qpos, qvel = run.reference_state()
    simulation.reset(qpos=[qpos], qvel=[qvel])
    errors = []
    for _ in range(episode["frames"]):
        targets = run.step(
            simulation.joint_position[0],
            simulation.joint_velocity[0],
            simulation.root_orientation[0],
            simulation.angular_velocity_w[0],
            simulation.root_position[0],
            simulation.linear_velocity_w[0],
        )
        simulation.step([targets])
        errors.append(np.abs(simulation.joint_position[0] - run.reference_joints))
    # The same up to rounding of the first heading, which the evaluation sets to zero and the run measures.
    assert episode["survived"]
    assert np.degrees(np.mean(errors, axis=0)) == pytest.approx(episode["joint_errors_deg"], rel=1e-2)


def test_a_measurement_that_the_policy_needs_is_asked_for(controller, walk):
    run = controller.follow(walk)
    zero = np.zeros(len(controller.robot.joint_names))
    with pytest.raises(lifelike.Error, match="position|velocity"):
        run.step(zero, zero, [1, 0, 0, 0], [0, 0, 0])
    with pytest.raises(lifelike.Error, match=r"root_orientation: expected shape \[4\], got \[3\]"):
        run.step(zero, zero, [1, 0, 0], [0, 0, 0])
    with pytest.raises(lifelike.Error, match="start"):
        controller.follow(walk, start=100)


def test_results_do_not_depend_on_threads(controller, clips):
    one, two = (lifelike.evaluate(controller, clips[:4], starts=2, threads=threads) for threads in (1, 2))
    assert one == two


def test_an_object_in_use_is_refused_to_another_thread(robot):
    simulation = lifelike.Simulation(robot, 2048)
    targets = np.tile(robot.default_pose, (2048, 1)).astype(np.float32)
    thread = threading.Thread(target=lambda: [simulation.step(targets) for _ in range(20)])
    thread.start()
    refused = 0
    while thread.is_alive():
        try:
            simulation.joint_position
        except RuntimeError as error:
            assert "borrowed" in str(error)
            refused += 1
    assert refused > 0
