"""An exported policy in mjlab's own tracking environment, on the CPU: their observations, physics, terminations, metrics.

    pip install mjlab onnxruntime
    lifelike motion convert CLIP --layout mjlab --robot g1 -o clip.npz
    python mjlab_env.py policy.onnx clip.npz [--envs N]

Only the action's scale is the policy's, as its metadata say. Prints the observation's terms as their manager builds them.
"""

import argparse
import json

import numpy as np
import onnx
import onnxruntime
import torch
from mjlab.envs import ManagerBasedRlEnv
from mjlab.tasks.tracking.config.g1.env_cfgs import unitree_g1_flat_tracking_env_cfg
from mjlab.tasks.tracking.mdp.metrics import compute_mpkpe, compute_root_relative_mpkpe


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("policy")
    parser.add_argument("motion")
    parser.add_argument("--envs", type=int, default=4)
    given = parser.parse_args()
    texts = {entry.key: entry.value for entry in onnx.load(given.policy).metadata_props}
    terms = texts["observation_names"].split(",")
    cfg = unitree_g1_flat_tracking_env_cfg(has_state_estimation="base_lin_vel" in terms, play=True)
    cfg.commands["motion"].motion_file = given.motion
    cfg.scene.num_envs = given.envs
    joints, scales = texts["joint_names"].split(","), [float(x) for x in texts["action_scale"].split(",")]
    cfg.actions["joint_pos"].scale = dict(zip(joints, scales, strict=True))
    env = ManagerBasedRlEnv(cfg=cfg, device="cpu")
    theirs = env.observation_manager.active_terms["actor"]
    if theirs != terms:
        raise SystemExit(f"observation of mjlab: {theirs}, of the policy: {terms}")
    default = env.scene["robot"].data.default_joint_pos[0].numpy()
    told = np.array([float(x) for x in texts["default_joint_pos"].split(",")])
    if np.abs(default - told).max() > 1e-3 or list(env.scene["robot"].joint_names) != joints:
        raise SystemExit("default pose or joints of mjlab's robot are not the policy's")
    session = onnxruntime.InferenceSession(given.policy, providers=["CPUExecutionProvider"])
    observation, _ = env.reset()
    command = env.command_manager.get_term("motion")
    length = int(command.motion.time_step_total)
    errors, absolute, relative, ended = [], [], [], 0
    for _ in range(length - 2):
        rows = observation["actor"].numpy().astype(np.float32)
        step = np.zeros((1, 1), np.float32)
        actions = np.concatenate([session.run(["actions"], {"obs": row[None], "time_step": step})[0] for row in rows])
        observation, _, terminated, _, _ = env.step(torch.from_numpy(actions))
        ended += int(terminated.sum())
        errors.append((command.robot_joint_pos - command.joint_pos).abs().mean().item())
        absolute.append(compute_mpkpe(command).mean().item())
        relative.append(compute_root_relative_mpkpe(command).mean().item())
    print(json.dumps({
        "policy": given.policy, "terms": terms, "steps": length - 2, "environments": given.envs, "terminations": ended,
        "joint_error_deg": round(float(np.degrees(np.mean(errors))), 2),
        "mpkpe_mm": round(1000 * float(np.mean(absolute)), 1), "r_mpkpe_mm": round(1000 * float(np.mean(relative)), 1),
    }))


if __name__ == "__main__":
    main()
