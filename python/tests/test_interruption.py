"""Ctrl-C at any moment, callbacks that fail, copies and threads that would break a world: none leaves it in disorder."""
from __future__ import annotations

import copy
import pickle
import random
import signal
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tulle

STEP = 1 / 90


def interrupt_often(count: int, use: Callable[[], Any], check: Callable[[], None]) -> None:
    """Repeats `use` and breaks into it `count` times, then calls `check` each time."""
    random.seed(1)
    interrupted = 0
    former = signal.signal(signal.SIGALRM, signal.default_int_handler)
    try:
        for _ in range(count):
            deadline = time.monotonic() + 5  # one in a destructor is lost, as Python has it
            try:
                signal.setitimer(signal.ITIMER_REAL, random.uniform(2e-5, 2e-3))
                while time.monotonic() < deadline:
                    use()
            except KeyboardInterrupt:
                interrupted += 1
            check()
        assert interrupted > count / 2
    finally:
        signal.signal(signal.SIGALRM, former)


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="needs timers of POSIX")
@pytest.mark.parametrize("is_batch", [False, True])
def test_an_interrupted_world_can_be_used_and_tells_its_state(is_batch: bool) -> None:
    worlds = []
    for _ in range(3 if is_batch else 1):
        world = tulle.World(threads=1)
        world.add_cloth(tulle.make_shape("rectangle", resolution=4))
        world.step(1e-4)
        worlds.append(world)
    cloths = [world.cloths[0] for world in worlds]

    def use() -> None:
        for world, cloth in zip(worlds, cloths):
            assert world.time > 0 and cloth.positions.shape == (16, 3)
        if is_batch:
            tulle.step_worlds(worlds, 1e-4, threads=1)
        else:
            worlds[0].step(1e-4)

    def check() -> None:
        for cloth in cloths:
            assert np.array_equal(cloth.positions, cloth.copy_values("positions")), "an array of an earlier state"

    interrupt_often(800, use, check)


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="needs timers of POSIX")
@pytest.mark.parametrize("is_obstacle", [False, True])
def test_an_interrupted_world_knows_its_objects(is_obstacle: bool) -> None:
    world = tulle.World(threads=1)
    mesh = tulle.make_shape("rectangle", resolution=200)

    def use() -> None:
        moved = mesh.transform(translation=(0, 0, len(world.objects)))
        signal.setitimer(signal.ITIMER_REAL, 2e-3)
        (world.add_obstacle if is_obstacle else world.add_cloth)(moved)

    def check() -> None:
        counts = world.counts
        assert counts.cloths == len(world.cloths) and counts.obstacles == len(world.obstacles)

    interrupt_often(4, use, check)


@pytest.mark.parametrize("call", [lambda world: world.start(), lambda world: world.step(STEP), lambda world: tulle.step_worlds([world], STEP)])
def test_what_a_pair_filter_raises_is_raised(world: tulle.World, call: Callable[[tulle.World], Any]) -> None:
    def collides(first: tulle.Object, second: tulle.Object) -> bool:
        raise KeyError("no such pair")

    world.set_pair_filter(collides)
    with pytest.raises(KeyError, match="no such pair"):
        call(world)
    world.step(STEP)


def test_a_callback_that_fails_leaves_no_stale_array_of_other_worlds(sheet: tulle.Mesh, ball: tulle.Mesh) -> None:
    def give(frame: int) -> Any:
        raise KeyError("lost")

    good, bad = tulle.World(threads=1), tulle.World(threads=1)
    cloth = good.add_cloth(sheet)
    bad.add_cloth(sheet)
    bad.add_obstacle(ball, frames=give, frame_count=9, frame_interval=STEP)
    good.step(STEP)
    positions = cloth.positions
    with pytest.raises(KeyError, match="lost"):
        tulle.step_worlds([bad, good], STEP)
    assert good.step_count == 2
    with pytest.raises(tulle.StaleError):
        positions.sum()
    assert np.array_equal(cloth.positions, cloth.copy_values("positions"))


def test_a_step_that_fails_leaves_arrays_as_they_are(world: tulle.World) -> None:
    world.step(STEP)
    positions = world.cloths[0].positions
    for call in (lambda: world.step(-1), lambda: world.add_obstacle(world.cloths[0].mesh), lambda: world.load_state(b"none"), lambda: tulle.step_worlds([world], STEP, threads=-1)):
        with pytest.raises(tulle.Error):
            call()
    with pytest.raises(TypeError):
        world.step("soon")  # type: ignore[arg-type]
    assert isinstance(tulle.step_worlds([world], -1)[0], tulle.Error)
    assert positions.shape and positions.sum() == world.cloths[0].positions.sum() and world.cloths[0].positions is positions


def test_handles_are_not_copied(world: tulle.World, tmp_path: Path) -> None:
    world.start()
    cloth = world.cloths[0]
    detector = tulle.Detector(cloth.triangles, cloth.vertex_count)
    with tulle.RunWriter(tmp_path / "run", world, STEP) as run, tulle.PointCacheWriter(tmp_path / "a.pc2", 3) as cache:
        for each in (world, detector, run, cache):
            for copying in (copy.copy, copy.deepcopy, pickle.dumps):
                with pytest.raises(TypeError, match=f"{type(each).__name__} can be neither copied"):
                    copying(each)
    assert detector.find_events(cloth.positions, cloth.positions).events.size == 0 and world.step(STEP).step == 0


def test_a_run_is_written_by_one_thread_at_a_time(world: tulle.World, tmp_path: Path) -> None:
    world.start()
    writer, failures = tulle.RunWriter(tmp_path / "run", world, STEP), []  # type: ignore[var-annotated]

    def write() -> None:
        try:
            for _ in range(200):
                writer.write_frame()
        except tulle.Error as failure:
            failures.append(failure)

    threads = [threading.Thread(target=write) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    writer.close()
    assert all(isinstance(failure, tulle.BusyError) for failure in failures)
    run = tulle.Run(tmp_path / "run")
    assert run.frame_count > 1 and not run.find_damage()
