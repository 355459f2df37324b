"""Operators: bake, cancel, free, and the way by a program on another machine."""
import time
from typing import Optional

import bpy

from . import bake, caches, export
from .meshes import Refusal


def report_end(operator, under_way: bake.Bake, scene) -> None:
    level = {"FINISHED": "INFO", "CANCELLED": "WARNING"}.get(under_way.state, "ERROR")
    if under_way.state == "CHANGED" and under_way.is_in_window:
        level = "WARNING"  # a question follows
    words = scene.tulle.status + (": " + scene.tulle.report if under_way.state in ("FAILED", "CHANGED") else "")
    if under_way.is_in_window:  # the panel has the rest
        words = words.split("\n")[0]
    operator.report({level}, words)


def begin(operator, context, in_window: bool = False) -> Optional[bake.Bake]:
    """A new bake, or none with the reason told."""
    if bake.current is not None:
        operator.report({"ERROR"}, "A bake is under way")
        return None
    try:
        from_frame = context.scene.frame_current if operator.from_frame else None
        bake.current = bake.Bake(context, operator.restart, in_window, from_frame)
    except (Refusal, OSError) as refusal:
        context.scene.tulle.state, context.scene.tulle.status, context.scene.tulle.report = "FAILED", "Not baked", str(refusal)
        operator.report({"ERROR"}, str(refusal))
    return bake.current


class TULLE_OT_bake(bpy.types.Operator):
    """Simulates the frames of the scene. A bake that was cancelled goes on where it ended"""

    bl_idname = "tulle.bake"
    bl_label = "Bake"
    restart: bpy.props.BoolProperty(
        name="Anew", description="Replace what is baked of another scene", default=False, options={"SKIP_SAVE"}
    )
    from_frame: bpy.props.BoolProperty(
        name="From Frame", description="Keep the frames up to the present one, and go on from there", default=False,
        options={"SKIP_SAVE"},
    )  # fmt: skip

    @classmethod
    def poll(cls, context):
        return bake.current is None

    def execute(self, context):
        """Waits until all is done: for scripts."""
        under_way = begin(self, context)
        if under_way is None:
            return {"CANCELLED"}
        try:
            while not under_way.is_over:
                under_way.advance(context)
                if under_way.process is not None:
                    time.sleep(0.01)
        except BaseException:
            bake.stop()
            raise
        finally:
            bake.current = None
        report_end(self, under_way, context.scene)
        return {"FINISHED"} if under_way.state == "FINISHED" else {"CANCELLED"}

    def invoke(self, context, event):
        if bpy.app.background:
            return self.execute(context)
        if begin(self, context, in_window=True) is None:
            return {"CANCELLED"}
        self._timer = context.window_manager.event_timer_add(0.1, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        under_way = bake.current
        if under_way is None:
            return self.end(context, None)
        if event.type != "TIMER":  # while the scene is read nobody changes it
            if under_way.state == "EXPORTING" and event.type == "ESC":
                under_way.cancel()
            is_held = under_way.state == "EXPORTING" and event.type not in ("MOUSEMOVE", "WINDOW_DEACTIVATE")
            return {"RUNNING_MODAL"} if is_held else {"PASS_THROUGH"}
        try:
            under_way.advance(context)
        except Exception:
            bake.stop()
            self.end(context, None)
            raise
        redraw(context)
        if not under_way.is_over:
            return {"PASS_THROUGH"}
        bake.current = None
        report_end(self, under_way, context.scene)
        result = self.end(context, under_way)
        if under_way.state == "CHANGED":
            bpy.ops.tulle.bake_anew("INVOKE_DEFAULT")
        return result

    def end(self, context, under_way: Optional[bake.Bake]):
        context.window_manager.event_timer_remove(self._timer)
        redraw(context)
        return {"FINISHED"} if under_way is not None and under_way.state == "FINISHED" else {"CANCELLED"}

    def cancel(self, context):
        bake.stop()


class TULLE_OT_bake_anew(bpy.types.Operator):
    """Replaces the frames that are there by a bake from the start"""

    bl_idname = "tulle.bake_anew"
    bl_label = "Bake Anew"

    @classmethod
    def poll(cls, context):
        return bake.current is None

    def invoke(self, context, event):
        return context.window_manager.invoke_confirm(self, event)

    def execute(self, context):
        mode = "EXEC_DEFAULT" if bpy.app.background else "INVOKE_DEFAULT"
        bpy.ops.tulle.bake(mode, restart=True)
        return {"FINISHED"}


class TULLE_OT_bake_from(bpy.types.Operator):
    """Keeps the frames up to the present one, and bakes those behind it anew with the settings as they are now"""

    bl_idname = "tulle.bake_from"
    bl_label = "Bake from Frame"

    @classmethod
    def poll(cls, context):
        return bake.current is None

    def invoke(self, context, event):
        return context.window_manager.invoke_confirm(self, event)

    def execute(self, context):
        mode = "EXEC_DEFAULT" if bpy.app.background else "INVOKE_DEFAULT"
        bpy.ops.tulle.bake(mode, from_frame=True)
        return {"FINISHED"}


class TULLE_OT_cancel(bpy.types.Operator):
    """Ends the bake; what is baked stays, and Bake goes on from there"""

    bl_idname = "tulle.cancel"
    bl_label = "Cancel"

    @classmethod
    def poll(cls, context):
        return bake.current is not None

    def execute(self, context):
        if bake.current is not None:
            bake.current.cancel()
            bake.current.tell(bake.current.state, None, "Ending the step")
        return {"FINISHED"}


class TULLE_OT_free(bpy.types.Operator):
    """Removes the caches, what was run, and the modifiers that show it"""

    bl_idname = "tulle.free"
    bl_label = "Free"

    @classmethod
    def poll(cls, context):
        return bake.current is None

    def invoke(self, context, event):
        return context.window_manager.invoke_confirm(self, event)

    def execute(self, context):
        try:
            folder = bake.find_folder(context.scene)
        except Refusal as refusal:
            self.report({"ERROR"}, str(refusal))
            return {"CANCELLED"}
        for obj in context.scene.objects:
            if obj.tulle.role in ("CLOTH", "BODY") or caches.find_modifier(obj) is not None:
                caches.remove_modifier(obj)
        caches.remove_files(folder)
        settings = context.scene.tulle
        settings.state, settings.status, settings.report, settings.progress = "", "", "", 0.0
        return {"FINISHED"}


class TULLE_OT_export(bpy.types.Operator):
    """Writes the folder for a program on another machine: there, run `tulle run scene.yaml -o run --record velocities` in it"""

    bl_idname = "tulle.export"
    bl_label = "Export Folder"

    @classmethod
    def poll(cls, context):
        return bake.current is None

    def execute(self, context):
        try:
            folder = bake.find_folder(context.scene)
            exported = export.Export(context, folder)
            for _ in exported.run():
                pass
        except (Refusal, OSError) as refusal:
            self.report({"ERROR"}, str(refusal))
            return {"CANCELLED"}
        context.scene.tulle.report = "\n".join(exported.notes)
        context.scene.tulle.status = "Exported to %s; run there: tulle run scene.yaml -o run --record velocities" % folder
        self.report({"INFO"}, context.scene.tulle.status)
        return {"FINISHED"}


class TULLE_OT_import(bpy.types.Operator):
    """Shows the frames that the folder holds, also those of a run on another machine"""

    bl_idname = "tulle.import_results"
    bl_label = "Import Results"

    @classmethod
    def poll(cls, context):
        return bake.current is None

    def execute(self, context):
        try:
            folder = bake.find_folder(context.scene)
            caches.settle(folder)
            found = caches.Caches(folder)
            found.update()
            found.show(context.scene)
        except (Refusal, OSError) as refusal:
            self.report({"ERROR"}, str(refusal))
            return {"CANCELLED"}
        context.scene.tulle.status, context.scene.tulle.report = "%d frames" % found.frame_count, ""
        return {"FINISHED"}


def redraw(context) -> None:
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type in ("VIEW_3D", "PROPERTIES", "DOPESHEET_EDITOR"):
                area.tag_redraw()


CLASSES = (
    TULLE_OT_bake,
    TULLE_OT_bake_anew,
    TULLE_OT_bake_from,
    TULLE_OT_cancel,
    TULLE_OT_free,
    TULLE_OT_export,
    TULLE_OT_import,
)


def register() -> None:
    for each in CLASSES:
        bpy.utils.register_class(each)


def unregister() -> None:
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
