"""What the scene for the program says of obstacles, pins, attachments, shapes at rest, forces and names."""
import os
import re

import bpy
import numpy as np
from mathutils import Euler

from support import SceneTest
from tulle_addon import export, meshes, motion, parts, settings


class Scenes(SceneTest):
    frames = 6

    def test_names_of_files(self):
        """Names that every file system takes, apart where it ignores case."""
        taken = set()
        for wanted, name in (("CON", "CON_"), ("con_", "con__2"), ("aux.001", "aux_.001"), ("Lpt1. ", "Lpt1_._"), ("a .", "a_"),
                             ("com10", "com10"), ("nulls", "nulls"), ("..", "object"), ("布", "_"), ("a/b", "a_b")):  # fmt: skip
            self.assertEqual(parts.make_name(wanted, taken), name)

    def test_character(self):
        """A tube that two bones bend is a mesh sequence; the sheet around its end does not cross it."""
        bpy.ops.mesh.primitive_cylinder_add(vertices=24, radius=0.1, depth=1.0, rotation=(0, 1.5708, 0))
        tube = bpy.context.object
        tube.name, tube.tulle.role = "tube", "OBSTACLE"
        bpy.ops.object.transform_apply(rotation=True)
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="SELECT")
        bpy.ops.mesh.subdivide(number_cuts=4)
        bpy.ops.object.mode_set(mode="OBJECT")
        bpy.ops.object.armature_add(enter_editmode=True, location=(0, 0, 0))
        rig = bpy.context.object
        bone = rig.data.edit_bones[0]
        bone.head, bone.tail = (-0.5, 0, 0), (0, 0, 0)
        other = rig.data.edit_bones.new("arm")
        other.head, other.tail, other.parent = (0, 0, 0), (0.5, 0, 0), bone
        bpy.ops.object.mode_set(mode="OBJECT")
        for name, chosen in ((rig.data.bones[0].name, lambda x: x <= 0), ("arm", lambda x: x > 0)):
            group = tube.vertex_groups.new(name=name)
            group.add([v.index for v in tube.data.vertices if chosen(v.co.x)], 1.0, "REPLACE")
        tube.modifiers.new("Armature", "ARMATURE").object = rig
        pose = rig.pose.bones["arm"]
        pose.rotation_mode = "XYZ"
        for frame, angle in ((10, 0.0), (16, 0.7)):
            pose.rotation_euler = (0, 0, angle)
            pose.keyframe_insert("rotation_euler", frame=frame)
        sheet = self.add_sheet(cells=10, size=0.9, place=(0, 0, 0.13))
        group = sheet.vertex_groups.new(name="collar")
        group.add([v.index for v in sheet.data.vertices if abs(v.co.x) < 0.01], 1.0, "REPLACE")
        attachment = sheet.tulle.attachments.add()
        attachment.target, attachment.vertex_group = tube, "collar"
        self.bake_all()
        said = self.read_scene()
        self.assertEqual(said["obstacles"][0]["motion"]["sequence"]["cache"], "meshes/tube.pc2")
        self.assertEqual(said["cloth"][0]["attach"][0]["to"], "tube")
        self.judge()
        self.compare(sheet, "sheet")
        frames = self.list_frames("tube")
        for number in range(self.frames + 1):
            self.assertLess(np.abs(self.see(tube, 10 + number) - frames[number]).max(), 1e-6)
        self.assertGreater(np.abs(frames[-1] - frames[0]).max(), 0.2)

    def test_rigid_obstacle(self):
        self.add_sheet()
        ball = self.add_ball(place=(0.3, 0.1, 0))
        ball.scale = (1.5, 1.0, 0.7)
        for frame, place, turn in ((10, (0.3, 0.1, 0), (0, 0, 0)), (16, (0.0, 0.2, 0.1), (0.5, 1.0, 2.0))):
            ball.location, ball.rotation_euler = place, turn
            ball.keyframe_insert("location", frame=frame)
            ball.keyframe_insert("rotation_euler", frame=frame)
        self.bake_all()
        self.assertEqual(len(self.read_scene()["obstacles"][0]["motion"]["keyframes"]), 7)
        self.assertFalse(os.path.exists(self.path("meshes", "ball.pc2")))
        frames = self.list_frames("ball")
        for number in range(self.frames + 1):
            self.assertLess(np.abs(self.see(ball, 10 + number) - frames[number]).max(), 2e-6)
        self.judge()

    def test_scaled_obstacle_is_a_sequence(self):
        self.add_sheet()
        ball = self.add_ball()
        for frame, size in ((10, 1.0), (16, 0.8)):
            ball.scale = (size, size, size)
            ball.keyframe_insert("scale", frame=frame)
        bpy.ops.tulle.export()
        self.assertIn("sequence", self.read_scene()["obstacles"][0]["motion"])

    def test_static_obstacle(self):
        self.add_sheet()
        self.add_ball().modifiers.new("Subdivision", "SUBSURF")
        bpy.ops.tulle.export()
        said = self.read_scene()["obstacles"][0]
        self.assertNotIn("motion", said)
        self.assertGreater(len(meshes.read_obj_faces(self.path(said["mesh"]["file"]))), 1280)

    def test_turns(self):
        random = np.random.default_rng(1)
        for _ in range(200):
            turn = np.array(Euler(random.uniform(-4, 4, 3)).to_matrix(), np.float64)
            u, _, vt = np.linalg.svd(turn)
            turn = u @ vt
            said = motion.find_axis_angle(turn)
            x, y, z = said["axis"]
            k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
            again = np.eye(3) + np.sin(said["angle"]) * k + (1 - np.cos(said["angle"])) * k @ k
            self.assertLess(np.abs(again - turn).max(), 1e-12)
        steps = [np.eye(4) for _ in range(20)]
        for i, step in enumerate(steps):
            c, s = np.cos(0.25 * np.pi * i), np.sin(0.25 * np.pi * i)
            step[:2, :2] = [[c, -s], [s, c]]
        for i, key in enumerate(motion.make_keyframes(steps, 0.1, 1.0)):
            np.testing.assert_allclose(key["rotate"]["angle"] * np.array(key["rotate"]["axis"]), [0, 0, 0.25 * np.pi * i], atol=1e-9)
        half = motion.find_axis_angle(np.diag([-1.0, 1.0, -1.0]))
        self.assertAlmostEqual(half["angle"], np.pi)
        self.assertIsNone(motion.find_turn(np.eye(4), np.diag([1.0, 1.1, 1.0, 1.0])))

    def test_pins_follow_the_object(self):
        sheet = self.add_sheet()
        sheet.scale = (1, 1.2, 1)
        group = sheet.vertex_groups.new(name="pins")
        group.add([0, 1, 2, 3, 8], 1.0, "REPLACE")
        group.add([20], 0.4, "REPLACE")
        sheet.tulle.pin_group = "pins"
        for frame, place, turn in ((10, (0, 0, 0), 0.0), (16, (0.1, 0, 0.2), 1.0)):
            sheet.location, sheet.rotation_euler.z = place, turn
            sheet.keyframe_insert("location", frame=frame)
            sheet.keyframe_insert("rotation_euler", frame=frame)
        self.bake_all()
        self.assertEqual(self.read_scene()["cloth"][0]["pins"][0]["vertices"], ["0-3", 8])
        self.compare(sheet, "sheet")
        modifier = sheet.modifiers[0]
        for frame in range(10, 17):
            baked = self.see(sheet, frame)
            modifier.show_viewport = False
            self.assertLess(np.abs(self.see(sheet, frame) - baked)[[0, 1, 2, 3, 8]].max(), 1e-6)
            modifier.show_viewport = True

    def test_attached_by_distance(self):
        ball, sheet = self.add_ball(), self.add_sheet(place=(0, 0, 0.26))
        for frame, height in ((10, 0.0), (16, 0.5)):
            ball.location.z = height
            ball.keyframe_insert("location", frame=frame)
        attachment = sheet.tulle.attachments.add()
        attachment.target, attachment.distance = ball, 0.02
        self.bake_all()
        frames = self.list_frames("sheet")
        self.assertAlmostEqual(float(frames[-1][40, 2]), 0.76, 3)
        self.judge()

    def test_rest_by_shape_key(self):
        sheet = self.add_sheet()
        sheet.shape_key_add(name="Basis")
        small = sheet.shape_key_add(name="small")
        for point in small.data:
            point.co *= 0.8
        small.value = 0.0
        sheet.tulle.rest, sheet.tulle.rest_key = "KEY", "small"
        self.scene.use_gravity = False
        self.bake_all()
        self.assertEqual(self.read_scene()["gravity"], [0, 0, 0])
        frames = self.list_frames("sheet")
        self.assertAlmostEqual(float(np.ptp(frames[0][:, 0])), 1.0, 5)
        self.assertLess(float(np.ptp(frames[-1][:, 0])), 0.95)  # it draws together
        self.compare(sheet, "sheet")

    def test_rest_by_uv(self):
        sheet = self.add_sheet()
        sheet.tulle.rest, sheet.tulle.uv_scale = "UV", 0.8
        self.scene.use_gravity = False
        self.bake_all()
        self.assertLess(float(np.ptp(self.list_frames("sheet")[-1][:, 0])), 0.95)

    def test_rigid_body(self):
        self.add_sheet(cells=4)
        ball = self.add_ball("Ball 1", role="BODY", place=(0, 0, 2))
        ball.modifiers.new("Bevel", "BEVEL")
        self.bake_all()
        self.assertEqual(self.read_scene()["obstacles"][0]["dynamic"], {"density": 1000.0})
        ball.modifiers["Bevel"].show_viewport = False
        self.compare(ball, "Ball_1")
        frames = self.list_frames("Ball_1")
        self.assertAlmostEqual(float((frames[0] - frames[-1])[:, 2].mean()), 9.81 * 0.25**2 / 2, 1)

    def test_linked_objects(self):
        """A linked sheet and a linked ball are simulated as overrides; the sheet itself cannot be."""
        self.add_sheet("Sheet"), self.add_ball("Ball", role="NONE")
        path = os.path.join(self.folder, "library.blend")
        bpy.data.libraries.write(path, {self.scene.objects["Sheet"], self.scene.objects["Ball"]})
        for name in ("Sheet", "Ball"):
            bpy.data.objects.remove(bpy.data.objects[name])
        with bpy.data.libraries.load(path, link=True) as (_, wanted):
            wanted.objects = ["Sheet", "Ball"]
        for obj in wanted.objects:
            self.scene.collection.objects.link(obj)
        bpy.context.view_layer.update()
        self.refuse("'Sheet' is linked from another file")
        sheet, ball = (obj.override_create(remap_local_usages=True) for obj in wanted.objects)
        sheet.tulle.fabric, ball.tulle.role = "silk", "OBSTACLE"
        bpy.ops.wm.save_mainfile()
        bpy.ops.wm.open_mainfile(filepath=bpy.data.filepath)
        sheet = next(obj for obj in self.scene.objects if obj.tulle.role == "CLOTH")
        self.assertIsNone(sheet.library)
        self.bake_all()
        said = self.read_scene()
        self.assertEqual((said["cloth"][0]["material"]["preset"], len(said["obstacles"])), ("silk", 1))
        self.compare(sheet, said["cloth"][0]["name"])

    def test_curves_texts_and_metaballs(self):
        bpy.ops.curve.primitive_bezier_circle_add(radius=0.3)
        bpy.context.object.data.bevel_depth = 0.03
        bpy.context.object.name = "ring"
        bpy.ops.object.text_add(location=(-0.3, 0, -0.2))
        bpy.context.object.data.extrude, bpy.context.object.name = 0.05, "words"
        bpy.ops.object.metaball_add(radius=0.2, location=(0, 0, -1))
        bpy.context.object.name = "drop"
        for name in ("ring", "words", "drop"):
            self.scene.objects[name].tulle.role = "OBSTACLE"
        self.add_sheet()
        self.bake_all()
        self.assertEqual({each["name"] for each in self.read_scene()["obstacles"]}, {"ring", "words", "drop"})
        self.judge()

    def test_instances(self):
        """An empty that instances a collection, and an object that is left out of it."""
        kinds = bpy.data.collections.new("kinds")
        for name, place in (("a", (0, 0, 0)), ("b", (1, 0, 0)), ("c", (2, 0, 0))):
            ball = self.add_ball(name, place=place, role="IGNORED" if name == "c" else "NONE")
            kinds.objects.link(ball)
            self.scene.collection.objects.unlink(ball)
        empty = bpy.data.objects.new("many", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", kinds
        self.scene.collection.objects.link(empty)
        empty.tulle.role, empty.location.z = "OBSTACLE", -0.1
        self.add_sheet()
        self.bake_all()
        corners = meshes.read_obj_faces(self.path("meshes", "many.obj"))
        one = len(bpy.data.objects["a"].data.polygons)
        self.assertEqual(len(corners), 2 * one)
        self.judge()

    def test_instances_of_nodes(self):
        """Boxes on the points of a mesh by geometry nodes, which grow."""
        self.add_sheet()
        ground = self.add_mesh("ground", [(-0.3, 0, 0), (0.3, 0, 0), (0, 0.3, 0)], [(0, 1, 2)], role="OBSTACLE")
        tree = bpy.data.node_groups.new("boxes", "GeometryNodeTree")
        if hasattr(tree, "interface"):
            for side in ("INPUT", "OUTPUT"):
                tree.interface.new_socket("Geometry", in_out=side, socket_type="NodeSocketGeometry")
        else:
            tree.inputs.new("NodeSocketGeometry", "Geometry"), tree.outputs.new("NodeSocketGeometry", "Geometry")
        made = {}
        for kind in (
            "NodeGroupInput",
            "NodeGroupOutput",
            "GeometryNodeInstanceOnPoints",
            "GeometryNodeMeshCube",
            "GeometryNodeJoinGeometry",
        ):
            made[kind] = tree.nodes.new(kind)
        instances, box = made["GeometryNodeInstanceOnPoints"], made["GeometryNodeMeshCube"]
        box.inputs["Size"].default_value = (0.1, 0.1, 0.1)
        start, join = made["NodeGroupInput"].outputs[0], made["GeometryNodeJoinGeometry"]
        for a, b in (
            (start, instances.inputs["Points"]), (box.outputs["Mesh"], instances.inputs["Instance"]),
            (instances.outputs[0], join.inputs[0]), (start, join.inputs[0]),
            (join.outputs[0], made["NodeGroupOutput"].inputs[0]),
        ):  # fmt: skip
            tree.links.new(a, b)
        ground.modifiers.new("Nodes", "NODES").node_group = tree
        self.bake_all()
        self.assertEqual(len(meshes.read_obj_faces(self.path("meshes", "ground.obj"))), 1 + 3 * 12)
        self.assertNotIn("motion", self.read_scene()["obstacles"][0])
        self.judge()
        for frame, size in ((10, 0.1), (16, 0.2)):
            box.inputs["Size"].default_value = (size, size, size)
            box.inputs["Size"].keyframe_insert("default_value", frame=frame)
        bpy.ops.tulle.export()
        self.assertIn("sequence", self.read_scene()["obstacles"][0]["motion"])

    def test_deformed_pins_are_told(self):
        sheet = self.add_sheet()
        sheet.vertex_groups.new(name="pins").add([0, 1], 1.0, "REPLACE")
        sheet.tulle.pin_group = "pins"
        sheet.modifiers.new("Wave", "WAVE").height = 0.2
        bpy.ops.tulle.export()
        self.assertIn("The pins of 'sheet' are deformed before the cache", self.scene.tulle.report)

    def test_names(self):
        for name in ("Füße: links", "Füße_ links", "füße_ LINKS", ".", "a/b"):
            self.add_ball(name, place=(len(name), 3, 0))
        self.add_sheet("Tuch\n1")
        bpy.ops.tulle.export()
        names = [each["name"] for each in self.read_scene()["obstacles"]]
        self.assertEqual(len({name.lower() for name in names}), 5)
        for name in names:
            self.assertRegex(name, r"^[A-Za-z0-9._-]+$")
        self.assertEqual(self.read_scene()["cloth"][0]["name"], "Tuch_1")
        self.bake_all()

    def test_forces(self):
        self.add_sheet()
        bpy.ops.object.effector_add(type="WIND", rotation=(0, 1.5707963, 0))
        bpy.context.object.field.strength = 3
        bpy.ops.object.effector_add(type="TURBULENCE")
        bpy.context.object.field.strength, bpy.context.object.field.size = 2, 0.7
        bpy.ops.object.effector_add(type="VORTEX")
        bpy.context.object.name = "twist"
        bpy.ops.tulle.export()
        wind = self.read_scene()["wind"]
        np.testing.assert_allclose(wind["velocity"], [3, 0, 0], atol=1e-6)
        self.assertAlmostEqual(wind["gust_strength"], 2)
        self.assertAlmostEqual(wind["gust_length"], 0.7, 5)
        self.assertIn("'twist' (vortex) is not taken over", self.scene.tulle.report)

    def test_faces_without_area(self):
        """An obstacle without them is the same obstacle; those that open later are kept."""
        self.add_sheet(place=(0, 0, 1))
        points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (2, 0, 0), (3, 0, 0)]
        ground = self.add_mesh("ground", points, [(1, 3, 4), (0, 1, 2)], role="OBSTACLE")
        self.bake_all()
        self.assertEqual(len(meshes.read_obj_faces(self.path("meshes", "ground.obj"))), 1)
        ground.shape_key_add(name="Basis")
        key = ground.shape_key_add(name="open")
        key.data[4].co.y = 0.5
        for frame, value in ((10, 0.0), (15, 1.0)):
            key.value = value
            key.keyframe_insert("value", frame=frame)
        bpy.ops.tulle.free()
        self.bake_all()
        self.assertEqual(len(meshes.read_obj_faces(self.path("meshes", "ground.obj"))), 2)

    def test_hidden_obstacle_counts(self):
        self.add_sheet()
        ball = self.add_ball()
        ball.hide_set(True)
        bpy.ops.tulle.export()
        self.assertEqual(len(self.read_scene()["obstacles"]), 1)
        self.assertTrue(ball.hide_get())

    def test_all_visible(self):
        self.add_sheet()
        self.add_ball("seen", role="NONE")
        self.add_ball("left out", role="IGNORED")
        self.add_ball("hidden", role="NONE").hide_set(True)
        self.scene.tulle.all_obstacles = True
        bpy.ops.tulle.export()
        self.assertEqual([each["name"] for each in self.read_scene()["obstacles"]], ["seen"])

    def test_loose_and_ngons(self):
        """Loose vertices are left out, keep their place, and numbers stay; polygons have many corners."""
        points = [(5, 5, 5), (0, 0, 0), (1, 0, 0), (1.5, 0.5, 0), (1, 1, 0), (0, 1, 0), (6, 6, 6), (-1, 0, 0), (-1, 1, 0)]
        sheet = self.add_mesh("odd", points, [(1, 2, 3, 4, 5), (7, 1, 5, 8)], [(0, 6)])
        self.bake_all()
        self.assertIn("2 vertices and 1 edges that belong to no face", self.scene.tulle.report)
        last = self.see(sheet, 16)
        np.testing.assert_allclose(last[[0, 6]], [(5, 5, 5), (6, 6, 6)])
        frames = self.list_frames("odd")
        np.testing.assert_array_equal(last[[1, 2, 3, 4, 5, 7, 8]], frames[-1])
        self.assertLess(last[3, 2], -0.1)

    def test_ranges(self):
        self.assertEqual(export.make_ranges(np.array([0, 2, 3, 4, 9])), [0, "2-4", 9])
        self.assertEqual(export.make_ranges(np.array([7])), [7])

    def test_fabrics_are_the_presets(self):
        book = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "docs", "guide", "scene.md")
        with open(book, encoding="utf-8") as file:
            table = file.read().split("## Material presets")[1].split("With `membrane")[0]
        self.assertEqual([name for name, _, _ in settings.FABRICS], re.findall(r"^\| `([a-z-]+)`", table, re.M))

    def test_obj_and_pc2(self):
        random = np.random.default_rng(2)
        places = random.normal(size=(20, 3)) * 10.0 ** random.integers(-12, 12, (20, 3))
        path = os.path.join(self.folder, "a")
        meshes.write_obj(path + ".obj", places, np.array([[0, 1, 2], [19, 3, 4]]))
        with open(path + ".obj", encoding="ascii") as file:
            again = [[float(word) for word in line.split()[1:]] for line in file if line.startswith("v ")]
        np.testing.assert_array_equal(again, places)
        writer = meshes.Pc2Writer(path + ".pc2", 20)
        for frame in range(3):
            writer.append(places + frame)
        reader = meshes.Pc2Reader(path + ".pc2")
        self.assertEqual(reader.count_frames(), 3)
        np.testing.assert_array_equal(reader.read(2), (places + 2).astype(np.float32))
        os.truncate(path + ".pc2", os.path.getsize(path + ".pc2") - 1)
        self.assertEqual(reader.count_frames(), 2)
