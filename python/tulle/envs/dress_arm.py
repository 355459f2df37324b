"""The task "dress-arm": two grippers pull a sleeve over an arm."""
from __future__ import annotations

import numpy as np

from tulle.envs.policy import Doubles, Policy, State, View, go
from tulle.envs.task import Options, Task, add_table
from tulle.mesh import Mesh, make_shape


class DressArm(Task):
    """A sleeve hangs from two grippers before an arm that is stretched out; the arm is to go through it.

    Done: four fifths of the sleeve's rings go round the arm. A ring is one of the loops around of which the sleeve's mesh is
    made; it goes round the arm if its angle about the arm's axis adds up to a whole turn, and it lies behind the tip. As cloth
    cannot pass through the arm, the arm is then in the sleeve. The score is the part of the rings that do. Features: the tip of
    the arm (3), the direction from there to the shoulder (3).
    """

    NAME, LENGTH, SETTLE, FEATURES = "dress-arm", 100, 30, 6
    SLEEVE, WIDTH = 0.24, 0.065  # [m] length and radius
    ARM, RADIUS = 0.4, 0.034
    LOW, HIGH = (-0.6, -0.5, 0.05), (0.6, 0.5, 0.9)
    CAMERA = "orbit=70deg,20deg"

    @classmethod
    def _get_size(cls, options: Options) -> tuple[int, int]:
        return options.resolution + 4, max(4, options.resolution - 2)

    @classmethod
    def count_vertices(cls, options: Options) -> int:
        around, along = cls._get_size(options)
        return around * along

    def build(self) -> None:
        turn, rise = self.random.uniform(-0.3, 0.3), self.random.uniform(-0.1, 0.2)
        self._axis = np.array([np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)])
        self._side = np.array([-np.sin(turn), np.cos(turn), 0.0])
        self._up = np.cross(self._axis, self._side)
        self._tip = np.array([-0.1, 0.0, 0.5]) + self.random.uniform(-0.03, 0.03, 3)
        self.world.add_obstacle(self._make_arm(), name="arm", friction=0.15)
        add_table(self.world)
        self._around, self._along = self._get_size(self.options)
        tube = make_shape("tube", radius=self.WIDTH, height=self.SLEEVE, resolution=(self._around, self._along))
        rows = tube.positions - [0, 0, self.SLEEVE / 2]  # the leading rim at 0, the rest behind it
        axes = np.array([self._up, -self._side, self._axis])
        shift = self.random.uniform([0.02, -0.03, -0.03], [0.06, 0.03, 0.03])
        rim = self._tip - shift[0] * self._axis + shift[1] * self._side + shift[2] * self._up
        rows = rows @ axes + rim
        self.add_cloth(Mesh(rows, tube.triangles))
        self.features = np.concatenate([self._tip, self._axis])
        for sign in (1.0, -1.0):
            across = (rows - rim) @ (sign * self._side)
            held = np.flatnonzero((across > 0.6 * self.WIDTH) & (np.arange(len(rows)) < self._around))
            self.add_gripper(rim + sign * self.WIDTH * self._side).hold(held)

    def _make_arm(self) -> Mesh:
        """A capsule from the tip to the shoulder: a sphere of which one half is moved along."""
        ball = make_shape("sphere", radius=self.RADIUS, resolution=5)
        along = ball.positions @ self._axis
        far = np.where(along > 0, self.ARM, 0.0)[:, None] * self._axis
        return Mesh(ball.positions + far + self._tip + self.RADIUS * self._axis, ball.triangles)

    def begin(self) -> None:
        """The grippers hold the sleeve from the start."""

    def measure(self) -> tuple[float, bool]:
        offsets = np.array(self.cloth.positions) - self._tip
        rings = offsets.reshape(self._along, self._around, 3)
        depth, angle = rings @ self._axis, np.arctan2(rings @ self._up, rings @ self._side)
        steps = np.diff(angle, axis=1, append=angle[:, :1])
        turns = np.round((np.mod(steps + np.pi, 2 * np.pi) - np.pi).sum(axis=1) / (2 * np.pi))
        score = float(((np.abs(turns) == 1) & (depth.min(axis=1) > 0)).mean())
        return score, score >= 0.8


class DressArmPolicy(Policy):
    """Holds the rim around the arm's axis and pulls it along."""

    task = DressArm

    def decide(self, view: View, state: State) -> Doubles:
        tip, axis = view["features"][:3], view["features"][3:]
        middle = view["grippers"].mean(axis=0)
        depth = float((middle - tip) @ axis)
        off = middle - tip - depth * axis
        if state["phase"] == "begin" and np.linalg.norm(off) > 0.01:
            return go(view, view["grippers"] - off, True, 0.4)
        state["phase"] = "pull"
        return go(view, view["grippers"] - off + 0.02 * axis, True, 0.5)
