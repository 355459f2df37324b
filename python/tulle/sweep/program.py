"""Finds the program `tulle`, and asks it."""
from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Optional

from .. import _find_program
from .problems import SweepError


def find_program(given: Optional[str]) -> Path:
    """The program; SweepError where it is not there."""
    try:
        return _find_program.find_program(given)
    except FileNotFoundError as error:
        raise SweepError(str(error)) from None


def get_package_path() -> str:
    """What PYTHONPATH must hold for `python -m tulle.sweep` to find this package."""
    return str(_find_program.PACKAGE.parent)


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
