"""The simulated world: cloth, obstacles, rigid bodies and time."""
from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from itertools import compress
from operator import methodcaller
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tulle import structs
from tulle._arrays import Clock, copy_from, point_to, to_doubles, to_indices, to_vector
from tulle._handles import Unique, take_turn
from tulle._library import core, ffi
from tulle._structs import decode, refuse_unknown
from tulle.errors import (BusyError, ClosedError, Error, InvalidArgumentError, make_error_buffer, make_exception)
from tulle.mesh import Mesh, PathLike, leave_out, view_mesh
from tulle.objects import Attachment, Body, Cloth, Object, Obstacle

Frames = Union[ArrayLike, Callable[[int], ArrayLike]]
_MAIN_THREAD = threading.main_thread().ident
STAGES: tuple[str, ...] = tuple(decode(core.tulle_stage_name(i)) for i in range(structs.STAGE_COUNT))
"""The names of the stages of a step, in the order in which a step runs them and reports tell their seconds."""
_NOT_STEPPED = 99  # no status
_try_to_acquire, _release = methodcaller("acquire", False), methodcaller("release")


class _Callbacks:
    """What a world calls back: an exception of one ends the call of the library, and is raised by it."""

    def __init__(self, flag: Any) -> None:
        self.failure: Optional[BaseException] = None
        self.kept: list[Any] = []  # cffi's handles, which the library holds
        self._flag = flag

    def note(self, kind: Any, failure: BaseException, trace: Any) -> None:
        """For cffi's onerror."""
        if self.failure is None:
            self.failure = failure
        self._flag[0] = b"1"  # not every callback can tell the library that it failed

    def take(self) -> Optional[BaseException]:
        """The exception of a callback since the last call."""
        failure, self.failure = self.failure, None
        return failure


class World(Unique):
    """A world of cloth and obstacles.

    >>> world = World(gravity=(0, 0, -9.81))
    >>> cloth = world.add_cloth(make_shape("rectangle", resolution=20).transform(translation=(0, 0, 1)), material="silk")
    >>> ball = world.add_obstacle(make_shape("sphere", radius=0.3))
    >>> for _ in range(90):
    ...     report = world.step(1 / 90)
    >>> cloth.positions.shape
    (400, 3)

    The promise: no accepted state holds an intersection of cloth with itself, with other cloth or with an obstacle. A step
    that cannot keep it raises and leaves the world as it was.

    One thread at a time may use a world; another one that tries meanwhile gets BusyError. Different worlds may run in
    different threads at once: steps release the interpreter. Ctrl-C ends a step of the main thread; the world is then as it
    was before the step or, where the step was just done, as after it: `step_count` says which.
    """

    _handle: Any = None
    _destroy: Any = None

    def __init__(self, settings: Optional[structs.WorldDef] = None, **changes: Any) -> None:
        """Makes an empty world of `settings`, or of the defaults, with `changes` by the names of the fields of WorldDef."""
        keep: list[Any] = []
        definition = structs.WorldDef.make(settings, changes, "World").to_c(keep)
        made, error = ffi.new("tulle_world **"), make_error_buffer()
        status = core.tulle_world_create(definition, made, error)
        if status:
            raise make_exception(status, error)
        self._set_up(made[0], core.tulle_world_destroy)

    def _set_up(self, handle: Any, destroy: Callable[[Any], None]) -> None:
        self._handle, self._destroy = handle, destroy
        self._lock = threading.Lock()
        self._error = make_error_buffer()
        self._clock = Clock()
        self._cloths: list[Cloth] = []
        self._obstacles: list[Obstacle] = []
        self._flag = ffi.new("char[2]", b"0")  # "1" asks a step to stop
        self._callbacks = _Callbacks(self._flag)
        self._is_started = False
        self._recording: Any = None
        self._asks: Any = None

    @classmethod
    def _adopt(cls, handle: Any, destroy: Callable[[Any], None]) -> World:
        """A world that something else made, and that `destroy` releases."""
        world = cls.__new__(cls)
        world._set_up(handle, destroy)
        return world

    # ---- life ----

    def close(self) -> None:
        """Releases the world. Everything that is asked of it later raises ClosedError; arrays that it gave raise StaleError."""
        if self._handle is None:
            return
        with self._using():
            handle, self._handle = self._handle, None
            self._clock.advance()
            self._destroy(handle)
            if self._recording is not None:
                self._recording.close()

    def __enter__(self) -> World:
        return self

    def __exit__(self, *unused: object) -> None:
        self.close()

    def __del__(self) -> None:
        if self._handle is not None:
            try:
                self.close()
            except BusyError:
                pass

    def __repr__(self) -> str:
        if self._handle is None:
            return "World(closed)"
        if self._lock.locked():
            return "World(in use)"
        return f"World({len(self._cloths)} cloths, {len(self._obstacles)} obstacles, time={self.time:g} s)"

    def _repr_html_(self) -> Optional[str]:
        """For notebooks: `tulle.show`."""
        from tulle.notebook import represent
        return None if self._handle is None else represent(self)

    def _using(self) -> threading.Lock:
        """The lock, for `with`."""
        return take_turn(self._lock, "the world")

    def _get(self, function: Any, *arguments: Any) -> Any:
        """What a function that takes the world gives."""
        with self._using():
            if self._handle is None:
                raise ClosedError("the world was closed")
            return function(self._handle, *arguments)

    def _call(self, function: Any, *arguments: Any) -> None:
        """Calls a function that takes the world first and an error last; raises what it says, or what a callback raised."""
        with self._using():
            if self._handle is None:
                raise ClosedError("the world was closed")
            self._check(function(self._handle, *arguments, self._error))

    def _check(self, status: int) -> None:
        """Raises what a callback raised during a call of the library, else what its status says."""
        failure = self._callbacks.take()
        if failure is not None:
            raise failure
        if status:
            raise make_exception(status, self._error)

    def _change(self, function: Any, *arguments: Any) -> None:
        """As _call, for what may take long and changes the state: arrays given before are stale then."""
        is_main = threading.get_ident() == _MAIN_THREAD
        with self._using():
            if self._asks is not (_ask_python if is_main else _ask_flag):
                self._ask_by(_ask_python if is_main else _ask_flag)
            if self._handle is None:
                raise ClosedError("the world was closed")
            self._flag[0] = b"0"
            former = self._clock.advance()  # before the call: Ctrl-C may come when it is done, and nothing runs after it
            try:
                status = function(self._handle, *arguments, self._error)
            except (TypeError, OverflowError):  # of an argument: nothing was called
                self._clock.now = former
                raise
            if status:
                self._clock.now = former
            if is_main and _interrupted:
                raise _interrupted.pop()
            self._check(status)

    def _ask_by(self, asks: Any) -> None:
        """What the library asks within long calls whether to stop: in the main thread the interpreter, for the sake of
        Ctrl-C; in others the flag of `interrupt`, so that they do not wait for one another."""
        if self._handle is None:
            raise ClosedError("the world was closed")
        core.tulle_world_set_stop_request(self._handle, asks, ffi.cast("void *", self._flag))
        self._asks = asks

    def interrupt(self) -> None:
        """Asks the start or the step that another thread makes to stop: it raises InterruptedError, with the world as before.

        Between two steps nothing happens: ask again until the thread has ended.
        """
        self._flag[0] = b"1"

    # ---- objects ----

    @property
    def cloths(self) -> tuple[Cloth, ...]:
        """All cloths, in the order of adding."""
        return tuple(self._cloths)

    @property
    def obstacles(self) -> tuple[Obstacle, ...]:
        """All obstacles and rigid bodies, in the order of adding."""
        return tuple(self._obstacles)

    @property
    def objects(self) -> tuple[Object, ...]:
        """Cloths, then obstacles: so contacts, events and intersections number them."""
        return (*self._cloths, *self._obstacles)

    def find_object(self, name: Union[str, structs.ObjectId]) -> Optional[Object]:
        """The object of that name, or that a query found; None: there is none."""
        if not isinstance(name, (str, structs.ObjectId)):
            raise TypeError(f"an object is found by its name or its id, not by a {type(name).__name__}")
        for each in self.objects:
            if each.name == name if isinstance(name, str) else each._is(name):
                return each
        return None

    def add_cloth(self, mesh: Mesh, settings: Optional[structs.ClothDef] = None, *,
                  material: Union[structs.Material, str, dict[str, Any], None] = None, **changes: Any) -> Cloth:
        """Adds a cloth, also while the world runs.

        mesh: an oriented manifold, at its place. material: a Material, the name of a preset such as "silk", or changes of
        cotton. changes: fields of ClothDef by name, as `pins=[Pin([0, 39])]` or `rest_positions=...`.
        """
        view = view_mesh(mesh)
        keep: list[Any] = []
        definition = structs.ClothDef.make(settings, changes, "add_cloth")
        if isinstance(material, str):
            definition.material = make_material(material)
        elif material is not None:
            definition.material = structs.Material.make(material, {}, "material")
        count = mesh.vertex_count
        for field, rows in (("rest_positions", count), ("velocities", count), ("rest_corners", mesh.triangle_count),
                            ("warps", mesh.triangle_count), ("stiffness_factors", mesh.triangle_count)):
            value = getattr(definition, field)
            numbers = {"rest_corners": 9, "stiffness_factors": 1}.get(field, 3)
            if value is not None and np.size(value) != numbers * rows:
                raise InvalidArgumentError(f"{field} should have {rows} rows, one for each "
                                           f"{'vertex' if rows == count else 'triangle'}, not shape {np.shape(value)}")
        made = definition.to_c(keep)
        made.mesh = view
        identity = ffi.new("tulle_cloth_id *")
        try:
            self._change(core.tulle_world_add_cloth, made, identity)
        finally:
            if identity.generation:  # also where Ctrl-C came when it was done
                self._cloths.append(Cloth(self, identity))
        return self._cloths[-1]

    def add_obstacle(self, mesh: Mesh, settings: Optional[structs.ObstacleDef] = None, *, frames: Optional[Frames] = None,
                     body: Union[structs.BodyDef, dict[str, Any], None] = None, **changes: Any) -> Obstacle:
        """Adds an obstacle or, with `body`, a rigid body, also while the world runs.

        frames: (frames, vertices, 3) positions [m] of a mesh that deforms, or a function that gives those of a frame and is
        asked for each when it is needed; then `frame_count=` says how many there are. `frame_interval` [s] lies between
        them. body: a BodyDef, or its fields, as `body={"density": 700}`. changes: fields of ObstacleDef by name, as
        `friction=0.5` or `drive="rigid"`. Triangles that the mesh has twice or that have no area are left out, with a
        warning; one that deforms may have them now and then.
        """
        view_mesh(mesh)  # or a TypeError
        keep: list[Any] = []
        frame_count = changes.pop("frame_count", None)
        definition = structs.ObstacleDef.make(settings, changes, "add_obstacle")
        if body is not None:
            definition.body = structs.BodyDef.make(body, {}, "body")
            definition.body.is_dynamic = True
        mesh = leave_out(mesh, frames is not None or definition.drive == structs.Drive.DEFORMING)
        view = view_mesh(mesh)
        made = definition.to_c(keep)
        made.mesh = view
        if frames is not None:
            made.read_frame, made.frame_count = self._make_reader(frames, mesh.vertex_count, frame_count)
        elif frame_count is not None:
            raise TypeError("add_obstacle has a frame_count, but no frames")
        identity = ffi.new("tulle_obstacle_id *")
        try:
            self._change(core.tulle_world_add_obstacle, made, identity)
        finally:
            if identity.generation:
                self._obstacles.append((Body if made.body.is_dynamic else Obstacle)(self, identity))
        return self._obstacles[-1]

    def _make_reader(self, frames: Frames, vertex_count: int, frame_count: Optional[int]) -> tuple[Any, int]:
        """A tulle_frame_reader over an array or a function, and how many frames it has."""
        if callable(frames):
            if frame_count is None:
                raise TypeError("frames is a function: say with frame_count= how many frames it has")
            read = frames
        else:
            array = np.asarray(frames)
            if array.dtype.kind not in "fiu":
                raise InvalidArgumentError(f"frames should hold real numbers, not {array.dtype}")
            array = np.ascontiguousarray(array, dtype=np.float64)
            if array.ndim != 3 or array.shape[1:] != (vertex_count, 3) or not array.shape[0]:
                raise InvalidArgumentError(f"frames should have the shape (frames, {vertex_count}, 3), not {array.shape}")
            if frame_count is not None and frame_count != array.shape[0]:
                raise InvalidArgumentError(f"there are {array.shape[0]} frames, and frame_count is {frame_count}")
            frame_count, read = array.shape[0], array.__getitem__

        def give(context: Any, frame: int, positions: Any, error: Any) -> int:
            rows = to_doubles(read(frame), 3, f"frame {frame}", vertex_count)
            ffi.memmove(positions, ffi.from_buffer(rows), rows.nbytes)
            return 0

        reader = ffi.callback("tulle_status(void *, uint32_t, double *, tulle_error *)", give,
                              error=int(structs.Status.IO), onerror=self._callbacks.note)
        self._callbacks.kept.append(reader)
        return reader, frame_count

    def remove(self, each: Object) -> None:
        """Removes a cloth, an obstacle or a body, before the start or later. All other objects keep their state, bit for bit."""
        self._own(each)
        if isinstance(each, Cloth):
            self._change(core.tulle_world_remove_cloth, each._id[0])
            self._cloths.remove(each)
        else:
            self._change(core.tulle_world_remove_obstacle, each._id[0])
            self._obstacles.remove(each)  # type: ignore[arg-type]
        each._is_removed = True

    def attach(self, cloth: Cloth, vertices: ArrayLike, to: Union[Object, ArrayLike], **changes: Any) -> Attachment:
        """Attaches vertices of a cloth to an obstacle, a body, another cloth, or to points in space [m] (vertices, 3).

        changes: fields of AttachmentDef by name, as `stiffness=1e4` or `max_distance=0.02`.
        """
        self._own(cloth)
        points = None if isinstance(to, Object) else to_doubles(to, 3, "to", int(np.size(vertices)))
        values: dict[str, Any] = {"vertices": to_indices(vertices, 1, "vertices"), **({} if points is None else {"points": points}), **changes}
        keep: list[Any] = []
        made = structs.AttachmentDef.make(None, values, "attach").to_c(keep)
        made.cloth = cloth._id[0]
        if isinstance(to, Object):
            self._own(to)
            if isinstance(to, Cloth):
                made.other_cloth = to._id[0]
            else:
                made.obstacle = to._id[0]
        identity = ffi.new("tulle_attachment_id *")
        self._call(core.tulle_world_attach, made, identity)
        return Attachment(self, int(identity[0]), cloth)

    def place(self, positions: ArrayLike) -> None:
        """Puts cloths and obstacles with `drive="deforming"` elsewhere, at rest: (vertices, 3) [m] of all cloths, then of all obstacles.

        Positions of other obstacles are not read. Raises IntersectingStartError where something would intersect; all is then
        where it was. Experimental: it may change.
        """
        rows = to_doubles(positions, 3, "positions")
        self._change(core.tulle_world_place, point_to(rows, "double *"), rows.shape[0])

    def _own(self, each: Object) -> None:
        if not isinstance(each, Object):
            raise TypeError(f"a cloth, an obstacle or a body is needed, not a {type(each).__name__}")
        if each.world is not self:
            raise InvalidArgumentError(f"\"{each.name}\" is of another world")

    def set_law(self, a: Object, b: Object, law: Optional[structs.ContactLaw] = None, **changes: Any) -> None:
        """Sets friction and restitution of a pair of objects, in place of what their materials say, at any time."""
        self._own(a)
        self._own(b)
        if isinstance(b, Cloth) and not isinstance(a, Cloth):
            a, b = b, a
        keep: list[Any] = []
        made = structs.ContactLaw.make(law, changes, "set_law").to_c(keep)
        if isinstance(a, Cloth):
            name = "tulle_world_set_cloth_cloth_law" if isinstance(b, Cloth) else "tulle_world_set_cloth_obstacle_law"
        else:
            name = "tulle_world_set_obstacle_obstacle_law"
        self._call(getattr(core, name), a._id[0], b._id[0], made)

    def set_material_law(self, a: str, b: str, law: Optional[structs.ContactLaw] = None, **changes: Any) -> None:
        """Sets the law of all pairs of surfaces with the contact materials `a` and `b`, by name; only before the start."""
        keep: list[Any] = []
        made = structs.ContactLaw.make(law, changes, "set_material_law").to_c(keep)
        self._call(core.tulle_world_set_material_law, a.encode(), b.encode(), made)

    def set_pair_filter(self, collides: Optional[Callable[[Object, Object], bool]]) -> None:
        """Before the start: asks `collides(a, b)` once for each pair of objects that may meet. None: asks no more.

        It must not use the world. The call that asks raises what it raises; the pair then collides.
        """
        if collides is None:
            self._call(core.tulle_world_set_pair_filter, ffi.NULL, ffi.NULL)
            return

        decide = collides

        def ask(context: Any, world: Any, a: Any, b: Any) -> int:
            first, second = self.find_object(structs.ObjectId(a)), self.find_object(structs.ObjectId(b))
            # An object that is being added has no Python object yet.
            return 1 if first is None or second is None else int(bool(decide(first, second)))

        made = ffi.callback("int(void *, const tulle_world *, tulle_object_id, tulle_object_id)", ask, error=1,
                            onerror=self._callbacks.note)
        self._callbacks.kept.append(made)
        self._call(core.tulle_world_set_pair_filter, made, ffi.NULL)

    # ---- time ----

    def start(self) -> None:
        """Prepares the first step and judges the start; the first step does so if you do not.

        Raises IntersectingStartError; `get_intersections` then gives all pairs.
        """
        self._change(core.tulle_world_start)
        self._is_started = True

    def start_at(
        self, time: float, positions: ArrayLike, velocities: ArrayLike, step_count: int = 0, bodies: Sequence[structs.Transform] = ()
    ) -> None:
        """Starts at a later time [s], with all cloth, in the order of adding, at these places [m] and velocities [m/s]: (vertices, 3).

        `bodies` gives place, rotation and velocities of each rigid body, in the order of adding, as its `transform` does. Rest shapes,
        pins and attachments are those of a start at time 0; contacts are new. `step_count` continues from there. Raises
        InvalidArgumentError for other shapes and numbers of bodies, IntersectingStartError as `start` does.
        """
        places, speeds = to_doubles(positions, 3, "positions"), to_doubles(velocities, 3, "velocities")
        if places.shape != speeds.shape:
            raise InvalidArgumentError(f"positions have {len(places)} rows, velocities {len(speeds)}")
        moment = ffi.new("tulle_moment *", {"time": time, "step_count": step_count, "vertex_count": len(places)})
        moment.positions, moment.velocities = point_to(places, "double *"), point_to(speeds, "double *")
        transforms = ffi.new("tulle_transform[]", len(bodies))
        for i, body in enumerate(bodies):
            transforms[i] = body._c[0]
        moment.bodies, moment.body_count = transforms, len(bodies)
        self._change(core.tulle_world_start_at, moment)
        self._is_started = True

    def step(self, time_step: float) -> structs.StepReport:
        """Moves the world on by `time_step` [s], 0 < time_step <= 1, and reports what the step did.

        Raises PinchedError, StepFailedError, IntersectingStartError, LimitError, OutOfMemoryError, KeyboardInterrupt; the
        world is as it was before the step then.
        """
        report = ffi.new("tulle_step_report *")
        self._change(core.tulle_world_step, time_step, report)
        self._is_started = True
        return structs.StepReport(report)

    @property
    def time(self) -> float:
        """[s] 0 at the start."""
        return self._get(core.tulle_world_get_time)  # type: ignore[no-any-return]

    @property
    def step_count(self) -> int:
        """Number of steps made."""
        return self._get(core.tulle_world_get_step_count)  # type: ignore[no-any-return]

    @property
    def last_message(self) -> str:
        """What the last step has to say, as that a pinch begins; empty if nothing."""
        return decode(self._get(core.tulle_world_last_message))

    # ---- state ----

    @property
    def state_hash(self) -> int:
        """Hash of everything that decides the future. Equal states have equal hashes on every machine."""
        return self._get(core.tulle_world_get_state_hash)  # type: ignore[no-any-return]

    def save_state(self) -> bytes:
        """The state as bytes, for `load_state` of a world that was made in the same way."""
        with self._using():
            if self._handle is None:
                raise ClosedError("the world was closed")
            size = core.tulle_world_get_state_size(self._handle)
            buffer, count = bytearray(max(size, 1)), ffi.new("size_t *")
            status = core.tulle_world_save_state_into(self._handle, ffi.from_buffer(buffer), len(buffer), count, self._error)
            if status:
                raise make_exception(status, self._error)
        return bytes(memoryview(buffer)[:count[0]])

    def load_state(self, state: bytes) -> None:
        """Puts a saved state in place. Raises InvalidArgumentError (another world) and ParseError; all stays as it was then."""
        if not isinstance(state, (bytes, bytearray, memoryview)):
            raise TypeError(f"the state should be bytes, not a {type(state).__name__}")
        self._change(core.tulle_world_load_state, ffi.from_buffer(state), len(memoryview(state).cast("B")))
        self._is_started = True

    def record(self, path: PathLike) -> None:
        """Records all calls to a file, for `tulle replay FILE`; before anything is added. Ends with `end_recording`, `close`."""
        file = open(path, "wb")  # noqa: SIM115 - closed by end_recording

        def write(context: Any, data: Any, count: int) -> int:
            file.write(ffi.buffer(data, count))
            file.flush()
            return 1

        made = ffi.callback("int(void *, const void *, size_t)", write, error=0, onerror=self._callbacks.note)
        self._callbacks.kept.append(made)
        writer = ffi.new("tulle_record_writer *", {"write": made})
        try:
            self._call(core.tulle_world_record, writer)
        except BaseException:
            file.close()
            raise
        self._recording = file

    def end_recording(self) -> None:
        """Ends the recording. Raises what ended it before, if something did."""
        try:
            self._call(core.tulle_world_record, ffi.NULL)
        finally:
            if self._recording is not None:
                self._recording.close()
                self._recording = None

    # ---- settings ----

    def set_gravity(self, gravity: ArrayLike) -> None:
        """Changes gravity [m/s^2] from the next step on."""
        self._call(core.tulle_world_set_gravity, point_to(to_vector(gravity, "gravity"), "double *"))

    def set_wind(self, wind: Optional[structs.Wind] = None, **changes: Any) -> None:
        """Changes the wind from the next step on. `changes`: fields of Wind by name."""
        keep: list[Any] = []
        self._call(core.tulle_world_set_wind, structs.Wind.make(wind, changes, "set_wind").to_c(keep))

    # ---- what there is to see ----

    @property
    def distances(self) -> tuple[float, float, float]:
        """[m] The contact distance, the separation distance and the minimum gap in force."""
        out = [ffi.new("double *") for _ in range(3)]
        self._get(core.tulle_world_get_distances, *out)
        return out[0][0], out[1][0], out[2][0]

    @property
    def counts(self) -> structs.Counts:
        """How much there is in the world."""
        return structs.Counts(ffi.new("tulle_counts *", self._get(core.tulle_world_get_counts)))

    @property
    def largest_stretch(self) -> structs.Stretch:
        """The edge or yarn of the cloth that is longest relative to its rest length."""
        return structs.Stretch(ffi.new("tulle_stretch *", self._get(core.tulle_world_find_largest_stretch)))

    @property
    def untangle_report(self) -> structs.UntangleReport:
        """What untangling did at the start."""
        return structs.UntangleReport(ffi.new("tulle_untangle_report *", self._get(core.tulle_world_get_untangle_report)))

    def get_contacts(self) -> NDArray[Any]:
        """The contacts of the last step: an array of CONTACT records. Objects are numbered as in `objects`."""
        given, count = ffi.new("const tulle_contact **"), ffi.new("size_t *")
        with self._using():
            if self._handle is None:
                raise ClosedError("the world was closed")
            status = core.tulle_world_get_contacts(self._handle, given, count, self._error)
            if status:
                raise make_exception(status, self._error)
            return copy_from(given[0], count[0], structs.CONTACT)

    def get_intersections(self) -> NDArray[Any]:
        """The pairs of triangles for which the last start failed: an array of INTERSECTION records."""
        return self._copy_borrowed(core.tulle_world_get_intersections, structs.INTERSECTION)

    def get_overlaps(self) -> NDArray[Any]:
        """How deep the pairs of `get_intersections` lie in each other, and where: an array of OVERLAP records."""
        return self._copy_borrowed(core.tulle_world_get_overlaps, structs.OVERLAP)

    def _copy_borrowed(self, function: Any, record: Any) -> NDArray[Any]:
        count = ffi.new("size_t *")
        with self._using():
            if self._handle is None:
                raise ClosedError("the world was closed")
            return copy_from(function(self._handle, count), count[0], record)

    def watch_events(self, watch: Optional[structs.EventWatch] = None, **changes: Any) -> None:
        """Begins to watch what happens, for `poll_events`. `changes`: fields of EventWatch; the world must have started."""
        keep: list[Any] = []
        self._call(core.tulle_world_watch_events, structs.EventWatch.make(watch, changes, "watch_events").to_c(keep))

    def poll_events(self) -> tuple[NDArray[Any], int]:
        """What happened since the last call, as EVENT records in order, and how many more there was no room for."""
        parts, lost, count = [], 0, ffi.new("size_t *")
        room, missed = ffi.new("tulle_event[1024]"), ffi.new("uint64_t *")
        while True:
            self._call(core.tulle_world_poll_events, room, 1024, count, missed)
            lost += missed[0]
            parts.append(copy_from(room, count[0], structs.EVENT))
            if count[0] < 1024:
                return np.concatenate(parts), lost

    def get_numerical_damping(self, time_step: float, period: float) -> float:
        """The damping ratio (1: critical) that the integrator gives a free motion of `period` [s] in steps of `time_step` [s]."""
        return self._get(core.tulle_world_get_numerical_damping, time_step, period)  # type: ignore[no-any-return]

    # ---- queries ----

    def cast_ray(self, start: ArrayLike, end: ArrayLike, *, mask: int = 0, skips_back_faces: bool = False) -> Optional[structs.Hit]:
        """The first triangle that the straight line from `start` to `end` [m] meets; None: none.

        `find_object(hit.object)` gives the object. mask: only objects with a category in common with it; 0: all.
        skips_back_faces: triangles are seen from the front only.
        """
        ray = ffi.new("tulle_ray *", {"from": to_vector(start, "start").tolist(), "to": to_vector(end, "end").tolist(),
                                      "mask": mask, "skips_back_faces": skips_back_faces})
        return self._find(core.tulle_world_cast_ray, ray)

    def find_closest_point(self, point: ArrayLike, max_distance: float = float("inf"), *, mask: int = 0) -> Optional[structs.Hit]:
        """The place on any surface that is nearest to `point` [m]; None: none within `max_distance` [m].

        mask: only objects with a category in common with it; 0: all.
        """
        place = to_vector(point, "point")
        return self._find(core.tulle_world_find_closest_point, point_to(place, "double *"), max_distance, mask)

    def _find(self, function: Any, *arguments: Any) -> Optional[structs.Hit]:
        hit = ffi.new("tulle_hit *")
        self._call(function, *arguments, hit)
        return structs.Hit(hit) if hit.object.kind else None

    def find_box_overlaps(self, low: ArrayLike, high: ArrayLike, *, mask: int = 0) -> list[tuple[Object, int]]:
        """All triangles that have a point in common with the box from `low` to `high` [m], as objects and triangle numbers.

        mask: only objects with a category in common with it; 0: all.
        """
        corners = to_vector(low, "low"), to_vector(high, "high")
        found = self._find_triangles(core.tulle_world_find_box_overlaps, *(point_to(row, "double *") for row in corners), mask)
        return [(each, triangle) for each, triangle, _ in found]

    def find_mesh_overlaps(self, mesh: Mesh, *, mask: int = 0) -> list[tuple[Object, int, int]]:
        """All pairs of a triangle of the world and one of `mesh` that have a point in common: object, its triangle, mesh's.

        mask: only objects with a category in common with it; 0: all.
        """
        return self._find_triangles(core.tulle_world_find_mesh_overlaps, view_mesh(mesh), mask)

    def _find_triangles(self, function: Any, *arguments: Any) -> list[tuple[Object, int, int]]:
        capacity = 256
        while True:
            room = ffi.new("tulle_found_triangle[]", capacity)
            found = ffi.new("tulle_found *", {"triangles": room, "capacity": capacity})
            self._call(function, *arguments, found)
            if found.count <= capacity:
                break
            capacity = found.count
        objects = {(each._kind, each._id.index, each._id.generation): each for each in self.objects}
        return [(objects[one.object.kind, one.object.index, one.object.generation], one.triangle, one.other)
                for one in room[0:found.count]]


def _see_signals(flag: Any) -> int:
    """Runs in the main thread within a step: the interpreter looks at its signals here, and Ctrl-C raises."""
    return 0 if ffi.cast("char *", flag)[0] == b"0" else 1


def _note_interrupt(kind: Any, failure: BaseException, trace: Any) -> None:
    _interrupted.append(failure)


_interrupted: list[BaseException] = []
_ask_python: Any = ffi.callback("int(void *)", _see_signals, error=1, onerror=_note_interrupt)
# Reads the flag as a number: "0" or "1". It needs no interpreter, so threads do not wait for one another.
_ask_flag: Any = ffi.cast("int (*)(void *)", ffi.dlopen(None).atoi)


def make_material(name: str = "cotton", **changes: Any) -> structs.Material:
    """The preset `name`, one of `list_materials()`, with `changes` by the names of the fields of Material."""
    made = ffi.new("tulle_material *")
    if core.tulle_material_preset(name.encode(), made):
        raise InvalidArgumentError(f"there is no material \"{name}\"; there are {', '.join(list_materials())}")
    material: structs.Material = structs.Material.make(structs.Material.from_c(made), changes, "make_material")
    return material


def list_materials() -> list[str]:
    """The names of all presets."""
    names: list[str] = []
    while True:
        name = core.tulle_material_preset_name(len(names))
        if name == ffi.NULL:
            return names
        names.append(decode(name))


def step_worlds(worlds: Sequence[World], time_step: float, threads: int = 0) -> list[Union[structs.StepReport, Error]]:
    """Makes one step of `time_step` [s] of each world, each on one thread alone: the way to run many small worlds.

    threads: 0 .. 256; 0: one per processor. Gives the report of each world, or the error of a world whose step failed; it is
    as it was, and keeps no other from its step. The bits are those of `World.step`.
    """
    count = len(worlds)
    handles, statuses = ffi.new("tulle_world *[]", count or 1), ffi.new("tulle_status[]", count or 1)
    reports, error = ffi.new("tulle_step_report[]", count or 1), make_error_buffer()
    locks, taken = [world._lock for world in worlds], []  # type: ignore[var-annotated]
    release = map(_release, compress(locks, taken))
    try:
        taken.extend(map(_try_to_acquire, locks))  # one call of the interpreter, as the release: Ctrl-C leaves none locked
        for i, world in enumerate(worlds):
            if not taken[i]:
                raise BusyError(f"world {i} is in use, or is given twice")
            if world._handle is None:
                raise ClosedError(f"world {i} was closed")
            handles[i] = world._handle
        former = []
        for world in worlds:
            world._ask_by(_ask_flag)
            world._flag[0] = b"0"
            former.append(world._clock.advance())
        batch = ffi.new("tulle_world_batch *", {"worlds": handles, "count": count, "threads": threads, "reports": reports,
                                                "statuses": statuses})
        for i in range(count):
            statuses[i] = _NOT_STEPPED
        status = core.tulle_worlds_step(batch, time_step, error)
        if status and (not count or statuses[0] == _NOT_STEPPED):
            for world, number in zip(worlds, former):
                world._clock.now = number
            raise make_exception(status, error)
        out: list[Union[structs.StepReport, Error]] = []
        failures: list[BaseException] = []
        for i, world in enumerate(worlds):
            failure = world._callbacks.take()
            if failure is not None and not isinstance(failure, Error):
                failures.append(failure)
            if statuses[i]:
                world._clock.now = former[i]
                out.append(failure if isinstance(failure, Error) else make_exception(statuses[i], error))
                error = make_error_buffer()  # the message was that of the first
            else:
                world._is_started = True
                out.append(structs.StepReport(reports[i], reports))
        if failures:
            raise failures[0]
        return out
    finally:
        deque(release, 0)


def replay(path: PathLike, threads: int = 0) -> structs.ReplayReport:
    """Repeats a recording, up to its end or to the first call that comes to another state, which the report names.

    threads: 1 .. 256, in place of those recorded; 0: as recorded.
    """
    with open(path, "rb") as file:
        data = file.read()
    options = ffi.new("tulle_replay_options *", {"threads": threads})
    report, error = ffi.new("tulle_replay_report *"), make_error_buffer()
    status = core.tulle_replay(ffi.from_buffer(data), len(data), options, report, error)
    if status:
        raise make_exception(status, error)
    return structs.ReplayReport(report)
