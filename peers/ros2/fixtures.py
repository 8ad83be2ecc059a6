"""Writes a JointTrajectory of ROS 2 as bytes, for the tests of crates/dds.

    pip install cyclonedds==11.0.1 unitree_dds_wrapper==2.0.9 numpy pygame
    python peers/ros2/fixtures.py crates/dds/tests/data

The message's type is that of the package; the bytes are as Cyclone DDS sends them (XCDR1, little-endian, with its header).
"""

import pathlib
import sys

from unitree_dds_wrapper.idl import builtin_interfaces, std_msgs, trajectory_msgs

times, ros = builtin_interfaces.msg.dds_, trajectory_msgs.msg.dds_
point = ros.JointTrajectoryPoint_([0.5, -0.25], [], [], [], times.Duration_(1, 2))
header = std_msgs.msg.dds_.Header_(times.Time_(0, 0), "")
message = ros.JointTrajectory_(header, ["left_knee_joint", "hip"], [point])
data = message.serialize(use_version_2=False)
(pathlib.Path(sys.argv[1]) / "joint_trajectory.cdr").write_bytes(data)
print(len(data), "bytes, header", data[:4].hex())
