"""Positions of cloth out of a run directory, as NPZ: one file a run.

    positions_NAME   (frames, vertices, 3) float32 [m], for each cloth that the sweep names
    frames, times    (frames,) int64 and float64 [s]
    what             a text that tells what was asked for and of which run, so that a change is noticed"""
from __future__ import annotations

import csv
import json
import zipfile
from pathlib import Path
from typing import Any

from .layout import SweepDirectory, read_json, replacing

CACHE_HEADER = 32  # bytes


def describe_wish(record: dict[str, Any]) -> str:
    """What the arrays of a run must hold, as text."""
    return json.dumps([record["positions"], record["array_frames"], record["key"], record.get("scene_hash")])


def read_frames(run: Path) -> list[tuple[int, float, str]]:
    """Number, time [s] and state hash of each whole frame."""
    try:
        with open(run / "frames.csv", newline="", encoding="utf-8") as stream:
            text = stream.read()
    except OSError:
        return []
    whole = text[:text.rfind("\n") + 1]
    return [(int(row["frame"]), float(row["time"]), row["state_hash"]) for row in csv.DictReader(whole.splitlines())]


def has_arrays(path: Path, wish: str) -> bool:
    """Whether a file holds what is wished for."""
    import numpy
    try:
        with numpy.load(path) as arrays:
            return str(arrays["what"]) == wish
    except (OSError, KeyError, ValueError, zipfile.BadZipFile):
        return False


def make_arrays(directory: SweepDirectory, record: dict[str, Any]) -> str:
    """Writes the arrays of a finished run where they are not there; returns why they cannot be had, or nothing."""
    path = directory.get_arrays(record["number"])
    if not record["positions"]:
        path.unlink(missing_ok=True)
        return ""
    try:
        import numpy
    except ImportError:
        return "there are no arrays: numpy is not installed here; install it and call collect"
    wish = describe_wish(record)
    if has_arrays(path, wish):
        return ""
    run_path = directory.get_run(record["number"])
    run = read_json(run_path / "run.json")
    if not isinstance(run, dict):
        return "there are no arrays: run.json cannot be read"
    cloths = {body["name"]: body for body in run["bodies"] if body["role"] == "cloth"}
    names = list(cloths) if record["positions"] == "all" else record["positions"]
    missing = [name for name in names if name not in cloths]
    frames = read_frames(run_path)
    wanted = record["array_frames"]
    chosen = frames[-1:] if wanted == "last" else frames if wanted == "all" else [f for f in frames if f[0] in set(wanted)]
    if missing:
        return f"there are no arrays: there is no cloth {missing[0]}; the cloths are {', '.join(cloths)}"
    if not chosen or (isinstance(wanted, list) and len(chosen) < len(wanted)):
        return f"there are no arrays: the run has frames 0 to {len(frames) - 1} alone"
    made = {"frames": numpy.array([f[0] for f in chosen], dtype=numpy.int64), "times": numpy.array([f[1] for f in chosen]),
            "what": numpy.array(wish)}
    for name in names:
        cache, count = run_path / cloths[name]["cache"], cloths[name]["vertices"]
        values = numpy.memmap(cache, dtype="<f4", mode="r", offset=CACHE_HEADER)
        made[f"positions_{name}"] = numpy.stack([values[3 * count * f[0]:3 * count * (f[0] + 1)].reshape(count, 3) for f in chosen])
    with replacing(path) as temporary, open(temporary, "wb") as stream:
        numpy.savez_compressed(stream, **made)
    return ""
