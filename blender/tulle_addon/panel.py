"""Panels: an object's role and values, on its physics tab and in the sidebar; bake and what became of it."""
import textwrap

import bpy

from . import bake, settings

LETTER = 6.6  # [pixels] mean width of a letter, at a scale of 1


def draw_object(layout, context, obj) -> None:
    values = obj.tulle
    layout.use_property_split = True
    layout.use_property_decorate = False
    layout.prop(values, "role")
    if values.role == "CLOTH":
        draw_cloth(layout, obj, values)
    elif values.role in ("OBSTACLE", "BODY"):
        draw_optional(layout, values, "use_friction", "friction")
        if values.role == "BODY":
            layout.prop(values, "density")


def draw_optional(layout, values, switch: str, name: str) -> None:
    row = layout.row(heading=values.bl_rna.properties[name].name)
    row.prop(values, switch, text="")
    side = row.row()
    side.active = getattr(values, switch)
    side.prop(values, name, text="")


def draw_cloth(layout, obj, values) -> None:
    layout.template_icon_view(values, "fabric", show_labels=True, scale=4.0, scale_popup=5.0)
    layout.prop(values, "fabric")
    words = next(text for name, _, text in settings.FABRICS if name == values.fabric)
    layout.label(text=words, icon="INFO")
    draw_optional(layout, values, "use_thickness", "thickness")
    draw_optional(layout, values, "use_friction", "friction")
    layout.prop_search(values, "pin_group", obj, "vertex_groups")
    layout.prop_search(values, "stiffness_group", obj, "vertex_groups")
    if values.stiffness_group:
        column = layout.column(align=True)
        column.prop(values, "stiffness_from")
        column.prop(values, "stiffness_to")
    layout.prop(values, "rest")
    if values.rest == "KEY" and obj.type == "MESH" and obj.data.shape_keys:
        layout.prop_search(values, "rest_key", obj.data.shape_keys, "key_blocks")
    elif values.rest == "UV":
        layout.prop(values, "uv_scale")
    for index, attachment in enumerate(values.attachments):
        box = layout.box().column()
        row = box.row()
        row.prop(attachment, "target", text="Attach")
        row.operator("tulle.remove_attachment", text="", icon="X").index = index
        box.prop_search(attachment, "vertex_group", obj, "vertex_groups")
        box.prop(attachment, "distance")
    layout.operator("tulle.add_attachment", icon="ADD")
    if any(modifier.type == "CLOTH" for modifier in obj.modifiers):
        layout.operator("tulle.convert", icon="MOD_CLOTH")


def draw_scene(layout, context) -> None:
    values = context.scene.tulle
    layout.use_property_split = True
    layout.use_property_decorate = False
    if bake.current is not None:
        draw_progress(layout, values)
        layout.operator("tulle.cancel", icon="CANCEL")
    else:
        row = layout.row()
        row.scale_y = 1.4
        row.operator("tulle.bake", icon="PHYSICS")
        row = layout.row(align=True)
        row.operator("tulle.bake_anew")
        row.operator("tulle.free")
        layout.operator("tulle.bake_from", text="Bake from Frame %d" % context.scene.frame_current, icon="FRAME_NEXT")
    draw_report(layout, context, values)


def draw_progress(layout, values) -> None:
    if hasattr(layout, "progress"):
        layout.progress(factor=values.progress / 100, text="%d %%" % values.progress)
    else:
        layout.prop(values, "progress", text="", slider=True)


def draw_report(layout, context, values) -> None:
    """Status and words of the last bake; long lines are cut where they fit."""
    icon = {"FAILED": "ERROR", "CHANGED": "ERROR", "FINISHED": "CHECKMARK"}.get(values.state, "BLANK1")
    if values.status:
        layout.label(text=values.status, icon=icon)
    width = max(20, int(context.region.width / (LETTER * context.preferences.system.ui_scale)) - 3)
    lines = [part for line in values.report.split("\n") if line for part in textwrap.wrap(line, width)]
    if lines:
        column = layout.box().column(align=True)
        column.scale_y = 0.75
        for line in lines:
            column.label(text=line)


def draw_settings(layout, context) -> None:
    values = context.scene.tulle
    layout.use_property_split = True
    layout.use_property_decorate = False
    layout.prop(values, "folder")
    layout.prop(context.scene, "frame_start", text="Frames")
    layout.prop(context.scene, "frame_end", text="End")
    layout.prop(values, "substeps")
    layout.prop(values, "threads")
    layout.prop(values, "start")
    layout.prop(values, "follow")
    layout.prop(values, "all_obstacles")
    row = layout.row(align=True)
    row.operator("tulle.export")
    row.operator("tulle.import_results")


class TULLE_OT_add_attachment(bpy.types.Operator):
    """Holds vertices of the cloth at an object, wherever it goes and however it deforms"""

    bl_idname = "tulle.add_attachment"
    bl_label = "Attach"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        context.object.tulle.attachments.add()
        return {"FINISHED"}


class TULLE_OT_remove_attachment(bpy.types.Operator):
    """Takes the attachment off"""

    bl_idname = "tulle.remove_attachment"
    bl_label = "Remove Attachment"
    bl_options = {"REGISTER", "UNDO"}
    index: bpy.props.IntProperty()

    def execute(self, context):
        context.object.tulle.attachments.remove(self.index)
        return {"FINISHED"}


class Sidebar:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Tulle"


class TULLE_PT_bake(Sidebar, bpy.types.Panel):
    bl_label = "Tulle"

    def draw(self, context):
        draw_scene(self.layout, context)


class TULLE_PT_object(Sidebar, bpy.types.Panel):
    bl_label = "Object"

    @classmethod
    def poll(cls, context):
        return context.object is not None

    def draw(self, context):
        self.layout.label(text=context.object.name, icon="OBJECT_DATA")
        draw_object(self.layout, context, context.object)


class TULLE_PT_settings(Sidebar, bpy.types.Panel):
    bl_label = "Settings"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        draw_settings(self.layout, context)


class TULLE_PT_check(Sidebar, bpy.types.Panel):
    bl_label = "Check"

    def draw(self, context):
        layout = self.layout
        row = layout.row(align=True)
        row.operator("tulle.check", text="This Frame").whole_range = False
        row.operator("tulle.check", text="All Frames").whole_range = True
        layout.operator("tulle.untangle")


class TULLE_PT_mend(Sidebar, bpy.types.Panel):
    bl_label = "Mend"

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.type == "MESH"

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(context.object.tulle, "strength")
        layout.operator("tulle.mend", icon="MOD_CLOTH")


class TULLE_PT_physics(bpy.types.Panel):
    bl_label = "Tulle"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "physics"

    @classmethod
    def poll(cls, context):
        return context.object is not None

    def draw(self, context):
        draw_object(self.layout, context, context.object)
        if context.object.tulle.role in ("CLOTH", "BODY"):
            draw_scene(self.layout, context)


CLASSES = (
    TULLE_OT_add_attachment,
    TULLE_OT_remove_attachment,
    TULLE_PT_bake,
    TULLE_PT_object,
    TULLE_PT_check,
    TULLE_PT_mend,
    TULLE_PT_settings,
    TULLE_PT_physics,
)


def register() -> None:
    for each in CLASSES:
        bpy.utils.register_class(each)


def unregister() -> None:
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
