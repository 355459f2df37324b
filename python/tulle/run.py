"""Runs: the directories that `tulle run` and `RunWriter` leave, read frame by frame; and point caches."""
from __future__ import annotations

import os
import threading
from dataclasses import dataclass
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tulle import structs
from tulle._arrays import Doubles, copy_from, point_to, to_doubles
from tulle._handles import Unique, take_turn
from tulle._library import ffi, io
from tulle._structs import decode
from tulle.errors import ClosedError, InvalidArgumentError, check, make_error_buffer
from tulle.mesh import Mesh, PathLike, copy_view, encode_path
from tulle.objects import Body, Cloth, Obstacle
from tulle.world import World


class _Handle:
    """A handle of the library that one thread at a time may use."""

    def __init__(self, pointer: Any, release: Any, what: str) -> None:
        self._pointer, self._what, self._lock = ffi.gc(pointer, release), what, threading.Lock()

    def using(self) -> threading.Lock:
        """The lock, for `with`."""
        return take_turn(self._lock, self._what)

    def get(self) -> Any:
        """What to hand to the library; the lock is held."""
        if self._pointer is None:
            raise ClosedError(f"{self._what} was closed")
        return self._pointer

    @property
    def is_closed(self) -> bool:
        """Whether it was released."""
        return self._pointer is None

    def close(self) -> None:
        """Releases it; nothing happens where it is closed."""
        with self._lock:
            if self._pointer is not None:
                ffi.release(self._pointer)
                self._pointer = None


@dataclass(frozen=True)
class RunFrame:
    """A frame of a run."""

    number: int
    """From 0, which is the start."""
    time: float
    """[s]."""
    step: int
    """Steps done."""
    state_hash: int
    """Hash of the world's state."""


class RunBody:
    """A cloth or an obstacle of a run."""

    def __init__(self, run: Run, index: int, info: Any) -> None:
        self._run, self.index = run, index
        self.name: str = decode(info.name)
        self.mesh_file: str = decode(info.mesh_file)
        self.cache_file: str = decode(info.cache_file)
        self.is_obstacle, self.is_static = bool(info.is_obstacle), bool(info.is_static)
        self.is_dynamic = bool(info.is_dynamic)
        self.vertex_count: int = info.vertex_count
        self.triangle_count: int = info.triangle_count
        self._mesh: Optional[Mesh] = None

    @property
    def mesh(self) -> Mesh:
        """Its mesh where it starts."""
        if self._mesh is None:
            view, error = ffi.new("tulle_mesh_view *"), make_error_buffer()
            with self._run._handle.using():
                check(io.tulle_run_reader_get_mesh(self._run._handle.get(), self.index, view, error), error)
                self._mesh = copy_view(view)
        return self._mesh

    def read_positions(self, frame: int, out: Optional[Doubles] = None) -> Doubles:
        """[m] (vertices, 3) at a frame, from 0; negative ones count from the end. `out`: filled in place of a new array."""
        if out is None:
            out = np.empty((self.vertex_count, 3))
        if (not isinstance(out, np.ndarray) or out.shape != (self.vertex_count, 3) or out.dtype != np.float64
                or not out.flags.c_contiguous or not out.flags.writeable):
            raise InvalidArgumentError(f"out should be a writeable array of float64 without gaps, of shape ({self.vertex_count}, 3)")
        error = make_error_buffer()
        number = self._run._number(frame)
        with self._run._handle.using():
            check(io.tulle_run_reader_read_positions(self._run._handle.get(), number, self.index, point_to(out, "double *"), error),
                  error)
        return out

    def is_present(self, frame: int) -> bool:
        """Whether it is in the scene at a frame."""
        number = self._run._number(frame)
        with self._run._handle.using():
            return bool(io.tulle_run_reader_is_present(self._run._handle.get(), number, self.index))

    def __repr__(self) -> str:
        return f"RunBody(\"{self.name}\")"


class Run:
    """A run that is read lazily: each frame when it is asked for, compared with its checksum.

    >>> run = Run("out/sphere")
    >>> run.bodies[0].read_positions(-1)

    A run that goes on or was killed is read up to its last whole frame.
    """

    def __init__(self, directory: PathLike) -> None:
        """Opens a directory. Raises FileError, ParseError, LimitError."""
        made, error = ffi.new("tulle_run_reader **"), make_error_buffer()
        check(io.tulle_run_reader_open(encode_path(directory), made, error), error)
        self._handle = _Handle(made[0], io.tulle_run_reader_close, "the run")
        self.path = os.fspath(directory)
        with self._handle.using():
            info = io.tulle_run_reader_get_info(self._handle.get())
            self.version = decode(info.version)
            self.scene_path = decode(info.scene_path)
            self.scene_text = decode(info.scene_text)
            self.scene_hash: int = info.scene_hash
            self.seed: int = info.seed
            self.time_step: float = info.time_step
            self.steps_per_frame: int = info.steps_per_frame
            self.wanted_frame_count: int = info.wanted_frame_count
            self.frame_count: int = info.frame_count
            self.state = structs.RunState(info.state)
            self.message = decode(info.message)
            self.has_checkpoint = bool(info.has_checkpoint)
            self.checkpoint_step: int = info.checkpoint_step
            self.outcome = None if info.outcome == ffi.NULL else structs.RunOutcome(
                ffi.new("tulle_run_outcome *", info.outcome[0]))
            self.bodies = tuple(RunBody(self, i, info.bodies[i]) for i in range(info.body_count))

    def close(self) -> None:
        """Releases the run."""
        self._handle.close()

    def __enter__(self) -> Run:
        return self

    def __exit__(self, *unused: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"Run({self.path!r}, {self.frame_count} frames, {self.state.name.lower()})"

    def _repr_html_(self) -> Optional[str]:
        """For notebooks: `tulle.show`."""
        from tulle.notebook import represent
        return None if self._handle.is_closed else represent(self)

    def _number(self, frame: int) -> int:
        number = frame + self.frame_count if frame < 0 else frame
        if not 0 <= number < self.frame_count:
            raise InvalidArgumentError(f"there is no frame {frame}; the run has {self.frame_count}")
        return number

    def find_body(self, name: str) -> Optional[RunBody]:
        """The body of that name; None: there is none."""
        return next((body for body in self.bodies if body.name == name), None)

    @property
    def frames(self) -> list[RunFrame]:
        """What there is to know of each frame beside its positions."""
        return [self.get_frame(frame) for frame in range(self.frame_count)]

    def get_frame(self, frame: int) -> RunFrame:
        """What there is to know of a frame, from 0; negative ones count from the end."""
        time, step, state = ffi.new("double *"), ffi.new("uint64_t *"), ffi.new("uint64_t *")
        number = self._number(frame)
        with self._handle.using():
            io.tulle_run_reader_get_frame(self._handle.get(), number, time, step, state)
        return RunFrame(number, time[0], step[0], state[0])

    @property
    def reports(self) -> NDArray[Any]:
        """STEP_REPORT records: what each step did."""
        given, count, error = ffi.new("const tulle_step_report **"), ffi.new("size_t *"), make_error_buffer()
        with self._handle.using():
            check(io.tulle_run_reader_get_reports(self._handle.get(), given, count, error), error)
            return copy_from(given[0], count[0], structs.STEP_REPORT)

    def get_lags(self, frame: int) -> NDArray[Any]:
        """RUN_LAG records: the obstacles that lag behind their frames at a frame."""
        given, count = ffi.new("const tulle_run_lag **"), ffi.new("size_t *")
        number = self._number(frame)
        with self._handle.using():
            io.tulle_run_reader_get_lags(self._handle.get(), number, given, count)
            return copy_from(given[0], count[0], structs.RUN_LAG)

    def find_damage(self) -> list[tuple[str, Optional[int], str]]:
        """What is not as the run wrote it: file, first damaged frame or None, message. Reads all of the run."""
        given, count, error = ffi.new("const tulle_run_damage **"), ffi.new("size_t *"), make_error_buffer()
        with self._handle.using():
            check(io.tulle_run_reader_find_damage(self._handle.get(), given, count, error), error)
            return [(decode(each.file), None if each.frame < 0 else each.frame, decode(each.message))
                    for each in given[0][0:count[0]]] if count[0] else []


class RunWriter(Unique):
    """Writes what a world does to a run directory, which the program, `Run` and other tools read.

    >>> with RunWriter("out/mine", world, time_step=1 / 90) as writer:
    ...     for _ in range(90):
    ...         writer.write_report(world.step(1 / 90))
    ...         writer.write_frame()
    """

    def __init__(self, directory: PathLike, world: World, time_step: float, *, steps_per_frame: int = 1, frame_count: int = 0,
                 replace: bool = False, writes_vtp: bool = False) -> None:
        """Makes the directory with the meshes as they are now, and writes frame 0. `replace`: in place of a run that is there.

        steps_per_frame: steps of `time_step` [s] between two frames. frame_count: frames that are wanted, for the record.
        writes_vtp: each frame also as VTP files. Objects must not come and go meanwhile.
        """
        if not world._is_started:
            world.start()
        self._world: World = world
        self._objects: tuple[Union[Cloth, Obstacle], ...] = (*world.cloths, *world.obstacles)
        keep: list[Any] = []
        bodies = ffi.new("tulle_run_body[]", len(self._objects) or 1)
        for i, each in enumerate(self._objects):
            mesh, name = each.mesh, ffi.new("char[]", each.name.encode())
            keep += [mesh, name]
            bodies[i].name, bodies[i].mesh = name, mesh._view()
            bodies[i].is_obstacle, bodies[i].is_dynamic = not isinstance(each, Cloth), isinstance(each, Body)
            bodies[i].is_static = isinstance(each, Obstacle) and each.is_static
        path = ffi.new("char[]", encode_path(directory))
        definition = ffi.new("tulle_run_def *", io.tulle_run_def_default())
        definition.directory, definition.bodies, definition.body_count = path, bodies, len(self._objects)
        definition.time_step, definition.steps_per_frame = time_step, steps_per_frame
        definition.frame_count, definition.writes_vtp = frame_count, writes_vtp
        made, error = ffi.new("tulle_run_writer **"), make_error_buffer()
        existing = structs.RunExisting.REPLACE if replace else structs.RunExisting.REFUSE
        check(io.tulle_run_create(definition, int(existing), made, error), error)
        self._writer, self._error, self._lock = made[0], error, threading.Lock()
        self._outcome = ffi.new("tulle_run_outcome *")
        self.write_frame()

    def write_frame(self) -> None:
        """Appends the present state as a frame. Raises DiskFullError, FileError, and LimitError where rounding to float leads a
        surface through another or itself; the frames before are whole then."""
        world, frame = self._world, ffi.new("tulle_run_frame *")
        arrays = [[np.asarray(each.positions) for each in self._objects], [np.asarray(each.velocities) for each in self._objects]]
        rows = [ffi.new("double *[]", [point_to(array, "double *") for array in each] or [ffi.NULL]) for each in arrays]
        present = ffi.new("int[]", [int(isinstance(each, Cloth) or each.is_present) for each in self._objects] or [0])
        dynamic = [each for each in self._objects if isinstance(each, Body)]
        transforms = ffi.new("tulle_transform[]", len(dynamic) or 1)
        for i, body in enumerate(dynamic):
            transforms[i] = body.transform._c[0]
        frame.time, frame.step, frame.state_hash = world.time, world.step_count, world.state_hash
        frame.positions, frame.velocities, frame.is_present, frame.transforms = rows[0], rows[1], present, transforms
        with self._using():
            check(io.tulle_run_write_frame(self._get(), frame, self._error), self._error)

    def write_report(self, report: structs.StepReport) -> None:
        """Appends what a step did."""
        whole = report._c if ffi.typeof(report._c).kind == "pointer" else ffi.addressof(report._c)
        with self._using():
            check(io.tulle_run_write_report(self._get(), whole, self._error), self._error)
            io.tulle_run_outcome_add(self._outcome, whole)
            io.tulle_run_set_outcome(self._get(), self._outcome)

    def _using(self) -> threading.Lock:
        """The lock, for `with`."""
        return take_turn(self._lock, "the run")

    def _get(self) -> Any:
        if self._writer is None:
            raise ClosedError("the run was closed")
        return self._writer

    def close(self, state: structs.RunState = structs.RunState.FINISHED, message: str = "") -> None:
        """Ends the run as `state`, with `message` in its record."""
        with self._using():
            writer, self._writer = self._writer, None
            if writer is not None:
                check(io.tulle_run_close(writer, int(state), message.encode() or ffi.NULL, self._error), self._error)

    def __enter__(self) -> RunWriter:
        return self

    def __exit__(self, kind: Any, failure: Optional[BaseException], trace: Any) -> None:
        if failure is None:
            self.close()
        elif isinstance(failure, KeyboardInterrupt):
            self.close(structs.RunState.INTERRUPTED)
        else:
            self.close(structs.RunState.FAILED, str(failure))


class PointCache:
    """A PC2 or MDD file that is read: the positions of one body at every frame."""

    def __init__(self, path: PathLike) -> None:
        """Opens the file. Raises FileError, ParseError."""
        made, info, error = ffi.new("tulle_pc2 **"), ffi.new("tulle_pc2_info *"), make_error_buffer()
        check(io.tulle_pc2_open(encode_path(path), made, info, error), error)
        self._handle = _Handle(made[0], io.tulle_pc2_close, "the point cache")
        self.vertex_count: int = info.vertex_count
        self.frame_count: int = info.frame_count
        self.start_frame: float = info.start_frame
        self.frame_step: float = info.frame_step

    def __len__(self) -> int:
        return self.frame_count

    def __getitem__(self, frame: int) -> Doubles:
        """[m] (vertices, 3) at a frame; negative ones count from the end."""
        if not -self.frame_count <= frame < self.frame_count:
            raise IndexError(f"there is no frame {frame}; the cache has {self.frame_count}")
        positions, error = np.empty((self.vertex_count, 3)), make_error_buffer()
        with self._handle.using():
            check(io.tulle_pc2_read_frame(self._handle.get(), frame % self.frame_count, point_to(positions, "double *"), error),
                  error)
        return positions

    def get_time(self, frame: int) -> float:
        """[s] of a frame as an MDD file has it; NaN of PC2, which has none."""
        time, error = ffi.new("double *"), make_error_buffer()
        with self._handle.using():
            check(io.tulle_pc2_get_time(self._handle.get(), frame, time, error), error)
        return float(time[0])

    def close(self) -> None:
        """Releases the file."""
        self._handle.close()


class PointCacheWriter(Unique):
    """A PC2 file that is written frame by frame; it is valid after each."""

    def __init__(self, path: PathLike, vertex_count: int, resume_frame_count: int = 0) -> None:
        """Opens the file for frames of `vertex_count` vertices; `resume_frame_count` keeps that many frames of one that is there."""
        made, error = ffi.new("tulle_pc2_writer **"), make_error_buffer()
        check(io.tulle_pc2_writer_open(encode_path(path), vertex_count, resume_frame_count, made, error), error)
        self._writer, self._error, self._vertex_count, self._lock = made[0], error, vertex_count, threading.Lock()

    def append(self, positions: ArrayLike) -> None:
        """Appends a frame. positions: (vertices, 3) [m], which are rounded to floats."""
        rows = to_doubles(positions, 3, "positions", self._vertex_count)
        with take_turn(self._lock, "the point cache"):
            if self._writer is None:
                raise ClosedError("the point cache was closed")
            check(io.tulle_pc2_writer_append(self._writer, point_to(rows, "double *"), self._error), self._error)

    def close(self) -> None:
        """Flushes the file to disk and releases it. Raises FileError, DiskFullError."""
        with take_turn(self._lock, "the point cache"):
            writer, self._writer = self._writer, None
            if writer is not None:
                check(io.tulle_pc2_writer_close(writer, self._error), self._error)

    def __enter__(self) -> PointCacheWriter:
        return self

    def __exit__(self, *unused: object) -> None:
        self.close()
