"""A bake that is under way; the one job that there is at a time."""
import atexit
import os
import time
from typing import Any, List, Optional

import bpy
from bpy.app.handlers import persistent

from . import caches, export, files, program, selection
from .job import SLICE, Job, find_folder, tell_rest
from .meshes import Refusal

LEFT_FILE = "left.csv"
LOCKED = "is locked: another process"
CHANGED = "cannot be resumed: "
NO_VELOCITIES, OTHER_BODY = "keeps no velocities", "no rigid body '"
SAME_RATE = 1e-9  # part of a frame's length by which that of the run may differ, since both are rounded

current: Optional[Job] = None  # a bake or a mending


class Bake(Job):
    """Export, run, caches. What is baked stays when it is cancelled."""

    def __init__(self, context, restarts: bool = False, in_window: bool = False, from_frame: Optional[int] = None):
        super().__init__(context, find_folder(context.scene), in_window)
        self.follows = in_window and context.scene.tulle.follow  # the view goes to the last whole frame
        self.usual_frame = context.scene.frame_current
        self.restarts = restarts
        self.from_frame = from_frame  # the last one that is kept; None: all that are there, or none
        self.caches: Optional[caches.Caches] = None
        self.has_begun = False  # files of the run are there, and cut back to where it goes on
        caches.settle(self.folder)
        if from_frame is not None:
            self.check_frame(context.scene, from_frame)
        self._export = export.Export(context, self.folder)
        self.begin_reading(self._export.run())

    def check_frame(self, scene, frame: int) -> None:
        held = caches.count_whole_frames(self.folder) if caches.has_run(self.folder) else 0
        if held == 0:
            raise Refusal("There is nothing to go on from: bake first")
        last = min(self.first + held - 1, scene.frame_end - 1)
        if not self.first <= frame <= last:
            raise Refusal(
                "Frame %d cannot be gone on from: choose a frame from %d to %d" % (frame, self.first, last)
            )
        links = files.read_links(self.folder) or {}
        if links.get("frame_start") != self.first:
            raise Refusal("The frames that are there start at another frame than the scene: bake anew")
        interval = (caches.read_json(os.path.join(self.folder, export.RUN_FOLDER, "run.json")) or {}).get("frame_interval", 0.0)
        if abs(interval * export.get_fps(scene) - 1) > SAME_RATE:
            raise Refusal("The frames that are there have another frame rate than the scene: bake anew")
        lagging = caches.list_lagging(self.folder)
        free = [self.first + number for number, lags in enumerate(lagging) if not lags and self.first + number <= last]
        if frame not in free:
            nearest = min(free, key=lambda each: abs(each - frame))
            raise Refusal(
                "An obstacle lags behind in frame %d, and cannot be gone on from there: choose another one, as frame %d"
                % (frame, nearest)
            )

    def end(self) -> None:
        super().end()
        caches.settle(self.folder)

    def start(self) -> None:
        """Starts the program, which goes on where it can."""
        scene = bpy.data.scenes[self.scene_name]
        left = os.path.join(self.folder, LEFT_FILE)
        files.remove(left)
        arguments = ["run", export.SCENE_FILE, "-o", export.RUN_FOLDER, "--progress", "json", "--list-left", LEFT_FILE]
        arguments += ["--record", "velocities"]
        if self.from_frame is not None:
            caches.put_aside(self.folder)
            arguments += ["--from", "%s:%d" % (export.BEFORE_FOLDER, self.from_frame - self.first)]
        elif self.restarts and caches.has_run(self.folder):
            arguments += ["--force"]
        else:
            arguments += ["--resume"]
        if scene.tulle.threads > 0:
            arguments += ["-t", str(scene.tulle.threads)]
        self.words = list(self._export.notes)
        self.process = program.Process(arguments, self.folder)
        self.tell("RUNNING", 0.1, "Starting")

    def advance_run(self, context) -> None:
        assert self.process is not None
        code = self.process.get_code()
        for event in self.process.poll():
            self.hear(event)
        if self.caches is not None:
            self.grow(context)
        elif os.path.exists(os.path.join(self.folder, export.RUN_FOLDER, "frames.csv")) and self.has_begun:
            self.caches = caches.Caches(self.folder)
        if code is not None:
            self.finish(context, code)

    def hear(self, event: dict) -> None:
        kind = event["event"]
        if kind == "checkpoint":
            self.has_begun = True
        elif kind == "step":
            self.has_begun = True
            share = event["step"] / max(1, event["steps"])
            rest = tell_rest(event["rest_seconds"])
            self.tell(
                "RUNNING",
                0.1 + 0.9 * share,
                "Frame %d of %d%s" % (self.first + event["frame"], self.first + event["frames"], rest),
            )
        elif kind == "substep":
            self.tell("RUNNING", None, "A hard step: %d %% after %d s" % (100 * event["share"], event["seconds"]))
        elif kind == "untangle":
            self.tell("RUNNING", None, "Untangling: %d of %d intersections left" % (event["left"], event["intersections"]))
        elif kind == "message":
            self.words.append(event["message"])

    def grow(self, context) -> None:
        """Takes over frames that are whole, and shows them."""
        assert self.caches is not None
        end, fresh = time.monotonic() + SLICE, 0
        while time.monotonic() < end:
            taken = self.caches.update(1)
            if taken == 0:
                break
            fresh += taken
        scene = bpy.data.scenes.get(self.scene_name)
        if fresh and scene is not None:
            self.caches.show(scene)
            if self.follows and not (context.screen and context.screen.is_animation_playing):
                scene.frame_set(self.caches.frame_start + self.caches.frame_count - 1)

    def finish(self, context, code: int) -> None:
        assert self.process is not None
        words = self.process.words
        self.process = None
        self.end_following()
        caches.settle(self.folder)
        if any(NO_VELOCITIES in line for line in words):
            words = ["The frames that are there were baked without velocities: bake anew once, then from any frame"]
        other = next((line.split(OTHER_BODY)[1].split("'")[0] for line in words if OTHER_BODY in line), None)
        if other:
            words = ["'%s' is no longer the rigid body that it was in the first frame, or is elsewhere there: bake anew" % other]
        if code == 2 and any(CHANGED in line for line in words):
            self.tell(
                "CHANGED", None, "The scene has changed since it was baked", "Bake anew to replace the frames that are there."
            )
            return
        if caches.has_run(self.folder) and (code != 2 or self.has_begun):
            self.take_over()
        frames = self.caches.frame_count if self.caches else 0
        self.words += [body.note for body in self.caches.bodies if body.note] if self.caches else []
        if code == 0:
            self.tell("FINISHED", 1.0, "%d frames" % frames, "\n".join(self.words + words))
        elif code == 130 or (self.is_cancelled and code < 0):
            self.tell("CANCELLED", None, "Cancelled after %d frames; Bake goes on from there" % frames, "\n".join(self.words))
        else:
            if any(LOCKED in line for line in words):
                words.append("A bake that Blender left behind may still run there. Press Bake again when it has ended.")
            self.words += words or ["tulle ended with code %d" % code]
            self.fail(context, "\n".join(words) or self.words[-1], [], code)

    def end_following(self) -> None:
        """Back to the frame that was shown before."""
        if self.follows and self.scene_name in bpy.data.scenes:
            bpy.data.scenes[self.scene_name].frame_set(self.usual_frame)
            self.follows = False

    def take_over(self) -> None:
        """All frames that are there, and the modifiers."""
        if self.caches is None:
            self.caches = caches.Caches(self.folder)
        self.caches.update()
        self.caches.show(bpy.data.scenes[self.scene_name])

    def fail(self, context, words: str, objects: List[str], code: int = 0) -> None:
        """Tells why, and selects what the words name."""
        if self.process:
            self.stop_process()
            caches.settle(self.folder)
        self.reading = None
        self.end_following()
        picks = selection.Picks()
        links = files.read_links(self.folder) if code else None
        if code and links:
            is_start = selection.read_left(os.path.join(self.folder, LEFT_FILE), picks)
            if is_start:  # in the artist's words first; of the pairs the deepest, since all are selected
                words = (
                    "Parts intersect at the start. Move those that are selected apart, press Untangle, or set At the Start to "
                    "Untangle.\n" + words.split(";")[0]
                )
            else:
                selection.read_words(words, links, picks)
            if picks.list_bodies():
                words = selection.tell_face(words, selection.select_bodies(context, links, picks), links["frame_start"])
        elif objects:
            selection.select(context, {name: (set(), set()) for name in objects if name in context.view_layer.objects})
        self.tell(
            "FAILED", None, "Not baked" if not self.caches else "Stopped after %d frames" % self.caches.frame_count, words
        )


def stop() -> None:
    """Ends a job that nobody waits for any more: the file or Blender is closed. The next bake goes on from its last
    checkpoint."""
    global current
    if current is not None:
        job, current = current, None
        job.end()


@persistent
def tell_after_load(*_: Any) -> None:
    """A file that was saved while it was baked says so."""
    for scene in bpy.data.scenes:
        if scene.tulle.state in ("EXPORTING", "RUNNING"):
            scene.tulle.state, scene.tulle.status = "CANCELLED", "The bake was cut short; Bake goes on from there"
        elif scene.tulle.state == "MENDING":
            scene.tulle.state, scene.tulle.status = "CANCELLED", "The mending was cut short"


@persistent
def stop_before_load(*_: Any) -> None:
    stop()


def register() -> None:
    bpy.app.handlers.load_pre.append(stop_before_load)
    bpy.app.handlers.load_post.append(tell_after_load)
    atexit.register(stop)


def unregister() -> None:
    stop()
    atexit.unregister(stop)
    bpy.app.handlers.load_pre.remove(stop_before_load)
    bpy.app.handlers.load_post.remove(tell_after_load)
