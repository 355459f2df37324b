"""Opens in Blender what make_scene.sh made and compares it with the NPZ archives.

usage: blender --background --factory-startup --python blender.py -- FOLDER

Debian's Blender 3.4 meets a NumPy without np.bool, which its importer of glTF names. The name is given back here, in this
test alone; in Blender as its makers build it nothing is to be done.
"""
import os
import sys
import traceback

import numpy as np

if "bool" not in np.__dict__:
    np.bool = bool

import bpy  # noqa: E402

folder = sys.argv[sys.argv.index("--") + 1]


def inside(name):
    return os.path.join(folder, name)


def clear():
    bpy.ops.wm.read_factory_settings(use_empty=True)


def get_positions(objects):
    """Positions of all vertices as Blender draws them at the frame that is set."""
    graph = bpy.context.evaluated_depsgraph_get()
    parts = []
    for item in objects:
        evaluated = item.evaluated_get(graph)
        mesh = evaluated.to_mesh()
        values = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", values)
        matrix = np.array(evaluated.matrix_world)
        parts.append(values.reshape(-1, 3).astype(float) @ matrix[:3, :3].T + matrix[:3, 3])
        evaluated.to_mesh_clear()
    return np.concatenate(parts)


def check_gltf(name, expected, count):
    """Blender turns y up to z up and back, so what it shows is what the run has."""
    clear()
    archive = np.load(inside(expected))
    # Frames of Blender are whole numbers; keys lie on them at this rate.
    bpy.context.scene.render.fps = round(1 / (archive["times"][1] - archive["times"][0]))
    bpy.ops.import_scene.gltf(filepath=inside(name), merge_vertices=False)
    objects = [item for item in bpy.data.objects if item.type == "MESH"]
    objects.sort(key=lambda item: list(archive["names"]).index(item.name))
    assert len(objects) == count, [item.name for item in objects]
    worst = 0.0
    for frame, positions in enumerate(archive["positions"]):
        bpy.context.scene.frame_set(frame)
        worst = max(worst, np.abs(get_positions(objects) - positions).max())
    assert worst < 1e-6, (name, worst)
    print(f"{name}: {len(objects)} objects, {len(archive['times'])} frames, at most {worst:.2g} m off")


def check_cache(name, kind):
    clear()
    positions = np.load(inside("sheet.npz"))["positions"]
    bpy.ops.wm.obj_import(filepath=inside("sheet.obj"), forward_axis="Y", up_axis="Z")
    item = bpy.context.selected_objects[0]
    modifier = item.modifiers.new("cache", "MESH_CACHE")
    modifier.cache_format = kind
    modifier.filepath = inside(name)
    for frame, expected in enumerate(positions):
        bpy.context.scene.frame_set(frame)
        found = get_positions([item])
        assert np.array_equal(found.astype(np.float32), expected), (name, frame, np.abs(found - expected).max())
    print(f"{name}: the same floats in {len(positions)} frames")


try:
    check_gltf("sheet.glb", "sheet.npz", 1)
    check_gltf("falls.glb", "falls.npz", 5)
    check_cache("sheet.mdd", "MDD")
    check_cache("sheet.pc2", "PC2")
    print("Blender reads the same numbers")
except BaseException:
    traceback.print_exc()
    sys.exit(1)
