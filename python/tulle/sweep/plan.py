"""From a sweep file to numbered runs in a directory, and what of an earlier start stays.

The key of a run is a hash of all that its result depends on, but for the program: the scene, the files that it and the
values name, the settings, the number of frames. A run whose key is known keeps its number and what was made. New rows
get new numbers. Runs of the directory that the sweep no longer has are in the way: they are refused, or replaced where
the user says so."""
from __future__ import annotations

import hashlib
import json
import os
import shutil
from pathlib import Path
from typing import Any, Optional

import yaml

from .definition import Sweep
from .document import Entry, read_document
from .layout import FORMAT, FORMAT_VERSION, SweepDirectory, read_json, write_json, write_sweep
from .problems import SweepError
from .program import try_scene
from .values import FILE_KEYS, find_files

KEY_DIGITS = 16


# ---- inputs ----

def hash_file(path: Path) -> str:
    digest = hashlib.sha256()
    with open(path, "rb") as stream:
        while block := stream.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()


def describe_file(path: Path) -> dict[str, Any]:
    """Size, time and hash of a file, by which a later look finds out whether it is the same."""
    try:
        facts = path.stat()
        return {"size": facts.st_size, "time_ns": facts.st_mtime_ns, "sha256": hash_file(path)}
    except OSError as error:
        raise SweepError(f"{path}: cannot be read: {error.strerror}") from None


def list_named_files(entry: Entry) -> list[Path]:
    """The files that a scene names, in the order of the scene; those that are not there are the program's to miss."""
    if entry.is_list():
        return [path for one in entry.get_list() for path in list_named_files(one)]
    if not entry.is_map():
        return []
    paths: list[Path] = []
    for name, one in entry.get_map().items():
        if name in FILE_KEYS and isinstance(one.node, yaml.ScalarNode) and one.node.value:
            paths += find_files(Path(entry.file.parent, one.node.value).resolve())
        else:
            paths += list_named_files(one)
    return paths


def find_changed_input(directory: SweepDirectory) -> Optional[str]:
    """The first file that is not as it was when the sweep was planned; files of the same size and time are not read."""
    for name, known in (read_json(directory.inputs) or {}).items():
        try:
            facts = os.stat(name)
            if (facts.st_size, facts.st_mtime_ns) == (known["size"], known["time_ns"]):
                continue
            if facts.st_size != known["size"] or hash_file(Path(name)) != known["sha256"]:
                return name
        except OSError:
            return name
    return None


# ---- runs ----

def make_records(sweep: Sweep, program: Path, inputs: dict[str, Any]) -> list[dict[str, Any]]:
    """A record for each row, without a number; fills in the inputs."""
    scene_files = [sweep.scene, *list_named_files(read_document(sweep.scene))]
    for path in scene_files:
        inputs.setdefault(str(path), None)
    for path in [*scene_files, *(path for row in sweep.rows for value in row for path in value.files)]:
        if inputs.get(str(path)) is None:
            inputs[str(path)] = describe_file(path)
    base = [inputs[str(path)]["sha256"] for path in scene_files]
    records = []
    for row in sweep.rows:
        settings = [[path, value.text] for parameter, value in zip(sweep.parameters, row) for path in parameter.paths]
        files = [inputs[str(path)]["sha256"] for value in row for path in value.files]
        # Files go by the names that the sweep has for them, so a folder that was moved has the same keys.
        shown = [[path, value.shown] for parameter, value in zip(sweep.parameters, row) for path in parameter.paths]
        text = json.dumps([base, shown, files, sweep.frames], ensure_ascii=False)
        records.append({
            "number": None, "key": hashlib.sha256(text.encode()).hexdigest()[:KEY_DIGITS],
            "values": {p.name: value.shown for p, value in zip(sweep.parameters, row)}, "settings": settings,
            "scene": str(sweep.scene), "program": str(program), "frames": sweep.frames, "threads": sweep.threads,
            "time_limit": sweep.limits.time, "retries": sweep.limits.retries,
            "positions": sweep.collect.positions, "array_frames": sweep.collect.frames,
            "state": "waiting", "attempts": 0, "wall_seconds": 0.0, "limit_used": 0.0})
    return records


def number_runs(directory: SweepDirectory, records: list[dict[str, Any]]) -> tuple[list[int], list[int]]:
    """Gives each record its number, and what is known of the run from before. Returns the numbers of runs of the
    directory that are no longer wanted: those with something in them, and all."""
    known: dict[str, dict[str, Any]] = {}
    highest = -1
    for path in (directory.path / "records").glob("[0-9]*.json"):
        old = read_json(path)
        if not isinstance(old, dict) or not isinstance(old.get("number"), int) or "key" not in old:
            raise SweepError(f"{path}: is no record of a run; bring it back from a copy, or remove it with its run "
                             f"{directory.path / 'runs' / path.stem}")
        known[old["key"]] = old
        highest = max(highest, old["number"])
    fresh = []
    for record in records:
        old = known.pop(record["key"], None)
        if old is None:
            fresh.append(record)
            continue
        kept = {name: value for name, value in old.items() if name not in record}
        kept.update({name: old[name] for name in ("number", "state", "attempts", "wall_seconds", "limit_used")})
        record.update(kept)
    unwanted = sorted(old["number"] for old in known.values())
    free = iter([*unwanted, *range(highest + 1, highest + 1 + len(fresh))])
    for record in fresh:
        record["number"] = next(free)
    return [number for number in unwanted if directory.get_run(number).exists()], unwanted


def plan_sweep(directory: SweepDirectory, sweep: Sweep, program: Path, is_replacing: bool) -> list[dict[str, Any]]:
    """Brings the directory up to the sweep and returns the records of its runs by number. The directory is locked."""
    inputs: dict[str, Any] = {}
    records = make_records(sweep, program, inputs)
    in_the_way, unwanted = number_runs(directory, records)
    if in_the_way and not is_replacing:
        raise SweepError(describe_difference(directory, sweep, inputs, in_the_way))
    check_settings(sweep, program, records[0])
    records.sort(key=lambda record: record["number"])
    # First of all, since it tells that the folder is ours.
    write_sweep(directory, {
        "format": FORMAT, "format_version": FORMAT_VERSION, "title": sweep.title, "file": str(sweep.file),
        "scene": str(sweep.scene), "program": str(program), "frames": sweep.frames, "threads": sweep.threads,
        "limits": {"time": sweep.limits.time, "retries": sweep.limits.retries},
        "collect": {"positions": sweep.collect.positions, "frames": sweep.collect.frames},
        "parameters": [{"name": p.name, "paths": p.paths} for p in sweep.parameters],
        "runs": [{"number": r["number"], "key": r["key"], "values": r["values"]} for r in records]})
    directory.make_folders()
    directory.remove_temporaries()
    for number in unwanted:
        remove_run(directory, number)
    write_json(directory.inputs, inputs)
    for record in records:
        if directory.read_record(record["number"]) != record:
            directory.write_record(record)
    return records


def describe_difference(directory: SweepDirectory, sweep: Sweep, inputs: dict[str, Any], numbers: list[int]) -> str:
    """Why runs of the directory are not of this sweep, and what to do."""
    reasons = []
    for name, known in (read_json(directory.inputs) or {}).items():
        if name in inputs and inputs[name]["sha256"] != known["sha256"]:
            reasons.append(f"{name} has changed")
    old = directory.read_sweep()
    if old["scene"] != str(sweep.scene):
        reasons.append(f"the scene was {old['scene']}")
    if old["frames"] != sweep.frames:
        reasons.append(f"frames were {old['frames'] or 'those of the scene'}")
    if not reasons:
        values = (directory.read_record(numbers[0]) or {}).get("values", {})
        reasons.append(f"run {numbers[0]:04d} has values that the sweep no longer has: " +
                       ", ".join(f"{name} {value}" for name, value in values.items()))
    return (f"{directory.path}: holds {len(numbers)} runs that are not of this sweep: {'; '.join(reasons)}. Give --replace "
            "to remove them and run what is missing, or another folder by -o")


def check_settings(sweep: Sweep, program: Path, record: dict[str, Any]) -> None:
    """Refuses a scene or a path that the program does not take. A start that intersects is a matter of that run."""
    said = try_scene(program, sweep.scene, record["settings"])
    if not said or "intersect at the start" in said:
        return
    for parameter in sweep.parameters:
        if any(f"--set {path}=" in said for path in parameter.paths):
            raise parameter.entry.make_problem(f"the program says: {said}")
    raise SweepError(f"{sweep.file}: the scene cannot be run: {said}")


def remove_run(directory: SweepDirectory, number: int) -> None:
    """Removes a run with all that was made of it; its record goes last."""
    if directory.get_run(number).exists():
        shutil.rmtree(directory.get_run(number))
    for path in (directory.get_log(number), directory.get_picture(number), directory.get_arrays(number),
                 directory.get_record(number)):
        path.unlink(missing_ok=True)
