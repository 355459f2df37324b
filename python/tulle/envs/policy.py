"""The base of policies that are written by hand: they solve the tasks from what is observed."""
from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tulle.envs.task import Gripper, Task
from tulle.envs.vector import split
from tulle.errors import InvalidArgumentError

Doubles = NDArray[np.float64]
_STRIDE = Gripper.SPEED * Task.TIME_STEP * Task.STEPS  # [m] that a gripper goes along an axis with one action

State = dict[str, Any]
View = dict[str, Doubles]


class Policy:
    """Gives actions (count, ...) for observations (count, ...) of its task, of any resolution.

    It remembers how far it is in each episode, and starts again at the first observation of an episode.
    """

    task: type[Task]
    """The task that it solves."""

    def __init__(self) -> None:
        self._states: list[State] = []

    def __call__(self, observations: NDArray[Any]) -> NDArray[np.float32]:
        width = observations.shape[1] if observations.ndim == 2 else 0
        others = sum(int(np.prod(shape)) for name, shape in self.task.get_layout(0).items())
        if width < others or (width - others) % 6:
            raise InvalidArgumentError(f"these are no observations of \"{self.task.NAME}\": "
                                       f"their shape is {observations.shape}")
        parts = split(self.task.get_layout((width - others) // 6), observations.astype(np.float64))
        if len(self._states) != len(observations):
            self._states = [{} for _ in observations]
        actions = np.zeros((len(observations), 4 * self.task.GRIPPERS), np.float32)
        for i in range(len(observations)):
            view = {name: part[i] for name, part in parts.items()}
            if view["time"][0] == 0:
                self._states[i] = {"phase": "begin"}
            actions[i] = self.decide(view, self._states[i]).reshape(-1)
        return actions

    def decide(self, view: View, state: State) -> Doubles:
        """The action in one environment, a row for each gripper. `state` is kept until the episode ends."""
        raise NotImplementedError


def go(view: View, goals: Any, closes: bool, pace: float = 1.0) -> Doubles:
    """The action that moves each gripper straight to its goal, at most by `pace` of the largest velocity."""
    moves = (np.asarray(goals, float) - view["grippers"]) / _STRIDE
    longest = np.abs(moves).max(axis=1, keepdims=True)
    moves *= np.where(longest > pace, pace / np.maximum(longest, 1e-12), 1.0)
    return np.hstack([moves, np.full((len(moves), 1), 1.0 if closes else -1.0)])


def is_there(view: View, goals: Any, distance: float = 0.008) -> bool:
    """Whether all grippers are at their goals."""
    return bool((np.linalg.norm(view["grippers"] - goals, axis=1) < distance).all())


def reach(view: View, corners: Doubles) -> Doubles:
    """The action that brings grippers over their corners, then down to them, then closes them."""
    flat = np.linalg.norm((view["grippers"] - corners)[:, :2], axis=1)
    over = corners + [0, 0, 0.03]
    goals = np.where(flat[:, None] < 0.015, corners + [0, 0, 0.006], over)
    action = go(view, goals, False, 0.7)
    near = np.linalg.norm(view["grippers"] - corners, axis=1) < 0.016
    action[near | (view["holds"] > 0), 3] = 1.0
    action[view["holds"] > 0, :3] = 0.0
    return action
