"""Mends the animation of a mesh, whatever moves it, until it passes through nothing.

The folder of a mended object, mend/NAME, is laid out as that of a bake: blender.json, its mesh, and the cache that is shown. All
is made in a folder within it, work.*, and moves from there once the result is whole. So what ends early leaves nothing.
"""
import os
import re
import shutil
import tempfile
import time
from typing import Any, Dict, Iterator, List, Optional, Set, Tuple

import bpy
import numpy as np

from . import bake, caches, export, files, meshes, selection, stack, waiting
from .files import MESH_FOLDER
from .job import SLICE, Job, find_folder, tell_rest
from .meshes import Refusal
from .parts import Part, Reader, is_in_all, make_name
from .program import Process

FOLDER = files.MEND_FOLDER
WORK_PREFIX, RESULT_FILE, GIVEN_FILE, CACHE_FILE = "work.", "mended.pc2", "given.pc2", "cache.pc2"
ROLE = "MENDED"
COLORS = "departure"


def is_met(scene, obj) -> bool:
    """Whether the cloth that is mended meets an object."""
    if obj.tulle.role in ("OBSTACLE", "BODY"):
        return True
    collides = obj.tulle.role == "NONE" and any(each.type == "COLLISION" for each in obj.modifiers)
    return collides or (scene.tulle.all_obstacles and is_in_all(obj))


class Recording(Reader):
    """The cloth as it is given, and the bodies, as meshes and point caches."""

    def __init__(self, context, obj, folder: str, name: str):
        super().__init__(context, folder)
        self.cloth = Part(obj, ROLE, name)
        self.given: Optional[meshes.Pc2Writer] = None

    def choose_parts(self) -> None:
        obj = self.cloth.obj
        if obj.library is not None:
            raise Refusal("'%s' is linked from another file: make a library override of it first" % obj.name, [obj.name])
        if self.last <= self.first:
            raise Refusal("The frame range has a single frame: set the end of the scene behind its start")
        taken = {self.cloth.name.lower()}
        met = [each for each in self.context.view_layer.objects if each is not obj and is_met(self.scene, each)]
        for each in sorted(met, key=lambda other: other.name_full):
            self.parts.append(Part(each, "OBSTACLE", make_name(each.name, taken)))
        self.parts.append(self.cloth)

    def run(self) -> Iterator[float]:
        """Reads all frames and writes all files. Blender's own cloth that is not baked runs meanwhile, from its own start."""
        self.choose_parts()
        obj = self.cloth.obj
        os.makedirs(os.path.join(self.folder, MESH_FOLDER), exist_ok=True)
        for modifier in stack.list_other_in_render(obj):
            self.note("'%s': the modifier '%s' before the cache differs in a render" % (obj.name, modifier))
        is_baked = any(stack.is_cache(each) and not stack.is_mended(each) for each in obj.modifiers)
        unmuted = [] if is_baked else [each.name for each in stack.list_muted(obj) if not each.show_viewport]
        try:
            for name in unmuted:
                obj.modifiers[name].show_viewport = True
            with stack.reading(self.context, [obj], [part.obj for part in self.parts[:-1]], stack.list_behind):
                for part in self.parts:
                    if not part.obj.visible_get():
                        raise Refusal("'%s' is hidden by its collection: show the collection" % part.obj.name, [part.obj.name])
                frames = range(self.find_start(), self.last + 1)
                for number, frame in enumerate(frames):
                    self.scene.frame_set(frame)
                    if frame >= self.first:
                        self.read_frame(frame - self.first)
                    yield (number + 1) / len(frames)
        finally:
            for name in unmuted:
                if name in obj.modifiers:
                    obj.modifiers[name].show_viewport = False
        export.write_links(self)

    def find_start(self) -> int:
        """The frame from which Blender's own simulation of the cloth leads to the first one that is read."""
        starts = [
            each.point_cache.frame_start
            for each in self.cloth.obj.modifiers
            if each.type in ("CLOTH", "SOFT_BODY") and each.show_viewport and not each.point_cache.is_baked
        ]
        return min([self.first] + starts)

    def begin_part(self, part: Part, pieces) -> None:
        super().begin_part(part, pieces)
        if part is self.cloth:
            part.thin = np.empty(0, np.int64)  # all its triangles are written
            self.given = meshes.Pc2Writer(os.path.join(self.folder, GIVEN_FILE), sum(part.counts))
            self.keep_given(pieces)

    def follow_part(self, part: Part, pieces) -> None:
        super().follow_part(part, pieces)
        if part is self.cloth:
            self.keep_given(pieces)

    def keep_given(self, pieces) -> None:
        """The given places in the space of the object, which vertices that are not away keep to the bit."""
        assert self.given is not None
        if abs(np.linalg.det(self.cloth.matrices[-1][:3, :3])) < 1e-12:
            name = self.cloth.obj.name
            raise Refusal("'%s' is scaled to nothing in frame %d" % (name, self.scene.frame_current), [name])
        self.given.append(pieces[0][0])

    def make_arguments(self) -> List[str]:
        """Of `tulle mend`, to be run in the folder."""
        cloth = self.cloth
        meshes.write_obj(self.get_path(cloth.name + ".obj"), cloth.world, cloth.corners)
        self.note_rounding(cloth)
        arguments = ["mend", self.name_file(cloth, ".pc2"), "--mesh", self.name_file(cloth, ".obj")]
        for part in self.parts[:-1]:
            corners = np.delete(part.corners, part.thin, axis=0)
            if len(corners) == 0:
                raise Refusal("'%s' has no face with an area" % part.obj.name, [part.obj.name])
            meshes.write_obj(self.get_path(part.name + ".obj"), part.world, corners)
            if export.has_no_motion(part):
                os.remove(part.writer.path)
                arguments += ["--body", self.name_file(part, ".obj")]
            else:
                self.note_rounding(part)
                arguments += ["--body", self.name_file(part, ".pc2"), "--body-mesh", self.name_file(part, ".obj")]
        arguments += ["-o", RESULT_FILE, "--json", "--strength", repr(float(cloth.obj.tulle.strength))]
        if self.scene.tulle.threads > 0:
            arguments += ["-t", str(self.scene.tulle.threads)]
        return arguments

    def name_file(self, part: Part, ending: str) -> str:
        return "%s/%s%s" % (MESH_FOLDER, part.name, ending)


class Mending(Job):
    """Reads the scene, runs the program, and shows the result once it is whole."""

    def __init__(self, context, obj, in_window: bool = False):
        folder = choose_folder(context.scene, obj)
        super().__init__(context, folder, in_window)
        remove_work(folder)  # what Blender left where it was killed
        os.makedirs(folder, exist_ok=True)
        self.work = tempfile.mkdtemp(prefix=WORK_PREFIX, dir=folder)
        self.object_name = obj.name
        self.answers: List[Dict[str, Any]] = []
        self.summary: Dict[str, Any] = {}
        self.result: Optional[Iterator[None]] = None
        self.code = 0
        self.rounding = ""  # what is told of the cache
        self.began = 0.0
        self.recording = Recording(context, obj, self.work, os.path.basename(folder))
        self.begin_reading(self.recording.run())

    def advance(self, context) -> None:
        super().advance(context)
        if self.is_over:
            self.clear()

    def end(self) -> None:
        super().end()
        self.clear()

    def clear(self) -> None:
        """Nothing but a whole result stays."""
        remove_work(self.folder)
        top = os.path.dirname(self.folder)
        for folder in (self.folder, top, os.path.dirname(top)):
            caches.remove_all(folder, [], [""])

    def start(self) -> None:
        arguments = self.recording.make_arguments()
        self.words = list(self.recording.notes)
        self.process, self.began = Process(arguments, self.work), time.monotonic()
        self.tell("MENDING", 0.1, "Starting")

    def advance_run(self, context) -> None:
        if self.result is not None:
            self.advance_result(context)
            return
        assert self.process is not None
        code = self.process.get_code()
        for answer in self.process.poll():
            self.hear(answer)
        if code is not None:
            self.finish(context, code)

    def hear(self, answer: Dict[str, Any]) -> None:
        if "frames" in answer:
            self.summary = answer
        elif "frame" in answer:
            self.answers.append(answer)
            done, count = len(self.answers), len(self.recording.cloth.matrices)
            rest = (time.monotonic() - self.began) / done * (count - done)
            words = "Frame %d of %d%s" % (self.recording.first + done - 1, self.recording.last, tell_rest(rest))
            self.tell("MENDING", 0.1 + 0.8 * done / count, words)

    def finish(self, context, code: int) -> None:
        assert self.process is not None
        said, self.process, self.code = self.process.words, None, code
        if code in (0, 1) and self.summary:
            self.result = self.write_result()
        elif code == 130 or (self.is_cancelled and code < 0):
            self.tell("CANCELLED", None, "Cancelled; nothing was changed", "\n".join(self.words))
        else:
            self.fail(context, "\n".join(said) or "tulle ended with code %d" % code, [], code)

    def write_result(self) -> Iterator[None]:
        """The cache in the space of the object."""
        cloth, scale = self.recording.cloth, self.recording.scale
        given = meshes.Pc2Reader(os.path.join(self.work, GIVEN_FILE))
        before = meshes.Pc2Reader(cloth.writer.path)
        after = meshes.Pc2Reader(os.path.join(self.work, RESULT_FILE))
        writer = meshes.Pc2Writer(os.path.join(self.work, CACHE_FILE), given.vertex_count)
        for frame, matrix in enumerate(cloth.matrices):
            places, mended = given.read(frame).astype(np.float64), after.read(frame)
            is_away = np.any(mended != before.read(frame), axis=1)
            local = meshes.to_local(mended[is_away].astype(np.float64), matrix, scale)
            self.rounding = self.rounding or meshes.tell_rounding(self.object_name, local, matrix, scale)
            places[cloth.used[is_away]] = local
            writer.append(places)
            yield

    def keep_result(self) -> str:
        """Moves the cache and what `check` reads of it to where they stay; the path of the cache."""
        name = self.recording.cloth.name
        cache = os.path.join(export.CACHE_FOLDER, name + ".pc2")
        mesh = os.path.join(MESH_FOLDER, name + ".obj")
        for source, path in ((mesh, mesh), (export.LINK_FILE, export.LINK_FILE), (CACHE_FILE, cache)):
            os.makedirs(os.path.dirname(os.path.join(self.folder, path)), exist_ok=True)
            os.replace(os.path.join(self.work, source), os.path.join(self.folder, path))
        return os.path.join(self.folder, cache)

    def advance_result(self, context) -> None:
        assert self.result is not None
        end = time.monotonic() + SLICE
        while time.monotonic() < end:
            if self.is_cancelled:
                self.result.close()
                self.tell("CANCELLED", None, "Cancelled; nothing was changed")
                return
            try:
                next(self.result)
            except StopIteration:
                self.show(context)
                return

    def show(self, context) -> None:
        scene = bpy.data.scenes.get(self.scene_name)
        obj = scene.objects.get(self.object_name) if scene is not None else None
        if obj is None:
            raise Refusal("'%s' is not there any more" % self.object_name)
        departures = self.measure_worst()
        caches.set_modifier(obj, self.keep_result(), self.recording.first, is_mended=True)
        color(context, obj, self.recording.cloth, departures)
        words = "Mended" if self.summary["frames_away"] else "As it was: nothing intersects"
        self.tell("FINISHED", 1.0, words, "\n".join(self.list_words(scene) + self.words + [self.rounding] * bool(self.rounding)))

    def measure_worst(self) -> np.ndarray:
        """[m] how far each vertex that was written is away in the worst frame."""
        frame = self.summary["worst_frame"]
        if not self.summary["frames_away"] or frame is None:
            return np.zeros(len(self.recording.cloth.used))
        before = meshes.Pc2Reader(self.recording.cloth.writer.path).read(frame)
        after = meshes.Pc2Reader(os.path.join(self.work, RESULT_FILE)).read(frame)
        return np.linalg.norm(after.astype(np.float64) - before, axis=1)

    def list_words(self, scene) -> List[str]:
        """What became of it, for the panel."""
        said, cloth, first = self.summary, self.recording.cloth, self.recording.first
        counts = []
        for when in ("before", "after"):
            frames = [answer for answer in self.answers if answer["own_" + when] + answer["bodies_" + when] > 0]
            pairs = [answer["own_" + when] + answer["bodies_" + when] for answer in frames]
            counts.append("up to %d in %d frames" % (max(pairs), len(frames)) if pairs else "0")
        words = ["'%s': pairs of triangles that intersect: %s before, %s after" % (cloth.obj.name, *counts)]
        if said["frames_away"]:
            # Blender writes lengths in the unit of the scene; without one a number in units of Blender.
            system, length = scene.unit_settings.system, said["largest_departure"]
            length = length / self.recording.scale if system == "NONE" else length
            words.append(
                "%d of %d frames were changed. The largest departure is %s, in frame %d at vertex %d"
                % (
                    said["frames_away"], said["frames"], bpy.utils.units.to_string(system, "LENGTH", length, precision=4),
                    first + said["worst_frame"], cloth.used[said["vertex"]],
                )
            )  # fmt: skip
            words.append("The color attribute '%s' shows it: Viewport Shading > Color > Attribute" % COLORS)
        if self.code == 1:
            lags = [first + answer["frame"] for answer in self.answers if answer["own_after"] + answer["bodies_after"] > 0]
            words.append("Something is left%s: obstacles leave the cloth no room" % (" in frame %d" % lags[0] if lags else ""))
        return words

    def fail(self, context, words: str, objects: List[str], code: int = 0) -> None:
        """Tells why, and selects what the words name."""
        self.stop_process()
        links = caches.read_json(os.path.join(self.work, export.LINK_FILE))
        if code and links:
            words, frame = self.translate(words, {link["name"] for link in links["bodies"]})
            picks = selection.Picks()
            selection.read_words(words, links, picks)
            if picks.list_bodies() and self.object_name in context.view_layer.objects:
                chosen = selection.select_bodies(context, links, picks, frame, only=self.object_name)
                words = selection.tell_face(words, chosen, frame)
            elif self.object_name in context.view_layer.objects:
                context.scene.frame_set(frame)
                selection.select(context, {self.object_name: (set(), set())})
        elif objects:
            selection.select(context, {name: (set(), set()) for name in objects if name in context.view_layer.objects})
        self.tell("FAILED", None, "Not mended", words)

    def translate(self, words: str, names: Set[str]) -> Tuple[str, int]:
        """The program's words with names in place of files, and frames of the scene in place of those of the cache; the first
        of these frames."""
        first, frames = self.recording.first, [int(frame) for frame in re.findall(r"\bframe (\d+)", words)]
        words = words.replace("'the cloth'", "'%s'" % self.recording.cloth.name)
        words = re.sub(r"'?\b%s/([A-Za-z0-9._-]+)\.(?:obj|pc2)\b'?" % MESH_FOLDER, r"'\1'", words)
        words = re.sub(r"\bframe (\d+)", lambda found: "frame %d" % (first + int(found[1])), words)
        said = re.match(r"'[^']+': (frame \d+: (.*))", words, re.DOTALL)
        if said and any("'%s'" % name in said[2] for name in names):  # what follows says whose it is
            words = said[1]
        return words, first + (frames[0] if frames else 0)


def color(context, obj, cloth: Part, departures: np.ndarray) -> None:
    """A color attribute of the object's own mesh: white where nothing is away, red where the departure is the largest."""
    mesh = obj.data
    if mesh.library is not None:
        return
    _, of_vertices = selection.find_originals(context, obj, None)
    shares = np.zeros(len(mesh.vertices))
    originals = of_vertices[cloth.used] if len(of_vertices) > cloth.used.max() else np.full(len(cloth.used), -1)
    known = originals >= 0
    np.maximum.at(shares, originals[known], departures[known] / max(float(departures.max()), 1e-30))
    if COLORS in mesh.color_attributes:
        mesh.color_attributes.remove(mesh.color_attributes[COLORS])
    if not shares.any():
        return
    colors = np.ones((len(shares), 4), np.float32)
    colors[:, 1] = colors[:, 2] = 1.0 - shares
    attribute = mesh.color_attributes.new(COLORS, "FLOAT_COLOR", "POINT")
    attribute.data.foreach_set("color", colors.ravel())
    mesh.color_attributes.active_color = attribute
    mesh.update()


def choose_folder(scene, obj) -> str:
    """That of the object, named after it; no other object of the scene has it."""
    top, taken = os.path.join(find_folder(scene), FOLDER), set()
    while True:
        folder = os.path.join(top, make_name(obj.name, taken))
        files.check_folder(folder)
        links = files.read_links(folder)
        owner = links["bodies"][-1]["object"] if links and links["bodies"] else obj.name
        if owner == obj.name or owner not in scene.objects:
            return folder


def remove_work(folder: str) -> None:
    """What ended before its result was whole."""
    for name in os.listdir(folder) if os.path.isdir(folder) else []:
        if name.startswith(WORK_PREFIX):
            shutil.rmtree(os.path.join(folder, name), ignore_errors=True)


def remove_files(folder: str) -> None:
    """Removes what was written of mended objects, and nothing else."""
    top = os.path.join(folder, FOLDER)
    if not os.path.isdir(top):
        return
    for name in sorted(os.listdir(top)):
        files.check_folder(os.path.join(top, name))
        remove_work(os.path.join(top, name))
        caches.remove_files(os.path.join(top, name))
        caches.remove_all(top, [], [name])
    caches.remove_all(folder, [], [FOLDER, ""])


class TULLE_OT_mend(waiting.Waiting, bpy.types.Operator):
    """Moves the active mesh, whatever moves it, as little as it takes so that it passes through neither itself nor obstacles in
    any frame, and shows the result by a Mesh Cache"""

    bl_idname = "tulle.mend"
    bl_label = "Mend"
    not_done = "Not mended"

    @classmethod
    def poll(cls, context):
        return bake.current is None and context.object is not None and context.object.type == "MESH"

    def make_job(self, context, in_window: bool) -> Job:
        return Mending(context, context.object, in_window)


def register() -> None:
    bpy.utils.register_class(TULLE_OT_mend)


def unregister() -> None:
    bpy.utils.unregister_class(TULLE_OT_mend)
