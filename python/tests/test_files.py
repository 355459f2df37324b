"""Meshes, point caches, scenes and runs in files; the program from Python."""
from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
import warnings
from pathlib import Path

import numpy as np
import pytest
import tulle
from conftest import ROOT
from tulle._find_program import find_program

STEP = 1 / 90
SMALL = {"time.frames": 4, "cloth[0].mesh.resolution": [12, 12]}
SCENE = ROOT / "scenes" / "sphere.yaml"


def test_numbers_of_numpy_in_overrides() -> None:
    plain = tulle.Scene(SCENE, {"time.frames": 7, "cloth[0].mesh.resolution": [9, 12], "gravity": [0.0, 0.0, -1.5]})
    numpy = tulle.Scene(SCENE, {"time.frames": np.int64(7), "cloth[0].mesh.resolution": np.array([9, 12]),
                                "gravity": [np.float32(0), 0, np.float64(-1.5)]})
    assert numpy.frame_count == 7 and numpy.hash == plain.hash
    with pytest.raises(TypeError, match="takes no set"):
        tulle.Scene(SCENE, {"time.frames": {7}})


@pytest.mark.parametrize("ending", ["obj", "ply", "vtp", "stl"])
def test_meshes_come_back(tmp_path: Path, sheet: tulle.Mesh, ending: str) -> None:
    path = tmp_path / f"sheet.{ending}"
    sheet.write(path)
    again = tulle.Mesh.read(path)
    assert again.triangle_count == sheet.triangle_count
    if ending != "stl":
        assert np.array_equal(again.positions, sheet.positions) and np.array_equal(again.triangles, sheet.triangles)
    with pytest.raises(tulle.UnsupportedError, match="xyz"):
        sheet.write(tmp_path / "sheet.xyz")


def test_odd_polygons_are_told(tmp_path: Path) -> None:
    """One that crosses itself keeps its fan, with a warning; a concave one needs none."""
    path = tmp_path / "tie.obj"
    path.write_text("v 0 0 0\nv 2 2 0\nv 2 0 0\nv 0 1 0\nf 1 2 3 4\n")
    with pytest.warns(UserWarning, match=r"tie.obj.*1 polygon crosses itself or has no area \(line 5\)"):
        assert tulle.Mesh.read(path).triangle_count == 2
    path.write_text("v -1 0 0\nv 0 3 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 4\n")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        concave = tulle.Mesh.read(path)
    ends = concave.positions[concave.triangles]
    normals = np.cross(ends[:, 1] - ends[:, 0], ends[:, 2] - ends[:, 0])
    np.testing.assert_allclose(normals[:, 2], [-2, -2])


def test_meshes_move_and_divide(sheet: tulle.Mesh) -> None:
    moved = sheet.transform(scale=(2, 1, 1), rotation=(np.sqrt(0.5), 0, 0, np.sqrt(0.5)), translation=(0, 0, 1))
    assert np.allclose(moved.positions[:, 1], 2 * sheet.positions[:, 0]) and np.allclose(moved.positions[:, 2], 1.5)
    mirrored = sheet.transform(scale=(-1, 1, 1))
    assert mirrored.triangles[0].tolist() != sheet.triangles[0].tolist()
    assert sheet.subdivide(1).triangle_count == 4 * sheet.triangle_count
    for wrong in ({"scale": 0}, {"rotation": (1, 1, 0, 0)}, {"translation": (np.inf, 0, 0)}):
        with pytest.raises(tulle.InvalidArgumentError):
            sheet.transform(**wrong)


def test_a_mesh_is_repaired() -> None:
    bow = tulle.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [9, 9, 9]], [[0, 1, 2], [0, 3, 4]])
    with pytest.raises(tulle.InvalidMeshError, match="bow tie"):
        bow.validate()
    made, done = bow.repair()
    made.validate()
    assert {kind: count for kind, (count, _) in done.items()} == {"cut": 1, "loose": 1}
    assert done["loose"][1].tolist() == [9, 9, 9] and bow.vertex_count == 6 and made.vertex_count == 6
    assert made.repair(1e-6)[1] == {}
    with pytest.raises(tulle.InvalidArgumentError):
        bow.repair(-1)


def test_point_caches(tmp_path: Path, sheet: tulle.Mesh) -> None:
    path = tmp_path / "sheet.pc2"
    with tulle.PointCacheWriter(path, sheet.vertex_count) as writer:
        writer.append(sheet.positions)
        writer.append(2 * sheet.positions)
        with pytest.raises(tulle.InvalidArgumentError, match="shape"):
            writer.append(sheet.positions[1:])
    cache = tulle.PointCache(path)
    assert len(cache) == 2 and np.allclose(cache[-1], 2 * sheet.positions, atol=1e-6)
    with pytest.raises(IndexError):
        cache[2]
    cache.close()
    with pytest.raises(tulle.ClosedError):
        cache[0]


def test_a_scene_steps_to_the_bits_of_the_program(tmp_path: Path) -> None:
    scene = tulle.Scene(SCENE, SMALL)
    world = scene.build_world(threads=1)
    for _ in range(scene.frame_count * scene.steps_per_frame):
        world.step(scene.time_step)
    events: list[dict] = []
    run = tulle.simulate(SCENE, tmp_path / "run", overrides=SMALL, threads=2, progress=events.append)
    assert run.state == tulle.RunState.FINISHED and run.frame_count == 5
    assert run.get_frame(-1).state_hash == world.state_hash and run.scene_hash == scene.hash
    assert [event["event"] for event in events][:1] == ["begin"] and events[-1]["event"] == "end"
    assert np.array_equal(run.find_body("cloth").read_positions(-1), world.cloths[0].positions.astype(np.float32))
    assert run.reports.size == world.step_count and run.reports["time"][-1] == world.time
    assert tulle.check_files(tmp_path / "run")[-1]["intersections"] == 0 and run.find_damage() == []
    again = tulle.simulate(SCENE, tmp_path / "run", overrides={**SMALL, "time.frames": 6}, resume=True, progress=False)
    assert again.frame_count == 7 and again.get_frame(4).state_hash == run.get_frame(4).state_hash
    with pytest.raises(tulle.ProgramError, match="--resume") as caught:
        tulle.simulate(SCENE, tmp_path / "run", overrides=SMALL, progress=False)
    assert caught.value.exit_code == 2
    with pytest.raises(tulle.InvalidArgumentError, match="no frame 99"):
        run.bodies[0].read_positions(99)


def test_a_run_that_python_writes(tmp_path: Path, world: tulle.World) -> None:
    with tulle.RunWriter(tmp_path / "mine", world, STEP) as writer:
        for _ in range(3):
            writer.write_report(world.step(STEP))
            writer.write_frame()
    run = tulle.Run(tmp_path / "mine")
    assert run.frame_count == 4 and run.state == tulle.RunState.FINISHED and run.get_frame(3).state_hash == world.state_hash
    assert [body.name for body in run.bodies] == ["sheet", "ball"] and run.outcome.steps == 3
    with pytest.raises(RuntimeError, match="enough"), tulle.RunWriter(tmp_path / "other", world, STEP):
        raise RuntimeError("enough")
    assert tulle.Run(tmp_path / "other").state == tulle.RunState.FAILED
    with pytest.raises(tulle.InvalidArgumentError, match="holds a run already"):
        tulle.RunWriter(tmp_path / "mine", world, STEP)


def test_rounding_that_leads_a_far_obstacle_through_cloth_is_refused(tmp_path: Path) -> None:
    """Far corners of a sloped triangle are rounded by up to a millimetre, so its middle sinks past a sheet right under it."""
    sheet = np.array([[-10, -10, -9.72], [10, -10, 10.28], [-10, 10, -9.72], [10, 10, 10.28]]) / 1000
    plane = np.array([[20000, 0, 20000.0009], [-10000, -17320, -9999.9996], [-10000, 17320, -9999.9996]])
    far = tulle.World(threads=1, gravity=(0, 0, 0), contact_distance=1e-4, minimum_gap=1e-5)
    far.add_cloth(tulle.Mesh(sheet, [[0, 1, 2], [2, 1, 3]]), name="sheet")
    obstacle = far.add_obstacle(tulle.Mesh(plane, [[0, 1, 2]]), name="plane", drive="deforming")
    with pytest.raises(tulle.LimitError, match="'plane'.*through.*'sheet'"), tulle.RunWriter(tmp_path / "far", far, STEP):
        pass
    assert obstacle.positions[0, 2] == 20000.0009


def test_the_program_is_not_looked_for_in_the_present_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "elsewhere").mkdir()
    for folder in (tmp_path, tmp_path / "elsewhere"):
        (folder / "other").write_text("#!/bin/sh\n")
        (folder / "other").chmod(0o755)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", os.pathsep.join([".", "", str(tmp_path / "elsewhere")]))
    assert find_program("other") == tmp_path / "elsewhere" / "other" and find_program("./other") == tmp_path / "other"
    monkeypatch.setenv("PATH", ".")
    with pytest.raises(FileNotFoundError, match="names other"):
        find_program("other")


def test_what_never_moves_is_written_as_still(tmp_path: Path, world: tulle.World, ball: tulle.Mesh) -> None:
    far = [ball.transform(translation=(2.0 * k, 3, 0)) for k in range(1, 6)]
    key = {"rotation_vector": (0.0, 0.0, 0.0)}
    world.add_obstacle(far[0], name="scripted", motion={"keys": [key, {**key, "time": 1.0, "translation": (0, 0, 1)}]})
    world.add_obstacle(far[1], name="frames", frames=np.array([far[1].positions, far[1].positions + 0.1]), frame_interval=0.5)
    world.add_obstacle(far[2], name="driven", drive="rigid")
    world.add_obstacle(far[3], name="body", body={"density": 300})
    assert [each.is_static for each in world.obstacles] == [True, False, False, False, False]
    with tulle.RunWriter(tmp_path / "run", world, STEP) as writer:
        world.step(STEP)
        writer.write_frame()
    run = tulle.Run(tmp_path / "run")
    assert [body.name for body in run.bodies if body.is_static] == ["ball"]
    assert {path.name for path in (tmp_path / "run").glob("*.pc2")} == {
        f"{name}.pc2" for name in ("sheet", "scripted", "frames", "driven", "body")}
    assert np.array_equal(run.find_body("ball").read_positions(-1), ball.positions) and run.find_damage() == []


def test_what_stands_is_grey_and_ground_has_no_end(ball: tulle.Mesh) -> None:
    """Pixels of a picture of a world: a ball that stands is grey, and ground under all cloth is an endless floor."""
    made = tulle.World(threads=1)
    made.add_cloth(tulle.make_shape("rectangle", size=(0.2, 0.2), resolution=3).transform(translation=(0, 0, 0.6)))
    made.add_obstacle(ball)
    made.add_obstacle(tulle.make_shape("plane", size=(1, 1)).transform(translation=(0, 0, -0.3)))
    try:
        picture = tulle.render(made, size=(64, 36), samples=4, options=["--camera", "position=0,-6,0.5,target=0,0,0"])
    except tulle.ProgramError as failure:
        if "without Embree" in failure.message:
            pytest.skip("the program draws no pictures")
        raise
    red, _, blue = (int(value) for value in picture[18, 32])
    assert abs(blue - red) < 0.15 * blue  # a moving one: blue is half as much again
    left, middle = (picture[22, column].astype(int) for column in (1, 20))  # beyond the plane, and on it
    assert abs(left - middle).max() < 12


def test_a_crate_hides_no_cloth() -> None:
    made = tulle.World(threads=1)
    made.add_cloth(tulle.make_shape("rectangle", size=(0.3, 0.3), resolution=5).transform(translation=(0, 0, 0.05)))
    for x, y in ((0.3, 0), (-0.3, 0), (0, 0.3), (0, -0.3)):
        size = (0.6 if y else 0.02, 0.6 if x else 0.02, 0.4)
        made.add_obstacle(tulle.make_shape("box", size=size).transform(translation=(x, y, 0.21)))
    try:
        picture = tulle.render(made, size=(64, 36), samples=4).astype(int)
    except tulle.ProgramError as failure:
        if "without Embree" in failure.message:
            pytest.skip("the program draws no pictures")
        raise
    red = picture[:, :, 0] > picture[:, :, 2] + 30
    assert red.mean() > 0.1


def test_pictures(world: tulle.World) -> None:
    try:
        picture = tulle.render(world, size=(64, 36), samples=2)
    except tulle.ProgramError as failure:
        pytest.skip(str(failure))
    assert picture.shape == (36, 64, 3) and picture.dtype == np.uint8 and picture.std() > 5


def test_pixels_of_png_files(tmp_path: Path) -> None:
    plot = pytest.importorskip("matplotlib.image")
    picture = np.random.default_rng(1).integers(0, 40, (17, 23, 3)).cumsum(axis=0).astype(np.uint8)
    plot.imsave(tmp_path / "a.png", picture)
    from tulle.program import read_png
    assert np.array_equal(read_png(tmp_path / "a.png")[..., :3], picture)
    (tmp_path / "b.png").write_bytes(b"no picture")
    with pytest.raises(tulle.ParseError, match="PNG"):
        read_png(tmp_path / "b.png")


def test_other_calls_of_the_program(tmp_path: Path, sheet: tulle.Mesh, monkeypatch: pytest.MonkeyPatch) -> None:
    sheet.write(tmp_path / "a.obj")
    sheet.transform(scale=(1, 1, 1), translation=(0, 0, -1)).write(tmp_path / "b.obj")
    assert tulle.detect_files(tmp_path / "a.obj", tmp_path / "b.obj")["events"]["vertex_face"] == 0
    tulle.convert(tmp_path / "a.obj", tmp_path / "a.ply")
    assert np.array_equal(tulle.Mesh.read(tmp_path / "a.ply").positions, sheet.positions)
    monkeypatch.setenv("TULLE", str(tmp_path / "nothing"))
    with pytest.raises(tulle.ProgramError, match="environment variable TULLE"):
        tulle.run_program("--version")


INTERRUPTED = """
import sys, tulle
scene, output = sys.argv[1:]
try:
    tulle.simulate(scene, output, overrides={"time.frames": 2000}, progress=lambda event: print(event["event"], flush=True))
except KeyboardInterrupt:
    print("state", tulle.Run(output).state.name, flush=True)
"""
STEPPING = """
import sys, time, tulle
world = tulle.World(threads=1)
cloth = world.add_cloth(tulle.make_shape("rectangle", resolution=100).transform(translation=(0, 0, 0.301)))
world.add_obstacle(tulle.make_shape("sphere", radius=0.3))
world.start()
print("step", flush=True)
try:
    while True:
        before = world.state_hash
        world.step(1 / 24)
except KeyboardInterrupt:
    print("state", world.state_hash == before, flush=True)
"""


@pytest.mark.parametrize(("script", "arguments"), [(INTERRUPTED, [str(SCENE)]), (STEPPING, [])])
def test_ctrl_c(tmp_path: Path, script: str, arguments: list) -> None:
    script = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n" + script  # a shell's background ignores it
    child = subprocess.Popen([sys.executable, "-c", script, *arguments, *([str(tmp_path / "run")] if arguments else [])],
                             stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert child.stdout is not None
    for line in child.stdout:
        if line.startswith("step"):
            break
    time.sleep(0.3)
    os.kill(child.pid, signal.SIGINT)
    out, err = child.communicate(timeout=60)
    assert child.returncode == 0, err
    assert out.splitlines()[-1] == ("state INTERRUPTED" if arguments else "state True")


def test_worlds_of_one_scene_read_its_mesh_sequence_side_by_side(tmp_path: Path) -> None:
    ball = tulle.make_shape("sphere", radius=0.2, resolution=16)
    ball.write(tmp_path / "ball.obj")
    with tulle.PointCacheWriter(tmp_path / "ball.pc2", ball.vertex_count) as cache:
        for i in range(60):
            cache.append(ball.positions + [0, 0, 2e-3 * i])
    (tmp_path / "scene.yaml").write_text(
        "time: {step: 0.01, frames: 10}\ncloth:\n  - mesh: {shape: rectangle, resolution: [2, 2]}\n    translate: [0, 0, 5]\n"
        "obstacles:\n  - mesh: {file: ball.obj}\n    motion: {sequence: {cache: ball.pc2, fps: 60}}\n")
    scene = tulle.Scene(tmp_path / "scene.yaml")
    failures: list[int] = []

    def run() -> None:
        world = scene.build_world(threads=1)
        for i in range(58):
            world.step(1 / 60)
            if abs(world.obstacles[0].positions[0, 2] - ball.positions[0, 2] - 2e-3 * (i + 1)) > 1e-6:
                failures.append(i)

    threads = [threading.Thread(target=run) for _ in range(12)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not failures
