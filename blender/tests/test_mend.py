"""Mend: what passes through something comes back whole, and what is clean as it was."""
import os

import bpy
import numpy as np

from support import SceneTest
from tulle_addon import bake, mend, meshes


class Mends(SceneTest):
    frames = 10

    def add_pushed(self, to=-0.3, **options):
        """A sheet above that shape keys push down to a height, linearly."""
        sheet = self.add_sheet(cells=14, place=(0, 0, 0.4), **options)
        sheet.tulle.role = "NONE"
        sheet.shape_key_add(name="Basis")
        key = sheet.shape_key_add(name="low")
        for point in key.data:
            point.co.z = to - 0.4
        for frame, value in ((10, 0.0), (20, 1.0)):
            key.value = value
            key.keyframe_insert("value", frame=frame)
        return sheet

    def mend(self, obj):
        bpy.context.view_layer.objects.active = obj
        self.assertEqual(bpy.ops.tulle.mend(), {"FINISHED"}, self.scene.tulle.report)

    def check(self, *objects):
        """What the judge says of all frames."""
        for obj in self.scene.objects:
            obj.select_set(obj in objects)
        bpy.ops.tulle.check(whole_range=True)
        if bpy.context.mode != "OBJECT":  # what crosses was selected
            bpy.ops.object.mode_set(mode="OBJECT")
        return self.scene.tulle.status

    def see_all(self, obj):
        return [self.see(obj, frame) for frame in range(10, 21)]

    def test_pushed_through_a_ball(self):
        sheet, ball = self.add_pushed(), self.add_ball()
        sheet.modifiers.new("Subdivision", "SUBSURF")
        self.assertIn("pairs of triangles intersect", self.check(sheet, ball))
        sheet.modifiers["Subdivision"].show_viewport = False
        given = self.see_all(sheet)
        sheet.modifiers["Subdivision"].show_viewport = True
        self.mend(sheet)
        self.assertRegex(self.scene.tulle.report, r"'sheet': .*: up to [1-9]\d* in \d+ frames before, 0 after")
        self.assertRegex(self.scene.tulle.report, r"The largest departure is [1-9].* c?m, in frame \d+ at vertex \d+")
        self.assertEqual([each.name for each in sheet.modifiers], ["Tulle Mended", "Subdivision"])
        self.assertIn("No intersection in 11 frames", self.check(sheet, ball))
        sheet.modifiers["Subdivision"].show_viewport = False
        mended = self.see_all(sheet)
        np.testing.assert_array_equal(mended[0], given[0])
        departures = [np.linalg.norm(a - b, axis=1) for a, b in zip(mended, given)]
        worst = int(np.argmax([each.max() for each in departures]))
        self.assertIn("in frame %d at vertex" % (10 + worst), self.scene.tulle.report)
        colors = np.empty(4 * len(sheet.data.vertices), np.float32)
        sheet.data.color_attributes["departure"].data.foreach_get("color", colors)
        np.testing.assert_allclose(1 - colors[1::4], departures[worst] / departures[worst].max(), atol=1e-4)
        bpy.ops.tulle.free()
        self.assertEqual([each.name for each in sheet.modifiers], ["Subdivision"])
        self.assertFalse(os.path.exists(self.path()))

    def test_far_from_its_origin(self):
        """What floats of the cache do to a mesh that is 3 km from its object's origin is told."""
        sheet, _ = self.add_pushed(), self.add_ball()
        self.mend(sheet)
        self.assertNotIn("floats of its cache", self.scene.tulle.report)
        for block in sheet.data.shape_keys.key_blocks:
            for point in block.data:
                point.co.x += 3000
        sheet.location.x -= 3000
        self.mend(sheet)
        self.assertRegex(self.scene.tulle.report, r"'sheet': floats of its cache move vertices by \S+e-0[45] m, .*Set Origin")

    def test_clean_comes_back(self):
        """Also loose vertices, of an object that turns and is scaled."""
        sheet = self.add_mesh(
            "sheet", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.3, 0.3, 2.0)], [(0, 1, 2, 3)], role="NONE"
        )
        self.add_ball(place=(3, 0, 0))
        sheet.modifiers.new("Wave", "WAVE")
        sheet.scale = (0.7, -1.1, 1.0)
        for frame, angle in ((10, 0.0), (20, 1.0)):
            sheet.rotation_euler.z = angle
            sheet.keyframe_insert("rotation_euler", frame=frame)
        given = self.see_all(sheet)
        self.assertGreater(np.abs(given[5][4] - given[0][4]).max(), 0.01)
        self.mend(sheet)
        self.assertEqual(self.scene.tulle.status, "As it was: nothing intersects")
        self.assertIn("0 before, 0 after", self.scene.tulle.report)
        for mended, before in zip(self.see_all(sheet), given):
            np.testing.assert_array_equal(mended, before)
        self.assertNotIn("departure", sheet.data.color_attributes)

    def test_blenders_cloth(self):
        """Not baked, and without collisions. It runs from its own start; mended again it begins from the given one again."""
        sheet, ball = self.add_sheet(cells=14), self.add_ball(role="NONE")
        ball.modifiers.new("Collision", "COLLISION")
        for key, frame in ((-0.5, 10), (0.3, 20)):  # a ball that comes from below
            ball.location.z = key
            ball.keyframe_insert("location", frame=frame)
        sheet.tulle.role = "NONE"
        cloth = sheet.modifiers.new("Cloth", "CLOTH")
        cloth.collision_settings.use_collision = False
        cloth.point_cache.frame_start = 5
        for frame in range(5, 10):
            self.scene.frame_set(frame)
        given = self.see_all(sheet)
        caught = []
        for _ in range(2):
            self.mend(sheet)
            self.assertFalse(cloth.show_viewport)
            self.assertNotIn("0 before", self.scene.tulle.report)
            self.assertIn("0 after", self.scene.tulle.report)
            caught.append(self.see_all(sheet))
        self.assertIn("No intersection", self.check(sheet, ball))
        np.testing.assert_array_equal(caught[0], caught[1])
        np.testing.assert_allclose(caught[0][0], given[0], atol=1e-6)
        self.assertLess(given[0][:, 2].max(), 0.29)  # it fell before the first frame
        bpy.ops.tulle.free()
        self.assertTrue(cloth.show_viewport)

    def test_blenders_cloth_baked(self):
        """What was baked is what is mended, though the scene would now simulate otherwise."""
        sheet = self.add_sheet(cells=14)
        sheet.tulle.role = "NONE"
        cloth = sheet.modifiers.new("Cloth", "CLOTH")
        sheet.modifiers.new("Subdivision", "SUBSURF").show_viewport = False
        cache = cloth.point_cache
        cache.frame_start, cache.frame_end = 10, 20
        with bpy.context.temp_override(scene=self.scene, active_object=sheet, point_cache=cache):
            bpy.ops.ptcache.bake(bake=True)
        self.assertTrue(cache.is_baked)
        given = self.see_all(sheet)
        self.assertLess(given[-1][:, 2].max(), 0.2)
        self.scene.gravity = (0, 0, 9.81)
        sheet.modifiers["Subdivision"].show_viewport = True
        self.mend(sheet)
        sheet.modifiers["Subdivision"].show_viewport = False
        for mended, before in zip(self.see_all(sheet), given):
            np.testing.assert_array_equal(mended, before)

    def test_deformed_after_a_bake(self):
        sheet, ball = self.add_sheet(cells=14), self.add_ball()
        self.bake_all()
        low = sheet.modifiers.new("Low", "DISPLACE")
        low.direction, low.mid_level = "Z", 0.0
        for frame, low.strength in ((10, 0.0), (20, -0.2)):
            low.keyframe_insert("strength", frame=frame)
        self.assertIn("intersect", self.check(sheet, ball))
        self.mend(sheet)
        self.assertEqual([each.name for each in sheet.modifiers], ["Tulle", "Low", "Tulle Mended"])
        self.assertIn("No intersection", self.check(sheet, ball))
        self.bake_all(restart=True)
        self.assertEqual([each.name for each in sheet.modifiers], ["Tulle", "Low"])

    def test_obstacle_that_deforms_in_centimetres(self):
        self.scene.unit_settings.scale_length = 0.01
        sheet, ball = self.add_sheet(cells=14, size=100.0, place=(0, 0, 20)), self.add_ball(radius=10.0)
        sheet.tulle.role = "NONE"
        ball.shape_key_add(name="Basis")
        key = ball.shape_key_add(name="large")
        for point in key.data:
            point.co *= 3.0
        for frame, value in ((10, 0.0), (20, 1.0)):
            key.value = value
            key.keyframe_insert("value", frame=frame)
        self.mend(sheet)
        self.assertIn("0 after", self.scene.tulle.report)
        self.assertGreater(self.see(sheet, 20)[:, 2].max(), 0.29)
        self.assertIn("No intersection", self.check(sheet, ball))

    def test_names_that_are_alike(self):
        """Each object has a cache of its own."""
        sheets = [self.add_pushed(name=name) for name in ("a sheet", "a_sheet")]
        sheets[1].location.x = 3.0
        self.add_ball()
        for sheet in sheets + sheets:
            self.mend(sheet)
        paths = {bpy.path.abspath(sheet.modifiers[0].filepath) for sheet in sheets}
        self.assertEqual(len(paths), 2)
        for path in paths:
            self.assertTrue(os.path.isfile(path))

    def begin(self, sheet, is_far):
        """A mending that has come so far."""
        bpy.context.view_layer.objects.active = sheet
        job = mend.Mending(bpy.context, sheet)
        while not job.is_over and not is_far(job):
            job.advance(bpy.context)
        self.assertFalse(job.is_over, self.scene.tulle.report)
        return job

    def go_on(self, job):
        while not job.is_over:
            job.advance(bpy.context)

    def list_files(self):
        """Paths and bytes of all that lies in the folder of results."""
        found = {}
        for top, _, names in os.walk(self.path()):
            for name in names:
                with open(os.path.join(top, name), "rb") as file:
                    found[os.path.join(top, name)] = file.read()
        return found

    STAGES = {
        "reading": lambda job: job.reading is not None,
        "running": lambda job: len(job.answers) > 0,
        "writing": lambda job: job.result is not None,
    }

    def test_cancelled(self):
        """Nothing is left where there was nothing, whenever it is cancelled."""
        sheet, _ = self.add_pushed(), self.add_ball()
        for stage, is_far in self.STAGES.items():
            with self.subTest(stage):
                job = self.begin(sheet, is_far)
                self.assertTrue(os.listdir(self.path("mend", "sheet")))
                job.cancel()
                self.go_on(job)
                self.assertEqual((job.state, len(sheet.modifiers)), ("CANCELLED", 0))
                self.assertFalse(os.path.exists(self.path()))

    def test_cancelled_over_a_result(self):
        """The earlier result stays whole, also when Blender is closed or the file is left meanwhile."""
        sheet, ball = self.add_pushed(), self.add_ball()
        self.mend(sheet)
        whole, seen = self.list_files(), self.see_all(sheet)
        self.assertEqual(
            sorted(os.path.relpath(path, self.path("mend", "sheet")) for path in whole),
            ["blender.json", "cache/sheet.pc2", "meshes/sheet.obj"],
        )
        ball.scale = (1.3, 1.3, 1.3)
        for stage, is_far in self.STAGES.items():
            for is_closed in (False, True):
                with self.subTest(stage, is_closed=is_closed):
                    job = self.begin(sheet, is_far)
                    if is_closed:
                        bake.current = job
                        bake.stop()
                    else:
                        job.cancel()
                        self.go_on(job)
                    self.assertEqual(self.list_files(), whole)
                    self.assertEqual(os.listdir(self.path("mend", "sheet")).count("blender.json"), 1)
        np.testing.assert_array_equal(self.see_all(sheet), seen)
        self.mend(sheet)
        self.assertNotEqual(self.list_files(), whole)
        self.assertIn("No intersection", self.check(sheet, ball))

    def test_killed(self):
        """Where Blender was killed, the earlier result is whole, and the next mending and Free clear up."""
        sheet, _ = self.add_pushed(), self.add_ball()
        self.mend(sheet)
        whole = self.list_files()
        for clears in (lambda: self.mend(sheet), bpy.ops.tulle.free):
            job = self.begin(sheet, self.STAGES["running"])
            job.process._process.kill()
            job.process.wait(10)
            left = self.list_files()
            self.assertGreater(len(left), len(whole))
            self.assertEqual({path: left[path] for path in whole}, whole)
            clears()
            self.assertEqual(self.list_files(), whole if os.path.exists(self.path()) else {})
        self.assertFalse(os.path.exists(self.path()))

    def test_full_disk(self):
        """A result that cannot be written leaves the earlier one."""
        sheet, ball = self.add_pushed(), self.add_ball()
        self.mend(sheet)
        whole = self.list_files()
        ball.scale = (1.3, 1.3, 1.3)
        usual = meshes.Pc2Writer.append

        def append(writer, positions):
            if os.path.basename(writer.path) == mend.CACHE_FILE and writer.frame_count == 2:
                raise OSError(28, "No space left on device")
            usual(writer, positions)

        meshes.Pc2Writer.append = append
        try:
            with self.assertRaisesRegex(RuntimeError, "No space left"):
                self.mend(sheet)
        finally:
            meshes.Pc2Writer.append = usual
        self.assertEqual(self.list_files(), whole)

    def refuse(self, sheet, *words):
        bpy.context.view_layer.objects.active = sheet
        self.assertRaisesRegex(RuntimeError, "Not mended", bpy.ops.tulle.mend)
        self.assertEqual(self.scene.tulle.state, "FAILED")
        for word in words:
            self.assertIn(word, self.scene.tulle.report)
        self.assertFalse(os.path.exists(self.path()))

    def test_inside_a_body(self):
        """The vertex that the program names is selected, behind a loose one and below a modifier."""
        sheet = self.add_mesh(
            "a sheet", [(9, 9, 9), (0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(1, 2, 3, 4)], role="NONE"
        )
        sheet.modifiers.new("Wave", "WAVE").height = 0.01
        sheet.modifiers.new("Subdivision", "SUBSURF")
        bpy.ops.mesh.primitive_cube_add(size=8.0)
        bpy.context.object.tulle.role = "OBSTACLE"
        self.refuse(sheet, "frame 10: 'a_sheet' lies inside 'Cube' at the start (vertex 0")
        self.assertEqual((sheet.mode, self.scene.frame_current), ("EDIT", 10))
        self.assertEqual(self.get_selected(sheet, "vertices"), [1])
        self.assertEqual([each.name for each in sheet.data.attributes if "tulle" in each.name], [])

    def test_zero_area(self):
        """The face is selected that the program names, through a modifier that mirrors."""
        sheet = self.add_mesh(
            "flat", [(0, 0, 0), (1, 0, 0), (0, 1, 0), (2, 0, 0), (3, 0, 0)], [(0, 1, 2), (1, 3, 4)], role="NONE"
        )
        mirror = sheet.modifiers.new("Mirror", "MIRROR")
        mirror.use_axis[0], mirror.use_axis[1], mirror.use_mirror_merge = False, True, False
        self.add_ball(place=(0, 0, 4))
        self.refuse(sheet, "'flat': frame 10: triangle", "zero area")
        self.assertEqual((sheet.mode, self.get_selected(sheet)), ("EDIT", [1]))
        self.assertTrue(self.scene.tulle.report.startswith("flat, frame 10: face 1 has no area\n"), self.scene.tulle.report)

    def test_face_of_a_body(self):
        """It is told and selected, but the cloth stays the active object: Mend, pressed again, means the cloth."""
        sheet, body = self.add_pushed(), self.add_ball(name="the body")
        body.data.polygons.foreach_set("select", [False] * len(body.data.polygons))
        job = self.begin(sheet, self.STAGES["running"])
        job.fail(
            bpy.context, "meshes/sheet.pc2: frame 4: meshes/the_body.obj: triangle 157 (vertices 1, 2, 3) has zero area", [], 3
        )
        job.clear()
        self.assertTrue(self.scene.tulle.report.startswith("the body, frame 14: face 157 has no area\n"), self.scene.tulle.report)
        self.assertEqual((sheet.mode, body.mode, bpy.context.view_layer.objects.active), ("OBJECT", "OBJECT", sheet))
        self.assertEqual((body.select_get(), self.get_selected(body)), (True, [157]))

    def test_turned_face(self):
        sheet = self.add_mesh(
            "turned", [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0), (2, 0, 0)], [(0, 1, 2), (1, 2, 3), (1, 4, 3)], role="NONE"
        )
        self.refuse(sheet, "oriented in opposite ways")
        self.assertEqual((sheet.mode, self.get_selected(sheet)), ("EDIT", [0, 1]))

    def test_body_that_changes_its_vertices(self):
        sheet, ball = self.add_pushed(), self.add_ball(place=(0, 0, -3))
        build = ball.modifiers.new("Build", "BUILD")
        build.frame_start, build.frame_duration = 5, 20
        self.refuse(sheet, "'ball' has", "vertices in frame")
        self.assertTrue(ball.select_get())

    def test_words(self):
        """Files and frames of the cache are named as in the scene."""
        sheet, _ = self.add_pushed(), self.add_ball()
        job = self.begin(sheet, self.STAGES["reading"])
        names = {"sheet", "ball"}
        for said, told, frame in (
            ("meshes/sheet.pc2: frame 2: the cloth finds no way to where it is given in 32 solves",
             "'sheet': frame 12: the cloth finds no way to where it is given in 32 solves", 12),
            ("meshes/sheet.pc2: frame 0: meshes/ball.obj: triangle 12 has the same three vertices as triangle 0",
             "frame 10: 'ball': triangle 12 has the same three vertices as triangle 0", 10),
            ("meshes/sheet.pc2: frame 3: 'the cloth' lies inside 'meshes/ball.obj' (vertex 0)",
             "frame 13: 'sheet' lies inside 'ball' (vertex 0)", 13),
            ("mended.pc2: cannot be written: No space left on device",
             "mended.pc2: cannot be written: No space left on device", 10),
        ):  # fmt: skip
            self.assertEqual(job.translate(said, names), (told, frame))
        job.end()

    def test_no_way(self):
        """A frame that cannot be mended is shown, with the cloth selected."""
        sheet, ball = self.add_pushed(), self.add_ball()
        job = self.begin(sheet, self.STAGES["running"])
        job.fail(bpy.context, "meshes/sheet.pc2: frame 4: the cloth finds no way to where it is given in 32 solves", [], 3)
        job.clear()
        self.assertEqual((job.state, self.scene.frame_current), ("FAILED", 14))
        self.assertEqual((sheet.select_get(), ball.select_get(), sheet.mode), (True, False, "OBJECT"))
