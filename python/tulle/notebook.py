"""Worlds, runs and meshes in the cells of a notebook, to turn and to play: `show`.

What is shown is one self-contained piece of HTML: a frame with the viewer (python/viewer: JavaScript, bundled with three.js
into viewer.js) and the data. It asks no server for anything, and works in a saved notebook and in a page made of one.
Positions are rounded to 1/65535 of the box in which a body moves. Where the package has no viewer.js, a ray traced picture is
shown.
"""
from __future__ import annotations

import base64
import html
import json
import os
import struct
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tulle._arrays import Doubles, Indices, to_doubles
from tulle.errors import Error, InvalidArgumentError
from tulle.mesh import Mesh, PathLike
from tulle.objects import Cloth, Object, Obstacle
from tulle.run import Run
from tulle.world import World

Thing = Union[World, Run, Mesh]
LIMIT = 4.0  # [MB] of data that an output holds, beside the viewer's fifth of one
_VIEWER = Path(__file__).with_name("viewer.js")
_STEPS = 65535  # positions are counted in steps of the box
_SAMPLE = 8  # frames that are packed to see how much one takes
_MOST_NAMES = 8
_COLORS = (None, "strain", "contact_force")


@dataclass
class _Body:
    """A body of a film, and how to read it; `frame` counts as the source does."""

    name: str
    kind: str  # "cloth", "obstacle" or "mesh"
    triangles: Indices
    vertex_count: int
    read: Callable[[int], Doubles]
    is_static: bool = False
    is_present: Callable[[int], bool] = lambda frame: True
    rest: Optional[Doubles] = None
    read_values: Optional[Callable[[int, Doubles], Doubles]] = None


@dataclass
class _Film:
    """What is shown: bodies, in frames of these numbers, at these times [s]."""

    title: str
    bodies: list[_Body]
    numbers: list[int]
    times: Optional[list[float]] = None
    enter: Callable[[int], None] = lambda frame: None  # called before a frame is read
    leave: Callable[[], None] = lambda: None
    notes: list[str] = field(default_factory=list)

    @property
    def about(self) -> str:
        """What there is to see, in words."""
        names = [f"{body.name} ({body.kind}, {body.vertex_count} vertices)" for body in self.bodies[:_MOST_NAMES]]
        more = len(self.bodies) - len(names)
        frames = f", {len(self.numbers)} frames" if len(self.numbers) > 1 else ""
        return f"{self.title}{frames}: {', '.join(names) or 'nothing'}{f' and {more} more' if more else ''}."


class View:
    """What `show` gives: a notebook shows it; `write` makes a page of it."""

    def __init__(self, markup: str, page: str, about: str) -> None:
        self.html = markup
        """For a cell or a page of your own."""
        self._page, self.about = page, about

    def _repr_html_(self) -> str:
        return self.html

    def __repr__(self) -> str:
        return f"View({self.about!r})"

    def write(self, path: PathLike) -> None:
        """Writes it as a page by itself."""
        with open(path, "w", encoding="utf-8") as file:
            file.write(self._page)


def show(thing: Thing, *, frames: Any = None, width: Optional[int] = None, height: int = 400, colors: Optional[str] = None,
         megabytes: float = LIMIT) -> View:
    """Shows `thing`, a world, a run or a mesh, in a notebook: give it as the last value of a cell.

    frames: of a run their numbers, as 10, range(0, 60, 2) or slice(-30, None); all where it is left out. Of a world a list of
    states that it saved (`save_state`); the present state where it is left out, which also stays. Of a mesh its positions
    [m], (frames, vertices, 3). width, height: pixels; as wide as the cell where width is left out. colors: "strain" of cloth,
    or "contact_force" [N] of each vertex, which a world knows of its last step. megabytes: at most so much data; frames in
    between are left out where there would be more, and the view says so.

    >>> tulle.show(run, colors="strain")
    """
    if colors not in _COLORS:
        raise InvalidArgumentError(f"colors is {colors!r}; it should be \"strain\", \"contact_force\" or None")
    if not megabytes > 0 or height < 1 or (width is not None and width < 1):
        raise InvalidArgumentError("width, height and megabytes should be above 0")
    film = _make_film(thing, frames, colors)
    viewer = _load_viewer()
    data = None if viewer is None else _pack(film, colors, int(1e6 * megabytes))
    if viewer is None:
        film.notes.append("This is a picture: the package has no viewer. In a checkout, make viewer builds it.")
    if viewer is None or data is None:
        return _show_picture(thing, film, width, height)
    page = _PAGE.format(title=html.escape(film.title), about=html.escape(film.about), viewer=viewer, data=data)
    size = f"width:{'100%' if width is None else f'{width}px'};max-width:100%;height:{height}px"
    markup = (f'<iframe title="{html.escape(film.title)}" style="{size};border:1px solid #c3c9d1;border-radius:6px" '
              f'sandbox="allow-scripts" srcdoc="{html.escape(page)}"></iframe>')
    return View(markup, page, film.about)


def represent(thing: Thing) -> str:
    """For `_repr_html_`: the view, or why there is none."""
    try:
        return show(thing).html
    except Error as problem:
        return f"<pre>{html.escape(f'{thing!r}: {problem}')}</pre>"


# ---- what there is to show ----


def _make_film(thing: Thing, frames: Any, colors: Optional[str]) -> _Film:
    if isinstance(thing, World):
        film = _film_world(thing, frames, colors)
    elif isinstance(thing, Run):
        film = _film_run(thing, frames)
    elif isinstance(thing, Mesh):
        film = _film_mesh(thing, frames)
    else:
        raise TypeError(f"show takes a World, a Run or a Mesh, not a {type(thing).__name__}")
    if colors == "contact_force" and not isinstance(thing, World):
        raise InvalidArgumentError("contact forces are known of a world alone, for its last step")
    if colors == "contact_force" and frames is not None:
        raise InvalidArgumentError("a saved state holds no contact forces: show the world as it is, without frames")
    if not film.numbers:
        raise InvalidArgumentError("there are no frames to show")
    if colors == "strain":
        for body in film.bodies:
            if body.rest is not None and body.read_values is None:
                body.read_values = _make_strain_reader(body.rest, body.triangles)
    return film


def _film_world(world: World, states: Optional[Sequence[bytes]], colors: Optional[str]) -> _Film:
    bodies = [_film_object(each, colors) for each in world.objects]
    if states is None:
        return _Film(f"World at {world.time:.4g} s", bodies, [0])
    now, saved, times = world.save_state(), list(states), []
    try:
        for state in saved:
            world.load_state(state)
            times.append(world.time)
    finally:
        world.load_state(now)
    return _Film(f"World, {len(saved)} states", bodies, list(range(len(saved))), times,
                 enter=lambda frame: world.load_state(saved[frame]), leave=lambda: world.load_state(now))


def _film_object(each: Object, colors: Optional[str]) -> _Body:
    body = _Body(each.name, "cloth" if isinstance(each, Cloth) else "obstacle", each.triangles, each.vertex_count,
                 lambda frame: np.array(each.positions))
    if isinstance(each, Obstacle):
        obstacle = each
        body.is_present, body.is_static = lambda frame: obstacle.is_present, obstacle.is_static
    elif isinstance(each, Cloth) and colors is not None:
        cloth, is_strain = each, colors == "strain"
        body.read_values = lambda frame, positions: _read_strain(cloth) if is_strain else _measure(cloth.contact_forces)
    return body


def _measure(vectors: ArrayLike) -> Doubles:
    """Their lengths."""
    return np.asarray(np.linalg.norm(np.asarray(vectors), axis=1), np.float64)


def _read_strain(cloth: Cloth) -> Doubles:
    """Of warp and weft the strain that is larger in magnitude, in percent, as the mean around each vertex."""
    yarns = np.asarray(cloth.strains)[:, :2]
    larger = yarns[np.arange(yarns.shape[0]), np.abs(yarns).argmax(axis=1)]
    return 100 * _average(larger, np.ones(larger.size), cloth.triangles, cloth.vertex_count)


def _film_run(run: Run, frames: Any) -> _Film:
    numbers = list(range(run.frame_count))
    if isinstance(frames, slice):
        numbers = numbers[frames]
    elif frames is not None:
        numbers = [run._number(int(frame)) for frame in np.atleast_1d(np.asarray(frames)).tolist()]
    times = [run.get_frame(number).time for number in numbers]
    bodies = [_Body(each.name, "obstacle" if each.is_obstacle else "cloth", each.mesh.triangles, each.vertex_count,
                    each.read_positions, each.is_static, each.is_present, None if each.is_obstacle else each.mesh.positions)
              for each in run.bodies]
    return _Film(f"Run {os.path.basename(os.path.normpath(run.path))}", bodies, numbers, times)


def _film_mesh(mesh: Mesh, frames: Optional[ArrayLike]) -> _Film:
    mesh._view()  # refuses arrays of the wrong shape
    last = int(mesh.triangles.max()) if mesh.triangle_count else -1
    if last >= mesh.vertex_count:
        raise InvalidArgumentError(f"the mesh has a triangle with vertex {last}, and {mesh.vertex_count} vertices")
    tracks = [mesh.positions]
    if frames is not None:
        tracks = [to_doubles(each, 3, "frames", mesh.vertex_count) for each in np.asarray(frames)]
    kind = "mesh" if frames is None else "cloth"
    body = _Body("mesh", kind, mesh.triangles, mesh.vertex_count, lambda frame: tracks[frame], rest=mesh.positions)
    return _Film(f"Mesh of {mesh.triangle_count} triangles", [body], list(range(len(tracks))))


def _average(values: Doubles, weights: Doubles, triangles: Indices, vertex_count: int) -> Doubles:
    """The weighted mean over the triangles around each vertex."""
    corners = triangles.reshape(-1)
    sums, totals = (np.bincount(corners, np.repeat(each, 3), vertex_count) for each in (values * weights, weights))
    return np.asarray(sums / np.maximum(totals, 1e-300), np.float64)


def _make_strain_reader(rest: Doubles, triangles: Indices) -> Callable[[int, Doubles], Doubles]:
    """As `tulle render --color strain` has it: of the two principal strains of each triangle the one that is larger in
    magnitude, in percent, as the mean around each vertex, weighted by areas at rest."""
    def get_edges(positions: Doubles) -> tuple[Doubles, Doubles]:
        a, b, c = (positions[triangles[:, k]] for k in range(3))
        return b - a, c - a

    first, second = get_edges(rest)
    length = np.linalg.norm(first, axis=1)
    area = np.linalg.norm(np.cross(first, second), axis=1)
    fine = (length > 0) & (area > 0)
    length, height = np.where(fine, length, 1), np.where(fine, area / np.where(fine, length, 1), 1)
    along = np.einsum("ij,ij->i", first, second) / length

    def read(frame: int, positions: Doubles) -> Doubles:
        now_first, now_second = get_edges(positions)
        u = now_first / length[:, None]
        v = (now_second - along[:, None] * u) / height[:, None]
        uu, vv, uv = (np.einsum("ij,ij->i", *pair) for pair in ((u, u), (v, v), (u, v)))
        most = np.sqrt(0.5 * (uu + vv) + np.hypot(0.5 * (uu - vv), uv))
        least = np.linalg.norm(np.cross(u, v), axis=1) / np.where(most > 0, most, 1)
        strain = np.where(np.abs(most - 1) >= np.abs(least - 1), most, least) - 1
        return 100 * _average(np.where(fine, strain, 0), np.where(fine, area, 0), triangles, rest.shape[0])

    return read


# ---- packing: python/viewer/src/film.js unpacks ----


def _pack(film: _Film, colors: Optional[str], limit: int) -> Optional[str]:
    """The film as text of at most `limit` characters, with frames in between left out where it must be; None: one frame
    alone is larger."""
    total = len(film.numbers)

    def pack(count: int) -> str:
        places = np.linspace(0, total - 1, count).round().astype(int) if count > 1 else np.array([total - 1])
        note = f"{count} of {total} frames are shown: the limit is {limit / 1e6:g} MB; megabytes= raises it."
        return _pack_frames(film, colors, places.tolist(), [*film.notes, *([note] if count < total else [])])

    moving = sum(body.vertex_count * (6 + (body.read_values is not None)) for body in film.bodies if not body.is_static)
    count = total
    if total > _SAMPLE and total * moving * 4 / 3 > limit:  # what a few frames take tells how many there may be
        one, few = len(pack(1)), len(pack(_SAMPLE))
        count = min(total, max(1, 1 + int((limit - one) * (_SAMPLE - 1) / max(few - one, 1))))
    while True:
        text = pack(count)
        if len(text) <= limit:
            return text
        if count == 1:
            film.notes.append(f"This is a picture: one frame alone takes {len(text) / 1e6:.3g} MB, and the limit is "
                              f"{limit / 1e6:g} MB; megabytes= raises it.")
            return None
        count = max(1, min(count - 1, int(0.97 * count * limit / len(text))))


def _pack_frames(film: _Film, colors: Optional[str], places: list[int], notes: list[str]) -> str:
    stacks: list[list[Doubles]] = [[] for _ in film.bodies]
    values: list[list[Doubles]] = [[] for _ in film.bodies]
    present: list[list[int]] = [[] for _ in film.bodies]
    try:
        for place in places:
            number = film.numbers[place]
            film.enter(number)
            for i, body in enumerate(film.bodies):
                present[i].append(int(body.is_present(number)))
                if body.is_static and stacks[i]:
                    continue
                stacks[i].append(np.array(body.read(number)))
                if body.read_values is not None:
                    values[i].append(body.read_values(number, stacks[i][-1]))
    finally:
        film.leave()
    scale = _choose_scale(colors, [np.stack(each) for each in values if each])
    parts: list[bytes] = []
    headers = []
    for i, body in enumerate(film.bodies):
        track = np.stack(stacks[i])
        if not np.isfinite(track).all():
            raise InvalidArgumentError(f"\"{body.name}\" has positions that are not finite")
        if (track == track[0]).all() and not values[i]:
            track = track[:1]
        low = track.min(axis=(0, 1)) if body.vertex_count else np.zeros(3)
        step = (track.max(axis=(0, 1)) - low) / _STEPS if body.vertex_count else np.zeros(3)
        steps = np.rint((track - low) / np.where(step > 0, step, 1)).astype(np.uint16)
        headers.append({"name": body.name, "kind": body.kind, "vertexCount": body.vertex_count,
                        "triangleCount": len(body.triangles), "frameCount": len(track), "low": low.tolist(),
                        "step": step.tolist(), "hasValues": bool(values[i]),
                        "present": None if all(present[i]) else present[i]})
        parts += [_to_planes(np.asarray(body.triangles, np.uint32)[None]), _to_planes(steps)]
        if values[i] and scale is not None:
            shares = (np.stack(values[i]) - scale["low"]) / (scale["high"] - scale["low"])
            parts.append(_to_planes(np.rint(255 * np.clip(shares, 0, 1)).astype(np.uint8)[:, :, None]))
    header = json.dumps({"title": film.title, "about": film.about, "frameCount": len(places), "startFrame": len(places) - 1,
                         "numbers": [film.numbers[place] for place in places],
                         "times": None if film.times is None else [film.times[place] for place in places],
                         "scale": scale, "note": " ".join(notes), "bodies": headers}).encode()
    return base64.b64encode(zlib.compress(b"".join([struct.pack("<I", len(header)), header, *parts]), 9)).decode()


def _to_planes(numbers: NDArray[Any]) -> bytes:
    """Whole numbers (frames, entries, width) as differences, then by bytes: all lowest ones, then all next ones. The first
    frame has differences from entry to entry, others from frame to frame."""
    differences = numbers.copy()
    differences[0, 1:] -= numbers[0, :-1]
    differences[1:] -= numbers[:-1]
    size = numbers.dtype.itemsize
    return differences.astype(numbers.dtype.newbyteorder("<")).reshape(-1).view(np.uint8).reshape(-1, size).T.tobytes()


def _choose_scale(colors: Optional[str], values: list[Doubles]) -> Optional[dict[str, Any]]:
    """What the colors mean; strains of all but one vertex in 200 lie within."""
    if not values:
        return None
    magnitudes = np.concatenate([np.abs(each).reshape(-1) for each in values])
    if colors == "strain":
        high = _round_up(max(float(np.quantile(magnitudes, 0.995)), 0.01))
        return {"title": "strain", "unit": "%", "low": -high, "high": high, "map": "diverging"}
    high = _round_up(max(float(magnitudes.max()), 1e-6))
    return {"title": "contact force", "unit": "N", "low": 0.0, "high": high, "map": "sequential"}


def _round_up(value: float) -> float:
    """The next of 1, 2, 5 times a power of ten."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(power * next(digit for digit in (1, 2, 5, 10) if value <= digit * power * (1 + 1e-12)))


# ---- pages ----


@lru_cache(maxsize=1)
def _load_viewer() -> Optional[str]:
    """viewer.js, packed; None: it was not built."""
    if not _VIEWER.is_file():
        return None
    return base64.b64encode(zlib.compress(_VIEWER.read_bytes(), 9)).decode()


# The policy keeps the page from asking anyone for anything. The text is there for those without scripts, streams or WebGL.
_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title>
<meta name="viewport" content="width=device-width">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'">
</head><body><p id="text">{about}</p>
<script type="text/plain" id="viewer">{viewer}</script>
<script type="text/plain" id="data">{data}</script>
<script>
(async () => {{
  const text = document.getElementById('text');
  const read = (id) => {{
    const bytes = Uint8Array.from(atob(document.getElementById(id).textContent), (letter) => letter.charCodeAt(0));
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'))).arrayBuffer();
  }};
  try {{
    const script = document.createElement('script');
    script.textContent = new TextDecoder().decode(await read('viewer'));
    document.head.append(script);
    tulleViewer.start(await read('data'), text);
  }} catch (problem) {{
    text.append(` This browser cannot show it: ${{problem.message}}.`);
  }}
}})();
</script></body></html>
"""


def _show_picture(thing: Thing, film: _Film, width: Optional[int], height: int) -> View:
    """A still in place of the viewer: ray traced, or words alone where the program draws no pictures."""
    from tulle.program import render
    about = html.escape(film.about)
    try:
        source: Union[Run, World]
        if isinstance(thing, Mesh):
            source = World(threads=1)
            source.add_obstacle(thing)
        else:
            source = thing
        size = (min(width or 640, 4 * height), height)
        pixels = render(source, frame=film.numbers[-1] if isinstance(thing, Run) else None, size=size, samples=8)
        data = base64.b64encode(encode_png(pixels)).decode()
        picture = f'<img alt="{about}" style="max-width:100%" src="data:image/png;base64,{data}">'
    except (Error, OSError) as problem:
        picture = f"<p>{about}</p>"
        film.notes.append(f"There is no picture: {problem}")
    markup = f"<figure>{picture}<figcaption>{html.escape(' '.join(film.notes))}</figcaption></figure>"
    head = f'<head><meta charset="utf-8"><title>{html.escape(film.title)}</title></head>'
    return View(markup, f'<!doctype html>\n<html lang="en">{head}<body>{markup}</body></html>\n', film.about)


def encode_png(pixels: NDArray[np.uint8]) -> bytes:
    """Pixels (height, width, 3) as a PNG file."""
    height, width, _ = pixels.shape

    def make_chunk(kind: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    rows = np.concatenate([np.zeros((height, 1), np.uint8), pixels.reshape(height, -1)], axis=1)  # 0: no filter
    return (b"\x89PNG\r\n\x1a\n" + make_chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
            + make_chunk(b"IDAT", zlib.compress(rows.tobytes(), 9)) + make_chunk(b"IEND", b""))
