"""Blender's own cloth beside Tulle, in the same files: each scene is simulated by Blender, taken over by the add-on, and baked.

    xvfb-run -a blender -b --factory-startup --threads 1 --python blender/compare.py -- FOLDER [--frames N] [--side N] [SCENE ...]

TULLE names the program. FOLDER gets SCENE.blend, SCENE.png with both side by side, and table.md; what is there already of a scene is
not made again. Both run on one thread. Meshes are those of scenes/SCENE.yaml as they start, and obstacles stand still.

Blender's cloth has its factory values but for what CLOTH says. Each frame is judged against the obstacles and itself; faces that
intersect something are red in the pictures. Workbench, which draws them, needs a display.
"""
import argparse
import json
import os
import resource
import subprocess
import sys
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
sys.dont_write_bytecode = True

import addon_utils  # noqa: E402
import bpy  # noqa: E402
import numpy as np  # noqa: E402
from mathutils import Vector  # noqa: E402

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
TULLE = os.path.abspath(os.environ.get("TULLE", os.path.join(ROOT, "build/release/tulle")))
SCENES = ("sphere", "needles", "spikes")
# What an artist would raise first; distances are those that Tulle keeps.
QUALITY, COLLISION_QUALITY, DISTANCE = 10, 5, 0.005
SIZE = (360, 300)  # [px] of a picture
GRAY, BLUE, GREEN, RED = (0.5, 0.5, 0.5, 1), (0.25, 0.4, 0.75, 1), (0.3, 0.6, 0.4, 1), (0.9, 0.05, 0.03, 1)


def run(*arguments):
    done = subprocess.run([TULLE, *arguments], capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        sys.exit(done.stderr)
    return done.stdout


def read_mesh(path):
    from tulle_addon import meshes

    with open(path, encoding="ascii") as file:
        points = [[float(word) for word in line.split()[1:4]] for line in file if line.startswith("v ")]
    return np.array(points), meshes.read_obj_faces(path)


def add_object(name, points, faces, color):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points.tolist(), [], faces.tolist())
    added = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(added)
    for each in (color, RED):
        material = bpy.data.materials.new(name)
        material.diffuse_color = each
        mesh.materials.append(material)
    return added


def make_file(folder, name, frames, side):
    """The objects of a scene, with Blender's cloth and colliders; the faces of the cloth."""
    start = os.path.join(folder, name + ".start")
    run("run", os.path.join(ROOT, "scenes", name + ".yaml"), "-o", start, "-n", "1", "--force" if os.path.exists(start) else "--resume",
        "--progress", "none", "--set", "cloth[0].mesh.resolution=[%d, %d]" % (side, side))  # fmt: skip
    with open(os.path.join(start, "run.json"), encoding="utf-8") as file:
        bodies = json.load(file)["bodies"]
    bpy.ops.wm.read_factory_settings(use_empty=True)
    addon_utils.enable("tulle_addon", default_set=True)
    bpy.context.preferences.addons["tulle_addon"].preferences.program = TULLE
    scene = bpy.context.scene
    scene.render.fps, scene.frame_start, scene.frame_end = 24, 1, frames + 1
    scene.tulle.threads = 1
    points, faces, count = [], [], 0
    for body in bodies:
        places, corners = read_mesh(os.path.join(start, body["mesh"]))
        if body["role"] == "cloth":
            cloth = add_object("cloth", places, corners, BLUE)
            cloth_faces = corners
            continue
        points.append(places), faces.append(corners + count)
        count += len(places)
    obstacles = add_object("obstacles", np.concatenate(points), np.concatenate(faces), GRAY)
    obstacles.modifiers.new("Collision", "COLLISION")
    obstacles.collision.thickness_outer = DISTANCE
    modifier = cloth.modifiers.new("Cloth", "CLOTH")
    modifier.settings.quality = QUALITY
    contact = modifier.collision_settings
    contact.collision_quality, contact.use_self_collision = COLLISION_QUALITY, True
    contact.distance_min = contact.self_distance_min = DISTANCE
    modifier.point_cache.frame_start, modifier.point_cache.frame_end = 1, frames + 1
    bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, name + ".blend"))
    return cloth, obstacles, cloth_faces


def see(cloth):
    from tulle_addon import meshes

    evaluated = cloth.evaluated_get(bpy.context.evaluated_depsgraph_get())
    places = meshes.read_positions(evaluated.to_mesh()).astype(np.float64)
    evaluated.to_mesh_clear()
    return places


def play(cloth):
    """All frames, from the first on."""
    scene = bpy.context.scene
    frames = []
    for frame in range(scene.frame_start, scene.frame_end + 1):
        scene.frame_set(frame)
        frames.append(see(cloth))
    return frames


def judge(folder, frames, faces, obstacle_file):
    """Of all frames: pairs of triangles that intersect; faces of the last one that do."""
    from tulle_addon import meshes

    path, counts, red = os.path.join(folder, "frame.obj"), [], set()
    for places in frames:
        meshes.write_obj(path, places, faces)
        told = json.loads(run("check", path, "--obstacle", obstacle_file, "--json", "-t", "1").splitlines()[0])
        counts.append(told["intersections"])
        red = {pair["triangle_a"] for pair in told["pairs"]}
        red |= {pair["triangle_b"] for pair in told["pairs"] if pair["b"] == path}
    os.remove(path)
    return counts, red


def render(path, shown, red):
    """A mesh beside the obstacles by Workbench, faces of `red` in red."""
    scene = bpy.context.scene
    for polygon in shown.data.polygons:
        polygon.material_index, polygon.use_smooth = int(polygon.index in red), True
    scene.render.engine, scene.display.shading.light = "BLENDER_WORKBENCH", "STUDIO"
    scene.display.shading.color_type, scene.display.shading.show_shadows = "MATERIAL", True
    scene.display.shading.show_cavity = True
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = SIZE[0], SIZE[1], 100
    scene.render.image_settings.file_format, scene.render.image_settings.color_mode = "PNG", "RGB"
    scene.view_settings.view_transform = "Standard"
    if scene.camera is None:
        camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        scene.collection.objects.link(camera)
        camera.location = (2.0, -2.9, 2.1)
        middle = Vector((0.0, 0.0, 0.45))
        camera.rotation_euler = (middle - camera.location).to_track_quat("-Z", "Y").to_euler()
        scene.camera = camera
        world = bpy.data.worlds.new("world")
        world.color, scene.world = (1, 1, 1), world
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)


def join_pictures(paths, path):
    """Side by side."""
    loaded = [bpy.data.images.load(each) for each in paths]
    pixels = [np.array(each.pixels[:], np.float32).reshape(each.size[1], each.size[0], 4) for each in loaded]
    joined = np.concatenate(pixels, axis=1)
    image = bpy.data.images.new("pair", joined.shape[1], joined.shape[0])
    image.pixels.foreach_set(joined.ravel())
    image.filepath_raw, image.file_format = path, "PNG"
    image.save()
    for each in paths:
        os.remove(each)


def compare(folder, name, frames, side):
    """A row of the table; the picture."""
    from tulle_addon import meshes

    cloth, obstacles, faces = make_file(folder, name, frames, side)
    obstacle_file = os.path.join(folder, name + ".obstacles.obj")
    meshes.write_obj(obstacle_file, meshes.read_positions(obstacles.data),
                     np.array([polygon.vertices[:] for polygon in obstacles.data.polygons]))  # fmt: skip
    begin = time.process_time()
    theirs = play(cloth)
    seconds = [time.process_time() - begin]

    bpy.context.view_layer.objects.active = cloth
    cloth.select_set(True)
    if bpy.ops.tulle.convert() != {"FINISHED"}:
        sys.exit(bpy.context.scene.tulle.report)
    begin = time.process_time() + resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    if bpy.ops.tulle.bake() != {"FINISHED"}:
        sys.exit(bpy.context.scene.tulle.report)
    seconds.append(time.process_time() + resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - begin)
    bpy.ops.wm.save_mainfile()
    ours = play(cloth)

    told, pictures = [], []
    cloth.hide_render = True
    for label, places, color in (("blender", theirs, BLUE), ("tulle", ours, GREEN)):
        counts, red = judge(folder, places, faces, obstacle_file)
        told.append({"pairs": counts[-1], "most": max(counts), "frames": sum(count > 0 for count in counts)})
        shown = add_object(label, places[-1], faces, color)
        pictures.append(os.path.join(folder, "%s.%s.png" % (name, label)))
        render(pictures[-1], shown, red)
        shown.hide_render = True
    join_pictures(pictures, os.path.join(folder, name + ".png"))
    return {"scene": name, "fabric": cloth.tulle.fabric, "blender": told[0], "tulle": told[1], "seconds": seconds, "frames": frames,
            "vertices": len(theirs[0]), "version": bpy.app.version_string}  # fmt: skip


def write_table(path, rows):
    lines = ["| scene | Blender: time | pairs at the end | most | frames with pairs | Tulle: time | pairs in all frames |",
             "|---|---|---|---|---|---|---|"]  # fmt: skip
    for row in rows:
        theirs, ours = row["blender"], row["tulle"]
        lines.append("| %s | %.0f s | %d | %d | %d of %d | %.0f s | %d |" % (
            row["scene"], row["seconds"][0], theirs["pairs"], theirs["most"], theirs["frames"], row["frames"] + 1,
            row["seconds"][1], ours["most"]))  # fmt: skip
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")
    print("\n".join(lines))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder")
    parser.add_argument("scenes", nargs="*", default=SCENES)
    parser.add_argument("--frames", type=int, default=36)
    parser.add_argument("--side", type=int, default=41, help="vertices along a side of the cloth")
    options = parser.parse_intermixed_args(sys.argv[sys.argv.index("--") + 1 :])
    folder = os.path.abspath(options.folder)
    os.makedirs(folder, exist_ok=True)
    rows = []
    for name in options.scenes:
        path = os.path.join(folder, name + ".json")
        if not os.path.exists(path):
            addon_utils.enable("tulle_addon", default_set=True)
            row = compare(folder, name, options.frames, options.side)
            with open(path, "w", encoding="utf-8") as file:
                json.dump(row, file)
        with open(path, encoding="utf-8") as file:
            rows.append(json.load(file))
    write_table(os.path.join(folder, "table.md"), rows)


main()
