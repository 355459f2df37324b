"""Fig. 6: example one with low and with high friction. Numbers that tell slipping from staying: the share of contacts
that stick, how far the cloth has come from where it started, and how high its centre is.

Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects, 2005, section 6, Fig. 6.
"""
from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from reproduce.figures import Figure
from reproduce.plots import Panel, draw
from reproduce.recorded import RecordedRun
from reproduce.runs import open_moving_run
from reproduce.session import DamagedRun, Exit, Failure, Session, write_table
from reproduce.stills import make_stills

LAST_SHARE = 0.25  # of the frames, over which the end is averaged


@dataclass
class FrictionFacts:
    """What tells slipping from staying, in one frame or as a mean."""

    stick_share: float  # of the contacts that bear on friction, 0 without any; NAN: not known
    way: float  # [m] mean over the vertices, from the first frame
    centre_height: float  # [m] mean over the vertices

    def format(self) -> str:
        """Cells of a table; a share that is not known is an empty one."""
        share = f"{self.stick_share:.4g}" if math.isfinite(self.stick_share) else ""
        return f"{share},{self.way:.5g},{self.centre_height:.5g}"


def compute_stick_shares(recorded: RecordedRun) -> np.ndarray | None:
    """Of the contacts that stick or slip, those that stick, after each step; None where that is not known."""
    try:
        reports = recorded.read_reports()
    except DamagedRun:
        return None
    stick, slip = reports["stick_contacts"].astype(float), reports["slip_contacts"].astype(float)
    return np.where(stick + slip > 0.0, stick / np.maximum(stick + slip, 1.0), 0.0)


def measure_frames(recorded: RecordedRun) -> list[FrictionFacts]:
    """Every frame but the first."""
    shares = compute_stick_shares(recorded)
    first = recorded.read_cloth(0)
    facts = []
    for number, frame in enumerate(recorded.frames[1:], start=1):
        positions = recorded.read_cloth(number)
        share = float(shares[frame.step - 1]) if shares is not None and frame.step > 0 else math.nan
        facts.append(FrictionFacts(share, float(np.linalg.norm(positions - first, axis=1).mean()),
                                   float(positions[:, 2].mean())))
    return facts


def compute_last(facts: list[FrictionFacts]) -> FrictionFacts:
    """The mean of the end."""
    last = facts[len(facts) - 1 - int(LAST_SHARE * len(facts)):]
    return FrictionFacts(*(sum(getattr(one, name) for one in last) / len(last)
                           for name in ("stick_share", "way", "centre_height")))


def format_finding(finding: str, low: float, high: float, is_high_more: bool) -> str:
    """What should hold if the cloth slips with low friction and stays with high, both numbers, and whether it does."""
    if not math.isfinite(low) or not math.isfinite(high):
        return f"{finding},,,not known"
    holds = high > low if is_high_more else high < low
    return f"{finding},{low:.5g},{high:.5g},{'yes' if holds else 'no'}"


def _write_tables(session: Session, figure: Figure, measured: list[tuple[RecordedRun, list[FrictionFacts]]]) -> None:
    rows = ["run,frame,time,stick_share,mean_way,centre_height"]
    means = ["run,stick_share,mean_way,centre_height"]
    for run, (recorded, facts) in zip(figure.runs, measured):
        rows += [f"{run.name},{number},{recorded.frames[number].time:.6g},{one.format()}"
                 for number, one in enumerate(facts, start=1)]
        means.append(f"{run.name},{compute_last(facts).format()}")
    low, high = (compute_last(facts) for _, facts in measured)
    write_table(session, "fig6_frames.csv", rows)
    write_table(session, "fig6.csv", means)
    write_table(session, "fig6_findings.csv", [
        "finding,low,high,verdict",
        format_finding("more contacts stick with high friction", low.stick_share, high.stick_share, True),
        format_finding("the cloth goes less far with high friction", low.way, high.way, False),
        format_finding("its centre stays higher with high friction", low.centre_height, high.centre_height, True)])


def _draw(session: Session, figure: Figure, measured: list[tuple[RecordedRun, list[FrictionFacts]]]) -> None:
    panels = [Panel("Contacts that stick", "time [s]", "share"), Panel("Mean way of the cloth", "time [s]", "[m]"),
              Panel("Height of its centre", "time [s]", "[m]")]
    for run, (recorded, facts) in zip(figure.runs, measured):
        for frame, one in zip(recorded.frames[1:], facts):
            for panel, value in zip(panels, (one.stick_share, one.way, one.centre_height)):
                if math.isfinite(value):
                    panel.add(run.name, frame.time, value)
    draw(session, panels, "fig6.svg")


def make(session: Session, figure: Figure) -> None:
    """figure.runs: example one with low and with high friction."""
    runs = [open_moving_run(session, run) for run in figure.runs]
    measured = []
    for recorded in runs if all(runs) else []:
        assert recorded is not None
        session.stop_if_interrupted()
        try:
            measured.append((recorded, measure_frames(recorded)))
        except DamagedRun as damage:
            raise Failure(Exit.BAD_INPUT, str(damage)) from damage
    if measured:
        _write_tables(session, figure, measured)
        _draw(session, figure, measured)
    make_stills(session, figure)
