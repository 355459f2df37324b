"""Finds and loads libtulle and libtulle_io, and makes sure that they are those that the package was made for."""
from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

PACKAGE = Path(__file__).resolve().parent
NAMES = {"linux": ("libtulle.so", "libtulle_io.so"), "darwin": ("libtulle.dylib", "libtulle_io.dylib"),
         "win32": ("tulle.dll", "tulle_io.dll")}

try:
    from tulle._bindings import ffi as _ffi
except ModuleNotFoundError as missing:
    if missing.name != "tulle._bindings":
        raise
    raise ImportError("tulle: these are the sources of the package. In a checkout, `make python` builds it in "
                      "build/release/python; `make wheel` makes a package to install") from missing

ffi: Any = _ffi


def _list_directories() -> list[Path]:
    """Where the libraries may be, in the order in which they are looked for."""
    chosen = os.environ.get("TULLE_LIBRARY_PATH")
    if chosen:
        return [Path(directory) for directory in chosen.split(os.pathsep) if directory]
    return [PACKAGE / "lib", PACKAGE.parents[1]]  # of a wheel, of a build directory


def _find_libraries() -> tuple[str, str]:
    """The paths of both libraries; where no directory has them, their names, for the system's loader."""
    names = NAMES.get(sys.platform, NAMES["linux"])
    for directory in _list_directories():
        if all((directory / name).exists() for name in names):
            return str(directory / names[0]), str(directory / names[1])
    if os.environ.get("TULLE_LIBRARY_PATH"):
        raise ImportError(f"tulle: TULLE_LIBRARY_PATH names no directory with {names[0]} and {names[1]}: "
                          f"{os.environ['TULLE_LIBRARY_PATH']}")
    return names


def _load() -> tuple[Any, Any]:
    """Loads both libraries. libtulle comes first, so that libtulle_io finds the same one."""
    paths = _find_libraries()
    try:
        core = ffi.dlopen(paths[0], ffi.RTLD_NOW | ffi.RTLD_GLOBAL)
        return core, ffi.dlopen(paths[1], ffi.RTLD_NOW)
    except OSError as failure:
        raise ImportError(f"tulle: the libraries cannot be loaded: {failure}. They are looked for in the package, "
                          "beside it and where the system has its libraries; the environment variable "
                          "TULLE_LIBRARY_PATH names another directory") from failure


def _check_structs() -> None:
    """Refuses libraries whose structs are laid out otherwise than the package declares them."""
    error = ffi.new("tulle_error *")
    for name in ffi.list_types()[0]:
        kind = ffi.typeof(name)
        if kind.kind != "struct" or kind.fields is None:
            continue
        if core.tulle_check_struct(name.encode(), ffi.sizeof(kind), error) != 0:
            message = ffi.string(error.message).decode()
            if "no struct" in message:  # one of libtulle_io
                continue
            raise ImportError(f"tulle: the package does not fit the library: {message}. Make both from the same sources")


core, io = _load()
try:
    _check_structs()
except ffi.error as failure:
    raise ImportError(f"tulle: the package does not fit the library: {failure}. Make both from the same sources") from None

version: str = ffi.string(core.tulle_version()).decode()
"""Version of the library: MAJOR.MINOR.PATCH."""
