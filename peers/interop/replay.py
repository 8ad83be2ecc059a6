"""Replays the golden rows of an exported policy with onnxruntime: fails where this machine gives other actions.

    pip install onnx onnxruntime numpy
    python replay.py policy.onnx [TOLERANCE]

What a runtime should do once before it moves a robot.
"""

import json
import sys

import numpy as np
import onnx
import onnxruntime


def main() -> None:
    path = sys.argv[1]
    tolerance = float(sys.argv[2]) if len(sys.argv) > 2 else 1e-5
    model = onnx.load(path)
    onnx.checker.check_model(model, full_check=True)
    texts = {entry.key: entry.value for entry in model.metadata_props}
    golden, layout = json.loads(texts["lifelike_golden"]), json.loads(texts["lifelike_layout"])
    session = onnxruntime.InferenceSession(path, providers=["CPUExecutionProvider"])
    names = [entry.name for entry in session.get_inputs()]
    worst = 0.0
    for row, expected in zip(golden["obs"], golden["actions"], strict=True):
        feeds = {"obs": np.asarray([row], np.float32)}
        if "time_step" in names:
            feeds["time_step"] = np.zeros((1, 1), np.float32)
        if "reference_joint_position" in names:
            feeds["reference_joint_position"] = np.zeros((1, len(layout["joints"])), np.float32)
        actions = session.run(["actions"], feeds)[0][0]
        worst = max(worst, float(np.abs(actions - np.asarray(expected, np.float32)).max()))
    print(f"{path}: {len(golden['obs'])} golden rows for {layout['robot']}, worst difference {worst:.1e}")
    if not worst <= tolerance:
        sys.exit(f"expected at most {tolerance}, got {worst}: this runtime gives other actions")


if __name__ == "__main__":
    main()
