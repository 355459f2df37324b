#!/usr/bin/env python3
"""Draws the plots of `make validate`: DIR/NAME.tsv to DIR/NAME.png.

usage: plot_validation.py DIR

A table begins with lines "# KEY TAB VALUE" (title, x, y, logarithmic); the others are series, x, y. A series whose name
begins with * is drawn by points, the others by lines.
"""
import glob
import os
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402


def read_table(path):
    """The words of the heading, and {series: ([x], [y])} in the order of their first points."""
    heading, series = {}, {}
    with open(path, encoding="utf-8") as file:
        for line in file:
            parts = line.rstrip("\n").split("\t")
            if parts[0].startswith("# "):
                heading[parts[0][2:]] = parts[1]
            else:
                xs, ys = series.setdefault(parts[0], ([], []))
                xs.append(float(parts[1]))
                ys.append(float(parts[2]))
    return heading, series


def draw(path):
    heading, series = read_table(path)
    figure, axes = plt.subplots(figsize=(7.2, 4.2), layout="constrained")
    for name, (xs, ys) in series.items():
        axes.plot(xs, ys, "o" if name.startswith("*") else "-", label=name.removeprefix("*"))
    axes.set(title=heading["title"], xlabel=heading["x"], ylabel=heading["y"])
    for axis in heading["logarithmic"]:
        axes.set(**{f"{axis}scale": "log"})
    axes.grid(color="#dddddd")
    if len(series) > 1:
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5), fontsize="small")
    figure.savefig(os.path.splitext(path)[0] + ".png", dpi=100)
    plt.close(figure)


def main():
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        print(__doc__, file=sys.stderr)
        return 2
    for path in sorted(glob.glob(os.path.join(glob.escape(sys.argv[1]), "*.tsv"))):
        draw(path)
    return 0


if __name__ == "__main__":
    sys.exit(main())
