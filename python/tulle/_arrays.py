"""Arrays on their way to the library and back."""
from __future__ import annotations

from typing import Any, Optional

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from tulle._library import ffi
from tulle.errors import InvalidArgumentError, StaleError

Doubles = NDArray[np.float64]
Indices = NDArray[np.uint32]


def _describe_shape(columns: int, count: Optional[int]) -> str:
    rows = "n" if count is None else str(count)
    return f"({rows}, {columns})" if columns > 1 else f"({rows},)"


def _check_shape(array: NDArray[Any], columns: int, count: Optional[int], what: str) -> None:
    """Refuses an array that has not `columns` numbers in each of `count` rows (None: any number of rows)."""
    wanted = (array.ndim == 2 and array.shape[1] == columns) if columns > 1 else array.ndim == 1
    if not wanted or (count is not None and array.shape[0] != count):
        hint = ""
        if array.ndim == 2 and array.shape[0] == columns and array.shape[1] != columns:
            hint = "; transpose it"
        elif array.ndim == 1 and columns > 1 and array.size % columns == 0:
            hint = f"; reshape it with .reshape(-1, {columns})"
        raise InvalidArgumentError(f"{what} should have the shape {_describe_shape(columns, count)}, not {array.shape}{hint}")


def to_doubles(values: ArrayLike, columns: int, what: str, count: Optional[int] = None) -> Doubles:
    """`values` as rows of `columns` doubles without gaps: itself where it is so already, else a copy."""
    values = _strip(values)
    try:
        array = np.asarray(values)
    except ValueError as failure:
        raise InvalidArgumentError(f"{what} is no array of numbers: {failure}") from None
    if array.dtype.kind not in "fiu":
        raise InvalidArgumentError(f"{what} should hold real numbers, not {array.dtype}")
    _check_shape(array, columns, count, what)
    return np.ascontiguousarray(array, dtype=np.float64)


def to_indices(values: ArrayLike, columns: int, what: str, count: Optional[int] = None) -> Indices:
    """`values` as rows of `columns` numbers of 32 bits without gaps: itself where it is so already, else a copy."""
    values = _strip(values)
    try:
        array = np.asarray(values)
    except ValueError as failure:
        raise InvalidArgumentError(f"{what} is no array of numbers: {failure}") from None
    if array.size == 0 and array.dtype.kind == "f":
        array = array.astype(np.uint32)
    if array.dtype.kind not in "iu":
        raise InvalidArgumentError(f"{what} should hold whole numbers, not {array.dtype}; convert it with .astype(np.uint32)")
    _check_shape(array, columns, count, what)
    if array.dtype != np.uint32 and array.size and (array.min() < 0 or array.max() > 0xFFFFFFFF):
        raise InvalidArgumentError(f"{what} holds {array.min()} to {array.max()}; it should hold numbers from 0 to 4294967295")
    return np.ascontiguousarray(array, dtype=np.uint32)


def to_vector(values: ArrayLike, what: str, count: int = 3) -> Doubles:
    """`values` as `count` doubles."""
    array = to_doubles(values, 1, what)
    if array.shape[0] != count:
        raise InvalidArgumentError(f"{what} should have {count} numbers, not {array.shape[0]}")
    return array


def point_to(array: NDArray[Any], kind: str) -> Any:
    """A C pointer to an array, which must outlive the call."""
    return ffi.cast(kind, ffi.from_buffer(array)) if array.size else ffi.NULL


def copy_from(pointer: Any, count: int, dtype: Any, columns: int = 1) -> NDArray[Any]:
    """A copy of `count` rows at `pointer`."""
    shape = (count, columns) if columns > 1 else (count,)
    dtype = np.dtype(dtype)
    if not count or pointer == ffi.NULL:
        return np.empty(shape if count == 0 else (0, *shape[1:]), dtype)
    return np.frombuffer(ffi.buffer(pointer, count * columns * dtype.itemsize), dtype).reshape(shape).copy()


class Clock:
    """Numbers the states of a world; no two have the same number."""

    __slots__ = ("now", "_last")

    def __init__(self) -> None:
        self.now = self._last = 0

    def advance(self) -> int:
        """Goes on to a number that no state has had. Gives the former, to put back into `now` where the state stays."""
        former, self._last = self.now, self._last + 1
        self.now = self._last
        return former


class StateArray(np.lib.mixins.NDArrayOperatorsMixin):
    """Numbers of one state of a world, such as the positions of a cloth; read only.

    It does all that a numpy array does. Once the world has gone on, reading it raises StaleError, so that nobody computes
    with an old state by mistake; parts of it, such as `positions[:, 2]` and `positions.T`, do so as well. Ask the object again for those
    of the new state, or keep the old ones with `.copy()` or `np.array(...)` in time. What is computed from it is an ordinary array.
    """

    # It holds an array rather than being one: numpy reads an array, of a subclass too, without asking it.
    __slots__ = ("_array", "_clock", "_made")

    def __init__(self, array: NDArray[Any], clock: Clock, made: int) -> None:
        self._array, self._clock, self._made = array, clock, made

    def _plain(self) -> NDArray[Any]:
        """The ordinary array, of this state."""
        if self._clock.now != self._made:
            raise StaleError("the array is of a state that the world has left: ask the object for it again after each step, "
                             "or keep it with .copy() before the next one")
        return self._array

    def _guard(self, part: Any) -> Any:
        """Guards a view of the array as itself."""
        return StateArray(part, self._clock, self._made) if isinstance(part, np.ndarray) and part.base is not None else part

    def __array__(self, dtype: DTypeLike = None, copy: Optional[bool] = None) -> NDArray[Any]:
        array = self._plain()
        return np.array(array, dtype) if copy or (dtype is not None and dtype != array.dtype) else array.view()

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **others: Any) -> Any:
        return getattr(ufunc, method)(*_strip(inputs), **_strip(others))

    def __array_function__(self, function: Any, types: Any, arguments: Any, others: Any) -> Any:
        return function(*_strip(arguments), **_strip(others))

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(f"a StateArray has no {name}")
        return self._guard(getattr(self._array if name in ("shape", "dtype", "ndim", "size", "nbytes") else self._plain(), name))

    def __dir__(self) -> list[str]:
        return dir(self._array)

    def __getitem__(self, key: Any) -> Any:
        return self._guard(self._plain()[_strip(key)])

    def __setitem__(self, key: Any, value: Any) -> None:
        self._plain()[key] = value  # which numpy refuses

    def __len__(self) -> int:
        return len(self._array)

    def __iter__(self) -> Any:
        return iter(self._plain())

    def __contains__(self, value: Any) -> bool:
        return value in self._plain()

    def __bool__(self) -> bool:
        return bool(self._plain())

    def __float__(self) -> float:
        return float(self._plain())

    def __int__(self) -> int:
        return int(self._plain())

    def __format__(self, form: str) -> str:
        return format(self._plain(), form)

    def __repr__(self) -> str:
        return repr(self._plain())

    def __str__(self) -> str:
        return str(self._plain())

    def __reduce__(self) -> Any:
        return self._plain().copy().__reduce__()


def _strip(value: Any) -> Any:
    """Ordinary arrays in place of those of a state, within lists, tuples and dictionaries, too."""
    if isinstance(value, StateArray):
        return value._plain()
    if type(value) in (list, tuple):
        return type(value)(_strip(part) for part in value)
    if type(value) is dict:
        return {key: _strip(part) for key, part in value.items()}
    return value


def make_state_array(array: NDArray[Any], clock: Clock, made: int) -> StateArray:
    """Guards an array that nobody else holds, of the state with the number `made`."""
    array.flags.writeable = False
    return StateArray(array.view(), clock, made)  # a view, which cannot be made writeable again
