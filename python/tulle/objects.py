"""Cloths, obstacles and rigid bodies of a world, and attachments between them."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from tulle import structs
from tulle._arrays import Indices, StateArray, copy_from, make_state_array, point_to, to_doubles, to_vector
from tulle._library import core, ffi
from tulle._structs import decode, to_enum
from tulle.errors import ClosedError, InvalidArgumentError
from tulle.mesh import Mesh

if TYPE_CHECKING:
    from tulle.world import World

_TARGET_TYPES = {np.dtype(np.float64): int(structs.NumberType.DOUBLE), np.dtype(np.float32): int(structs.NumberType.FLOAT)}


class Object:
    """A cloth or an obstacle of a world."""

    world: World
    """The world that it is part of."""
    _kind: int
    _name = ""
    _is_removed = False

    def __init__(self, world: World, identity: Any, name: str = "") -> None:
        self.world, self._id = world, identity
        self._arrays: dict[str, StateArray] = {}
        self._triangles: Optional[Indices] = None
        info = self._get_info()
        self._name = name or decode(info.name)
        self._vertex_count, self._triangle_count = int(info.vertex_count), int(info.triangle_count)

    def __repr__(self) -> str:
        return f"{type(self).__name__}(\"{self.name}\")"

    # ---- what it is ----

    def _object_id(self) -> Any:
        return ffi.new("tulle_object_id *", (self._kind, self._id.index, self._id.generation))[0]

    def _is(self, identity: structs.ObjectId) -> bool:
        c = identity._c
        return (c.kind, c.index, c.generation) == (self._kind, self._id.index, self._id.generation)

    def _ask(self, function: Any) -> Any:
        """What a function that takes its id gives; the library gives 0 for one that was removed."""
        if self._is_removed:
            raise InvalidArgumentError(f"\"{self._name}\" was removed from its world")
        return self.world._get(function, self._id[0])

    def _get_info(self) -> Any:
        info = self.world._get(core.tulle_object_get_info, self._object_id())
        if info.triangles == ffi.NULL:
            raise InvalidArgumentError(f"\"{self._name}\" was removed from its world")
        return info

    @property
    def name(self) -> str:
        """As it was added, else "cloth 0", "obstacle 0" and so on."""
        return self._name

    @property
    def vertex_count(self) -> int:
        """Number of vertices."""
        return self._vertex_count

    @property
    def triangles(self) -> Indices:
        """(triangles, 3) vertex numbers, counterclockwise seen from outside; read only."""
        if self._triangles is None:
            info = self._get_info()
            self._triangles = copy_from(info.triangles, info.triangle_count, np.uint32, 3)
            self._triangles.flags.writeable = False
        return self._triangles

    @property
    def mesh(self) -> Mesh:
        """The mesh as it is now, a copy."""
        return Mesh(self.positions.copy(), self.triangles)

    def set_filter(self, category: int = 1, mask: int = 0xFFFFFFFF) -> None:
        """Before the start: its categories, a set of bits `category`, and the `mask` of those that it collides with."""
        self.world._call(core.tulle_object_set_filter, self._object_id(), category, mask)

    # ---- values of its vertices ----

    def _copy_values(self, values: structs.Values, out: NDArray[Any]) -> None:
        target = ffi.new("tulle_target *", {
            "data": ffi.cast("void *", out.ctypes.data), "size": out.strides[0] * (out.shape[0] - 1) + 3 * out.itemsize,
            "stride": out.strides[0], "type": _TARGET_TYPES[out.dtype]})
        self.world._call(core.tulle_object_copy_values, self._object_id(), int(values), target)

    def _read_borrowed(self, function: Any) -> NDArray[np.float64]:
        """A copy of positions or velocities, which the library also gives before the start."""
        world, count = self.world, ffi.new("size_t *")
        with world._using():
            if world._handle is None:
                raise ClosedError("the world was closed")
            pointer = function(world._handle, self._id[0], count)
            if pointer != ffi.NULL:
                return copy_from(pointer, count[0], np.float64, 3)
        raise InvalidArgumentError(f"\"{self._name}\" was removed from its world, or the world has not started")

    def _read(self, name: str) -> StateArray:
        clock = self.world._clock
        made = clock.now  # before it is read: should another thread step meanwhile, the array is stale, not wrong
        if name in ("positions", "velocities"):
            kind = "cloth" if isinstance(self, Cloth) else "obstacle"
            array = self._read_borrowed(getattr(core, f"tulle_{kind}_get_{name}"))
        else:
            rows = self._triangle_count if name == "strains" else self._vertex_count
            array = np.empty((rows, 3))
            self._copy_values(structs.Values[name.upper()], array)
        guarded = self._arrays[name] = make_state_array(array, clock, made)
        return guarded

    @property
    def positions(self) -> StateArray:
        """[m] (vertices, 3) in the present state."""
        array = self._arrays.get("positions")
        return array if array is not None and array._made == self.world._clock.now else self._read("positions")

    @property
    def velocities(self) -> StateArray:
        """[m/s] (vertices, 3); of an obstacle on a script the mean over the last step."""
        array = self._arrays.get("velocities")
        return array if array is not None and array._made == self.world._clock.now else self._read("velocities")

    @property
    def normals(self) -> StateArray:
        """(vertices, 3) unit normals of the front, the mean of the triangles around."""
        array = self._arrays.get("normals")
        return array if array is not None and array._made == self.world._clock.now else self._read("normals")

    @property
    def contact_forces(self) -> StateArray:
        """[N] (vertices, 3): the mean force of all contacts over the last substep."""
        array = self._arrays.get("contact_forces")
        return array if array is not None and array._made == self.world._clock.now else self._read("contact_forces")

    @property
    def drawn_positions(self) -> StateArray:
        """[m] (vertices, 3): those that the frames of an obstacle give, behind which it may lag; else the positions."""
        array = self._arrays.get("drawn_positions")
        return array if array is not None and array._made == self.world._clock.now else self._read("drawn_positions")

    def copy_values(self, values: Union[structs.Values, str], out: Optional[NDArray[Any]] = None,
                    dtype: DTypeLike = np.float64) -> NDArray[Any]:
        """Copies values, such as "positions" or "normals", into `out`, or into a new array of `dtype`; the world has started.

        out: (rows, 3) of float64 or float32 whose rows may lie apart, as `vertices["position"]` of a structured array does.
        """
        kind = to_enum(structs.Values, values, "values")
        rows = self._triangle_count if kind == structs.Values.STRAINS else self._vertex_count
        if out is None:
            out = np.empty((rows, 3), dtype)
        if not isinstance(out, np.ndarray) or out.shape != (rows, 3):
            raise InvalidArgumentError(f"out should be an array of shape ({rows}, 3), not {getattr(out, 'shape', type(out))}")
        if out.dtype not in _TARGET_TYPES:
            raise InvalidArgumentError(f"out should hold float64 or float32, not {out.dtype}")
        if not out.flags.writeable:
            raise InvalidArgumentError("out is read only")
        if out.strides[1] != out.itemsize or out.strides[0] < 3 * out.itemsize:
            raise InvalidArgumentError("out should have the three numbers of a row side by side, and rows in ascending order")
        self._copy_values(kind, out)
        return out

    def get_contacts(self) -> NDArray[Any]:
        """The contacts of the last step that it has part in: an array of CONTACT records."""
        count = ffi.new("size_t *")
        self.world._call(core.tulle_object_copy_contacts, self._object_id(), ffi.NULL, 0, count)
        array = np.empty(count[0], structs.CONTACT)
        if array.size:
            self.world._call(core.tulle_object_copy_contacts, self._object_id(), point_to(array, "tulle_contact *"),
                             array.size, count)
        return array


class Cloth(Object):
    """A cloth of a world."""

    _kind = int(structs.ObjectKind.CLOTH)

    @property
    def strains(self) -> StateArray:
        """(triangles, 3) of woven cloth: strain of the warp, of the weft, and the shear."""
        array = self._arrays.get("strains")
        return array if array is not None and array._made == self.world._clock.now else self._read("strains")

    @property
    def fineness(self) -> structs.Fineness:
        """How fine the mesh is beside the folds that the fabric makes."""
        return structs.Fineness(ffi.new("tulle_fineness *", self._ask(core.tulle_cloth_get_fineness)))

    def set_material(self, material: Union[structs.Material, str, dict[str, Any]]) -> None:
        """Changes what it is made of from the next step on: a Material, a preset's name, or changes of cotton."""
        from tulle.world import make_material
        keep: list[Any] = []
        made = make_material(material) if isinstance(material, str) else structs.Material.make(material, {}, "material")
        self.world._call(core.tulle_cloth_set_material, self._id[0], made.to_c(keep))

    def set_thickness(self, thickness: float) -> None:
        """Changes the distance `thickness` [m] at which its contact acts, from the next step on."""
        self.world._call(core.tulle_cloth_set_thickness, self._id[0], thickness)

    def set_pin_targets(self, pin: int, positions: ArrayLike) -> None:
        """Tells where the vertices of a pin are at the end of the next step. positions: (vertices, 3) [m]."""
        rows = to_doubles(positions, 3, "positions")
        self.world._call(core.tulle_cloth_set_pin_targets, self._id[0], pin, point_to(rows, "double *"), rows.shape[0])

    def set_targets(self, positions: ArrayLike, departures: Optional[ArrayLike] = None, is_led: Optional[ArrayLike] = None) -> None:
        """Draws it to positions [m] in the next step, from which its vertices may differ by departures [m]: (vertices, 3) each.

        It bends by what it differs from the positions by, and neighbours depart together. Vertices of `is_led`, a flag for
        each, go straight to their positions. All cloth of the world needs `has_flat_rest`. Experimental: it may change.
        """
        rows = to_doubles(positions, 3, "positions")
        away = None if departures is None else to_doubles(departures, 3, "departures", rows.shape[0])
        led = None if is_led is None else np.ascontiguousarray(is_led, dtype=bool).view(np.uint8)
        if led is not None and led.shape != rows.shape[:1]:
            raise InvalidArgumentError(f"is_led should have {rows.shape[0]} flags, not the shape {led.shape}")
        made = ffi.new("tulle_cloth_targets *", {
            "positions": point_to(rows, "double *"), "vertex_count": rows.shape[0],
            "departures": ffi.NULL if away is None else point_to(away, "double *"),
            "is_led": ffi.NULL if led is None else point_to(led, "unsigned char *")})
        self.world._call(core.tulle_cloth_set_targets, self._id[0], made)

    def release_pin(self, pin: int) -> None:
        """Lets go of a pin for good."""
        self.world._call(core.tulle_cloth_release_pin, self._id[0], pin)

    @property
    def is_asleep(self) -> bool:
        """Whether it sleeps (`sleep_speed` of the world)."""
        return bool(self._ask(core.tulle_cloth_is_asleep))

    def wake(self) -> None:
        """Wakes it."""
        self.world._call(core.tulle_cloth_wake, self._id[0])

    def find_patches(self, **options: Any) -> tuple[Indices, int]:
        """A label for each triangle, 1 .. the number of patches, or 0, and that number. `options`: fields of PatchOptions."""
        keep: list[Any] = []
        labels, count = np.empty(self.triangles.shape[0], np.uint32), ffi.new("size_t *")
        made = structs.PatchOptions.make(None, options, "find_patches").to_c(keep)
        self.world._call(core.tulle_cloth_get_patches, self._id[0], made, point_to(labels, "uint32_t *"), count)
        return labels, int(count[0])


class Obstacle(Object):
    """An obstacle of a world: static, on a script, deforming, or driven step by step."""

    _kind = int(structs.ObjectKind.OBSTACLE)

    @property
    def is_present(self) -> bool:
        """Whether it is in the scene at this time."""
        return bool(self._ask(core.tulle_obstacle_is_present))

    @property
    def is_static(self) -> bool:
        """Whether it never moves: no motion, no frames, no drive, not a rigid body."""
        return bool(self._get_info().is_static)

    def set_next_transform(self, translation: ArrayLike = (0, 0, 0), rotation: ArrayLike = (1, 0, 0, 0),
                           travel: Union[structs.Travel, str] = structs.Travel.MOVE) -> None:
        """Tells where one with `drive="rigid"` is at the end of the next step.

        Vertex x of its mesh is then at translation [m] + R (x - pivot) + pivot, where R is `rotation`, a unit quaternion w,
        x, y, z.
        """
        rows = to_vector(translation, "translation"), to_vector(rotation, "rotation", 4)
        self.world._call(core.tulle_obstacle_set_next_transform, self._id[0], *(point_to(row, "double *") for row in rows),
                         int(to_enum(structs.Travel, travel, "travel")))

    def set_next_positions(self, positions: ArrayLike, travel: Union[structs.Travel, str] = structs.Travel.MOVE) -> None:
        """Tells where the vertices of one with `drive="deforming"` are at the end of the next step.

        positions: (vertices, 3) [m].
        """
        rows = to_doubles(positions, 3, "positions")
        self.world._call(core.tulle_obstacle_set_next_positions, self._id[0], point_to(rows, "double *"), rows.shape[0],
                         int(to_enum(structs.Travel, travel, "travel")))

    @property
    def contact_impulse(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """[N s] and [N m s]: what contact gave it in the last substep, and the moment of that."""
        return self._get_two(core.tulle_obstacle_get_contact_impulse)

    def _get_two(self, function: Any) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        first, second = np.empty(3), np.empty(3)
        self.world._call(function, self._id[0], point_to(first, "double *"), point_to(second, "double *"))
        return first, second


class Body(Obstacle):
    """A rigid body of a world."""

    @property
    def transform(self) -> structs.Transform:
        """Where it is, how fast, its mass and inertia; once the world has started."""
        made = ffi.new("tulle_transform *")
        self.world._call(core.tulle_obstacle_get_transform, self._id[0], made)
        return structs.Transform(made)

    def add_impulse(self, impulse: ArrayLike, point: ArrayLike) -> None:
        """Changes its velocities at once by `impulse` [N s] at `point` [m] of the world."""
        rows = to_vector(point, "point"), to_vector(impulse, "impulse")
        self.world._call(core.tulle_obstacle_add_impulse, self._id[0], *(point_to(row, "double *") for row in rows))

    def add_force(self, force: ArrayLike, point: Optional[ArrayLike] = None) -> None:
        """Adds `force` [N] at `point` [m] of the world, or at the centre of mass, through the next step."""
        place = None if point is None else to_vector(point, "point")
        row = to_vector(force, "force")
        self.world._call(core.tulle_obstacle_add_force, self._id[0], ffi.NULL if place is None else point_to(place, "double *"),
                         point_to(row, "double *"))

    def add_torque(self, torque: ArrayLike) -> None:
        """Adds `torque` [N m] through the next step."""
        self.world._call(core.tulle_obstacle_add_torque, self._id[0], point_to(to_vector(torque, "torque"), "double *"))

    def set_velocity(self, velocity: Optional[ArrayLike] = None, angular_velocity: Optional[ArrayLike] = None) -> None:
        """Sets `velocity` [m/s] and `angular_velocity` [rad/s] at once; what is left out stays."""
        rows = [None if row is None else to_vector(row, "velocity") for row in (velocity, angular_velocity)]
        self.world._call(core.tulle_obstacle_set_velocity, self._id[0],
                         *(ffi.NULL if row is None else point_to(row, "double *") for row in rows))

    def set_locks(self, translations: Union[structs.Lock, int] = 0, rotations: Union[structs.Lock, int] = 0) -> None:
        """Locks it along axes of the world, and about them: sums of Lock.X, Lock.Y, Lock.Z."""
        self.world._call(core.tulle_obstacle_set_locks, self._id[0], int(translations), int(rotations))

    def set_drive(self, drive: Optional[structs.BodyDrive] = None, **changes: Any) -> None:
        """Gives it a drive, in place of the one that it has. `changes`: fields of BodyDrive by name; neither: no drive."""
        keep: list[Any] = []
        made = ffi.NULL
        if drive is not None or changes:
            made = structs.BodyDrive.make(drive, changes, "set_drive").to_c(keep)
        self.world._call(core.tulle_obstacle_set_drive, self._id[0], made)

    @property
    def drive_force(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """[N] and [N m]: what its drive gave in the last substep, as a mean."""
        return self._get_two(core.tulle_obstacle_get_drive_force)

    @property
    def is_asleep(self) -> bool:
        """Whether it sleeps."""
        return bool(self._ask(core.tulle_obstacle_is_asleep))

    def wake(self) -> None:
        """Wakes it and those that fell asleep with it."""
        self.world._call(core.tulle_obstacle_wake, self._id[0])


class Attachment:
    """Vertices of a cloth that are held at something."""

    def __init__(self, world: World, identity: int, cloth: Cloth) -> None:
        self.world, self._identity, self.cloth = world, identity, cloth

    @property
    def id(self) -> int:
        """The number by which events name it."""
        return self._identity

    @property
    def report(self) -> structs.AttachmentReport:
        """How it stands: what it holds, and its forces."""
        return structs.AttachmentReport(ffi.new("tulle_attachment_report *", self.world._get(
            core.tulle_attachment_get_report, self._identity)))

    def holds(self, vertex: int) -> bool:
        """Whether it holds this vertex of its cloth."""
        return bool(self.world._get(core.tulle_attachment_holds, self._identity, vertex))

    def set_points(self, points: ArrayLike) -> None:
        """Moves the points of an attachment to points: (vertices, 3) [m], reached during the next step."""
        rows = to_doubles(points, 3, "points")
        self.world._call(core.tulle_attachment_set_points, self._identity, point_to(rows, "double *"), rows.shape[0])

    def release(self) -> None:
        """Lets go."""
        self.world._call(core.tulle_attachment_release, self._identity)
