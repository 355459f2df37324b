"""Bakes: what is shown is what was run, and goes on to the same bits."""
import os
import signal
import time

import bpy
import numpy as np

from support import SceneTest
from tulle_addon import bake, caches, meshes, stack


class Bakes(SceneTest):
    frames = 12

    def test_sheet_on_a_ball(self):
        sheet, _ = self.add_sheet(), self.add_ball()
        sheet.modifiers.new("Subdivision", "SUBSURF")
        sheet.modifiers.new("Solidify", "SOLIDIFY")
        self.bake_all()
        self.assertEqual([each.type for each in sheet.modifiers], ["MESH_CACHE", "SUBSURF", "SOLIDIFY"])
        self.assertTrue(sheet.modifiers[0].filepath.startswith("//tulle"))
        self.assertTrue(sheet.modifiers["Subdivision"].show_viewport)
        self.judge()
        self.assertGreater(len(self.see(sheet, 12)), 81 * 4)
        for each in list(sheet.modifiers)[1:]:
            each.show_viewport = False
        self.compare(sheet, "sheet")
        frames = self.list_frames("sheet")
        self.assertLess(frames[-1][:, 2].min(), 0.15)
        self.assertGreater(frames[-1][40, 2], 0.24)  # its middle lies on the ball
        said = self.read_scene()
        self.assertAlmostEqual(said["time"]["step"], 1 / 96)
        self.assertEqual(said["time"]["steps_per_frame"], 4)
        self.assertEqual(self.scene.frame_current, 10 + self.frames)  # where the last look left it

    def test_polygons_with_corners_on_straight_sides(self):
        """No triangle lacks area, wherever the polygon begins; the triangles face as it does and cover it."""
        outlines = {
            "pentagon": ([(0, 0), (0.5, 0), (1, 0), (1, 1), (0, 1)], 1.0),
            "triangle": ([(0, 0), (1, 0), (2, 0), (0, 2)], 2.0),
            "three": ([(0, 0), (0.2, 0), (0.5, 0), (0.7, 0), (1, 0), (1, 1)], 0.5),
            "l": ([(0, 0), (1, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2), (0, 1)], 3.0),
        }
        for name, (outline, area) in outlines.items():
            for turn in range(len(outline)):
                mesh = bpy.data.meshes.new(name)
                corners = [(k + turn) % len(outline) for k in range(len(outline))]
                mesh.from_pydata([(x, y, 0.0) for x, y in outline], [], [corners])
                mesh.update()
                found = meshes.read_triangles(mesh)
                a, b, c = (meshes.read_positions(mesh)[found.corners[:, k]].astype(np.float64) for k in range(3))
                parts = np.cross(b - a, c - a)[:, 2] / 2
                self.assertGreater(parts.min(), 0.01, (name, turn))
                self.assertAlmostEqual(parts.sum(), area, places=5)

    def test_turned_scaled_and_mirrored_cloth(self):
        sheet, _ = self.add_sheet(place=(3, 1, 0.4)), self.add_ball(place=(3, 1, 0))
        sheet.rotation_euler, sheet.scale = (0.2, 0.1, 0.7), (0.8, -1.3, 1.0)
        self.bake_all()
        self.compare(sheet, "sheet")
        self.judge()

    def test_same_bits_where_the_object_lies_at_the_origin(self):
        sheet, _ = self.add_sheet(place=(0, 0, 0)), self.add_ball(place=(0, 0, -0.3))
        self.bake_all()
        self.assertEqual(*[open(self.path(folder, "sheet.pc2"), "rb").read() for folder in ("run", "cache")])
        for number, frame in enumerate(self.list_frames("sheet")):
            np.testing.assert_array_equal(self.see(sheet, 10 + number), frame)

    def test_units(self):
        """A scene in centimetres falls as one in metres does."""
        sheet, _ = self.add_sheet(), self.add_ball()
        self.bake_all()
        metres = self.list_frames("sheet")
        bpy.ops.tulle.free()
        for obj in self.scene.objects:
            obj.location *= 100
            obj.scale *= 100
        self.scene.unit_settings.scale_length = 0.01
        self.scene.gravity = (0, 0, -981)
        self.bake_all()
        self.compare(sheet, "sheet")
        centimetres = self.list_frames("sheet")
        off = [np.abs(a - b).max() for a, b in zip(metres, centimetres)]
        self.assertEqual(len(metres), len(centimetres))
        self.assertLess(max(off[:6]), 1e-5)  # the fall and the first contact
        self.assertLess(max(off), 0.03)  # draped cloth makes more of rounding; it goes 0.58 m
        self.scene.gravity = (0, 0, -9.81)
        self.bake_all(restart=True)
        self.assertIn("Gravity is 0.0981", self.scene.tulle.report)

    def test_cancel_and_resume(self):
        sheet, _ = self.add_sheet(cells=16), self.add_ball()
        self.scene.frame_end = 34
        self.bake_all()
        whole = [open(self.path("cache", "sheet.pc2"), "rb").read(), open(self.path("run", "sheet.pc2"), "rb").read()]
        bpy.ops.tulle.free()
        self.assertFalse(os.path.exists(self.path()))
        self.assertEqual(len(sheet.modifiers), 0)
        under_way = bake.Bake(bpy.context)
        while not under_way.is_over:
            under_way.advance(bpy.context)
            if under_way.caches and under_way.caches.frame_count >= 3 and not under_way.is_cancelled:
                self.assertEqual(sheet.modifiers[0].type, "MESH_CACHE")  # shown while it grows
                under_way.cancel()
        self.assertEqual(under_way.state, "CANCELLED")
        held = meshes.Pc2Reader(self.path("cache", "sheet.pc2")).count_frames()
        self.assertTrue(3 <= held < 25, held)
        self.bake_all()
        self.assertEqual(
            whole, [open(self.path("cache", "sheet.pc2"), "rb").read(), open(self.path("run", "sheet.pc2"), "rb").read()]
        )

    def test_killed(self):
        """A bake whose program and Blender die leaves a whole cache, and goes on."""
        self.add_sheet(cells=16), self.add_ball()
        under_way = bake.Bake(bpy.context)
        while not (under_way.caches and under_way.caches.frame_count >= 3):
            under_way.advance(bpy.context)
        under_way.process._process.kill()
        while under_way.process.get_code() is None:
            time.sleep(0.01)
        with open(self.path("cache", "sheet.pc2"), "ab") as file:
            file.write(b"half a frame")
        reader = meshes.Pc2Reader(self.path("cache", "sheet.pc2"))
        for frame in range(reader.count_frames()):
            self.assertTrue(np.isfinite(reader.read(frame)).all())
        self.bake_all()
        self.compare(self.scene.objects["sheet"], "sheet")

    def test_narrow_start_is_told(self):
        self.add_sheet(place=(0, 0, 2e-4))
        self.add_mesh("table", [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [(0, 1, 2, 3)], role="OBSTACLE")
        self.bake_all()
        self.assertIn("'sheet' lies 0.2 mm from 'table'", self.scene.tulle.report)
        self.assertIn("a thickness of 0.2 mm", self.scene.tulle.report)

    def test_full_disk(self):
        """A cache that cannot be written ends the bake, and stays whole up to its last frame."""
        self.add_sheet(cells=16), self.add_ball()
        usual = meshes.Pc2Writer.append

        def append(writer, positions):
            if os.path.basename(os.path.dirname(writer.path)) == "cache" and writer.frame_count == 2:
                raise OSError(28, "No space left on device")
            usual(writer, positions)

        meshes.Pc2Writer.append = append
        under_way = bake.Bake(bpy.context)
        try:
            while not under_way.is_over:
                under_way.advance(bpy.context)
        finally:
            meshes.Pc2Writer.append = usual
        reader = meshes.Pc2Reader(self.path("cache", "sheet.pc2"))
        self.assertEqual(under_way.state, "FAILED")
        self.assertIn("No space left", self.scene.tulle.report)
        self.assertEqual(reader.count_frames(), 2)
        self.bake_all()
        self.compare(self.scene.objects["sheet"], "sheet")

    def test_changed_scene_asks(self):
        self.add_sheet(), self.add_ball()
        self.bake_all()
        self.scene.objects["ball"].location.x = 0.1
        self.assertEqual(self.bake(), {"CANCELLED"})
        self.assertEqual(self.scene.tulle.state, "CHANGED")
        self.bake_all(restart=True)
        self.judge()

    def test_from_frame(self):
        """Frames up to the present one stay to the bit; those behind it follow the settings as they are now."""
        sheet, ball = self.add_sheet(cells=16, place=(0, 0, 0.27)), self.add_ball()
        self.scene.frame_end = 18
        self.bake_all()
        before = self.list_frames("sheet")
        sheet.tulle.fabric, sheet.tulle.use_friction, sheet.tulle.friction = "silk", True, 0.05
        ball.location, ball.rotation_mode = (0, 0, 0), "XYZ"
        ball.keyframe_insert("location", frame=14)
        ball.location.z = 0.05
        ball.keyframe_insert("location", frame=18)
        self.scene.frame_set(14)
        self.bake_all(from_frame=True)
        self.assertEqual(self.scene.frame_current, 14)
        after = self.list_frames("sheet")
        self.assertEqual(len(after), len(before))
        self.assertTrue(all(np.array_equal(a, b) for a, b in zip(before[:5], after[:5])))
        self.assertFalse(np.array_equal(before[5], after[5]))
        self.assertLess(np.abs(before[5] - after[5]).max(), 0.05)  # it goes on as it moved
        self.compare(sheet, "sheet")
        self.judge()
        self.assertFalse(os.path.exists(self.path("run.before")))
        self.bake_all()  # all is there
        self.assertTrue(all(np.array_equal(a, b) for a, b in zip(after, self.list_frames("sheet"))))
        bpy.ops.tulle.free()
        self.assertFalse(os.path.exists(self.path()))

    def test_from_frame_with_bodies(self):
        """Rigid bodies go on as they moved, also in finer steps."""
        sheet, _ = self.add_sheet(cells=16, place=(0, 0, 0.3)), self.add_ball()
        box = self.add_ball("box", 0.1, (0.1, 0, 0.6), "BODY")
        self.scene.frame_end = 18
        self.bake_all()
        before = {name: self.list_frames(name) for name in ("sheet", "box")}
        sheet.tulle.fabric, self.scene.tulle.substeps = "silk", 7
        self.scene.frame_set(14)
        self.bake_all(from_frame=True)
        for name, frames in before.items():
            after = self.list_frames(name)
            self.assertEqual(len(after), len(frames))
            self.assertTrue(all(np.array_equal(a, b) for a, b in zip(frames[:5], after[:5])))
            self.assertFalse(np.array_equal(frames[5], after[5]))
            self.assertLess(np.abs(frames[5] - after[5]).max(), 0.02)  # it goes on as it moved
        for obj, name in ((sheet, "sheet"), (box, "box")):
            self.compare(obj, name)
        self.judge()
        self.scene.frame_set(14)
        box.location.x += 0.01
        self.assertEqual(self.bake(from_frame=True), {"CANCELLED"})
        self.assertIn("'box' is no longer the rigid body", self.scene.tulle.report)
        self.assertEqual(len(self.list_frames("box")), len(before["box"]))

    def test_from_frame_cancelled(self):
        """A bake from a frame that was cancelled goes on to the same frames."""
        sheet = self.add_sheet(cells=16)
        self.add_ball()
        self.scene.frame_end = 34
        self.bake_all()
        sheet.tulle.fabric = "silk"
        self.scene.frame_set(12)
        under_way = bake.Bake(bpy.context, from_frame=12)
        while not under_way.is_over:
            under_way.advance(bpy.context)
            if under_way.caches and under_way.caches.frame_count >= 4 and not under_way.is_cancelled:
                under_way.cancel()
        self.assertEqual(under_way.state, "CANCELLED")
        self.assertFalse(os.path.exists(self.path("run.before")))
        self.bake_all()
        cancelled = self.list_frames("sheet")
        sheet.tulle.fabric = "cotton"
        self.bake_all(restart=True)
        sheet.tulle.fabric = "silk"
        self.bake_all(from_frame=True)
        self.assertTrue(all(np.array_equal(a, b) for a, b in zip(cancelled, self.list_frames("sheet"))))
        self.compare(sheet, "sheet")

    def test_from_frame_refused(self):
        """A refusal leaves the frames that were there."""
        self.assertEqual(self.bake(from_frame=True), {"CANCELLED"})
        self.add_sheet(cells=16), self.add_ball()
        self.assertEqual(self.bake(from_frame=True), {"CANCELLED"})
        self.assertIn("nothing to go on from", self.scene.tulle.report)
        self.bake_all()
        before = self.list_frames("sheet")
        self.scene.frame_set(22)
        self.assertEqual(self.bake(from_frame=True), {"CANCELLED"})
        self.assertIn("from 10 to 21", self.scene.tulle.report)
        self.scene.frame_set(13)
        self.scene.objects["ball"].location.z = 0.15  # into the cloth
        self.assertEqual(self.bake(from_frame=True), {"CANCELLED"})
        self.assertIn("intersect", self.scene.tulle.report)
        self.scene.frame_set(13)
        self.scene.render.fps = 25
        self.scene.objects["ball"].location.z = 0.0
        self.assertEqual(self.bake(from_frame=True), {"CANCELLED"})
        self.assertIn("another frame rate", self.scene.tulle.report)
        self.scene.render.fps = 24
        self.assertTrue(all(np.array_equal(a, b) for a, b in zip(before, self.list_frames("sheet"))))
        self.assertFalse(os.path.exists(self.path("run.before")))
        with open(self.path("run", "frames.csv")) as file:  # as where a body that deforms leaves the cloth no room
            lines = file.read().split("\n")
        lagging = ["%s1:0:0.01:0" % line if line[:1] in ("2", "3") else line for line in lines]
        with open(self.path("run", "frames.csv"), "w") as file:
            file.write("\n".join(lagging))
        self.assertEqual(self.bake(from_frame=True), {"CANCELLED"})
        self.assertIn("in frame 13, and cannot be gone on from there: choose another one, as frame 14", self.scene.tulle.report)
        with open(self.path("run", "frames.csv"), "w") as file:
            file.write("\n".join(lines))
        # Blender ended right after the run was put aside.
        caches.put_aside(self.path())
        self.bake_all()
        self.assertTrue(all(np.array_equal(a, b) for a, b in zip(before, self.list_frames("sheet"))))

    def test_stiffness_group(self):
        """Weights become factors; the stiff side of a sheet that is held along its middle hangs less."""
        sheet = self.add_sheet(cells=16)
        sheet.vertex_groups.new(name="pins").add([v.index for v in sheet.data.vertices if abs(v.co.x) < 0.32], 1.0, "REPLACE")
        stiff = sheet.vertex_groups.new(name="stiff")
        for vertex in sheet.data.vertices:
            if vertex.co.x > 0:
                stiff.add([vertex.index], min(1.0, 4.0 * vertex.co.x), "REPLACE")
        values = sheet.tulle
        values.fabric = "denim"
        values.pin_group, values.stiffness_group, values.stiffness_from, values.stiffness_to = "pins", "stiff", 0.5, 100.0
        self.scene.frame_end = 30
        self.bake_all()
        file = self.read_scene()["cloth"][0]["stiffness_file"]
        factors = np.loadtxt(self.path(*file.split("/")))
        places = np.array([v.co for v in sheet.data.vertices])
        wanted = 0.5 + 99.5 * np.clip(4.0 * places[:, 0], 0.0, 1.0)
        self.assertLess(np.abs(factors / wanted - 1).max(), 1e-6)
        last = self.list_frames("sheet")[-1]
        left, right = last[places[:, 0] < -0.49][:, 2].mean(), last[places[:, 0] > 0.49][:, 2].mean()
        self.assertGreater(right, left + 0.05)
        values.stiffness_group = "none"
        self.refuse("no vertex group 'none'", "stiffness")

    def test_longer_range_goes_on(self):
        sheet, _ = self.add_sheet(), self.add_ball()
        self.bake_all()
        before = self.list_frames("sheet")
        self.scene.frame_end += 4
        self.bake_all()
        after = self.list_frames("sheet")
        self.assertEqual(len(after), len(before) + 4)
        self.assertTrue(all(np.array_equal(a, b) for a, b in zip(before, after)))
        self.compare(sheet, "sheet")

    def test_pinched(self):
        """Where the program cannot go on, what is baked is kept and its words are told."""
        sheet = self.add_sheet(cells=6, place=(0, 0, 0))
        self.scene.use_gravity = False
        for name, sign in (("above", 1), ("below", -1)):
            bpy.ops.mesh.primitive_cube_add(size=0.6, location=(0, 0, 0.4 * sign))
            box = bpy.context.object
            box.name, box.tulle.role = name, "OBSTACLE"
            for frame, place in ((10, 0.4), (18, 0.29)):
                box.location.z = place * sign
                box.keyframe_insert("location", frame=frame)
        self.assertEqual(self.bake(), {"CANCELLED"})
        self.assertEqual(self.scene.tulle.state, "FAILED")
        self.assertIn("above", self.scene.tulle.report)
        self.assertIn("Stopped after", self.scene.tulle.status)
        self.assertGreater(meshes.Pc2Reader(self.path("cache", "sheet.pc2")).count_frames(), 3)
        self.assertEqual(sheet.modifiers[0].type, "MESH_CACHE")
        self.judge()

    def add_tilted(self, size, above):
        """A tilted triangle of a size [m], and a sheet that lies on it."""
        self.scene.use_gravity = False
        sheet = self.add_sheet(cells=4, size=0.1, place=(0, 0, above))
        sheet.rotation_euler[1] = -np.arctan(0.75)
        sheet.tulle.use_thickness, sheet.tulle.thickness = True, 0.0002
        plane = self.add_mesh("plane", [(1.93, 0.1, 1.4475), (-1.07, 1.7, -0.8025), (-0.86, -1.8, -0.645)], [(0, 1, 2)],
                              role="OBSTACLE")  # fmt: skip
        plane.scale = (size, size, size)
        return sheet, plane

    def test_far_obstacle(self):
        """Floats hold no thin layer on an obstacle of 35 km."""
        self.add_tilted(10000, 0.0003)
        self.refuse("minimum gap", "m from the origin", "Move the scene nearer")

    def test_obstacle_that_grows(self):
        """It is exported as floats: how far these move it is told, and that alone."""
        _, plane = self.add_tilted(1, 0.0003)
        for frame, size in ((10, 1.0), (10 + self.frames, 20000.0)):
            plane.scale = (size, size, size)
            plane.keyframe_insert("scale", frame=frame)
        self.bake_all()
        self.judge()
        self.assertRegex(self.scene.tulle.report, r"'plane': floats of its frames move vertices by 0\.00\d+ m, .*Move the scene")
        self.assertNotIn("'sheet': floats", self.scene.tulle.report)

    def test_beside_another_bake(self):
        """Where a bake of a Blender that died is still running in the folder, that is told."""
        self.add_sheet(cells=16), self.add_ball()
        self.scene.frame_end = 60
        first = bake.Bake(bpy.context)
        while not (first.caches and first.caches.frame_count >= 2):
            first.advance(bpy.context)
        first.process._process.send_signal(signal.SIGSTOP)  # it must not be done before the other begins
        self.assertFalse(first.is_over)
        self.assertEqual(self.bake(), {"CANCELLED"})
        self.assertIn("locked", self.scene.tulle.report)
        first.process._process.send_signal(signal.SIGCONT)
        while not first.is_over:
            first.advance(bpy.context)
        self.assertEqual(first.state, "FINISHED")
        self.bake_all()

    def test_file_saved_while_baking(self):
        self.add_sheet()
        self.scene.tulle.state, self.scene.tulle.status = "RUNNING", "Frame 3 of 5"
        path = os.path.join(self.folder, "saved.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path)
        bpy.ops.wm.open_mainfile(filepath=path)
        self.assertIn("cut short", self.scene.tulle.status)

    def test_other_vertices_in_render(self):
        sheet = self.add_sheet()
        sheet.modifiers.new("Fine", "SUBSURF").render_levels = 2
        sheet.modifiers.new("Wave", "WAVE").show_render = False
        bpy.ops.tulle.export()
        self.assertIn("'Fine' before the cache differs in a render", self.scene.tulle.report)
        self.assertNotIn("Wave", self.scene.tulle.report)

    def test_shorter_range(self):
        self.add_sheet(), self.add_ball()
        self.bake_all()
        self.scene.frame_end -= 4
        self.bake_all()
        self.assertEqual(meshes.Pc2Reader(self.path("cache", "sheet.pc2")).count_frames(), self.frames - 3)

    def test_export_and_import(self):
        import subprocess

        from support import TULLE

        sheet, _ = self.add_sheet(), self.add_ball()
        self.assertEqual(bpy.ops.tulle.export(), {"FINISHED"})
        subprocess.run([TULLE, "run", "scene.yaml", "-o", "run"], cwd=self.path(), check=True, capture_output=True)
        self.assertEqual(bpy.ops.tulle.import_results(), {"FINISHED"})
        self.compare(sheet, "sheet")

    def test_free_keeps_other_files(self):
        self.add_sheet(), self.add_ball()
        self.bake_all()
        with open(self.path("run", "mine.txt"), "w") as file:
            file.write("mine")
        bpy.ops.tulle.free()
        self.assertEqual(os.listdir(self.path()), ["run"])
        self.assertEqual(os.listdir(self.path("run")), ["mine.txt"])

    def test_modifiers_before_and_behind(self):
        sheet, _ = self.add_sheet(place=(0, 0, 0.5)), self.add_ball()
        sheet.modifiers.new("Mirror", "MIRROR").use_axis[0] = False
        sheet.modifiers["Mirror"].use_axis[2] = True
        for vertex in sheet.data.vertices:
            vertex.co.z = 0.1
        cloth = sheet.modifiers.new("Cloth", "CLOTH")
        for kind in ("SUBSURF", "TRIANGULATE"):
            sheet.modifiers.new(kind, kind)
        self.bake_all()
        self.assertEqual([each.type for each in sheet.modifiers], ["MIRROR", "CLOTH", "MESH_CACHE", "SUBSURF", "TRIANGULATE"])
        self.assertFalse(cloth.show_viewport or cloth.show_render)
        self.assertEqual(len(self.list_frames("sheet")[0]), 2 * 81)
        sheet.modifiers["SUBSURF"].show_viewport = sheet.modifiers["TRIANGULATE"].show_viewport = False
        self.compare(sheet, "sheet")
        bpy.ops.tulle.free()
        self.assertTrue(cloth.show_viewport and cloth.show_render)
        self.assertIsNone(caches.find_modifier(sheet))

    def test_tail(self):
        class Kind:
            def __init__(self, kind):
                self.type = kind

        for kinds, begin in (
            ([], 0), (["SUBSURF"], 0), (["ARMATURE"], 1), (["TRIANGULATE"], 1), (["SUBSURF", "ARMATURE"], 2),
            (["MIRROR", "TRIANGULATE", "SUBSURF", "TRIANGULATE", "SOLIDIFY"], 2),
        ):  # fmt: skip
            self.assertEqual(stack.find_tail([Kind(kind) for kind in kinds]), begin, kinds)
