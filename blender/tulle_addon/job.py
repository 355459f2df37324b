"""Work that is under way, whoever waits for it: a timer in the window, or a loop where a script calls the operator. It reads
the scene frame by frame, then runs the program."""
import os
import time
from typing import Any, Iterator, List, Optional

import bpy

from . import files, program
from .meshes import Refusal

SLICE = 0.1  # [s] that the window waits for at most, while the scene is read and caches grow


def find_folder(scene) -> str:
    """Where files lie. Files beside each other have folders of their own, unless the scene names one."""
    named = scene.tulle.folder
    if (not named or named.startswith("//")) and not bpy.data.is_saved:
        raise Refusal("Save the file first: the folder %slies beside it" % (named and named + " "))
    stem = os.path.splitext(os.path.basename(bpy.data.filepath))[0]
    folder = os.path.abspath(bpy.path.abspath(named or "//tulle_" + stem))
    files.check_folder(folder)
    return folder


class Job:
    """`advance` does a little of it; `state` becomes FINISHED, CANCELLED, FAILED or CHANGED at the end.

    A subclass says what is read, starts the program in `start`, follows it in `advance_run`, and ends there or in `fail`."""

    def __init__(self, context, folder: str, in_window: bool = False):
        self.is_in_window = in_window
        self.scene_name, self.folder = context.scene.name, folder
        self.first = context.scene.frame_start
        self.process: Optional[program.Process] = None
        self.reading: Optional[Iterator[float]] = None
        self.is_cancelled = False
        self.words: List[str] = []
        self.state = ""
        program.find_program()

    def begin_reading(self, reading: Iterator[float]) -> None:
        self.reading = reading
        self.tell("EXPORTING", 0.0, "Reading the scene", "")

    def start(self) -> None:
        raise NotImplementedError

    def advance_run(self, context) -> None:
        raise NotImplementedError

    def fail(self, context, words: str, objects: List[str], code: int = 0) -> None:
        raise NotImplementedError

    def tell(self, state: str, share: Optional[float], status: str, report: Optional[str] = None) -> None:
        self.state = state
        scene = bpy.data.scenes.get(self.scene_name)
        if scene is None:
            return
        scene.tulle.state, scene.tulle.status = state, status
        if share is not None:
            scene.tulle.progress = 100.0 * share
        if report is not None:
            scene.tulle.report = report

    @property
    def is_over(self) -> bool:
        return self.state in ("FINISHED", "CANCELLED", "FAILED", "CHANGED")

    def cancel(self) -> None:
        """A second call does not wait for the end of the step."""
        self.is_cancelled = True
        if self.process:
            self.process.interrupt()

    def end(self) -> None:
        """Ends what is under way, where nobody waits for it any more."""
        self.cancel()
        if self.process is not None:
            self.process.wait(60)

    def advance(self, context) -> None:
        try:
            if self.reading is not None:
                self._advance_reading()
            else:
                self.advance_run(context)
        except Refusal as refusal:
            self.fail(context, str(refusal), refusal.objects)
        except OSError as error:
            self.fail(context, "Files could not be written or read: %s" % error, [])
        except ReferenceError:
            self.fail(context, "The scene was changed by others while it was read; begin again", [])

    def _advance_reading(self) -> None:
        end = time.monotonic() + SLICE
        while self.reading is not None and time.monotonic() < end:
            if self.is_cancelled:
                self.reading.close()
                self.reading = None
                self.tell("CANCELLED", 0.0, "Cancelled")
                return
            try:
                self.tell("EXPORTING", 0.1 * next(self.reading), "Reading the scene")
            except StopIteration:
                self.reading = None
                self.start()

    def stop_process(self) -> None:
        if self.process:
            self.process.interrupt()
            self.process.wait(30)
            self.process = None
        self.reading = None


def tell_rest(seconds: Any) -> str:
    """How long it still takes, in words; empty where that is not known."""
    if seconds is None:
        return ""
    return ", %d min left" % round(seconds / 60) if seconds > 90 else ", %d s left" % round(seconds)
