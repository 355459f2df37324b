"""What holds a handle of the library, for one thread at a time."""
from __future__ import annotations

import threading
from typing import Any

from tulle.errors import BusyError


class Unique:
    """The base of what releases a handle of the library: a copy would release it a second time."""

    def __reduce__(self) -> Any:
        raise TypeError(f"a {type(self).__name__} can be neither copied nor pickled")


def take_turn(lock: threading.Lock, what: str) -> threading.Lock:
    """`lock`, for `with`, which takes it in such a way that Ctrl-C cannot leave it locked. Raises BusyError."""
    if lock.locked():
        raise BusyError(f"{what} is in use by another thread, or by the call that calls back: use one thread at a time")
    return lock
