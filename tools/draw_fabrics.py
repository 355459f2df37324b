#!/usr/bin/env python3
"""The pictures of fabrics in docs/pictures/fabric: each preset on a pedestal; springs beside woven cloth. Those on pedestals also become
the icons of the add-on for Blender.

    python3 tools/draw_fabrics.py PROGRAM [drape|strip|hem ...]          all of them without names

Runs the scenes of scenes/fabric into out/fabric, judges every frame, and renders. A run that is there is used, one that was cut short
goes on. Prints what it measured: drape coefficient, folds, how far anything still moved in the last frame. Needs Pillow and
matplotlib: paper/find_python.sh says which python3 has them.
"""
import io
import json
import pathlib
import re
import struct
import subprocess
import sys

import matplotlib
import numpy
from PIL import Image, ImageDraw, ImageFont

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parent.parent
RUNS, SCENES, PICTURES = ROOT / "out/fabric", ROOT / "scenes/fabric", ROOT / "docs/pictures/fabric"
SIZE_LIMIT = 600_000  # [bytes] of a picture in the repository
SAMPLE_RADIUS, DISC_RADIUS = 0.15, 0.09  # [m]
COARSEST_RINGS = 20
MEMBRANES = ("springs", "woven")
COLUMNS, PANEL = 4, (270, 190)  # of the sheet of fabrics; [px]
PREVIEWS = ROOT / "blender/tulle_addon/fabrics"
PREVIEW_SIZE, PREVIEW_PART = 128, 240  # [px] of an icon; width of the panel's part that it shows
FONT = ImageFont.truetype(str(pathlib.Path(matplotlib.get_data_path()) / "fonts/ttf/DejaVuSans.ttf"), 13)


def simulate(program, scene, name, values):
    """A finished run, every frame of which was judged."""
    directory = RUNS / name
    command = [program, "run", SCENES / f"{scene}.yaml", "-o", directory, "--resume", "--progress", "none", "--threads", "1"]
    for value in values:
        command += ["--set", value]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    judged = subprocess.run([program, "check", directory, "--threads", "1"], stdout=subprocess.PIPE, text=True, check=False)
    if judged.returncode != 0:
        sys.exit(f"{directory}: {judged.stdout}")
    return directory


def render(program, directory, size, *more):
    target = directory.with_name(directory.name + ".png")
    subprocess.run([program, "render", directory, "--size", f"{size[0]}x{size[1]}", "--samples", "256", *more, "-o", target],
                   check=True, stdout=subprocess.DEVNULL)
    return Image.open(target).convert("RGB")


def read_positions(directory, name):
    """Of every frame [m]: frames, vertices, 3."""
    data = (directory / f"{name}.pc2").read_bytes()
    count, = struct.unpack_from("<I", data, 16)
    return numpy.frombuffer(data, "<f4", offset=32).reshape(-1, count, 3).astype(float)


def read_triangles(directory, name):
    lines = (directory / f"{name}.obj").read_text().splitlines()
    return numpy.array([[int(corner.split("/")[0]) - 1 for corner in line.split()[1:4]] for line in lines if line.startswith("f ")])


def save(picture, name):
    """With a palette: half of the bytes, and nothing to be seen of it."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    target = PICTURES / f"{name}.png"
    palette = picture.quantize(256)
    picture.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG).save(target, optimize=True)
    if target.stat().st_size > SIZE_LIMIT:
        sys.exit(f"{target} is larger than {SIZE_LIMIT} bytes")
    print(target)


# ---- each fabric on the pedestal ----


def choose_rings(program, fabric):
    """So many that edges are at most a third of the bending length; in fives, so that one lies on the disc's edge."""
    answer = subprocess.run([program, "info", SCENES / "drape.yaml", "--json", "--set", f"cloth[0].material.preset={fabric}"],
                            check=True, stdout=subprocess.PIPE, text=True)
    rings = 3.0 * SAMPLE_RADIUS / json.loads(answer.stdout)["cloths"][0]["bending_length"]
    return max(COARSEST_RINGS, 5 * int(numpy.ceil(rings / 5.0)))


def measure_drape(directory):
    """Part of the ring around the disc that the sample's shadow covers [%]: points of 0.1 mm that a triangle covers."""
    scale = 1e4
    side = int(2.2 * SAMPLE_RADIUS * scale)
    shadow = Image.new("1", (side, side))
    draw = ImageDraw.Draw(shadow)
    points = read_positions(directory, "sample")[-1][:, :2] * scale + 0.5 * side
    for triangle in read_triangles(directory, "sample"):
        draw.polygon([tuple(points[corner]) for corner in triangle], fill=1)
    area = numpy.asarray(shadow).sum() / scale**2
    disc = numpy.pi * DISC_RADIUS**2
    return 100.0 * (area - disc) / (numpy.pi * SAMPLE_RADIUS**2 - disc)


def count_folds(heights):
    """Times that the height of the rim goes above its mean, once round."""
    above = heights > heights.mean()
    return int((above & ~numpy.roll(above, 1)).sum())


def save_preview(picture, fabric):
    """The middle of a panel, as a square icon for the add-on for Blender."""
    PREVIEWS.mkdir(parents=True, exist_ok=True)
    edge = (picture.width - PREVIEW_PART) // 2
    height = PREVIEW_SIZE * picture.height // PREVIEW_PART
    small = picture.crop((edge, 0, edge + PREVIEW_PART, picture.height)).resize((PREVIEW_SIZE, height), Image.Resampling.LANCZOS)
    square = Image.new("RGB", (PREVIEW_SIZE, PREVIEW_SIZE), picture.getpixel((0, 0)))
    square.paste(small, (0, PREVIEW_SIZE - height))
    square.quantize(64, dither=Image.Dither.NONE).save(PREVIEWS / f"{fabric}.png", optimize=True)


def draw_drapes(program):
    fabrics = re.findall(r'^    \{"([a-z-]+)",', (ROOT / "src/dynamics/presets.c").read_text(), re.MULTILINE)
    panels = []
    for fabric in fabrics:
        rings = choose_rings(program, fabric)
        held = 3 * rings // 5
        directory = simulate(program, "drape", f"drape.{fabric}", [
            f"cloth[0].material.preset={fabric}", f"cloth[0].mesh.resolution=[{rings}, {6 * rings}]",
            f"cloth[0].pins[0].vertices=[0-{3 * held * (held + 1)}]"])
        positions = read_positions(directory, "sample")
        drape = measure_drape(directory)
        folds = count_folds(positions[-1][-6 * rings:, 2])
        moved = numpy.abs(positions[-1] - positions[-2]).max()
        print(f"{fabric:18} {rings} rings, drape coefficient {drape:.1f} %, {folds} folds, moved by {1e3 * moved:.3f} mm", flush=True)
        panels.append((drape, f"{fabric}, {drape:.0f} %", render(program, directory, PANEL)))
        save_preview(panels[-1][2], fabric)
    panels.sort(key=lambda panel: panel[0])
    rows = -(-len(panels) // COLUMNS)
    line = FONT.size + 8
    sheet = Image.new("RGB", (COLUMNS * PANEL[0], rows * (PANEL[1] + line)), "white")
    draw = ImageDraw.Draw(sheet)
    for i, (_, words, picture) in enumerate(panels):
        x, y = i % COLUMNS * PANEL[0], i // COLUMNS * (PANEL[1] + line)
        sheet.paste(picture, (x, y))
        draw.text((x + PANEL[0] / 2, y + PANEL[1] + 3), words, fill="black", font=FONT, anchor="ma")
    save(sheet, "drape")


# ---- springs beside woven cloth ----


def draw_strips(program):
    """How high the pulled strip lies, from above and in a section across its middle."""
    figure, axes = pyplot.subplots(2, 2, figsize=(9, 4.4), dpi=100, height_ratios=[1.5, 1], constrained_layout=True)
    for (above, section), membrane in zip(axes.T, MEMBRANES):
        directory = simulate(program, "strip", f"strip.{membrane}", [f"membrane={membrane}"])
        last = 1e3 * read_positions(directory, "strip")[-1]
        x, y, z = last.T
        map_of_height = above.tripcolor(x, y, z, triangles=read_triangles(directory, "strip"), cmap="RdBu", vmin=-2.0, vmax=2.0)
        above.set(title=f"membrane: {membrane}", aspect="equal", ylabel="y [mm]", xlabel="x [mm]")
        columns = last.reshape(25, 61, 3)[:, 30]
        section.plot(columns[:, 1], columns[:, 2], ".-")
        section.set(ylim=(-2.5, 2.5), xlabel="y [mm]", ylabel="height [mm]")
        print(f"strip, {membrane}: {numpy.ptp(z):.4f} mm high")
    figure.colorbar(map_of_height, ax=axes[0], label="height [mm]")
    drawn = io.BytesIO()
    figure.savefig(drawn)
    save(Image.open(drawn).convert("RGB"), "strip")


def count_zigzags(positions):
    """Of a frame, rows by columns: part of the vertices [%] that stand out of their row or column to and fro, each by more than 0.5 mm."""
    found = numpy.zeros(positions.shape[:2], bool)
    for points, marks in ((positions, found), (positions.swapaxes(0, 1), found.T)):
        out = points[1:-1] - 0.5 * (points[:-2] + points[2:])
        turns = (out[1:] * out[:-1]).sum(axis=-1) < 0.0
        marks[2:-2] |= turns[1:] & turns[:-1] & (numpy.linalg.norm(out[1:-1], axis=-1) > 0.5e-3)
    return 100.0 * found.mean()


def draw_hems(program):
    """The sides of a sheet that has fallen on a box, on their way down; zigzags by fineness."""
    size = (480, 300)
    line = FONT.size + 8
    pair = Image.new("RGB", (2 * size[0] + 8, size[1] + line), "white")
    draw = ImageDraw.Draw(pair)
    for side in (41, 61, 101):
        for i, membrane in enumerate(MEMBRANES):
            directory = simulate(program, "hem", f"hem.{side}.{membrane}",
                                 [f"membrane={membrane}", f"cloth[0].mesh.resolution=[{side}, {side}]"])
            zigzags = [count_zigzags(frame.reshape(side, side, 3)) for frame in read_positions(directory, "sheet")]
            print(f"hem, {side} x {side}, {membrane}: zigzags {max(zigzags):.1f} % at most, {zigzags[-1]:.1f} % at the end", flush=True)
            x = i * (size[0] + 8)
            if side == 101:
                pair.paste(render(program, directory, size, "--frame", "9"), (x, 0))
                draw.text((x + size[0] / 2, size[1] + 3), f"membrane: {membrane}", fill="black", font=FONT, anchor="ma")
    save(pair, "hem")


def main():
    program, *names = sys.argv[1:] or sys.exit(__doc__)
    program = pathlib.Path(program).resolve()
    RUNS.mkdir(parents=True, exist_ok=True)
    drawings = {"drape": draw_drapes, "strip": draw_strips, "hem": draw_hems}
    for name in names or drawings:
        drawings[name](program)


if __name__ == "__main__":
    main()
