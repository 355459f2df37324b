"""Runs a case of bench-peers in Blender: blender -b --factory-startup --threads 1 --python blender_driver.py -- CASE OUTPUT

CASE is a text file of `key value` lines as run.py writes it; OUTPUT gets told.txt and frames.raw (see run.py).
Settings are paths of attributes: `set settings.quality 5` of the cloth, `set collision_settings...` of its contact, `set collider...`
of every obstacle's, `set collider.cloth_friction scaled 100` is a factor on the friction of each obstacle, `set scene.gravity 15.7`
is told instead of the case's.
"""
import array
import sys
import time

import bpy

CASE, OUTPUT = sys.argv[sys.argv.index("--") + 1 :]


def read_case():
    case = {"obstacle": [], "set": []}
    with open(CASE, encoding="utf-8") as file:
        for line in file:
            key, value = line.rstrip("\n").split(" ", 1)
            if isinstance(case.get(key), list):
                case[key].append(value.split(" "))
            else:
                case[key] = value
    return case


def add_mesh(name, path):
    vertices, faces = [], []
    with open(path, encoding="utf-8") as file:
        for line in file:
            words = line.split()
            if words[:1] == ["v"]:
                vertices.append([float(word) for word in words[1:4]])
            elif words[:1] == ["f"]:
                faces.append([int(word) - 1 for word in words[1:4]])
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    added = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(added)
    return added


def apply_setting(owner, attribute, value):
    kind = type(getattr(owner, attribute))
    setattr(owner, attribute, value == "1" if kind is bool else kind(float(value)))


def add_obstacles(case):
    for number, (path, friction) in enumerate(case["obstacle"]):
        obstacle = add_mesh(f"obstacle{number}", path)
        obstacle.modifiers.new("collision", "COLLISION")
        for name, *value in case["set"]:
            if name.startswith("collider."):
                factor = float(friction) if value[0] == "scaled" else 1.0
                apply_setting(obstacle.collision, name.split(".")[1], str(factor * float(value[-1])))


def add_cloth(case):
    cloth = add_mesh("cloth", case["cloth"])
    modifier = cloth.modifiers.new("cloth", "CLOTH")
    for name, *value in case["set"]:
        group, attribute = name.split(".")
        if group in ("settings", "collision_settings"):
            apply_setting(getattr(modifier, group), attribute, value[0])
    modifier.point_cache.frame_start, modifier.point_cache.frame_end = 1, int(case["frames"]) + 1
    return cloth


def get_positions(cloth):
    mesh = cloth.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    positions = [0.0] * (3 * len(mesh.vertices))
    mesh.vertices.foreach_get("co", positions)
    return positions


def main():
    case = read_case()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    gravity = [value[0] for name, *value in case["set"] if name == "scene.gravity"] or [case["gravity"]]
    scene.gravity = (0, 0, -float(gravity[0]))
    scene.render.fps, scene.render.fps_base = round(1 / float(case["interval"])), 1
    scene.frame_start, scene.frame_end = 1, int(case["frames"]) + 1
    add_obstacles(case)
    cloth = add_cloth(case)
    with open(OUTPUT + "/told.txt", "w", encoding="utf-8") as told, open(OUTPUT + "/frames.raw", "wb") as raw:
        told.write(f"version {bpy.app.version_string}\n")
        scene.frame_set(1)
        array.array("f", get_positions(cloth)).tofile(raw)
        told.write("frame 0 0\n")
        start = time.process_time()
        for frame in range(1, int(case["frames"]) + 1):
            scene.frame_set(frame + 1)
            positions = get_positions(cloth)
            cpu = time.process_time() - start
            array.array("f", positions).tofile(raw)
            raw.flush()
            told.write(f"frame {frame * float(case['interval']):.9f} {cpu:.3f}\n")
            told.flush()
            if cpu > float(case["limit"]):
                break


main()
