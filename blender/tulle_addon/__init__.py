"""Tulle in Blender: cloth that never passes through anything.

One marks a cloth, marks what it falls on, and bakes. The add-on writes a scene for the program `tulle`, runs it, and shows
its frames by a Mesh Cache modifier. Each module is one thought:

    settings   what an artist sets on objects and on the scene
    pictures   pictures of the fabrics
    meshes     meshes of Blender in world space and metres, as arrays and files
    stack      which modifiers are simulated and which stay behind the cache; what is switched while a mesh is read
    motion     what stands still, moves rigidly or deforms
    parts      the objects that take part, and what their meshes hold frame by frame
    export     the folder that the program runs: scene.yaml, meshes, point caches
    program    finds the program and runs it
    caches     frames of a run as a point cache in the space of the object, and the modifier that shows it
    selection  selects what the words of the program name
    job        what reads the scene and runs the program, bit by bit
    bake       a bake that is under way
    mend       operator: mends an animation of another origin
    waiting    an operator that waits for a job
    operators  bake, cancel, free, export, import
    check      operators: the judge, untangling
    convert    operator: takes over Blender's own cloth
    panel      panels
"""
bl_info = {
    "name": "Tulle",
    "author": "Tulle",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "Properties > Physics, and the sidebar of the 3D view",
    "description": "Cloth that never passes through anything",
    "category": "Physics",
}

from . import bake, check, convert, mend, operators, panel, program, settings  # noqa: E402

MODULES = (settings, program, bake, operators, check, mend, convert, panel)


def register() -> None:
    for module in MODULES:
        module.register()


def unregister() -> None:
    for module in reversed(MODULES):
        module.unregister()
