"""What is wrong is told as an exception, and nothing has changed then."""
from __future__ import annotations

import pickle
import threading
import time

import numpy as np
import pytest
import tulle

STEP = 1 / 90


def test_every_status_has_its_exception() -> None:
    from tulle.errors import _CLASSES
    assert len(_CLASSES) == len(tulle.Status)
    for status in tulle.Status:
        name = "".join(part.capitalize() for part in status.name.split("_"))
        assert status == tulle.Status.OK or _CLASSES[status].__name__ in (f"{name}Error", "FileError"), name


@pytest.mark.parametrize(("make", "kind", "words"), [
    (lambda: tulle.World(gravty=(0, 0, 0)), TypeError, "did you mean \"gravity\""),
    (lambda: tulle.World(gravity=(0, 0)), tulle.InvalidArgumentError, "3 numbers"),
    (lambda: tulle.World(gravity=(0, 0, np.nan)), tulle.InvalidArgumentError, "gravity"),
    (lambda: tulle.World(threads=-1), tulle.InvalidArgumentError, "threads"),
    (lambda: tulle.World(threads=2**40), tulle.InvalidArgumentError, "threads"),
    (lambda: tulle.World(threads="many"), tulle.InvalidArgumentError, "threads"),
    (lambda: tulle.World(on_pinch="lagg"), tulle.InvalidArgumentError, "\"stop\""),
    (lambda: tulle.World(on_pinch=77), tulle.InvalidArgumentError, "OnPinch"),
    (lambda: tulle.World(wind={"speed": 1}), TypeError, "wind"),
    (lambda: tulle.World(wind=3), TypeError, "Wind"),
    (lambda: tulle.make_shape("spher"), tulle.InvalidArgumentError, "sphere"),
    (lambda: tulle.make_shape("sphere", radius=-1), tulle.InvalidArgumentError, "radius"),
    (lambda: tulle.make_shape("box", radius=1), tulle.InvalidArgumentError, "box: radius does not apply to this shape; it takes size"),
    (lambda: tulle.make_shape("sphere", resolution=(24, 12)), tulle.InvalidArgumentError, "resolution.1. does not apply"),
    (lambda: tulle.make_shape("sphere", size=(1, 1)), tulle.InvalidArgumentError, "sphere: size.0. does not apply"),
    (lambda: tulle.make_shape("plane", seed=3), tulle.InvalidArgumentError, "plane: seed does not apply"),
    (lambda: tulle.make_shape("torus", is_irregular=True), tulle.InvalidArgumentError, "torus: is_irregular does not apply"),
    (lambda: tulle.make_shape("rectangle", size=(1, 1, 1)), tulle.InvalidArgumentError, "rectangle takes 2 numbers"),
    (lambda: tulle.make_shape("box", size=1), tulle.InvalidArgumentError, "box takes 3 numbers"),
    (lambda: tulle.make_shape("rectangle", resolution=1.5), tulle.InvalidArgumentError, "whole"),
    (lambda: tulle.make_shape("rectangle", resolution=10**5), tulle.LimitError, "10000000"),
    (lambda: tulle.make_material("wooll"), tulle.InvalidArgumentError, "wool"),
    (lambda: tulle.Mesh.read("/nowhere/a.obj"), tulle.FileError, "/nowhere/a.obj"),
    (lambda: tulle.Mesh.read("a\0b.obj"), tulle.InvalidArgumentError, "zero byte"),
    (lambda: tulle.Scene("/nowhere/a.yaml"), tulle.FileError, "/nowhere/a.yaml"),
    (lambda: tulle.Run("/nowhere"), tulle.FileError, "nowhere"),
    (lambda: tulle.PointCache("/nowhere.pc2"), tulle.FileError, "nowhere"),
    (lambda: tulle.Detector([[0, 1, 9]], 3), tulle.InvalidMeshError, "9"),
    (lambda: tulle.Detector([[0, 1, 2]], -3), (tulle.InvalidArgumentError, OverflowError), ""),
    (lambda: tulle.World(allocator={"byte_limit": 10}), tulle.OutOfMemoryError, "")])
def test_what_is_wrong_is_told(make, kind, words: str) -> None:
    with pytest.raises(kind, match=words):
        make()


@pytest.mark.parametrize(("use", "words"), [
    (lambda world: world.add_cloth(None), "mesh should be a Mesh, not a NoneType"),
    (lambda world: world.add_cloth(world.cloths[0]), "its `mesh` is one"),
    (lambda world: world.add_obstacle("ball.obj"), "not a str"),
    (lambda world: world.find_mesh_overlaps([[0, 1, 2]]), "not a list"),
    (lambda world: tulle.Judge().find_intersections(world.cloths), "body 0 should be a Mesh, not a Cloth: its `mesh` is one"),
    (lambda world: world.remove("sheet"), "not a str"),
    (lambda world: world.find_object(3), "not by a int"),
    (lambda world: world.attach("sheet", [0], [[0, 0, 0]]), "not a str"),
    (lambda world: world.set_law(world.cloths[0], None), "not a NoneType")])
def test_other_types_are_told(world: tulle.World, use, words: str) -> None:
    with pytest.raises(TypeError, match=words):
        use(world)


def test_places_in_files(tmp_path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text("cloth:\n  - mesh: {shape: rectangle, resolution: [4, -4]}\n    materiel: silk\n")
    with pytest.raises(tulle.Error) as caught:
        tulle.Scene(path)
    error = caught.value
    assert error.file == str(path) and error.line in (2, 3) and error.column > 1 and str(error).startswith(f"{path}:{error.line}:")
    assert len(error.problems) >= 2 and {problem.line for problem in error.problems} >= {2, 3}
    again = pickle.loads(pickle.dumps(error))
    assert (type(again), again.line, str(again)) == (type(error), error.line, str(error))
    mesh = tmp_path / "broken.obj"
    mesh.write_text("v 0 0 0\nv 1 0 zero\n")
    with pytest.raises(tulle.ParseError) as caught:
        tulle.Mesh.read(mesh)
    assert caught.value.line == 2


def test_a_closed_world(world: tulle.World) -> None:
    world.step(STEP)
    cloth, positions = world.cloths[0], world.cloths[0].positions
    world.close()
    world.close()
    for use in (lambda: world.step(STEP), lambda: world.time, lambda: cloth.positions, world.save_state,
                lambda: world.add_cloth(tulle.make_shape("rectangle")), lambda: tulle.step_worlds([world], STEP), world.get_contacts,
                lambda: world.state_hash, lambda: world.cast_ray((0, 0, 1), (0, 0, 0)), lambda: cloth.wake()):
        with pytest.raises(tulle.ClosedError):
            use()
    with pytest.raises(tulle.StaleError):
        positions.sum()
    assert repr(world) == "World(closed)"


def test_objects_of_another_world(world: tulle.World, sheet: tulle.Mesh) -> None:
    other = tulle.World()
    stranger = other.add_cloth(sheet)
    for use in (lambda: world.remove(stranger), lambda: world.attach(stranger, [0], [[0, 0, 0]]),
                lambda: world.set_law(world.cloths[0], stranger)):
        with pytest.raises(tulle.InvalidArgumentError, match="another world"):
            use()


def test_one_world_in_two_threads() -> None:
    world = tulle.World(threads=1)
    world.add_cloth(tulle.make_shape("rectangle", resolution=60).transform(translation=(0, 0, 0.4)))
    world.add_obstacle(tulle.make_shape("sphere", radius=0.3))
    world.start()
    failures: list[BaseException] = []
    is_done = threading.Event()

    def run() -> None:
        try:
            for _ in range(10):
                world.step(STEP)
        except BaseException as failure:
            failures.append(failure)
        is_done.set()

    thread = threading.Thread(target=run)
    thread.start()
    refused = 0
    while not is_done.is_set():
        for use in (lambda: world.step(STEP), lambda: world.state_hash, lambda: world.save_state(), lambda: world.cloths[0].velocities):
            try:
                use()
            except tulle.BusyError:
                refused += 1
        time.sleep(0.001)
    thread.join()
    assert refused > 10
    assert not [failure for failure in failures if not isinstance(failure, tulle.BusyError)]


def test_a_step_of_another_thread_can_be_stopped() -> None:
    world = tulle.World(threads=1)
    world.add_cloth(tulle.make_shape("rectangle", resolution=150).transform(translation=(0, 0, 0.31)))
    world.add_obstacle(tulle.make_shape("sphere", radius=0.3))
    world.start()
    caught: list[BaseException] = []

    def run() -> None:
        try:
            while True:
                world.step(1 / 24)
        except tulle.Error as failure:
            caught.append(failure)

    thread = threading.Thread(target=run)
    thread.start()
    deadline = time.time() + 30
    while thread.is_alive() and time.time() < deadline:
        world.interrupt()
        time.sleep(0.005)
    thread.join(1)
    assert isinstance(caught[0], tulle.errors.InterruptedError)
    world.step(STEP)


def test_what_a_callback_raises_ends_the_call(sheet: tulle.Mesh, ball: tulle.Mesh) -> None:
    def give(frame: int) -> np.ndarray:
        if frame > 2:
            raise KeyError("frame 3 was lost")
        return ball.positions

    world = tulle.World(threads=1)
    world.add_cloth(sheet)
    world.add_obstacle(ball, frames=give, frame_count=9, frame_interval=STEP)
    world.step(STEP)
    with pytest.raises(KeyError, match="was lost"):
        for _ in range(9):
            world.step(STEP)
    steps = world.step_count
    assert steps < 4
    with pytest.raises(KeyError, match="was lost"):
        world.step(STEP)
    assert world.step_count == steps

    short = tulle.World(threads=1)
    short.add_cloth(sheet)
    short.add_obstacle(ball, frames=lambda frame: np.zeros((2, 3)), frame_count=9, frame_interval=STEP)
    with pytest.raises(tulle.InvalidArgumentError, match="frame 0 should have the shape"):
        short.step(STEP)


def test_a_callback_must_not_use_its_world(sheet: tulle.Mesh, ball: tulle.Mesh) -> None:
    world = tulle.World(threads=1)
    world.add_cloth(sheet)
    world.add_obstacle(ball, frames=lambda frame: (world.time, ball.positions)[1], frame_count=2, frame_interval=STEP)
    with pytest.raises(tulle.BusyError, match="calls back"):
        world.step(STEP)
