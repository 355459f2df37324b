"""Finds the program `tulle`, and asks it."""
from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path
from typing import Optional

from .problems import SweepError

PACKAGE = Path(__file__).resolve().parent.parent  # the folder tulle/


def find_program(given: Optional[str]) -> Path:
    """The program that --program names, or $TULLE, or that lies in the package or in the checkout's build, or on PATH."""
    for name, source in ((given, "--program"), (os.environ.get("TULLE"), "TULLE")):
        if name:
            found = shutil.which(name)
            if not found:
                raise SweepError(f"{source}: {name} is no program that can be run")
            return Path(found).resolve()
    for path in (PACKAGE / "bin" / "tulle", PACKAGE.parent.parent / "build" / "release" / "tulle"):
        if os.access(path, os.X_OK) and path.is_file():
            return path.resolve()
    found = shutil.which("tulle")
    if not found:
        raise SweepError("the program tulle is nowhere: give --program PATH or set TULLE=PATH, or put it on PATH")
    return Path(found).resolve()


def get_package_path() -> str:
    """What PYTHONPATH must hold for `python -m tulle.sweep` to find this package."""
    return str(PACKAGE.parent)


def try_scene(program: Path, scene: Path, settings: list[list[str]]) -> str:
    """What the program says against a scene with these settings: empty if it loads it."""
    command = [str(program), "info", str(scene), "--json"]
    for path, text in settings:
        command += ["--set", f"{path}={text}"]
    try:
        done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace",
                              check=False, start_new_session=True)
    except OSError as error:
        raise SweepError(f"{program}: cannot be run: {error.strerror}") from None
    return "" if done.returncode == 0 else done.stderr.strip() or f"{program} ended with exit code {done.returncode}"
