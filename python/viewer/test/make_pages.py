"""Pages for check_pages.mjs: views by themselves and in cells, a notebook that was run.

usage: make_pages.py DIRECTORY
"""
import json
import sys
import tempfile
from pathlib import Path

import numpy as np
import tulle

ROOT = Path(__file__).resolve().parents[3]


def write_page(path: Path, body: str) -> None:
    path.write_text(f'<!doctype html><html lang="en"><title>{path.stem}</title><body>{body}</body></html>', encoding="utf-8")


def write_views(place: Path) -> None:
    world = tulle.World(threads=1)
    sheet = tulle.make_shape("rectangle", size=(1, 1), resolution=21).transform(translation=(0, 0, 0.32))
    world.add_cloth(sheet, name="a <b>sheet</b>")
    world.add_obstacle(tulle.make_shape("sphere", radius=0.3, resolution=8), name="ball")
    with tempfile.TemporaryDirectory() as directory:
        with tulle.RunWriter(f"{directory}/run", world, 1 / 90) as writer:
            for step in range(60):
                world.step(1 / 90)
                if step % 2:
                    writer.write_frame()
        run = tulle.Run(f"{directory}/run")
        tulle.show(run).write(place / "run.html")
        strain = tulle.show(run, colors="strain")
        strain.write(place / "strain.html")
        tulle.show(run, megabytes=0.04).write(place / "thinned.html")
        views = (run._repr_html_(), strain.html, tulle.show(world, width=300, height=250).html)
    write_page(place / "cells.html", "".join(f"<p>a cell</p>{each}" for each in views))
    # More views than a browser has WebGL contexts.
    ball = tulle.show(tulle.make_shape("sphere", radius=0.3, resolution=4), height=300).html
    write_page(place / "many.html", ball * 24)
    # A box has edges, and all of it is in the view; a motion of a mesh has no times.
    tulle.show(tulle.make_shape("box")).write(place / "box.html")
    frames = [sheet.positions + (0, 0, 0.1 * np.sin(k)) for k in range(5)]
    tulle.show(sheet, frames=frames).write(place / "motion.html")


def write_notebook(place: Path) -> None:
    """An executed notebook as a page; nothing where nbconvert is missing."""
    try:
        import nbclient
        import nbconvert
        import nbformat
    except ImportError as missing:
        print(f"skipped: the page of a notebook ({missing})")
        return
    book = nbformat.reads((ROOT / "python/notebooks/first_cloth.ipynb").read_text(encoding="utf-8"), 4)
    nbclient.NotebookClient(book, timeout=60, kernel_name="python3").execute()
    page, _ = nbconvert.HTMLExporter().from_notebook_node(book)
    (place / "notebook.html").write_text(page, encoding="utf-8")


if __name__ == "__main__":
    where = Path(sys.argv[1]).resolve()
    write_views(where)
    write_notebook(where)
    print(json.dumps(sorted(path.name for path in where.glob("*.html"))))
