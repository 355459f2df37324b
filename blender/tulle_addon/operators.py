"""Operators: bake, cancel, free, and the way by a program on another machine."""
import bpy

from . import bake, caches, export, mend, waiting
from .meshes import Refusal


class TULLE_OT_bake(waiting.Waiting, bpy.types.Operator):
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

    def make_job(self, context, in_window: bool):
        from_frame = context.scene.frame_current if self.from_frame else None
        return bake.Bake(context, self.restart, in_window, from_frame)

    def follow_end(self, job) -> None:
        if job.state == "CHANGED":
            bpy.ops.tulle.bake_anew("INVOKE_DEFAULT")


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
    """Ends what is under way. What is baked stays, and Bake goes on from there"""

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
        try:
            caches.remove_files(folder)
            mend.remove_files(folder)
        except (Refusal, OSError) as refusal:
            self.report({"ERROR"}, str(refusal))
            return {"CANCELLED"}
        for obj in context.scene.objects:
            if caches.is_ours(obj):
                caches.remove_modifier(obj)
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
