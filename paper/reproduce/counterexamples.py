"""Collisions that the paper's rule for patches misses: it skips every pair within a patch, on the strength of the cone
of its normals alone. Two motions that paper_measure makes, then the recorded frames of the paper's scenes. Every time
the truth is a search without patches.

Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects, 2005, sections 3.2, 3.3
and 7.
"""
from __future__ import annotations

import re
import sys
from dataclasses import dataclass

from reproduce.children import call
from reproduce.figures import Figure
from reproduce.frames import Measure, choose_frames, describe
from reproduce.kept import Kept
from reproduce.recorded import RecordedRun
from reproduce.runs import open_moving_run, read_scene
from reproduce.scenes import Run
from reproduce.session import Exit, Failure, Session, write_table

BEST_ANGLE = 85  # [degrees] at which the paper's rule is fastest; that of paper_measure
FRAMES_QUICK, FRAMES_FULL = 50, 600
COUNTS = re.compile(r"(\d+),(\d+),(\d+),(\d+),(\d+)")
MOTIONS_HEAD = ("motion,triangles,intersections_start,intersections_end,collisions,paper_patches,paper_found,"
                "paper_missed,proven_missed")
SCENES_HEAD = ("run,frames,contact_distance_mm,events,paper_patches,paper_found,paper_missed,frames_with_missed,"
               "proven_missed")


@dataclass
class Counts:
    """What was found in one frame, or sums over frames."""

    events: int = 0
    patches: int = 0
    paper_found: int = 0
    paper_missed: int = 0
    proven_missed: int = 0


def parse_counts(row: str | None) -> Counts | None:
    """The counts that a row tells, whole from its beginning to its end."""
    match = COUNTS.fullmatch(row) if row is not None else None
    return Counts(*(int(cell) for cell in match.groups())) if match else None


def _look_at_frames(session: Session, run: Run, recorded: RecordedRun) -> str:
    """A line of counterexamples_scenes.csv."""
    facts = read_scene(session, run)
    head = (f"# build {session.build} {describe(recorded, facts)} angle {BEST_ANGLE}\n"
            "frame,events,paper_patches,paper_found,paper_missed,proven_missed\n")
    kept = Kept(session.path(f"measured/counterexamples_{run.name}.csv"), head, 1)
    frames = choose_frames(len(recorded.frames), FRAMES_QUICK if session.is_quick else FRAMES_FULL)
    found = []
    session.progress.begin_work()
    with Measure(session, "missed", recorded, facts) as measure:
        try:
            for done, frame in enumerate(frames, start=1):
                session.stop_if_interrupted()
                found.append(_look_at_frame(session, frame, kept, measure))
                session.progress.show_work(run.name, done, len(frames))
        finally:
            kept.save()
            session.progress.end_work()
    sums = Counts(*(sum(getattr(counts, name) for counts in found) for name in Counts.__dataclass_fields__))
    return (f"{run.name},{len(found)},{1000.0 * facts.contact_distance:.4g},{sums.events},"
            f"{sums.patches / len(found):.4g},{sums.paper_found},{sums.paper_missed},"
            f"{sum(counts.paper_missed > 0 for counts in found)},{sums.proven_missed}")


def _look_at_frame(session: Session, frame: int, kept: Kept, measure: Measure) -> Counts:
    """What is known of the frame, or what is measured."""
    counts = parse_counts(kept.find(str(frame)))
    if counts:
        session.progress.skip_work()
        return counts
    measure.ask([str(frame)])
    row = measure.read_row()
    key, _, rest = row.partition(",")
    counts = parse_counts(rest)
    if key != str(frame) or not counts:
        raise Failure(Exit.CANNOT_GO_ON, f"paper_measure answered \"{row}\" about frame {frame}")
    kept.add(row)
    return counts


def make(session: Session, figure: Figure) -> None:
    """figure.runs: every scene, by rules that miss nothing."""
    code, output, errors = call(session.interrupts, [str(session.measure), "motions", str(session.used_threads)])
    session.stop_if_interrupted()
    if code != Exit.FINE:
        print(errors, end="", file=sys.stderr, flush=True)
        raise Failure(code if code > 0 else Exit.CANNOT_GO_ON)
    write_table(session, "counterexamples_motions.csv", [MOTIONS_HEAD, *output.splitlines()])
    lines = [SCENES_HEAD]
    for run in figure.runs:
        recorded = open_moving_run(session, run)
        if recorded:
            lines.append(_look_at_frames(session, run, recorded))
    write_table(session, "counterexamples_scenes.csv", lines)
