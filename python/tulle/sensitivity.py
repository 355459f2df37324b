"""Derivatives of what a simulation comes to, by finite differences over worlds that step together, each with its error.

>>> def build(values):
...     world = tulle.World(quality="exact", paper={"cg_tolerance": 1e-10})
...     world.add_cloth(sheet, pins=[tulle.Pin([0, 19])], material={"area_density": values["density"]})
...     return world
>>> rollout = Rollout(build, lambda world: world.cloths[0].positions[-1], time_step=0.02, steps=50)
>>> found = differentiate(rollout, {"density": 0.15})
>>> found.jacobian["density"], found.error["density"], found.is_smooth["density"]

Whatever `build` and `control` use can be a parameter: fields of a material, places and velocities at the start, forces, where
grippers go. A simulation with contact is not smooth everywhere: a vertex that sticks may slide, one that misses may touch. So
no single difference is believed. Central differences of several steps are compared, and extrapolated to the step 0; how far
these estimates lie apart is the error that is told.

Based on: Ridders 1982, Accurate computation of F'(x) and F'(x) F''(x), for the extrapolation and the choice of an estimate. We
add what tells rounding, truncation and kinks apart.
"""
from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tulle.errors import Error, InvalidArgumentError
from tulle.world import World, step_worlds

Doubles = NDArray[np.float64]
Values = Mapping[str, Any]

LEVELS = 4
"""Steps that are compared, each half of the one before."""
_BATCH = 64  # worlds that are alive at a time


@dataclass(frozen=True)
class Rollout:
    """A simulation as a function of parameters."""

    build: Callable[[Values], World]
    """Makes the world of given parameters, not stepped yet; each call makes a new one, and the same for the same values."""
    measure: Callable[[World], ArrayLike]
    """The numbers that are wanted of a world, as many for any parameters."""
    time_step: float
    """[s]"""
    steps: int
    """How many steps are made."""
    control: Optional[Callable[[World, int, Values], None]] = None
    """Acts before each step, whose number it gets, from 0."""
    measured_after: Sequence[int] = field(default=())
    """Numbers of steps after which to measure, ascending, 0: the start; none: after the last one."""

    def __post_init__(self) -> None:
        if isinstance(self.steps, bool) or not isinstance(self.steps, (int, np.integer)) or self.steps < 0:
            raise InvalidArgumentError(f"steps is {self.steps!r}; it should be a whole number from 0")
        after = list(self.measured_after)
        if after != sorted(set(after)) or (after and not 0 <= after[0] <= after[-1] <= self.steps):
            raise InvalidArgumentError(f"measured_after should ascend within 0 .. {self.steps}, not be {after}")

    def run(self, parameters: Sequence[Values], threads: int = 0) -> Doubles:
        """What is measured for each of the parameters: (parameters, numbers). Their worlds step together.

        threads: 0: one per processor; no result depends on it.

        Raises the error of a step that fails.
        """
        rows: list[Doubles] = []
        for first in range(0, len(parameters), _BATCH):
            rows += self._run_batch(parameters[first:first + _BATCH], threads)
        if len({row.size for row in rows}) > 1:
            raise InvalidArgumentError("measure gave different numbers of values for different parameters")
        return np.array(rows)

    def _run_batch(self, parameters: Sequence[Values], threads: int) -> list[Doubles]:
        worlds: list[World] = []
        try:
            for values in parameters:
                worlds.append(self.build(values))
            after = set(self.measured_after) or {self.steps}
            parts: list[list[Doubles]] = [[] for _ in worlds]
            for step in range(self.steps + 1):
                if step in after:
                    for world, part in zip(worlds, parts):
                        part.append(self._measure(world))
                if step == self.steps:
                    break
                if self.control is not None:
                    if step == 0:
                        for world in worlds:
                            world.start()
                    for world, values in zip(worlds, parameters):
                        self.control(world, step, values)
                for report in step_worlds(worlds, self.time_step, threads):
                    if isinstance(report, Error):
                        raise report
            return [np.concatenate(part) for part in parts]
        finally:
            for world in worlds:
                world.close()

    def _measure(self, world: World) -> Doubles:
        values = np.array(self.measure(world), np.float64).reshape(-1)
        if not np.isfinite(values).all():
            raise InvalidArgumentError("measure gave numbers that are not finite")
        return values


@dataclass(frozen=True)
class Sensitivity:
    """Derivatives of what was measured, by name of the parameter: arrays (numbers, *shape of the parameter)."""

    values: Doubles
    """What was measured at the parameters themselves."""
    jacobian: dict[str, Doubles]
    """The derivatives."""
    error: dict[str, Doubles]
    """How far each may be off: an estimate, no bound. It is large where `is_smooth` is false."""
    is_smooth: dict[str, NDArray[np.bool_]]
    """Whether the estimates of different steps agree. Where they do not, a contact comes, goes, sticks or slides within the
    steps, or rounding hides the derivative: believe no derivative there, but choose another step or a smoother measure."""
    is_rounding: dict[str, NDArray[np.bool_]]
    """Whether the error is one of rounding, for which a larger step is better; else of truncation, for which a smaller
    one is."""
    differences: dict[str, Doubles]
    """The central differences themselves, first those of the largest step: (levels, numbers, *shape)."""
    steps: dict[str, Doubles]
    """The largest step of each parameter, in its shape."""

    def get_matrix(self) -> Doubles:
        """All derivatives as a matrix (numbers, parameters), in the order of the parameters."""
        return _join(self.jacobian)

    def get_errors(self) -> Doubles:
        """All errors in the same order."""
        return _join(self.error)


def _join(parts: Mapping[str, Doubles]) -> Doubles:
    return np.concatenate([part.reshape(part.shape[0], -1) for part in parts.values()], axis=1)


def differentiate(rollout: Rollout, values: Values, *, relative_step: float = 0.02, steps: Optional[Values] = None,
                  tolerance: float = 0.05, threads: int = 0) -> Sensitivity:
    """Derivatives at `values`: parameters by name, each a number or an array.

    It makes 2 * LEVELS simulations for each number of the parameters. The largest step is `relative_step` of a number, or
    what `steps` says by name, which a number that is 0 needs; the others are a half, a fourth and an eighth of it.
    tolerance: estimates agree that differ by less than this part of the derivative, or of a hundredth of the largest one of
    the same parameter. threads: 0: one per processor; no result depends on it. Raises InvalidArgumentError, and the error
    of a step that fails.
    """
    base = {name: np.asarray(value, np.float64) for name, value in values.items()}
    largest = {name: _choose_steps(name, value, relative_step, steps) for name, value in base.items()}
    if steps is not None:
        unknown = [name for name in steps if name not in base]
        if unknown:
            raise InvalidArgumentError(f"steps names \"{unknown[0]}\"; the parameters are {', '.join(base)}")
    runs: list[Values] = [values]
    for name, value in base.items():
        for index in np.ndindex(value.shape):
            for level in range(LEVELS):
                for sign in (1.0, -1.0):
                    runs.append({**values, name: _shift(value, index, sign * largest[name][index] / 2**level)})
    measured = rollout.run(runs, threads)
    place = 1
    out: dict[str, dict[str, Any]] = {key: {} for key in ("jacobian", "error", "is_smooth", "is_rounding", "differences")}
    for name, value in base.items():
        pairs = measured[place:place + 2 * LEVELS * value.size].reshape(value.size, LEVELS, 2, -1)
        place += 2 * LEVELS * value.size
        widths = largest[name].reshape(-1, 1, 1) / 2.0 ** np.arange(LEVELS).reshape(1, -1, 1)
        differences = (pairs[:, :, 0] - pairs[:, :, 1]) / (2 * widths)
        floor = 8 * np.finfo(float).eps * np.abs(pairs).max(axis=(1, 2)) / widths[:, -1]
        shape = (-1, *value.shape)
        # Where the function has a kink at the parameter itself, central differences agree; those to either side do not.
        bends = np.abs(pairs[:, :, 0] + pairs[:, :, 1] - 2 * measured[0]) / widths
        for key, part in zip(out, _judge(differences, bends, floor, tolerance)):
            out[key][name] = np.moveaxis(part, 0, -1).reshape(shape)
        out["differences"][name] = np.moveaxis(differences, 0, -1).reshape(LEVELS, -1, *value.shape)
    return Sensitivity(values=measured[0], steps=largest, **out)


def _choose_steps(name: str, value: Doubles, relative_step: float, steps: Optional[Values]) -> Doubles:
    if steps is not None and name in steps:
        chosen = np.broadcast_to(np.asarray(steps[name], np.float64), value.shape).copy()
    else:
        chosen = relative_step * np.abs(value)
    if not (np.isfinite(chosen).all() and (chosen > 0).all()):
        raise InvalidArgumentError(f"the step of \"{name}\" should be above 0: say with steps={{\"{name}\": ...}} how large a "
                                   "change of it is small, since a part of 0 is none")
    return chosen


def _shift(value: Doubles, index: tuple[int, ...], change: float) -> Any:
    if not value.shape:
        return float(value) + change
    shifted = value.copy()
    shifted[index] += change
    return shifted


def _judge(differences: Doubles, bends: Doubles, floor: Doubles, tolerance: float) -> tuple[Any, ...]:
    """The best estimate, its error, whether the estimates agree, and whether the error is one of rounding.

    differences: (parameters, levels, numbers), first those of the largest step. bends: how far the differences to either side
    lie apart, alike. floor: what rounding of what was measured can change in the difference of the smallest step.
    """
    best, error = differences[:, -1].copy(), np.full_like(differences[:, -1], np.inf)
    row = [differences[:, level] for level in range(LEVELS)]
    # Neville's table: each column takes one more even power of the step away.
    for order in range(1, LEVELS):
        factor = 4.0**order
        following = [(factor * row[i + 1] - row[i]) / (factor - 1) for i in range(len(row) - 1)]
        for i, estimate in enumerate(following):
            apart = np.maximum(np.abs(estimate - row[i + 1]), np.abs(estimate - row[i]))
            is_better = apart < error
            best, error = np.where(is_better, estimate, best), np.where(is_better, apart, error)
        row = following
    error = np.maximum(error, floor)
    changes = np.abs(np.diff(differences, axis=1))
    # Of a smooth function they shrink to a quarter with each halving; those of rounding grow.
    is_rounding = (changes[:, -1] > 0.5 * changes[:, -2]) | (error <= floor)
    reference = np.maximum(np.abs(best), 0.01 * np.abs(best).max(axis=1, keepdims=True))
    spread = differences.max(axis=1) - differences.min(axis=1)
    # Of a smooth function central differences draw together to a quarter with each halving of the step, those to both sides to
    # a half. Where the largest step reaches across a kink they do so at once, or not at all.
    draws = (changes[:, 1:] <= changes[:, :-1] / 2) & (changes[:, 1:] >= changes[:, :-1] / 16)
    agree = (error <= tolerance * reference) & ((spread <= 2 * tolerance * reference) | draws.all(axis=1))
    agree &= (bends[:, -1] <= 2 * tolerance * reference) | (bends[:, -1] <= bends[:, 0] / 4)
    is_smooth = agree | ((spread == 0) & (bends[:, -1] == 0))  # the latter: nothing depends on the parameter
    error = np.where(is_smooth, error, np.maximum(error, np.maximum(spread, bends[:, -1])))
    return best, error, is_smooth, is_rounding
