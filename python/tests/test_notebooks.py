"""What notebooks show: the data that views hold, their bounds, what stands in for the viewer, plots; the notebooks run whole.

python/viewer/test.sh looks at the views in a browser.
"""
from __future__ import annotations

import base64
import html
import json
import re
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tulle
from numpy.testing import assert_allclose, assert_array_equal
from tulle import notebook

from conftest import ROOT

NOTEBOOKS = sorted((ROOT / "python/notebooks").glob("*.ipynb"))


@pytest.fixture
def viewer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A stand-in for viewer.js, which need not be built for what is tested here."""
    (tmp_path / "viewer.js").write_text("/* no viewer */")
    monkeypatch.setattr(notebook, "_VIEWER", tmp_path / "viewer.js")
    notebook._load_viewer.cache_clear()
    yield
    notebook._load_viewer.cache_clear()


@pytest.fixture
def no_viewer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A package without viewer.js."""
    monkeypatch.setattr(notebook, "_VIEWER", tmp_path / "nothing.js")
    notebook._load_viewer.cache_clear()
    yield
    notebook._load_viewer.cache_clear()


@pytest.fixture
def run(world: tulle.World, tmp_path: Path) -> tulle.Run:
    """The sheet falls on the ball, 21 frames."""
    with tulle.RunWriter(tmp_path / "run", world, 1 / 90) as writer:
        for _ in range(20):
            writer.write_report(world.step(1 / 90))
            writer.write_frame()
    return tulle.Run(tmp_path / "run")


class Film:
    """The data of a view, unpacked as python/viewer/src/film.js does."""

    def __init__(self, view: tulle.View) -> None:
        page = html.unescape(re.search(r'srcdoc="([^"]*)"', view.html)[1])
        self.text = re.search(r'id="data">([^<]*)<', page)[1]
        self.page, self.data = page, zlib.decompress(base64.b64decode(self.text))
        (size,) = struct.unpack_from("<I", self.data)
        self.header: dict[str, Any] = json.loads(self.data[4:4 + size])
        self.place = 4 + size
        self.bodies = [self.read_body(each) for each in self.header["bodies"]]
        assert self.place == len(self.data)

    def read(self, kind: str, *shape: int) -> np.ndarray:
        dtype = np.dtype(kind)
        count = int(np.prod(shape))
        planes = np.frombuffer(self.data, np.uint8, count * dtype.itemsize, self.place).reshape(dtype.itemsize, count)
        self.place += planes.size
        numbers = np.ascontiguousarray(planes.T).view(dtype).reshape(shape).copy()
        numbers[0] = np.cumsum(numbers[0], axis=0, dtype=dtype)
        return np.cumsum(numbers, axis=0, dtype=dtype)

    def read_body(self, header: dict[str, Any]) -> dict[str, Any]:
        triangles = self.read("<u4", 1, header["triangleCount"], 3)[0]
        steps = self.read("<u2", header["frameCount"], header["vertexCount"], 3)
        values = self.read("<u1", header["frameCount"], header["vertexCount"], 1)[:, :, 0] if header["hasValues"] else None
        if values is not None:
            scale = self.header["scale"]
            values = scale["low"] + values / 255 * (scale["high"] - scale["low"])
        low, step = np.array(header["low"]), np.array(header["step"])
        return {"triangles": triangles, "positions": low + steps * step, "values": values, "half": 0.51 * step}


def test_a_view_holds_what_a_run_holds(run: tulle.Run, viewer: None) -> None:
    film = Film(tulle.show(run))
    assert film.header["numbers"] == list(range(21)) and film.header["times"] == [each.time for each in run.frames]
    for body, shown, header in zip(run.bodies, film.bodies, film.header["bodies"]):
        assert header["name"] == body.name and header["kind"] == ("obstacle" if body.is_obstacle else "cloth")
        assert_array_equal(shown["triangles"], body.mesh.triangles)
        frames = [body.read_positions(frame) for frame in range(21)]
        assert shown["positions"].shape[0] == (1 if body.is_obstacle else 21)
        for frame, positions in enumerate(shown["positions"]):
            assert np.all(np.abs(positions - frames[frame]) <= shown["half"])
        assert np.all(shown["half"] < 1e-5)  # [m] for bodies of a metre


@pytest.mark.parametrize("frames, numbers", [
    (3, [3]), (-1, [20]), (range(0, 21, 5), [0, 5, 10, 15, 20]), (slice(-2, None), [19, 20]), ([7, 2, 2], [7, 2, 2]),
    (np.array([1, 4]), [1, 4])])
def test_frames_of_a_run(run: tulle.Run, viewer: None, frames: Any, numbers: list[int]) -> None:
    film = Film(tulle.show(run, frames=frames))
    assert film.header["numbers"] == numbers and film.header["note"] == ""
    assert film.header["times"] == [run.get_frame(number).time for number in numbers]
    for positions, number in zip(film.bodies[0]["positions"], numbers):
        assert_allclose(positions, run.bodies[0].read_positions(number), atol=1e-5)


@pytest.mark.parametrize("limit", [8_000, 30_000, 100_000])
def test_a_long_film_is_thinned(sheet: tulle.Mesh, viewer: None, limit: int) -> None:
    tracks = sheet.positions + np.random.default_rng(2).normal(0, 0.1, (200, sheet.vertex_count, 3))
    film = Film(tulle.show(sheet, frames=tracks, megabytes=limit / 1e6))
    numbers = film.header["numbers"]
    assert 0.75 * limit < len(film.text) <= limit and 4 < len(numbers) < 200
    assert numbers[0] == 0 and numbers[-1] == 199 and np.ptp(np.diff(numbers)) <= 1
    assert film.header["note"].startswith(f"{len(numbers)} of 200 frames are shown")
    assert_allclose(film.bodies[0]["positions"], tracks[numbers], atol=2e-5)


def test_what_is_too_large_is_a_picture(run: tulle.Run, viewer: None) -> None:
    view = tulle.show(run, megabytes=0.001)
    assert "srcdoc" not in view.html and "one frame alone takes" in view.html


def test_a_world_as_it_is(world: tulle.World, viewer: None) -> None:
    for _ in range(2):  # before the start, and after steps
        film = Film(tulle.show(world))
        for each, shown in zip(world.objects, film.bodies):
            assert_allclose(shown["positions"][0], each.positions, atol=1e-5)
        for _ in range(30):
            world.step(1 / 90)
    assert world._repr_html_() == tulle.show(world).html


def test_states_of_a_world(world: tulle.World, viewer: None) -> None:
    world.start()
    states, tracks, times = [], [], []
    for _ in range(4):
        states.append(world.save_state())
        tracks.append(world.cloths[0].positions.copy())
        times.append(world.time)
        world.step(1 / 90)
    now = world.state_hash
    film = Film(tulle.show(world, frames=states))
    assert world.state_hash == now and film.header["times"] == times
    assert_allclose(film.bodies[0]["positions"], tracks, atol=1e-5)
    with pytest.raises(tulle.Error):
        tulle.show(world, frames=[states[0], b"no state"])
    assert world.state_hash == now


def test_an_obstacle_that_comes_and_goes(sheet: tulle.Mesh, ball: tulle.Mesh, tmp_path: Path, viewer: None) -> None:
    world = tulle.World(threads=1)
    world.add_cloth(sheet)
    world.add_obstacle(ball, appear_time=3 / 90)
    with tulle.RunWriter(tmp_path / "run", world, 1 / 90) as writer:
        for _ in range(6):
            world.step(1 / 90)
            writer.write_frame()
    run = tulle.Run(tmp_path / "run")
    expected = [int(run.bodies[1].is_present(frame)) for frame in range(7)]
    assert 0 < sum(expected) < 7
    header = Film(tulle.show(run)).header
    assert header["bodies"][1]["present"] == expected and header["bodies"][0]["present"] is None


def test_colors_of_strain(viewer: None) -> None:
    mesh = tulle.make_shape("rectangle", size=(1, 1), resolution=9, is_irregular=True)
    stretched = mesh.positions * (1.1, 0.97, 1)
    turn = np.array([[np.cos(1), -np.sin(1), 0], [np.sin(1), np.cos(1), 0], [0, 0, 1]])
    sheared = mesh.positions @ np.array([[1, 0, 0], [0.3, 1, 0], [0, 0, 1]])
    film = Film(tulle.show(mesh, frames=[mesh.positions, stretched @ turn.T, 0.9 * mesh.positions, sheared], colors="strain"))
    largest = np.linalg.svd(np.array([[1, 0.3], [0, 1]]), compute_uv=False)[0] - 1
    assert film.header["scale"] == {"title": "strain", "unit": "%", "low": -20, "high": 20, "map": "diverging"}
    for values, expected in zip(film.bodies[0]["values"], (0, 10, -10, 100 * largest)):
        assert_allclose(values, expected, atol=0.08)  # 1/255 of the scale


def test_colors_of_a_world(world: tulle.World, viewer: None) -> None:
    for _ in range(40):
        world.step(1 / 90)
    cloth = world.cloths[0]
    film = Film(tulle.show(world, colors="contact_force"))
    force = np.linalg.norm(cloth.contact_forces, axis=1)
    assert force.max() > 0 and film.bodies[1]["values"] is None
    assert_allclose(film.bodies[0]["values"][0], force, atol=film.header["scale"]["high"] / 500)
    film = Film(tulle.show(world, colors="strain"))
    larger = 100 * np.abs(np.asarray(cloth.strains)[:, :2]).max()
    assert 0 < np.abs(film.bodies[0]["values"]).max() <= larger + film.header["scale"]["high"] / 100


def test_names_are_text(sheet: tulle.Mesh, viewer: None) -> None:
    world = tulle.World()
    world.add_cloth(sheet, name='</script><script>alert("1")</script>')
    view = tulle.show(world)
    page = Film(view).page
    assert "<script>alert" not in page and "&lt;script&gt;alert" in page
    assert len(re.findall("<iframe", view.html)) == 1 and view.html.endswith('"></iframe>')


def test_a_page_by_itself(ball: tulle.Mesh, viewer: None, tmp_path: Path) -> None:
    view = tulle.show(ball, width=300, height=200)
    view.write(tmp_path / "ball.html")
    assert (tmp_path / "ball.html").read_text() == html.unescape(re.search(r'srcdoc="([^"]*)"', view.html)[1])
    assert "width:300px" in view.html and "height:200px" in view.html
    assert "ball" not in view.about and "vertices" in view.about
    assert not re.search(r"https?://|src=|href=", (tmp_path / "ball.html").read_text())


@pytest.mark.parametrize("options, kind, words", [
    ({"colors": "speed"}, tulle.InvalidArgumentError, "colors"), ({"frames": 21}, tulle.InvalidArgumentError, "no frame 21"),
    ({"frames": []}, tulle.InvalidArgumentError, "no frames"),
    ({"colors": "contact_force"}, tulle.InvalidArgumentError, "world alone"),
    ({"height": 0}, tulle.InvalidArgumentError, "above 0"), ({"megabytes": 0}, tulle.InvalidArgumentError, "above 0")])
def test_errors(run: tulle.Run, viewer: None, options: dict[str, Any], kind: type, words: str) -> None:
    with pytest.raises(kind, match=words):
        tulle.show(run, **options)


def test_errors_of_meshes_and_worlds(world: tulle.World, run: tulle.Run, viewer: None) -> None:
    with pytest.raises(TypeError, match="not a str"):
        tulle.show("run")  # type: ignore[arg-type]
    with pytest.raises(tulle.InvalidArgumentError, match="saved state"):
        tulle.show(world, frames=[world.save_state()], colors="contact_force")
    bad = tulle.Mesh(np.zeros((3, 3)), [[0, 1, 7]])
    with pytest.raises(tulle.InvalidArgumentError, match="vertex 7"):
        tulle.show(bad)
    assert "vertex 7" in bad._repr_html_()  # a cell shows why
    with pytest.raises(tulle.InvalidArgumentError, match="not finite"):
        tulle.show(tulle.Mesh(np.full((3, 3), np.nan), [[0, 1, 2]]))
    with pytest.raises(tulle.InvalidArgumentError, match="frames"):
        tulle.show(tulle.make_shape("box"), frames=[np.zeros((3, 3))])
    world.close()
    run.close()
    assert world._repr_html_() is None and run._repr_html_() is None  # then their text is shown


def test_without_the_viewer_there_is_a_picture(world: tulle.World, run: tulle.Run, no_viewer: None, tmp_path: Path) -> None:
    for thing in (world, run, tulle.make_shape("box")):
        view = tulle.show(thing, width=120, height=60)
        assert "make viewer" in view.html and "srcdoc" not in view.html
        found = re.search(r'src="data:image/png;base64,([^"]*)"', view.html)
        if found is None:
            assert "There is no picture" in view.html
            pytest.skip("the program draws no pictures here")
        (tmp_path / "picture.png").write_bytes(base64.b64decode(found[1]))
        pixels = tulle.program.read_png(tmp_path / "picture.png")
        assert pixels.shape == (60, 120, 3) and pixels.std() > 5


def test_without_the_program_there_are_words(world: tulle.World, no_viewer: None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TULLE", "/nowhere/tulle")
    view = tulle.show(world)
    assert "There is no picture: " in view.html and "sheet (cloth, 144 vertices)" in view.html and "<img" not in view.html


def test_png_files(tmp_path: Path) -> None:
    pixels = np.random.default_rng(1).integers(0, 256, (7, 11, 3), np.uint8)
    path = tmp_path / "a.png"
    path.write_bytes(notebook.encode_png(pixels))
    assert_array_equal(tulle.program.read_png(path), pixels)


def test_the_viewer_was_built() -> None:
    notebook._load_viewer.cache_clear()
    packed = notebook._load_viewer()
    if packed is None:
        pytest.skip("python/tulle/viewer.js was not built: make viewer")
    code = zlib.decompress(base64.b64decode(packed)).decode()
    assert "three.js authors" in code and "tulleViewer" in code
    assert len(packed) < 300_000


# ---- plots ----


def test_plots(run: tulle.Run, world: tulle.World, tmp_path: Path) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    steps = [world.step(1 / 90) for _ in range(3)]
    for given, count in ((run, 20), (run.reports[5:8], 3), (steps, 3), (iter(steps), 3)):
        figure = tulle.plot_report(given)
        labels = [axes.get_ylabel() for axes in figure.axes]
        assert labels == ["step time [ms]", "contacts", "smallest gap [mm]", "energy [J]", "CG iterations", "max stretch [%]",
                          "relative residual"]
        assert figure.axes[5].get_xlabel() == "simulated time [s]"
        assert len(figure.axes[1].lines[0].get_xdata()) == count
        assert len(figure.axes[0].get_legend().get_texts()) >= 11
        figure.savefig(tmp_path / "plot.png", dpi=40)
        plt.close(figure)
    expected = run.reports["kinetic_energy"] + run.reports["gravity_energy"] + run.reports["elastic_energy"]
    figure = tulle.plot_report(run, title="energies in $ and _")
    assert_allclose(figure.axes[3].lines[0].get_ydata(), expected, rtol=1e-12)
    assert_array_equal(figure.axes[1].lines[0].get_ydata(), run.reports["contacts"])
    tops = np.sum([each.get_paths()[0].vertices[:, 1].max() for each in figure.axes[0].collections[-1:]])
    assert_allclose(tops, 1e3 * run.reports["total_seconds"].max(), rtol=1e-6)
    plt.close("all")
    for nothing in ([], run.reports[:0]):
        with pytest.raises(tulle.InvalidArgumentError, match="no reports"):
            tulle.plot_report(nothing)
    with pytest.raises(tulle.InvalidArgumentError, match="STEP_REPORT"):
        tulle.plot_report(np.zeros(3))


# ---- notebooks ----


def test_there_are_notebooks() -> None:
    assert [path.stem for path in NOTEBOOKS] == ["detect_a_motion", "first_cloth", "fit_a_fabric", "friction_on_an_incline"]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is committed without outputs, and runs without an error; what it says of its results is asserted in its cells."""
    book = json.loads(path.read_text(encoding="utf-8"))
    codes = [cell for cell in book["cells"] if cell["cell_type"] == "code"]
    assert codes and all(not cell["outputs"] and cell["execution_count"] is None for cell in codes)
    assert any("assert " in "".join(cell["source"]) for cell in codes)
    assert max(len(line.rstrip("\n")) for cell in codes for line in cell["source"]) <= 128
    nbclient, nbformat = pytest.importorskip("nbclient"), pytest.importorskip("nbformat")
    for module in ("ipykernel", "matplotlib"):
        pytest.importorskip(module)
    made = nbformat.reads(json.dumps(book), 4)
    nbformat.validate(made)
    monkeypatch.setenv("PYTHONPATH", str(Path(tulle.__file__).parents[1]))  # the kernel works in another directory
    client = nbclient.NotebookClient(made, timeout=60, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}})
    client.execute()
    assert all(cell["execution_count"] for cell in made.cells if cell["cell_type"] == "code")
    kinds = {kind for cell in made.cells for output in cell.get("outputs", ()) for kind in output.get("data", ())}
    assert {"text/html", "image/png"} <= kinds  # a view, and a plot
