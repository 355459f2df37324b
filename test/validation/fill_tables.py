#!/usr/bin/env python3
"""Writes the rows of several runs of tulle_validate, a column each, into lab/validation.md.

Usage: test/validation/fill_tables.py responses CSV CSV [...] [--fill lab/validation.md]

The table between the marks `begin responses` and `end responses`. Without --fill it is printed.
The rows of one run are in the book: tools/make_validation_page.py.
"""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools"))
from markdown_tables import fill, make_table, read_rows  # noqa: E402

BROKEN_ROW = "runs to its end"


def short(text):
    value = float(text)
    return "-" if value != value else f"{value:.4g}"


def figure(row):
    if row["verdict"] == "skipped":
        return "skipped"
    return f"{short(row['measured'])} {row['unit']}".strip()


def marked(row):
    return f"**{figure(row)}**" if row["verdict"] == "OFF" else figure(row)


def way(row):
    parts = [row["response"]] + [row[key] for key in ("motion_space", "integrator")
                                 if row[key] not in ("-", "implicit-euler")]
    return ", ".join(parts)


def broken(rows):
    """Why an experiment broke off, by its name."""
    return {row["experiment"]: row["reference"] for row in rows if row["row"] == BROKEN_ROW}


def cell(rows, breaks, key, is_first):
    """What one file says of a row; the message of what broke off stands once."""
    if key in rows:
        return marked(rows[key])
    if key[0] not in breaks:
        return "not run"
    return f"**broke off**: {breaks[key[0]]}" if is_first else "**broke off**"


def keyed(rows):
    """Rows of the same name in one experiment are told apart by their order."""
    counts = {}
    out = []
    for row in rows:
        name = (row["experiment"], row["row"])
        counts[name] = counts.get(name, 0) + 1
        out.append((name + (counts[name],), row))
    return out


def responses(files):
    """Rows of the first file, with the figures of all; those that are off are in bold."""
    head = ["experiment", "what", "expected"] + [way(rows[0]) for rows in files]
    found = [dict(keyed(rows)) for rows in files]
    breaks = [broken(rows) for rows in files]
    told = set()
    out = []
    last = ""
    for key, row in keyed(files[0]):
        if row["expected"] == "-" or key[0] == "all":
            continue
        cells = []
        for i, rows in enumerate(found):
            cells.append(cell(rows, breaks[i], key, (i, key[0]) not in told))
            if key not in rows:
                told.add((i, key[0]))
        out.append([f"`{key[0]}`" if key[0] != last else "", row["row"], row["expected"]] + cells)
        last = key[0]
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
    name = arguments.pop(0) if arguments else ""
    files = [rows for rows in map(read_rows, arguments) if rows]
    if name != "responses" or len(files) < 2:
        sys.exit(__doc__)
    text = responses(files)
    if target:
        fill(target, {name: text})
    else:
        print(text)


if __name__ == "__main__":
    main()
