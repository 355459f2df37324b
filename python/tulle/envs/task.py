"""What all tasks have in common: a cloth, grippers that move it, and measures of how it lies."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Optional, Union

import numpy as np
from numpy.typing import NDArray

from tulle import structs
from tulle.errors import InvalidArgumentError
from tulle.mesh import Mesh, make_shape
from tulle.objects import Attachment, Cloth
from tulle.world import World, list_materials, make_material

Doubles = NDArray[np.float64]

MATERIALS = ("cotton", "silk", "wool-tropical", "polyester-plain", "polyester-faille")
"""Fabrics among which the seed chooses."""


@dataclass(frozen=True)
class Options:
    """Options of every task, by name in `make`."""

    resolution: int = 14
    """Vertices along a side of the cloth, 8 .. 40; it has the square of that."""
    episode_length: int = 0
    """Actions after which an episode is truncated; 0: what suits the task."""
    material: Optional[str] = None
    """Name of a fabric; None: the seed chooses."""
    quality: Union[structs.Quality, str] = structs.Quality.NORMAL
    """How far the solves of a step go."""
    settle_steps: int = 0
    """Most steps that the cloth gets to come to its start before an episode begins; 0: what suits the task."""

    def __post_init__(self) -> None:
        for name, least, most in (("resolution", 8, 40), ("episode_length", 0, 1_000_000), ("settle_steps", 0, 100_000)):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not least <= value <= most:
                raise InvalidArgumentError(f"{name} is {value!r}; it should be a whole number from {least} to {most}")
        if self.material is not None and self.material not in list_materials():
            raise InvalidArgumentError(f"there is no material \"{self.material}\"; there are {', '.join(list_materials())}")


class Gripper:
    """A point that an action moves. When it closes it takes the nearest vertex and its neighbours in the cloth, and holds
    them by springs of limited force; other layers slip out of it."""

    REACH = 0.025
    """[m] what is nearer when it closes is held."""
    MOST = 6
    """Vertices that it holds at a time, the nearest ones."""
    SPEED = 0.6
    """[m/s] along each axis; a step then moves a vertex by about an edge, and leaves the cloth time to follow."""
    STIFFNESS = 100.0
    """[N/m] it sags by some tenths of a millimetre under a cloth that hangs from it."""
    BREAK_FORCE = 4.0
    """[N] on a vertex: more than a start at full speed takes."""

    def __init__(self, task: Task, position: Doubles) -> None:
        self.cloth, self._rest, self.position = task.cloth, task.rest, np.array(position, float)
        self._low, self._high = np.array(task.LOW), np.array(task.HIGH)
        self.velocity = np.zeros(3)
        self._attachment: Optional[Attachment] = None
        self._offsets = np.zeros((0, 3))

    def hold(self, vertices: NDArray[Any]) -> None:
        """Holds these vertices where they are, beside itself."""
        places = np.array(self.cloth.positions)[vertices]
        self._attachment = self.cloth.world.attach(self.cloth, vertices, places, stiffness=self.STIFFNESS,
                                                   break_force=self.BREAK_FORCE)
        self._offsets = places - self.position

    def close(self) -> None:
        """Holds the nearest vertices within reach; nothing where there are none, or where it holds some already."""
        if self.holds:
            return
        distances = np.linalg.norm(np.array(self.cloth.positions) - self.position, axis=1)
        beside = np.linalg.norm(self._rest - self._rest[distances.argmin()], axis=1) <= 1.5 * self.REACH
        near = np.argsort(np.where(beside, distances, np.inf), kind="stable")[:self.MOST]
        near = near[(distances[near] <= self.REACH) & beside[near]]
        if near.size:
            self.hold(near)

    def open(self) -> None:
        """Lets go."""
        if self._attachment is not None:
            self._attachment.release()
            self._attachment = None

    @property
    def holds(self) -> bool:
        """Whether it holds something: its vertices may have broken off."""
        if self._attachment is not None and not self._attachment.report.held_count:
            self._attachment = None
        return self._attachment is not None

    def act(self, action: Doubles) -> None:
        """Takes an action: velocity along x, y and z in parts of SPEED, then above 0 to close, else to open."""
        self.velocity = self.SPEED * action[:3]
        if action[3] > 0:
            self.close()
        else:
            self.open()

    def move(self, time: float) -> None:
        """Moves on for `time` [s], through the next step of the world."""
        self.position = np.clip(self.position + time * self.velocity, self._low, self._high)
        if self._attachment is not None:
            self._attachment.set_points(self.position + self._offsets)


class Task:
    """One episode of a task: a world with its cloth and grippers. Subclasses build it, observe it and measure it."""

    NAME: ClassVar[str]
    LENGTH: ClassVar[int]  # actions of an episode
    SETTLE: ClassVar[int]  # steps of the world before it begins
    FEATURES: ClassVar[int] = 0  # numbers that the task adds to what is observed
    TIME_STEP: ClassVar[float] = 0.02  # [s]
    STEPS: ClassVar[int] = 2  # steps of the world for each action
    GRIPPERS: ClassVar[int] = 2
    LOW: ClassVar[tuple[float, float, float]] = (-0.5, -0.5, 0.006)  # [m] where grippers may go
    HIGH: ClassVar[tuple[float, float, float]] = (0.5, 0.5, 0.6)
    CAMERA: ClassVar[str] = "orbit=35deg,30deg"

    def __init__(self, random: np.random.Generator, options: Options) -> None:
        self.random, self.options = random, options
        self.world = World(threads=1, quality=options.quality, friction_cloth_cloth=0.5)
        try:
            chosen = MATERIALS[int(random.integers(len(MATERIALS)))]
            self.material = make_material(options.material or chosen)
            self.cloth: Cloth
            self.rest: Doubles
            self.grippers: list[Gripper] = []
            self.features: Doubles = np.zeros(self.FEATURES)
            self.build()
            self.world.start()
        except BaseException:
            self.world.close()
            raise
        self.length = options.episode_length or self.LENGTH
        self.settle_count = options.settle_steps or self.SETTLE
        self.action_count = 0

    # ---- what a task defines ----

    def build(self) -> None:
        """Adds cloth, by `add_cloth`, and obstacles to the world."""
        raise NotImplementedError

    def settle(self, step: int) -> None:
        """Acts before step number `step` of those that come before the episode."""

    def is_ready(self) -> bool:
        """Whether the world has settled to a start that is worth an episode; else another one is tried."""
        return True

    def begin(self) -> None:
        """The world has settled: places the grippers."""
        raise NotImplementedError

    def measure(self) -> tuple[float, bool]:
        """How well it is done, 0 .. 1, and whether it is done."""
        raise NotImplementedError

    # ---- what all do ----

    @classmethod
    def count_vertices(cls, options: Options) -> int:
        """Vertices of the cloth."""
        return options.resolution**2

    @classmethod
    def get_layout(cls, vertex_count: int) -> dict[str, tuple[int, ...]]:
        """The shapes of what an observation of a cloth of `vertex_count` vertices holds, in order."""
        return {"positions": (vertex_count, 3), "velocities": (vertex_count, 3), "grippers": (cls.GRIPPERS, 3),
                "holds": (cls.GRIPPERS,), "features": (cls.FEATURES,), "time": (1,)}

    @property
    def is_settled(self) -> bool:
        """Whether the steps before the episode are made."""
        return int(self.world.step_count) >= self.settle_count

    def add_cloth(self, mesh: Mesh) -> None:
        """Adds the cloth, which is at rest as it is."""
        self.cloth, self.rest = self.world.add_cloth(mesh, material=self.material, name="cloth"), mesh.positions.copy()

    def add_gripper(self, position: Doubles) -> Gripper:
        """Adds a gripper at `position` [m]."""
        made = Gripper(self, position)
        self.grippers.append(made)
        return made

    def act(self, action: Doubles) -> None:
        """Takes an action, one row for each gripper."""
        for gripper, row in zip(self.grippers, action.reshape(self.GRIPPERS, 4)):
            gripper.act(row)
        self.action_count += 1

    def move(self) -> None:
        """Moves the grippers through the next step of the world."""
        for gripper in self.grippers:
            gripper.move(self.TIME_STEP)

    def observe(self, out: NDArray[np.float32]) -> None:
        """Writes what is observed into `out`, see `get_layout`."""
        count = 3 * self.cloth.vertex_count
        for values, start in (("positions", 0), ("velocities", count)):
            self.cloth.copy_values(values, out[start:start + count].reshape(-1, 3))
        rest = [gripper.position for gripper in self.grippers]
        holds = [float(gripper.holds) for gripper in self.grippers]
        out[2 * count:] = np.concatenate([*rest, holds, self.features, [self.action_count / self.length]])

    def is_still(self, speed: float = 0.05) -> bool:
        """Whether nothing is held, and no vertex faster than `speed` [m/s]."""
        if any(gripper.holds for gripper in self.grippers):
            return False
        return float(np.abs(self.cloth.velocities).max()) < speed


def add_table(world: World, friction: float = 0.5) -> None:
    """Adds a table at z = 0."""
    world.add_obstacle(make_shape("plane", size=(2.4, 2.4)), name="table", friction=friction)


def make_towel(side: float, resolution: int, angle: float = 0.0, place: Sequence[float] = (0, 0, 0)) -> Mesh:
    """A flat square cloth, turned about z. Its corners are the vertices of `list_corners`."""
    turn = (float(np.cos(angle / 2)), 0.0, 0.0, float(np.sin(angle / 2)))
    return make_shape("rectangle", size=(side, side), resolution=resolution).transform(rotation=turn, translation=place)


def list_corners(resolution: int) -> list[int]:
    """The corners of a square cloth: at low y those of low and high x, then at high y."""
    return [0, resolution - 1, resolution * (resolution - 1), resolution**2 - 1]


class Coverage:
    """Measures which part of its flat area a cloth covers, seen from above."""

    def __init__(self, flat: Mesh) -> None:
        """flat: the cloth as it lies flat, in the plane of x and y."""
        sides = np.sort(flat.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).astype(np.int64), axis=1)
        self._edges = np.unique(sides, axis=0)
        lengths = np.linalg.norm(flat.positions[self._edges[:, 0]] - flat.positions[self._edges[:, 1]], axis=1)
        # Vertices and middles of edges lie half an edge apart: each cell of this side that the cloth fills has one of them.
        self._side = 0.6 * float(np.median(lengths))
        self._full = self._count(flat.positions)

    def _count(self, positions: Doubles) -> int:
        flat = positions[:, :2]
        points = np.concatenate([flat, 0.5 * (flat[self._edges[:, 0]] + flat[self._edges[:, 1]])])
        cells = np.floor(points / self._side).astype(np.int64)
        cells -= cells.min(axis=0)
        width = int(cells[:, 1].max()) + 1
        return int(np.count_nonzero(np.bincount(cells[:, 0] * width + cells[:, 1])))

    def measure(self, positions: Doubles) -> float:
        """1 where it lies flat; less where it overlaps itself or stands on edge."""
        return self._count(positions) / self._full
