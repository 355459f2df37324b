"""Animations: one mesh that moves, in a file that other programs write or open: glTF, USD, NPZ, MDD, PC2."""
from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Optional, Protocol, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tulle import structs
from tulle._arrays import Doubles, Indices, copy_from, point_to, to_doubles, to_indices, to_vector
from tulle._library import ffi, io
from tulle.errors import InvalidArgumentError, check, make_error_buffer
from tulle.mesh import Mesh, PathLike, encode_path
from tulle.run import PointCache, _Handle


class Frames(Protocol):
    """What gives the positions of a surface frame by frame: an array, an `Animation`, a `PointCache`, or what is like them."""

    def __len__(self) -> int:
        """Of frames."""

    def __getitem__(self, frame: int) -> Any:
        """[m] (vertices, 3)."""


class Animation:
    """A file that is read: .glb, .gltf, .usda, .npz, .mdd or .pc2. A frame is read when it is asked for.

    >>> walk = Animation("walk.usda")
    >>> walk.times[-1], walk[-1].shape
    (1.0, (812, 3))

    All surfaces of the file are one mesh, in the coordinates of the file: `is_y_up` and `meters_per_unit` tell which they are.
    Point caches have no triangles; those of PC2 have no times, so theirs are NaN. `note` says what was ignored. Frames are not
    evenly apart where the file's keys are not, and `added_frame_count` of them lie between keys, where something turns.
    """

    def __init__(self, path: PathLike) -> None:
        """Opens the file. Raises FileError, ParseError, LimitError, UnsupportedError."""
        self.path = os.fspath(path)
        self.is_y_up, self.meters_per_unit, self.note, self.added_frame_count = False, 1.0, "", 0
        self.triangles: Indices = np.empty((0, 3), np.uint32)
        self._handle: Any = None
        self._cache: Optional[PointCache] = None
        if os.fsdecode(self.path).lower().endswith((".mdd", ".pc2")):
            self._open_cache()
        else:
            self._open_animation()
        self.triangles.flags.writeable = self.times.flags.writeable = False

    def _open_cache(self) -> None:
        self._cache = PointCache(self.path)
        self.vertex_count, self.frame_count = self._cache.vertex_count, self._cache.frame_count
        self.times: Doubles = np.array([self._cache.get_time(i) for i in range(self.frame_count)], dtype=float)

    def _open_animation(self) -> None:
        made, info, error = ffi.new("tulle_animation **"), ffi.new("tulle_animation_info *"), make_error_buffer()
        check(io.tulle_animation_open(encode_path(self.path), made, info, error), error)
        self._handle = _Handle(made[0], io.tulle_animation_close, "the animation")
        self.vertex_count, self.frame_count = int(info.vertex_count), int(info.frame_count)
        self.is_y_up, self.meters_per_unit = bool(info.is_y_up), float(info.meters_per_unit)
        self.added_frame_count = int(info.added_frame_count)
        self.note = ffi.string(info.note).decode(errors="replace")
        if info.triangle_count:
            self.triangles = copy_from(io.tulle_animation_get_triangles(made[0]), info.triangle_count, np.uint32, 3)
        self.times = np.array([io.tulle_animation_get_time(made[0], i) for i in range(self.frame_count)])

    def __len__(self) -> int:
        return self.frame_count

    def __getitem__(self, frame: int) -> Doubles:
        """(vertices, 3) at a frame, in the file's unit; negative ones count from the end."""
        if self._cache is not None:
            return self._cache[frame]
        if not -self.frame_count <= frame < self.frame_count:
            raise IndexError(f"there is no frame {frame}; the animation has {self.frame_count}")
        positions, error = np.empty((self.vertex_count, 3)), make_error_buffer()
        with self._handle.using():
            check(io.tulle_animation_read_frame(self._handle.get(), frame % self.frame_count, point_to(positions, "double *"),
                                                error), error)
        return positions

    def __iter__(self) -> Iterator[Doubles]:
        for frame in range(self.frame_count):
            yield self[frame]

    def make_mesh(self, frame: int = 0) -> Mesh:
        """The mesh of a frame."""
        return Mesh(self[frame], self.triangles)

    def close(self) -> None:
        """Releases the file."""
        (self._handle if self._cache is None else self._cache).close()

    def __enter__(self) -> Animation:
        return self

    def __exit__(self, *unused: object) -> None:
        self.close()


class _Writing:
    """What a file is written from, while the library asks for frames."""

    def __init__(self, surfaces: Sequence[tuple[Frames, Optional[Indices]]], counts: Sequence[int]) -> None:
        self._surfaces, self._counts = surfaces, counts
        self.failure: Optional[BaseException] = None
        self.read = ffi.callback("tulle_status(void *, size_t, uint32_t, double *, tulle_error *)", self._give,
                                 error=int(structs.Status.INVALID_ARGUMENT), onerror=self._note)

    def _give(self, context: Any, surface: int, frame: int, values: Any, error: Any) -> int:
        count = self._counts[surface]
        rows = to_doubles(self._surfaces[surface][0][frame], 3, f"frame {frame} of surface {surface}", count)
        ffi.memmove(values, point_to(rows, "double *"), rows.nbytes)
        return 0

    def _note(self, kind: Any, failure: BaseException, trace: Any) -> None:
        if self.failure is None:
            self.failure = failure


def write_animation(path: PathLike, surfaces: Mapping[str, Union[Frames, tuple[Frames, ArrayLike]]], *, fps: float = 24.0,
                    times: Optional[ArrayLike] = None, is_y_up: bool = False, meters_per_unit: float = 1.0,
                    is_stepped: bool = False, is_double: bool = False,
                    colors: Optional[Mapping[str, ArrayLike]] = None) -> None:
    """Writes surfaces over time to a file: .glb, .gltf, .usda, .npz or .mdd, by its extension; the last holds one surface.

    >>> walk = Animation("walk.usda")
    >>> write_animation("walk.glb", {"walker": (walk, walk.triangles)}, times=walk.times, is_y_up=True)

    `surfaces` gives for each name frames, as an array (frames, vertices, 3) or what is like a list of (vertices, 3), and the
    triangles, if there are any. All have as many frames. Frames are asked for one by one, as often as the format needs them.
    `times` [s] rise; without them a second has `fps` frames. `is_y_up` and `meters_per_unit` say what the positions are: USD
    says them, glTF means y and metres. `is_stepped`: glTF holds a frame until the next. `is_double`: NPZ as float64.
    Without it, and in all other formats, positions are rounded to float, and surfaces that this leads through each other are not reported:
    where gaps are smaller than a float step at the largest coordinate (0.06 um at 1 m, 0.06 mm at 1 km), take doubles, or judge
    `frame.astype(np.float32)` by `Detector.find_events` from the exact positions to the rounded ones.
    `colors`: red, green and blue from 0 to 1. Raises InvalidArgumentError, InvalidMeshError, FileError, and what frames raise.
    """
    given = [value if isinstance(value, tuple) else (value, None) for value in surfaces.values()]
    parts = [(frames, None if triangles is None else to_indices(triangles, 3, "triangles")) for frames, triangles in given]
    lengths = {len(frames) for frames, _ in parts}
    if len(lengths) != 1 or 0 in lengths:
        raise InvalidArgumentError("an animation needs surfaces, all with the same number of frames, at least one")
    frame_count = lengths.pop()
    moments: NDArray[np.float64] = np.arange(frame_count) / fps if times is None else np.array(times, dtype=float)
    if moments.shape != (frame_count,):
        raise InvalidArgumentError(f"times: {moments.shape} should be ({frame_count},)")
    counts = [len(to_doubles(frames[0], 3, "frames")) for frames, _ in parts]
    writing = _Writing(parts, counts)
    kept: list[Any] = [moments]
    rows = ffi.new("tulle_animation_surface[]", len(parts))
    for i, (name, (frames, triangles)) in enumerate(zip(surfaces, parts)):
        kept.append(ffi.new("char[]", name.encode()))
        rows[i].name, rows[i].prototype = kept[-1], i
        rows[i].motion = int(structs.AnimationMotion.DEFORMS)
        rows[i].color = list(to_vector((colors or {}).get(name, (0.6, 0.1, 0.08)), "colors"))
        rows[i].mesh.vertex_count = counts[i]
        if triangles is not None and len(triangles):
            kept.append(triangles)
            rows[i].mesh.triangles, rows[i].mesh.triangle_count = point_to(triangles, "uint32_t *"), len(triangles)
    wanted = ffi.new("tulle_animation_def *", io.tulle_animation_def_default())
    wanted.surfaces, wanted.surface_count = rows, len(parts)
    wanted.times, wanted.frame_count = point_to(moments, "double *"), frame_count
    span = float(moments[-1] - moments[0])
    wanted.frame_rate = float(fps) if times is None or not span > 0 else (frame_count - 1) / span
    wanted.is_y_up, wanted.meters_per_unit = is_y_up, meters_per_unit
    wanted.is_stepped, wanted.is_double = is_stepped, is_double
    wanted.read = writing.read
    error = make_error_buffer()
    status = io.tulle_animation_write(encode_path(path), wanted, error)
    if writing.failure is not None:
        raise writing.failure
    check(status, error)
