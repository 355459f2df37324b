#!/usr/bin/env python3
"""Makes the book's page of validation, docs/results/validation.md, of the rows that tulle_validate writes.

usage: make_validation_page.py                   the page of docs/results/validation.csv, anew
       make_validation_page.py CSV --build WORDS takes the rows of CSV (of `make validate`) into the book, and makes the page;
                                                 WORDS name the build that was measured
       make_validation_page.py --check           exit 1 if the page is not what this script makes
       make_validation_page.py --self-test       shows it rows of each kind

The rows in the book begin with a line "# build: WORDS". What an experiment shows is read from test/validation/*.c, as in
`tulle_validate --list`. An experiment that is there and has no row is named at the top of the page.
"""
import csv
import glob
import os
import re
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
ROWS, PAGE = "docs/results/validation.csv", "docs/results/validation.md"
BUILD = "# build: "
# Title, groups of experiments, what they have in common.
SECTIONS = (
    ("Cloth itself", ("fabric", "laws", "bends", "shears", "drape"), "Woven cloth without contact."),
    ("Friction", ("incline", "capstan", "layers", "tablecloth", "pinched", "carried", "between"), ""),
    ("Impacts and energy", ("impact", "settling"), ""),
    ("Sharp shapes", ("turning", "tips"), ""),
    ("Starts that intersect", ("untangle",), ""),
    ("Scenes", ("scenes",), "The scenes of `scenes/`, whole, as one line. Every frame is judged."),
    ("All experiments together", ("all",), ""),
)
EXPERIMENT = re.compile(r'^    \{"(\w+\.\w+)",\s*"([^"]*)"', re.M)
TOLERANCE = re.compile(r"\+- ([\d.eE+-]+)%")
SKIPPED, OFF = "skipped", "OFF"
LONGEST_REFERENCE = 30
INTRODUCTION = """# Validation

Experiments in mechanics whose result is known. `make validate` runs them all on one core in some hours, compares each measurement with the
expected value, and fails if one is off. `build/release/test/tulle_validate --only incline` runs one group, `--list` names all.
`make validate VALIDATE_OPTIONS=--quick` takes a minute. Steps last 1/90 s and values are the defaults, unless an experiment says otherwise.

A line for each experiment has the number of its judged measurements, of how many, and the judged measurement that is nearest to its bound.
All measurements are in [validation.csv](validation.csv), also those without an expected value, which are not judged. How each experiment is
built, with plots, other integrators and the response of the paper: [the diary of validation](../../lab/validation.md). What these
experiments do not cover: [known limits](index.md#known-limits).

    make validate
    python3 tools/make_validation_page.py build/validation/validation.csv --build "$(git rev-parse --short HEAD)"

makes this page again.
"""


def read_rows(path):
    """What the rows say of their build, and the rows as dictionaries."""
    with open(path, newline="", encoding="utf-8") as file:
        lines = file.read().splitlines(keepends=True)
    build = ""
    if lines and lines[0].startswith(BUILD):
        build = lines.pop(0)[len(BUILD):].strip()
    return build, list(csv.DictReader(lines))


def find_experiments(root):
    """{name: what it shows}, as test/validation names them."""
    found = {}
    for path in sorted(glob.glob(os.path.join(root, "test/validation/*.c"))):
        with open(path, encoding="utf-8") as file:
            found.update(EXPERIMENT.findall(file.read()))
    return found


def format_number(text):
    value = float(text)
    if value != value:
        return "-"
    if value == int(value) and abs(value) < 1e15:
        return f"{int(value):,}"
    return f"{value:.4g}"


def format_expected(row):
    words = TOLERANCE.sub(lambda match: f"± {float(match.group(1)):.3g} %", row["expected"]).replace("+-", "±")
    words = words.replace("<=", "≤").replace(">=", "≥")
    return words + (f" ({row['reference']})" if 0 < len(row["reference"]) <= LONGEST_REFERENCE else "")


def escape(words):
    return words.replace("|", "\\|").replace("<", "&lt;").replace("*", "\\*")


def measure_nearness(row):
    """How far a judged row is on the way to its bound: 0 is in the middle, 1 is at the bound; more if it is off."""
    measured, sign, rest = float(row["measured"]), row["expected"][:2], row["expected"][2:]
    if sign in ("<=", ">="):
        over, under = (measured, float(rest)) if sign == "<=" else (float(rest), measured)
        return over / under if under else float(over != 0)
    middle, _, percent = row["expected"].partition("+-")
    if not percent:
        return float(measured != float(middle))
    return abs(measured - float(middle)) / (abs(float(middle)) * float(percent.rstrip("%")) / 100)


def make_experiment(name, shows, rows):
    """One line of a table: what is shown, how many rows are judged, and the row that is nearest to its bound."""
    judged = [row for row in rows if row["verdict"] not in ("-", SKIPPED)]
    words = shows[:1].upper() + shows[1:] + "." if shows else ""
    cells = [f"`{name}`", escape(words), f"{len(judged)}/{len(rows)}"]
    if not judged:
        return "| " + " | ".join(cells + [SKIPPED, ""]) + " |"
    row = max(judged, key=measure_nearness)
    verdict = " **off**" if row["verdict"] == OFF else ""
    measured = f"{row['row']}: {format_number(row['measured'])} {row['unit']}".strip()
    return "| " + " | ".join(cells + [escape(measured) + verdict, escape(format_expected(row))]) + " |"


def count(number, one, many):
    return f"{number:,} {one if number == 1 else many}"


def make_summary(build, rows, experiments):
    judged = [row for row in rows if row["verdict"] not in ("-", SKIPPED)]
    off = [row for row in judged if row["verdict"] != "ok"]
    names = {row["experiment"] for row in rows} - {"all"}
    skipped = sum(row["verdict"] == SKIPPED for row in rows)
    sums = {row["row"]: float(row["measured"]) for row in rows if row["experiment"] == "all"}
    words = [f"Build: {build}." if build else ""]
    words.append(f"{count(len(names), 'experiment has', 'experiments have')} {count(len(rows), 'row', 'rows')}. "
                 f"{count(len(judged), 'row is', 'rows are')} judged: {count(len(off), 'is', 'are') if off else 'none is'} off."
                 + (f" {count(skipped, 'row is', 'rows are')} skipped." if skipped else ""))
    if "steps" in sums and "pairs of triangles that cross in them" in sums:
        words.append(f"Together they make {format_number(sums['steps'])} steps with {format_number(sums['contacts, summed over steps'])} contacts. "
                     f"The judge read {format_number(sums['states judged'])} states and found "
                     f"{count(int(sums['pairs of triangles that cross in them']), 'crossing', 'crossings')}.")
    missing = [name for name in experiments if name not in names]
    if missing:
        words.append("**Without a row in this file**: " + ", ".join(f"`{name}`" for name in missing) + ".")
    lines = wrap(" ".join(filter(None, words)), 140) + [""]
    for row in off:
        lines.append(f"- off: `{row['experiment']}`, {escape(row['row'])}")
    return lines + ([""] if off else [])


def wrap(words, width):
    lines = [""]
    for word in words.split():
        if lines[-1] and len(lines[-1]) + 1 + len(word) > width:
            lines.append("")
        lines[-1] += (" " if lines[-1] else "") + word
    return lines


def make_page(build, rows, experiments):
    lines = INTRODUCTION.splitlines() + [""] + make_summary(build, rows, experiments)
    known = {group for _, groups, _ in SECTIONS for group in groups}
    others = sorted({row["experiment"].split(".")[0] for row in rows} - known)
    for title, groups, words in SECTIONS + tuple((group, (group,), "") for group in others):
        names = dict.fromkeys(row["experiment"] for row in rows if row["experiment"].split(".")[0] in groups)
        if not names:
            continue
        lines += [f"## {title}", ""] + ([words, ""] if words else [])
        lines += ["| experiment | what it shows | judged | nearest to its bound: measured | expected |", "|---|---|---|---|---|"]
        if groups == ("scenes",):
            found = [dict(row, row=f"{row['experiment'].split('.')[1]}, {row['row']}") for row in rows if row["experiment"] in names]
            lines += [make_experiment("scenes.*", "whole scenes keep the promise", found), ""]
            continue
        lines += [make_experiment(name, experiments.get(name, ""), [row for row in rows if row["experiment"] == name]) for name in names] + [""]
    return "\n".join(lines).rstrip() + "\n"


def make_of_file(root):
    build, rows = read_rows(os.path.join(root, ROWS))
    return make_page(build, rows, find_experiments(root))


def self_test():
    head = ("experiment", "row", "measured", "unit", "expected", "verdict", "reference")
    make = lambda *cells: dict(zip(head, cells))
    rows = [make("a.b", "angle", "41.6311", "deg", "41.5 +- 2.40964%", "ok", "Peirce"), make("a.b", "path", "0.5", "m", "<= 0.1", OFF, "Peirce"),
            make("a.b", "size", "3", "m", "-", "-", ""), make("e.f", "angle", "41.6311", "deg", "41.5 +- 2.40964%", "ok", ""),
            make("e.f", "share", "8", "", ">= 2", "ok", ""), make("e.f", "zero", "0", "", "<= 0", "ok", ""),
            make("all", "steps", "91950", "", "-", "-", ""), make("incline.x", "z|z", "nan", "", "-", SKIPPED, "no mesh")]
    page = make_page("0123abc", rows, {"a.b": "a thing", "c.d": "another"})
    wanted = ("Build: 0123abc. 3 experiments have 8 rows. 5 rows are judged: 1 is off. 1 row is skipped.", "- off: `a.b`, path\n",
              "**Without a row in this file**: `c.d`.", "| `a.b` | A thing. | 2/3 | path: 0.5 m **off** | ≤ 0.1 (Peirce) |",
              "| `e.f` |  | 3/3 | share: 8 | ≥ 2 |", "| `incline.x` |  | 0/1 | skipped |  |", "## Friction\n")
    missing = [words for words in wanted if words not in page]
    for words in missing:
        print(f"self-test: the page lacks {words!r}")
    print(f"self-test: {len(wanted) - len(missing)} of {len(wanted)} cases right")
    return 1 if missing else 0


def main():
    arguments = sys.argv[1:]
    if arguments == ["--self-test"]:
        return self_test()
    if len(arguments) == 3 and arguments[1] == "--build":
        _, rows = read_rows(arguments[0])
        if not rows:
            sys.exit(f"{arguments[0]} has no rows")
        with open(arguments[0], newline="", encoding="utf-8") as file:
            text = re.sub(rf"\A{BUILD}.*\n", "", file.read())
        with open(os.path.join(ROOT, ROWS), "w", newline="", encoding="utf-8") as file:
            file.write(f"{BUILD}{arguments[2]}\n{text}")
    elif arguments not in ([], ["--check"]):
        sys.exit(__doc__)
    page, path = make_of_file(ROOT), os.path.join(ROOT, PAGE)
    if arguments == ["--check"]:
        with open(path, encoding="utf-8") as file:
            is_same = file.read() == page
        print(f"validation page: {PAGE} is what its rows say" if is_same else
              f"{PAGE} is not what its rows and test/validation say; write it anew: python3 tools/make_validation_page.py")
        return 0 if is_same else 1
    with open(path, "w", encoding="utf-8") as file:
        file.write(page)
    return 0


if __name__ == "__main__":
    sys.exit(main())
