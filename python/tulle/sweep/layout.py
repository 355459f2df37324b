"""The files of a sweep's directory, how they are written, and the lock on it.

    sweep.yaml             the sweep with everything resolved
    inputs.json            the files that the runs read, with their hashes
    records/NNNN.json      what is known of a run: its settings, its state, how it ended
    runs/NNNN/             its Tulle run directory
    logs/NNNN.txt          what the program printed
    pictures/NNNN.png      its last frame
    arrays/NNNN.npz        positions
    table.csv, table.parquet, index.html
    slurm/                 the scripts of array jobs and what their tasks printed

A file is written under another name and renamed when it is whole, so a reader never sees half of one."""
from __future__ import annotations

import contextlib
import fcntl
import json
import os
import socket
import threading
import time
from pathlib import Path
from typing import Any, Iterator, Optional

import yaml

from .problems import SweepError

FORMAT, FORMAT_VERSION = "tulle sweep", 1
FOLDERS = ("records", "logs", "pictures", "arrays")
TEMPORARY_MAX = 3600.0  # [s] that no file takes to be written
HEARTBEAT = 10.0       # [s] between two signs of life of a run under way
SILENCE_MAX = 120.0    # [s] without one after which a run on another host counts as silent: some heartbeats, and a slow disk

# A record says waiting, running, whole, failed or interrupted; find_state adds lost and silent.


class SweepDirectory:
    """Names of the files of a sweep's directory."""

    def __init__(self, path: Path) -> None:
        self.path = Path(os.path.abspath(path))
        self.program: Optional[Path] = None  # the program tulle, never by what the directory says
        self.sweep, self.inputs = self.path / "sweep.yaml", self.path / "inputs.json"
        self.table, self.page = self.path / "table.csv", self.path / "index.html"
        self.stop, self.slurm = self.path / "stop", self.path / "slurm"

    def get_record(self, number: int) -> Path:
        return self.path / "records" / f"{number:04d}.json"

    def get_run(self, number: int) -> Path:
        return self.path / "runs" / f"{number:04d}"

    def get_log(self, number: int) -> Path:
        return self.path / "logs" / f"{number:04d}.txt"

    def get_picture(self, number: int) -> Path:
        return self.path / "pictures" / f"{number:04d}.png"

    def get_arrays(self, number: int) -> Path:
        return self.path / "arrays" / f"{number:04d}.npz"

    def make_folders(self) -> None:
        for name in ("runs", *FOLDERS):
            (self.path / name).mkdir(parents=True, exist_ok=True)

    def remove_temporaries(self) -> None:
        """Removes what killed processes left half-written; a file that was begun lately may still be under way."""
        for folder in (self.path, *(self.path / name for name in FOLDERS)):
            for path in folder.glob(".*.tmp.*"):
                with contextlib.suppress(OSError):
                    if time.time() - path.stat().st_mtime > TEMPORARY_MAX:
                        path.unlink()

    def read_record(self, number: int) -> Optional[dict[str, Any]]:
        """The record of a run; None if there is none."""
        return read_json(self.get_record(number))

    def write_record(self, record: dict[str, Any]) -> None:
        write_json(self.get_record(record["number"]), record)

    def read_sweep(self) -> dict[str, Any]:
        """The resolved sweep; refuses a folder that holds none."""
        try:
            with open(self.sweep, encoding="utf-8") as stream:
                sweep = yaml.load(stream, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))
        except FileNotFoundError:
            raise SweepError(f"{self.path} holds no sweep: there is no sweep.yaml in it") from None
        except (OSError, yaml.YAMLError, UnicodeDecodeError) as error:
            raise SweepError(f"{self.sweep}: cannot be read: {error}") from None
        if not isinstance(sweep, dict) or sweep.get("format") != FORMAT:
            raise SweepError(f"{self.sweep} is no resolved sweep; sweeps go into a folder of their own")
        if sweep.get("format_version") != FORMAT_VERSION:
            raise SweepError(f"{self.sweep}: is of format version {sweep.get('format_version')}, and this program "
                             f"knows {FORMAT_VERSION}")
        return sweep

    def read_records(self) -> list[dict[str, Any]]:
        """The records of all runs of the sweep, by number, with the states that they are found in."""
        records = []
        for run in self.read_sweep()["runs"]:
            record = self.read_record(run["number"]) or dict(run, state="waiting")
            record["seen_state"] = find_state(self, record)
            records.append(record)
        return records


# ---- files ----

def get_temporary(path: Path) -> Path:
    """A name beside `path` that no other process and thread writes, with the same ending."""
    return path.with_name(f".{path.stem}.{socket.gethostname()}.{os.getpid()}.{threading.get_ident()}.tmp{path.suffix}")


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A temporary name to write; renamed to `path` when the block ends well, removed when it does not."""
    temporary = get_temporary(path)
    try:
        yield temporary
        descriptor = os.open(temporary, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
        os.replace(temporary, path)
    except BaseException:
        with contextlib.suppress(OSError):
            temporary.unlink()
        raise


def write_text(path: Path, text: str) -> None:
    with replacing(path) as temporary:
        temporary.write_bytes(text.encode("utf-8"))


def write_json(path: Path, value: Any) -> None:
    write_text(path, json.dumps(value, indent=1, ensure_ascii=False) + "\n")


def read_json(path: Path) -> Any:
    """The value of a JSON file; None where there is no such file or it is none."""
    try:
        return json.loads(path.read_bytes())
    except (OSError, ValueError):
        return None


def write_sweep(directory: SweepDirectory, sweep: dict[str, Any]) -> None:
    """Writes the resolved sweep."""
    text = yaml.dump(sweep, Dumper=getattr(yaml, "CSafeDumper", yaml.SafeDumper), sort_keys=False, allow_unicode=True,
                     default_flow_style=None, width=1000)
    write_text(directory.sweep, "# The sweep with everything resolved. Written by the program; changes here have no effect.\n" + text)


# ---- what a record is found to mean ----

def is_process(pid: int, started: Optional[str]) -> bool:
    """Whether a process of this host with this number, and this time of start where it is known, is there."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        pass
    return started is None or get_process_start(pid) in (None, started)


def get_process_start(pid: int) -> Optional[str]:
    """When a process began, in the ticks of Linux; None elsewhere. A number that was given anew has another start."""
    try:
        text = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return None
    return text.rpartition(")")[2].split()[19]


def is_whole(directory: SweepDirectory, record: dict[str, Any]) -> bool:
    """Whether the directory of a run that was whole still holds that run."""
    run = read_json(directory.get_run(record["number"]) / "run.json")
    return isinstance(run, dict) and run.get("state") == "finished" and run.get("scene_hash") == record.get("scene_hash")


def find_state(directory: SweepDirectory, record: dict[str, Any]) -> str:
    """The state of a run: that of its record, but "lost" where nobody works at it any more or what was whole is gone."""
    state = record["state"]
    if state == "whole" and not is_whole(directory, record):
        return "lost"
    if state != "running":
        return state
    if record.get("host") == socket.gethostname():
        return state if is_process(record["pid"], record.get("pid_start")) else "lost"
    try:
        silence = time.time() - directory.get_record(record["number"]).stat().st_mtime
    except OSError:
        return "lost"
    return "silent" if silence > SILENCE_MAX else state


# ---- the lock ----

@contextlib.contextmanager
def locked(directory: SweepDirectory) -> Iterator[None]:
    """Holds the directory for one sweep. The lock is the kernel's; host and process stand in the file for people, and
    for hosts whose kernels do not hear of each other's locks."""
    path = directory.path / "lock"
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            is_held = False
        except OSError:
            is_held = True
        owner = read_owner(descriptor)
        host = owner.get("host")
        if is_held or (host and host != socket.gethostname()):
            raise SweepError(f"{directory.path}: another sweep works here: process {owner.get('pid', 'unknown')} on "
                             f"{host or 'an unknown host'}" +
                             ("" if is_held else f"; if it is there no more, remove {path}"))
        text = json.dumps({"host": socket.gethostname(), "pid": os.getpid()}).encode()
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, text, 0)
        try:
            yield
        finally:
            os.ftruncate(descriptor, 0)
    finally:
        os.close(descriptor)


def read_owner(descriptor: int) -> dict[str, Any]:
    """Host and process of a lock file; empty where it is free."""
    try:
        owner = json.loads(os.pread(descriptor, 4096, 0) or b"{}")
    except ValueError:
        return {}
    return owner if isinstance(owner, dict) else {}
