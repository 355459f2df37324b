"""The figures and tables of the paper: the runs of each, what the paper shows, what is done here and what differs.

The texts are HTML.
"""
from __future__ import annotations

from dataclasses import dataclass

from reproduce.scenes import METHODS, Run

LOW_FRICTION, HIGH_FRICTION = Run("example_one_low_friction"), Run("example_one_high_friction")
EXAMPLE_ONE = (LOW_FRICTION, HIGH_FRICTION)
ANIMATION_NUMBERS = range(1, 7)
ANIMATIONS = tuple(Run(f"animation_{number}", "patches") for number in ANIMATION_NUMBERS)
ANIMATIONS_FOUR_WAYS = tuple(Run(f"animation_{number}", method) for number in ANIMATION_NUMBERS for method in METHODS)
RINGS_AND_RIBBONS = (Run("rings"), Run("ribbons"))
EVERY_SCENE = (*EXAMPLE_ONE, *ANIMATIONS, *RINGS_AND_RIBBONS)


@dataclass(frozen=True)
class Figure:
    """A figure or table of the paper."""

    name: str
    title: str
    runs: tuple[Run, ...]
    paper: str  # what the paper shows
    ours: str  # what is done here
    differences: str  # what differs and why
    items: tuple[tuple[str, str], ...] = ()  # tables and plots: file in the directory of the results, caption
    has_stills: bool = False  # of all its runs


FIGURES = (
    Figure(
        "fig6", "Fig. 6: example one, low and high friction", EXAMPLE_ONE,
        paper=(
            "A cloth of 9,801 particles and 19,200 triangles, some particles held along lines, falls on rigid "
            "bodies of 2,827 particles and 5,472 triangles in gravity and stochastic wind; 2,400 frames of "
            "1/90 s. With low friction it slips off, with high friction it stays. The paper shows pictures and"
            " gives no number for this."),
        ours=(
            "The scene has the same sizes and is run with low and with high friction. Numbers that tell "
            "slipping from staying, as means over the last quarter: the share of contacts that stick, the mean"
            " way of the cloth's particles from where they started [m], the height of its centre [m]."),
        differences=(
            "The paper gives neither the bodies' shapes nor the coefficients of friction; ours stand in the "
            "scene files. Cloth that has slipped off comes to rest on the ground, whose contacts count for the"
            " share that sticks; cloth that stays hangs between its held lines and the bodies, at the limit of"
            " friction, where each gust moves most of its contacts by some micrometres. The way and the height"
            " tell more. Friction acts inside the implicit solve, not on forces before it."),
        items=(("fig6.csv", "Means over the last quarter"),
               ("fig6_findings.csv", "Slips or stays"),
               ("fig6.svg", "Over time")),
        has_stills=True,
    ),
    Figure(
        "fig7", "Fig. 7: the angle of patches", EXAMPLE_ONE,
        paper=(
            "Self-collision detection of example one, scene (a) of Fig. 6, which is that with low friction, "
            "with the largest surface angle from 30 to 89 degrees: 0.8 s a frame at 30 degrees, 0.23 s at 85, "
            "the best, 0.26 s at 89. Over the run 1,910 s at 30 degrees, 700 s at 60, 540 s at 85; with the "
            "cloth against the rigid bodies too 2,070, 860 and 780 s. Figs. 7b and 7c show these three frame "
            "by frame, Fig. 7d the shares of partitioning, tree construction, traversal and intrinsic test: "
            "from 30 to 89 degrees traversal becomes shorter and partitioning longer."),
        ours=(
            "Recorded frames of example one with low friction, from each one to the next, given to the "
            "detector with the contact distance of the scene as separation; all angles and all rules take "
            "turns on the same frame. With one thread times are of the processor, in which other work on the "
            "machine hardly counts, with several of the wall clock. <b>paper</b>: patches grown at every "
            "frame, the paper's cone, no certificate. <b>proven</b>: the same trees, tighter cones, only "
            "patches that are proven not to touch themselves are skipped. <b>patches</b>: one refitted tree, "
            "patches that live from frame to frame and are proven; asked about the still frame first, untimed,"
            " so that what they cost to grow, which the first two pay at every frame, is not in the times. "
            "<b>bvox</b>: trees without patches, the same work at every angle: its longest mean over its "
            "shortest tells how far the machine's other load changed the times. Times over the run are the "
            "mean of a frame times the number of frames. The last table is the same for high friction at the "
            "paper's three angles."),
        differences=(
            "Another machine, by two decades; so ratios to the time at 30 degrees stand beside the paper's. "
            "The intrinsic test here is a conservative time of impact in place of a cubic and a test of the "
            "end; the paper leaves out pairs that collided in the last frame from it, this detector knows no "
            "frame before. With the paper's rules collisions within a patch are missed, see the "
            "counterexamples."),
        items=(("fig7_findings.csv", "Against the paper's statements"),
               ("fig7a.svg", "7a: self-collision by angle"),
               ("fig7b.svg", "7b: self-collision frame by frame"),
               ("fig7_totals.csv", "7c: with obstacles, over the run"),
               ("fig7c.svg", "7c: with obstacles, frame by frame"),
               ("fig7d.svg", "7d: shares"),
               ("fig7_angles.csv", "7a and 7d: all numbers"),
               ("fig7_high.csv", "The same with high friction")),
    ),
    Figure(
        "table1", "Table 1: animations 1 to 6", ANIMATIONS_FOUR_WAYS,
        paper=(
            "Animations 1 to 6 at steps of 0.033 s (the first) and 0.02 s, with the proposed method at 85 "
            "degrees, BVOX-AABB trees alone, and a constant (refitted) AABB tree: what collision detection "
            "(CS), dynamics (DYN) and conjugate gradients (CGM) cost. The performance of the proposed method "
            "is the best, followed by BVOX-AABB and, last, the AABB tree. The table's numbers are in a picture"
            " and not published as text."),
        ours=(
            "The same scenes run four times: <b>paper</b>, by the paper's rules at 85 degrees without "
            "certificate, <b>bvox</b>, <b>refit</b>, and <b>patches</b>, which are kept and proven. Means of a "
            "step [ms] over the steps that all four have: CS is patches, trees, search, choice of contacts, and the "
            "tests of paths with what impacts do, which are one stage; CGM the linear solves with contact; DYN the "
            "rest."),
        differences=(
            "Sizes and shapes of the scenes are ours, since the paper tells few. The contact solve is coupled "
            "to the dynamics, so CGM holds work that the paper counts as response. Runs by the paper's rules "
            "miss collisions, so their states and their costs drift from those of the others; the judge counts"
            " frames with intersections. The runs are made one after another: the linear solves of bvox, refit"
            " and patches are the same work, and same_work_ratio, their longest time over their shortest, "
            "tells how far the machine's other load changed the times. Differences of CS below it say nothing:"
            " in rankings ~ stands between such methods, and a claim that only they stand against is within "
            "the noise."),
        items=(("table1.csv", "Costs of a step"),
               ("table1_ranking.csv", "The paper's ranking, by CS"),
               ("table1.svg", "CS of the four methods")),
    ),
    Figure(
        "fig8", "Fig. 8: animations 1 to 6", ANIMATIONS,
        paper=(
            "1: a net slips over the head of a nail, down a bumpy slope, hits a small nail and falls on sharp "
            "crests. 2: a large net falls over sceptres that stand in bumpy ground and collides with itself. "
            "3: a cloth falls on a hemisphere, slips over a rough surface and falls on crests. 4: a long "
            "ribbon slips over two rows of 12 tiles into the gap between them. 5: a cloth falls over a smooth "
            "and a rough object: one part slips, one sticks. 6: 80 needles in a spiral on a hemisphere leave "
            "one by one, in strong wind."),
        ours=(
            "Three stills of each, from the runs with our patches."),
        differences=(
            "Sizes, shapes and materials are ours. The paper smooths its results by Loop subdivision for "
            "pictures; these show the particles' triangles as they are."),
        has_stills=True,
    ),
    Figure(
        "fig9", "Fig. 9: rings and ribbons", RINGS_AND_RIBBONS,
        paper=(
            "9a: nine rings slip over a cape in wind. 9b: nine long ribbons fall on obstacles."),
        ours=(
            "Three stills of each. The rings are rigid bodies that the cloth pushes back."),
        differences=(
            "Sizes and shapes are ours."),
        has_stills=True,
    ),
    Figure(
        "counterexamples", "What the rule for patches misses", EVERY_SCENE,
        paper=(
            "Section 3.3 skips every pair of triangles within one patch whose normals stay within a cone, and "
            "says that this misses collisions of two parts of one patch at different sides, and in surfaces "
            "with holes or narrow regions; section 7 leaves them open. No number is given."),
        ours=(
            "Two motions, both clean at the start and at the end: a spiral ramp that is turned upside down, "
            "and an open ring whose ends go through each other. Then recorded frames of the paper's scenes, "
            "from each one to the next, with the contact distance of the scene: what a search without patches "
            "finds (events), what the paper's rules find at their best angle, 85 degrees, and what they miss. "
            "The last column is the same with only those patches skipped that are proven not to touch "
            "themselves."),
        differences=(
            "The frames are those of runs in which nothing was missed, so each one starts clean; in a run by "
            "the paper's rules a collision that was missed once stays."),
        items=(("counterexamples_motions.csv", "Motions made for this"),
               ("counterexamples_scenes.csv", "Recorded frames of the scenes")),
    ),
)


def add_runs(figure: Figure, runs: list[Run]) -> None:
    """Adds the runs of a figure that are not there yet."""
    runs.extend(run for run in figure.runs if run not in runs)


def list_runs() -> list[Run]:
    """Every run of any figure once."""
    runs: list[Run] = []
    for figure in FIGURES:
        add_runs(figure, runs)
    return runs
