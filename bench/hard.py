"""Runs the hard scenes, scenes/hard, and tells how even their steps are.

    python3 bench/hard.py                      # all of them, a table in Markdown; some ten minutes
    python3 bench/hard.py thrown stiff         # some of them
    python3 bench/hard.py --threads 2 --csv hard.csv

Times of steps are of the clock on the wall, so other work beside them shows. processor_s is what the whole run used of the
processor. most_stretch_percent is the longest yarn or edge over its length at rest. Exit code: 0, or 1 if a step took more than
20 times its scene's median, a solve did not come to its end, or a frame holds an intersection.
"""

import argparse
import csv
import resource
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
MOST_OF_MEDIAN = 20.0
CASES = {  # name: scene, changes
    "silk_1cm": ("silk_1cm", []),
    "strips": ("strips", []),
    "thrown": ("thrown", []),
    "thrown_120": ("thrown", ["cloth[0].mesh.resolution=[120, 120]"]),
    "gear": ("gear", []),
    "four_layers": ("four_layers", []),
    "huge": ("huge", []),
    "stiff": ("stiff", []),
    "soft": ("stiff", ["cloth[0].material.warp.stiffness=1", "cloth[0].material.weft.stiffness=1",
                       "cloth[0].material.shear.stiffness=0.1", "cloth[0].material.poisson=0"]),
}
COLUMNS = ["scene", "particles", "steps", "processor_s", "median_ms", "p95_ms", "most_ms", "most_of_median", "solves", "iterations",
           "most_iterations", "cut_steps", "most_substeps", "not_converged", "rescues", "most_stretch_percent", "crossings", "message"]


def get_processor_seconds():
    """What children that have ended used of the processor."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def run_case(program, name, threads, limit, folder):
    """A row of the table for one scene."""
    scene, changes = CASES[name]
    out = Path(folder) / name
    words = [program, "run", str(ROOT / "scenes/hard" / f"{scene}.yaml"), "-o", str(out), "-t", str(threads), "--progress", "none"]
    for change in changes:
        words += ["--set", change]
    before = get_processor_seconds()
    run = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    messages = []
    try:
        run.wait(limit)
    except subprocess.TimeoutExpired:
        messages.append(f"stopped after {limit} s")
        run.send_signal(signal.SIGINT)  # it ends the step under way, or undoes it
    errors = run.communicate()[1]
    row = dict.fromkeys(COLUMNS, "")
    row["scene"] = name
    row["processor_s"] = f"{get_processor_seconds() - before:.1f}"
    if run.returncode != 0 and not messages:
        messages.append(errors.strip().splitlines()[-1])
    check = subprocess.run([program, "check", str(out)], capture_output=True, text=True)
    row["crossings"] = 0 if check.returncode == 0 else "some"
    if check.returncode != 0:
        messages.append((check.stdout + check.stderr).strip().splitlines()[-1])
    with open(out / "report.csv") as file:
        steps = list(csv.DictReader(file))
    if not steps:
        row.update(steps=0, not_converged=0, most_of_median="inf", message="; ".join([*messages, "no step ended"]))
        return row
    times = sorted(1000.0 * float(step["total_seconds"]) for step in steps)
    count = len(times)
    mean = lambda column: sum(float(step[column]) for step in steps) / count
    median, most = times[count // 2], times[-1]
    row.update(steps=count, median_ms=f"{median:.1f}", p95_ms=f"{times[int(0.95 * count)]:.1f}", most_ms=f"{most:.1f}",
               most_of_median=f"{most / median:.1f}", solves=f"{mean('solve_count'):.1f}", iterations=f"{mean('cg_iterations'):.0f}",
               most_iterations=max(int(step["cg_iterations"]) for step in steps),
               cut_steps=sum(int(step["substeps"]) > 1 for step in steps),
               most_stretch_percent=f"{100.0 * (max(float(step['max_stretch']) for step in steps) - 1.0):.1f}",
               most_substeps=max(int(step["substeps"]) for step in steps),
               not_converged=sum(int(step["cg_converged"]) == 0 for step in steps),
               rescues=sum(int(step[f"rescue_{kind}"]) for step in steps
                           for kind in ("impact_zones", "component_scalings", "global_scalings")))
    row["message"] = "; ".join(messages)
    return row


def count_particles(program, name):
    """Vertices of all cloth in the scene."""
    scene, changes = CASES[name]
    words = [program, "info", str(ROOT / "scenes/hard" / f"{scene}.yaml")]
    for change in changes:
        words += ["--set", change]
    told = subprocess.run(words, capture_output=True, text=True).stdout.splitlines()
    return sum(int(line.split(" vertices")[0].split()[-1]) for line in told if line.startswith("  cloth ") and " vertices" in line)


def main():
    """Runs what was asked for."""
    reader = argparse.ArgumentParser(description="how even the steps of hard scenes are", epilog=f"scenes: {', '.join(CASES)}")
    reader.add_argument("cases", metavar="SCENE", nargs="*", help="all unless given")
    reader.add_argument("--threads", type=int, default=1)
    reader.add_argument("--limit", type=int, default=300, help="seconds for a scene (default: 300)")
    reader.add_argument("--csv", metavar="FILE", help="write the rows there too")
    reader.add_argument("--tulle", metavar="FILE", default=str(ROOT / "build/release/tulle"), help="the program")
    options = reader.parse_args()
    unknown = [case for case in options.cases if case not in CASES]
    if unknown:
        reader.error(f"no scene {unknown[0]}; there are {', '.join(CASES)}")
    rows = []
    print("| " + " | ".join(COLUMNS) + " |\n|" + "---|" * len(COLUMNS), flush=True)
    with tempfile.TemporaryDirectory() as folder:
        for name in options.cases or CASES:
            row = run_case(options.tulle, name, options.threads, options.limit, folder)
            row["particles"] = count_particles(options.tulle, name)
            rows.append(row)
            print("| " + " | ".join(str(row[column]) for column in COLUMNS) + " |", flush=True)
    if options.csv:
        with open(options.csv, "w", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
    bad = [row for row in rows if row["message"] or row["not_converged"] or float(row["most_of_median"]) > MOST_OF_MEDIAN]
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
