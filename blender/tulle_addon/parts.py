"""The objects that take part, and what their meshes hold frame by frame: places, triangles, pins, loose vertices, and whether
they keep their shape."""
import os
import re
from dataclasses import dataclass, field
from typing import Any, Dict, List, Optional, Tuple

import numpy as np

from . import meshes
from .files import MESH_FOLDER
from .meshes import Refusal

# Heights over longest edges: below the first the program takes a triangle for one without area; below the second it has none
# in a frame but
# for the rounding of floats.
NO_AREA, NO_AREA_LATER = 2e-9, 1e-5

# Positions in the space of an object, its matrix, and, at the start, its triangles.
Piece = Tuple[np.ndarray, np.ndarray, Optional[meshes.Triangles]]


def make_name(wanted: str, taken: set) -> str:
    """A name for the scene file and for files: letters, digits, - _ and . only, no device of Windows, unique also where files ignore
    case."""
    base = re.sub(r"[^A-Za-z0-9._-]", "_", wanted).strip(".") or "object"
    base = re.sub(r"(?i)^(con|prn|aux|nul|(?:com|lpt)[0-9])(?=\.|$)", r"\1_", base)
    name, number = base, 2
    while name.lower() in taken:
        name, number = "%s_%d" % (base, number), number + 1
    taken.add(name.lower())
    return name


def is_in_all(obj) -> bool:
    """Whether `All Visible Objects Are Obstacles` means an object."""
    return (
        obj.tulle.role == "NONE"
        and obj.visible_get()
        and (obj.type in ("MESH", "CURVE", "SURFACE", "FONT", "META") or obj.is_instancer)
    )


@dataclass
class Part:
    """An object that is a cloth, a rigid body or an obstacle, as it is read over the frames."""

    obj: Any
    role: str
    name: str
    matrices: List[np.ndarray] = field(default_factory=list)
    own: Optional[meshes.Triangles] = None  # of its own mesh, at the start
    counts: Tuple[int, ...] = ()  # vertices of its mesh and its instances, at the start
    corners: Optional[np.ndarray] = None  # triangles as they are written
    used: Optional[np.ndarray] = None  # vertices that are written; the others are loose
    local: Optional[np.ndarray] = None  # all vertices at the start, in the space of the object
    world: Optional[np.ndarray] = None  # [m] vertices that are written, at the start
    is_turned: bool = False  # mirrored: triangles are written the other way round
    keeps_shape: bool = True  # its local positions are those of the start in every frame so far
    pins: Optional[np.ndarray] = None  # pinned vertices as they are written
    pins_keep_shape: bool = True
    weights: Optional[np.ndarray] = None  # of all vertices in the group of stiffness
    thin: Optional[np.ndarray] = None  # triangles of an obstacle without area in every frame so far
    writer: Optional[meshes.Pc2Writer] = None
    rounding: float = 0.0  # [m] by which the floats of its frames move a vertex at most

    @property
    def is_simulated(self) -> bool:
        return self.role in ("CLOTH", "BODY")


class Reader:
    """Reads the parts of a scene; a subclass says which frames, and what is written of them."""

    def __init__(self, context, folder: str):
        self.context, self.folder = context, folder
        self.scene = context.scene
        self.scale = meshes.get_scale(self.scene)
        self.first, self.last = self.scene.frame_start, self.scene.frame_end
        self.notes: List[str] = []
        self.parts: List[Part] = []
        self.keyframe_count = 0

    def note(self, words: str) -> None:
        if words not in self.notes:
            self.notes.append(words)

    def choose_parts(self) -> None:
        """Marked objects of the view layer, in the order of their names."""
        layer = {obj.name for obj in self.context.view_layer.objects}
        taken: set = set()
        for obj in sorted(self.scene.objects, key=lambda each: each.name_full):
            role = obj.tulle.role
            if self.scene.tulle.all_obstacles and obj.name in layer and is_in_all(obj):
                role = "OBSTACLE"
            if role in ("NONE", "IGNORED"):
                continue
            if obj.name not in layer:
                self.note("'%s' is not in this view layer and is left out" % obj.name)
                continue
            if role in ("CLOTH", "BODY") and obj.type != "MESH":
                raise Refusal("'%s' is no mesh: only a mesh can be a cloth or a rigid body" % obj.name, [obj.name])
            if role in ("CLOTH", "BODY") and obj.library is not None:
                raise Refusal("'%s' is linked from another file: make a library override of it first" % obj.name, [obj.name])
            self.parts.append(Part(obj, role, make_name(obj.name, taken)))
        if not any(part.is_simulated for part in self.parts):
            raise Refusal("Nothing is marked: choose Cloth as the role of what is to be simulated")
        if self.last <= self.first:
            raise Refusal("The frame range has a single frame: set the end of the scene behind its start")

    def read_frame(self, number: int) -> None:
        graph = self.context.evaluated_depsgraph_get()
        instances = self.gather_instances(graph, number)
        for part in self.parts:
            evaluated = part.obj.evaluated_get(graph)
            part.matrices.append(meshes.get_matrix(evaluated.matrix_world))
            pieces = self.read_pieces(part, evaluated, instances.get(part.obj.name, []), number)
            if number == 0:
                self.begin_part(part, pieces)
            else:
                self.follow_part(part, pieces)

    def gather_instances(self, graph, number: int) -> Dict[str, List[Piece]]:
        """Local positions, matrix and triangles of each instance that an obstacle makes, by the name of that obstacle."""
        wanted = {part.obj.name: part for part in self.parts}
        found: Dict[str, List[Piece]] = {}
        for instance in graph.object_instances:
            if not instance.is_instance or instance.parent is None or instance.parent.original.name not in wanted:
                continue
            source = instance.object
            if source.original.tulle.role == "IGNORED" or source.type not in ("MESH", "CURVE", "SURFACE", "FONT", "META"):
                continue
            name = instance.parent.original.name
            if wanted[name].role != "OBSTACLE":
                raise Refusal(
                    "'%s' makes instances: a cloth or a rigid body must be one mesh (Realize Instances)" % name, [name]
                )
            mesh = source.data if source.type == "MESH" else source.to_mesh()
            if mesh is not None and len(mesh.polygons) > 0:
                triangles = meshes.read_triangles(mesh) if number == 0 else None
                found.setdefault(name, []).append(
                    (meshes.read_positions(mesh), meshes.get_matrix(instance.matrix_world), triangles)
                )
            if source.type != "MESH":
                source.to_mesh_clear()
        return found

    def read_pieces(self, part: Part, evaluated, instances: List[Piece], number: int) -> List[Piece]:
        """The part's own mesh, if it has one, and then its instances."""
        pieces: List[Piece] = []
        mesh = evaluated.to_mesh() if evaluated.type in ("MESH", "CURVE", "SURFACE", "FONT", "META") else None
        if mesh is not None:
            if len(mesh.polygons) > 0:
                triangles = meshes.read_triangles(mesh, part.obj.tulle.rest == "UV") if number == 0 else None
                pieces.append((meshes.read_positions(mesh), part.matrices[-1], triangles))
                if number == 0:
                    part.own = triangles
                    if part.role == "CLOTH":
                        part.pins = self.find_group(part, mesh, part.obj.tulle.pin_group, "pins")
                        part.weights = self.read_stiffness(part, mesh)
            evaluated.to_mesh_clear()
        pieces += instances
        if not pieces:
            raise Refusal(
                "'%s' has no faces%s" % (part.obj.name, "" if number == 0 else " in frame %d" % (self.first + number)),
                [part.obj.name],
            )
        for positions, matrix, _ in pieces:
            if not np.isfinite(positions).all() or not np.isfinite(matrix).all():
                raise Refusal(
                    "'%s' has a vertex whose place is no number, in frame %d" % (part.obj.name, self.first + number),
                    [part.obj.name],
                )
        return pieces

    def find_group(self, part: Part, mesh, group: str, what: str) -> Optional[np.ndarray]:
        if not group:
            return None
        name = part.obj.name
        if group not in part.obj.vertex_groups:
            raise Refusal("'%s' has no vertex group '%s', which its %s name" % (name, group, what), [name])
        found = meshes.read_group(mesh, part.obj.vertex_groups[group].index)
        if len(found) == 0:
            raise Refusal(
                "No vertex of '%s' has a weight of 0.5 or more in '%s', the group of its %s" % (name, group, what), [name]
            )
        return found

    def read_stiffness(self, part: Part, mesh) -> Optional[np.ndarray]:
        group, name = part.obj.tulle.stiffness_group, part.obj.name
        if not group:
            return None
        if group not in part.obj.vertex_groups:
            raise Refusal("'%s' has no vertex group '%s', which its stiffness names" % (name, group), [name])
        return meshes.read_weights(mesh, part.obj.vertex_groups[group].index)

    def begin_part(self, part: Part, pieces) -> None:
        """The first frame: triangles, which vertices are loose, where they are."""
        name = part.obj.name
        part.counts = tuple(len(positions) for positions, _, _ in pieces)
        corners, offset = [], 0
        for positions, matrix, triangles in pieces:
            turned = meshes.is_mirrored(matrix)
            corners.append(offset + (triangles.corners[:, ::-1] if turned else triangles.corners))
            offset += len(positions)
        part.is_turned = meshes.is_mirrored(pieces[0][1])
        joined = np.concatenate(corners)
        is_used = np.zeros(offset, bool)
        is_used[joined.ravel()] = True
        part.used = np.flatnonzero(is_used)
        part.corners = (np.cumsum(is_used) - 1)[joined]
        loose, loose_edges = offset - len(part.used), part.own.loose_edges if part.own else 0
        if part.is_simulated and (loose > 0 or loose_edges > 0):
            self.note("'%s': %d vertices and %d edges that belong to no face are left out" % (name, loose, loose_edges))
        part.local = pieces[0][0].copy()
        part.world = self.place(part, pieces)
        if part.is_simulated:
            if abs(np.linalg.det(part.matrices[0][:3, :3])) < 1e-12:
                raise Refusal("'%s' is scaled to nothing" % name, [name])
            if part.pins is not None:
                part.pins = self.number_as_written(part, part.pins)
        else:
            part.thin = np.flatnonzero(meshes.measure_heights(part.world, part.corners) < NO_AREA)
            part.writer = meshes.Pc2Writer(self.get_path(part.name + ".pc2"), len(part.used))
            self.write_frame(part, part.world)
        if part.role == "CLOTH" and part.obj.tulle.rest == "UV" and part.own.uvs is None:
            raise Refusal("'%s' has no UV map, which is to be its shape at rest" % name, [name])

    def number_as_written(self, part: Part, chosen: np.ndarray) -> np.ndarray:
        """Numbers of vertices in the mesh file; loose ones are left out."""
        assert part.used is not None
        return np.flatnonzero(np.isin(part.used, chosen))

    def place(self, part: Part, pieces) -> np.ndarray:
        return np.concatenate([meshes.to_world(positions, matrix, self.scale) for positions, matrix, _ in pieces])[part.used]

    def follow_part(self, part: Part, pieces) -> None:
        """A later frame: whether it is the same mesh, whether it deforms, where it is."""
        counts = tuple(len(positions) for positions, _, _ in pieces)
        if counts != part.counts:
            raise Refusal(
                "'%s' has %d vertices in frame %d and %d at the start: a mesh may move, and keeps its vertices"
                % (part.obj.name, sum(counts), self.first + len(part.matrices) - 1, sum(part.counts)), [part.obj.name],
            )  # fmt: skip
        if part.is_simulated:
            if part.pins is not None and part.pins_keep_shape:
                chosen = part.used[part.pins]
                part.pins_keep_shape = bool(np.array_equal(pieces[0][0][chosen], part.local[chosen]))
            if abs(np.linalg.det(part.matrices[-1][:3, :3])) < 1e-12:
                raise Refusal(
                    "'%s' is scaled to nothing in frame %d" % (part.obj.name, self.first + len(part.matrices) - 1),
                    [part.obj.name],
                )
            return
        if part.keeps_shape:
            part.keeps_shape = len(pieces) == 1 and part.own is not None and bool(np.array_equal(pieces[0][0], part.local))
        places = self.place(part, pieces)
        self.write_frame(part, places)
        part.thin = part.thin[meshes.measure_heights(places, part.corners[part.thin]) < NO_AREA_LATER]

    def write_frame(self, part: Part, places: np.ndarray) -> None:
        part.writer.append(places)
        part.rounding = max(part.rounding, meshes.measure_rounding(places))

    def note_rounding(self, part: Part) -> None:
        """Tells of frames of floats in the world's space, where these are coarse."""
        if part.rounding > meshes.ROUNDING_TOLD:
            self.note(
                "'%s': floats of its frames move vertices by %.2g m, since these are far from the world's origin; cloth that is nearer "
                "than that may be seen on its other side. Move the scene to the origin" % (part.obj.name, part.rounding)
            )

    def get_path(self, name: str) -> str:
        return os.path.join(self.folder, MESH_FOLDER, name)
