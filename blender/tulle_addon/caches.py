"""Frames of a run as point caches in the space of the objects, and the Mesh Cache modifier that shows them.

A run holds frames in world space and metres. The cache of an object holds them in the object's own space, with its loose
vertices, and grows with the run; it is whole up to the count in its head at any moment.
"""
import csv
import os
from typing import Any, Dict, List, Optional

import bpy
import numpy as np

from . import meshes, stack
from .files import BEFORE_FOLDER, CACHE_FOLDER, LINK_FILE, MESH_FOLDER, RUN_FOLDER, is_name, read_json, read_links
from .meshes import Refusal


def count_whole_frames(folder: str) -> int:
    """Frames of the run that are in all its caches: a line of frames.csv is written after them."""
    try:
        with open(os.path.join(folder, RUN_FOLDER, "frames.csv"), "rb") as file:
            return max(0, file.read().count(b"\n") - 1)
    except OSError:
        return 0


def list_lagging(folder: str) -> List[bool]:
    """Of each whole frame of the run whether an obstacle lags behind its frames there; the first never does."""
    with open(os.path.join(folder, RUN_FOLDER, "frames.csv"), encoding="utf-8", newline="") as file:
        return [bool(row.get("lags")) for row in csv.DictReader(file)]


class BodyCache:
    """The cache of one object."""

    def __init__(self, folder: str, link: Dict[str, Any], run_file: str, scale: float):
        self.object_name, self.scale = link["object"], scale
        self.source = meshes.Pc2Reader(os.path.join(folder, RUN_FOLDER, run_file))
        self.matrices = [np.array(matrix) for matrix in link["matrices"]]
        self.loose = np.array(link["loose"], np.int64)
        self.loose_places = np.array(link["loose_places"], np.float64).reshape(-1, 3)
        self.used = np.setdiff1d(np.arange(link["vertices"]), self.loose)
        if self.source.vertex_count != len(self.used) or len(self.used) + len(self.loose) != link["vertices"]:
            raise Refusal("The run has another mesh for '%s' than the export: bake anew" % self.object_name)
        os.makedirs(os.path.join(folder, CACHE_FOLDER), exist_ok=True)
        self.path = os.path.join(folder, CACHE_FOLDER, link["name"] + ".pc2")
        self.writer = meshes.Pc2Writer(self.path, link["vertices"])
        self.note = ""

    def append(self, frame: int) -> None:
        places = np.empty((len(self.used) + len(self.loose), 3))
        places[self.used] = meshes.to_local(self.source.read(frame), self.matrices[frame], self.scale)
        places[self.loose] = self.loose_places
        self.note = self.note or meshes.tell_rounding(self.object_name, places[self.used], self.matrices[frame], self.scale)
        self.writer.append(places)


class Caches:
    """Caches of all objects of a run. They are made anew from the first frame on whenever a run begins or goes on: what the
    run holds is compared with checksums before it goes on, what lies here is not."""

    def __init__(self, folder: str):
        self.folder, self.frame_count = folder, 0
        links = read_links(folder)
        if links is None or not has_run(folder):
            raise Refusal("There are no results in %s" % folder)
        self.frame_start, self.frame_end = links["frame_start"], links["frame_end"]
        files = {body["name"]: body.get("cache") for body in list_run_bodies(folder, RUN_FOLDER)}
        simulated = [link for link in links["bodies"] if link["role"] in ("CLOTH", "BODY")]
        missing = [link["object"] for link in simulated if not files.get(link["name"])]
        if missing:
            raise Refusal("The run holds no frames of '%s': bake anew" % missing[0])
        self.bodies = [BodyCache(folder, link, files[link["name"]], links["scale"]) for link in simulated]

    def update(self, most: int = 1 << 30) -> int:
        """Appends what is new, `most` frames at once; how many there were."""
        frames = min(
            [count_whole_frames(self.folder), self.frame_end - self.frame_start + 1]
            + [body.source.count_frames() for body in self.bodies]
        )
        fresh = min(frames - self.frame_count, most)
        for frame in range(self.frame_count, self.frame_count + fresh):
            for body in self.bodies:
                body.append(frame)
            self.frame_count = frame + 1
        return max(0, fresh)

    def show(self, scene) -> None:
        """Gives each object its modifier, and has the view drawn again."""
        for body in self.bodies:
            obj = scene.objects.get(body.object_name)
            if obj is not None and self.frame_count > 0:
                set_modifier(obj, body.path, self.frame_start)


def find_modifier(obj):
    """The cache that decides what is seen."""
    return next((modifier for modifier in reversed(obj.modifiers) if stack.is_cache(modifier)), None)


def is_ours(obj) -> bool:
    """Whether an object is simulated, or shows a cache."""
    return obj.tulle.role in ("CLOTH", "BODY") or find_modifier(obj) is not None


def set_modifier(obj, path: str, frame_start: int, is_mended: bool = False) -> None:
    """The Mesh Cache right before the trailing run of modifiers; Blender's own cloth is switched off. What was mended before a
    bake goes."""
    for each in [each for each in obj.modifiers if stack.is_mended(each) and not is_mended]:
        obj.modifiers.remove(each)
    modifier = next((each for each in obj.modifiers if stack.is_cache(each) and stack.is_mended(each) == is_mended), None)
    is_new = modifier is None
    if is_new:
        modifier = obj.modifiers.new(stack.MENDED_NAME if is_mended else stack.CACHE_NAME, "MESH_CACHE")
    if is_new or is_mended:
        move_modifier(obj, modifier, stack.find_tail([each for each in obj.modifiers if each != modifier]))
    modifier.cache_format, modifier.deform_mode, modifier.interpolation = "PC2", "OVERWRITE", "LINEAR"
    modifier.play_mode, modifier.time_mode = "SCENE", "FRAME"
    modifier.forward_axis, modifier.up_axis = "POS_Y", "POS_Z"
    modifier.flip_axis = set() if isinstance(modifier.flip_axis, set) else (False, False, False)  # as before and in Blender 5
    modifier.frame_start, modifier.frame_scale, modifier.factor = frame_start, 1.0, 1.0
    modifier.filepath = make_relative(path)
    muted: List[str] = []
    for each in obj.modifiers:
        if each.type == "CLOTH" and (each.show_viewport or each.show_render):
            each.show_viewport = each.show_render = False
            muted.append(each.name)
    if muted:
        obj.tulle.muted_cloth = "\n".join(muted)
    obj.update_tag(refresh={"DATA"})


def make_relative(path: str) -> str:
    try:
        return bpy.path.relpath(path)
    except ValueError:  # another drive of Windows
        return path


def move_modifier(obj, modifier, index: int) -> None:
    if hasattr(obj.modifiers, "move"):
        obj.modifiers.move(list(obj.modifiers).index(modifier), index)
        return
    with bpy.context.temp_override(object=obj, active_object=obj, selected_objects=[obj]):
        bpy.ops.object.modifier_move_to_index(modifier=modifier.name, index=index)


def remove_modifier(obj) -> None:
    """Takes the caches off, and switches Blender's own cloth on again where it was."""
    for modifier in [each for each in obj.modifiers if stack.is_cache(each)]:
        obj.modifiers.remove(modifier)
    for modifier in stack.list_muted(obj):
        modifier.show_viewport = modifier.show_render = True
    obj.tulle.muted_cloth = ""


def has_run(folder: str, name: str = RUN_FOLDER) -> bool:
    return os.path.exists(os.path.join(folder, name, "run.json"))


def list_run_bodies(folder: str, name: str) -> List[Dict[str, Any]]:
    """Bodies of a run, as run.json has them, whose files lie in its own folder."""
    run = read_json(os.path.join(folder, name, "run.json")) or {}
    bodies = run.get("bodies", [])
    for body in bodies if isinstance(bodies, list) else [None]:
        if not isinstance(body, dict) or not all(not body.get(key) or is_name(body[key]) for key in ("mesh", "cache")):
            raise Refusal("%s names files that are not in its folder: bake anew" % os.path.join(folder, name, "run.json"))
    return bodies


def list_run_files(folder: str, name: str) -> List[str]:
    """What a run may hold, within the folder; run.json, which tells, is the last."""
    files = [body[key] for body in list_run_bodies(folder, name) for key in ("mesh", "cache") if body.get(key)]
    files += ["scene.yaml", "frames.csv", "bodies.csv", "report.csv", "checksums.csv", "debug.bin", "checkpoint.bin"]
    files += ["checkpoint.previous.bin", "run.json"]
    return [os.path.join(name, file) for file in files]


def remove_all(folder: str, files: List[str], folders: List[str]) -> None:
    for file in files:
        path = os.path.join(folder, file)
        if os.path.isfile(path):
            os.remove(path)
    for name in folders:
        try:
            os.rmdir(os.path.join(folder, name))
        except OSError:  # it holds something else, or is not there
            pass


def remove_run(folder: str, name: str) -> None:
    remove_all(folder, list_run_files(folder, name), [name])


def put_aside(folder: str) -> None:
    """The run makes room for one that begins with its frames."""
    os.replace(os.path.join(folder, RUN_FOLDER), os.path.join(folder, BEFORE_FOLDER))


def settle(folder: str) -> None:
    """What was put aside goes where the new run holds its frames, and comes back where it does not."""
    if not has_run(folder, BEFORE_FOLDER):
        return
    if os.path.exists(os.path.join(folder, RUN_FOLDER, "checkpoint.bin")):
        remove_run(folder, BEFORE_FOLDER)
        return
    remove_run(folder, RUN_FOLDER)
    os.replace(os.path.join(folder, BEFORE_FOLDER), os.path.join(folder, RUN_FOLDER))


def remove_files(folder: str) -> None:
    """Removes what the add-on wrote, and nothing else: a folder that holds other files stays."""
    links = read_links(folder)
    if links is None:
        return
    files = [os.path.join(CACHE_FOLDER, link["name"] + ".pc2") for link in links["bodies"]]
    files += [
        os.path.join(MESH_FOLDER, link["name"] + ending)
        for link in links["bodies"]
        for ending in (".obj", ".pc2", ".rest.obj", ".stiffness.txt")
    ]
    files += list_run_files(folder, RUN_FOLDER) + list_run_files(folder, BEFORE_FOLDER)
    remove_all(
        folder, files + ["scene.yaml", "left.csv", LINK_FILE], [CACHE_FOLDER, MESH_FOLDER, RUN_FOLDER, BEFORE_FOLDER, ""]
    )
