"""Measures the numbers of README's table again, and writes them to docs/results/data/headline.json and into the table.

    python peers/results/headline.py LIFELIKE FOLDER     # FOLDER has data/lima, data/g1 and experiments/, as experiments/track-long.toml makes it
    sed s/lima/g1/ experiments/track-hard-test.txt > g1-hard-test.txt     # in FOLDER, before

A test of `xtask` fails where README has other numbers than the file.
"""

import json
import platform
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FILE = ROOT / "docs/results/data/headline.json"
KEPT = ["episodes", "survival", "success", "joint_error_deg", "effector_error_m", "jerk", "reference_jerk", "sole_slip", "heat"]
# Robot, words of README, arguments.
ROWS = [
    ("lima", "30 clips of unseen people", "eval --policy lima --motions @experiments/track-all-test.txt"),
    ("lima", "83 harder clips of unseen people and styles", "eval --policy lima --motions @experiments/track-hard-test.txt"),
    (
        "lima",
        "the same in MuJoCo",
        "eval --policy lima --motions @experiments/track-hard-test.txt --engine mujoco",
    ),
    (
        "Unitree G1",
        "83 harder clips of unseen people and styles",
        "eval --policy g1 --robot g1 --motions @g1-hard-test.txt",
    ),
]


def row(robot, test, overall):
    """A line of README's table; the test of xtask makes the same."""
    shares = [f"{100 * overall[key]:.1f}%" for key in ("survival", "success")]
    return f"| {robot} | {test} | {shares[0]} | {shares[1]} | {overall['joint_error_deg']:.2f} deg |"


def main(program, folder):
    version = subprocess.run([program, "--version"], stdout=subprocess.PIPE, text=True, check=True).stdout
    rows = []
    for robot, test, arguments in ROWS:
        with tempfile.TemporaryDirectory() as output:
            command = [program, "--json", *arguments.split(), "-o", output]
            out = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, check=True)
        measured = json.loads(out.stdout)
        rows.append(
            {
                "robot": robot,
                "test": test,
                "command": f"lifelike {arguments}",
                "overall": {key: measured["overall"][key] for key in KEPT},
                "intervals": measured["intervals"],
            }
        )
        print(row(robot, test, rows[-1]["overall"]))
    FILE.write_text(json.dumps({"program": version.splitlines()[0], "machine": platform.machine(), "rows": rows}, indent=1) + "\n")
    readme = (ROOT / "README.md").read_text().splitlines()
    for entry in rows:
        starts = f"| {entry['robot']} | {entry['test']} |"
        readme = [row(entry["robot"], entry["test"], entry["overall"]) if line.startswith(starts) else line for line in readme]
    (ROOT / "README.md").write_text("\n".join(readme) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
