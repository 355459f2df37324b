"""Scene files: YAML text in, a checked scene and a world out."""
from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any, Optional, Union

import numpy as np

from tulle._library import ffi, io
from tulle._structs import decode
from tulle.errors import ClosedError, Error, check, make_error_buffer, make_exception
from tulle.mesh import Mesh, PathLike, copy_view, encode_path
from tulle.objects import Body, Cloth, Obstacle
from tulle.world import World

Overrides = Union[Mapping[str, Any], Sequence[str]]


def format_overrides(overrides: Overrides) -> list[str]:
    """"path=value" texts, as `tulle run --set` takes them; values that are not text become JSON, which is YAML.

    Numbers and arrays of numpy are such values, too.
    """
    def to_plain(value: Any) -> Any:
        if isinstance(value, (np.generic, np.ndarray)):
            return value.tolist()
        raise TypeError(f"a scene takes no {type(value).__name__}, as {value!r}")

    if isinstance(overrides, str):
        raise TypeError("overrides should be a dictionary, or a list of \"path=value\"")
    if isinstance(overrides, Mapping):
        return [f"{key}={value if isinstance(value, str) else json.dumps(value, default=to_plain)}" for key, value in overrides.items()]
    return list(overrides)


class Scene:
    """A scene file that was read and checked.

    >>> scene = Scene("scenes/sphere.yaml", {"time.frames": 10, "cloth[0].mesh.resolution": [40, 40]})
    >>> world = scene.build_world()
    >>> report = world.step(scene.time_step)
    """

    def __init__(self, path: PathLike, overrides: Overrides = ()) -> None:
        """Loads a scene; `overrides` change its keys, one after the other. Nothing is written.

        All that is wrong is told at once: the error is that of the first problem, and its `problems` are all of them, each
        with file, line and column.
        """
        texts = [text.encode() for text in format_overrides(overrides)]
        kept = [ffi.new("char[]", text) for text in texts]
        made, problems = ffi.new("tulle_scene **"), ffi.new("tulle_scene_problems *")
        status = io.tulle_scene_load(encode_path(path), ffi.new("char *[]", kept) if kept else ffi.NULL, len(kept), made, problems)
        if status:
            each: list[Error] = [make_exception(problems.list[i].status, ffi.addressof(problems.list[i]))
                                 for i in range(problems.count)]
            if not each:
                raise make_exception(status, make_error_buffer())
            first = each[0]
            first.problems = each  # type: ignore[attr-defined]
            raise first
        self._handle: Any = ffi.gc(made[0], io.tulle_scene_destroy)

    def _use(self) -> Any:
        if self._handle is None:
            raise ClosedError("the scene was closed")
        return self._handle

    def close(self) -> None:
        """Releases the scene, once no world reads its frames any more."""
        self._handle = None

    @property
    def path(self) -> str:
        """The path that was loaded."""
        return decode(io.tulle_scene_get_path(self._use()))

    @property
    def time_step(self) -> float:
        """[s]."""
        return io.tulle_scene_get_time_step(self._use())  # type: ignore[no-any-return]

    @property
    def frame_count(self) -> int:
        """How many frames a run writes after the start."""
        return io.tulle_scene_get_frame_count(self._use())  # type: ignore[no-any-return]

    @property
    def steps_per_frame(self) -> int:
        """How many steps a frame lasts."""
        return io.tulle_scene_get_steps_per_frame(self._use())  # type: ignore[no-any-return]

    @property
    def seed(self) -> int:
        """The seed of wind and irregular meshes."""
        return io.tulle_scene_get_seed(self._use())  # type: ignore[no-any-return]

    @property
    def hash(self) -> int:
        """Hash of the scene, its meshes and sequences, without the number of frames."""
        return io.tulle_scene_get_hash(self._use())  # type: ignore[no-any-return]

    @property
    def canonical_text(self) -> str:
        """The whole scene as YAML in SI units, with every default filled in."""
        return decode(io.tulle_scene_get_canonical_text(self._use()))

    @property
    def notes(self) -> list[str]:
        """What the user should know, as that triangles of an obstacle were dropped."""
        handle = self._use()
        return [decode(io.tulle_scene_get_note(handle, i)) for i in range(io.tulle_scene_get_note_count(handle))]

    @property
    def cloths(self) -> dict[str, Mesh]:
        """The meshes of the cloths at the start by name, in the order of the file."""
        handle = self._use()
        return {decode(io.tulle_scene_get_cloth_name(handle, i)): copy_view(io.tulle_scene_get_cloth_mesh(handle, i))
                for i in range(io.tulle_scene_get_cloth_count(handle))}

    @property
    def obstacles(self) -> dict[str, Mesh]:
        """The meshes of the obstacles at the start by name, in the order of the file."""
        handle = self._use()
        return {decode(io.tulle_scene_get_obstacle_name(handle, i)): copy_view(io.tulle_scene_get_obstacle_mesh(handle, i))
                for i in range(io.tulle_scene_get_obstacle_count(handle))}

    def build_world(self, threads: int = 0) -> World:
        """A world with all objects of the scene, not started. Several worlds of a scene may step in different threads."""
        handle = self._use()
        built, error = ffi.new("tulle_scene_world *"), make_error_buffer()
        check(io.tulle_scene_build_world(handle, threads, ffi.NULL, built, error), error)

        def destroy(unused: Any, scene: Optional[Scene] = self) -> None:  # holds the scene, which the world reads
            io.tulle_scene_destroy_world(built)

        world = World._adopt(built.world, destroy)
        for i in range(built.cloth_count):
            world._cloths.append(Cloth(world, ffi.new("tulle_cloth_id *", built.cloths[i])))
        for i in range(built.obstacle_count):
            kind = Body if io.tulle_scene_is_obstacle_dynamic(handle, i) else Obstacle
            world._obstacles.append(kind(world, ffi.new("tulle_obstacle_id *", built.obstacles[i])))
        return world

    def __repr__(self) -> str:
        return "Scene(closed)" if self._handle is None else f"Scene({self.path!r})"
