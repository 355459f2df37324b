"""Meshes of Blender as arrays, and arrays as OBJ and PC2 files.

Positions of a scene for Tulle are in world space and in metres; a unit of Blender has `scene.unit_settings.scale_length`
metres.
"""
import os
import struct
from dataclasses import dataclass
from typing import Optional

import numpy as np

from .files import Refusal, replacing

SLIVER = 1e-5  # height over longest side of a triangle whose corners lie on a line but for rounding
ROUNDING_TOLD = 1e-6  # [m] what floats may move a vertex by without a word: half a step at 16 m

PC2_HEAD = struct.Struct("<12siiffi")


@dataclass
class Triangles:
    """How the vertices of a mesh are joined. `polygons` has the polygon of each triangle, `uvs` the texture coordinates of
    its corners."""

    vertex_count: int
    corners: np.ndarray
    polygons: np.ndarray
    uvs: Optional[np.ndarray]
    loose_edges: int

    def find_used(self) -> np.ndarray:
        """Vertices that belong to a triangle, ascending."""
        is_used = np.zeros(self.vertex_count, bool)
        is_used[self.corners.ravel()] = True
        return np.flatnonzero(is_used)


def get_scale(scene) -> float:
    """[m] of a unit of Blender."""
    return float(scene.unit_settings.scale_length)


def get_matrix(matrix) -> np.ndarray:
    return np.array([list(row) for row in matrix], np.float64)


def is_mirrored(matrix: np.ndarray) -> bool:
    return bool(np.linalg.det(matrix[:3, :3]) < 0)


def to_world(local: np.ndarray, matrix: np.ndarray, scale: float) -> np.ndarray:
    return (local.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]) * scale


def to_local(world: np.ndarray, matrix: np.ndarray, scale: float) -> np.ndarray:
    """The way back. A matrix that flattens has none: it is refused where matrices are collected."""
    if np.array_equal(matrix, np.eye(4)) and scale == 1.0:
        return world
    return np.linalg.solve(matrix[:3, :3], (world.astype(np.float64) / scale - matrix[:3, 3]).T).T


def measure_rounding(places: np.ndarray, matrix: np.ndarray = np.eye(4), scale: float = 1.0) -> float:
    """[m] how far floats move a vertex at most."""
    moved = (places.astype(np.float32) - places) @ np.asarray(matrix)[:3, :3].T * scale
    return float(np.linalg.norm(moved, axis=1).max(initial=0.0))


def tell_rounding(name: str, local: np.ndarray, matrix: np.ndarray, scale: float, what: str = "cache") -> str:
    """What is to be told where a cache of floats in the object's own space moves vertices by more than ROUNDING_TOLD; else
    nothing. Far from its origin floats are coarse, also where they are fine in the world."""
    largest = measure_rounding(local, matrix, scale)
    if largest <= ROUNDING_TOLD:
        return ""
    return (
        "'%s': floats of its %s move vertices by %.2g m, since these are far from the object's origin; layers that are nearer than "
        "that may pass through each other. Object > Set Origin > Origin to Geometry helps" % (name, what, largest)
    )


def read_positions(mesh) -> np.ndarray:
    positions = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", positions)
    return positions.reshape(-1, 3)


def read_triangles(mesh, wants_uvs: bool = False) -> Triangles:
    """Triangles over the vertices as they are numbered. Polygons of any number of corners are cut as Blender shows them; where that
    leaves a triangle without area, diagonals are exchanged."""
    mesh.calc_loop_triangles()
    count = len(mesh.loop_triangles)
    loops = np.empty(3 * count, np.int32)
    polygons = np.empty(count, np.int32)
    mesh.loop_triangles.foreach_get("loops", loops)
    mesh.loop_triangles.foreach_get("polygon_index", polygons)
    vertices = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", vertices)
    loops = exchange_diagonals(read_positions(mesh), vertices, loops.reshape(-1, 3), polygons)
    corners = vertices[loops]
    uvs = None
    if wants_uvs and mesh.uv_layers.active is not None:
        layer, places = mesh.uv_layers.active, np.empty(2 * len(mesh.loops), np.float32)
        if hasattr(layer, "uv"):  # from Blender 3.5 on
            layer.uv.foreach_get("vector", places)
        else:
            layer.data.foreach_get("uv", places)
        uvs = places.reshape(-1, 2)[loops]
    loop_edges = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("edge_index", loop_edges)
    loose_edges = len(mesh.edges) - len(np.unique(loop_edges))
    return Triangles(len(mesh.vertices), corners, polygons, uvs, loose_edges)


def exchange_diagonals(positions: np.ndarray, vertices: np.ndarray, loops: np.ndarray, polygons: np.ndarray) -> np.ndarray:
    """Triangles of corners such that none is a sliver that another cut of its polygon would not have. `vertices` has the vertex
    of each corner, `loops` the corners of each triangle, `polygons` the polygon of each triangle."""
    loops, places = loops.copy(), positions.astype(np.float64)
    thin = measure_heights(places, vertices[loops]) < SLIVER
    for polygon in np.unique(polygons[thin]):
        rows = np.flatnonzero(polygons == polygon)
        # Each exchange makes the smaller height of a pair larger, so there is an end to it.
        for _ in range(len(rows) ** 2):
            if not any(exchange_diagonal(places, vertices, loops, rows, row) for row in rows):
                break
    return loops


def exchange_diagonal(places: np.ndarray, vertices: np.ndarray, loops: np.ndarray, rows: np.ndarray, row: int) -> bool:
    """Replaces the longest side of a sliver by the other diagonal of the two triangles that share it."""
    def measure(*triangles):
        return measure_heights(places, vertices[np.array(triangles)]).min()

    if measure(loops[row]) >= SLIVER:
        return False
    ends = places[vertices[loops[row]]]
    side = int(np.argmax(((np.roll(ends, -1, axis=0) - ends) ** 2).sum(1)))
    a, b, c = np.roll(loops[row], -side)
    for other in rows:
        for k in range(3):
            if loops[other][k] != b or loops[other][(k + 1) % 3] != a:
                continue
            d = loops[other][(k + 2) % 3]
            if measure((a, d, c), (d, b, c)) <= measure(loops[row], loops[other]):
                return False
            loops[row], loops[other] = (a, d, c), (d, b, c)
            return True
    return False


def measure_heights(places: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Of each triangle the height over its longest edge, as a share of that edge; 0: it has no area."""
    a, b, c = (places[corners[:, k]].astype(np.float64) for k in range(3))
    longest2 = np.max([((b - a) ** 2).sum(1), ((c - b) ** 2).sum(1), ((a - c) ** 2).sum(1)], axis=0)
    doubled_area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return np.divide(doubled_area, longest2, out=np.zeros(len(corners)), where=longest2 > 0)


def read_integers(mesh, name: str, count: int) -> Optional[np.ndarray]:
    attribute = mesh.attributes.get(name)
    if attribute is None or len(attribute.data) != count:
        return None
    values = np.empty(count, np.int32)
    attribute.data.foreach_get("value", values)
    return values


def read_group(mesh, index: int) -> np.ndarray:
    """Vertices with a weight of at least 0.5 in a vertex group, ascending."""
    chosen = [v.index for v in mesh.vertices if any(g.group == index and g.weight >= 0.5 for g in v.groups)]
    return np.array(chosen, np.int64)


def read_weights(mesh, index: int) -> np.ndarray:
    """The weight of each vertex in a vertex group; 0 for those outside."""
    weights = np.zeros(len(mesh.vertices))
    for vertex in mesh.vertices:
        for each in vertex.groups:
            if each.group == index:
                weights[vertex.index] = each.weight
    return weights


def write_obj(path: str, positions: np.ndarray, corners: np.ndarray, uvs: Optional[np.ndarray] = None) -> None:
    """Doubles with as many digits as give them again; faces of a mirrored object are turned round by who calls."""
    with replacing(path, encoding="ascii") as file:
        file.writelines("v %r %r %r\n" % (x, y, z) for x, y, z in positions.astype(np.float64).tolist())
        if uvs is None:
            file.writelines("f %d %d %d\n" % (a, b, c) for a, b, c in (corners + 1).tolist())
            return
        file.writelines("vt %r %r\n" % (u, v) for u, v in uvs.reshape(-1, 2).astype(np.float64).tolist())
        for number, (a, b, c) in enumerate((corners + 1).tolist()):
            file.write("f %d/%d %d/%d %d/%d\n" % (a, 3 * number + 1, b, 3 * number + 2, c, 3 * number + 3))


def read_obj_faces(path: str) -> np.ndarray:
    """Triangles of an OBJ file that Tulle wrote."""
    faces = []
    with open(path, encoding="ascii") as file:
        for line in file:
            if line.startswith("f "):
                faces.append([int(word.split("/")[0]) - 1 for word in line.split()[1:4]])
    return np.array(faces, np.int64).reshape(-1, 3)


class Pc2Writer:
    """A point cache that grows. It replaces an older one with its first frame. A frame is written before the head counts it,
    so the file is whole up to its count at any moment."""

    def __init__(self, path: str, vertex_count: int):
        self.path, self.vertex_count, self.frame_count = path, vertex_count, 0

    def _make_head(self) -> bytes:
        return PC2_HEAD.pack(b"POINTCACHE2\0", 1, self.vertex_count, 0.0, 1.0, self.frame_count)

    def append(self, positions: np.ndarray) -> None:
        data = np.ascontiguousarray(positions, "<f4").tobytes()
        if len(data) != 12 * self.vertex_count:
            raise ValueError("a frame of another number of vertices")
        if self.frame_count == 0:
            self._begin(data)
            return
        with open(self.path, "r+b") as file:
            file.seek(PC2_HEAD.size + self.frame_count * len(data))
            file.write(data)
            file.flush()
            self.frame_count += 1
            file.seek(0)
            try:
                file.write(self._make_head())
                file.flush()
            except OSError:
                self.frame_count -= 1
                raise

    def _begin(self, data: bytes) -> None:
        self.frame_count = 1
        try:
            with replacing(self.path, "b") as file:
                file.write(self._make_head() + data)
        except OSError:
            self.frame_count = 0
            raise


class Pc2Reader:
    """Frames of a point cache, also of one that another process writes."""

    def __init__(self, path: str):
        self.path = path
        with open(path, "rb") as file:
            head = file.read(PC2_HEAD.size)
        if len(head) < PC2_HEAD.size or head[:12] != b"POINTCACHE2\0":
            raise Refusal("%s is no point cache" % os.path.basename(path))
        self.vertex_count = PC2_HEAD.unpack(head)[2]

    def count_frames(self) -> int:
        with open(self.path, "rb") as file:
            counted = PC2_HEAD.unpack(file.read(PC2_HEAD.size))[5]
            held = (os.fstat(file.fileno()).st_size - PC2_HEAD.size) // max(1, 12 * self.vertex_count)
        return max(0, min(counted, held))

    def read(self, frame: int) -> np.ndarray:
        size = 12 * self.vertex_count
        with open(self.path, "rb") as file:
            file.seek(PC2_HEAD.size + frame * size)
            data = file.read(size)
        if len(data) < size:
            raise Refusal("%s ends within frame %d" % (os.path.basename(self.path), frame))
        return np.frombuffer(data, "<f4").reshape(-1, 3)
