"""The judge on meshes of the scene, and untangling.

Cloth is judged as it was simulated: before the trailing run of modifiers, with the triangles of the bake if there is one.
`as_shown` judges what is seen.
"""
import json
import os
import shutil
import tempfile
from typing import Any, Dict, List, Optional, Set, Tuple

import bpy
import numpy as np

from . import bake, caches, export, files, meshes, parts, program, selection, stack
from .meshes import Refusal


def find_baked_triangles(obj, vertex_count: int) -> Optional[np.ndarray]:
    """Triangles that the bake has for an object whose cache is shown; None: there is no bake, or it has other vertices."""
    modifier = caches.find_modifier(obj)
    if modifier is None:
        return None
    path = bpy.path.abspath(modifier.filepath)
    folder, name = os.path.dirname(os.path.dirname(path)), os.path.splitext(os.path.basename(path))[0]
    links = files.read_links(folder) or {"bodies": []}
    link = next((each for each in links["bodies"] if each["name"] == name and each["vertices"] == vertex_count), None)
    mesh_path = os.path.join(folder, parts.MESH_FOLDER, name + ".obj")
    if link is None or not os.path.isfile(mesh_path):
        return None
    used = np.setdiff1d(np.arange(vertex_count), np.array(link["loose"], np.int64))
    return used[meshes.read_obj_faces(mesh_path)]


class Judge:
    """Judges objects together, frame by frame."""

    def __init__(self, context, objects: List[Any], as_shown: bool):
        self.context, self.objects, self.as_shown = context, objects, as_shown
        self.scale = meshes.get_scale(context.scene)
        self.are_obstacles = [obj.tulle.role == "OBSTACLE" for obj in objects]
        if all(self.are_obstacles):
            self.are_obstacles = [False] * len(objects)

    @property
    def simulated(self) -> List[Any]:
        return [] if self.as_shown else [obj for obj in self.objects if caches.is_ours(obj)]

    def hide_tails(self) -> List[Any]:
        """Modifiers behind the caches, which are off while the judge looks."""
        hidden = []
        for obj in self.simulated:
            for modifier in list(obj.modifiers)[stack.find_tail(obj.modifiers) :]:
                if modifier.show_viewport:
                    modifier.show_viewport = False
                    hidden.append(modifier)
        return hidden

    def write(self, folder: str) -> List[str]:
        graph = self.context.evaluated_depsgraph_get()
        arguments = ["check", "--json", "--together"]
        for number, obj in enumerate(self.objects):
            evaluated = obj.evaluated_get(graph)
            mesh = evaluated.to_mesh()
            triangles, local = meshes.read_triangles(mesh).corners, meshes.read_positions(mesh)
            evaluated.to_mesh_clear()
            if len(triangles) == 0:
                raise Refusal("'%s' has no faces" % obj.name, [obj.name])
            if obj in self.simulated:
                baked = find_baked_triangles(obj, len(local))
                triangles = triangles if baked is None else baked
            path = os.path.join(folder, "%d.obj" % number)
            used, corners = np.unique(triangles, return_inverse=True)
            places = meshes.to_world(local, meshes.get_matrix(evaluated.matrix_world), self.scale)
            meshes.write_obj(path, places[used], corners.reshape(-1, 3))
            arguments += ["--obstacle", path] if self.are_obstacles[number] else [path]
        return arguments

    def judge_frame(self, folder: str) -> List[Dict[int, Set[int]]]:
        """Pairs of triangles that intersect, each as triangles by the number of the object."""
        answer = json.loads(program.run_to_end(self.write(folder), (0, 1)).splitlines()[0])
        pairs = []
        for pair in answer["pairs"]:
            found: Dict[int, Set[int]] = {}
            for side in "ab":
                found.setdefault(int(os.path.basename(pair[side]).split(".")[0]), set()).add(pair["triangle_" + side])
            pairs.append(found)
        return pairs


class TULLE_OT_check(bpy.types.Operator):
    """Judges by exact arithmetic whether faces of the selected meshes intersect, and selects those that do"""

    bl_idname = "tulle.check"
    bl_label = "Check"
    whole_range: bpy.props.BoolProperty(name="All Frames", description="Judge every frame of the scene's range", default=False)
    as_shown: bpy.props.BoolProperty(
        name="As Shown", description="With the modifiers behind the cache, such as Subdivision", default=False
    )

    @classmethod
    def poll(cls, context):
        return bake.current is None and any(obj.type == "MESH" for obj in context.selected_objects)

    def execute(self, context):
        objects = [obj for obj in context.selected_objects if obj.type == "MESH"]
        if context.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        scene = context.scene
        frames = range(scene.frame_start, scene.frame_end + 1) if self.whole_range else [scene.frame_current]
        judge = Judge(context, objects, self.as_shown)
        folder = tempfile.mkdtemp(prefix="tulle_check_")
        first_bad, pairs, bad_frames, sum_of_pairs = None, [], 0, 0
        hidden = judge.hide_tails()
        manager = context.window_manager
        manager.progress_begin(0, len(frames))
        try:
            for number, frame in enumerate(frames):
                manager.progress_update(number)
                if scene.frame_current != frame:
                    scene.frame_set(frame)
                found = judge.judge_frame(folder)
                bad_frames, sum_of_pairs = bad_frames + bool(found), sum_of_pairs + len(found)
                if found and first_bad is None:
                    first_bad, pairs = frame, found
        except Refusal as refusal:
            self.report({"ERROR"}, str(refusal))
            return {"CANCELLED"}
        finally:
            manager.progress_end()
            shutil.rmtree(folder)
            for modifier in hidden:
                modifier.show_viewport = True
        if first_bad is None:
            scene.tulle.status = "No intersection in %d frame%s" % (len(frames), "" if len(frames) == 1 else "s")
            self.report({"INFO"}, scene.tulle.status)
            return {"FINISHED"}
        scene.frame_set(first_bad)
        self.show(context, judge, pairs)
        scene.tulle.status = "%d pairs of triangles intersect in %d of %d frames, first in frame %d" % (
            sum_of_pairs,
            bad_frames,
            len(frames),
            first_bad,
        )
        self.report({"WARNING"}, scene.tulle.status)
        return {"FINISHED"}

    def show(self, context, judge: Judge, pairs: List[Dict[int, Set[int]]]) -> None:
        triangles: Dict[int, Set[int]] = {}
        for pair in pairs:
            for number, found in pair.items():
                triangles.setdefault(number, set()).update(found)
        chosen: Dict[str, Tuple[Set[int], Set[int]]] = {}
        frame = context.scene.frame_current
        for number, found in triangles.items():
            obj = judge.objects[number]
            is_simulated = obj in judge.simulated
            of_triangles, _ = selection.find_originals(
                context, obj, context.scene.frame_start if is_simulated else frame, is_shown=not is_simulated
            )
            chosen[obj.name] = ({int(of_triangles[t]) for t in found if t < len(of_triangles)} - {-1}, set())
        selection.select(context, chosen)


class TULLE_OT_untangle(bpy.types.Operator):
    """Moves the active cloth, as a new shape key, until it intersects nothing in this frame"""

    bl_idname = "tulle.untangle"
    bl_label = "Untangle"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return bake.current is None and context.object is not None and context.object.type == "MESH"

    def execute(self, context):
        if context.object.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        folder = tempfile.mkdtemp(prefix="tulle_untangle_")
        try:
            moved, note = untangle(context, context.object, folder)
        except Refusal as refusal:
            context.scene.tulle.report = str(refusal)
            self.report({"ERROR"}, str(refusal))
            return {"CANCELLED"}
        finally:
            shutil.rmtree(folder)
        context.scene.tulle.status = "%d vertices of '%s' were moved" % (moved, context.object.name)
        context.scene.tulle.report = note
        self.report({"INFO"}, context.scene.tulle.status)
        return {"FINISHED"}


def untangle(context, obj, folder: str) -> Tuple[int, str]:
    """Adds a shape key in which the cloth intersects neither itself nor obstacles; the number of vertices that it moves, and what
    there is to say."""
    scale, frame = meshes.get_scale(context.scene), context.scene.frame_current
    own = read_own(obj)
    others = [
        each
        for each in context.view_layer.objects
        if each is not obj and each.visible_get() and each.type == "MESH" and each.tulle.role in ("OBSTACLE", "BODY")
    ]
    with stack.reading(context, [obj]):
        context.scene.frame_set(frame)
        graph = context.evaluated_depsgraph_get()
        cloth = obj.evaluated_get(graph)
        matrix = meshes.get_matrix(cloth.matrix_world)
        mesh = cloth.to_mesh()
        local, triangles = meshes.read_positions(mesh), meshes.read_triangles(mesh)
        cloth.to_mesh_clear()
        extent = max(1e-12, float(np.ptp(own, axis=0).max()))
        if len(local) != len(own) or np.abs(local - own).max() > 1e-5 * extent:
            raise Refusal(
                "Modifiers deform '%s' or change its vertices in this frame: switch them off, or untangle where they do nothing"
                % obj.name,
                [obj.name],
            )
        used, corners = np.unique(triangles.corners, return_inverse=True)
        start = meshes.to_world(local, matrix, scale)[used]
        meshes.write_obj(os.path.join(folder, "cloth.obj"), start, corners.reshape(-1, 3))
        obstacles = [
            write_other(graph, each, os.path.join(folder, "%d.obj" % number), scale) for number, each in enumerate(others)
        ]
    cloth_said: Dict[str, Any] = {"name": "cloth", "mesh": {"file": "cloth.obj"}, "material": {"preset": obj.tulle.fabric}}
    if obj.tulle.use_thickness:
        cloth_said["thickness"] = obj.tulle.thickness * scale
    scene = {
        "time": {"step": 1e-6, "frames": 1}, "gravity": [0, 0, 0], "contact": {"start_intersections": "untangle"},
        "cloth": [cloth_said], "obstacles": obstacles,
    }  # fmt: skip
    export.write_scene(os.path.join(folder, "scene.yaml"), scene)
    run = os.path.join(folder, "run")
    program.run_to_end(["run", os.path.join(folder, "scene.yaml"), "-o", run, "--progress", "none"])
    body = next(each for each in caches.read_json(os.path.join(run, "run.json"))["bodies"] if each["name"] == "cloth")
    end = meshes.Pc2Reader(os.path.join(run, body["cache"])).read(0).astype(np.float64)
    is_moved = np.any(end != start.astype(np.float32), axis=1)
    places = own.astype(np.float64)
    places[used[is_moved]] = meshes.to_local(end[is_moved], matrix, scale)
    add_key(obj, places, own)
    return int(is_moved.sum()), meshes.tell_rounding(obj.name, places, matrix, scale, "shape key")


def read_own(obj) -> np.ndarray:
    """Positions of the object's mesh with its shape keys as they are mixed."""
    if obj.data.shape_keys is None:
        return meshes.read_positions(obj.data)
    key = obj.shape_key_add(name="Tulle mix", from_mix=True)
    places = np.empty(3 * len(key.data), np.float32)
    key.data.foreach_get("co", places)
    obj.shape_key_remove(key)
    return places.reshape(-1, 3)


def add_key(obj, places: np.ndarray, own: np.ndarray) -> None:
    """A key that, at full weight over the keys as they are mixed, gives these places."""
    if obj.data.shape_keys is None:
        obj.shape_key_add(name="Basis", from_mix=False)
    key = obj.shape_key_add(name="Untangled", from_mix=False)
    basis = np.empty(3 * len(key.data), np.float32)
    key.relative_key.data.foreach_get("co", basis)
    key.data.foreach_set("co", (basis.reshape(-1, 3) + (places - own)).astype(np.float32).ravel())
    key.value = 1.0
    obj.data.update()


def write_other(graph, obj, path: str, scale: float) -> Dict[str, Any]:
    evaluated = obj.evaluated_get(graph)
    mesh = evaluated.to_mesh()
    matrix = meshes.get_matrix(evaluated.matrix_world)
    places, corners = meshes.to_world(meshes.read_positions(mesh), matrix, scale), meshes.read_triangles(mesh).corners
    evaluated.to_mesh_clear()
    corners = corners[meshes.measure_heights(places, corners) >= parts.NO_AREA]
    meshes.write_obj(path, places, corners[:, ::-1] if meshes.is_mirrored(matrix) else corners)
    return {"mesh": {"file": os.path.basename(path)}}


CLASSES = (TULLE_OT_check, TULLE_OT_untangle)


def register() -> None:
    for each in CLASSES:
        bpy.utils.register_class(each)


def unregister() -> None:
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
