"""A stack's G1 tracker in MuJoCo, by definitions of its own: the peer of `lifelike import` and `lifelike eval`.

    pip install onnx onnxruntime mujoco numpy
    python dance.py POLICY.onnx G1.xml [--scale effort|one] [--seconds S] [--starts N] [--reader]

With --reader holosoma's own program loads the file and builds every observation (pip install holosoma-inference pin); the
largest difference from ours is printed.

Nothing of lifelike is used. Observations are written after holosoma's own source (holosoma_inference 0.1.3,
policies/wbt.py) or mjlab's (1.6.0, tasks/tracking), actions are theirs, torques are explicit PD at 1 kHz with the rotors
and limits of BeyondMimic. Prints what `eval` prints: episodes without a fall, mean joint error, seconds.
"""

import argparse
import json
from types import SimpleNamespace

import mujoco
import numpy as np
import onnx
import onnxruntime

# Rotor inertia (kg m2) and largest torque (N m), by the end of a joint's name (whole_body_tracking, robots/g1.py).
MOTORS = {
    "hip_pitch_joint": (0.010177520, 88), "hip_yaw_joint": (0.010177520, 88), "waist_yaw_joint": (0.010177520, 88),
    "hip_roll_joint": (0.025101925, 139), "knee_joint": (0.025101925, 139),
    "ankle_pitch_joint": (0.00721945, 50), "ankle_roll_joint": (0.00721945, 50),
    "waist_roll_joint": (0.00721945, 50), "waist_pitch_joint": (0.00721945, 50),
    "wrist_pitch_joint": (0.00425, 5), "wrist_yaw_joint": (0.00425, 5),
}
OTHERS = (0.003609725, 25)
CROUCH = {
    "hip_pitch_joint": -0.312, "knee_joint": 0.669, "ankle_pitch_joint": -0.363, "shoulder_pitch_joint": 0.2,
    "elbow_joint": 0.6, "left_shoulder_roll_joint": 0.2, "right_shoulder_roll_joint": -0.2,
}


def by_end(table, name, other):
    return next((value for end, value in table.items() if name.endswith(end)), other)


def matrix(quaternion):
    out = np.zeros(9)
    mujoco.mju_quat2Mat(out, np.asarray(quaternion, float))
    return out.reshape(3, 3)


class Policy:
    """A policy's file: network, motion, joints and gains by its own metadata."""

    def __init__(self, path, scale):
        model = onnx.load(path)
        texts = {entry.key: entry.value for entry in model.metadata_props}
        self.session = onnxruntime.InferenceSession(path, providers=["CPUExecutionProvider"])
        self.is_holosoma = "dof_names" in texts
        if self.is_holosoma:
            self.joints = json.loads(texts["dof_names"])
            self.kp, self.kd = np.array(json.loads(texts["kp"])), np.array(json.loads(texts["kd"]))
            self.terms = ["actions", "base_ang_vel", "dof_pos", "dof_vel", "motion_command", "motion_ref_ori_b"]
            self.default = np.array([by_end(CROUCH, name, 0.0) for name in self.joints])
            effort = np.array([by_end(MOTORS, name, OTHERS)[1] for name in self.joints])
            told = json.loads(texts["action_scale"]) if "action_scale" in texts else None
            self.scale = np.array(told) if told else (0.25 * effort / self.kp if scale == "effort" else np.ones(len(effort)))
            self.anchor = json.loads(texts["anchor_body_name"]) if "anchor_body_name" in texts else "torso_link"
        else:
            numbers = lambda key: np.array([float(x) for x in texts[key].split(",")])
            self.joints, self.terms = texts["joint_names"].split(","), texts["observation_names"].split(",")
            self.kp, self.kd = numbers("joint_stiffness"), numbers("joint_damping")
            self.default, self.scale = numbers("default_joint_pos"), numbers("action_scale")
            self.anchor, self.bodies = texts["anchor_body_name"], texts["body_names"].split(",")
        self.size = self.session.get_inputs()[0].shape[1]
        self.frames = self.motion_length()

    def row(self, step):
        feeds = {"obs": np.zeros((1, self.size), np.float32), "time_step": np.array([[step]], np.float32)}
        names = [output.name for output in self.session.get_outputs()]
        return dict(zip(names, self.session.run(names, feeds), strict=True))

    def motion_length(self):
        low, high = 0, 1
        key = "ref_pos_xyz" if self.is_holosoma else "body_pos_w"
        last = self.row(1e9)[key]
        while not np.array_equal(self.row(high)[key], last):
            low, high = high, 2 * high
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (low, middle) if np.array_equal(self.row(middle)[key], last) else (middle, high)
        return high + 1

    def reference(self, step):
        """Joint positions and velocities, and place and orientation (wxyz) of the anchor and, where the file has it, of the root."""
        row = self.row(step)
        joints = row["joint_pos"][0], row["joint_vel"][0]
        if self.is_holosoma:
            return *joints, row["ref_pos_xyz"][0], row["ref_quat_xyzw"][0][[3, 0, 1, 2]], None
        at = self.bodies.index(self.anchor)
        root = row["body_pos_w"][0, 0], row["body_quat_w"][0, 0]
        return *joints, row["body_pos_w"][0, at], row["body_quat_w"][0, at], root


class Reader:
    """holosoma's own reader: its classes load the file and build the observation. Only the robot's interface is left out."""

    def __init__(self, path):
        from holosoma_inference.config.config_values.observation import wbt as observation
        from holosoma_inference.config.config_values.robot import g1_29dof
        from holosoma_inference.config.config_values.task import wbt as task
        from holosoma_inference.policies.wbt import WholeBodyTrackingPolicy as Theirs

        self.it = it = Theirs.__new__(Theirs)
        it._target_source, it.robot_yaw_offset, it.motion_yaw_offset = None, 0.0, 0.0
        it.config = SimpleNamespace(robot=g1_29dof, observation=observation, task=task)
        it._init_robot_config(g1_29dof)
        it._init_obs_config()
        it.last_policy_action = np.zeros((1, it.num_dofs))
        it.setup_policy(path)
        it._configure_action_scales()
        self.scale = it.per_joint_policy_action_scale[0]

    def row(self, data, q, v, action, command, turn):
        self.it.last_policy_action = action[None]
        self.it.motion_command_t = np.concatenate(command)[None]
        self.it.ref_quat_xyzw_t = np.asarray(turn)[None, [1, 2, 3, 0]]
        state = np.concatenate([data.qpos[:7], data.qpos[q], data.qvel[:6], data.qvel[v]])[None]
        return self.it.prepare_obs_for_rl(state)["actor_obs"][0]


def place_root(model, data, q, policy, anchor, step):
    """Puts the robot into a frame; returns its position and the joints' velocities."""
    position, velocity, place, turn, _ = policy.reference(step)
    data.qpos[:7] = 0, 0, 0, 1, 0, 0, 0
    data.qpos[q] = position
    mujoco.mj_kinematics(model, data)
    # The root is where it must be for the anchor to be where the motion has it.
    root = matrix(turn) @ data.xmat[anchor].reshape(3, 3).T
    data.qpos[:3] = np.array(place) - root @ data.xpos[anchor]
    mujoco.mju_mat2Quat(data.qpos[3:7], root.flatten())
    return data.qpos.copy(), velocity


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("policy")
    parser.add_argument("robot")
    parser.add_argument("--scale", choices=["effort", "one"], default="effort")
    parser.add_argument("--seconds", type=float, default=1e9)
    parser.add_argument("--starts", type=int, default=5)
    parser.add_argument("--reader", action="store_true")
    parser.add_argument("--save", help="CSV of the first episode at 50 Hz: x y z, quaternion xyzw, joints (rad)")
    given = parser.parse_args()
    policy = Policy(given.policy, given.scale)
    reader = Reader(given.policy) if given.reader else None
    if reader:
        policy.scale = reader.scale
    spec = mujoco.MjSpec.from_file(given.robot)
    # Shapes that are only seen, and whose files may not be there; the model says every mass.
    for geom in [geom for geom in spec.geoms if geom.type == mujoco.mjtGeom.mjGEOM_MESH]:
        spec.delete(geom)
    for mesh in list(spec.meshes):
        spec.delete(mesh)
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1])
    model = spec.compile()
    model.opt.timestep = 0.001
    model.actuator_gainprm[:] = 0
    model.actuator_biasprm[:] = 0
    joints = [model.joint(name) for name in policy.joints]
    q, v = np.array([j.qposadr[0] for j in joints]), np.array([j.dofadr[0] for j in joints])
    for joint, name in zip(joints, policy.joints, strict=True):
        model.dof_armature[joint.dofadr[0]] = by_end(MOTORS, name, OTHERS)[0]
        model.dof_damping[joint.dofadr[0]] = model.dof_frictionloss[joint.dofadr[0]] = 0.0
    limit = np.array([by_end(MOTORS, name, OTHERS)[1] for name in policy.joints], float)
    anchor = model.body(policy.anchor).id
    errors, survived, seconds, differs, rows = [], 0, 0.0, 0.0, []
    for start in np.linspace(0, max(policy.frames - 100, 0), given.starts).astype(int):
        data = mujoco.MjData(model)
        ahead, _ = place_root(model, data, q, policy, anchor, start + 1)
        pose, velocity = place_root(model, data, q, policy, anchor, start)
        # Velocities of the root by differences: linear in the world, angular in its own frame.
        mujoco.mj_differentiatePos(model, data.qvel, 0.02, pose, ahead)
        data.qvel[v] = velocity
        mujoco.mj_forward(model, data)
        position = data.qpos[q].copy()
        action = (position - policy.default) / policy.scale
        fell = False
        for step in range(start, min(policy.frames - 1, start + int(given.seconds * 50))):
            position, velocity, place, turn, _ = policy.reference(step)
            mujoco.mj_kinematics(model, data)
            own = data.xmat[anchor].reshape(3, 3)
            lean = own.T @ matrix(turn)
            values = {
                "actions": action, "base_ang_vel": data.qvel[3:6],
                "base_lin_vel": matrix(data.qpos[3:7]).T @ data.qvel[:3],
                "motion_anchor_pos_b": own.T @ (np.array(place) - data.xpos[anchor]),
            }
            values["dof_pos"] = values["joint_pos"] = data.qpos[q] - policy.default
            values["dof_vel"] = values["joint_vel"] = data.qvel[v]
            values["motion_command"] = values["command"] = np.concatenate([position, velocity])
            values["motion_ref_ori_b"] = values["motion_anchor_ori_b"] = lean[:, :2].reshape(-1)
            row = np.concatenate([values[term] for term in policy.terms]).astype(np.float32)
            if reader:
                theirs = reader.row(data, q, v, action, (position, velocity), turn)
                differs = max(differs, float(np.abs(theirs - row).max()))
                row = theirs
            feeds = {"obs": row[None], "time_step": np.array([[step]], np.float32)}
            action = policy.session.run(["actions"], feeds)[0][0].astype(float)
            target = policy.default + policy.scale * action
            for _ in range(20):
                torque = policy.kp * (target - data.qpos[q]) - policy.kd * data.qvel[v]
                data.qfrc_applied[v] = np.clip(torque, -limit, limit)
                mujoco.mj_step(model, data)
            errors.append(np.abs(data.qpos[q] - policy.reference(step + 1)[0]).mean())
            seconds += 0.02
            if start == 0:
                rows.append(np.concatenate([data.qpos[:3], data.qpos[[4, 5, 6, 3]], data.qpos[q]]))
            if data.qpos[2] < 0.35 or matrix(data.qpos[3:7])[2, 2] < 0.3:
                fell = True
                break
        survived += not fell
    if given.save:
        np.savetxt(given.save, rows, delimiter=",", fmt="%.6f")
    print(json.dumps({
        "policy": given.policy, "episodes": given.starts, "without_a_fall": survived, "seconds": round(seconds, 1),
        "joint_error_deg": round(float(np.degrees(np.mean(errors))), 2),
        **({"readers_observation_differs_by": differs} if reader else {}),
    }))


if __name__ == "__main__":
    main()
