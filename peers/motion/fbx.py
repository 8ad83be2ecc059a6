"""Writes a BVH file as FBX by Blender: y or z up, cm or m, with a bind pose or without.

    pip install bpy            # 5.0.1, Python 3.11
    python peers/motion/fbx.py WALK.bvh FOLDER [--takes] [--still] [--mirrored]

Each file is FOLDER/AXIS-UNIT-POSE/walk.fbx. Compare them with the BVH by the example `compare` of lifelike-motion.
`--takes` adds a second take, `--still` leaves the animation out, `--mirrored` gives the ends of limbs a scale of -1 as
3ds Max does: the fixtures of crates/motion/src/formats/tests/fbx.
"""

import pathlib
import sys

import bpy

AXES = {"y": {"axis_up": "Y", "axis_forward": "-Z"}, "z": {"axis_up": "Z", "axis_forward": "Y"}}
UNITS = {
    "cm": {"apply_scale_options": "FBX_SCALE_NONE"},
    "m": {"apply_scale_options": "FBX_SCALE_ALL"},
}


def armature_of(file):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_anim.bvh(filepath=file, global_scale=0.01, axis_forward="-Z", axis_up="Y", update_scene_fps=True)
    armature = next(o for o in bpy.data.objects if o.type == "ARMATURE")
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = (int(t) for t in armature.animation_data.action.frame_range)
    return armature


def add_skin(armature):
    """A bind pose is written for a skinned mesh alone."""
    mesh = bpy.data.meshes.new("skin")
    mesh.from_pydata([(0, 0, 0), (0.01, 0, 0), (0, 0.01, 0)], [], [(0, 1, 2)])
    skin = bpy.data.objects.new("skin", mesh)
    bpy.context.collection.objects.link(skin)
    skin.parent = armature
    for bone in armature.data.bones:
        skin.vertex_groups.new(name=bone.name).add([0, 1, 2], 0.05, "REPLACE")
    skin.modifiers.new("skin", "ARMATURE").object = armature


def main(file, folder, *flags):
    for up, axes in AXES.items():
        for unit, scale in UNITS.items():
            for pose in ("bind", "free"):
                armature = armature_of(file)
                if pose == "bind":
                    add_skin(armature)
                if "--mirrored" in flags:
                    for bone in armature.pose.bones:
                        bone.scale = (1, 1, 1) if bone.children else (-1, -1, -1)
                if "--takes" in flags:
                    armature.animation_data.action.copy().use_fake_user = True
                path = pathlib.Path(folder, f"{up}-{unit}-{pose}", "walk.fbx")
                path.parent.mkdir(parents=True, exist_ok=True)
                bpy.ops.export_scene.fbx(
                    filepath=str(path),
                    object_types={"ARMATURE", "MESH"},
                    bake_anim="--still" not in flags,
                    bake_anim_use_all_actions="--takes" in flags,
                    bake_anim_use_nla_strips=False,
                    bake_anim_simplify_factor=0.0,
                    **axes,
                    **scale,
                )


if __name__ == "__main__":
    main(*sys.argv[1:])
