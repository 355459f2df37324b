"""The task "straighten": two grippers pull a crumpled cloth straight on a table."""
from __future__ import annotations

import numpy as np

from tulle.envs.policy import Doubles, Policy, State, View, go, is_there, reach
from tulle.envs.task import Coverage, Gripper, Task, add_table, list_corners, make_towel

_EDGES = ((0, 1), (1, 3), (3, 2), (2, 0))  # corners along each edge, of `list_corners`


class Straighten(Task):
    """A crumpled cloth lies on a table; it is to lie flat.

    Done: it covers 92 % of its flat area, nowhere higher than 4 cm, and nothing is held or moves. The score is the part that it
    covers.
    """

    NAME, LENGTH, SETTLE = "straighten", 320, 100
    SIDE = 0.28  # [m]

    def build(self) -> None:
        size = self.options.resolution
        mesh = make_towel(self.SIDE, size, self.random.uniform(-np.pi, np.pi), (*self.random.uniform(-0.05, 0.05, 2), 0.006))
        self.add_cloth(mesh)
        add_table(self.world)
        self._coverage = Coverage(mesh)
        self._vertices = self.random.choice(size * size, 2, replace=False)
        self._goals = self.random.uniform([-0.06, -0.06, 0.16], [0.06, 0.06, 0.24], (2, 3))
        self._starts = self.random.uniform([-0.2, -0.2, 0.25], [0.2, 0.2, 0.35], (2, 3))
        self._hands: list[Gripper] = []

    def settle(self, step: int) -> None:
        """Two hands lift the cloth somewhere, bring it together and drop it."""
        if step == 5:
            positions = np.array(self.cloth.positions)
            for vertex, goal in zip(self._vertices, self._goals):
                hand = Gripper(self, positions[vertex])
                hand.close()
                # On straight lines in the same time, they never draw apart farther than they are at one of the ends.
                hand.velocity = (goal - hand.position) / (30 * self.TIME_STEP)
                self._hands.append(hand)
        for hand in self._hands:
            if step == 35:
                hand.velocity = np.zeros(3)
            if step == 45:
                hand.open()
            hand.move(self.TIME_STEP)

    def is_ready(self) -> bool:
        return self.measure()[0] < 0.8

    def begin(self) -> None:
        for start in self._starts:
            self.add_gripper(start)

    def measure(self) -> tuple[float, bool]:
        positions = np.array(self.cloth.positions)
        coverage = self._coverage.measure(positions)
        return min(1.0, coverage), bool(coverage >= 0.92 and positions[:, 2].max() < 0.04 and self.is_still())


class StraightenPolicy(Policy):
    """Lifts the cloth by the ends of an edge, pulls that straight, lets the rest hang down, and lays it down from below."""

    task = Straighten

    def decide(self, view: View, state: State) -> Doubles:
        size = round(len(view["positions"]) ** 0.5)
        corners = view["positions"][list_corners(size)]
        if state["phase"] == "begin":
            edge = max(_EDGES, key=lambda pair: float(np.linalg.norm(corners[pair[0]] - corners[pair[1]])))
            away = [float(np.linalg.norm(view["grippers"] - corners[list(way)], axis=1).sum()) for way in (edge, edge[::-1])]
            state["pair"] = edge if away[0] <= away[1] else edge[::-1]
            state["phase"] = "reach"
        if state["phase"] == "reach":
            if not (view["holds"] > 0).all():
                return reach(view, corners[list(state["pair"])])
            state["phase"] = "lift"
            along = (view["grippers"][1] - view["grippers"][0])[:2]
            along = np.array([1.0, 0.0]) if np.linalg.norm(along) < 1e-3 else along / np.linalg.norm(along)
            state["along"], state["across"] = np.array([*along, 0.0]), np.array([-along[1], along[0], 0.0])
            state.update(angle=np.pi / 2, left=30)
        if state["phase"] != "leave" and not (view["holds"] > 0).all():
            state["phase"] = "begin"  # it slipped away
            return go(view, view["grippers"] + [0, 0, 0.1], False)
        return self._lay(view, state)

    def _lay(self, view: View, state: State) -> Doubles:
        side = Straighten.SIDE
        halves = np.array([[-0.5], [0.5]]) * side * state["along"]
        if state["phase"] == "lift":
            goals = halves + [0, 0, side + 0.04]
            if not is_there(view, goals):
                return go(view, goals, True, 0.5)
            state["left"] -= 1
            if state["left"] > 0:
                return go(view, goals, True)
            # Lay it down away from where the lower edge hangs.
            hanging = view["positions"][list_corners(round(len(view["positions"]) ** 0.5))] - view["grippers"].mean(axis=0)
            lower = hanging[[i for i in range(4) if i not in state["pair"]]].mean(axis=0)
            if lower @ state["across"] > 0:
                state["across"] = -state["across"]
            state["phase"] = "lay"
        if state["phase"] == "lay":
            state["angle"] = angle = max(-1.0, state["angle"] - 0.035)
            # On the way down the lower edge is dragged a little, so that it trails behind. Once down, they go on for a while
            # and pull out what is left of the folds.
            slope, beyond = max(angle, 0.0), max(-angle, 0.0)
            reached = (side + 0.005) * np.cos(slope) + 0.1 * (1 - slope / (np.pi / 2)) + 0.06 * beyond
            goals = halves * (1.0 + 0.05 * beyond) + reached * state["across"] + [0, 0, max(0.012, side * np.sin(slope))]
            if angle > -1.0:
                return go(view, goals, True)
            state.update(phase="leave", left=20, goals=goals + [0, 0, 0.2])
        state["left"] -= 1
        if state["left"] <= 0:
            state["phase"] = "begin"
        return go(view, state["goals"], False, 0.5)
