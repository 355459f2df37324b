"""The task "fold-towel": two grippers fold a towel that lies on a table in half."""
from __future__ import annotations

import numpy as np

from tulle.envs.policy import Doubles, Policy, State, View, go, reach
from tulle.envs.task import Coverage, Task, add_table, list_corners, make_towel


class FoldTowel(Task):
    """A towel lies flat on a table; its first edge is to lie on the opposite one.

    Done: both corners of the edge lie within 4 cm of theirs, the towel covers 40 to 65 % of its flat area, nowhere higher than
    6 cm, and nothing is held or moves. The score is how near the corners are (0.7) and how well half of it is covered (0.3).
    """

    NAME, LENGTH, SETTLE = "fold-towel", 200, 10
    SIDE = 0.3  # [m]

    def build(self) -> None:
        angle, place = self.random.uniform(-0.6, 0.6), self.random.uniform(-0.06, 0.06, 2)
        self._starts = self.random.uniform([-0.04, -0.04, 0.04], [0.04, 0.04, 0.1], (2, 3))
        size = self.options.resolution
        mesh = make_towel(self.SIDE, size, angle, (*place, 0.006))
        self.add_cloth(mesh)
        add_table(self.world)
        self._corners = list_corners(size)
        self._coverage = Coverage(mesh)

    def begin(self) -> None:
        corners = np.array(self.cloth.positions)[self._corners[:2]]
        for start, corner in zip(self._starts, corners):
            self.add_gripper(corner + start)

    def measure(self) -> tuple[float, bool]:
        positions = np.array(self.cloth.positions)
        corners = positions[self._corners]
        apart = np.linalg.norm(corners[:2] - corners[2:], axis=1)
        coverage = self._coverage.measure(positions)
        score = 0.7 * (1 - min(1.0, apart.mean() / self.SIDE)) + 0.3 * float(np.clip(2 * (1 - coverage), 0, 1))
        is_done = (apart.max() < 0.04 and 0.4 <= coverage <= 0.65 and positions[:, 2].max() < 0.06 and self.is_still())
        return float(score), bool(is_done)


class FoldTowelPolicy(Policy):
    """Takes both corners over an arc to those opposite, and lets go; once more where they spring away."""

    task = FoldTowel

    def decide(self, view: View, state: State) -> Doubles:
        size = round(len(view["positions"]) ** 0.5)
        corners = view["positions"][list_corners(size)]
        if state["phase"] == "begin":
            if not (view["holds"] > 0).all():
                return reach(view, corners[:2])
            if "ahead" not in state:
                ahead = (corners[2:] - corners[:2]).mean(axis=0) * [1, 1, 0]
                state.update(beyond=-0.03, ahead=ahead / np.linalg.norm(ahead))
            state.update(phase="fold", share=0.0, start=view["grippers"].copy(), offset=view["grippers"] - corners[:2], left=18)
        over = corners[2:] + state["offset"] + [0, 0, 0.035]
        if state["phase"] == "fold":
            state["share"] = share = min(1.0, state["share"] + 0.03)
            height = 0.45 * np.linalg.norm((over - state["start"])[0]) * np.sin(np.pi * share)
            goals = state["start"] + share * (over - state["start"]) + [0, 0, height]
            if share < 1:
                return go(view, goals, True)
            state["phase"] = "lay"
        if state["phase"] == "lay":  # the rest of the towel may have slid: first over it, where nothing drags it, then down
            state["left"] -= 1
            if state["left"] > 8:
                state["end"] = over + state["beyond"] * state["ahead"] - [0, 0, 0.031]
                return go(view, over, True, 0.4)
            if state["left"] > 0:
                return go(view, state["end"], True, 0.3)
            state.update(phase="leave", end=view["grippers"] + [0, 0, 0.1], left=16)
        state["left"] -= 1
        back = corners[2:] - corners[:2]
        if state["left"] == 0 and np.linalg.norm(back, axis=1).max() > 0.035:
            # Once more, by some of that farther or nearer.
            state.update(phase="begin", beyond=state["beyond"] + 0.5 * float(back.mean(axis=0) @ state["ahead"]))
        return go(view, state["end"], False, 0.5)
