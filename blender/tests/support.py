"""A scene for each test, in a folder of its own, and what tests look at."""
import json
import os
import shutil
import subprocess
import tempfile
import unittest

import addon_utils
import bpy
import numpy as np

from tulle_addon import caches, meshes

TULLE = os.path.abspath(os.environ.get("TULLE", "build/release/tulle"))


class SceneTest(unittest.TestCase):
    """An empty, saved file with the add-on on."""

    frames = 5

    def setUp(self):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.assertIsNotNone(addon_utils.enable("tulle_addon", default_set=True))
        bpy.context.preferences.addons["tulle_addon"].preferences.program = TULLE
        self.folder = tempfile.mkdtemp(prefix="tulle_blender_")
        self.addCleanup(shutil.rmtree, self.folder, True)
        bpy.ops.wm.save_as_mainfile(filepath=os.path.join(self.folder, "file.blend"))
        self.scene.frame_start, self.scene.frame_end = 10, 10 + self.frames
        self.scene.render.fps, self.scene.tulle.threads = 24, 1
        self.scene.frame_set(10)

    @property
    def scene(self):
        return bpy.context.scene

    def path(self, *names):
        return os.path.join(self.folder, "tulle_file", *names)

    def add_sheet(self, name="sheet", cells=8, size=1.0, place=(0, 0, 0.3)):
        bpy.ops.mesh.primitive_grid_add(x_subdivisions=cells, y_subdivisions=cells, size=size, location=place)
        sheet = bpy.context.object
        sheet.name, sheet.tulle.role = name, "CLOTH"
        return sheet

    def add_ball(self, name="ball", radius=0.25, place=(0, 0, 0), role="OBSTACLE"):
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=radius, location=place)
        ball = bpy.context.object
        ball.name, ball.tulle.role = name, role
        return ball

    def add_mesh(self, name, points, faces, edges=(), role="CLOTH"):
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata(points, edges, faces)
        added = bpy.data.objects.new(name, mesh)
        self.scene.collection.objects.link(added)
        added.tulle.role = role
        bpy.context.view_layer.update()
        return added

    def bake(self, **options):
        try:
            return bpy.ops.tulle.bake(**options)
        except RuntimeError as error:  # an operator that reports an error
            self.words = str(error)
            return {"CANCELLED"}

    def bake_all(self, **options):
        self.assertEqual(self.bake(**options), {"FINISHED"}, self.scene.tulle.report)

    def refuse(self, *words):
        """The bake is refused with these words in its report."""
        self.assertEqual(self.bake(), {"CANCELLED"})
        self.assertEqual(self.scene.tulle.state, "FAILED")
        for word in words:
            self.assertIn(word, self.scene.tulle.report)

    def read_scene(self):
        """scene.yaml, whose values are JSON."""
        said, key = {}, ""
        with open(self.path("scene.yaml"), encoding="utf-8") as file:
            for line in file:
                if line.startswith("  - "):
                    said[key].append(json.loads(line[4:]))
                else:
                    key, value = line.rstrip("\n").split(":", 1)
                    said[key] = json.loads(value) if value else []
        return said

    def list_frames(self, name):
        """Frames of a body in the run, in world space [m]."""
        run = caches.read_json(self.path("run", "run.json"))
        body = next(each for each in run["bodies"] if each["name"] == name)
        reader = meshes.Pc2Reader(self.path("run", body["cache"]))
        return [reader.read(frame) for frame in range(reader.count_frames())]

    def see(self, obj, frame):
        """World positions [m] of what an object evaluates to in a frame."""
        self.scene.frame_set(frame)
        evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
        places = meshes.read_positions(evaluated.to_mesh())
        evaluated.to_mesh_clear()
        return meshes.to_world(places, meshes.get_matrix(evaluated.matrix_world), meshes.get_scale(self.scene))

    def compare(self, obj, name, tolerance=2e-7):
        """What an object shows are the frames of the run, to the roundings of floats."""
        frames = self.list_frames(name)
        self.assertEqual(len(frames), self.scene.frame_end - self.scene.frame_start + 1)
        for number, frame in enumerate(frames):
            seen = self.see(obj, self.scene.frame_start + number)
            extent = max(1.0, float(np.abs(frame).max()))
            self.assertLess(np.abs(seen - frame).max(), tolerance * extent, "frame %d" % number)

    def judge(self):
        """The judge finds no intersection in the run."""
        done = subprocess.run([TULLE, "check", self.path("run")], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def get_selected(self, obj, kind="polygons"):
        if obj.mode == "EDIT":
            obj.update_from_editmode()
        return sorted(each.index for each in getattr(obj.data, kind) if each.select)
