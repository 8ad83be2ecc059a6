"""Compares the places of joints in FBX files with those of Blender's Python importer, which shares no code with ours.

    pip install bpy            # 5.0.1, Python 3.11; binary files of version 7.1 and later
    cargo build --release -p lifelike-motion --example places
    python peers/motion/fbx_places.py target/release/examples/places FILE.fbx...

One turn and shift of the whole clip is free, since we turn bodies to face along x; sizes are not.
"""

import contextlib
import io
import pathlib
import subprocess
import sys

import bpy
import numpy as np


def ours(program, file):
    done = subprocess.run([program, file, "y", "z"], capture_output=True, text=True)
    if done.returncode:
        return done.stderr.strip()
    head, *rows = done.stdout.splitlines()
    fps, names = head.split(" ", 1)
    places = np.array([[[float(x) for x in place.split()] for place in row.split("\t")] for row in rows])
    return float(fps), names.split("\t"), places


def blenders(file, fps, frames, names):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="io_scene_fbx")
    with contextlib.redirect_stdout(io.StringIO()):
        bpy.ops.import_scene.fbx(filepath=file, ignore_leaf_bones=False)
    armatures = [o for o in bpy.data.objects if o.type == "ARMATURE"]
    if not armatures:
        raise RuntimeError("no armature")
    scene = bpy.context.scene
    rate = scene.render.fps / scene.render.fps_base
    moving = [o for o in bpy.data.objects if o.animation_data and o.animation_data.action]
    first = min((o.animation_data.action.frame_range[0] for o in moving), default=1)
    plain = lambda name: name.split(":")[-1]
    found = [plain(n) for n in names]
    heads = {plain(b.name): (a, b.name) for a in armatures for b in a.data.bones}
    # The topmost joint may be the armature itself.
    objects = {plain(o.name): o for o in bpy.data.objects}
    common = [n for n in found if n in heads or n in objects]
    places = np.zeros((frames, len(common), 3))
    for t in range(frames):
        time = first + t / fps * rate
        scene.frame_set(int(time), subframe=time - int(time))
        for i, name in enumerate(common):
            if name in heads:
                armature, bone = heads[name]
                places[t, i] = armature.matrix_world @ armature.pose.bones[bone].head
            else:
                places[t, i] = objects[name].matrix_world.translation
    return common, places


def apart(a, b):
    """Returns the largest distance after the best turn and shift of all frames together, and the quotient of sizes."""
    a, b = a.reshape(-1, 3), b.reshape(-1, 3)
    a, b = a - a.mean(0), b - b.mean(0)
    u, _, v = np.linalg.svd(a.T @ b)
    turn = u @ np.diag([1, 1, np.sign(np.linalg.det(u @ v))]) @ v
    return np.linalg.norm(a @ turn - b, axis=1).max(), np.sqrt((a**2).sum() / (b**2).sum())


def main(program, *files):
    for file in files:
        name = pathlib.Path(file).stem
        read = ours(program, file)
        if isinstance(read, str):
            print(f"{name}: refused: {read.splitlines()[-1]}", flush=True)
            continue
        fps, names, places = read
        try:
            common, others = blenders(file, fps, len(places), names)
        except RuntimeError as error:
            print(f"{name}: {len(names)} joints, {len(places)} frames at {fps:g}; Blender: {str(error)[-80:]!r}", flush=True)
            continue
        plain = [n.split(":")[-1] for n in names]
        mine = places[:, [plain.index(n) for n in common]]
        way, size = apart(mine, others)
        print(
            f"{name}: {len(common)} of {len(names)} joints, {len(places)} frames at {fps:g}, apart {1e3 * way:.3f} mm, "
            f"size {size:.6f}",
            flush=True,
        )


if __name__ == "__main__":
    main(*sys.argv[1:])
