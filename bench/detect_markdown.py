#!/usr/bin/env python3
"""Prints the tables of lab/detection.md from the CSV of bench_detect.

Usage: bench/detect_markdown.py build/bench_detect.csv [--fill lab/detection.md]
"""
import contextlib
import io
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "tools"))
from markdown_tables import fill, make_table, read_rows  # noqa: E402

# Totals of the design experiment, two threads, in ms: quoted, of another machine (two cores of a
# Zen 4 class server). What it took on a crumple, a twisted rod, a violent crumple, smooth cloth.
EXPERIMENT = {"crumple": "11.6", "bundle": "26.5", "violent": "63.1", "wave": "2.1 to 2.5"}
STAGES = ["patches", "trees", "traversal", "filters", "impact", "search", "events", "total"]


def number(row, key):
    return float(row[key])


def millions(value):
    return f"{int(float(value)):,}"


def print_table(head, rows):
    print(make_table(head, rows) + "\n")


def share(row):
    return 100.0 * number(row, "patch_triangles") / number(row, "triangles")


def print_kinds(rows):
    inputs = []
    for row in rows:
        if row["input"] not in inputs:
            inputs.append(row["input"])
    for name in inputs:
        of_input = [row for row in rows if row["input"] == name]
        first = of_input[0]
        print(f"`{name}`: {millions(first['vertices'])} vertices, {millions(first['triangles'])} "
              f"triangles, motion {first['motion_edges']} edges; the experiment took "
              f"{EXPERIMENT.get(name, '-')} ms.\n")
        out = []
        for row in of_input:
            refit = next(r for r in of_input if r["run"] == "refit" and r["threads"] == row["threads"])
            ratio = number(row, "total_median_ms") / number(refit, "total_median_ms")
            out.append([row["run"], row["threads"], millions(row["box_pairs"]),
                        millions(row["filtered_pairs"]), millions(row["tested_pairs"]),
                        row["events"], f"{share(row):.0f} %"]
                       + [f"{number(row, s + '_median_ms'):.2f}" for s in STAGES]
                       + [f"{number(row, 'total_min_ms'):.2f}", f"{number(row, 'total_p90_ms'):.2f}",
                          f"{ratio:.2f}"])
        print_table(["method", "threads", "box pairs", "filtered", "tested", "events", "in patches"]
                    + STAGES + ["least", "9th decile", "/ refit"], out)


def print_angles(rows):
    names = []
    for row in rows:
        if row["input"] not in names:
            names.append(row["input"])
    for name in names:
        of_input = [row for row in rows if row["input"] == name]
        refit = next(r for r in of_input if r["run"] == "refit")
        bvox = next(r for r in of_input if r["run"] == "bvox")
        print(f"`{name}`: {millions(refit['triangles'])} triangles, motion {refit['motion_edges']} "
              f"edges, {refit['threads']} threads\n")
        out = []
        for row in of_input:
            # boxes of searches with patches hold whole motions, as those of bvox do
            alike = bvox if row["uses_patches"] == "1" or row is bvox else refit
            pairs = max(number(alike, "box_pairs"), 1.0)
            total = number(row, "total_median_ms")
            out.append([row["run"], f"{share(row):.1f} %", row["patches"], millions(row["box_pairs"]),
                        f"{100.0 * (1.0 - number(row, 'box_pairs') / pairs):.1f} %",
                        "yes" if row["uses_patches"] == "1" else "no",
                        f"{number(row, 'patches_median_ms'):.2f}", f"{total:.2f}",
                        f"{total / number(refit, 'total_median_ms'):.2f}",
                        f"{total / number(bvox, 'total_median_ms'):.2f}"])
        print_table(["run", "triangles in patches", "patches", "box pairs", "culled", "in use",
                     "patches [ms]", "total [ms]", "/ refit", "/ bvox"], out)


def print_lasting(rows):
    names = []
    for row in rows:
        if row["input"] not in names:
            names.append(row["input"])
    out = []
    for name in names:
        of_input = [row for row in rows if row["input"] == name]
        refit = next(r for r in of_input if r["run"] == "refit")
        for row in of_input:
            out.append([name, row["run"], f"{share(row):.0f} %", row["patches"],
                        f"{number(row, 'patches_median_ms'):.2f}", f"{number(row, 'mean_ms'):.2f}",
                        f"{number(row, 'total_median_ms'):.2f}", f"{number(row, 'total_p90_ms'):.2f}",
                        f"{number(row, 'mean_ms') / number(refit, 'mean_ms'):.2f}",
                        f"{number(row, 'total_median_ms') / number(refit, 'total_median_ms'):.2f}",
                        f"{number(row, 'mean_part_ms') / number(refit, 'mean_ms'):.2f}"])
    print_table(["input", "run", "triangles in patches", "patches", "patches [ms]", "mean [ms]",
                 "median [ms]", "9th decile [ms]", "mean / refit", "median / refit",
                 "patches and search / refit"], out)


def print_growth(rows):
    for table, what in (("growth", "motion of 0.1 edges at every size"),
                        ("growth-same-motion", "motion as simulated, the same in metres")):
        chosen = [row for row in rows if row["table"] == table]
        if not chosen:
            continue
        base = {}
        out = []
        for row in sorted(chosen, key=lambda r: (r["run"], number(r, "triangles"))):
            each = [1e6 * number(row, key) / number(row, "triangles")
                    for key in ("total_median_ms", "processor_median_ms")]
            if number(row, "triangles") == 20000:
                base[row["run"]] = each
            growth = ([f"{a / b:.2f}" for a, b in zip(each, base[row["run"]])]
                      if row["run"] in base else ["-", "-"])
            out.append([row["run"], millions(row["triangles"]), row["motion_edges"],
                        millions(row["box_pairs"]), f"{number(row, 'total_median_ms'):.2f}",
                        f"{each[0]:.1f}", growth[0], f"{each[1]:.1f}", growth[1],
                        f"{number(row, 'bytes_held') / number(row, 'triangles'):.0f}",
                        f"{number(row, 'first_ms'):.0f}"])
        print(what.capitalize() + ":\n")
        print_table(["method", "triangles", "motion [edges]", "box pairs", "total [ms]",
                     "ns a triangle", "/ 20k", "processor ns a triangle", "/ 20k",
                     "bytes a triangle", "first pass [ms]"], out)


def print_busy(rows):
    out = []
    for row in rows:
        if row["table"] != "busy":
            continue
        idle = next(r for r in rows if r["table"] == "busy-idle" and r["input"] == row["input"]
                    and r["run"] == row["run"])
        before, after = number(idle, "total_median_ms"), number(row, "total_median_ms")
        out.append([row["input"], row["run"], f"{before:.2f}", f"{after:.2f}",
                    f"{number(row, 'total_p90_ms'):.2f}", f"{after / before:.2f}"])
    print_table(["input", "method", "idle [ms]", "busy [ms]", "busy, 9th decile", "busy / idle"], out)


def print_alarms(rows):
    out = []
    for row in rows:
        tested = max(number(row, "tested_pairs"), 1.0)
        keys = ("box_pairs", "coplanar_pairs", "filtered_pairs", "tested_pairs", "events", "touching",
                "missed", "false_alarms")
        out.append([row["input"], row["run"], row["motions"]] + [millions(row[key]) for key in keys]
                   + [f"{100.0 * number(row, 'false_alarms') / tested:.2f} %"])
    print_table(["input", "times the step", "motions", "box pairs", "coplanar", "filtered", "tested",
                 "events", "truly touch", "missed", "false alarms", "of tested"], out)


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    rows = read_rows(sys.argv[1])
    printers = {"kinds": print_kinds, "angles": print_angles, "lasting": print_lasting,
                "growth": print_growth,
                "busy": print_busy, "alarms": print_alarms}
    texts = {}
    for name, printer in printers.items():
        chosen = [row for row in rows if row["table"].startswith(name)]
        if chosen:
            with contextlib.redirect_stdout(io.StringIO()) as text:
                printer(chosen)
            texts[name] = text.getvalue().strip()
    if len(sys.argv) == 4 and sys.argv[2] == "--fill":
        fill(sys.argv[3], texts)
    else:
        print("\n\n".join(texts.values()))


if __name__ == "__main__":
    main()
