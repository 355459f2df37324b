#!/usr/bin/env python3
"""Writes the rows of tulle_validate into docs/validation.md.

Usage: test/validation/fill_tables.py MAIN.csv [OTHER.csv ...] [--fill docs/validation.md]

MAIN.csv becomes the table between the marks `begin validation` and `end validation`; all files
together, one column each, the one between `begin responses` and `end responses`. Without --fill
both are printed.
"""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools"))
from markdown_tables import fill, make_table, read_rows  # noqa: E402


def short(text):
    value = float(text)
    return "-" if value != value else f"{value:.4g}"


def figure(row):
    if row["verdict"] == "skipped":
        return "skipped"
    return f"{short(row['measured'])} {row['unit']}".strip()


def marked(row):
    return f"**{figure(row)}**" if row["verdict"] == "OFF" else figure(row)


def validation(rows):
    out = []
    last = ""
    for row in rows:
        name = f"`{row['experiment']}`" if row["experiment"] != last else ""
        last = row["experiment"]
        out.append([name, row["row"], figure(row), row["expected"], row["reference"],
                    row["verdict"]])
    return make_table(["experiment", "what", "measured", "expected", "after", ""], out)


def way(row):
    parts = [row["response"]] + [row[key] for key in ("motion_space", "integrator")
                                 if row[key] not in ("-", "implicit-euler")]
    return ", ".join(parts)


def responses(files):
    """Rows of the first file, with the figures of all; those that are off are in bold."""
    head = ["experiment", "what", "expected"] + [way(rows[0]) for rows in files]
    out = []
    found = [{(row["experiment"], row["row"]): row for row in rows} for rows in files]
    groups = [{row["experiment"].split(".")[0] for row in rows} for rows in files]
    for row in files[0]:
        key = (row["experiment"], row["row"])
        if row["expected"] == "-":
            continue
        out.append([f"`{row['experiment']}`", row["row"], row["expected"]] +
                   [marked(rows[key]) if key in rows else
                    "**broke off**" if key[0].split(".")[0] in ran else "not run"
                    for rows, ran in zip(found, groups)])
    return make_table(head, out)


def main():
    arguments = sys.argv[1:]
    target = None
    if "--fill" in arguments:
        at = arguments.index("--fill")
        if at + 1 == len(arguments):
            sys.exit(__doc__)
        target = arguments[at + 1]
        del arguments[at:at + 2]
    if not arguments:
        sys.exit(__doc__)
    files = [rows for rows in map(read_rows, arguments) if rows]
    if not files:
        sys.exit("no rows")
    texts = {"validation": validation(files[0])}
    if len(files) > 1:
        texts["responses"] = responses(files)
    if target:
        fill(target, texts)
    else:
        print("\n\n".join(texts.values()))


if __name__ == "__main__":
    main()
