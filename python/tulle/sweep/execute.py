"""One run from start to end, wherever it happens: `tulle run --resume`, the judge, a picture, the arrays.

The record of the run tells at every moment how far it is. Whoever executes a run again goes on where it was: the
program resumes from its checkpoint, and what is whole is left alone."""
from __future__ import annotations

import contextlib
import json
import os
import signal
import socket
import struct
import subprocess
import threading
import time
from pathlib import Path
from typing import Any, Optional

from .arrays import make_arrays
from .layout import HEARTBEAT, SweepDirectory, get_process_start, is_whole, read_json, replacing
from .plan import find_changed_input
from .problems import EXIT_INTERRUPTED

POLL = 0.05            # [s] between two looks at a child
STOP_FILE_POLL = 1.0   # [s] between two looks for the file that stops all runs
GRACE = 60.0           # [s] for a run to reach its checkpoint; then it is killed and goes on from an earlier one
LOCK_WAIT = 600.0      # [s] to wait for another process that still writes the run, as one of a node given up for dead
IDLE_STOPS_MAX = 3     # stops in a row without a step done after which a run is given up
LAST_LINES = 6
LINE_LENGTH_MAX = 500
LOG_BYTES = 8192       # of the end of a log that are searched for the last lines
CLEAN = "clean"        # the verdict of a run without intersections
PICTURE = ("--size", "240x135", "--samples", "16")


class Stop:
    """The wish to end. The first one lets runs reach a checkpoint, a second one kills them. With a `parent` the end of that
    process is such a wish, too."""

    def __init__(self, parent: Optional[int] = None) -> None:
        self.level, self.reason, self.parent = 0, "", parent
        self.changed = threading.Event()

    def ask(self, reason: str) -> None:
        self.level, self.reason = self.level + 1, self.reason or reason
        self.changed.set()


class Stopped(Exception):
    """A run stopped before its end, since somebody wished so."""


class Failed(Exception):
    """A run cannot be had as it is; the text says why."""


class Child:
    """A program under way for a run: waits for it, gives signs of life, hands the wish to stop on."""

    def __init__(self, directory: SweepDirectory, number: int, stop: Stop) -> None:
        self.directory, self.number, self.stop = directory, number, stop
        self.next_sign = self.next_look = 0.0

    def call(self, command: list[str], output: Any, limit: Optional[float], stops_softly: bool) -> tuple[int, bool]:
        """Runs the command. Returns its exit code, as a shell has it, and whether it took longer than `limit` [s]."""
        began = time.monotonic()
        try:
            # A session of its own: Ctrl-C at a terminal reaches it through us alone, once.
            child = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
                                     start_new_session=True)
        except OSError as error:
            raise Failed(f"{command[0]}: cannot be run: {error.strerror}") from None
        asked_at, is_late = 0.0, False
        try:
            while child.poll() is None:
                now = time.monotonic()
                self.look_around(now)
                is_late = is_late or (limit is not None and now - began > limit)
                if (self.stop.level or is_late) and not asked_at:
                    asked_at = now
                    child.send_signal(signal.SIGINT if stops_softly else signal.SIGKILL)
                elif asked_at and (self.stop.level > 1 or now - asked_at > GRACE):
                    child.kill()
                try:
                    child.wait(POLL)
                except subprocess.TimeoutExpired:
                    pass
        finally:
            if child.poll() is None:
                child.kill()
                child.wait()
        code = child.returncode
        return (128 - code if code < 0 else code), is_late

    def look_around(self, now: float) -> None:
        """Signs of life; the file that stops a whole sweep; a parent that is gone."""
        if now >= self.next_sign:
            self.next_sign = now + HEARTBEAT
            os.utime(self.directory.get_record(self.number))
        if now >= self.next_look and not self.stop.level:
            self.next_look = now + STOP_FILE_POLL
            if self.directory.stop.exists():
                self.stop.ask("the sweep was stopped")
            elif self.stop.parent not in (None, os.getppid()):
                self.stop.ask("what had started it ended")


def execute(directory: SweepDirectory, number: int, stop: Stop, place: str = "") -> dict[str, Any]:
    """Brings a run to its end and returns its record. `place` names a task of a cluster."""
    record = directory.read_record(number)
    if record is None:
        raise Failed(f"{directory.get_record(number)}: there is no such record")
    if record["state"] == "whole" and is_whole(directory, record):
        return record
    for name in ("reason", "last_lines"):
        record.pop(name, None)
    record.update(state="running", host=socket.gethostname(), pid=os.getpid(), pid_start=get_process_start(os.getpid()),
                  place=place, attempts=record["attempts"] + 1)
    directory.write_record(record)
    child = Child(directory, number, stop)
    log_begin = get_size(directory.get_log(number))
    try:
        changed = find_changed_input(directory)
        if changed:
            raise Stopped(f"{changed} has changed since the sweep was planned; start the sweep anew")
        simulate(child, record)
        judge(child, record)
        finish(child, record)
        record["state"] = "whole"
    except Stopped as error:
        record.update(state="interrupted", reason=str(error))
    except Exception as error:  # whatever it is, it is this run's and stops no other
        reason = str(error) if isinstance(error, (Failed, OSError)) else f"{type(error).__name__}: {error}"
        record.update(state="failed", reason=reason, last_lines=read_last_lines(directory.get_log(number), log_begin))
        if (directory.get_run(number) / "run.json").exists() and not stop.level:
            with contextlib.suppress(Stopped):
                make_picture(child, record)  # the last frame may show why
    directory.write_record(record)
    return record


# ---- the parts of a run ----

def simulate(child: Child, record: dict[str, Any]) -> None:
    """Runs or resumes the simulation until it is finished; tries again where the sweep says so."""
    tries = 0
    locked_until = time.monotonic() + LOCK_WAIT
    while True:
        log = child.directory.get_log(record["number"])
        begin = get_size(log)
        code, is_late = call_run(child, record)
        record["exit_code"] = code
        if code == 0:
            record.pop("idle_stops", None)
            return
        reason = describe_end(log, begin, code)
        if code == 2 and "locked" in reason and time.monotonic() < locked_until:
            if child.stop.changed.wait(1.0):
                raise Stopped(child.stop.reason)
            continue
        if is_late:
            raise Failed(f"took longer than limits.time, {record['time_limit']:g} s; --retry-failed goes on from its checkpoint")
        if child.stop.level:
            note_stop(child, record)
            raise Stopped(child.stop.reason)
        # What is wrong with the input stays wrong.
        if code == 2 or tries >= record["retries"]:
            raise Failed(reason)
        tries += 1


def call_run(child: Child, record: dict[str, Any]) -> tuple[int, bool]:
    """One call of `tulle run --resume`; returns its exit code, and whether the time of the run was over."""
    command = [str(child.directory.program), "run", record["scene"], "-o", str(child.directory.get_run(record["number"])), "--resume",
               "-t", str(record["threads"]), "--progress", "none"]
    if record["frames"]:
        command += ["-n", str(record["frames"])]
    for path, text in record["settings"]:
        command += ["--set", f"{path}={text}"]
    limit = record["time_limit"]
    if child.stop.level:
        raise Stopped(child.stop.reason)
    began = time.monotonic()
    with open(child.directory.get_log(record["number"]), "ab") as output:
        code, is_late = child.call(command, output, None if limit is None else limit - record["limit_used"], True)
    seconds = time.monotonic() - began
    record["wall_seconds"] = round(record["wall_seconds"] + seconds, 3)
    record["limit_used"] = round(record["limit_used"] + seconds, 3)
    return code, is_late and code != 0


def describe_end(log: Path, begin: int, code: int) -> str:
    """Why a call of the program did not end well: its last line, or the signal."""
    lines = [line for line in read_last_lines(log, begin) if line.startswith("tulle run: ")] or read_last_lines(log, begin)
    said = lines[-1] if lines else ""
    said = said[len("tulle run: "):] if said.startswith("tulle run: ") else said
    if code > 128 and code != EXIT_INTERRUPTED:
        return f"killed by signal {code - 128}" + ("; perhaps memory was short" if code - 128 == signal.SIGKILL else "")
    return said or f"tulle run ended with exit code {code}"


def note_stop(child: Child, record: dict[str, Any]) -> None:
    """Gives a run up that is stopped over and over before it has done a step."""
    steps = read_checkpoint_steps(child.directory.get_run(record["number"]))
    is_idle = steps <= record.get("steps_at_stop", -1)
    record["idle_stops"] = record.get("idle_stops", 0) + 1 if is_idle else 0
    record["steps_at_stop"] = steps
    if record["idle_stops"] >= IDLE_STOPS_MAX:
        record["idle_stops"] = 0
        raise Failed(f"was stopped {IDLE_STOPS_MAX} times in a row without a step done; give it more time")


def read_checkpoint_steps(run: Path) -> int:
    """Steps done at the newest checkpoint; 0 where there is none."""
    try:
        head = (run / "checkpoint.bin").read_bytes()[:24]
        return int(struct.unpack_from("<Q", head, 16)[0])
    except (OSError, struct.error):
        return 0


def judge(child: Child, record: dict[str, Any]) -> None:
    """Has `tulle check` judge every frame; notes the verdict and what run.json says."""
    run_path = child.directory.get_run(record["number"])
    run = read_json(run_path / "run.json")
    if not isinstance(run, dict) or run.get("state") != "finished":
        raise Failed(f"{run_path}/run.json does not say that the run has finished")
    record["scene_hash"] = run.get("scene_hash")
    command = [str(child.directory.program), "check", str(run_path), "--json", "--list", "0", "-t", str(record["threads"])]
    judged = child.directory.get_log(record["number"]).with_suffix(".judge")
    try:
        with open(judged, "wb") as output:
            code, _ = child.call(command, output, None, stops_softly=False)
        if child.stop.level and code not in (0, 1):
            raise Stopped(child.stop.reason)
        lines = judged.read_text(encoding="utf-8", errors="replace").splitlines()
    finally:
        judged.unlink(missing_ok=True)
    sums = [line for line in lines if line.startswith('{"frames":')]
    if code not in (0, 1) or not sums:
        raise Failed(f"the judge cannot read the run: {lines[-1] if lines else f'exit code {code}'}")
    found = json.loads(sums[-1])
    record["verdict"] = CLEAN if code == 0 else (f"{found['intersections']} intersections in "
                                                 f"{found['frames_with_intersections']} frames")


def finish(child: Child, record: dict[str, Any]) -> None:
    """Makes picture and arrays. A run without them is whole; what is missing is told, and made by `collect`."""
    if child.stop.level:
        raise Stopped(child.stop.reason)
    record.pop("notes", None)
    notes = [make_picture(child, record), make_arrays(child.directory, record)]
    if any(notes):
        record["notes"] = [note for note in notes if note]


def make_picture(child: Child, record: dict[str, Any]) -> str:
    """Renders the last frame; returns why that is not possible, or nothing."""
    number = record["number"]
    picture = child.directory.get_picture(number)
    log = child.directory.get_log(number)
    begin = get_size(log)
    try:
        with replacing(picture) as temporary, open(log, "ab") as output:
            code, _ = child.call([str(child.directory.program), "render", str(child.directory.get_run(number)), "-o", str(temporary),
                                  *PICTURE, "-t", str(record["threads"]), "--progress", "none"], output, None, False)
            if code != 0:
                raise Failed(" ".join(read_last_lines(log, begin)[-1:]) or f"exit code {code}")
    except (Failed, OSError) as reason:
        if child.stop.level:
            raise Stopped(child.stop.reason) from None
        return f"there is no picture: {reason}"
    return ""


# ---- logs ----

def get_size(path: Path) -> int:
    try:
        return path.stat().st_size
    except OSError:
        return 0


def read_last_lines(path: Path, begin: int) -> list[str]:
    """The last lines of a log that were written after its byte `begin`."""
    try:
        with open(path, "rb") as stream:
            stream.seek(max(begin, get_size(path) - LOG_BYTES))
            text = stream.read().decode("utf-8", errors="replace")
    except OSError:
        return []
    return [line[:LINE_LENGTH_MAX] for line in text.splitlines() if line.strip()][-LAST_LINES:]
