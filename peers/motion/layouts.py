"""One motion in the layouts of robot motion, as NumPy, pickle, PyTorch and MuJoCo write and read them.

    python layouts.py --write FOLDER    writes the fixtures of crates/motion/src/formats/tests/robot_motion
    python layouts.py --check FOLDER    reads what `lifelike motion convert` wrote in every layout, and compares

The files of --check come from lafan1.csv of --write, each by

    lifelike motion convert lafan1.csv FOLDER/LAYOUT.SUFFIX --to LAYOUT \\
        --layout lafan1 --input-fps 50 --fps 50 --robot lima

The motion is of lima (robots/lima.xml): a turn with steps, 5 frames at 50 frames per second, made up. Poses and
velocities of bodies are MuJoCo's: velocities of joints and root are numpy.gradient (as torch.gradient), the root's
angular velocity is a central difference of rotations repeated at the ends, bodies move at the origins of their
frames. Needs numpy, torch, mujoco 4.0, scipy.
"""

import argparse
import csv
import pathlib
import pickle
import zipfile

import mujoco
import numpy as np
import torch
from scipy.spatial.transform import Rotation

ROBOT = pathlib.Path(__file__).parents[2] / "robots/lima.xml"
FPS = 50


def model():
    m = mujoco.MjModel.from_xml_path(str(ROBOT))
    joints = [m.joint(i).name for i in range(1, m.njnt)]
    bodies = [m.body(i).name for i in range(m.nbody)]
    return m, joints, bodies


def breadth_first(m, joints):
    depth = lambda b: 0 if b == 0 else 1 + depth(m.body_parentid[b])
    bodies = sorted(range(1, m.nbody), key=depth)
    order = sorted(range(len(joints)), key=lambda j: depth(m.jnt_bodyid[j + 1]))
    return bodies, order


def motion(frames=5):
    m, joints, _ = model()
    t = np.arange(frames) / FPS
    phase = np.arange(len(joints))
    q = 0.3 * np.sin(9 * t[:, None] + phase)
    q[:, [joints.index("left_knee"), joints.index("right_knee")]] += 0.5
    place = np.stack([0.8 * t, 0.1 * np.sin(5 * t), 0.6 + 0.02 * np.cos(7 * t)], 1)
    turn = Rotation.from_euler("xyz", np.stack([0.05 * np.sin(6 * t), 0.1 + 0 * t, 1.6 + 3.0 * t], 1))
    return place, turn, q


def states(place, turn, q):
    """Poses and velocities of all bodies, the world first."""
    m, _, _ = model()
    data = mujoco.MjData(m)
    dt = 1 / FPS
    linear, joint_vel = np.gradient(place, dt, axis=0), np.gradient(q, dt, axis=0)
    angular = (turn[2:] * turn[:-2].inv()).as_rotvec() / (2 * dt)
    angular = np.concatenate([angular[:1], angular, angular[-1:]])
    out = {name: [] for name in ("body_pos_w", "body_quat_w", "body_lin_vel_w", "body_ang_vel_w")}
    wxyz = turn.as_quat()[:, [3, 0, 1, 2]]
    for i in range(len(place)):
        data.qpos[:] = np.concatenate([place[i], wxyz[i], q[i]])
        data.qvel[:] = np.concatenate([linear[i], turn[i].inv().apply(angular[i]), joint_vel[i]])
        mujoco.mj_forward(m, data)
        velocity = np.zeros((m.nbody, 6))
        for b in range(m.nbody):
            mujoco.mj_objectVelocity(m, data, mujoco.mjtObj.mjOBJ_XBODY, b, velocity[b], 0)
        for name, value in zip(out, (data.xpos, data.xquat, velocity[:, 3:], velocity[:, :3])):
            out[name].append(value.copy())
    return {name: np.array(values) for name, values in out.items()}, joint_vel, linear, angular


def write(folder):
    m, joints, bodies = model()
    place, turn, q = motion()
    xyzw = turn.as_quat()
    wxyz = xyzw[:, [3, 0, 1, 2]]
    np.savetxt(folder / "lafan1.csv", np.concatenate([place, xyzw, q], 1), delimiter=",", fmt="%.9f")
    np.savetxt(folder / "kimodo.csv", np.concatenate([place, wxyz, q], 1), delimiter=",", fmt="%.9f")
    with open(folder / "bones.csv", "w", newline="") as file:
        rows = csv.writer(file)
        root = ["root_translateX", "root_translateY", "root_translateZ", "root_rotateX", "root_rotateY", "root_rotateZ"]
        rows.writerow(["Frame", *root, *(f"{name}_dof" for name in joints)])
        for i in range(len(q)):
            rows.writerow([i, *(100 * place[i]), *turn[i].as_euler("xyz", degrees=True), *np.degrees(q[i])])

    world, joint_vel, linear, angular = states(place, turn, q)
    f32 = lambda values: {name: np.asarray(value, np.float32) for name, value in values.items()}
    robot = {name: value[:, 1:] for name, value in world.items()}
    mjlab = f32({"joint_pos": q, "joint_vel": joint_vel, **robot})
    np.savez_compressed(folder / "mjlab.npz", fps=[FPS], **mjlab)
    level, order = breadth_first(m, joints)
    level = [b - 1 for b in level]
    beyond = {"joint_pos": q[:, order], "joint_vel": joint_vel[:, order]}
    beyond.update({name: value[:, level] for name, value in robot.items()})
    np.savez_compressed(folder / "beyondmimic.npz", fps=[FPS], **f32(beyond))
    names = {"joint_names": np.asarray(joints, dtype=object), "robot": np.asarray("lima", dtype=object)}
    twice = {name: np.concatenate([value, value[:3]]) for name, value in mjlab.items()}
    segments = {
        "segment_start_idx": np.array([0, 5]), "segment_length": np.array([5, 3]),
        "segment_source": np.array(["a.csv", "b.csv"], object), "segment_names": np.array(["turn", "part"], object),
    }
    np.savez_compressed(folder / "wbc.npz", fps=np.float32(FPS), **names, **twice, **segments)
    qpos, qvel = np.concatenate([place, wxyz, q], 1), np.concatenate([linear, angular, joint_vel], 1)
    np.savez_compressed(
        folder / "holosoma.npz", fps=np.array([FPS]), joint_pos=qpos, joint_vel=qvel, **world,
        joint_names=np.array(joints), body_names=np.array(bodies),
    )
    gmr = {"fps": FPS, "root_pos": place, "root_rot": xyzw, "dof_pos": q}
    gmr |= {"local_body_pos": None, "link_body_list": None}
    for protocol in (2, 4, 5):
        (folder / f"gmr{protocol}.pkl").write_bytes(pickle.dumps(gmr, protocol=protocol))
    fortran = {**gmr, "fps": np.float64(FPS), "dof_pos": np.asfortranarray(q), "joint_names": joints}
    (folder / "gmr_fortran.pkl").write_bytes(pickle.dumps(fortran, protocol=4))
    contacts = torch.zeros(len(q), m.nbody - 1, dtype=torch.bool)
    contacts[:2, bodies.index("left_foot") - 1] = True
    tensor = lambda value: torch.tensor(value, dtype=torch.float32)
    torch.save(
        {
            "dof_pos": tensor(q.T).T, "dof_vel": tensor(joint_vel), "fps": FPS, "rigid_body_contacts": contacts,
            "rigid_body_pos": tensor(robot["body_pos_w"]),
            "rigid_body_rot": tensor(robot["body_quat_w"][..., [1, 2, 3, 0]]),
            "rigid_body_vel": tensor(robot["body_lin_vel_w"]),
            "rigid_body_ang_vel": tensor(robot["body_ang_vel_w"]),
        },
        folder / "protomotions.motion",
    )


def same(name, got, expected, tolerance=1e-5):
    error = float(np.abs(np.asarray(got, float) - expected).max())
    print(f"{name:34} {error:.1e}")
    assert error < tolerance, name


def check(folder):
    """Compares files that were written from lafan1.csv of --write, at 50 frames per second."""
    m, joints, bodies = model()
    place, turn, q = motion()
    xyzw = turn.as_quat()
    wxyz = xyzw[:, [3, 0, 1, 2]]
    world, joint_vel, linear, angular = states(place, turn, q)
    robot = {name: value[:, 1:] for name, value in world.items()}
    level, order = breadth_first(m, joints)
    level = [b - 1 for b in level]
    signed = lambda got, expected: got * np.sign((got * expected).sum(-1, keepdims=True))
    for name, root in (("lafan1", xyzw), ("kimodo", wxyz)):
        same(name, np.loadtxt(folder / f"{name}.csv", delimiter=","), np.concatenate([place, root, q], 1))
    depth_first = list(range(m.nbody - 1)), list(range(len(joints)))
    for name, b, j in (("mjlab", *depth_first), ("beyondmimic", level, order)):
        file = np.load(folder / f"{name}.npz")
        assert file["fps"].tolist() == [FPS] and file["joint_pos"].dtype == np.float32
        same(f"{name} joint_pos", file["joint_pos"], q[:, j])
        same(f"{name} joint_vel", file["joint_vel"], joint_vel[:, j], 1e-4)
        for key in ("body_pos_w", "body_lin_vel_w", "body_ang_vel_w"):
            same(f"{name} {key}", file[key], robot[key][:, b], 1e-4 if "vel" in key else 1e-5)
        quat = robot["body_quat_w"][:, b]
        same(f"{name} body_quat_w", signed(file["body_quat_w"], quat), quat)
    file = np.load(folder / "wbc.npz", allow_pickle=True)
    assert file["joint_names"].tolist() == joints and file["segment_length"].tolist() == [len(q)]
    same("wbc joint_pos", file["joint_pos"], q)
    file = np.load(folder / "holosoma.npz")
    assert file["joint_names"].tolist() == joints and file["body_names"].tolist() == bodies
    assert file["fps"].tolist() == [FPS]
    same("holosoma joint_pos", file["joint_pos"], np.concatenate([place, wxyz, q], 1))
    same("holosoma joint_vel", file["joint_vel"], np.concatenate([linear, angular, joint_vel], 1), 1e-4)
    for key in ("body_pos_w", "body_lin_vel_w", "body_ang_vel_w"):
        same(f"holosoma {key}", file[key], world[key], 1e-4 if "vel" in key else 1e-5)
    gmr = pickle.loads((folder / "gmr.pkl").read_bytes())
    assert gmr["fps"] == FPS and gmr["joint_names"] == joints and gmr["local_body_pos"] is None
    for key, expected in (("root_pos", place), ("root_rot", xyzw), ("dof_pos", q)):
        same(f"gmr {key}", gmr[key], expected)
    proto = torch.load(folder / "protomotions.motion", weights_only=True)
    assert proto["fps"] == FPS and proto["rigid_body_contacts"].dtype == torch.bool
    same("protomotions dof_pos", proto["dof_pos"], q)
    same("protomotions rigid_body_pos", proto["rigid_body_pos"], robot["body_pos_w"])
    same("protomotions rigid_body_vel", proto["rigid_body_vel"], robot["body_lin_vel_w"], 1e-4)
    same("protomotions rigid_body_ang_vel", proto["rigid_body_ang_vel"], robot["body_ang_vel_w"], 1e-4)
    assert zipfile.ZipFile(folder / "protomotions.motion").testzip() is None


if __name__ == "__main__":
    arguments = argparse.ArgumentParser()
    arguments.add_argument("--write", type=pathlib.Path)
    arguments.add_argument("--check", type=pathlib.Path)
    arguments = arguments.parse_args()
    if arguments.write:
        write(arguments.write)
    if arguments.check:
        check(arguments.check)
