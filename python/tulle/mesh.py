"""Triangle meshes: read, written, generated, measured, moved, smoothed."""
from __future__ import annotations

import os
import warnings
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt
from numpy.typing import ArrayLike

from tulle import structs
from tulle._arrays import Doubles, Indices, copy_from, point_to, to_doubles, to_indices, to_vector
from tulle._library import core, ffi, io
from tulle._structs import to_enum
from tulle.errors import InvalidArgumentError, InvalidMeshError, check, make_error_buffer

PathLike = Union[str, "os.PathLike[str]"]


def encode_path(path: PathLike) -> bytes:
    """A path for the library."""
    data = os.fsencode(path)
    if b"\0" in data:
        raise InvalidArgumentError(f"the path {path!r} holds a zero byte")
    return data


class Mesh:
    """A triangle mesh."""

    positions: Doubles
    """[m] (vertices, 3)."""
    triangles: Indices
    """(triangles, 3) vertex numbers, counterclockwise seen from outside."""

    def __init__(self, positions: ArrayLike, triangles: ArrayLike) -> None:
        """Takes arrays of any numbers; those that have the right type and no gaps are not copied."""
        self.positions = to_doubles(positions, 3, "positions")
        self.triangles = to_indices(triangles, 3, "triangles")

    @classmethod
    def read(cls, path: PathLike) -> Mesh:
        """Reads an OBJ, PLY or STL file, or a VTK file (.vtp). Polygons become triangles that lie within them.

        Warns of polygons that cross themselves or are not flat, and of what was passed over that may say something about the
        shape. Raises FileError, ParseError with line and column, LimitError.
        """
        mesh, error = ffi.new("tulle_mesh *"), make_error_buffer()
        if os.fspath(path).lower().endswith(".vtp"):
            passed = ffi.new("tulle_vtp_passed_over *")
            check(io.tulle_vtp_read(encode_path(path), mesh, passed, error), error)
            note = ffi.string(passed.polygons)
        else:
            source = ffi.new("tulle_mesh_source *")
            check(io.tulle_mesh_read_source(encode_path(path), mesh, source, error), error)
            note = ffi.string(source.note) if source.has_passed_shape else b""
            io.tulle_mesh_source_destroy(source)
        if note:
            warnings.warn(f"{os.fspath(path)!r}: {note.decode(errors='replace')}", stacklevel=2)
        return _take(mesh)

    def write(self, path: PathLike) -> None:
        """Writes the mesh as OBJ, PLY, STL or VTP, by the extension of `path`: whole or not at all.

        Raises FileError, DiskFullError, InvalidMeshError, UnsupportedError for another extension.
        """
        view, error = self._view(), make_error_buffer()
        if os.fspath(path).lower().endswith(".vtp"):
            check(io.tulle_vtp_write(encode_path(path), view, ffi.NULL, error), error)
        else:
            check(io.tulle_mesh_write(encode_path(path), view, error), error)

    @property
    def vertex_count(self) -> int:
        """Number of vertices."""
        return int(self.positions.shape[0])

    @property
    def triangle_count(self) -> int:
        """Number of triangles."""
        return int(self.triangles.shape[0])

    def validate(self, role: Union[structs.MeshRole, str] = structs.MeshRole.CLOTH) -> None:
        """Refuses a mesh that cannot be simulated as "cloth" or as "obstacle".

        Raises InvalidMeshError, which names the first offender and how many there are.
        """
        error = make_error_buffer()
        check(core.tulle_mesh_validate(self._view(), int(to_enum(structs.MeshRole, role, "role")), error), error)

    def find_degenerate(self) -> npt.NDArray[np.bool_]:
        """(triangles,) which triangles have no area, are needle-thin or use a vertex twice: an obstacle goes without them.

        Raises InvalidMeshError where an index is out of range.
        """
        marks, error = np.zeros(self.triangle_count, np.uint8), make_error_buffer()
        view = self._view()
        check(core.tulle_mesh_find_degenerate(view, point_to(marks, "uint8_t *"), ffi.NULL, error), error)
        return marks.astype(bool)

    def get_info(self) -> structs.MeshInfo:
        """Counts and quality of the mesh. Raises InvalidMeshError where an index is out of range."""
        info, error = ffi.new("tulle_mesh_info *"), make_error_buffer()
        check(core.tulle_mesh_get_info(self._view(), info, error), error)
        return structs.MeshInfo(info)

    def repair(self, tolerance: float = 0.0) -> tuple[Mesh, dict[str, tuple[int, Doubles]]]:
        """A mesh that can be cloth, and what was done: by kind, how often and where first [m].

        Triangles without area ("degenerate") and "duplicate" ones are dropped, boundary vertices in the same place "joined",
        boundary edges split at a "t_junction"; at an "edge" with three triangles or more two stay joined, other fans of triangles
        are "cut" off and moved inwards by a hundredth of an edge; triangles are "turned" alike, "loose" vertices left out.
        tolerance: [m] how far apart boundaries may be that meet. A surface with one side stays one, and what is moved may come to
        intersect: ask `validate` and `find_intersections`. Raises InvalidMeshError for an index out of range and a place that is
        not finite, InvalidArgumentError for the tolerance.
        """
        if not self.triangle_count:
            raise InvalidMeshError("the mesh has no triangles to repair")
        mesh, repairs, error = ffi.new("tulle_mesh *"), ffi.new("tulle_mesh_repairs *"), make_error_buffer()
        check(core.tulle_mesh_create(self.vertex_count, self.triangle_count, mesh, error), error)
        view = self._view()
        ffi.memmove(mesh.positions, view.positions, self.positions.nbytes)
        ffi.memmove(mesh.triangles, view.triangles, self.triangles.nbytes)
        status = core.tulle_mesh_repair(mesh, float(tolerance), repairs, error)
        made = _take(mesh)
        check(status, error)
        places = np.array(list(repairs.places)).reshape(-1, 3)
        kinds = ("degenerate", "duplicate", "joined", "t_junction", "edge", "cut", "turned", "loose")
        return made, {kind: (int(repairs.counts[i]), places[i]) for i, kind in enumerate(kinds) if repairs.counts[i]}

    def transform(self, scale: Union[float, ArrayLike] = 1.0, rotation: ArrayLike = (1, 0, 0, 0),
                  translation: ArrayLike = (0, 0, 0)) -> Mesh:
        """A mesh of which every vertex x is at translation + R (scale * x).

        scale: one factor, or one for each axis, not 0. rotation: R as a unit quaternion w, x, y, z. translation: [m].
        Where the product of the factors is negative the mesh is mirrored, and what faced outwards still does.
        """
        factors = np.broadcast_to(np.asarray(scale, dtype=np.float64), (3,)) if np.ndim(scale) == 0 else scale
        moved = Mesh(self.positions.copy(), self.triangles.copy())
        mesh = ffi.new("tulle_mesh *", {"positions": point_to(moved.positions, "double *"),
                                        "vertex_count": moved.vertex_count,
                                        "triangles": point_to(moved.triangles, "uint32_t *"),
                                        "triangle_count": moved.triangle_count})
        rows = [to_vector(factors, "scale"), to_vector(rotation, "rotation", 4), to_vector(translation, "translation")]
        if not rows[0].all() or not np.isfinite(np.concatenate(rows)).all():
            raise InvalidArgumentError("scale, rotation and translation should be finite, and no factor of scale 0")
        if abs(float(np.dot(rows[1], rows[1])) - 1) > 1e-6:
            raise InvalidArgumentError("rotation should be a unit quaternion w, x, y, z")
        core.tulle_mesh_transform(mesh, *(point_to(row, "double *") for row in rows))
        return moved

    def subdivide(self, levels: int = 2, **changes: Any) -> Mesh:
        """A smoother mesh by Loop's scheme, with 4^levels triangles for each. `changes`: fields of SubdivisionDef."""
        keep: list[Any] = []
        definition = structs.SubdivisionDef.make(None, {"levels": levels, **changes}, "subdivide").to_c(keep)
        made, error = ffi.new("tulle_subdivision **"), make_error_buffer()
        check(io.tulle_subdivision_create(self._view(), definition, made, error), error)
        mesh = ffi.new("tulle_mesh *")
        try:
            check(io.tulle_subdivision_make_mesh(made[0], point_to(self.positions, "double *"), mesh, error), error)
        finally:
            io.tulle_subdivision_destroy(made[0])
        return _take(mesh)

    def _view(self) -> Any:
        """The mesh for a call; it must outlive the call."""
        # Arrays may have been put in place, or changed in shape, since.
        self.positions = to_doubles(self.positions, 3, "positions")
        self.triangles = to_indices(self.triangles, 3, "triangles")
        return ffi.new("tulle_mesh_view *", {
            "positions": point_to(self.positions, "double *"), "vertex_count": self.vertex_count,
            "triangles": point_to(self.triangles, "uint32_t *"), "triangle_count": self.triangle_count})[0]

    def __repr__(self) -> str:
        return f"Mesh({self.vertex_count} vertices, {self.triangle_count} triangles)"

    def _repr_html_(self) -> str:
        """For notebooks: `tulle.show`."""
        from tulle.notebook import represent
        return represent(self)


def view_mesh(mesh: Mesh, what: str = "mesh") -> Any:
    """A mesh that a caller gives, for a call of the library; it must outlive the call."""
    if not isinstance(mesh, Mesh):
        hint = ": its `mesh` is one" if hasattr(mesh, "mesh") else ""
        raise TypeError(f"{what} should be a Mesh, not a {type(mesh).__name__}{hint}")
    return mesh._view()


def leave_out(mesh: Mesh, deforms: bool) -> Mesh:
    """What an obstacle is made of: without triangles that it has twice, or that have no area. One that deforms keeps those
    that have three different vertices. Says so by a warning."""
    corners = np.sort(mesh.triangles, axis=1)
    is_line = (corners[:, 0] == corners[:, 1]) | (corners[:, 1] == corners[:, 2])
    is_flat = is_line if deforms else mesh.find_degenerate()
    is_again = np.ones(len(corners), bool)
    is_again[np.unique(corners, axis=0, return_index=True)[1]] = False
    if is_flat.all() or not (is_flat | is_again).any():
        return mesh
    for marks, words in ((is_flat, "has no area"), (is_again & ~is_flat, "has the same corners as another one")):
        count = int(marks.sum())
        if count:
            more = f", and {count - 1} more" if count > 1 else ""
            warnings.warn(f"obstacle: triangle {int(marks.argmax())} {words} and is left out{more}", stacklevel=3)
    return Mesh(mesh.positions, mesh.triangles[~(is_flat | is_again)])


def _take(mesh: Any) -> Mesh:
    """A mesh of the library as one of Python; releases the former."""
    try:
        return Mesh(copy_from(mesh.positions, mesh.vertex_count, np.float64, 3),
                    copy_from(mesh.triangles, mesh.triangle_count, np.uint32, 3))
    finally:
        core.tulle_mesh_destroy(mesh)


def copy_view(view: Any) -> Mesh:
    """A mesh that the library owns, copied."""
    return Mesh(copy_from(view.positions, view.vertex_count, np.float64, 3),
                copy_from(view.triangles, view.triangle_count, np.uint32, 3))


def make_shape(shape: Union[structs.Shape, str], *, size: Optional[ArrayLike] = None, radius: Optional[float] = None,
               inner_radius: Optional[float] = None, height: Optional[float] = None, tip_height: Optional[float] = None,
               head_radius: Optional[float] = None, head_height: Optional[float] = None, angle: Optional[float] = None,
               strand: Optional[float] = None, wavelength: Optional[float] = None, resolution: Optional[ArrayLike] = None,
               cells: Optional[ArrayLike] = None, strand_resolution: Optional[int] = None,
               is_irregular: bool = False, seed: Optional[int] = None) -> Mesh:
    """Generates a mesh: cloth ("rectangle", "disc", "cape" ...) or an obstacle ("sphere", "needle" ...), see Shape.

    size: [m] along x, y and z, as many as the shape has. Other lengths in metres, angle in radians. resolution: vertices
    along its sides; one number serves both. radius, inner_radius, height, tip_height, head_radius, head_height, strand,
    wavelength, cells, strand_resolution, is_irregular, seed: see docs/guide/shapes.md. What is left out has the default of
    the shape. What the shape does not have is refused. Raises InvalidArgumentError, which names the field, and LimitError
    for over 10,000,000 vertices.

    >>> sheet = make_shape("rectangle", size=(1, 1), resolution=40)
    >>> ball = make_shape("sphere", radius=0.3)
    """
    kind = to_enum(structs.Shape, shape, "shape")
    definition = ffi.new("tulle_shape_def *", core.tulle_shape_def_default(int(kind)))
    lengths = {"radius": radius, "inner_radius": inner_radius, "height": height, "tip_height": tip_height,
               "head_radius": head_radius, "head_height": head_height, "angle": angle, "strand": strand,
               "wavelength": wavelength, "strand_resolution": strand_resolution, "seed": seed, "is_irregular": bool(is_irregular)}
    for name, value in lengths.items():
        if value is not None:
            try:
                setattr(definition, name, value)
            except (TypeError, OverflowError) as failure:
                raise InvalidArgumentError(f"{name} is {value!r}: {failure}") from None
    for name, values, most in (("size", size, 3), ("resolution", resolution, 2), ("cells", cells, 2)):
        if values is None:
            continue
        row = np.atleast_1d(np.asarray(values))
        if row.ndim != 1 or not 1 <= row.size <= most or row.dtype.kind not in ("fiu" if name == "size" else "iu"):
            kinds = "numbers" if name == "size" else "whole numbers"
            raise InvalidArgumentError(f"{name} should be 1 to {most} {kinds}, not {values!r}")
        count = sum(each != 0 for each in definition.size)  # 0: the shape has none along this axis
        if name == "size" and count > 0 and row.size != count:
            raise InvalidArgumentError(f"{name} is {values!r}; {kind.name.lower()} takes {count} numbers")
        if name != "size":
            row = np.resize(row, most)
            if row.min() < 0 or row.max() > 0xFFFFFFFF:
                raise InvalidArgumentError(f"{name} is {values!r}; it should be from 0 to 4294967295")
        for i, value in enumerate(row.tolist()):
            getattr(definition, name)[i] = value
    mesh, error = ffi.new("tulle_mesh *"), make_error_buffer()
    check(core.tulle_shape_generate(definition, mesh, error), error)
    return _take(mesh)
