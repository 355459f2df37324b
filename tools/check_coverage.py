#!/usr/bin/env python3
"""Judges which lines and branches of the two libraries the tests have run.

usage: check_coverage.py BUILD         BUILD: a folder made by the preset `coverage`, whose tests have been run
       check_coverage.py --self-test   proves that what is missing is found

Prints a table by folder, and writes BUILD/unreached.txt: the lines that no test runs, and the lines of which a branch is never
taken. Fails where a library is below LINES or BRANCHES, and where an exclusion is at fault. The program is shown, not judged.

A branch is one way out of a condition: `a && b` has two conditions, so four branches. gcov counts them in what the compiler makes
of the source. So the preset compiles without inlining, which would count the branches of a function once for each caller, and
with NDEBUG, since the branch of an assert that fails is one that no test should take.

An exclusion is a comment with the marker that gcovr knows and the reason:
    /* GCOVR_EXCL_LINE: REASON */                            this line
    /* GCOVR_EXCL_START: REASON */ ... /* GCOVR_EXCL_STOP */ the lines from the one to the other
    /* GCOVR_EXCL_BR_LINE: REASON */                         the branches of this line (BR_START and BR_STOP likewise)
It is at fault if it has no reason, has no end, or if the tests run all that it excludes. Exclusions may take EXCLUDED of the lines.
"""
import json
import os
import re
import subprocess
import sys
import tempfile

from check_layers import ENGINE, IO

LINES, BRANCHES, EXCLUDED = 0.95, 0.90, 0.01  # least, least, most
LIBRARIES = [("libtulle", ENGINE), ("libtulle_io", IO)]
SHOWN = LIBRARIES + [("program", ["render", "app"])]
MARKER = re.compile(r"GCOVR_EXCL_(BR_)?(LINE|START|STOP)\b(?::[ \t]*(\w[^*\n]*))?")


class Tally:
    """Lines and branches: how many there are, how many were reached, how many lines are excluded."""
    def __init__(self):
        self.lines = self.lines_run = self.branches = self.branches_taken = self.excluded = 0

    def add(self, other):
        for name in vars(self):
            setattr(self, name, getattr(self, name) + getattr(other, name))


def get_share(part, whole):
    return part / whole if whole else 1.0


def find_exclusions(text):
    """Exclusions as [first line, last line, whether branches only], and faults as (line, reason)."""
    exclusions, faults, opened = [], [], {}
    for number, line in enumerate(text.split("\n"), 1):
        for is_branch, kind, reason in MARKER.findall(line):
            if kind != "STOP" and not reason.strip():
                faults.append((number, "an exclusion without a reason"))
            if kind == "LINE":
                exclusions.append([number, number, bool(is_branch)])
            elif (kind == "START") == (is_branch in opened):
                faults.append((number, f"{kind} of an exclusion without its {'STOP' if kind == 'START' else 'START'}"))
            elif kind == "START":
                opened[is_branch] = number
            else:
                exclusions.append([opened.pop(is_branch), number, bool(is_branch)])
    return exclusions, faults + [(number, "START of an exclusion without its STOP") for number in opened.values()]


def merge_lines(entries):
    """{line: (count, [count of each branch])} of a file's entries. A line has an entry for each function and each object file that has it."""
    lines = {}
    for entry in entries:
        count, branches = lines.get(entry["line_number"], (0, []))
        more = [branch["count"] for branch in entry["branches"]]
        length = max(len(branches), len(more))
        sums = [a + b for a, b in zip(branches + [0] * (length - len(branches)), more + [0] * (length - len(more)))]
        lines[entry["line_number"]] = (count + entry["count"], sums)
    return lines


def judge_file(path, entries, text):
    """The tally of one file, what is unreached as texts, and the faults of its exclusions as texts."""
    lines, tally, unreached = merge_lines(entries), Tally(), []
    exclusions, found = find_exclusions(text)
    faults = [f"{path}:{number}: {reason}" for number, reason in found]
    without_line, without_branches = set(), set()
    for first, last, is_branch in exclusions:
        inside = [number for number in lines if first <= number <= last]
        (without_branches if is_branch else without_line).update(inside)
        tally.excluded += len(inside)
        if all(all(lines[number][1]) if is_branch else lines[number][0] for number in inside):
            faults.append(f"{path}:{first}: the tests run what is excluded; the exclusion can go")
    source, missing = text.split("\n"), []
    for number, (count, branches) in sorted(lines.items()):
        if number in without_line:
            continue
        tally.lines += 1
        tally.lines_run += count > 0
        if number not in without_branches:
            taken = sum(branch > 0 for branch in branches)
            tally.branches += len(branches)
            tally.branches_taken += taken
            if count and taken < len(branches):
                code = source[number - 1].strip()
                unreached.append((number, f"{path}:{number}: {len(branches) - taken} of {len(branches)} branches: {code}"))
        if count:
            missing = []
        elif missing:
            missing.append(number)
            unreached[-1] = (missing[0], f"{path}:{missing[0]}-{number}: {len(missing)} lines: {source[missing[0] - 1].strip()}")
        else:
            missing = [number]
            unreached.append((number, f"{path}:{number}: 1 line: {source[number - 1].strip()}"))
    return tally, [line for _, line in unreached], faults


def judge(report, root):
    """The tally of each folder, the unreached texts of the libraries and the faults, of {path: entries of its lines as gcov gives them}."""
    folders, unreached, faults = {}, [], []
    for path, entries in sorted(report.items()):
        folder = path.split("/")[1]
        with open(os.path.join(root, path), encoding="utf-8") as source:
            tally, missing, found = judge_file(path, entries, source.read())
        folders.setdefault(folder, Tally()).add(tally)
        if folder in ENGINE + IO:
            unreached += missing
        faults += found
    for name, parts in LIBRARIES:
        total = get_total(folders, parts)
        if not total.lines:
            faults.append(f"{name}: not a line was counted")
        for what, part, whole, least in (("lines", total.lines_run, total.lines, LINES),
                                         ("branches", total.branches_taken, total.branches, BRANCHES)):
            if get_share(part, whole) < least:
                faults.append(f"{name}: {100 * get_share(part, whole):.2f} % of the {what} are reached, less than {100 * least:.0f} %")
        if total.excluded > EXCLUDED * (total.lines + total.excluded):
            faults.append(f"{name}: {total.excluded} lines are excluded, more than {100 * EXCLUDED:.0f} %")
    return folders, unreached, faults


def get_total(folders, parts):
    total = Tally()
    for folder in parts:
        total.add(folders.get(folder, Tally()))
    return total


def print_table(folders):
    print(f"{'folder':14}{'lines':>8}{'reached':>9}{'':>9}{'branches':>10}{'reached':>9}{'':>9}{'excluded':>10}")
    for name, parts in SHOWN:
        for title, tally in [("  " + folder, folders.get(folder, Tally())) for folder in parts] + [(name, get_total(folders, parts))]:
            print(f"{title:14}{tally.lines:8}{tally.lines_run:9}{100 * get_share(tally.lines_run, tally.lines):7.2f} %"
                  f"{tally.branches:10}{tally.branches_taken:9}{100 * get_share(tally.branches_taken, tally.branches):7.2f} %{tally.excluded:10}")


def make_report(build, root):
    """{path below root: entries of its lines} of all sources below root/src, from the counts that stand in the folder BUILD."""
    notes = [os.path.join(folder, name) for folder, _, names in os.walk(build) for name in names if name.endswith(".gcno")]
    files = {}
    for first in range(0, len(notes), 50):
        told = subprocess.run(["gcov", "--json-format", "--stdout", "--branch-probabilities"] + notes[first:first + 50],
                              check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        for document in told.stdout.splitlines():
            report = json.loads(document)
            for file in report["files"]:
                path = os.path.relpath(os.path.join(report["current_working_directory"], file["file"]), root)
                if path.startswith("src/"):
                    files.setdefault(path, []).extend(file["lines"])
    return files


def make_entry(number, count, *branches):
    return {"line_number": number, "count": count, "branches": [{"count": taken} for taken in branches]}


# What it shows: source, its entries, and the one fault (None: none); or the unreached texts.
FULL = [make_entry(number, 1, 1, 1) for number in range(10, 210)]
SELF_TEST = [
    ("all is reached", "", FULL, None, []),
    ("lines that are not run", "\n\nif (a)\n", FULL + [make_entry(number, 0) for number in (3, 4, 6, 300, 301)], None,
     ["src/base/a.c:3-6: 3 lines: if (a)", "src/base/a.c:300-301: 2 lines: "]),
    ("a line alone", "", FULL + [make_entry(1, 0), make_entry(2, 1)], None, ["src/base/a.c:1: 1 line: "]),
    ("branches of a line that is run", "if (a && b)\n", FULL + [make_entry(1, 5, 5, 0, 4, 1)], None,
     ["src/base/a.c:1: 1 of 4 branches: if (a && b)"]),
    ("two functions share a line", "", FULL + [make_entry(1, 0, 0, 0), make_entry(1, 1, 1), make_entry(1, 1, 0, 1)], None, []),
    ("94 % of lines", "", FULL[:94] + [make_entry(500 + k, 0) for k in range(6)], "94.00 % of the lines", None),
    ("89 % of branches", "", [make_entry(k, 1, 1, k >= 22) for k in range(100)], "89.00 % of the branches", None),
    ("nothing", "", [], "not a line was counted", None),
    ("an excluded line", "a; /* GCOVR_EXCL_LINE: no disk is that large */\n", FULL + [make_entry(1, 0, 0, 0)], None, []),
    ("excluded branches", "a; /* GCOVR_EXCL_BR_LINE: b is never 0 */\n", FULL + [make_entry(1, 1, 0, 1)], None, []),
    ("no reason", "a; /* GCOVR_EXCL_LINE */\n", FULL + [make_entry(1, 0)], "a.c:1: an exclusion without a reason", None),
    ("no reason either", "a; /* GCOVR_EXCL_LINE: */\n", FULL + [make_entry(1, 0)], "a.c:1: an exclusion without a reason", None),
    ("an excluded range", "/* GCOVR_EXCL_START: so */\na;\nb;\n/* GCOVR_EXCL_STOP */\n", FULL + [make_entry(2, 0), make_entry(3, 1)],
     None, []),
    ("no end", "/* GCOVR_EXCL_START: so */\na;\n", FULL + [make_entry(2, 0)], "a.c:1: START of an exclusion without its STOP", None),
    ("no start", "a;\n/* GCOVR_EXCL_STOP */\n", FULL, "a.c:2: STOP of an exclusion without its START", None),
    ("reached and excluded", "a; /* GCOVR_EXCL_LINE: so */\n", FULL + [make_entry(1, 1)], "a.c:1: the tests run what is excluded", None),
    ("branches reached and excluded", "a; /* GCOVR_EXCL_BR_LINE: so */\n", FULL + [make_entry(1, 1, 1, 1)], "the tests run what", None),
    ("too much excluded", "/* GCOVR_EXCL_START: so */\n\n\n\n/* GCOVR_EXCL_STOP */\n", FULL + [make_entry(k, 0) for k in (2, 3, 4)],
     "3 lines are excluded, more than 1 %", None),
]


def self_test():
    failures = 0
    for name, source, entries, expected, listed in SELF_TEST:
        with tempfile.TemporaryDirectory() as root:
            for folder in ("src/base", "src/io"):
                os.makedirs(os.path.join(root, folder))
                with open(os.path.join(root, folder, "a.c"), "w", encoding="utf-8") as file:
                    file.write((source if folder == "src/base" else "") + "\n" * 600)
            report = {"src/base/a.c": entries, "src/io/a.c": FULL}
            folders, unreached, faults = judge(report, root)
        is_right = (not faults) if expected is None else (len(faults) == 1 and expected in faults[0])
        if not is_right or (listed is not None and sorted(unreached) != sorted(listed)) or folders["io"].lines != len(FULL):
            failures += 1
            print(f"self-test {name}: expected {expected!r} and {listed}, found {faults} and {unreached}")
    print(f"self-test: {len(SELF_TEST) - failures} of {len(SELF_TEST)} cases right")
    return 1 if failures else 0


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    if len(sys.argv) != 2 or not os.path.isdir(sys.argv[1]):
        print("usage: check_coverage.py BUILD | --self-test", file=sys.stderr)
        return 2
    build, root = os.path.abspath(sys.argv[1]), os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    folders, unreached, faults = judge(make_report(build, root), root)
    print_table(folders)
    list_path = os.path.join(build, "unreached.txt")
    with open(list_path, "w", encoding="utf-8") as file:
        file.writelines(line + "\n" for line in unreached)
    print(f"coverage: {len(unreached)} places of the libraries are not reached: {list_path}; {len(faults)} faults")
    for fault in faults:
        print(fault)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
