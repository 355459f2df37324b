"""Data sets of cloth for learning: draped and crumpled cloth over random obstacles, with exact labels of what intersects.

>>> data = tulle.datasets.drapes(1000, seed=7, negatives=0.5)
>>> for sample in data:
...     sample.positions, sample.triangles, sample.pairs
>>> data.write("drapes")                       # continues an interrupted call
>>> for sample in tulle.datasets.read("drapes"):
...     ...

Sample i depends on the seed and on i alone, not on the number of threads, nor on what is asked before. Its labels come from
`tulle.Judge`, which decides by exact arithmetic and shares no code with the simulation: a sample without pairs intersects
nowhere, one with pairs exactly there.
"""
from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from tulle import structs
from tulle._library import version
from tulle.detector import Judge
from tulle.envs.task import Gripper
from tulle.errors import Error, InvalidArgumentError, ParseError, PinchedError, StepFailedError
from tulle.mesh import Mesh, PathLike, make_shape
from tulle.objects import Attachment
from tulle.world import World, make_material, step_worlds

Doubles = NDArray[np.float64]
Indices = NDArray[np.uint32]

FORMAT = 1
"""Version of the layout of files."""
LICENCE = ("MIT. The files were made by Tulle, and are under the licence of Tulle, in its file LICENSE: "
           "Copyright (c) 2026 The Tulle authors")
_SHARD = 50  # samples of a file, which are simulated together
_TIME_STEP = 0.02  # [s]
_TRIES = 20  # worlds that are tried for a sample, each from other random numbers
_MATERIALS = ("cotton", "silk", "wool", "denim-soft", "chiffon", "polyester-plain", "jersey")
_INDEX = "index.json"


@dataclass(frozen=True)
class Sample:
    """Cloth and obstacles at a moment, and which of their triangles intersect."""

    index: int
    """Its number, from 0."""
    kind: str
    """"drape" or "crumple"."""
    material: str
    """Name of the fabric."""
    positions: Doubles
    """[m] (vertices, 3) of the cloth."""
    triangles: Indices
    """(triangles, 3) of the cloth."""
    rest_positions: Doubles
    """[m] (vertices, 3) of the cloth as it was cut."""
    obstacle_positions: Doubles
    """[m] (vertices, 3) of all obstacles, one after the other."""
    obstacle_triangles: Indices
    """(triangles, 3) of all obstacles, which count their vertices together."""
    is_accepted: bool
    """Whether it is a state that the simulation accepted; else one that was pushed until something intersected."""
    pairs: NDArray[Any]
    """Pairs that intersect: CHECK_PAIR records in order. Body 0 is the cloth, body 1 all obstacles; none where nothing does."""

    def get_meshes(self) -> tuple[Mesh, Mesh]:
        """The cloth, and the obstacles as one mesh."""
        return Mesh(self.positions, self.triangles), Mesh(self.obstacle_positions, self.obstacle_triangles)


_ARRAYS = ("positions", "triangles", "rest_positions", "obstacle_positions", "obstacle_triangles", "pairs")


class Drapes:
    """The samples of `drapes`: iterate, index, or write them."""

    def __init__(self, count: int, seed: int, negatives: float, resolution: int, steps: int, threads: int) -> None:
        ranges = (("count", count, 0, 2**31), ("seed", seed, 0, 2**63), ("resolution", resolution, 4, 100),
                  ("steps", steps, 1, 100_000), ("threads", threads, 0, 256))
        for name, value, least, most in ranges:
            if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not least <= value <= most:
                raise InvalidArgumentError(f"{name} is {value!r}; it should be a whole number from {least} to {most}")
        if not 0 <= negatives <= 1:
            raise InvalidArgumentError(f"negatives is {negatives!r}; it should be a part of the samples, 0 .. 1")
        self.count, self.seed, self.negatives = int(count), int(seed), float(negatives)
        self.resolution, self.steps, self.threads = int(resolution), int(steps), threads

    def __len__(self) -> int:
        return self.count

    def __iter__(self) -> Iterator[Sample]:
        for first in range(0, self.count, _SHARD):
            yield from self._make(range(first, min(first + _SHARD, self.count)))

    def __getitem__(self, index: int) -> Sample:
        if not -self.count <= index < self.count:
            raise IndexError(f"there are {self.count} samples, and none is number {index}")
        return self._make([index % self.count])[0]

    def _make(self, indices: Sequence[int]) -> list[Sample]:
        """Simulates some samples together."""
        made: dict[int, Sample] = {}
        waiting = list(indices)
        for attempt in range(_TRIES):
            scenes = {i: _Scene(np.random.Generator(np.random.PCG64([self.seed, i, attempt])), self) for i in waiting}
            try:
                failed = _simulate(list(scenes.values()), self.steps, self.threads)
                for i, scene in scenes.items():
                    sample = None if scene in failed else scene.take(i)
                    if sample is not None:
                        made[i] = sample
            finally:
                for scene in scenes.values():
                    scene.world.close()
            waiting = [i for i in waiting if i not in made]
            if not waiting:
                return [made[i] for i in indices]
        raise StepFailedError(f"sample {waiting[0]} of the seed {self.seed} could not be simulated in {_TRIES} tries")

    # ---- files ----

    def write(self, directory: PathLike) -> None:
        """Writes the samples as NPZ files of 50 each, and index.json with sizes, licence, version and seed.

        If a call was cut short, the same call continues it: whole files stay. A file appears whole or not at
        all. Raises InvalidArgumentError where the directory holds other samples, and OSError.
        """
        target = Path(directory)
        target.mkdir(parents=True, exist_ok=True)
        index = self._describe()
        known = _read_index(target) if (target / _INDEX).exists() else None
        if known is not None:
            for key in index:
                if key not in ("shards", "is_complete", "totals") and known.get(key) != index[key]:
                    raise InvalidArgumentError(f"{target} holds samples with {key} {known.get(key)!r}, not {index[key]!r}: "
                                               "write to another directory")
        there = {shard["file"]: shard for shard in known["shards"]} if known is not None else {}
        for number, first in enumerate(range(0, self.count, _SHARD)):
            name = f"drapes-{number:05d}.npz"
            shard = there.get(name)
            if shard is None or not _is_whole(target / name, shard):
                samples = self._make(range(first, min(first + _SHARD, self.count)))
                shard = _write_shard(target / name, samples)
            index["shards"].append(shard)
            later = [each for each in there.values() if each["file"] > name]
            self._write_index(target, {**index, "shards": [*index["shards"], *later]})
        index["is_complete"] = True
        self._write_index(target, index)

    def _describe(self) -> dict[str, Any]:
        return {"format": FORMAT, "generator": "tulle.datasets.drapes", "version": version, "licence": LICENCE,
                "seed": self.seed, "count": self.count, "negatives": self.negatives, "resolution": self.resolution,
                "steps": self.steps, "time_step": _TIME_STEP, "unit": "m",
                "arrays": {"positions": "float64 (vertices, 3)", "triangles": "uint32 (triangles, 3)",
                           "rest_positions": "float64 (vertices, 3)", "obstacle_positions": "float64 (vertices, 3)",
                           "obstacle_triangles": "uint32 (triangles, 3)",
                           "pairs": "uint32 (pairs, 4): body_a, triangle_a, body_b, triangle_b; body 0: cloth, 1: obstacles"},
                "is_complete": False, "shards": []}

    @staticmethod
    def _write_index(target: Path, index: dict[str, Any]) -> None:
        totals = {key: sum(shard[key] for shard in index["shards"]) for key in ("samples", "positives", "pairs", "bytes")}
        _write_file(target / _INDEX, (json.dumps({**index, "totals": totals}, indent=1) + "\n").encode())


def drapes(count: int, seed: int = 0, *, negatives: float = 0.0, resolution: int = 9, steps: int = 40,
           threads: int = 0) -> Drapes:
    """`count` samples of draped and crumpled cloth over random obstacles. Nothing is simulated before a sample is asked for.

    seed: of all that is drawn. negatives: the part of samples that are pushed until something intersects; 0: all are states
    that the simulation accepted. resolution: most vertices along a side of a cloth, which has from 60 % of them on. steps:
    of 0.02 s that a cloth falls or is crumpled. threads: 0: one per processor; no byte depends on it.
    """
    return Drapes(count, seed, negatives, resolution, steps, threads)


def read(directory: PathLike) -> Iterator[Sample]:
    """The samples that `Drapes.write` wrote, in order. Raises ParseError where a file is damaged, and OSError."""
    target = Path(directory)
    for shard in _read_index(target)["shards"]:
        path = target / shard["file"]
        if not _is_whole(path, shard):
            raise ParseError("the file is not as it was written; write the samples again", str(path))
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        ends = {name: np.cumsum(arrays[name + "_count"]) for name in _ARRAYS}
        for i in range(shard["samples"]):
            parts = {name: arrays[name][ends[name][i] - arrays[name + "_count"][i]:ends[name][i]] for name in _ARRAYS}
            parts["pairs"] = np.ascontiguousarray(parts["pairs"]).view(structs.CHECK_PAIR).reshape(-1)
            yield Sample(index=int(arrays["index"][i]), kind=str(arrays["kind"][i]), material=str(arrays["material"][i]),
                         is_accepted=bool(arrays["is_accepted"][i]), **parts)


class _Scene:
    """A world that comes to be a sample."""

    def __init__(self, random: np.random.Generator, settings: Drapes) -> None:
        self._random = random
        self.material = _MATERIALS[int(random.integers(len(_MATERIALS)))]
        self.kind = ("drape", "crumple")[int(random.integers(2))]
        self._is_negative = bool(random.random() < settings.negatives)
        self._steps = settings.steps
        self._rest = self._make_cloth(settings.resolution)
        self._obstacle = _join([self._make_obstacle(i) for i in range(int(random.integers(1, 4)))])
        low = float(self._obstacle.positions[:, 2].max()) + 0.02
        self.world = World(threads=1)
        try:
            self.world.add_obstacle(self._obstacle, name="obstacles", friction=float(random.uniform(0.1, 0.8)))
            start = self._rest.transform(rotation=_turn(random, 1.0), translation=(*random.uniform(-0.05, 0.05, 2), 0.0))
            lift = low - float(start.positions[:, 2].min())
            self.cloth = self.world.add_cloth(start.transform(translation=(0, 0, lift)), material=make_material(self.material),
                                              rest_positions=self._rest.positions, name="cloth",
                                              velocity=(*random.uniform(-0.5, 0.5, 2), float(random.uniform(-2, -0.5))))
        except BaseException:
            self.world.close()
            raise
        self._holds: list[tuple[Attachment, Doubles, Doubles]] = []

    def _make_cloth(self, resolution: int) -> Mesh:
        random = self._random
        least = max(4, round(0.6 * resolution))
        first, second = (int(each) for each in random.integers(least, resolution + 1, 2))
        if random.random() < 0.25:
            rings = (max(2, first // 2), max(6, 2 * second))
            return make_shape("disc", radius=float(random.uniform(0.1, 0.16)), resolution=rings)
        size = random.uniform(0.18, 0.32, 2)
        return make_shape("rectangle", size=size, resolution=(first, second), is_irregular=bool(random.random() < 0.5),
                          seed=int(random.integers(2**31)))

    def _make_obstacle(self, number: int) -> Mesh:
        random = self._random
        shape = ("sphere", "box", "cylinder", "cone", "torus")[int(random.integers(5))]
        size = float(random.uniform(0.04, 0.09))
        if shape == "sphere":
            made = make_shape("sphere", radius=size, resolution=3)
        elif shape == "box":
            made = make_shape("box", size=size * random.uniform(0.8, 2, 3), resolution=3)
        elif shape == "cylinder":
            made = make_shape("cylinder", radius=0.6 * size, height=2.5 * size, resolution=(10, 3))
        elif shape == "cone":
            made = make_shape("cone", radius=size, height=2 * size, resolution=(10, 3))
        else:
            made = make_shape("torus", radius=size, inner_radius=0.3 * size, resolution=(14, 7))
        place = random.uniform(-0.1, 0.1, 3) if number else np.zeros(3)
        return made.transform(rotation=_turn(random, np.pi), translation=place)

    def act(self, step: int) -> None:
        """Crumples the cloth: vertices far apart are pulled together, then let go."""
        if self.kind != "crumple":
            return
        begin, end = self._steps // 4, self._steps * 3 // 4
        if step == begin:
            positions = np.array(self.cloth.positions)
            centre = positions.mean(axis=0)
            for vertex in self._random.choice(len(positions), 3, replace=False):
                goal = centre + self._random.uniform(-0.03, 0.03, 3) + [0, 0, 0.05]
                held = self.world.attach(self.cloth, [vertex], positions[[vertex]], stiffness=Gripper.STIFFNESS,
                                         break_force=Gripper.BREAK_FORCE)
                self._holds.append((held, positions[vertex], goal))
        for held, start, goal in self._holds:
            if step == end:
                held.release()
            elif step < end:
                share = (step - begin + 1) / (end - begin)
                held.set_points((start + share * (goal - start)).reshape(1, 3))

    def take(self, index: int) -> Optional[Sample]:
        """The sample, of the state as it is; None: the cloth could not be pushed into anything."""
        positions, judge = np.array(self.cloth.positions), Judge(threads=1)
        obstacles = Mesh(self._obstacle.positions, self._obstacle.triangles)

        def find(places: Doubles) -> NDArray[Any]:
            return judge.find_intersections([Mesh(places, self._rest.triangles)], [obstacles]).pairs

        pairs = find(positions)
        if pairs.size:
            raise StepFailedError(f"sample {index}: the judge finds an intersection in an accepted state: please report it")
        if self._is_negative:
            positions, pairs = self._push(positions, find)
            if not pairs.size:
                return None
        return Sample(index=index, kind=self.kind, material=self.material, positions=positions, triangles=self._rest.triangles,
                      rest_positions=self._rest.positions, obstacle_positions=self._obstacle.positions,
                      obstacle_triangles=self._obstacle.triangles, is_accepted=not self._is_negative, pairs=pairs)

    def _push(self, positions: Doubles, find: Any) -> tuple[Doubles, NDArray[Any]]:
        """Pushes cloth around a vertex through what lies near it, farther and farther, until something intersects."""
        random, triangles = self._random, self._rest.triangles.astype(np.int64)
        vertex = int(random.integers(len(positions)))
        if random.random() < 0.5:  # towards another part of the cloth, else towards an obstacle
            apart = np.linalg.norm(self._rest.positions - self._rest.positions[vertex], axis=1)
            far = apart[triangles].min(axis=1) > 0.06
            targets = positions[triangles[far]].mean(axis=1)
        else:
            targets = self._obstacle.positions[self._obstacle.triangles.astype(np.int64)].mean(axis=1)
        if not len(targets):
            targets = self._obstacle.positions
        way = targets[np.linalg.norm(targets - positions[vertex], axis=1).argmin()] - positions[vertex]
        way *= 1 + 0.01 / max(float(np.linalg.norm(way)), 1e-9)  # a centimetre beyond
        reach = float(random.uniform(0.005, 0.06))
        weight = np.exp(-((np.linalg.norm(self._rest.positions - self._rest.positions[vertex], axis=1) / reach) ** 2))
        share = float(random.uniform(0.5, 1.0))
        for _ in range(40):
            pushed = positions + share * weight[:, None] * way
            pairs = find(pushed)
            if pairs.size:
                break
            share *= 1.3
        return pushed, pairs


def _simulate(scenes: list[_Scene], steps: int, threads: int) -> list[_Scene]:
    """Simulates scenes together; gives those that failed."""
    failed: list[_Scene] = []
    for scene in scenes:
        try:
            scene.world.start()
        except Error:  # it was thrown into an obstacle
            failed.append(scene)
    for step in range(steps):
        moving = [scene for scene in scenes if scene not in failed]
        for scene in moving:
            scene.act(step)
        for scene, report in zip(moving, step_worlds([scene.world for scene in moving], _TIME_STEP, threads)):
            if isinstance(report, (PinchedError, StepFailedError)):
                failed.append(scene)
            elif isinstance(report, Error):
                raise report
    return failed


def _turn(random: np.random.Generator, most: float) -> tuple[float, float, float, float]:
    """A turn by at most `most` [rad] about any axis, as a unit quaternion."""
    axis = random.normal(size=3)
    axis /= np.linalg.norm(axis)
    angle = float(random.uniform(-most, most))
    row = np.array([np.cos(angle / 2), *(np.sin(angle / 2) * axis)])
    row /= np.linalg.norm(row)
    return float(row[0]), float(row[1]), float(row[2]), float(row[3])


def _join(meshes: list[Mesh]) -> Mesh:
    starts = np.cumsum([0, *(mesh.vertex_count for mesh in meshes)])
    return Mesh(np.concatenate([mesh.positions for mesh in meshes]),
                np.concatenate([mesh.triangles + start for mesh, start in zip(meshes, starts.astype(np.uint32))]))


def _write_shard(path: Path, samples: list[Sample]) -> dict[str, Any]:
    """Writes samples, and gives what the index tells of them."""
    arrays: dict[str, Any] = {"index": np.array([sample.index for sample in samples]),
                              "kind": np.array([sample.kind for sample in samples]),
                              "material": np.array([sample.material for sample in samples]),
                              "is_accepted": np.array([sample.is_accepted for sample in samples])}
    for name in _ARRAYS:
        rows = [getattr(sample, name) for sample in samples]
        if name == "pairs":
            rows = [np.ascontiguousarray(row).view(np.uint32).reshape(-1, 4) for row in rows]
        arrays[name] = np.concatenate(rows)
        arrays[name + "_count"] = np.array([len(row) for row in rows])
    temporary = path.with_suffix(".npz.tmp")
    with open(temporary, "wb") as file:
        np.savez(file, **arrays)
        file.flush()
        os.fsync(file.fileno())
    os.replace(temporary, path)
    data = path.read_bytes()
    return {"file": path.name, "samples": len(samples), "positives": sum(sample.is_accepted for sample in samples),
            "pairs": int(arrays["pairs"].shape[0]), "bytes": len(data), "sha256": hashlib.sha256(data).hexdigest()}


def _write_file(path: Path, data: bytes) -> None:
    temporary = path.with_suffix(path.suffix + ".tmp")
    with open(temporary, "wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    os.replace(temporary, path)


def _is_whole(path: Path, shard: dict[str, Any]) -> bool:
    return path.is_file() and hashlib.sha256(path.read_bytes()).hexdigest() == shard["sha256"]


def _read_index(directory: Path) -> dict[str, Any]:
    path = directory / _INDEX
    try:
        index = json.loads(path.read_bytes())
        if index["format"] != FORMAT:
            raise ParseError(f"the samples are of the format {index['format']}; this version reads {FORMAT}", str(path))
        if not all({"file", "samples", "sha256"} <= set(shard) for shard in index["shards"]):
            raise KeyError("shards")
    except (ValueError, KeyError, TypeError) as failure:
        if isinstance(failure, ParseError):
            raise
        raise ParseError(f"this is no index of samples: {failure}", str(path)) from None
    return index  # type: ignore[no-any-return]
