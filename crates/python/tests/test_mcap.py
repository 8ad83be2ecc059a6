"""Records of an evaluation, read by the MCAP project's own ROS 2 reader; the numbers are the evaluation's."""

import subprocess
import sys

import lifelike
import numpy as np
import pytest

mcap_reader = pytest.importorskip("mcap.reader")
mcap_ros2 = pytest.importorskip("mcap_ros2.decoder")


def test_a_record_has_joints_bodies_contacts_and_torques(tmp_path):
    line = ["eval", "--policy", "lima", "--motions", "builtin:wave", "--starts", "1", "-o", "report", "--mcap"]
    subprocess.run([sys.executable, "-m", "lifelike", "-q", *line], cwd=tmp_path, check=True)
    messages = {}
    with (tmp_path / "report" / "wave.mcap").open("rb") as file:
        reader = mcap_reader.make_reader(file, decoder_factories=[mcap_ros2.DecoderFactory()])
        for _, channel, message, decoded in reader.iter_decoded_messages():
            messages.setdefault(channel.topic, []).append((message.log_time, decoded))

    robot = lifelike.Robot("lima")
    (clip,) = lifelike.load_clips("builtin:wave", robot)
    first = messages["/reference/joint_states"][0][1]
    assert list(first.name) == list(robot.joint_names)
    np.testing.assert_allclose(first.position, clip.joints[0], atol=1e-5)

    times = np.array([time for time, _ in messages["/joint_states"]]) * 1e-9
    np.testing.assert_allclose(np.diff(times), 0.02, atol=1e-8)
    positions = np.array([state.position for _, state in messages["/joint_states"]])
    velocities = np.array([state.velocity for _, state in messages["/joint_states"]])
    np.testing.assert_allclose(velocities[1:], np.diff(positions, axis=0) * 50.0, atol=1e-6)
    torques = np.array([state.effort for _, state in messages["/joint_states"]])
    assert torques.min() < -0.1 and torques.max() > 0.1, "torques have a sign"

    frames = {t.child_frame_id: t.transform for t in messages["/tf"][0][1].transforms}
    root = frames["reference/pelvis"].translation
    # An episode begins above the origin.
    np.testing.assert_allclose([root.x, root.y, root.z], [0.0, 0.0, clip.root_position[0][2]], atol=1e-5)
    assert len(frames) == 2 * 21, "20 links and the root, in physics and in the reference"

    # Standing and waving, the two feet carry the weight: its mean over a second.
    force = sum(np.array([w.wrench.force.z for _, w in messages[f"/contacts/{side}_foot"]]) for side in ("left", "right"))
    assert abs(force[-50:].mean() / (16.2 * 9.81) - 1.0) < 0.05
    assert all(marker.frame_locked for marker in messages["/robot"][0][1].markers)
