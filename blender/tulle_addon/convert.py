"""Takes over the settings of Blender's own cloth modifier, as well as they map, and lists what does not."""
from math import log
from typing import Any, List, Tuple

import bpy

# Mass of a vertex, tension and bending of the presets of Blender, and the fabric that is nearest to each.
KNOWN = [
    ((0.3, 15.0, 0.5), "cotton"),
    ((1.0, 40.0, 10.0), "denim"),
    ((0.4, 80.0, 150.0), "felt"),
    ((3.0, 15.0, 25.0), "rubber-sheet"),
    ((0.15, 5.0, 0.05), "silk"),
]
# Settings without a counterpart: of what, name, the value at which they do nothing, words.
WITHOUT: List[Tuple[str, str, Any, str]] = [
    ("settings", "use_pressure", False, "pressure"),
    ("settings", "use_sewing_springs", False, "sewing springs"),
    ("settings", "use_internal_springs", False, "internal springs"),
    ("settings", "use_dynamic_mesh", False, "a mesh that changes while it is simulated"),
    ("settings", "vertex_group_shrink", "", "the group of shrinking"),
    ("settings", "shrink_min", 0.0, "shrinking"),
    ("settings", "vertex_group_shear_stiffness", "", "the group of shear"),
    ("settings", "vertex_group_bending", "", "the group of bending"),
    ("settings", "time_scale", 1.0, "the speed"),
    ("settings", "air_damping", 1.0, "the viscosity of air: the fabric has its own"),
    ("collision_settings", "impulse_clamp", 0.0, "clamped impulses"),
    ("collision_settings", "collection", None, "the collection of colliders: mark its objects"),
    ("collision_settings", "vertex_group_object_collisions", "", "the group without collisions"),
    ("collision_settings", "vertex_group_self_collisions", "", "the group without self collisions"),
]


def choose_fabric(settings) -> str:
    """The fabric whose preset of Blender is nearest, by ratios."""
    values = (settings.mass, settings.tension_stiffness, settings.bending_stiffness)
    return min(KNOWN, key=lambda known: sum(log(max(a, 1e-6) / b) ** 2 for a, b in zip(values, known[0])))[1]


def take_over(obj, modifier) -> List[str]:
    """Sets what maps; words for what does not."""
    settings, contact, values = modifier.settings, modifier.collision_settings, obj.tulle
    notes = []
    values.role, values.fabric = "CLOTH", choose_fabric(settings)
    notes.append("Fabric: %s, the nearest to its mass, stiffness and bending" % values.fabric)
    values.pin_group = settings.vertex_group_mass
    if settings.vertex_group_mass and settings.pin_stiffness != 1.0:
        notes.append("Pins hold fully; their stiffness is not taken over")
    if settings.vertex_group_structural_stiffness:
        values.stiffness_group, values.stiffness_from = settings.vertex_group_structural_stiffness, 1.0
        ratio = settings.tension_stiffness_max / max(settings.tension_stiffness, 1e-6)
        values.stiffness_to = min(100.0, max(1.0, ratio))
        notes.append("The group of stiffness counts for shear and bending, too: up to %.3g times" % values.stiffness_to)
    if settings.rest_shape_key is not None:
        values.rest, values.rest_key = "KEY", settings.rest_shape_key.name
    if contact.use_self_collision:
        values.use_thickness, values.thickness = True, contact.self_distance_min
    else:
        notes.append("Cloth always meets itself, though self collisions were off")
    notes.append("Friction is the fabric's; Blender's value, from 0 to 80, is no coefficient")
    if settings.effector_weights.gravity != 1.0:
        notes.append("Not taken over: the weight of gravity")
    for owner, name, idle, words in WITHOUT:
        if getattr(getattr(modifier, owner), name) != idle:
            notes.append("Not taken over: " + words)
    return notes


class TULLE_OT_convert(bpy.types.Operator):
    """Takes over Blender's cloth of the selected objects; objects with a Collision modifier become obstacles"""

    bl_idname = "tulle.convert"
    bl_label = "Take Over Blender's Cloth"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        notes = []
        for obj in context.selected_objects:
            modifier = next((each for each in obj.modifiers if each.type == "CLOTH"), None)
            if modifier is not None:
                notes += ["%s: %s" % (obj.name, words) for words in take_over(obj, modifier)]
        if not notes:
            self.report({"ERROR"}, "No selected object has a cloth modifier")
            return {"CANCELLED"}
        for obj in context.view_layer.objects:
            if obj.tulle.role == "NONE" and any(each.type == "COLLISION" for each in obj.modifiers):
                obj.tulle.role = "OBSTACLE"
                notes.append("%s is an obstacle" % obj.name)
        context.scene.tulle.report = "\n".join(notes)
        context.scene.tulle.status = "Taken over"
        self.report({"INFO"}, "Taken over; what does not map is listed in the panel")
        return {"FINISHED"}


def register() -> None:
    bpy.utils.register_class(TULLE_OT_convert)


def unregister() -> None:
    bpy.utils.unregister_class(TULLE_OT_convert)
