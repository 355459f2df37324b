"""Reads the directory of a run: run.json, frames.csv, point caches and report.csv (docs/guide/formats.md).

A frame is whole where it has a line in frames.csv that ends and is in every cache.
"""
from __future__ import annotations

import json
import math
import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from reproduce.session import DamagedRun

FRAMES_HEAD = "frame,time,step,state_hash,absent"  # and lags, but in older runs
CACHE_HEAD = struct.Struct("<12siiffi")  # magic, version, vertices, start, rate, frames
CACHE_MAGIC = b"POINTCACHE2\0"

# The stages of a step as report.csv names them, and those of reports of format_version 1 that they hold.
STAGES = {
    "predict_paths": ("propose_paths",),
    "update_patches": ("build_patches",),
    "build_trees": ("build_trees",),
    "find_pairs": ("find_pairs",),
    "gather_rows": ("gather_contacts",),
    "compute_forces": ("compute_forces",),
    "solve_motion": ("solve_motion",),
    "resolve_impacts": ("test_pairs", "select_admissible", "resolve_impacts"),
    "commit_safely": ("commit_safely",),
    "accept_state": ("update_contacts",),
}
RESCUES = ("rescue_impact_zones", "rescue_component_scalings", "rescue_global_scalings")


@dataclass(frozen=True)
class Body:
    """A cloth or an obstacle of a run."""

    name: str
    is_obstacle: bool
    vertices: int
    triangles: int
    cache: str  # file; empty for bodies that never move


@dataclass(frozen=True)
class Frame:
    """A whole frame."""

    time: float  # [s]
    step: int  # steps done
    state_hash: str  # 16 hexadecimal digits


@dataclass(frozen=True)
class Reports:
    """Columns of report.csv, a number for each step."""

    columns: dict[str, np.ndarray]

    @property
    def count(self) -> int:
        """Steps."""
        return len(self.columns["step"])

    def get(self, name: str) -> np.ndarray:
        """A column."""
        return self.columns[name]

    def get_stage(self, stage: str) -> np.ndarray:
        """[s] of a stage in each step."""
        if "test_pairs_seconds" in self.columns:  # a report with the twelve stages of format_version 1
            return np.sum([self.columns[f"{old}_seconds"] for old in STAGES[stage]], axis=0)
        return self.columns[f"{stage}_seconds"]


@dataclass(frozen=True)
class RecordedRun:
    """What a run directory holds."""

    directory: Path
    state: str  # "running" (or killed), "finished", "interrupted", "failed"
    scene_hash: str
    time_step: float  # [s]
    bodies: list[Body]
    frames: list[Frame]

    @property
    def cloths(self) -> list[Body]:
        """Its cloths."""
        return [body for body in self.bodies if not body.is_obstacle]

    def describe(self) -> str:
        """Which frames these are, on one line: what is measured in them depends on it."""
        return f"scene {self.scene_hash} frames {len(self.frames)} last {self.frames[-1].state_hash}"

    def read_cloth(self, frame: int) -> np.ndarray:
        """Positions [m] of the vertices of all cloths, one behind the other."""
        return np.concatenate([self._read_positions(body, frame) for body in self.cloths])

    def _read_positions(self, body: Body, frame: int) -> np.ndarray:
        path = self.directory / body.cache
        try:
            positions = np.fromfile(path, dtype="<f4", count=3 * body.vertices,
                                    offset=CACHE_HEAD.size + 12 * body.vertices * frame)
        except OSError as error:
            raise DamagedRun(f"{path} cannot be read: {error.strerror}") from error
        if positions.size < 3 * body.vertices:
            raise DamagedRun(f"{path}: frame {frame} is cut short")
        if not np.isfinite(positions).all():
            raise DamagedRun(f"{path}: frame {frame}: a coordinate is not finite")
        return positions.reshape(-1, 3).astype(np.float64)

    def read_reports(self) -> Reports:
        """The reports of all steps that the frames tell of; DamagedRun where there are fewer."""
        reports = read_reports(self.directory / "report.csv")
        steps = self.frames[-1].step if self.frames else 0
        if reports.count < steps:
            raise DamagedRun(f"its report.csv tells of {reports.count} steps, its frames of {steps}")
        return reports


def is_run(directory: Path) -> bool:
    """Whether the directory holds a run.json."""
    return (directory / "run.json").is_file()


def _read_text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise DamagedRun(f"{path} cannot be opened: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise DamagedRun(f"{path} is no text") from error


def _read_frames(path: Path) -> list[Frame]:
    """The lines that end; a run that was killed while its files were made has none."""
    if not path.exists():
        return []
    lines = _read_text(path).split("\n")[:-1]
    if lines and lines[0] not in (FRAMES_HEAD, FRAMES_HEAD + ",lags"):
        raise DamagedRun(f"{path} does not begin with \"{FRAMES_HEAD}\"")
    frames = []
    for number, line in enumerate(lines[1:]):
        try:
            index, time, step, state_hash = line.split(",")[:4]
            if line.count(",") != lines[0].count(","):
                raise ValueError
            int(state_hash, 16)
            if int(index) != number:
                raise ValueError
            frames.append(Frame(float(time), int(step), state_hash))
        except ValueError as error:
            raise DamagedRun(f"{path}:{number + 2}: this should be frame {number}") from error
    return frames


def _count_cached(path: Path, vertices: int) -> int:
    """Frames in a point cache."""
    try:
        with open(path, "rb") as file:
            head = file.read(CACHE_HEAD.size)
        size = path.stat().st_size
    except OSError as error:
        raise DamagedRun(f"{path} cannot be opened: {error.strerror}") from error
    if len(head) < CACHE_HEAD.size or not head.startswith(CACHE_MAGIC):
        raise DamagedRun(f"{path} is no point cache")
    _, _, found, _, _, frames = CACHE_HEAD.unpack(head)
    if found != vertices:
        raise DamagedRun(f"{path} holds {found} vertices, but run.json says {vertices}")
    return min(frames, (size - CACHE_HEAD.size) // (12 * vertices))


def read_run(directory: Path) -> RecordedRun:
    """Opens a run directory; runs that go on or were killed are read up to their last whole frame."""
    path = directory / "run.json"
    try:
        record = json.loads(_read_text(path))
        bodies = [Body(body["name"], body["role"] != "cloth", int(body["vertices"]), int(body["triangles"]),
                       body["cache"] or "") for body in record["bodies"]]
        facts = str(record["state"]), str(record["scene_hash"]), float(record["time_step"])
    except (ValueError, KeyError, TypeError) as error:
        raise DamagedRun(f"{path} is no record of a run: {error!r}") from error
    frames = _read_frames(directory / "frames.csv")
    for body in bodies:
        if body.cache and frames:
            frames = frames[:_count_cached(directory / body.cache, body.vertices)]
    return RecordedRun(directory, *facts, bodies, frames)


def read_reports(path: Path) -> Reports:
    """The lines of report.csv that end; DamagedRun where it is not there or not a report."""
    lines = _read_text(path).split("\n")[:-1]
    if not lines:
        return Reports({"step": np.zeros(0)})
    names = lines[0].split(",")
    old = "test_pairs_seconds" in names
    stages = [name for stage, parts in STAGES.items() for name in (parts if old else (stage,))]
    wanted = ["step", "time", "total_seconds", "contacts", "stick_contacts", "slip_contacts", *RESCUES,
              *(f"{stage}_seconds" for stage in stages)]
    lacking = [name for name in wanted if name not in names]
    if lacking:
        raise DamagedRun(f"{path}:1: the heading has no column {lacking[0]}")
    rows = np.empty((len(lines) - 1, len(names)))
    for number, line in enumerate(lines[1:]):
        cells = line.split(",")
        try:
            if len(cells) != len(names):
                raise ValueError
            rows[number] = [float(cell) if cell else math.nan for cell in cells]
        except ValueError as error:
            raise DamagedRun(f"{path}:{number + 2}: the line should have {len(names)} numbers") from error
    return Reports({name: rows[:, index] for index, name in enumerate(names)})
