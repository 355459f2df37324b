"""The space of observations or actions: arrays of one shape between two bounds."""
from __future__ import annotations

from typing import Any, Optional

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from tulle.errors import InvalidArgumentError


class Box:
    """All arrays of `shape` with `low` <= array <= `high`, as gymnasium's Box."""

    low: NDArray[Any]
    """Lower bounds, of `shape`; -inf: none."""
    high: NDArray[Any]
    """Upper bounds, of `shape`; inf: none."""

    def __init__(self, low: ArrayLike, high: ArrayLike, shape: Optional[tuple[int, ...]] = None,
                 dtype: DTypeLike = np.float32, seed: Optional[int] = None) -> None:
        """low, high: arrays of one shape, or numbers for all of `shape`. dtype: of the arrays. seed: of `sample`.

        Raises InvalidArgumentError.
        """
        self.dtype = np.dtype(dtype)
        self.shape = np.broadcast(low, high).shape if shape is None else tuple(shape)
        try:
            self.low = np.broadcast_to(np.asarray(low, self.dtype), self.shape).copy()
            self.high = np.broadcast_to(np.asarray(high, self.dtype), self.shape).copy()
        except ValueError:
            raise InvalidArgumentError(f"low and high should have the shape {self.shape}, not {np.shape(low)} and "
                                       f"{np.shape(high)}") from None
        if not (self.low <= self.high).all():
            raise InvalidArgumentError("low should be at most high")
        self.seed(seed)

    def seed(self, seed: Optional[int] = None) -> list[int]:
        """Seeds `sample`; None: by chance. Gives the seed."""
        chosen = int(np.random.SeedSequence().generate_state(1)[0]) if seed is None else seed
        self._random = np.random.Generator(np.random.PCG64(chosen))
        return [chosen]

    def sample(self) -> NDArray[Any]:
        """An array of the space: even between two bounds, exponential beyond one, normal without any."""
        has_low, has_high = np.isfinite(self.low), np.isfinite(self.high)
        low, high = np.where(has_low, self.low, 0).astype(float), np.where(has_high, self.high, 0).astype(float)
        even = low + (high - low) * self._random.random(self.shape)
        far = self._random.exponential(size=self.shape)
        free = self._random.normal(size=self.shape)
        chosen = np.where(has_low & has_high, even, np.where(has_low, low + far, np.where(has_high, high - far, free)))
        return np.clip(chosen.astype(self.dtype), self.low, self.high)

    def contains(self, value: Any) -> bool:
        """Whether the array `value` is of the space."""
        array = np.asarray(value)
        return bool(array.shape == self.shape and np.can_cast(array.dtype, self.dtype, "same_kind")
                    and (array >= self.low).all() and (array <= self.high).all())

    __contains__ = contains

    def repeat(self, count: int) -> Box:
        """The space of `count` such arrays, one below the other."""
        shape = (count, *self.shape)
        return Box(np.broadcast_to(self.low, shape), np.broadcast_to(self.high, shape), shape, self.dtype)

    def __eq__(self, other: object) -> bool:
        return (isinstance(other, Box) and self.dtype == other.dtype and self.shape == other.shape
                and np.array_equal(self.low, other.low) and np.array_equal(self.high, other.high))

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        low, high = (f"{bound.flat[0]:g}" if bound.size and (bound == bound.flat[0]).all() else "..."
                     for bound in (self.low, self.high))
        return f"Box({low}, {high}, {self.shape}, {self.dtype})"
