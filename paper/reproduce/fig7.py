"""Fig. 7: what self-collision detection of the recorded frames of example one costs at patch angles from 30 to 89
degrees, by the paper's rules, by patches that are proven and by ours, which live from frame to frame; with obstacles
too at three angles. All angles take turns on each frame, so that the machine's other load troubles all of them alike.
Each frame's times are kept in measured/fig7_ANGLE.csv under the conditions, the run and the angle that they were
measured with.

Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects, 2005, section 6, Fig. 7.
"""
from __future__ import annotations

import re
from dataclasses import dataclass, fields

from reproduce.figures import Figure
from reproduce.frames import Measure, choose_frames, describe
from reproduce.kept import Kept
from reproduce.plots import PUBLISHED, Panel, draw
from reproduce.recorded import RecordedRun
from reproduce.runs import open_moving_run, read_scene
from reproduce.scenes import Run, SceneFacts
from reproduce.session import Exit, Failure, Session, write_table

MS = 1000.0  # [ms/s]
FRAMES_QUICK, FRAMES_FULL = 100, 300
ANGLES = (30, 35, 40, 45, 50, 55, 60, 65, 70, 75, 80, 85, 89)  # [degrees]
FEW_ANGLES = (30, 60, 85)
FIRST, BEST, LAST = 30, 85, 89  # [degrees] the smallest; the paper's best; the largest

# The last one knows no angle: the same work at each, and so what the machine's other load does to the times.
RULES = ("paper", "proven", "patches", "bvox")
SHOWN = {"paper": "the rules of the paper", "patches": "patches kept and proven"}  # frame by frame

ROW_HEAD = ("frame,rules,partition,trees,traversal,intrinsic,total,with_obstacles,events,patches,patch_triangles")
ANGLES_HEAD = ("rules,angle,self_ms,self_run_seconds,partition_percent,trees_percent,traversal_percent,"
               "intrinsic_percent,patches,patch_triangles_percent,events,published_self_ms,"
               "published_self_run_seconds")
TOTALS_HEAD = ("rules,angle,total_ms,self_run_seconds,total_run_seconds,ratio_to_30,published_self_run_seconds,"
               "published_total_run_seconds,published_ratio_to_30")
SECONDS = r"(\d+(?:\.\d+)?(?:e[+-]\d+)?)"
ROW = re.compile(",".join([SECONDS] * 6 + [r"(\d+)"] * 3))


@dataclass(frozen=True)
class Published:
    """What the paper tells of an angle."""

    self_seconds: float  # [s] a frame; 0: not told, as the following
    self_total: float = 0.0  # [s] over the run
    total_seconds: float = 0.0  # [s] over the run, obstacles too: it shows these angles' curves


PUBLISHED_TIMES = {30: Published(0.8, 1910, 2070), 60: Published(0, 700, 860), 85: Published(0.23, 540, 780),
                   89: Published(0.26)}


def has_curve(angle: int) -> bool:
    """Whether the paper shows the angle frame by frame."""
    return angle in PUBLISHED_TIMES and PUBLISHED_TIMES[angle].total_seconds > 0.0


@dataclass
class Times:
    """One frame, or sums over frames."""

    partition: float = 0.0  # [s] as the following, cloth alone
    trees: float = 0.0
    traversal: float = 0.0
    intrinsic: float = 0.0
    total: float = 0.0
    with_obstacles: float = 0.0  # [s] 0: not asked
    events: int = 0
    patches: int = 0
    patch_triangles: int = 0

    def add(self, other: Times) -> None:
        """Adds a frame to the sums."""
        for one in fields(Times):
            setattr(self, one.name, getattr(self, one.name) + getattr(other, one.name))

    def compute_share(self, seconds: float) -> float:
        """[%] of the whole time."""
        return 100.0 * seconds / self.total if self.total > 0.0 else 0.0


def parse_times(row: str | None) -> Times | None:
    """The times that a row tells, whole from its beginning to its end."""
    match = ROW.fullmatch(row) if row is not None else None
    if not match:
        return None
    partition, trees, traversal, intrinsic, total, with_obstacles = (float(cell) for cell in match.groups()[:6])
    events, patches, patch_triangles = (int(cell) for cell in match.groups()[6:])
    return Times(partition, trees, traversal, intrinsic, total, with_obstacles, events, patches, patch_triangles)


class Measurement:
    """The frames of one run at some angles: what was measured before, and what is measured."""

    def __init__(self, session: Session, run: Run, recorded: RecordedRun, angles: tuple[int, ...], label: str) -> None:
        self.session = session
        self.recorded = recorded
        self.angles = angles
        self.facts: SceneFacts = read_scene(session, run)
        self.kept = {angle: self._open_kept(angle, label) for angle in angles}
        self.sums = {(rules, angle): Times() for rules in RULES for angle in angles}
        self.by_frame: list[tuple[str, int, int, Times]] = []  # rules, angle, frame: of angles with a curve
        self.looks = 0  # frames that were looked at
        self._measured: set[int] = set()  # angles

    def _open_kept(self, angle: int, label: str) -> Kept:
        """Rows of an angle, kept in measured/fig7_LABELANGLE.csv."""
        obstacles = " obstacles" if has_curve(angle) else ""
        head = (f"# conditions {self.session.conditions} build {self.session.build} "
                f"{describe(self.recorded, self.facts)} angle {angle}{obstacles}\n{ROW_HEAD}\n")
        return Kept(self.session.path(f"measured/fig7_{label}{angle}.csv"), head, 2)

    def look(self) -> None:
        """All frames at all angles."""
        frames = choose_frames(len(self.recorded.frames), FRAMES_QUICK if self.session.is_quick else FRAMES_FULL)
        self.session.progress.begin_work()
        with Measure(self.session, "angles", self.recorded, self.facts) as measure:
            try:
                for frame in frames:
                    self.session.stop_if_interrupted()
                    self._look_at_frame(frame, measure)
                    count = len(self.angles)
                    self.session.progress.show_work("fig7", self.looks * count, len(frames) * count)
            finally:
                for kept in self.kept.values():
                    kept.save()
                self.session.progress.end_work()

    def _look_at_frame(self, frame: int, measure: Measure) -> None:
        """One frame at every angle. Each frame begins with another one, which finds the frame's positions not yet in
        the processor's caches."""
        first = self.looks % len(self.angles)
        turns = self.angles[first:] + self.angles[:first]
        found = {angle: self._find(frame, angle) for angle in turns}
        missing = [angle for angle in turns if found[angle] is None]
        self.session.progress.skip_work(len(turns) - len(missing))
        if missing:
            measure.ask([f"{frame} {angle}{' obstacles' if has_curve(angle) else ''}" for angle in missing])
        for angle in missing:
            found[angle] = self._take(frame, angle, measure)
        for angle in self.angles:
            for rules, times in zip(RULES, found[angle] or ()):
                self.sums[rules, angle].add(times)
                if has_curve(angle):
                    self.by_frame.append((rules, angle, frame, times))
        self.looks += 1

    def _find(self, frame: int, angle: int) -> list[Times] | None:
        """What was measured before by each of the rules; None where any is not known."""
        found = [parse_times(self.kept[angle].find(f"{frame},{rules}")) for rules in RULES]
        return None if None in found else [times for times in found if times]

    def _take(self, frame: int, angle: int, measure: Measure) -> list[Times]:
        """What is measured by each of the rules."""
        found = []
        rows = [measure.read_row() for _ in RULES]
        for row, rules in zip(rows, RULES):
            key = f"{frame},{rules},"
            times = parse_times(row[len(key):]) if row.startswith(key) else None
            if not times:
                raise Failure(Exit.CANNOT_GO_ON, f"paper_measure answered \"{row}\" about frame {frame}")
            self.kept[angle].add(row)
            found.append(times)
        if angle not in self._measured:  # saved at once: the file is there from the first frame on
            self.kept[angle].save()
        self._measured.add(angle)
        return found

    def compute_mean(self, angle: int, rules: str) -> float:
        """[s] mean of a frame."""
        return self.sums[rules, angle].total / self.looks

    def compute_total(self, angle: int, rules: str) -> float:
        """[s] the same with obstacles."""
        return self.sums[rules, angle].with_obstacles / self.looks

    def compute_noise(self) -> float:
        """The same work at every angle: its longest time over its shortest."""
        means = [self.compute_mean(angle, "bvox") for angle in self.angles]
        return max(means) / min(means)


# ---- tables ----

def _format_published(value: float) -> str:
    """A number that the paper tells, or nothing."""
    return f"{value:g}" if value > 0.0 else ""


def write_angles(measured: Measurement, file: str) -> None:
    """A line an angle and rules."""
    run_frames = len(measured.recorded.frames) - 1
    triangles = sum(body.triangle_count for body in measured.recorded.cloths)
    lines = [ANGLES_HEAD]
    for angle in measured.angles:
        for rules in RULES:
            sums, mean = measured.sums[rules, angle], measured.compute_mean(angle, rules)
            told = PUBLISHED_TIMES.get(angle, Published(0)) if rules == "paper" else Published(0)
            shares = ",".join(f"{sums.compute_share(part):.3g}"
                              for part in (sums.partition, sums.trees, sums.traversal, sums.intrinsic))
            lines.append(f"{rules},{angle},{MS * mean:.5g},{mean * run_frames:.5g},{shares},"
                         f"{sums.patches / measured.looks:.4g},"
                         f"{100.0 * sums.patch_triangles / (measured.looks * triangles):.3g},{sums.events},"
                         f"{_format_published(MS * told.self_seconds)},{_format_published(told.self_total)}")
    write_table(measured.session, file, lines)


def write_frames(measured: Measurement) -> None:
    """Frame by frame, at the angles whose curves the paper shows."""
    frames = measured.recorded.frames
    write_table(measured.session, "fig7_frames.csv", [
        "rules,angle,frame,time,self_ms,total_ms",
        *(f"{rules},{angle},{frame},{frames[frame].time:.6g},{MS * times.total:.5g},{MS * times.with_obstacles:.5g}"
          for rules, angle, frame, times in measured.by_frame)])


def write_totals(measured: Measurement) -> None:
    """Times over the run with obstacles."""
    run_frames = len(measured.recorded.frames) - 1
    lines = [TOTALS_HEAD]
    for angle in filter(has_curve, measured.angles):
        told = PUBLISHED_TIMES[angle]
        for rules in RULES:
            total = measured.compute_total(angle, rules)
            lines.append(f"{rules},{angle},{MS * total:.5g},{measured.compute_mean(angle, rules) * run_frames:.5g},"
                         f"{total * run_frames:.5g},{total / measured.compute_total(FIRST, rules):.4g},"
                         f"{told.self_total:g},{told.total_seconds:g},"
                         f"{told.total_seconds / PUBLISHED_TIMES[FIRST].total_seconds:.4g}")
    write_table(measured.session, "fig7_totals.csv", lines)


def judge_ratio(ratio: float, noise: float) -> str:
    """Whether a ratio that the paper has above 1 is so here, beyond what the machine's load can do."""
    if ratio > noise:
        return "yes"
    return "no" if ratio * noise < 1.0 else "within the noise"


def judge_best(means: dict[int, float], noise: float) -> tuple[int, str]:
    """The angle with the shortest mean, the smallest of several, and whether it is the paper's."""
    best = min(means, key=means.__getitem__)
    is_near = means[BEST] <= noise * means[best]
    return best, "yes" if best == BEST else "within the noise" if is_near else "no"


def write_findings(measured: Measurement) -> None:
    """What the paper says beside what was found."""
    noise = measured.compute_noise()
    means = {angle: measured.compute_mean(angle, "paper") for angle in measured.angles}
    first, last = measured.sums["paper", FIRST], measured.sums["paper", LAST]
    told = PUBLISHED_TIMES
    best, verdict = judge_best(means, noise)
    ratios = (
        ("time at 30 degrees over time at 85", means[FIRST] / means[BEST],
         told[FIRST].self_seconds / told[BEST].self_seconds),
        ("time at 30 degrees over time at 89", means[FIRST] / means[LAST],
         told[FIRST].self_seconds / told[LAST].self_seconds),
        ("traversal at 30 degrees over traversal at 89", first.traversal / last.traversal, None),
        ("partition at 89 degrees over partition at 30", last.partition / first.partition, None),
        ("with obstacles: time at 30 degrees over time at 85",
         measured.compute_total(FIRST, "paper") / measured.compute_total(BEST, "paper"),
         told[FIRST].total_seconds / told[BEST].total_seconds),
    )
    write_table(measured.session, "fig7_findings.csv", [
        "finding,ours,published,verdict",
        f"best angle of the paper's rules [degrees],{best},{BEST},{verdict}",
        *(f"{finding},{ratio:.3g},{'above 1' if theirs is None else f'{theirs:.3g}'},{judge_ratio(ratio, noise)}"
          for finding, ratio, theirs in ratios),
        f"same work at all angles (bvox): longest over shortest,{noise:.4g},,"])


# ---- plots ----

ANGLE_AXIS = "largest surface angle [degrees]"


def draw_means(measured: Measurement) -> None:
    """7a."""
    means = Panel("Self-collision of a frame", ANGLE_AXIS, "mean time [ms]")
    ratios = Panel("The same, in times of 30 degrees", ANGLE_AXIS, "ratio")
    for angle in measured.angles:
        for rules in RULES:
            mean = measured.compute_mean(angle, rules)
            means.add(rules, angle, MS * mean)
            ratios.add(rules, angle, mean / measured.compute_mean(FIRST, rules))
        told = PUBLISHED_TIMES.get(angle)
        if told and told.self_seconds > 0.0:
            ratios.add(PUBLISHED, angle, told.self_seconds / PUBLISHED_TIMES[FIRST].self_seconds)
    draw(measured.session, [means, ratios], "fig7a.svg")


def draw_curves(measured: Measurement) -> None:
    """7b, and 7c: the curves, and the means in times of the first."""
    curves = {rules: Panel(f"Self-collision frame by frame, {text}", "frame", "time [ms]")
              for rules, text in SHOWN.items()}
    totals = {rules: Panel(f"With obstacles frame by frame, {text}", "frame", "time [ms]")
              for rules, text in SHOWN.items()}
    for rules, angle, frame, times in measured.by_frame:
        if rules in SHOWN:
            curves[rules].add(f"{angle} degrees", frame, MS * times.total)
            totals[rules].add(f"{angle} degrees", frame, MS * times.with_obstacles)
    means = Panel("Mean with obstacles, in times of 30 degrees", ANGLE_AXIS, "ratio")
    for angle in filter(has_curve, measured.angles):
        for rules in RULES:
            means.add(rules, angle, measured.compute_total(angle, rules) / measured.compute_total(FIRST, rules))
        means.add(PUBLISHED, angle, PUBLISHED_TIMES[angle].total_seconds / PUBLISHED_TIMES[FIRST].total_seconds)
    draw(measured.session, list(curves.values()), "fig7b.svg")
    draw(measured.session, [*totals.values(), means], "fig7c.svg")


def draw_shares(measured: Measurement) -> None:
    """7d."""
    panels = []
    for rules, text in SHOWN.items():
        panel = Panel(f"Shares, {text}", ANGLE_AXIS, "share [%]")
        for angle in measured.angles:
            sums = measured.sums[rules, angle]
            for name, part in (("partition", sums.partition), ("trees", sums.trees), ("traversal", sums.traversal),
                               ("intrinsic test", sums.intrinsic)):
                panel.add(name, angle, sums.compute_share(part))
        panels.append(panel)
    draw(measured.session, panels, "fig7d.svg")


def make(session: Session, figure: Figure) -> None:
    """figure.runs: example one with low and with high friction."""
    low, high = (open_moving_run(session, run) for run in figure.runs)
    if low:
        measured = Measurement(session, figure.runs[0], low, ANGLES, "")
        measured.look()
        write_frames(measured)
        write_angles(measured, "fig7_angles.csv")
        write_totals(measured)
        write_findings(measured)
        draw_means(measured)
        draw_curves(measured)
        draw_shares(measured)
    if high:
        measured = Measurement(session, figure.runs[1], high, FEW_ANGLES, "high_")
        measured.look()
        write_angles(measured, "fig7_high.csv")
