"""Collisions of surfaces that move from one state to another, and the exact judge of states. No world is needed."""
from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Optional

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tulle import structs
from tulle._arrays import Indices, copy_from, point_to, to_doubles, to_indices
from tulle._handles import Unique, take_turn
from tulle._library import core, ffi
from tulle.errors import ClosedError, InvalidArgumentError, check, make_error_buffer, make_exception
from tulle.mesh import Mesh, view_mesh

_INTERRUPTED = int(structs.Status.INTERRUPTED)


@dataclass(frozen=True)
class Detection:
    """The answer of a detector."""

    events: NDArray[Any]
    """DETECT_EVENT records in order; none where they were streamed."""
    earliest_time: float
    """The smallest time of an event; 1 without events."""
    statistics: structs.DetectStatistics
    """What the call did."""


class Detector(Unique):
    """Finds every pair of a vertex and a triangle, and of two edges, that comes within its separation in a motion.

    >>> detector = Detector(mesh.triangles, mesh.vertex_count, thickness=1e-3)
    >>> detector.find_events(start, end).events["time"]

    Vertex i moves along start[i] + t (end[i] - start[i]), t in [0, 1]. Nothing is missed, whatever the motion. A detector
    keeps trees between calls, so ask the same one for step after step; one thread at a time may use it.
    """

    def __init__(self, triangles: ArrayLike, vertex_count: int, settings: Optional[structs.DetectDef] = None,
                 **changes: Any) -> None:
        """triangles: (triangles, 3) vertex numbers. changes: fields of DetectDef by name, as `surfaces=[DetectSurface(...)]`.

        collides: (surfaces, surfaces) of truth values, symmetric. Raises InvalidArgumentError, InvalidMeshError.
        """
        self._handle: Any = None
        keep: list[Any] = []
        if changes.get("collides") is not None:
            changes["collides"] = np.asarray(changes["collides"]).astype(np.uint8).reshape(-1)
        definition = structs.DetectDef.make(settings, changes, "Detector")
        count = len(definition.surfaces)
        if definition.collides is not None and np.size(definition.collides) != count * count:
            raise InvalidArgumentError(f"collides should have the shape ({count}, {count}), one row for each surface")
        rows = to_indices(triangles, 3, "triangles")
        if definition.rest is not None:
            definition.rest = to_doubles(definition.rest, 3, "rest", vertex_count)
        made = definition.to_c(keep)
        made.triangles, made.triangle_count, made.vertex_count = point_to(rows, "uint32_t *"), rows.shape[0], vertex_count
        handle, self._error = ffi.new("tulle_detector **"), make_error_buffer()
        check(core.tulle_detector_create(made, handle, self._error), self._error)
        self._handle, self._lock = handle[0], threading.Lock()
        self._vertex_count, self._triangle_count = vertex_count, rows.shape[0]

    def _using(self) -> threading.Lock:
        """The lock, for `with`."""
        return take_turn(self._lock, "the detector")

    def _open(self) -> Any:
        if self._handle is None:
            raise ClosedError("the detector was closed")
        return self._handle

    def find_events(self, start: ArrayLike, end: ArrayLike) -> Detection:
        """All events of the motion from `start` to `end`, (vertices, 3) [m] each."""
        return self._find(core.tulle_detector_find_events, start, end)

    def find_earliest(self, start: ArrayLike, end: ArrayLike) -> Detection:
        """Only the earliest event, which is cheaper."""
        return self._find(core.tulle_detector_find_earliest, start, end)

    def stream_events(self, start: ArrayLike, end: ArrayLike, receive: Callable[[NDArray[Any]], Any]) -> Detection:
        """Hands over all events in batches of at most 1024 records; `receive` asks to stop by giving True.

        The answer has no events of its own, and is empty where `receive` asked to stop.
        """
        failure: list[BaseException] = []

        def take(context: Any, events: Any, count: int) -> int:
            return 1 if receive(copy_from(events, count, structs.DETECT_EVENT)) else 0

        made = ffi.callback("int(void *, const tulle_detect_event *, size_t)", take, error=1,
                            onerror=lambda kind, problem, trace: failure.append(problem))
        receiver = ffi.new("tulle_detect_receiver *", {"receive": made})
        answer = self._find(core.tulle_detector_stream_events, start, end, receiver[0])
        if failure:
            raise failure[0]
        return answer

    def _find(self, function: Any, start: ArrayLike, end: ArrayLike, *others: Any) -> Detection:
        rows = [to_doubles(values, 3, name, self._vertex_count) for values, name in ((start, "start"), (end, "end"))]
        result = ffi.new("tulle_detect_result *")
        with self._using():
            status = function(self._open(), *(point_to(row, "double *") for row in rows), *others, result, self._error)
            if status and not (status == _INTERRUPTED and others):  # a receiver may ask to stop
                raise make_exception(status, self._error)
            events = copy_from(result.events, 0 if result.events == ffi.NULL else result.event_count, structs.DETECT_EVENT)
        return Detection(events, result.earliest_time, structs.DetectStatistics(result.statistics, result))

    @property
    def patches(self) -> Optional[Indices]:
        """The patches in use after the last call: a label for each triangle, 0 for an isolated one; None: there are none."""
        with self._using():
            labels = core.tulle_detector_get_patches(self._open())
            return None if labels == ffi.NULL else copy_from(labels, self._triangle_count, np.uint32)

    def close(self) -> None:
        """Releases the detector."""
        if self._handle is not None:
            with self._using():
                handle, self._handle = self._handle, None
                if handle is not None:
                    core.tulle_detector_destroy(handle)

    def __enter__(self) -> Detector:
        return self

    def __exit__(self, *unused: object) -> None:
        self.close()

    def __del__(self) -> None:
        if getattr(self, "_handle", None) is not None:
            self.close()


@dataclass(frozen=True)
class Verdict:
    """What the judge found in a state."""

    pairs: NDArray[Any]
    """CHECK_PAIR records: all pairs of triangles that intersect, in order. Bodies are numbered cloths first."""
    tested_pair_count: int
    """Pairs of triangles whose boxes overlap."""
    exact_count: int
    """Signs that floating point could not decide."""

    @property
    def is_clean(self) -> bool:
        """Whether nothing intersects."""
        return not self.pairs.size


class Judge:
    """Decides by exact arithmetic, without a tolerance, which triangles intersect. It shares no code with what it judges.

    >>> Judge().find_intersections([cloth.mesh], obstacles=[ball.mesh]).is_clean
    True
    """

    def __init__(self, threads: int = 0) -> None:
        """threads: 0 .. 256; 0: one per processor. The verdict does not depend on it."""
        self.threads = threads

    def find_intersections(self, cloths: Iterable[Mesh], obstacles: Iterable[Mesh] = ()) -> Verdict:
        """Every intersecting pair of triangles within and between cloths, and between cloths and obstacles.

        Obstacles may intersect themselves and one another. Raises InvalidMeshError, LimitError.
        """
        bodies = [(mesh, 0) for mesh in cloths] + [(mesh, 1) for mesh in obstacles]
        made = ffi.new("tulle_check_body[]", len(bodies) or 1)
        for i, (mesh, is_obstacle) in enumerate(bodies):
            made[i].mesh, made[i].is_obstacle = view_mesh(mesh, f"body {i}"), is_obstacle
        result, error = ffi.new("tulle_check_result *"), make_error_buffer()
        check(core.tulle_check_intersections(made, len(bodies), self.threads, result, error), error)
        try:
            pairs = copy_from(result.pairs, result.pair_count, structs.CHECK_PAIR)
            return Verdict(pairs, result.tested_pair_count, result.exact_count)
        finally:
            core.tulle_check_result_destroy(result)

    def find_world_intersections(self, world: Any) -> Verdict:
        """The same for a world as it is now: its cloths, and the obstacles that are present."""
        return self.find_intersections([cloth.mesh for cloth in world.cloths],
                                       [each.mesh for each in world.obstacles if each.is_present])
