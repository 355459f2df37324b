#!/usr/bin/env python3
"""What the Python package costs beside C: getters, steps, many worlds. Prints a table.

usage: PYTHONPATH=build/release/python bench_python.py [--steps N]

A step's share is the time around `World.step` less `total_seconds` of its report, which is measured within the library.
"""
from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable
from threading import Thread
from typing import Any

import tulle

STEP = 1 / 90


def make_world(resolution: int, threads: int = 1) -> tulle.World:
    """A sheet that lies on a ball."""
    world = tulle.World(threads=threads)
    world.add_cloth(tulle.make_shape("rectangle", resolution=resolution).transform(translation=(0, 0, 0.31)))
    world.add_obstacle(tulle.make_shape("sphere", radius=0.3, resolution=8))
    world.start()
    return world


def measure(call: Callable[[], Any], count: int) -> float:
    """[s] of a call, the median of seven rounds."""
    rounds = []
    for _ in range(7):
        begin = time.perf_counter()
        for _ in range(count):
            call()
        rounds.append((time.perf_counter() - begin) / count)
    return statistics.median(rounds)


def measure_getters() -> None:
    world = make_world(20)
    world.step(STEP)
    cloth = world.cloths[0]
    print("getter                  [us]")
    for name, call in {"World.time": lambda: world.time, "World.step_count": lambda: world.step_count,
                       "Cloth.positions": lambda: cloth.positions, "Cloth.velocities": lambda: cloth.velocities,
                       "Cloth.triangles": lambda: cloth.triangles, "Cloth.is_asleep": lambda: cloth.is_asleep,
                       "Cloth.vertex_count": lambda: cloth.vertex_count}.items():
        print(f"{name:22s} {1e6 * measure(call, 20000):5.2f}")


def measure_steps(steps: int) -> None:
    print("\nparticles  step [ms]  Python's share  positions [us]")
    for resolution in (10, 20, 40, 100):
        world = make_world(resolution)
        outside, inside, copies = [], [], []
        for _ in range(steps):
            begin = time.perf_counter()
            report = world.step(STEP)
            end = time.perf_counter()
            positions = world.cloths[0].positions
            copies.append(time.perf_counter() - end)
            outside.append(end - begin)
            inside.append(report.total_seconds)
        extra = statistics.median(a - b for a, b in zip(outside, inside))
        print(f"{positions.shape[0]:9d}  {1e3 * statistics.median(outside):9.3f}  {extra / statistics.median(inside):13.2%}"
              f"  {1e6 * statistics.median(copies):14.1f}")


def measure_worlds(steps: int) -> None:
    print("\n64 worlds of 400 particles      steps/s  beside one thread")
    first = 0.0
    for name, threads in (("step_worlds, one thread", 1), ("step_worlds, two threads", 2), ("two Python threads", 0)):
        worlds = [make_world(20) for _ in range(64)]

        def run(part: list[tulle.World]) -> None:
            for _ in range(steps):
                for world in part:
                    world.step(STEP)

        begin = time.perf_counter()
        if threads:
            for _ in range(steps):
                tulle.step_worlds(worlds, STEP, threads)
        else:
            each = [Thread(target=run, args=(worlds[i::2],)) for i in range(2)]
            for thread in each:
                thread.start()
            for thread in each:
                thread.join()
        rate = 64 * steps / (time.perf_counter() - begin)
        first = first or rate
        print(f"{name:28s} {rate:10.0f}  {rate / first:17.2f}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0] if __doc__ else None)
    parser.add_argument("--steps", type=int, default=60, help="steps of each world (default: 60)")
    steps = parser.parse_args().steps
    measure_getters()
    measure_steps(steps)
    measure_worlds(steps)


if __name__ == "__main__":
    main()
