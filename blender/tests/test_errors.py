"""What is refused, in which words, and what is selected."""
import os

import addon_utils
import bpy

from support import SceneTest
from tulle_addon import selection


class Errors(SceneTest):
    def test_unsaved_file(self):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        addon_utils.enable("tulle_addon", default_set=True)
        self.add_sheet()
        self.refuse("Save the file first")

    def test_no_program(self):
        self.add_sheet()
        bpy.context.preferences.addons["tulle_addon"].preferences.program = "/nowhere/tulle"
        self.refuse("/nowhere/tulle")
        bpy.context.preferences.addons["tulle_addon"].preferences.program = ""
        path, os.environ["PATH"] = os.environ["PATH"], "/nowhere"
        try:
            self.refuse("Preferences > Add-ons > Tulle")
        finally:
            os.environ["PATH"] = path

    def test_nothing_marked(self):
        self.add_ball()
        self.refuse("Nothing is marked")

    def test_one_frame(self):
        self.add_sheet()
        self.scene.frame_end = self.scene.frame_start
        self.refuse("single frame")

    def test_start_that_intersects(self):
        """The faces that the judge names are selected, through a mirror too."""
        faces = [(4 * y + x, 4 * y + x + 1, 4 * y + x + 5, 4 * y + x + 4) for y in range(3) for x in range(3)]
        sheet = self.add_mesh("sheet", [(x, y, 0) for y in range(4) for x in range(4)], faces)
        spike = self.add_mesh("spike", [(1.4, 1.5, -1), (1.6, 1.5, -1), (1.5, 1.6, 1), (9, 9, 9), (8, 9, 9), (9, 8, 9)],
                              [(3, 4, 5), (0, 1, 2)], role="OBSTACLE")  # fmt: skip
        sheet.modifiers.new("Subdivision", "SUBSURF")
        self.refuse("intersect at the start", "triangle", "Untangle")
        self.assertEqual(sheet.mode, "EDIT")
        self.assertEqual(self.get_selected(sheet), [4])
        self.assertEqual(self.get_selected(spike), [1])
        self.assertEqual([each.name for each in sheet.data.attributes if "tulle" in each.name], [])
        self.scene.tulle.start = "untangle"
        self.bake_all()
        self.judge()

    def test_zero_area(self):
        sheet = self.add_mesh("flat", [(0, 0, 0), (1, 0, 0), (0, 1, 0), (2, 0, 0), (3, 0, 0)], [(0, 1, 2), (1, 3, 4)])
        self.refuse("flat, frame 10: face 1 has no area\n", "zero area")
        self.assertEqual(self.get_selected(sheet), [1])

    def test_fan_names_a_vertex(self):
        """Two triangles that share a vertex alone are no cloth; the vertex is selected."""
        bow = self.add_mesh("bow", [(9, 9, 9), (0, 0, 0), (1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0)], [(1, 2, 3), (1, 4, 5)])
        self.refuse("fans of triangles")
        self.assertEqual(self.get_selected(bow, "vertices"), [1])

    def test_loose_edges_alone(self):
        self.add_mesh("wire", [(0, 0, 0), (1, 0, 0)], [], [(0, 1)])
        self.refuse("'wire' has no faces")

    def test_open_body(self):
        self.add_sheet()
        body = self.add_mesh("shell", [(0, 0, 5), (1, 0, 5), (0, 1, 5)], [(0, 1, 2)], role="BODY")
        self.refuse("shell")
        self.assertEqual(bpy.context.view_layer.objects.active, body)

    def test_vertex_count_that_changes(self):
        self.add_sheet()
        ball = self.add_ball(place=(0, 0, -2))
        build = ball.modifiers.new("Build", "BUILD")
        build.frame_start, build.frame_duration = 5, 20
        self.refuse("'ball' has", "vertices in frame")
        self.assertTrue(ball.select_get())
        self.assertEqual(self.scene.frame_current, 10)

    def test_groups(self):
        sheet = self.add_sheet()
        sheet.tulle.pin_group = "gone"
        self.refuse("no vertex group 'gone'")
        sheet.vertex_groups.new(name="gone")
        self.refuse("No vertex of 'sheet' has a weight of 0.5")

    def test_attachment_to_nothing(self):
        sheet, ball = self.add_sheet(), self.add_ball(role="NONE", place=(0, 0, -3))
        attachment = sheet.tulle.attachments.add()
        attachment.distance = 0.1
        self.refuse("names no object")
        attachment.target = ball
        self.refuse("is attached to 'ball', which is no obstacle")

    def test_hidden_collection(self):
        self.add_sheet()
        ball, other = self.add_ball(), bpy.data.collections.new("other")
        self.scene.collection.children.link(other)
        other.objects.link(ball)
        self.scene.collection.objects.unlink(ball)
        other.hide_viewport = True
        self.refuse("'ball' is hidden by its collection")

    def test_scaled_pins(self):
        sheet = self.add_sheet()
        sheet.vertex_groups.new(name="pins").add([0], 1.0, "REPLACE")
        sheet.tulle.pin_group = "pins"
        for frame, size in ((10, 1.0), (15, 2.0)):
            sheet.scale.x = size
            sheet.keyframe_insert("scale", frame=frame)
        self.refuse("scaled while it moves")

    def test_rest_that_is_not_there(self):
        sheet = self.add_sheet()
        sheet.tulle.rest, sheet.tulle.rest_key = "KEY", "none"
        self.refuse("no shape key 'none'")
        sheet.tulle.rest = "UV"
        sheet.data.uv_layers.remove(sheet.data.uv_layers[0])
        sheet.data.update_tag()
        self.refuse("no UV map")

    def test_words(self):
        """Which vertices and triangles messages name."""
        links = {"bodies": [{"name": "s-1", "role": "CLOTH"}, {"name": "b", "role": "OBSTACLE"}]}
        for words, triangles, vertices in (
            ("meshes/s-1.obj:6: triangle 7 (line 6) (vertices 0 (line 1) at (0, 0, 0)) has zero area "
             "(read for cloth[0].mesh, x)", {"s-1": {7}}, {"s-1": {0}}),
            ("'s-1' is overstretched in step 4: at vertices 3, 4, 5 of it", {}, {"s-1": {3, 4, 5}}),
            ("triangle 2 of 's-1' (vertices 1, 2, 9) with triangle 3 of 'b' (vertices 4, 5, 6)",
             {"s-1": {2}, "b": {3}}, {"s-1": {1, 2, 9}, "b": {4, 5, 6}}),
            ("'b' lies inside 's-1' at the start (vertex 11 at 0, 0, 0 is 1 m deep)", {}, {"b": {11}}),
            ("triangles 3 and 9, which share the edge (read for obstacles[0].mesh)", {"b": {3, 9}}, {}),
        ):  # fmt: skip
            picks = selection.Picks()
            selection.read_words(words, links, picks)
            self.assertEqual(picks.triangles, triangles, words)
            self.assertEqual(picks.vertices, vertices, words)
