"""Finds the program `tulle`. It needs nothing but Python, so that sweeps can be planned where the libraries are not."""
from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import Optional

PACKAGE = Path(__file__).resolve().parent


def find_program(given: Optional[str] = None) -> Path:
    """The program that is given, or that the environment variable TULLE names, or of the package, of its build directory, or
    on PATH. Raises FileNotFoundError, which says what to do."""
    for name, source in ((given, "--program"), (os.environ.get("TULLE"), "the environment variable TULLE")):
        if name:
            found = shutil.which(name)
            if not found:
                raise FileNotFoundError(f"{source} names {name}, which is no program that can be run")
            return Path(found).resolve()
    for path in (PACKAGE / "bin" / "tulle", PACKAGE.parents[1] / "tulle"):
        if path.is_file() and os.access(path, os.X_OK):
            return path.resolve()
    found = shutil.which("tulle")
    if not found:
        raise FileNotFoundError("the program tulle is neither in the package nor on PATH; the environment variable TULLE says "
                                "where it is")
    return Path(found).resolve()
