"""A film that drives the add-on: a sheet falls on a figure that moves. It is baked, cancelled, baked on, judged and rendered.

    blender -b --factory-startup --python blender/film.py -- FOLDER [--frames N] [--no-pictures]

TULLE names the program. Exit code 0: nothing intersects in any frame.
"""
import argparse
import math
import os
import subprocess
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
sys.dont_write_bytecode = True

import addon_utils  # noqa: E402
import bpy  # noqa: E402
from mathutils import Vector  # noqa: E402

TULLE = os.path.abspath(os.environ.get("TULLE", "build/release/tulle"))
# Joints of the figure [m] and the half thickness there; limbs between them.
JOINTS = {
    "hip": ((0, 0, 0.95), 0.13), "chest": ((0, 0, 1.3), 0.15), "neck": ((0, 0, 1.5), 0.06), "head": ((0, 0, 1.66), 0.1),
    "shoulder.L": ((0.2, 0, 1.4), 0.07), "elbow.L": ((0.45, 0, 1.3), 0.05), "hand.L": ((0.7, 0, 1.25), 0.045),
    "shoulder.R": ((-0.2, 0, 1.4), 0.07), "elbow.R": ((-0.45, 0, 1.3), 0.05), "hand.R": ((-0.7, 0, 1.25), 0.045),
    "thigh.L": ((0.1, 0, 0.85), 0.09), "knee.L": ((0.12, 0.02, 0.48), 0.07), "foot.L": ((0.13, 0, 0.06), 0.05),
    "thigh.R": ((-0.1, 0, 0.85), 0.09), "knee.R": ((-0.12, 0.02, 0.48), 0.07), "foot.R": ((-0.13, 0, 0.06), 0.05),
}  # fmt: skip
LIMBS = [
    ("hip", "chest"), ("chest", "neck"), ("neck", "head"), ("chest", "shoulder.L"), ("shoulder.L", "elbow.L"),
    ("elbow.L", "hand.L"),
    ("chest", "shoulder.R"), ("shoulder.R", "elbow.R"), ("elbow.R", "hand.R"), ("hip", "thigh.L"), ("thigh.L", "knee.L"),
    ("knee.L", "foot.L"), ("hip", "thigh.R"), ("thigh.R", "knee.R"), ("knee.R", "foot.R"),
]  # fmt: skip


def add_figure():
    """A skin about the limbs, which bones bend."""
    names = list(JOINTS)
    mesh = bpy.data.meshes.new("Figure")
    mesh.from_pydata([JOINTS[name][0] for name in names], [(names.index(a), names.index(b)) for a, b in LIMBS], [])
    figure = bpy.data.objects.new("Figure", mesh)
    bpy.context.collection.objects.link(figure)
    bpy.context.view_layer.objects.active = figure
    skin = figure.modifiers.new("Skin", "SKIN")
    skin.branch_smoothing = 0.3
    for vertex, name in zip(mesh.skin_vertices[0].data, names):
        vertex.radius = (JOINTS[name][1],) * 2
    figure.modifiers.new("Subdivision", "SUBSURF").levels = 2
    for name in ("Skin", "Subdivision"):
        bpy.ops.object.modifier_apply(modifier=name)
    for polygon in figure.data.polygons:
        polygon.use_smooth = True
    rig = add_rig()
    for obj in bpy.context.view_layer.objects:
        obj.select_set(obj in (figure, rig))
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.parent_set(type="ARMATURE_AUTO")
    figure.tulle.role = "OBSTACLE"
    figure.color = (0.8, 0.55, 0.4, 1)
    return figure, rig


def add_rig():
    bpy.ops.object.armature_add(enter_editmode=True)
    rig = bpy.context.object
    bones = rig.data.edit_bones
    bones.remove(bones[0])
    ends = {}
    for a, b in LIMBS:
        bone = bones.new(a + "-" + b)
        bone.head, bone.tail = JOINTS[a][0], JOINTS[b][0]
        bone.parent = ends.get(a)
        ends[b] = bone
    bpy.ops.object.mode_set(mode="OBJECT")
    return rig


def animate(rig, frames: int) -> None:
    """The figure turns, bows and swings its arms."""
    for name, axis, size, turns in (
        ("hip-chest", 1, 0.35, 1.0), ("hip-chest", 0, 0.2, 1.5), ("neck-head", 0, 0.25, 2.0),
        ("shoulder.L-elbow.L", 2, 0.6, 1.5),
        ("shoulder.R-elbow.R", 2, 0.6, 1.5), ("elbow.L-hand.L", 0, 0.5, 2.0), ("elbow.R-hand.R", 0, 0.5, 2.0),
    ):  # fmt: skip
        pose = rig.pose.bones[name]
        pose.rotation_mode = "XYZ"
        for frame in range(1, frames + 1, 3):
            pose.rotation_euler[axis] = size * math.sin(2 * math.pi * turns * (frame - 1) / 72)
            pose.keyframe_insert("rotation_euler", index=axis, frame=frame)


def add_sheet():
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=64, y_subdivisions=64, size=1.7, location=(0, 0.02, 1.86))
    sheet = bpy.context.object
    sheet.name, sheet.rotation_euler.z = "Sheet", 0.4
    sheet.tulle.role, sheet.tulle.fabric = "CLOTH", "silk"
    for polygon in sheet.data.polygons:
        polygon.use_smooth = True
    sheet.modifiers.new("Subdivision", "SUBSURF")
    return sheet


def add_material(obj, color) -> None:
    material = bpy.data.materials.new(obj.name)
    material.use_nodes = True
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    shader.inputs["Base Color"].default_value = color + (1,)
    shader.inputs["Roughness"].default_value = 0.6
    obj.data.materials.clear()
    obj.data.materials.append(material)


def add_stage() -> None:
    bpy.ops.mesh.primitive_plane_add(size=12)
    ground = bpy.context.object
    ground.name, ground.tulle.role = "Ground", "OBSTACLE"
    add_material(ground, (0.35, 0.37, 0.4))
    for name, kind, energy, place in (("Key", "AREA", 250, (2.5, -2.5, 3.5)), ("Fill", "AREA", 60, (-3, -2, 2))):
        lamp = bpy.data.objects.new(name, bpy.data.lights.new(name, kind))
        lamp.data.energy, lamp.data.size = energy, 2
        lamp.location = place
        lamp.rotation_euler = (Vector((0, 0, 1.1)) - lamp.location).to_track_quat("-Z", "Y").to_euler()
        bpy.context.collection.objects.link(lamp)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location = (1.9, -3.1, 1.9)
    camera.rotation_euler = (Vector((0, 0, 1.0)) - camera.location).to_track_quat("-Z", "Y").to_euler()
    bpy.context.collection.objects.link(camera)
    bpy.context.scene.camera = camera
    world = bpy.data.worlds.new("World")
    world.color = (0.25, 0.27, 0.3)
    bpy.context.scene.world = world


def bake_with_a_pause() -> None:
    """Baked to a third, cancelled, baked on."""
    from tulle_addon import bake

    scene = bpy.context.scene
    bpy.ops.tulle.free()  # what an earlier film left
    under_way = bake.Bake(bpy.context)
    while not under_way.is_over:
        under_way.advance(bpy.context)
        if under_way.caches and under_way.caches.frame_count >= scene.frame_end // 3 and not under_way.is_cancelled:
            under_way.cancel()
    print("first bake:", scene.tulle.status, scene.tulle.report)
    assert under_way.state == "CANCELLED", scene.tulle.report
    assert bpy.ops.tulle.bake() == {"FINISHED"}, scene.tulle.report
    print("second bake:", scene.tulle.status, scene.tulle.report)


def judge(folder: str) -> int:
    """The judge on the run, and on the meshes as Blender has them."""
    code = subprocess.run([TULLE, "check", os.path.join(folder, "tulle_film", "run")], check=False).returncode
    for obj in bpy.context.scene.objects:
        obj.select_set(obj.tulle.role in ("CLOTH", "OBSTACLE"))
    bpy.ops.tulle.check(whole_range=True)
    print("in Blender:", bpy.context.scene.tulle.status)
    return code or (0 if bpy.context.scene.tulle.status.startswith("No intersection") else 1)


def render(folder: str) -> None:
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = 24, False
    scene.cycles.max_bounces = 3
    scene.render.resolution_x, scene.render.resolution_y = 480, 420
    scene.render.image_settings.file_format = "PNG"
    scene.render.filepath = os.path.join(folder, "film_")
    scene.frame_step = 3
    bpy.ops.render.render(animation=True)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("folder")
    parser.add_argument("--frames", type=int, default=72)
    parser.add_argument("--no-pictures", action="store_true")
    options = parser.parse_args(sys.argv[sys.argv.index("--") + 1 :])
    folder = os.path.abspath(options.folder)
    os.makedirs(folder, exist_ok=True)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    addon_utils.enable("tulle_addon", default_set=True)
    bpy.context.preferences.addons["tulle_addon"].preferences.program = TULLE
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, options.frames
    bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, "film.blend"))
    figure, rig = add_figure()
    animate(rig, options.frames)
    sheet = add_sheet()
    add_stage()
    add_material(figure, (0.75, 0.45, 0.3))
    add_material(sheet, (0.1, 0.35, 0.5))
    bake_with_a_pause()
    bpy.ops.wm.save_mainfile()
    code = judge(folder)
    bpy.ops.object.mode_set(mode="OBJECT")
    if not options.no_pictures:
        render(folder)
    sys.stdout.flush()
    os._exit(code)


try:
    main()
except Exception:
    import traceback

    traceback.print_exc()
    os._exit(2)
