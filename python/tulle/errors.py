"""Exceptions. Each status of the library has a class; all are `Error`.

>>> try:
...     tulle.Scene("scene.yaml")
... except tulle.Error as error:
...     print(error.file, error.line, error.column, error.message)
"""
from __future__ import annotations

from typing import Any

from tulle._library import core, ffi


class Error(Exception):
    """A call of the library failed. It changed nothing, unless its description says otherwise."""

    message: str
    """What is wrong and what to do about it, without file and line."""
    file: str
    """Path of the file that caused the error; empty if none did."""
    line: int
    """Line in that file, from 1; 0 if there is none."""
    column: int
    """Column in that line, from 1; 0 if there is none."""

    def __init__(self, message: str, file: str = "", line: int = 0, column: int = 0) -> None:
        self.message, self.file, self.line, self.column = message, file, line, column
        place = ":".join(str(part) for part in (file, line, column) if part)
        super().__init__(f"{place}: {message}" if place else message)

    def __reduce__(self) -> tuple[type[Error], tuple[str, str, int, int]]:
        return type(self), (self.message, self.file, self.line, self.column)


class InvalidArgumentError(Error, ValueError):
    """A value is out of its range, an array has another shape, or an object is not there any more."""


class ClosedError(InvalidArgumentError):
    """The world, the run or the detector was closed."""


class StaleError(InvalidArgumentError):
    """An array of a state that the world has left is read."""


class BusyError(Error, RuntimeError):
    """Two threads use one world, or one detector, at the same time."""


class OutOfMemoryError(Error, MemoryError):
    """There is no memory left, or the limit of the world's allocator was met."""


class FileError(Error, OSError):
    """A file could not be opened, read, written or renamed."""

    def __init__(self, message: str, file: str = "", line: int = 0, column: int = 0) -> None:
        Error.__init__(self, message, file, line, column)

    def __str__(self) -> str:
        return str(self.args[0])


class DiskFullError(FileError):
    """The disk filled up while a file was being written."""


class ParseError(Error, ValueError):
    """The text or the bytes of a file do not follow its format."""


class InvalidMeshError(Error, ValueError):
    """Indices, topology or coordinates of a mesh cannot be used."""


class IntersectingStartError(Error):
    """Cloth intersects something at the start, or something was added into it."""


class PinchedError(Error):
    """Obstacles leave cloth no room. The world is as it was before the step."""


class StepFailedError(Error):
    """The step found no state without an intersection. The world is as it was before it."""


class LimitError(Error):
    """A documented limit of size would be exceeded."""


class InterruptedError(Error):  # noqa: A001 - the library's own word
    """The call was asked to stop by `World.interrupt`."""


class UnsupportedError(Error):
    """What is asked for is valid, but this build cannot do it."""


class ProgramError(Error):
    """The program `tulle` ended with an error, or is not there."""

    exit_code: int
    """Exit code of the program; -1: it did not run."""

    def __init__(self, message: str, exit_code: int = -1) -> None:
        super().__init__(message)
        self.exit_code = exit_code

    def __reduce__(self) -> Any:
        return type(self), (self.message, self.exit_code)


_CLASSES: list[type[Error]] = [
    Error, InvalidArgumentError, OutOfMemoryError, FileError, DiskFullError, ParseError, InvalidMeshError,
    IntersectingStartError, PinchedError, StepFailedError, LimitError, InterruptedError, UnsupportedError]


def make_error_buffer() -> Any:
    """A `tulle_error` for a call to fill in."""
    return ffi.new("tulle_error *")


def make_exception(status: int, error: Any) -> Error:
    """The exception of a status that is none of success, and of what the call wrote to `error`."""
    message = ffi.string(error.message).decode(errors="replace") or ffi.string(core.tulle_status_text(status)).decode()
    made: type[Error] = _CLASSES[status] if 0 < status < len(_CLASSES) else Error
    return made(message, ffi.string(error.file).decode(errors="replace"), error.line, error.column)


def check(status: int, error: Any) -> None:
    """Raises the exception of a status, unless it is success."""
    if status:
        raise make_exception(status, error)
