"""Which modifiers of an object are simulated, and what is switched while its mesh is read.

The trailing run of modifiers that only make a surface finer or thicker stays behind the cache. What stands before it makes
the mesh that is simulated.
"""
from contextlib import contextmanager
from typing import Any, Callable, Iterator, List

import bpy

CACHE_NAME, MENDED_NAME = "Tulle", "Tulle Mended"
TAIL_TYPES = {
    "SUBSURF",
    "SOLIDIFY",
    "BEVEL",
    "WIREFRAME",
    "EDGE_SPLIT",
    "WEIGHTED_NORMAL",
    "NORMAL_EDIT",
    "UV_PROJECT",
    "UV_WARP",
}
# What moves vertices and leaves their number alone; off while a shape at rest is read.
DEFORM_TYPES = {
    "ARMATURE", "CAST", "CURVE", "DISPLACE", "HOOK", "LAPLACIANDEFORM", "LATTICE", "MESH_DEFORM", "SHRINKWRAP", "SIMPLE_DEFORM",
    "SMOOTH",
    "CORRECTIVE_SMOOTH", "LAPLACIANSMOOTH", "SURFACE_DEFORM", "WARP", "WAVE", "VOLUME_DISPLACE", "SOFT_BODY", "MESH_CACHE",
    "MESH_SEQUENCE_CACHE",
}  # fmt: skip


def is_cache(modifier) -> bool:
    return modifier.type == "MESH_CACHE" and modifier.name.startswith(CACHE_NAME)


def is_mended(modifier) -> bool:
    return is_cache(modifier) and modifier.name.startswith(MENDED_NAME)


def get_kind(modifier) -> str:
    """The type of a modifier; Smooth by Angle, which Blender 4.1 and later add as nodes, only shades."""
    group = getattr(modifier, "node_group", None) if modifier.type == "NODES" else None
    return "WEIGHTED_NORMAL" if group is not None and group.name.startswith("Smooth by Angle") else modifier.type


def find_tail(modifiers) -> int:
    """Index of the first modifier of the tail; their number if there is none.

    A Triangulate belongs to the tail where a finer surface is triangulated, and else to the mesh that is simulated."""
    kinds = [get_kind(modifier) for modifier in modifiers]
    begin = len(kinds)
    while begin > 0 and kinds[begin - 1] in TAIL_TYPES | {"TRIANGULATE", "COLLISION"}:
        begin -= 1
    while begin < len(kinds) and kinds[begin] not in TAIL_TYPES:
        begin += 1
    return begin


def list_hidden(obj, deforms: bool = True) -> List:
    """Modifiers that are off while the mesh that is simulated is read."""
    tail = find_tail(obj.modifiers)
    return [
        modifier
        for index, modifier in enumerate(obj.modifiers)
        if index >= tail
        or modifier.type in ("CLOTH", "COLLISION")
        or is_cache(modifier)
        or (not deforms and modifier.type in DEFORM_TYPES)
    ]


def list_behind(obj) -> List:
    """Modifiers that are off while what is mended is read: Blender's own cloth and the cache of a bake are on."""
    return [
        modifier
        for index, modifier in enumerate(obj.modifiers)
        if index >= find_tail(obj.modifiers) or is_mended(modifier)
    ]


def list_muted(obj) -> List:
    """Blender's cloth that a cache has switched off."""
    return [obj.modifiers[name] for name in obj.tulle.muted_cloth.split("\n") if name in obj.modifiers]


def list_other_in_render(obj) -> List[str]:
    """Modifiers before the cache that may give a render another number of vertices than the view."""
    hidden = list_hidden(obj)
    return [
        modifier.name
        for modifier in obj.modifiers
        if modifier not in hidden
        and modifier.type not in DEFORM_TYPES
        and (
            modifier.show_viewport != modifier.show_render
            or getattr(modifier, "levels", 0) != getattr(modifier, "render_levels", 0)
        )
    ]


@contextmanager
def reading(context, simulated, shown=(), hide: Callable[[Any], List] = list_hidden) -> Iterator[None]:
    """Within it the meshes of `simulated` evaluate without the modifiers that `hide` lists: to what is simulated. Hidden
    ones of `shown` are evaluated too.

    It leaves edit mode, and brings frame, visibility and modifiers back at its end."""
    scene = context.scene
    if context.view_layer.objects.active and context.view_layer.objects.active.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    frame, subframe = scene.frame_current, scene.frame_subframe
    switched, unhidden = [], []
    try:
        for obj in simulated:
            for modifier in hide(obj):
                if modifier.show_viewport:
                    modifier.show_viewport = False
                    switched.append((obj.name, modifier.name))
        for obj in list(simulated) + list(shown):
            if obj.hide_viewport or obj.hide_get():
                unhidden.append((obj.name, obj.hide_viewport, obj.hide_get()))
                obj.hide_viewport = False
                obj.hide_set(False)
        context.view_layer.update()
        yield
    finally:
        for name, modifier in switched:
            if name in scene.objects and modifier in scene.objects[name].modifiers:
                scene.objects[name].modifiers[modifier].show_viewport = True
        for name, viewport, eye in unhidden:
            if name in scene.objects:
                scene.objects[name].hide_viewport = viewport
                scene.objects[name].hide_set(eye)
        scene.frame_set(frame, subframe=subframe)
