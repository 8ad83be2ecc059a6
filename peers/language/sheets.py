"""Sheets for judges of sentences: each sentence in physics, ten pictures of the rollout, and its numbers.

    pip install mujoco safetensors pillow
    MUJOCO_GL=osmesa python peers/language/sheets.py prompts.jsonl out --program lifelike

A line of the prompts is {"id": 1, "robot": "lima", "text": "wave twice", "must": "..."}. The folder gets NNN.txt (sentence, the program's
words, numbers), NNN.png and the clips. docs/results/language.md has the rules by which judges read them.
"""

import argparse
import json
import subprocess
from pathlib import Path

import mujoco
import numpy as np
from PIL import Image, ImageDraw
from safetensors import safe_open

WIDTH, HEIGHT, PICTURES = 256, 288, 10
# Height of the root, and lift from which a foot is off the ground (m).
SIZES = {"lima": (0.5, 0.02), "g1": (0.95, 0.03)}
TOLD = ("neck", "waist", "elbow", "knee")
SIDES = ("left", "right")


def model(path):
    """The robot with a ground and light to see it by."""
    spec = mujoco.MjSpec.from_file(str(path))
    for geom in [g for g in spec.worldbody.geoms if g.type == mujoco.mjtGeom.mjGEOM_PLANE]:
        spec.delete(geom)
    kind, pattern = mujoco.mjtTexture.mjTEXTURE_2D, mujoco.mjtBuiltin.mjBUILTIN_CHECKER
    spec.add_texture(name="tiles", type=kind, builtin=pattern, rgb1=[0.85] * 3, rgb2=[0.7] * 3, width=256, height=256)
    material = spec.add_material(name="tiles", texrepeat=[10, 10])
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "tiles"
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[20, 20, 0.1], material="tiles")
    spec.worldbody.add_light(pos=[1, 1, 4], dir=[-0.2, -0.2, -1], diffuse=[0.9] * 3)
    spec.visual.headlight.ambient = [0.45] * 3
    spec.visual.global_.offwidth, spec.visual.global_.offheight = WIDTH, HEIGHT
    return spec.compile()


class Robot:
    def __init__(self, name, path):
        self.model = model(path)
        self.data, self.renderer = mujoco.MjData(self.model), mujoco.Renderer(self.model, HEIGHT, WIDTH)
        self.height, self.lift = SIZES[name]
        names = [self.model.body(i).name for i in range(self.model.nbody)]
        last = {}
        for side in SIDES:
            for part, keys in (("hand", ("hand", "wrist_yaw", "forearm")), ("foot", ("foot", "ankle_roll", "ankle"))):
                last[side, part] = next(names.index(n) for k in keys for n in names if side in n and k in n)
        self.parts = last

    def pose(self, clip, t):
        joints, orientation, position, columns = clip
        self.data.qpos[:3], self.data.qpos[3:7], self.data.qpos[columns] = position[t], orientation[t], joints[t]
        mujoco.mj_kinematics(self.model, self.data)

    def gap(self):
        """Distance between the surfaces of the hands (m)."""
        model, data = self.model, self.data
        left, right = ([g for g in range(model.ngeom) if model.geom_bodyid[g] == self.parts[s, "hand"]] for s in SIDES)
        return min(mujoco.mj_geomDistance(model, data, a, b, 2.0, None) for a in left for b in right)


def headings(orientation):
    w, x, y, z = orientation.T
    return np.unwrap(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))


def sheet(robot, clip, rate):
    """Ten pictures, from the front and the left."""
    position, yaw = clip[2], np.degrees(headings(clip[1])[0])
    image = Image.new("RGB", (WIDTH * 5, (HEIGHT + 14) * 2), "white")
    draw, camera = ImageDraw.Draw(image), mujoco.MjvCamera()
    for k, t in enumerate(np.linspace(0, len(position) - 1, PICTURES).round().astype(int)):
        robot.pose(clip, t)
        camera.lookat[:] = [*position[t][:2], 0.75 * robot.height]
        camera.distance, camera.azimuth, camera.elevation = 3 * robot.height, yaw + 208, -14
        robot.renderer.update_scene(robot.data, camera)
        x, y = k % 5 * WIDTH, k // 5 * (HEIGHT + 14)
        image.paste(Image.fromarray(robot.renderer.render()), (x, y + 14))
        draw.text((x + 4, y + 1), f"{t / rate:.1f} s", fill="black")
    return image


def lifts(height, least, rate):
    """When a foot is off the ground, and for how long."""
    up = np.concatenate([[False], height > least, [False]]).astype(int)
    edges = np.flatnonzero(np.diff(up)).reshape(-1, 2)
    return ", ".join(f"{a / rate:.1f} s for {(b - a) / rate:.1f} s" for a, b in edges) or "never"


def numbers(robot, clip, rate, names):
    joints, orientation, position, _ = clip
    places, gaps = {part: [] for part in robot.parts}, []
    for t in range(len(position)):
        robot.pose(clip, t)
        gaps.append(robot.gap())
        for part, body in robot.parts.items():
            places[part].append(robot.data.xpos[body][2])
    yaw, way = headings(orientation), position[-1] - position[0]
    ahead = way[0] * np.cos(yaw[0]) + way[1] * np.sin(yaw[0])
    left = way[1] * np.cos(yaw[0]) - way[0] * np.sin(yaw[0])
    turned = np.degrees(yaw - yaw[0])
    lines = [
        f"{len(position) / rate:.1f} s; ends {ahead:+.2f} m ahead, {left:+.2f} m to the left; turned {turned[-1]:+.0f} deg "
        f"(left is positive), between {turned.min():+.0f} and {turned.max():+.0f}",
        f"root height {position[0][2]:.2f} m, lowest {position[:, 2].min():.2f}, highest {position[:, 2].max():.2f}",
    ]
    for (side, part), heights in places.items():
        height = np.array(heights) - heights[0]
        line = f"{side} {part}: highest {100 * height.max():+.0f} cm, lowest {100 * height.min():+.0f} cm"
        lines.append(line + (f"; off the ground {lifts(height, robot.lift, rate)}" if part == "foot" else ""))
    near = np.array(gaps) < 0.1
    count = int(near[0]) + int((np.diff(near.astype(int)) == 1).sum())
    lines.append(f"hands: nearest {100 * min(gaps):.1f} cm, within 10 cm {count} times")
    for column, name in enumerate(names):
        if any(word in name for word in TOLD):
            angles = np.degrees(joints[:, column])
            lines.append(f"{name}: {angles[0]:+.0f} deg at first, from {angles.min():+.0f} to {angles.max():+.0f}")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("prompts", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--program", default="lifelike")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    fetched = Path.home() / ".local/share/lifelike/robots/unitree_g1/g1.xml"
    files = {"lima": Path(__file__).parents[2] / "robots/lima.xml", "g1": fetched}
    robots = {}
    for line in options.prompts.read_text().splitlines():
        prompt = json.loads(line)
        base = options.out / f"{prompt['id']:03d}"
        endings = (".motion.safetensors", ".script.toml", ".x.motion.safetensors")
        clip, script, executed = (base.with_suffix(ending) for ending in endings)
        make = [options.program, "generate", "--robot", prompt["robot"]]
        said = subprocess.run([*make, prompt["text"], "--physics", "-o", clip], capture_output=True, text=True)
        text = f"{prompt['text']}\n{prompt.get('must', '')}\n\nexit {said.returncode}\n{said.stdout}{said.stderr}"
        if script.exists():
            subprocess.run([*make, "--script", script, "--project", "-o", executed], capture_output=True)
        if executed.exists():
            if prompt["robot"] not in robots:
                robots[prompt["robot"]] = Robot(prompt["robot"], files[prompt["robot"]])
            own = robots[prompt["robot"]]
            with safe_open(executed, "np") as file:
                told = json.loads(file.metadata()["motion"])
                arrays = [file.get_tensor(k) for k in ("joints", "root_orientation", "root_position")]
            columns = [own.model.joint(name).qposadr[0] for name in told["joint_names"]]
            motion = (*arrays, columns)
            sheet(own, motion, told["fps"]).save(base.with_suffix(".png"))
            text += "\n" + numbers(own, motion, told["fps"], told["joint_names"])
        base.with_suffix(".txt").write_text(text)


if __name__ == "__main__":
    main()
