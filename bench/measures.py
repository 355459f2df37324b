"""Measures of the bench: rows of a CSV file, tables of them, and what got worse between two files.

A row is a list of eight texts, the columns of HEAD; rows are a dictionary from the first five. lab/benchmarks.md describes them.
"""
import csv
import math
import os
import statistics
from pathlib import Path

HEAD = ["scene", "size", "threads", "kind", "name", "value", "minimum", "spread"]
KINDS = ("about", "time", "count", "memory", "hash", "instructions")

# Stages below this share of the step, before and now, are not judged: their times are those of the clock and the caches.
LEAST_SHARE = 0.01
# The fastest step by the clock over its processor time; undisturbed, system calls and page faults take a few per cent.
MOST_WAITING = 1.1
# [share] Other work on the machine changes the processor time of the same steps, through the caches: 14 % was seen.
DISTURBED_BOUND = 0.25
# [share] The C library chooses code by the processor, which changes less; a change of our code changes more.
INSTRUCTION_BOUND = 0.005
MEMORY_BOUND = 0.05  # [share] growth of arrays by doubling is not to be flagged twice


class Failed(Exception):
    """What ends the bench: a message, which may be empty where somebody else said it, and an exit code."""

    def __init__(self, message, code=2):
        super().__init__(message)
        self.code = code


# ---- rows ----

def is_number(text):
    try:
        return 0.0 <= float(text) < math.inf
    except ValueError:
        return False


def find_fault(fields):
    """What is wrong with the fields of a row, or None."""
    if len(fields) != len(HEAD):
        return f"has {len(fields)} fields, not the {len(HEAD)} that it should have"
    if fields[2] and not fields[2].isdecimal():
        return '"threads" should be a number, or empty'
    if fields[3] not in KINDS:
        return f'"kind" should be one of {", ".join(KINDS)}'
    if not fields[4]:
        return '"name" is empty'
    if fields[3] not in ("about", "hash") and not is_number(fields[5]):
        return '"value" should be a number of 0 or more'
    if fields[3] == "time" and not (is_number(fields[6]) and is_number(fields[7])):
        return '"minimum" and "spread" of a time should be numbers of 0 or more'
    return None


def read_rows(path):
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as fault:
        raise Failed(f"{path}: cannot be read: {fault}")
    lines = text.splitlines()
    if not lines or lines[0] != ",".join(HEAD):
        raise Failed(f"{path}:1: is no table of the bench: the first line should be {','.join(HEAD)}")
    if not text.endswith("\n"):
        raise Failed(f"{path}:{len(lines)}: the last line is cut off")
    rows = {}
    for number, fields in enumerate(csv.reader(lines[1:]), 2):
        fault = find_fault(fields)
        if fault:
            raise Failed(f"{path}:{number}: {fault}")
        rows[tuple(fields[:5])] = fields
    return rows


def write_rows(path, rows):
    """Writes beside the file and moves there, so that the file is whole at any time."""
    beside = f"{path}.{os.getpid()}.tmp"
    try:
        with open(beside, "w", encoding="utf-8") as file:
            file.write(",".join(HEAD) + "\n")
            file.writelines(",".join(fields) + "\n" for fields in rows.values())
        os.replace(beside, path)
    except OSError as fault:
        raise Failed(f"{path}: cannot be written: {fault.strerror}", 3)


def put(rows, case, kind, name, value):
    """case: scene, size, threads. Several values are the samples of a time."""
    fields = [*case, kind, name, str(value), "", ""]
    if kind == "time":
        median = statistics.median(value)
        spread = statistics.median(abs(sample - median) for sample in value)
        fields[5:] = [f"{median:.6g}", f"{min(value):.6g}", f"{spread:.3g}"]
    rows[tuple(fields[:5])] = fields


def get_value(rows, case, kind, name, column=5):
    """A number of a row, or None."""
    fields = rows.get((*case, kind, name))
    return float(fields[column]) if fields else None


def were_disturbed(rows, case):
    """Whether other work ran beside a case. False where it was not measured on one thread."""
    case = (*case[:2], "1")
    wall, used = get_value(rows, case, "time", "step", 6), get_value(rows, case, "time", "processor", 6)
    return wall is not None and used is not None and wall > MOST_WAITING * used


# ---- tables ----

def print_table(title, lines):
    """Markdown; the first line is the head. Nothing where there is no other."""
    if len(lines) < 2:
        return
    widths = [max(len(line[k]) for line in lines) for k in range(len(lines[0]))]
    print(title + "\n")
    for number, line in enumerate(lines):
        print("".join(f"| {cell:<{width}} " if k < 2 else f"| {cell:>{width}} " for k, (cell, width) in enumerate(zip(line, widths))) + "|")
        if number == 0:
            print("|---" * 2 + "|---:" * (len(line) - 2) + "|")
    print()


TIMES = (("processor", "processor"), ("predict", "predict_paths"), ("patches", "update_patches"), ("trees", "build_trees"),
         ("pairs", "find_pairs"), ("rows", "gather_rows"), ("forces", "compute_forces"), ("solve", "solve_motion"),
         ("impacts", "resolve_impacts"), ("commit", "commit_safely"), ("accept", "accept_state"))


def print_times(rows):
    def show(seconds):
        value = 1e3 * seconds
        return f"{value:.0f}" if value >= 99.95 else f"{value:.1f}" if value >= 9.995 else f"{value:.2f}"

    lines = [["scene", "size", "threads", "step (least, spread)", *(title for title, _ in TIMES)]]
    for key, fields in rows.items():
        if key[3:] == ("time", "step"):
            values = (get_value(rows, key[:3], "time", name) for _, name in TIMES)
            lines.append([*key[:3], "{} ({}, {})".format(*(show(float(text)) for text in fields[5:])),
                          *("-" if value is None else show(value) for value in values)])
    print_table("Medians of a step [ms]:", lines)


# Title: kind, whether sums over the steps are divided by their number, unit, names of what is added.
COUNTS = {
    "particles": ("count", False, 1.0, ("particles",)), "triangles": ("count", False, 1.0, ("cloth_triangles",)),
    "of obstacles": ("count", False, 1.0, ("obstacle_triangles",)), "contacts": ("count", True, 1.0, ("contacts",)),
    "candidates": ("count", True, 1.0, ("box_pairs",)), "tested": ("count", True, 1.0, ("tested_pairs",)),
    "searches": ("count", True, 1.0, ("pair_searches",)), "solves": ("count", True, 1.0, ("solve_count",)),
    "iterations": ("count", True, 1.0, ("cg_iterations",)), "substeps": ("count", True, 1.0, ("substeps",)),
    "rescues": ("count", True, 1.0, ("rescue_impact_zones", "rescue_component_scalings", "rescue_global_scalings")),
    "allocations": ("memory", True, 1.0, ("allocator_calls",)), "MB": ("memory", False, 1e-6, ("most_bytes",)),
    "M instructions": ("instructions", True, 1e-6, ("steps",)),
}


def print_counts(rows):
    """One line a scene and size: counts do not depend on threads."""
    lines, seen = [["scene", "size", *COUNTS]], set()
    for key, fields in rows.items():
        if key[3:] != ("count", "steps") or key[:2] in seen:
            continue
        seen.add(key[:2])
        line = list(key[:2])
        for kind, is_mean, unit, names in COUNTS.values():
            known = [value for value in (get_value(rows, key[:3], kind, name) for name in names) if value is not None]
            value = sum(known) * unit / (float(fields[5]) if is_mean else 1.0)
            has_decimals = (is_mean or unit < 1.0) and value < 999.95
            line.append(f"{value:.{1 if has_decimals else 0}f}" if known else "")
        lines.append(line)
    print_table("Counts, means of a step:", lines)


def print_scaling(rows, sizes):
    """What a particle takes in each size, of scenes in several sizes."""
    lines = [["scene", "size", "threads", "particles", "processor [ms]", "us a particle", "of the size before", "iterations",
              "bytes a particle", "resident"]]
    for scene in dict.fromkeys(key[0] for key in rows if key[0]):
        before, lines_of_scene = 0.0, []
        for size in sizes:
            case = next((key[:3] for key in rows if key[:2] == (scene, size) and key[3:] == ("time", "processor")), None)
            if not case:
                continue
            values = [get_value(rows, case, kind, name) for kind, name in (
                ("count", "particles"), ("time", "processor"), ("memory", "most_bytes"), ("count", "cg_iterations"), ("count", "steps"))]
            if None in values:
                continue
            count, processor, held, iterations, steps = values
            each, resident = processor / count, get_value(rows, case, "about", "most_resident")
            lines_of_scene.append([*case, f"{count:.0f}", f"{1e3 * processor:.4g}", f"{1e6 * each:.1f}",
                                   f"{each / before:.2f}" if before > 0.0 else "", f"{iterations / steps:.1f}", f"{held / count:.0f}",
                                   f"{resident / count:.0f}" if resident else ""])
            before = each
        if len(lines_of_scene) > 1:
            lines += lines_of_scene
    print_table("What a particle takes:", lines)


# ---- compared ----

class Comparison:
    """What got worse or changed since a baseline; prints a line for each.

    Times are judged between equal processors only. A time is slower when even its minimum is above the baseline's median by more
    than both spreads, and faster when its median is below the baseline's minimum by as much. Where other work ran on the machine,
    then or now, only processor time is judged, and it must differ by a bound, too. Counts do not depend on the machine: from the
    same state they must be the same. Instructions and memory may differ by a small bound."""

    def __init__(self, baseline, rows):
        self.baseline, self.rows = baseline, rows
        self.compared = self.slower = self.changed = self.grown = self.faster = 0

    def is_same(self, case, kind, name):
        """Whether both have the same text, and have one at all."""
        old, now = (rows.get((*case, kind, name)) for rows in (self.baseline, self.rows))
        return old is not None and now is not None and old[5] == now[5]

    def tell(self, verdict, key, text):
        print(f"{verdict:<8} {key[0]} {key[1]}, {key[2]} thread{'' if key[2] == '1' else 's'}{text}")

    def tell_values(self, verdict, key, old, now, unit, behind=""):
        times = f", {now / old:.3f} times" if old > 0.0 else ""
        form = ".0f" if unit != " ms" else ".4g"
        self.tell(verdict, key, f", {key[4]}: {now:{form}}{unit}, was {old:{form}}{unit}{times}{behind}")

    def compare_times(self, key, old, now):
        steps = (get_value(rows, key[:3], "time", "step") for rows in (self.baseline, self.rows))
        if not any(step is not None and fields[0] >= LEAST_SHARE * step for step, fields in zip(steps, (old, now))):
            return
        is_busy = were_disturbed(self.baseline, key[:3]) or were_disturbed(self.rows, key[:3])
        if is_busy and key[4] == "step":
            self.tell("note:", key, ": other work ran beside; only processor time is compared")
        if is_busy and key[4] != "processor":
            return
        spreads = max(old[2] + now[2], DISTURBED_BOUND * old[0] if is_busy else 0.0)
        is_slower, is_faster = now[1] > old[0] + spreads, now[0] + spreads < old[1]
        self.compared += 1
        self.slower += is_slower
        self.faster += is_faster
        if is_slower or is_faster:
            self.tell_values("slower:" if is_slower else "faster:", key, 1e3 * old[0], 1e3 * now[0], " ms",
                             f" (spreads {1e3 * old[2]:.2g} and {1e3 * now[2]:.2g} ms)")

    def compare_bounded(self, key, old, now, bound):
        has_grown, has_shrunk = now > old * (1.0 + bound), now < old * (1.0 - bound)
        self.compared += 1
        self.grown += has_grown
        self.faster += has_shrunk
        if has_grown or has_shrunk:
            self.tell_values("more:" if has_grown else "less:", key, old, now, " instructions" if key[3] == "instructions" else "")

    def compare_row(self, key, judges_times, judges_instructions):
        kind, old, now = key[3], self.baseline[key], self.rows[key]
        starts_alike, is_start = self.is_same(key[:3], "hash", "start"), key[3:] == ("hash", "start")
        if is_start and not starts_alike:
            self.tell("note:", key, ": starts from another state than the baseline did; its counts and instructions are not compared")
        if kind == "time" and judges_times:
            self.compare_times(key, *([float(text) for text in fields[5:]] for fields in (old, now)))
        elif kind == "memory":
            self.compare_bounded(key, float(old[5]), float(now[5]), MEMORY_BOUND)
        elif kind == "instructions" and starts_alike and judges_instructions:
            self.compare_bounded(key, float(old[5]), float(now[5]), INSTRUCTION_BOUND)
        elif kind in ("count", "hash") and starts_alike and not is_start:
            self.compared += 1
            if kind == "hash" and old[5] != now[5]:
                self.changed += 1
                self.tell("changed:", key, ": the steps end in another state")
            elif kind == "count" and float(old[5]) != float(now[5]):
                self.changed += 1
                self.tell_values("changed:", key, float(old[5]), float(now[5]), "")

    def compare(self):
        """The number of measures that got worse."""
        judges_times, judges_instructions = (self.is_same(("", "", ""), "about", name) for name in ("processor", "compiler"))
        if not judges_times:
            print("note:    the baseline was measured on another processor; times are not compared")
        if not judges_instructions:
            print("note:    the baseline was built by another compiler; instructions are not compared")
        for key in self.rows:
            if key in self.baseline and key[3] != "about":
                self.compare_row(key, judges_times, judges_instructions)
        missing = sum(key[3:] == ("time", "step") and key not in self.baseline for key in self.rows)
        if missing:
            print(f"note:    {missing} cases are not in the baseline")
        print(f"compared {self.compared} measures: {self.slower} slower, {self.changed} changed, {self.grown} more of instructions or "
              f"memory; {self.faster} faster or less")
        return self.slower + self.changed + self.grown
