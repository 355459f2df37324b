"""The runs: which are whole, and `tulle run` for those that are not."""
from __future__ import annotations

import json
import math
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

from reproduce.children import call
from reproduce.conditions import note_run
from reproduce.progress import format_duration
from reproduce.recorded import RecordedRun, is_run, read_run
from reproduce.scenes import METHODS, PAPER_COST, SCENES, Run, SceneFacts
from reproduce.session import DamagedRun, Exit, Failure, Session, say


def find_scene_file(session: Session, run: Run) -> tuple[Path, tuple[str, ...]]:
    """The scene's file, its own or one that it shares, and the values that the latter is changed by."""
    scene = SCENES[run.scene]
    path = session.scenes / f"{run.scene}.yaml"
    if path.is_file() or not scene.shared_file:
        return path, ()
    return session.scenes / f"{scene.shared_file}.yaml", scene.shared


def has_scene(session: Session, run: Run) -> bool:
    """Whether the scene's file is there."""
    return find_scene_file(session, run)[0].is_file()


def list_words(session: Session, run: Run) -> list[str]:
    """The scene's file and its other values, as `tulle run` and `tulle info` take them."""
    path, values = find_scene_file(session, run)
    if session.is_quick:
        values += SCENES[run.scene].quick
    if run.method:
        values += METHODS[run.method]
    return [str(path), *(word for value in values for word in ("--set", value))]


def read_scene(session: Session, run: Run) -> SceneFacts:
    """Facts of the scene as it is run, asked for once; prints what is wrong with it."""
    if run in session.scene_facts:
        return session.scene_facts[run]
    code, output, errors = call(session.interrupts, [str(session.program), "info", "--json", *list_words(session, run)])
    session.stop_if_interrupted()
    if code != Exit.FINE:
        print(errors, end="", file=sys.stderr, flush=True)
        raise Failure(code if code > 0 else Exit.CANNOT_GO_ON)
    facts = json.loads(output)
    frames = int(facts["frames"])
    if session.is_quick:
        frames = min(frames, SCENES[run.scene].quick_frames)
    triangles = sum(int(cloth["triangles"]) for cloth in facts["cloths"])
    session.scene_facts[run] = SceneFacts(facts["scene_hash"], frames, int(facts["steps_per_frame"]),
                                          float(facts["contact_distance"]), triangles)
    return session.scene_facts[run]


def get_directory(session: Session, run: Run) -> Path:
    """The directory of the run within that of the results."""
    return session.path(f"runs/{run.name}")


def open_run(session: Session, run: Run) -> RecordedRun | None:
    """The run; None where it is not there or cannot be read."""
    directory = get_directory(session, run)
    if not is_run(directory):
        return None
    try:
        return read_run(directory)
    except DamagedRun:
        return None


def open_moving_run(session: Session, run: Run) -> RecordedRun | None:
    """The run if it has at least two frames."""
    recorded = open_run(session, run)
    return recorded if recorded and len(recorded.frames) > 1 else None


def has_reports(session: Session, run: Run) -> bool:
    """Whether the reports of all steps are there; says so where not."""
    try:
        read_run(get_directory(session, run)).read_reports()
    except DamagedRun as damage:
        say(f"runs/{run.name}: {damage}; its times are not known; without that folder the run is made again")
        return False
    return True


def _count_made(session: Session, run: Run, facts: SceneFacts) -> int:
    """Frames that are there, the start not counted; all, where nothing is left to do."""
    recorded = open_run(session, run)
    if not recorded or recorded.scene_hash != facts.scene_hash:
        return 0
    made = max(len(recorded.frames) - 1, 0)
    if made >= facts.frames:
        made = facts.frames if recorded.state == "finished" else facts.frames - 1
    return made


def weigh(session: Session, run: Run) -> float:
    """What is left of the run to be made, in steps times triangles of cloth times what a scene's step costs."""
    facts = read_scene(session, run)
    cost = SCENES[run.scene].cost * (1.0 if run.is_proven else PAPER_COST)
    left = facts.frames - _count_made(session, run, facts)
    return cost * left * facts.steps_per_frame * facts.cloth_triangles


def make_run(session: Session, run: Run) -> int:
    """Makes the run, or what is missing of it; the exit code of `tulle run`."""
    facts = read_scene(session, run)
    is_done = _count_made(session, run, facts) == facts.frames
    session.progress.show_job(run.name, "is there" if is_done else "runs")
    return Exit.FINE if is_done else _run_scene(session, run, facts.frames)


def _run_scene(session: Session, run: Run, frames: int) -> int:
    """Calls `tulle run` and shows what it tells. Its conditions are written down when it begins, not where it is
    refused."""
    session.stop_if_rebuilt()
    words = [str(session.program), "run", *list_words(session, run), "--resume", "-o", str(get_directory(session, run)),
             "--frames", str(frames), "--progress", "json"]
    if session.threads:
        words += ["--threads", str(session.threads)]
    with tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace") as summary:
        child = session.interrupts.start(words, signal.SIGINT, stdin=subprocess.DEVNULL, stdout=summary,
                                         stderr=subprocess.PIPE, text=True, encoding="utf-8", errors="replace")
        assert child.stderr is not None
        with child.stderr:
            for line in child.stderr:
                _take_line(session, run, line.rstrip("\n"))
        code = session.interrupts.finish(child)
        session.progress.end_work()
        summary.seek(0)
        print(summary.read(), end="", flush=True)
    return code if code >= 0 else Exit.INTERRUPTED if session.interrupts.are_pending else Exit.CANNOT_GO_ON


def _take_line(session: Session, run: Run, line: str) -> None:
    event = {}
    if line.startswith("{"):
        try:
            event = json.loads(line)
        except ValueError:
            pass  # shown as it is
    if event.get("event") == "begin":
        note_run(session, run.name, bool(event["goes_on"]))
    if not event or not session.progress.is_terminal:
        session.progress.tell(line)
    elif event["event"] == "step":
        gap = event["smallest_gap"]
        nearest = f"{1000.0 * gap:.3g} mm" if gap is not None and math.isfinite(gap) else "none near"
        rest = format_duration(event["rest_seconds"] or 0.0)
        session.progress.draw(event["step"], event["steps"], f"frame {event['frame']}/{event['frames']}  rest {rest}  "
                              f"{event['contacts']} contacts  gap {nearest}")
