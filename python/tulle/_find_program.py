"""Finds the program `tulle`. It needs nothing but Python, so that sweeps can be planned where the libraries are not."""
from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import Optional

PACKAGE = Path(__file__).resolve().parent
FILE_NAME = "tulle.exe" if os.name == "nt" else "tulle"


def _find_on_path(name: str) -> Optional[Path]:
    """Not in the present folder, where Windows looks first, nor in folders of PATH that depend on it."""
    for folder in os.get_exec_path():
        if os.path.isabs(folder):
            found = shutil.which(os.path.join(folder, name))
            if found:
                return Path(found)
    return None


def find_program(given: Optional[str] = None) -> Path:
    """The program that is given, or that the environment variable TULLE names, or of the package, of its build directory, or
    in a folder of PATH, never in the present folder. Raises FileNotFoundError, which says what to do."""
    for name, source in ((given, "--program"), (os.environ.get("TULLE"), "the environment variable TULLE")):
        if name:
            chosen = shutil.which(name) if os.path.dirname(name) else _find_on_path(name)
            if not chosen:
                raise FileNotFoundError(f"{source} names {name}, which is no program that can be run")
            return Path(chosen).resolve()
    for path in (PACKAGE / "bin" / FILE_NAME, PACKAGE.parents[1] / FILE_NAME):
        if path.is_file() and os.access(path, os.X_OK):
            return path.resolve()
    found = _find_on_path(FILE_NAME)
    if not found:
        raise FileNotFoundError("the program tulle is neither in the package nor on PATH; the environment variable TULLE says "
                                "where it is")
    return found.resolve()
