#!/usr/bin/env python3
"""Writes the rows of tulle_validate into docs/validation.md.

Usage: test/validation/fill_tables.py MAIN.csv [OTHER.csv ...] [--fill docs/validation.md]

MAIN.csv becomes the table between the marks `begin validation` and `end validation`; all files
together, one column each, the one between `begin responses` and `end responses`. Without --fill
both are printed.
"""
import csv
import re
import sys


def read(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def short(text):
    value = float(text)
    return "-" if value != value else f"{value:.4g}"


def figure(row):
    if row["verdict"] == "skipped":
        return "skipped"
    return f"{short(row['measured'])} {row['unit']}".strip()


def marked(row):
    return f"**{figure(row)}**" if row["verdict"] == "OFF" else figure(row)


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    lines += ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows]
    return "\n".join(lines)


def validation(rows):
    out = []
    last = ""
    for row in rows:
        name = f"`{row['experiment']}`" if row["experiment"] != last else ""
        last = row["experiment"]
        out.append([name, row["row"], figure(row), row["expected"], row["reference"],
                    row["verdict"]])
    return table(["experiment", "what", "measured", "expected", "after", ""], out)


def way(row):
    parts = [row["response"]] + [row[key] for key in ("motion_space", "integrator")
                                 if row[key] not in ("-", "implicit-euler")]
    return ", ".join(parts)


def responses(files):
    """Rows of the first file, with the figures of all; those that are off are in bold."""
    head = ["experiment", "what", "expected"] + [way(rows[0]) for rows in files]
    out = []
    found = [{(row["experiment"], row["row"]): row for row in rows} for rows in files]
    for row in files[0]:
        key = (row["experiment"], row["row"])
        if row["expected"] == "-":
            continue
        out.append([f"`{row['experiment']}`", row["row"], row["expected"]] +
                   [marked(rows[key]) if key in rows else "**broke off**" for rows in found])
    return table(head, out)


def fill(path, texts):
    with open(path, encoding="utf-8") as file:
        page = file.read()
    for name, text in texts.items():
        marks = f"<!-- begin {name} -->", f"<!-- end {name} -->"
        pattern = re.escape(marks[0]) + ".*?" + re.escape(marks[1])
        page = re.sub(pattern, lambda _: f"{marks[0]}\n{text}\n{marks[1]}", page, flags=re.DOTALL)
    with open(path, "w", encoding="utf-8") as file:
        file.write(page)


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
    files = [rows for rows in map(read, arguments) if rows]
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
