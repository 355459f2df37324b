"""Table 1: what collision detection, dynamics and the linear solves of animations 1 to 6 cost a step, by the paper's
three ways of finding pairs and by ours, and whether the ranking is the paper's.

Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects, 2005, section 6, Table 1.
"""
from __future__ import annotations

from dataclasses import dataclass, field

from reproduce.figures import ANIMATION_NUMBERS, Figure
from reproduce.judge import Verdict, read_verdict
from reproduce.plots import Panel, draw
from reproduce.recorded import STAGES, read_run
from reproduce.runs import get_directory, open_moving_run
from reproduce.scenes import METHODS
from reproduce.session import DamagedRun, Exit, Failure, Session, say, write_table

MS = 1000.0  # [ms/s]
PAPER_METHODS = ("paper", "bvox", "refit")  # in the paper's ranking, cheapest first
SAME_WORK = ("bvox", "refit", "patches")  # lead to the same states, so their linear solves are the same work
CLAIM = " < ".join(PAPER_METHODS)

# The part of a step that each of its stages belongs to; those that are not named are dynamics. The stage gather_rows
# measures near pairs and chooses contacts. The stage resolve_impacts tests all paths beside what impacts do, and the
# tests take nearly all of its time. So both count as collision detection.
CS, DYN, CGM = "cs", "dyn", "cgm"
STAGE_COSTS = {"update_patches": CS, "build_trees": CS, "find_pairs": CS, "gather_rows": CS, "resolve_impacts": CS,
               "solve_motion": CGM}
TABLE_HEAD = ("animation,method,cloth_particles,cloth_triangles,obstacle_particles,obstacle_triangles,steps,cs_ms,"
              "dyn_ms,cgm_ms,step_ms,state,bad_frames,conditions")
RANKING_HEAD = "animation,paper_ranking,our_ranking,verdict,with_patches,same_work_ratio"


@dataclass
class Cell:
    """An animation by one method, over as many steps as all its runs have."""

    verdict: Verdict
    steps: int = 0  # 0: nothing tells its times
    sums: dict[str, float] = field(default_factory=dict)  # [s] of each part
    total: float = 0.0  # [s]

    def compute_cost(self, part: str) -> float:
        """[ms] a step."""
        return MS * self.sums[part] / self.steps if self.steps > 0 else 0.0


Cells = dict[str, Cell]


def read_cells(session: Session, figure: Figure, number: int) -> Cells:
    """The cells of one animation, by method; those whose run is not there are missing."""
    runs = {run.method: run for run in figure.runs if run.scene == f"animation_{number}"}
    cells = {}
    for method in METHODS:
        verdict = read_verdict(session, runs[method]) if open_moving_run(session, runs[method]) else None
        if verdict:
            cells[method] = Cell(verdict)
    timed = [method for method, cell in cells.items() if cell.verdict.has_reports]
    steps = min((cells[method].verdict.steps for method in timed), default=0)
    for method in timed:
        try:
            reports = read_run(get_directory(session, runs[method])).read_reports()
        except DamagedRun as damage:
            raise Failure(Exit.BAD_INPUT, str(damage)) from damage
        cell = cells[method]
        cell.steps = steps
        cell.sums = {CS: 0.0, DYN: 0.0, CGM: 0.0}
        for stage, seconds in zip(STAGES, reports["stage_seconds"][:steps].sum(axis=0)):
            cell.sums[STAGE_COSTS.get(stage, DYN)] += float(seconds)
        cell.total = float(reports["total_seconds"][:steps].sum())
    return cells


def format_cell(number: int, method: str, cell: Cell) -> str:
    """A line of table1.csv."""
    verdict = cell.verdict
    times = (f"{cell.steps},{cell.compute_cost(CS):.4g},{cell.compute_cost(DYN):.4g},{cell.compute_cost(CGM):.4g},"
             f"{MS * cell.total / cell.steps:.4g}" if cell.steps > 0 else "0,,,,")
    return (f"{number},{method},{verdict.cloth_vertices},{verdict.cloth_triangles},{verdict.obstacle_vertices},"
            f"{verdict.obstacle_triangles},{times},{verdict.state},{verdict.bad_frames},{verdict.conditions}")


def compute_disturbance(cells: Cells) -> float:
    """The longest over the shortest linear solves of those that do the same work: how far the machine's other load
    changed the times."""
    costs = [cells[method].compute_cost(CGM) for method in SAME_WORK]
    return max(costs) / min(costs) if min(costs) > 0.0 else 0.0


def rank(cells: Cells, methods: tuple[str, ...], noise: float) -> str:
    """"bvox < refit ~ paper": the methods by what detection costs, cheapest first; ~ between two that differ by less
    than the machine's load can."""
    costs = {method: cells[method].compute_cost(CS) for method in methods}
    ranked = sorted(methods, key=costs.__getitem__)
    text = ranked[0]
    for last, method in zip(ranked, ranked[1:]):
        text += f" {'<' if costs[method] > noise * costs[last] else '~'} {method}"
    return text


def judge_claim(cells: Cells, noise: float) -> str:
    """The paper's claim: each method costs less than those that follow it."""
    costs = [cells[method].compute_cost(CS) for method in PAPER_METHODS]
    pairs = [(less, more) for place, less in enumerate(costs) for more in costs[place + 1:]]
    if any(less > noise * more for less, more in pairs):
        return "not confirmed"
    return "confirmed" if all(more > noise * less for less, more in pairs) else "within the noise"


def has_one_condition(cells: Cells) -> bool:
    """Whether all runs were made by one build with as many threads on one kind of processor."""
    conditions = {cell.verdict.conditions for cell in cells.values()}
    return len(conditions) == 1 and not conditions & {"mixed", "unknown"}


def format_finding(number: int, cells: Cells) -> str | None:
    """A line of table1_ranking.csv; None where a run is missing."""
    if len(cells) < len(METHODS):
        return None
    is_one = has_one_condition(cells)
    if not is_one:
        say(f"animation {number}: its times are not compared, since its runs were made by several builds, on several "
            f"processors or with several numbers of threads; without runs/animation_{number}.* they are made again")
    if not is_one or not all(cell.verdict.has_reports for cell in cells.values()):
        return f"{number},{CLAIM},,not compared,,"
    noise = compute_disturbance(cells)
    return (f"{number},{CLAIM},{rank(cells, PAPER_METHODS, noise)},{judge_claim(cells, noise)},"
            f"{rank(cells, tuple(METHODS), noise)},{noise:.4g}")


def make(session: Session, figure: Figure) -> None:
    """figure.runs: each animation by paper, bvox, refit and patches."""
    table, findings = [TABLE_HEAD], [RANKING_HEAD]
    panel = Panel("Collision detection (CS)", "animation", "CS of a step [ms]")
    for number in ANIMATION_NUMBERS:
        session.stop_if_interrupted()
        cells = read_cells(session, figure, number)
        table += [format_cell(number, method, cell) for method, cell in cells.items()]
        finding = format_finding(number, cells)
        if finding:
            findings.append(finding)
        for method, cell in cells.items():
            if cell.verdict.has_reports:
                panel.add(method, number, cell.compute_cost(CS))
    write_table(session, "table1.csv", table)
    write_table(session, "table1_ranking.csv", findings)
    draw(session, [panel], "table1.svg")
