"""Fits what cloth is made of to where it was seen, or to any residual.

>>> def build(material):
...     world = tulle.World()
...     world.add_cloth(sheet, material=material, pins=[tulle.Pin(corners)])
...     return world
>>> found = tulle.fit_material(build, {"warp.stiffness": (100, 1e5)}, {100: positions}, time_step=0.02)
>>> found.values["warp.stiffness"], found.uncertainties["warp.stiffness"]

The method is that of Levenberg and Marquardt on the logarithms of the values, within their bounds. Derivatives are those of
`tulle.sensitivity`.

Based on: Levenberg 1944; Marquardt 1963; Nocedal & Wright 2006, Numerical optimization, 10.3. We try several dampings at a
time, as their worlds step together.
"""
from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tulle import structs
from tulle._structs import refuse_unknown
from tulle.errors import InvalidArgumentError
from tulle.sensitivity import Rollout, Values, differentiate
from tulle.world import World, make_material

Doubles = NDArray[np.float64]
Name = Union[str, tuple[str, ...]]
Observations = Mapping[int, ArrayLike]

_DAMPINGS = (1e-6, 1e-3, 1e-1, 10.0)  # parts of the diagonal that are tried at a time
_MOST = 1.5  # by which a logarithm changes at most in a round
_STEP = 0.02  # of a logarithm, in differences
_SETTLED = 1e-4  # change of all logarithms, or part of the sum of squares, below which the search ends


@dataclass(frozen=True)
class Fit:
    """What fits."""

    material: structs.Material
    """The material."""
    values: dict[Name, float]
    """The values that were looked for; of fields that change together, that of the first."""
    uncertainties: dict[Name, float]
    """Standard deviation of each value, by the noise of what was seen and by the error of the derivatives; inf: not known."""
    correlation: Doubles
    """(values, values) Correlation of the logarithms of the values. Near 1 or -1: only the ratio or the product is known."""
    residuals: Doubles
    """What is left: simulated minus seen, or what `residual` gave."""
    noise: float
    """Standard deviation of a residual: that which was given, or that of what is left."""
    rounds: int
    """Rounds that the search took."""
    has_settled: bool
    """Whether the search came to its end, not to its most rounds."""
    at_bounds: tuple[Name, ...]
    """Values that lie at a bound: the uncertainty of those means little."""
    is_smooth: bool
    """Whether the derivatives at the end agree over different steps, see tulle.sensitivity."""


def fit_material(build: Callable[[structs.Material], World], fields: Mapping[Name, tuple[float, float]],
                 observations: Optional[Observations] = None, *, time_step: float, steps: Optional[int] = None,
                 material: Union[structs.Material, str] = "cotton",
                 residual: Optional[Callable[[World], ArrayLike]] = None,
                 control: Optional[Callable[[World, int], None]] = None, noise: Optional[float] = None,
                 max_rounds: int = 30, starts: int = 24, threads: int = 0) -> Fit:
    """Finds the values of `fields` with which the simulation comes nearest to what was seen.

    build: makes the world of a material, always the same for the same one. fields: the least and the largest value by name,
    both above 0, as "area_density" or "warp.stiffness"; a tuple of names for fields that keep their ratio, as ("bend_warp",
    "bend_weft"). The others, and where the search begins, are those of `material`.
    observations: where the vertices of the first cloth were seen [m] (vertices, 3) by the number of steps after which;
    places that are not known are NaN. Or residual: numbers of a world after `steps` steps that should all be 0. control:
    acts before each step. time_step: [s] of a step. max_rounds: most rounds of the search. threads: 0: one per processor;
    no result depends on it. noise: standard deviation of what was seen; None: that of what is left at the end. starts: how
    many places that are spread over the bounds are tried first, with that of `material`; the search continues from the best
    two.

    Raises InvalidArgumentError, and the error of a step that fails.
    """
    start = make_material(material) if isinstance(material, str) else material
    names = list(fields)
    if not names:
        raise InvalidArgumentError("there are no fields to fit")
    bounds = np.array([_check_bounds(name, fields[name], start) for name in names])
    if (observations is None) == (residual is None):
        raise InvalidArgumentError("give either observations or residual")
    if noise is not None and not noise > 0:
        raise InvalidArgumentError(f"noise is {noise!r}; it should be above 0")
    begin = np.array([_get(start, name) for name in names])
    if not ((bounds[:, 0] <= begin) & (begin <= bounds[:, 1])).all():
        begin = np.where((bounds[:, 0] <= begin) & (begin <= bounds[:, 1]), begin, np.sqrt(bounds[:, 0] * bounds[:, 1]))

    def make(logarithms: Doubles) -> structs.Material:
        made = start
        for name, value in zip(names, np.exp(logarithms)):
            made = _set(made, start, name, float(value))
        return made

    rollout, seen = _make_rollout(lambda values: build(make(np.asarray(values["x"]))), observations, residual, control,
                                  time_step, steps)
    is_seen: Any = np.isfinite(seen) if observations is not None else slice(None)

    def run(rows: Sequence[Doubles]) -> Doubles:
        return (rollout.run([{"x": row} for row in rows], threads) - seen)[:, is_seen]

    places = _spread_starts(np.log(begin), np.log(bounds), starts)
    order = np.argsort([float(row @ row) for row in run(places)], kind="stable")[:2]
    searches = [_search(run, places[i], np.log(bounds), max_rounds) for i in order]
    x, left, rounds, has_settled = min(searches, key=lambda found: float(found[1] @ found[1]))
    if left.size <= len(names):
        raise InvalidArgumentError(f"{left.size} numbers were seen; {len(names)} values take more")
    found = differentiate(rollout, {"x": x}, steps={"x": np.full(len(names), _STEP)}, threads=threads)
    jacobian, errors = found.jacobian["x"][is_seen], found.error["x"][is_seen]
    deviation = noise if noise is not None else float(np.sqrt(left @ left / (left.size - len(names))))
    spread, correlation = _get_spread(jacobian, errors, left, deviation)
    values = np.exp(x)
    at_bounds = tuple(name for name, value, bound in zip(names, x, np.log(bounds)) if np.abs(bound - value).min() < 1e-9)
    # Only what matters to the fit counts.
    weight = np.abs(jacobian) > 0.1 * np.abs(jacobian).max(axis=0)
    return Fit(make(x), dict(zip(names, values.tolist())), dict(zip(names, (values * spread).tolist())), correlation, left,
               deviation, rounds, has_settled, at_bounds, bool((found.is_smooth["x"][is_seen] | ~weight).all()))


def _make_rollout(build: Callable[[Values], World], observations: Optional[Observations],
                  residual: Optional[Callable[[World], ArrayLike]], control: Optional[Callable[[World, int], None]],
                  time_step: float, steps: Optional[int]) -> tuple[Rollout, Doubles]:
    """The simulation as a function of the logarithms, and what was seen."""
    def act(world: World, step: int, values: Values) -> None:
        assert control is not None
        control(world, step)

    acts = act if control is not None else None
    if observations is None:
        if steps is None:
            raise InvalidArgumentError("steps says after how many steps residual is asked")
        assert residual is not None
        return Rollout(build, residual, time_step, steps, acts), np.zeros(1)
    if not observations:
        raise InvalidArgumentError("there are no observations")
    after = sorted(observations)
    if steps is not None and steps != after[-1]:
        raise InvalidArgumentError(f"steps is {steps}; the last observation is after {after[-1]}")
    seen = [np.asarray(observations[step], np.float64) for step in after]
    for step, each in zip(after, seen):
        if each.ndim != 2 or each.shape[1] != 3:
            raise InvalidArgumentError(f"what was seen after step {step} should have the shape (vertices, 3), not {each.shape}")

    def measure(world: World) -> Doubles:
        positions = np.array(world.cloths[0].positions)
        if any(each.shape != positions.shape for each in seen):
            raise InvalidArgumentError(f"observations should have the shape {positions.shape}, as the first cloth")
        return positions

    return Rollout(build, measure, time_step, after[-1], acts, after), np.concatenate([each.reshape(-1) for each in seen])


def _spread_starts(begin: Doubles, bounds: Doubles, count: int) -> list[Doubles]:
    """The start, and `count` places spread evenly between the bounds: multiples of irrational steps (Roberts 2018)."""
    root = 2.0
    for _ in range(60):
        root = (1 + root) ** (1 / (len(begin) + 1))
    steps = root ** -np.arange(1.0, len(begin) + 1)
    shares = [(0.5 + i * steps) % 1 for i in range(count)]
    return [begin, *(bounds[:, 0] + share * (bounds[:, 1] - bounds[:, 0]) for share in shares)]


def _search(run: Callable[[Sequence[Doubles]], Doubles], x: Doubles, bounds: Doubles,
            max_rounds: int) -> tuple[Doubles, Doubles, int, bool]:
    """The logarithms with the least sum of squares, what is left there, how many rounds it took, and whether it settled."""
    low, high = bounds[:, 0], bounds[:, 1]
    scale, count = 1.0, len(x)
    left = run([x])[0]
    for round_ in range(1, max_rounds + 1):
        shifts = [np.where(np.arange(count) == i, sign * _STEP, 0.0) for i in range(count) for sign in (1, -1)]
        around = run([x + shift for shift in shifts])
        jacobian = (around[0::2] - around[1::2]).T / (2 * _STEP)
        slope, normal = jacobian.T @ left, jacobian.T @ jacobian
        # At a bound that the slope pushes against, a value stays.
        is_free = ~(((x <= low) & (slope > 0)) | ((x >= high) & (slope < 0)))
        if not is_free.any():
            return x, left, round_, True
        tries = []
        for damping in _DAMPINGS:
            diagonal = np.maximum(np.diag(normal), 1e-12 * max(float(np.diag(normal).max()), 1e-300))
            matrix = (normal + scale * damping * np.diag(diagonal))[np.ix_(is_free, is_free)]
            change = np.zeros(count)
            change[is_free] = np.linalg.lstsq(matrix, -slope[is_free], rcond=None)[0]
            change *= min(1.0, _MOST / max(float(np.abs(change).max()), 1e-300))
            tries.append(np.clip(x + change, low, high))
        results = run(tries)
        sums = np.einsum("ij,ij->i", results, results)
        best, before = int(sums.argmin()), float(left @ left)
        if not sums[best] < before:
            if scale >= 1e6 or max(float(np.abs(each - x).max()) for each in tries) < _SETTLED:
                return x, left, round_, True
            scale *= 100
            continue
        change_of_x = float(np.abs(tries[best] - x).max())
        gain = 1 - float(sums[best]) / before
        x, left, scale = tries[best], results[best], max(scale / 10, 1e-3)
        if change_of_x < _SETTLED or gain < _SETTLED * 1e-2:
            return x, left, round_, True
    return x, left, max_rounds, False


def _get_spread(jacobian: Doubles, errors: Doubles, left: Doubles, deviation: float) -> tuple[Doubles, Doubles]:
    """Standard deviations of the logarithms, and their correlation."""
    normal = jacobian.T @ jacobian
    size = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    scaled = normal / np.outer(size, size)
    if np.linalg.cond(scaled) > 1e12:
        return np.full(len(size), np.inf), scaled
    inverse = np.linalg.inv(scaled) / np.outer(size, size)
    variance = deviation**2 * np.diag(inverse)
    # Where a derivative is off by its error, the slope of the sum of squares is not 0 at the best values.
    wrong = np.abs(inverse) @ (errors.T @ np.abs(left) / np.sqrt(max(left.size, 1)))
    spread = np.sqrt(variance + wrong**2)
    return spread, inverse / np.sqrt(np.outer(np.diag(inverse), np.diag(inverse)))


def _list_parts(name: Name) -> tuple[str, ...]:
    return (name,) if isinstance(name, str) else tuple(name)


def _check_bounds(name: Name, bounds: Any, material: structs.Material) -> tuple[float, float]:
    for part in _list_parts(name):
        _get_one(material, part)
    row = np.asarray(bounds, np.float64)
    if row.shape != (2,) or not (np.isfinite(row).all() and 0 < row[0] < row[1]):
        raise InvalidArgumentError(f"the bounds of {name!r} are {bounds!r}; they should be a least and a largest value above 0")
    if not isinstance(name, str) and not all(_get_one(material, part) > 0 for part in name):
        raise InvalidArgumentError(f"fields that keep their ratio should be above 0 at the start: {name!r}")
    return float(row[0]), float(row[1])


def _get_one(material: structs.Material, name: str) -> float:
    value: Any = material
    for part in name.split("."):
        refuse_unknown([part], getattr(value, "_fields", ()), "the material")
        value = getattr(value, part)
    if not isinstance(value, (int, float)):
        fields = ", ".join(f"{name}.{each}" for each in value._fields)
        raise InvalidArgumentError(f"\"{name}\" is no number; its fields are {fields}")
    return float(value)


def _get(material: structs.Material, name: Name) -> float:
    return _get_one(material, _list_parts(name)[0])


def _set(material: Any, start: structs.Material, name: Name, value: float) -> Any:
    """The material with another value, and with others that keep their ratio to it."""
    for part in _list_parts(name):
        ratio = _get_one(start, part) / _get(start, name) if part != _list_parts(name)[0] else 1.0
        outer, _, inner = part.partition(".")
        made = value * ratio
        material = dataclasses.replace(material, **{outer: dataclasses.replace(getattr(material, outer), **{inner: made})
                                                    if inner else made})
    return material
