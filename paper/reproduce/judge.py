"""The exact judge, `tulle check`, over every frame of the runs, and the table of runs: sizes, machine time, contacts,
rescues and what the judge found."""
from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable
from dataclasses import dataclass

from reproduce.children import call
from reproduce.conditions import read_conditions
from reproduce.figures import list_runs
from reproduce.kept import Kept
from reproduce.recorded import RESCUES, RecordedRun, read_run
from reproduce.runs import get_directory, open_run
from reproduce.scenes import Run
from reproduce.session import DamagedRun, Exit, Failure, Session, write_table

DIGITS = re.compile(r"[0-9]+")
RUNS_HEAD = ("run,state,cloth_particles,cloth_triangles,obstacle_particles,obstacle_triangles,frames,simulated_seconds,"
             "step_seconds,rescues_per_1000_contacts,bad_frames,intersections,time_step,conditions")


@dataclass
class Verdict:
    """What the judge found in a run, and sums over the reports of its steps."""

    frames: int
    bad_frames: int
    intersections: int
    state: str  # of the run
    time_step: float  # [s]
    conditions: str
    cloth_vertices: int
    cloth_triangles: int
    obstacle_vertices: int
    obstacle_triangles: int
    has_reports: bool = False  # of all steps; without them what follows is 0
    steps: int = 0
    simulated_seconds: float = 0.0
    step_seconds: float = 0.0
    contacts: int = 0
    rescues: int = 0


def _make_head(recorded: RecordedRun) -> str:
    """How the table of verdicts begins: a state's verdict holds for the obstacles of its scene."""
    return f"# scene {recorded.scene_hash}\nframe,state_hash,intersections\n"


def _make_key(recorded: RecordedRun, frame: int) -> str:
    """A verdict is that of the frame's state."""
    return f"{frame},{recorded.frames[frame].state_hash}"


def _open_verdicts(session: Session, run: Run, recorded: RecordedRun) -> Kept:
    return Kept(session.path(f"judged/{run.name}.csv"), _make_head(recorded), 2)


def _get_pairs(verdicts: Kept, key: str) -> int | None:
    """Pairs that intersect; None where that is not known."""
    text = verdicts.find(key)
    return int(text) if text is not None and DIGITS.fullmatch(text) else None


def _read_verdicts(session: Session, run: Run, recorded: RecordedRun) -> list[int] | None:
    """Pairs that intersect in each frame; None where the table is not of this run or not whole."""
    verdicts = _open_verdicts(session, run, recorded)
    if not recorded.frames or len(verdicts.rows) != len(recorded.frames):
        return None
    found = []
    for frame, row in enumerate(verdicts.rows):
        key = _make_key(recorded, frame)
        if not row.startswith(f"{key},") or not DIGITS.fullmatch(row[len(key) + 1:]):
            return None
        found.append(int(row[len(key) + 1:]))
    return found


def _find_gaps(known: list[int | None]) -> list[tuple[int, int]]:
    """First and last frame of each piece without a verdict."""
    gaps: list[tuple[int, int]] = []
    for frame, pairs in enumerate(known):
        if pairs is not None:
            continue
        if gaps and gaps[-1][1] == frame - 1:
            gaps[-1] = (gaps[-1][0], frame)
        else:
            gaps.append((frame, frame))
    return gaps


def judge(session: Session, run: Run) -> None:
    """Judges every frame of the run, unless that was done, and writes judged/RUN.csv."""
    try:
        recorded = read_run(get_directory(session, run))
    except DamagedRun as damage:
        raise Failure(Exit.BAD_INPUT, str(damage)) from damage
    if not recorded.frames:
        raise Failure(Exit.BAD_INPUT, f"{recorded.directory} holds no whole frame")
    if _read_verdicts(session, run, recorded) is not None:
        return
    session.progress.show_job(run.name, "is judged")
    table = _open_verdicts(session, run, recorded)
    keys = [_make_key(recorded, frame) for frame in range(len(recorded.frames))]
    known = [_get_pairs(table, key) for key in keys]
    session.progress.begin_work()
    session.progress.skip_work(sum(pairs is not None for pairs in known))
    try:
        for first, last in _find_gaps(known):
            _judge_frames(session, run, (first, last), known, lambda frame: table.add(f"{keys[frame]},{known[frame]}"))
    finally:
        table.forget()
        for key, pairs in zip(keys, known):
            if pairs is not None:
                table.add(f"{key},{pairs}")
        table.save()
        session.progress.end_work()


def _judge_frames(session: Session, run: Run, frames: tuple[int, int], known: list[int | None],
                  take: Callable[[int], None]) -> None:
    """Judges the frames from the first to the last; each is handed over when it is known."""

    def take_line(line: str) -> None:
        verdict = json.loads(line)
        if "frame" in verdict:
            known[verdict["frame"]] = verdict["intersections"]
            take(verdict["frame"])
            session.progress.show_work(run.name, sum(pairs is not None for pairs in known), len(known))

    words = [str(session.program), "check", str(get_directory(session, run)), "--json", "--list", "0", "--frames",
             f"{frames[0]}:{frames[1]}", "--threads", str(session.used_threads)]
    code, _, errors = call(session.interrupts, words, take_line)
    session.stop_if_interrupted()
    if code not in (Exit.FINE, Exit.FALSE) or None in known[frames[0]:frames[1] + 1]:
        print(errors, end="", file=sys.stderr, flush=True)
        raise Failure(code if code > Exit.FALSE else Exit.CANNOT_GO_ON, f"{run.name} cannot be judged")


def read_verdict(session: Session, run: Run) -> Verdict | None:
    """What was found; None where the run is not there or not judged."""
    recorded = open_run(session, run)
    pairs = _read_verdicts(session, run, recorded) if recorded else None
    if recorded is None or pairs is None:
        return None
    obstacles = [body for body in recorded.bodies if body.is_obstacle]
    verdict = Verdict(frames=len(pairs), bad_frames=sum(count > 0 for count in pairs), intersections=sum(pairs),
                      state=recorded.state, time_step=recorded.time_step, conditions=read_conditions(session, run.name),
                      cloth_vertices=sum(body.vertex_count for body in recorded.cloths),
                      cloth_triangles=sum(body.triangle_count for body in recorded.cloths),
                      obstacle_vertices=sum(body.vertex_count for body in obstacles),
                      obstacle_triangles=sum(body.triangle_count for body in obstacles))
    try:
        reports = recorded.read_reports()
    except DamagedRun:
        return verdict
    verdict.has_reports = True
    verdict.steps = len(reports)
    if verdict.steps > 0:
        verdict.simulated_seconds = float(reports["time"][-1])
        verdict.step_seconds = float(reports["total_seconds"].sum())
        verdict.contacts = int(reports["contacts"].sum())
        verdict.rescues = int(sum(reports[name].sum() for name in RESCUES))
    return verdict


def _format_steps(verdict: Verdict) -> str:
    """What report.csv tells of a run; nothing where it does not tell of all steps."""
    if not verdict.has_reports:
        return ",,"
    rescues = 1000.0 * verdict.rescues / verdict.contacts if verdict.contacts > 0 else 0.0
    return f"{verdict.simulated_seconds:.6g},{verdict.step_seconds:.6g},{rescues:.3g}"


def write_runs(session: Session) -> None:
    """Writes runs.csv, a line for every run that is there."""
    lines = [RUNS_HEAD]
    for run in list_runs():
        verdict = read_verdict(session, run)
        if verdict:
            lines.append(f"{run.name},{verdict.state},{verdict.cloth_vertices},{verdict.cloth_triangles},"
                         f"{verdict.obstacle_vertices},{verdict.obstacle_triangles},{verdict.frames},"
                         f"{_format_steps(verdict)},{verdict.bad_frames},{verdict.intersections},"
                         f"{verdict.time_step:g},{verdict.conditions}")
    write_table(session, "runs.csv", lines)
