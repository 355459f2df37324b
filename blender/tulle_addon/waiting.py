"""An operator that waits for a job: in a window beside other work, in a script to its end."""
import time
from typing import Optional

import bpy

from . import bake
from .job import Job
from .meshes import Refusal


def report_end(operator, job: Job, scene) -> None:
    level = {"FINISHED": "INFO", "CANCELLED": "WARNING"}.get(job.state, "ERROR")
    if job.state == "CHANGED" and job.is_in_window:
        level = "WARNING"  # a question follows
    words = scene.tulle.status + (": " + scene.tulle.report if job.state in ("FAILED", "CHANGED") else "")
    if job.is_in_window:  # the panel has the rest
        words = words.split("\n")[0]
    operator.report({level}, words)


def redraw(context) -> None:
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type in ("VIEW_3D", "PROPERTIES", "DOPESHEET_EDITOR"):
                area.tag_redraw()


class Waiting:
    """What such operators have in common; one makes its job in `make_job`."""

    not_done = "Not baked"

    @classmethod
    def poll(cls, context):
        return bake.current is None

    def make_job(self, context, in_window: bool) -> Job:
        raise NotImplementedError

    def follow_end(self, job: Job) -> None:
        """What else there is to do in a window."""

    def begin(self, context, in_window: bool = False) -> Optional[Job]:
        """A new job, or none with the reason told."""
        if bake.current is not None:
            self.report({"ERROR"}, "A bake is under way")
            return None
        try:
            bake.current = self.make_job(context, in_window)
        except (Refusal, OSError) as refusal:
            values = context.scene.tulle
            values.state, values.status, values.report = "FAILED", self.not_done, str(refusal)
            self.report({"ERROR"}, str(refusal))
        return bake.current

    def execute(self, context):
        """Waits until all is done: for scripts."""
        job = self.begin(context)
        if job is None:
            return {"CANCELLED"}
        try:
            while not job.is_over:
                job.advance(context)
                if job.process is not None:
                    time.sleep(0.01)
        except BaseException:
            bake.stop()
            raise
        finally:
            bake.current = None
        report_end(self, job, context.scene)
        return {"FINISHED"} if job.state == "FINISHED" else {"CANCELLED"}

    def invoke(self, context, event):
        if bpy.app.background:
            return self.execute(context)
        if self.begin(context, in_window=True) is None:
            return {"CANCELLED"}
        self._timer = context.window_manager.event_timer_add(0.1, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        job = bake.current
        if job is None:
            return self.end(context, None)
        if event.type != "TIMER":  # while the scene is read nobody changes it
            if job.state == "EXPORTING" and event.type == "ESC":
                job.cancel()
            is_held = job.state == "EXPORTING" and event.type not in ("MOUSEMOVE", "WINDOW_DEACTIVATE")
            return {"RUNNING_MODAL"} if is_held else {"PASS_THROUGH"}
        try:
            job.advance(context)
        except Exception:
            bake.stop()
            self.end(context, None)
            raise
        redraw(context)
        if not job.is_over:
            return {"PASS_THROUGH"}
        bake.current = None
        report_end(self, job, context.scene)
        result = self.end(context, job)
        self.follow_end(job)
        return result

    def end(self, context, job: Optional[Job]):
        context.window_manager.event_timer_remove(self._timer)
        redraw(context)
        return {"FINISHED"} if job is not None and job.state == "FINISHED" else {"CANCELLED"}

    def cancel(self, context):
        bake.stop()
