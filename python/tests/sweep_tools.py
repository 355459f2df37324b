"""What the tests of sweeps share: a small scene, calls of the program and of `python -m tulle.sweep`, plain runs to compare with."""
from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, Callable, Optional

import pytest
import tulle
from tulle._find_program import find_program

PACKAGES = Path(tulle.__file__).resolve().parents[1]

SCENE = """
time: {step: 0.01 s, frames: 6, steps_per_frame: 2}
cloth:
  - name: sheet
    mesh: {shape: rectangle, size: [0.4, 0.4], resolution: [12, 12]}
    translate: [0.02, 0.01, 0.16]
obstacles:
  - mesh: {shape: plane, size: [2, 2]}
  - mesh: {shape: tetrahedron, radius: 0.05, height: 0.14}
    translate: [-0.05, 0, 0.001]
"""
FRICTION = 'friction: {path: "cloth[0].material.friction", grid: [0.1, 0.2, 0.4]}'
DAMPING = 'damping: {path: "cloth[0].material.air_damping", grid: [0.1, 0.5]}'


def get_program() -> Path:
    """The program; skips the test where there is none."""
    try:
        return find_program()
    except FileNotFoundError as error:
        pytest.skip(str(error))


def make_sweep(folder: Path, *parameters: str, more: str = "", scene: str = SCENE) -> Path:
    """Writes scene.yaml and sweep.yaml; the sweep goes into the folder `out` beside them."""
    (folder / "scene.yaml").write_text(scene)
    lines = "\n".join(f"  {one}" for one in parameters or (FRICTION, DAMPING))
    path = folder / "sweep.yaml"
    path.write_text(f"scene: scene.yaml\noutput: out\n{more}\nparameters:\n{lines}\n")
    return path


def get_environment(**more: str) -> dict[str, str]:
    return dict(os.environ, PYTHONPATH=str(PACKAGES), TULLE=str(get_program()), **more)


def start(*arguments: object, **more: str) -> subprocess.Popen[str]:
    """Starts `python -m tulle.sweep` as the leader of a group of its own."""
    return subprocess.Popen([sys.executable, "-m", "tulle.sweep", *map(str, arguments)], env=get_environment(**more), text=True,
                            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True)


def call(*arguments: object, code: int = 0, timeout: float = 300, **more: str) -> str:
    """Calls `python -m tulle.sweep`; returns what it prints, both streams. Fails where the exit code is another one."""
    child = start(*arguments, **more)
    try:
        out, err = child.communicate(timeout=timeout)
    except subprocess.TimeoutExpired:
        os.killpg(child.pid, signal.SIGKILL)
        out, err = child.communicate()
        raise AssertionError(f"took more than {timeout} s\n{out}\n{err}") from None
    assert child.returncode == code, f"exit code {child.returncode}, not {code}\n{out}\n{err}"
    return out + err


def read_table(out: Path) -> list[dict[str, str]]:
    with open(out / "table.csv", newline="") as stream:
        return list(csv.DictReader(stream))


def read_record(out: Path, number: int) -> dict[str, Any]:
    return json.loads((out / "records" / f"{number:04d}.json").read_text())


def find_states(out: Path) -> list[str]:
    return [json.loads(path.read_text())["state"] for path in sorted((out / "records").glob("[0-9]*.json"))]


def run_plainly(scene: Path, folder: Path, settings: list[list[str]], frames: Optional[int] = None) -> str:
    """The state hash after a run by the program alone, without a pause."""
    command = [str(get_program()), "run", str(scene), "-o", str(folder), "-t", "1", "--progress", "none"]
    command += ["-n", str(frames)] if frames else []
    for path, text in settings:
        command += ["--set", f"{path}={text}"]
    subprocess.run(command, check=True, capture_output=True)
    return (folder / "frames.csv").read_text().splitlines()[-1].split(",")[3]


def check_hashes(out: Path, scene: Path, folder: Path) -> None:
    """Every run of the sweep ended in the state of a plain run with the same settings."""
    rows = read_table(out)
    assert rows
    for row in rows:
        record = read_record(out, int(row["run"]))
        expected = run_plainly(scene, folder / f"plain{row['run']}", record["settings"], record["frames"])
        assert row["state_hash"] == expected, row


def wait_until(is_so: Callable[[], bool], what: str, seconds: float = 300) -> None:
    end = time.monotonic() + seconds
    while not is_so():
        assert time.monotonic() < end, f"waited {seconds} s for {what}"
        time.sleep(0.05)


def count_frames(out: Path, number: int) -> int:
    """Whole frames of a run under way."""
    try:
        return (out / "runs" / f"{number:04d}" / "frames.csv").read_text().count("\n") - 1
    except OSError:
        return 0
