"""Selects what the program names: triangles and vertices of objects, in edit mode, with the view on them."""
import csv
import os
import re
from typing import Any, Callable, Dict, List, Optional, Set, Tuple

import bpy
import numpy as np

from . import meshes, stack

FACE_MARK, VERTEX_MARK = "tulle_face", "tulle_vertex"

# Faces and vertices by the name of their object, in Blender's numbers.
Chosen = Dict[str, Tuple[Set[int], Set[int]]]


class Picks:
    """Triangles and vertices by body, numbered as in the mesh files."""

    def __init__(self) -> None:
        self.triangles: Dict[str, Set[int]] = {}
        self.vertices: Dict[str, Set[int]] = {}

    def add(self, kind: str, body: str, number: int) -> None:
        (self.triangles if kind == "triangle" else self.vertices).setdefault(body, set()).add(number)

    def list_bodies(self) -> List[str]:
        return sorted(set(self.triangles) | set(self.vertices))


def read_left(path: str, picks: Picks) -> bool:
    """Pairs of triangles that intersect at the start, as --list-left writes them; false if there are none."""
    if not os.path.isfile(path):
        return False
    with open(path, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        for side in "ab":
            picks.add("triangle", row["object_" + side], int(row["triangle_" + side]))
    return len(rows) > 0


def read_words(words: str, links: Dict[str, Any], picks: Picks) -> None:
    """Triangles and vertices that a message names. It says whose they are: `triangle 3 of 'NAME'`, or the mesh that was
    read."""
    names = {link["name"] for link in links["bodies"]}
    cloths = [link["name"] for link in links["bodies"] if link["role"] in ("CLOTH", "MENDED")]
    others = [link["name"] for link in links["bodies"] if link["role"] not in ("CLOTH", "MENDED")]
    found = re.search(r"\b(cloth|obstacles)\[(\d+)\]", words)
    subject: Optional[str] = None
    if found:
        part = cloths if found[1] == "cloth" else others
        subject = part[int(found[2])] if int(found[2]) < len(part) else None
    quoted = [name for name in re.findall(r"'([^']+)'", words) if name in names]
    if subject is None and quoted:
        subject = quoted[0]
    for found in re.finditer(r"\b(triangles?|vertex|vertices) (\d+(?: \(line \d+\))?(?:(?:, | and )\d+)*)", words):
        behind = re.match(r" of '([^']+)'| \([^)]*\) of '([^']+)'", words[found.end() :])
        before = re.search(r" of '([^']+)' \($", words[: found.start()])
        owners = [name for match in (behind, before) if match for name in match.groups() if name in names]
        body = owners[0] if owners else subject
        if body is not None:
            for number in re.findall(r"\d+", re.sub(r"\(line \d+\)", "", found[2])):
                picks.add("triangle" if found[1].startswith("triangle") else "vertex", body, int(number))


def find_originals(
    context, obj, frame: Optional[int], is_shown: bool = False, hide: Callable[[Any], List] = stack.list_hidden
) -> Tuple[np.ndarray, np.ndarray]:
    """The faces of the object's own mesh that its triangles come of, and the vertices that its vertices come of; -1: none.

    Numbers travel through the modifiers as attributes of the mesh, which are taken off again. What `hide` lists is off, unless
    the object is taken as it is shown."""
    mesh = obj.data
    with stack.reading(context, [] if is_shown else [obj], hide=hide):
        faces = mesh.attributes.new(FACE_MARK, "INT", "FACE")
        faces.data.foreach_set("value", np.arange(1, len(mesh.polygons) + 1, dtype=np.int32))
        points = mesh.attributes.new(VERTEX_MARK, "INT", "POINT")
        points.data.foreach_set("value", np.arange(1, len(mesh.vertices) + 1, dtype=np.int32))
        mesh.update()
        try:
            if frame is not None:
                context.scene.frame_set(frame)
            evaluated = obj.evaluated_get(context.evaluated_depsgraph_get()).to_mesh()
            triangles = meshes.read_triangles(evaluated)
            of_faces = meshes.read_integers(evaluated, FACE_MARK, len(evaluated.polygons))
            of_vertices = meshes.read_integers(evaluated, VERTEX_MARK, len(evaluated.vertices))
            obj.evaluated_get(context.evaluated_depsgraph_get()).to_mesh_clear()
        finally:
            for name in (FACE_MARK, VERTEX_MARK):
                mesh.attributes.remove(mesh.attributes[name])
    no_face, no_vertex = np.full(len(triangles.corners), -1), np.full(triangles.vertex_count, -1)
    return (
        no_face if of_faces is None else of_faces[triangles.polygons].astype(np.int64) - 1,
        no_vertex if of_vertices is None else of_vertices.astype(np.int64) - 1,
    )


def tell_face(words: str, chosen: Chosen, frame: int) -> str:
    """The program's words; where they refuse a face for its area, these first: the object's name, the frame, and the face in
    Blender's numbers."""
    fault = re.search(r"\b(has (?:zero|no) area|is too thin)\b", words)
    faces = [(name, face) for name, (own, _) in chosen.items() for face in sorted(own)]
    if fault is None or not faces:
        return words
    name, face = faces[0]
    said = "is too thin" if fault[1] == "is too thin" else "has no area"
    return "%s, frame %d: face %d %s\n%s" % (name, frame, face, said, words)


def select_bodies(
    context, links: Dict[str, Any], picks: Picks, frame: Optional[int] = None, only: Optional[str] = None
) -> Chosen:
    """Selects what was picked in the objects that the bodies are, as `select` does, and goes to the frame, or to the first
    one; what is selected of these objects."""
    chosen: Chosen = {}
    for link in links["bodies"]:
        if link["name"] not in picks.list_bodies() or link["object"] not in context.view_layer.objects:
            continue
        obj = context.view_layer.objects[link["object"]]
        faces: Set[int] = set()
        vertices: Set[int] = set()
        if obj.type == "MESH" and obj.library is None and obj.data.library is None:
            of_triangles, of_vertices = find_originals(
                context, obj, links["frame_start"], is_shown=link["role"] == "OBSTACLE",
                hide=stack.list_behind if link["role"] == "MENDED" else stack.list_hidden,
            )  # fmt: skip
            used = np.setdiff1d(np.arange(link["vertices"]), np.array(link["loose"], np.int64))
            of_triangles = np.delete(
                of_triangles[: link["own_triangles"]], [t for t in link["thin"] if t < link["own_triangles"]]
            )
            faces = {int(of_triangles[t]) for t in picks.triangles.get(link["name"], ()) if t < len(of_triangles)}
            vertices = {
                int(of_vertices[used[v]])
                for v in picks.vertices.get(link["name"], ())
                if v < len(used) and used[v] < len(of_vertices)
            }
        chosen[obj.name] = (faces - {-1}, vertices - {-1})
    context.scene.frame_set(links["frame_start"] if frame is None else frame)
    select(context, chosen, only)
    return chosen


def select(context, chosen: Chosen, only: Optional[str] = None) -> None:
    """Objects with the faces and vertices that are to be selected in edit mode; an object without any is selected as a
    whole. With `only`, no other object comes into edit mode or becomes the active one."""
    layer = context.view_layer
    if layer.objects.active and layer.objects.active.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    for obj in layer.objects:
        obj.select_set(obj.name in chosen)
    edited = [name for name, (faces, vertices) in chosen.items() if faces or vertices]
    for name in edited:
        set_flags(layer.objects[name].data, *chosen[name])
    if only is not None:
        edited = [name for name in edited if name == only]
    if edited:
        by_faces = any(chosen[name][0] for name in edited)
        for name in chosen:
            layer.objects[name].select_set(name in edited)
        layer.objects.active = layer.objects[edited[0]]
        context.tool_settings.mesh_select_mode = (not by_faces, False, by_faces)
        bpy.ops.object.mode_set(mode="EDIT")
    elif chosen:
        layer.objects.active = layer.objects[only or next(iter(chosen))]
    frame_view(context)


def set_flags(mesh, faces: Set[int], vertices: Set[int]) -> None:
    of_faces, of_vertices = np.zeros(len(mesh.polygons), bool), np.zeros(len(mesh.vertices), bool)
    of_faces[list(faces)] = True
    if faces:
        vertices = {v for f in faces for v in mesh.polygons[f].vertices}
    of_vertices[list(vertices)] = True
    mesh.vertices.foreach_set("select", of_vertices)
    mesh.edges.foreach_set("select", np.zeros(len(mesh.edges), bool))
    mesh.polygons.foreach_set("select", of_faces)


def frame_view(context) -> None:
    """The first 3D view of each window looks at what is selected."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            region = next((each for each in area.regions if each.type == "WINDOW"), None)
            if area.type == "VIEW_3D" and region is not None:
                with context.temp_override(window=window, area=area, region=region):
                    bpy.ops.view3d.view_selected()
                break
