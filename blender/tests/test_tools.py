"""Check, untangle, and what is taken over of Blender's own cloth."""
import bpy
import numpy as np

from support import SceneTest


class Tools(SceneTest):
    def select(self, *objects):
        if bpy.context.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        for obj in self.scene.objects:
            obj.select_set(obj in objects)
        bpy.context.view_layer.objects.active = objects[0]

    def add_crossing(self):
        """A sheet of nine faces, whose middle one a needle crosses from frame 12 on."""
        sheet = self.add_sheet(cells=3, size=3.0, place=(0, 0, 0))
        needle = self.add_mesh("needle", [(-0.1, 0, -1), (0.1, 0, -1), (0, 0.1, 1)], [(0, 1, 2)], role="OBSTACLE")
        for frame, height in ((11, -3.0), (12, 0.0)):
            needle.location.z = height
            needle.keyframe_insert("location", frame=frame)
        return sheet, needle

    def test_check_selects_faces(self):
        sheet, needle = self.add_crossing()
        middle = [p.index for p in sheet.data.polygons if p.center.length < 0.1]
        self.scene.frame_set(11)
        self.select(sheet, needle)
        self.assertEqual(bpy.ops.tulle.check(), {"FINISHED"})
        self.assertIn("No intersection in 1 frame", self.scene.tulle.status)
        self.assertEqual(bpy.ops.tulle.check(whole_range=True), {"FINISHED"})
        self.assertEqual(self.scene.frame_current, 12)
        self.assertIn("in 4 of 6 frames, first in frame 12", self.scene.tulle.status)
        self.assertEqual(self.get_selected(sheet), middle)
        self.assertEqual(self.get_selected(needle), [0])

    def test_check_through_modifiers(self):
        sheet, needle = self.add_crossing()
        middle = [p.index for p in sheet.data.polygons if p.center.length < 0.1]
        sheet.modifiers.new("Subdivision", "SUBSURF").levels = 2
        self.scene.frame_set(14)
        for shown in (False, True):
            self.select(sheet, needle)
            bpy.ops.tulle.check(as_shown=shown)
            self.assertEqual(self.get_selected(sheet), middle)
        self.assertTrue(sheet.modifiers[0].show_viewport)

    def test_check_of_a_bake(self):
        sheet, ball = self.add_sheet(), self.add_ball()
        sheet.modifiers.new("Subdivision", "SUBSURF")
        self.bake_all()
        self.select(sheet, ball)
        bpy.ops.tulle.check(whole_range=True)
        self.assertIn("No intersection in 6 frames", self.scene.tulle.status)

    def test_untangle(self):
        sheet, ball = self.add_sheet(cells=12, place=(0, 0, 0.22)), self.add_ball()
        sheet.rotation_euler = (0.05, 0, 0.4)
        self.scene.frame_set(10)
        self.select(sheet, ball)
        bpy.ops.tulle.check()
        self.assertIn("intersect", self.scene.tulle.status)
        self.select(sheet)
        self.assertEqual(bpy.ops.tulle.untangle(), {"FINISHED"})
        key = sheet.data.shape_keys.key_blocks["Untangled"]
        self.assertEqual(key.value, 1.0)
        moved = [(point.co - sheet.data.vertices[i].co).length for i, point in enumerate(key.data)]
        self.assertTrue(0.02 < max(moved) < 0.1, max(moved))
        self.assertLess(np.median(moved), 0.005)  # what lies off the ball hardly moves
        self.assertEqual(self.scene.tulle.report, "")
        self.select(sheet, ball)
        bpy.ops.tulle.check()
        self.assertIn("No intersection", self.scene.tulle.status)
        self.bake_all()
        self.judge()

    def test_untangle_over_keys(self):
        """The new key stands over keys as they are mixed."""
        sheet, _ = self.add_sheet(cells=12, place=(0, 0, 0)), self.add_ball()
        sheet.shape_key_add(name="Basis")
        raised = sheet.shape_key_add(name="raised")
        for point in raised.data:
            point.co.z = 0.44
        raised.value = 0.5
        self.select(sheet)
        self.assertEqual(bpy.ops.tulle.untangle(), {"FINISHED"})
        self.select(sheet, self.scene.objects["ball"])
        bpy.ops.tulle.check()
        self.assertIn("No intersection", self.scene.tulle.status)
        self.assertGreater(self.see(sheet, 10)[:, 2].min(), 0.15)

    def test_untangle_far_from_its_origin(self):
        """What floats of the shape key do to a mesh that is 3 km from its object's origin is told."""
        sheet, _ = self.add_sheet(cells=12, place=(0, 0, 0.22)), self.add_ball()
        for vertex in sheet.data.vertices:
            vertex.co.x += 3000
        sheet.location.x -= 3000
        self.select(sheet)
        self.assertEqual(bpy.ops.tulle.untangle(), {"FINISHED"})
        self.assertRegex(self.scene.tulle.report, r"'sheet': floats of its shape key move vertices by \S+ m, .*Set Origin")

    def test_untangle_refuses_deformed(self):
        sheet = self.add_sheet()
        sheet.modifiers.new("Cast", "CAST").factor = 1.0
        self.select(sheet)
        with self.assertRaisesRegex(RuntimeError, "Modifiers deform 'sheet'"):
            bpy.ops.tulle.untangle()

    def test_convert(self):
        sheet, ball = self.add_sheet(), self.add_ball(role="NONE")
        sheet.tulle.role = "NONE"
        ball.modifiers.new("Collision", "COLLISION")
        sheet.shape_key_add(name="Basis")
        sheet.shape_key_add(name="small")
        sheet.vertex_groups.new(name="held").add([0, 8], 1.0, "REPLACE")
        cloth = sheet.modifiers.new("Cloth", "CLOTH")
        values = cloth.settings
        values.mass, values.tension_stiffness, values.bending_stiffness = 1.0, 40.0, 10.0
        values.vertex_group_mass, values.use_pressure, values.use_sewing_springs = "held", True, True
        sheet.vertex_groups.new(name="stiff").add([3, 4], 1.0, "REPLACE")
        values.vertex_group_structural_stiffness, values.tension_stiffness_max = "stiff", 120.0
        values.rest_shape_key = sheet.data.shape_keys.key_blocks["small"]
        cloth.collision_settings.use_self_collision, cloth.collision_settings.self_distance_min = True, 0.02
        self.select(sheet)
        self.assertEqual(bpy.ops.tulle.convert(), {"FINISHED"})
        taken = sheet.tulle
        self.assertEqual((taken.role, taken.fabric, taken.pin_group), ("CLOTH", "denim", "held"))
        self.assertEqual((taken.rest, taken.rest_key, taken.use_thickness), ("KEY", "small", True))
        self.assertAlmostEqual(taken.thickness, 0.02, 6)
        self.assertEqual((taken.stiffness_group, taken.stiffness_from, taken.stiffness_to), ("stiff", 1.0, 3.0))
        self.assertEqual(ball.tulle.role, "OBSTACLE")
        for words in ("pressure", "sewing springs", "ball is an obstacle"):
            self.assertIn(words, self.scene.tulle.report)
        self.assertNotIn("internal springs", self.scene.tulle.report)
        self.bake_all()
        self.assertFalse(cloth.show_viewport)
        self.judge()
