#!/usr/bin/env python3
"""Measures the house, and holds it to limits that may only fall.

usage: check_limits.py [ROOT]              prints each figure beside its limit; exit 1 where one is over its limit
       check_limits.py [ROOT] --lower      also: appends a row for each figure that has fallen
       check_limits.py --self-test

tools/limits.csv has a row for each limit: date, figure, value, granted. The last row of a figure is its limit. Rows are
appended, never changed. A row that is higher than the one before says in `granted` what the growth was for.

What a step reaches is counted by tools/count_reach.py: as a whole, and in a world that has started. Members are those of
the struct itself. A file sees the context of a step if it includes step/step_context.h. The booleans of stage 7 are the
members of type bool in the headers and files that steer it (STAGE_7). Lines are raw lines of *.c and *.h.
Habits are those of tools/count_habits.py.
"""
import csv
import datetime
import os
import re
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import check_sizes  # noqa: E402
import count_habits  # noqa: E402
import count_reach  # noqa: E402

COLUMNS = ["date", "figure", "value", "granted"]
LIMITS = "tools/limits.csv"
STARTS = ["world_start"]
STRUCTS = {"tulle_world": "src/world/world_state.h", "step_model": "src/step/step_model.h", "motion_state": "src/step/motion_state.h",
           "step_work": "src/step/step_work.h", "substep": "src/step/step_work.h", "step_context": "src/step/step_context.h", "retry_state": "src/step/step_context.h"}
CONTEXT = "step/step_context.h"
STAGE_7 = ("src/contact/response.h", "src/contact/solve/solve_motion.h", "src/contact/solve/solve_motion.c", "src/step/step_context.h")
STRUCT = re.compile(r"\bstruct\s+(\w+)\s*\{")


def read_code(root, path):
    with open(os.path.join(root, path), encoding="utf-8") as file:
        return check_sizes.TOKEN.sub(check_sizes.blank, file.read())


def find_structs(code):
    """{name: the text between its braces}, of structs of the top level."""
    return {match.group(1): code[opened + 1:closed] for head, opened, closed in check_sizes.split_top_level(code)
            if (match := STRUCT.search(code, head, opened + 1))}


def split_members(body):
    """The declarations of a struct, without what is within inner braces; `int a, b;` are two."""
    while "{" in body:
        body = re.sub(r"\{[^{}]*\}", "", body)
    members = []
    for declaration in body.split(";"):
        flat = re.sub(r"\([^()]*\)", "", re.sub(r"\([^()]*\)", "", declaration)) if "ARRAY" in declaration or "(*" in declaration else declaration
        members += [" ".join(part.split()) for part in ([declaration] if flat != declaration else declaration.split(",")) if part.strip()]
    return members


def list_sources(root):
    for folder, _, names in sorted(os.walk(os.path.join(root, "src"))):
        for name in sorted(names):
            if name.endswith((".c", ".h")):
                yield os.path.relpath(os.path.join(folder, name), root).replace(os.sep, "/")


def measure(root):
    """{figure: value}."""
    figures = {}
    for kernels in (False, True):
        graph = count_reach.make_graph(*count_reach.read_functions(root, kernels))
        for started in (False, True):
            reached = count_reach.find_reached(graph, "tulle_world_step", STARTS if started else ())
            what = ("of a started world" if started else "and of the start") + (" with kernels" if kernels else "")
            figures[f"functions of a step {what}"] = len(reached)
            figures[f"depth of a step {what}"] = max(depth for depth, _ in reached.values())
    for name, path in STRUCTS.items():
        figures[f"members of {name}"] = len(split_members(find_structs(read_code(root, path))[name]))
    figures["booleans of stage 7"] = sum(
        bool(re.match(r"bool\b", member))
        for path in STAGE_7 for body in find_structs(read_code(root, path)).values() for member in split_members(body))
    sources = list(list_sources(root))
    texts = {}
    for path in sources:
        with open(os.path.join(root, path), encoding="utf-8") as file:
            texts[path] = file.read()
    figures["files that see the context of a step"] = sum(f'#include "{CONTEXT}"' in text for text in texts.values())
    figures["lines of src"] = sum(text.count("\n") for text in texts.values())
    for folder in sorted({path.split("/")[1] for path in sources if path.count("/") > 1}):
        figures[f"lines of src/{folder}"] = sum(text.count("\n") for path, text in texts.items() if path.startswith(f"src/{folder}/"))
    figures.update({f"hindering habits in {area}": number for area, number in count_habits.count(root).items()})
    return figures


def read_limits(text):
    """{figure: limit}, and what is wrong with the rows."""
    limits, wrong, last = {}, [], ""
    rows = csv.DictReader(text.splitlines())
    if rows.fieldnames != COLUMNS:
        return limits, [f"{LIMITS}:1: the columns should be {','.join(COLUMNS)}"]
    for line, row in enumerate(rows, 2):
        place, figure = f"{LIMITS}:{line}", row["figure"]
        if not re.fullmatch(r"\d{4}-\d\d-\d\d", row["date"] or "") or row["date"] < last:
            wrong.append(f"{place}: the date {row['date']!r} should be year-month-day, not before that of the row above")
        if not (row["value"] or "").isdigit():
            wrong.append(f"{place}: the value {row['value']!r} should be a whole number")
            continue
        value, last = int(row["value"]), row["date"] or last
        if figure in limits and value > limits[figure] and not row["granted"]:
            wrong.append(f"{place}: {figure}: {value} is over the limit before, {limits[figure]}, and nothing says what for")
        limits[figure] = value
    return limits, wrong


def read_past(root):
    """The texts of the limits that git knows, the newest first; none where there is no git."""
    git = ["git", "-C", root]
    try:
        log = subprocess.run([*git, "log", "--format=%H", "--", LIMITS], capture_output=True, text=True, check=True).stdout
        return [subprocess.run([*git, "show", f"{commit}:{LIMITS}"], capture_output=True, text=True, check=True).stdout
                for commit in log.split()]
    except (OSError, subprocess.CalledProcessError):
        return []


def judge(figures, text, past=()):
    """What is wrong: one line each."""
    limits, wrong = read_limits(text)
    wrong += [f"{LIMITS}: rows that stood there were changed; append a row instead" for before in past if not text.startswith(before)][:1]
    for figure, value in figures.items():
        if figure not in limits:
            wrong.append(f"{figure}: {value}, and no row of {LIMITS} limits it")
        elif value > limits[figure]:
            wrong.append(f"{figure}: {value} is over its limit, {limits[figure]}; take out what can go")
    wrong += [f"{LIMITS}: nothing measures {figure!r}" for figure in limits if figure not in figures]
    return wrong


SELF_TEST_STRUCT = """struct a { int one, two; bool three; ARRAY(int, x) four; struct { int x; bool y; } five; void (*six)(int, int); };
typedef struct b { bool is_b; } b;
"""


def self_test():
    good = "date,figure,value,granted\n2026-01-01,a,10,\n2026-01-02,b,3,\n2026-01-03,a,9,\n"
    cases = [(good, {"a": 9, "b": 3}, (), 0), (good, {"a": 10, "b": 3}, (), 1), (good, {"a": 8, "b": 3}, (), 0),
             (good + "2026-01-04,a,11,\n", {"a": 11, "b": 3}, (), 1), (good + "2026-01-04,a,11,sleeves\n", {"a": 11, "b": 3}, (), 0),
             (good + "2026-01-01,a,8,\n", {"a": 8, "b": 3}, (), 1), (good, {"a": 9, "b": 3, "c": 1}, (), 1), (good, {"a": 9}, (), 1),
             (good, {"a": 9, "b": 3}, (good[:40],), 0), (good, {"a": 9, "b": 3}, (good.replace("10", "12"),), 1),
             ("date,figure\n", {}, (), 1), (good + "2026-01-04,a,x,\n", {"a": 9, "b": 3}, (), 1)]
    for number, (text, figures, past, count) in enumerate(cases):
        wrong = judge(figures, text, past)
        if len(wrong) != count:
            print(f"self-test: case {number} tells {wrong}, expected {count} lines")
            return 1
    structs = {name: split_members(body) for name, body in find_structs(SELF_TEST_STRUCT).items()}
    if [len(structs["a"]), len(structs["b"])] != [6, 1] or structs["b"] != ["bool is_b"]:
        print(f"self-test: members are {structs}")
        return 1
    with tempfile.TemporaryDirectory() as root:
        if read_past(root):
            print("self-test: there are past limits without git")
            return 1
    print("self-test: limits are held")
    return 0


def main():
    arguments = [a for a in sys.argv[1:] if a != "--lower"]
    if arguments == ["--self-test"]:
        return self_test()
    if len(arguments) > 1 or any(a.startswith("-") for a in arguments):
        print(__doc__, file=sys.stderr)
        return 2
    root = arguments[0] if arguments else os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    figures = measure(root)
    with open(os.path.join(root, LIMITS), encoding="utf-8") as file:
        text = file.read()
    limits, _ = read_limits(text)
    for figure, value in figures.items():
        print(f"{value:7} of {limits.get(figure, '-'):>7}  {figure}")
    if "--lower" in sys.argv:
        today = datetime.date.today().isoformat()
        text += "".join(f"{today},{figure},{value},\n" for figure, value in figures.items() if value < limits.get(figure, value + 1))
        with open(os.path.join(root, LIMITS), "w", encoding="utf-8") as file:
            file.write(text)
    wrong = judge(figures, text, read_past(root))
    print("\n".join(wrong or [f"limits: {len(figures)} figures, none over its limit"]))
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
