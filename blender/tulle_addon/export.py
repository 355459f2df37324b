"""Writes the folder that the program runs.

    scene.yaml      the scene
    meshes/         where each cloth and obstacle starts, shapes at rest, frames of obstacles that deform
    blender.json    which object is which body, and the matrix of each cloth in each frame, so that results find their way back

`Export` reads the scene frame by frame: `run` is a generator that yields the share that is done, so that a window stays alive.
"""
import json
import os
from typing import Any, Dict, Iterator, List

import numpy as np

from . import meshes, motion, stack
from .files import BEFORE_FOLDER, CACHE_FOLDER, LINK_FILE, MESH_FOLDER, RUN_FOLDER, SCENE_FILE, replacing  # noqa: F401
from .meshes import Refusal
from .parts import Part, Reader

LARGEST_STEP = 1 / 90  # [s]
# A scene file holds 200,000 values; a rigid motion beyond this many keyframes in all is written as a point cache.
MOST_KEYFRAMES = 15000
USUAL_GRAVITY = 9.81  # [m/s^2]


def get_fps(scene) -> float:
    return scene.render.fps / scene.render.fps_base


def get_substeps(scene) -> int:
    """Steps in a frame: as set, or so many that one is at most 1/90 s."""
    chosen = scene.tulle.substeps
    return chosen if chosen > 0 else max(1, int(np.ceil(1 / (get_fps(scene) * LARGEST_STEP) - 1e-9)))


def make_ranges(numbers: np.ndarray) -> List[Any]:
    """Ascending whole numbers as a scene lists them: 3, 10-19."""
    ranges: List[Any] = []
    ends = np.flatnonzero(np.diff(numbers) != 1)
    for first, last in zip(np.r_[0, ends + 1], np.r_[ends, len(numbers) - 1]):
        a, b = int(numbers[first]), int(numbers[last])
        ranges.append(a if a == b else "%d-%d" % (a, b))
    return ranges


class Export(Reader):
    """What is exported, and what there is to say about it."""

    def run(self) -> Iterator[float]:
        """Reads all frames and writes all files."""
        self.choose_parts()
        simulated = [part.obj for part in self.parts if part.is_simulated]
        obstacles = [part.obj for part in self.parts if not part.is_simulated]
        os.makedirs(os.path.join(self.folder, MESH_FOLDER), exist_ok=True)
        for obj in simulated:
            for modifier in stack.list_other_in_render(obj):
                self.note(
                    "'%s': the modifier '%s' before the cache differs in a render; there the cache needs the same vertices"
                    % (obj.name, modifier)
                )
        with stack.reading(self.context, simulated, obstacles):
            for part in self.parts:
                if not part.obj.visible_get():
                    raise Refusal(
                        "'%s' is hidden by its collection: show the collection, or set the role to Ignored" % part.obj.name,
                        [part.obj.name],
                    )
            frames = range(self.first, self.last + 1)
            for number, frame in enumerate(frames):
                self.scene.frame_set(frame)
                self.read_frame(number)
                yield (number + 1) / len(frames)
            scene = self.make_scene()
        write_scene(os.path.join(self.folder, SCENE_FILE), scene)
        write_links(self)

    # What a frame holds

    # The scene

    def make_scene(self) -> Dict[str, Any]:
        scene, fps, substeps = self.scene, get_fps(self.scene), get_substeps(self.scene)
        gravity = [float(g) * self.scale for g in scene.gravity] if scene.use_gravity else [0.0, 0.0, 0.0]
        strength = float(np.linalg.norm(gravity))
        if scene.use_gravity and 0 < strength < USUAL_GRAVITY / 3 and self.scale != 1.0:
            self.note(
                "Gravity is %.3g m/s^2, since a unit of the scene is %g m; for 9.81 set it to %g in the scene's properties"
                % (strength, self.scale, -USUAL_GRAVITY / self.scale)
            )
        said: Dict[str, Any] = {
            "time": {"step": 1 / (fps * substeps), "steps_per_frame": substeps, "frames": self.last - self.first},
            "gravity": gravity,
        }
        wind = self.make_wind()
        if wind:
            said["wind"] = wind
        if scene.tulle.start != "refuse":
            said["contact"] = {"start_intersections": scene.tulle.start}
        said["cloth"] = [self.make_cloth(part) for part in self.parts if part.role == "CLOTH"]
        said["obstacles"] = [self.make_obstacle(part) for part in self.parts if part.role != "CLOTH"]
        return said

    def make_wind(self) -> Dict[str, Any]:
        """Velocity along z of each wind field; turbulence as gusts."""
        velocity, strength, length = np.zeros(3), 0.0, 0.0
        self.scene.frame_set(self.first)
        for obj in self.context.view_layer.objects:
            kind = obj.field.type if obj.field else "NONE"
            if kind == "NONE":
                continue
            if kind == "WIND":
                matrix = meshes.get_matrix(obj.matrix_world)
                velocity += obj.field.strength * matrix[:3, 2] / max(1e-12, float(np.linalg.norm(matrix[:3, 2])))
            elif kind == "TURBULENCE":
                strength = float(np.hypot(strength, obj.field.strength))
                length = max(length, obj.field.size * self.scale)
            else:
                self.note(
                    "The force field '%s' (%s) is not taken over: only wind and turbulence are" % (obj.name, kind.lower())
                )
                continue
            if obj.animation_data is not None:
                self.note("The force field '%s' is animated; it counts as it is at the start" % obj.name)
        if not velocity.any() and strength == 0.0:
            return {}
        wind: Dict[str, Any] = {"velocity": velocity.tolist(), "gust_strength": strength}
        if length > 0:
            wind["gust_length"] = length
        return wind

    def make_cloth(self, part: Part) -> Dict[str, Any]:
        settings = part.obj.tulle
        uvs = part.own.uvs
        if uvs is not None and part.is_turned:
            uvs = uvs[:, ::-1]
        meshes.write_obj(self.get_path(part.name + ".obj"), part.world, part.corners, uvs)
        cloth: Dict[str, Any] = {"name": part.name, "mesh": self.name_file(part), "material": {"preset": settings.fabric}}
        if settings.use_friction:
            # A dynamic coefficient is at most the static one; presets say "same".
            cloth["material"].update({"friction": settings.friction})
        if settings.use_thickness:
            cloth["thickness"] = settings.thickness * self.scale
        if part.weights is not None:
            cloth["stiffness_file"] = self.write_stiffness(part)
        if settings.rest == "UV":
            cloth["rest"] = {"uv": settings.uv_scale * self.scale}
        elif settings.rest == "KEY":
            cloth["rest"] = {"file": self.write_rest(part)}
        if part.pins is not None and len(part.pins) > 0:
            cloth["pins"] = [self.make_pin(part)]
        attachments = [self.make_attachment(part, each) for each in settings.attachments]
        if attachments:
            cloth["attach"] = attachments
        return cloth

    def write_stiffness(self, part: Part) -> str:
        """A factor for each vertex that is written."""
        settings = part.obj.tulle
        factors = settings.stiffness_from + (settings.stiffness_to - settings.stiffness_from) * part.weights[part.used]
        least, most = sorted((settings.stiffness_from, settings.stiffness_to))
        with replacing(self.get_path(part.name + ".stiffness.txt"), encoding="ascii") as file:
            file.writelines("%.9g\n" % factor for factor in np.clip(factors, max(least, 0.01), most))
        return "%s/%s.stiffness.txt" % (MESH_FOLDER, part.name)

    def name_file(self, part: Part, ending: str = ".obj") -> Dict[str, Any]:
        return {"file": "%s/%s%s" % (MESH_FOLDER, part.name, ending)}

    def make_pin(self, part: Part) -> Dict[str, Any]:
        pin: Dict[str, Any] = {"vertices": make_ranges(part.pins)}
        if not part.pins_keep_shape:
            self.note(
                "The pins of '%s' are deformed before the cache; they follow the object alone. "
                "To follow a character, attach them to it" % part.obj.name
            )
        if not motion.is_still(part.matrices):
            keyframes = motion.make_keyframes(part.matrices, 1 / get_fps(self.scene), self.scale)
            if keyframes is None:
                raise Refusal(
                    "'%s' is scaled while it moves; its pins can follow a motion without scale only" % part.obj.name,
                    [part.obj.name],
                )
            self.keyframe_count += len(keyframes)
            pin.update({"keyframes": keyframes, "pivot": (part.matrices[0][:3, 3] * self.scale).tolist()})
        return pin

    def make_attachment(self, part: Part, attachment) -> Dict[str, Any]:
        target = attachment.target
        if target is None:
            raise Refusal("An attachment of '%s' names no object" % part.obj.name, [part.obj.name])
        found = [each for each in self.parts if each.obj.name == target.name]
        if not found or found[0] is part:
            raise Refusal(
                "'%s' is attached to '%s', which is no obstacle, rigid body or other cloth" % (part.obj.name, target.name),
                [part.obj.name],
            )
        said: Dict[str, Any] = {"to": found[0].name}
        if attachment.distance > 0:
            said["within"] = attachment.distance * self.scale
        if not attachment.vertex_group:
            if attachment.distance <= 0:
                raise Refusal("An attachment of '%s' needs vertices or a distance" % part.obj.name, [part.obj.name])
            return {"near": {"to": found[0].name, "within": said["within"]}, **said}
        self.scene.frame_set(self.first)
        evaluated = part.obj.evaluated_get(self.context.evaluated_depsgraph_get())
        chosen = self.find_group(part, evaluated.to_mesh(), attachment.vertex_group, "attachment")
        evaluated.to_mesh_clear()
        return {"vertices": make_ranges(self.number_as_written(part, chosen)), **said}

    def write_rest(self, part: Part) -> str:
        """The mesh with one shape key alone, without what deforms it, as large as the object is at the start."""
        obj, key = part.obj, part.obj.tulle.rest_key
        keys = obj.data.shape_keys.key_blocks if obj.data.shape_keys else {}
        if key not in keys:
            raise Refusal("'%s' has no shape key '%s', which is to be its shape at rest" % (obj.name, key), [obj.name])
        index, alone, muted = obj.active_shape_key_index, obj.show_only_shape_key, keys[key].mute
        try:
            obj.active_shape_key_index, obj.show_only_shape_key, keys[key].mute = keys.find(key), True, False
            with stack.reading(self.context, [obj], hide=lambda each: stack.list_hidden(each, deforms=False)):
                self.scene.frame_set(self.first)
                evaluated = obj.evaluated_get(self.context.evaluated_depsgraph_get())
                local = meshes.read_positions(evaluated.to_mesh())
                evaluated.to_mesh_clear()
        finally:
            obj.active_shape_key_index, obj.show_only_shape_key, keys[key].mute = index, alone, muted
        if len(local) != sum(part.counts):
            raise Refusal("The shape key '%s' of '%s' gives a mesh of other vertices" % (key, obj.name), [obj.name])
        world = meshes.to_world(local, part.matrices[0], self.scale)[part.used]
        meshes.write_obj(self.get_path(part.name + ".rest.obj"), world, part.corners)
        return "%s/%s.rest.obj" % (MESH_FOLDER, part.name)

    def make_obstacle(self, part: Part) -> Dict[str, Any]:
        settings = part.obj.tulle
        said: Dict[str, Any] = {"name": part.name, "mesh": self.name_file(part)}
        corners = part.corners
        if part.thin is not None and len(part.thin) > 0:
            corners = np.delete(corners, part.thin, axis=0)
            if len(corners) == 0:
                raise Refusal("'%s' has no face with an area" % part.obj.name, [part.obj.name])
        meshes.write_obj(self.get_path(part.name + ".obj"), part.world, corners)
        if settings.use_friction:
            said["friction"] = settings.friction
        if part.role == "BODY":
            said["dynamic"] = {"density": settings.density}
            if not motion.is_still(part.matrices):
                self.note("'%s' is a rigid body; its animation counts as it is at the start" % part.obj.name)
            return said
        keyframes = motion.make_keyframes(part.matrices, 1 / get_fps(self.scene), self.scale) if part.keeps_shape else None
        if has_no_motion(part):
            os.remove(part.writer.path)
        elif keyframes is not None and self.keyframe_count + len(keyframes) <= MOST_KEYFRAMES:
            os.remove(part.writer.path)
            self.keyframe_count += len(keyframes)
            said["motion"] = {"keyframes": keyframes, "pivot": (part.matrices[0][:3, 3] * self.scale).tolist()}
        else:
            self.note_rounding(part)
            cache = self.name_file(part, ".pc2")["file"]
            said["motion"] = {"sequence": {"cache": cache, "interval": 1 / get_fps(self.scene)}}
        return said


def has_no_motion(part: Part) -> bool:
    """Whether no vertex moves; decided by what was written where it deforms or is made of instances."""
    if part.keeps_shape and motion.is_still(part.matrices):
        return True
    if part.keeps_shape:
        return False
    cache = meshes.Pc2Reader(part.writer.path)
    first = cache.read(0)
    return all(np.array_equal(first, cache.read(frame)) for frame in range(1, cache.count_frames()))


def write_links(read: Reader) -> None:
    """What `caches` needs to bring results back to the objects."""
    bodies = []
    for part in read.parts:
        loose = np.setdiff1d(np.arange(sum(part.counts)), part.used)
        bodies.append({
            "object": part.obj.name, "name": part.name, "role": part.role, "vertices": sum(part.counts),
            "loose": loose.tolist(), "thin": [] if part.thin is None else part.thin.tolist(),
            "own_triangles": len(part.own.corners) if part.own else 0,
            "loose_places": part.local[loose].astype(float).tolist() if part.is_simulated else [],
            "matrices": [matrix.tolist() for matrix in part.matrices] if part.is_simulated else [],
        })  # fmt: skip
    links = {"format": "tulle blender", "format_version": 1, "scale": read.scale, "frame_start": read.first,
             "frame_end": read.last, "notes": read.notes, "bodies": bodies}  # fmt: skip
    with replacing(os.path.join(read.folder, LINK_FILE), encoding="utf-8") as file:
        json.dump(links, file)


def write_scene(path: str, scene: Dict[str, Any]) -> None:
    """YAML: a line for each key, and one for each cloth and obstacle, whose values are JSON, which is YAML too."""
    lines = []
    for key, value in scene.items():
        if isinstance(value, list) and value and isinstance(value[0], dict):
            lines.append(key + ":")
            lines += ["  - " + json.dumps(each, ensure_ascii=False) for each in value]
        else:
            lines.append("%s: %s" % (key, json.dumps(value, ensure_ascii=False)))
    with replacing(path, encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")
