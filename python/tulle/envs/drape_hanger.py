"""The task "drape-hanger": two grippers lay a cloth over a bar so that it stays there."""
from __future__ import annotations

import numpy as np

from tulle.envs.policy import Doubles, Policy, State, View, go, is_there
from tulle.envs.task import Task, add_table, list_corners
from tulle.mesh import Mesh, make_shape


class DrapeHanger(Task):
    """A cloth hangs from two grippers next to a bar; it is to hang over the bar by itself.

    Done: on each side of the bar hangs 30 % of the cloth or more, off the table, and nothing is held or moves for eight
    actions. The score is how much hangs on the lighter side, twice, as a part of what is off the table.
    Features: a point of the bar (3), and its direction (3).
    """

    NAME, LENGTH, SETTLE, FEATURES = "drape-hanger", 120, 25, 6
    SIDE, RADIUS, BAR = 0.3, 0.014, 0.6  # [m]
    HIGH = (0.5, 0.5, 0.9)
    CAMERA = "orbit=60deg,15deg"

    def build(self) -> None:
        turn, height = self.random.uniform(-0.35, 0.35), self.random.uniform(0.42, 0.5)
        place = self.random.uniform(-0.04, 0.04, 2)
        self._along = np.array([np.cos(turn), np.sin(turn), 0.0])
        self._across = np.array([-np.sin(turn), np.cos(turn), 0.0])
        self._middle = np.array([*place, height])
        axes = np.array([self._across, [0.0, 0.0, 1.0], self._along])  # that of the cylinder becomes that of the bar
        shape = make_shape("cylinder", radius=self.RADIUS, height=self.BAR, resolution=(12, 8))
        bar = Mesh((shape.positions - [0, 0, self.BAR / 2]) @ axes + self._middle, shape.triangles)
        self.world.add_obstacle(bar, name="bar", friction=0.6)
        add_table(self.world)
        size, lift = self.options.resolution, self.random.uniform(0.16, 0.2)
        flat = make_shape("rectangle", size=(self.SIDE, self.SIDE), resolution=size)
        slide, before = self.random.uniform(-0.04, 0.04), self.random.uniform(-0.16, -0.1)
        rows = (flat.positions[:, :1] * self._along + (flat.positions[:, 1:2] - self.SIDE / 2) * [0.0, 0.0, 1.0]
                + self._middle + slide * self._along + before * self._across + [0, 0, lift])
        self.add_cloth(Mesh(rows, flat.triangles))
        self.features = np.concatenate([self._middle, self._along])
        self._calm = 0
        for corner in list_corners(size)[2:]:
            near = np.flatnonzero(np.linalg.norm(rows - rows[corner], axis=1) < 0.024)
            self.add_gripper(rows[corner]).hold(near)

    def begin(self) -> None:
        """The grippers hold the cloth from the start."""

    def measure(self) -> tuple[float, bool]:
        positions = np.array(self.cloth.positions)
        is_off = positions[:, 2] > 0.05
        beyond = (positions - self._middle) @ self._across > 0
        sides = [float((is_off & side).mean()) for side in (beyond, ~beyond)]
        hangs = min(sides) >= 0.3 and bool(is_off.all())
        self._calm = self._calm + 1 if hangs and self.is_still() else 0
        return min(1.0, 2 * min(sides)), self._calm >= 8


class DrapeHangerPolicy(Policy):
    """Carries the cloth over the bar, down on the far side, and lets go."""

    task = DrapeHanger

    def decide(self, view: View, state: State) -> Doubles:
        middle, along = view["features"][:3], view["features"][3:]
        across = np.array([-along[1], along[0], 0.0])
        radius = 0.5 * DrapeHanger.SIDE + DrapeHanger.RADIUS
        if state["phase"] == "begin":
            sides = (view["grippers"] - middle) @ along
            state.update(phase="over", angle=np.pi / 2, sides=sides[:, None] * along)
            state["goals"] = middle + state["sides"] + [0, 0, radius]
        if state["phase"] == "over":
            if not is_there(view, state["goals"]):
                return go(view, state["goals"], True, 0.5)
            state["phase"] = "down"
        if state["phase"] == "down":
            state["angle"] = angle = max(-0.42 * np.pi, state["angle"] - 0.06)
            radius -= 0.065 * (np.pi / 2 - angle) / np.pi  # the bar takes up what winds around it
            state["goals"] = middle + state["sides"] + radius * (np.cos(angle) * across + [0, 0, np.sin(angle)])
            if angle > -0.42 * np.pi or not is_there(view, state["goals"]):
                return go(view, state["goals"], True)
            state.update(phase="wait", left=12)
        if state["phase"] == "wait":
            state["left"] -= 1
            if state["left"] > 0:
                return go(view, state["goals"], True)
            state["phase"] = "leave"
        return go(view, state["goals"] + 0.15 * across, False, 0.5)
