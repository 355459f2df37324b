"""Mend: what passes through something comes back whole, and what is clean as it was."""
import os

import bpy
import numpy as np

from support import SceneTest
from tulle_addon import mend


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

    def test_cancelled_and_refused(self):
        sheet, _ = self.add_pushed(), self.add_ball()
        bpy.context.view_layer.objects.active = sheet
        job = mend.Mending(bpy.context, sheet)
        while not job.is_over:
            job.advance(bpy.context)
            if job.process is not None and not job.is_cancelled:
                job.cancel()
        self.assertEqual((job.state, len(sheet.modifiers)), ("CANCELLED", 0))
        for point in sheet.data.shape_keys.key_blocks["low"].data:
            point.co.z = 0.0
        bpy.ops.mesh.primitive_cube_add(size=3.0)
        bpy.context.object.tulle.role = "OBSTACLE"
        bpy.context.view_layer.objects.active = sheet
        with self.assertRaisesRegex(RuntimeError, "Not mended"):
            bpy.ops.tulle.mend()
        self.assertEqual((self.scene.tulle.state, len(sheet.modifiers)), ("FAILED", 0))
        self.assertIn("inside", self.scene.tulle.report)
