#!/usr/bin/env python3
"""What steps of environments cost (tulle.envs): many side by side on one thread and on all, beside a single one; and worlds
with the same cloth on a ball in Tulle and in MuJoCo, where its package is there. Prints Markdown.

usage: PYTHONPATH=python bench_envs.py [--count N] [--actions N] [--resolution N] [--peers DIR]

DIR is what bench/peers/prepare.sh made, build/peers by default.
"""
from __future__ import annotations

import argparse
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Optional

import numpy as np
import tulle
from tulle import envs

HERE = Path(__file__).resolve().parent
STEP = 0.01  # [s] of worlds
FRAMES, INTERVAL = 24, 1 / 24  # of a drape


def bench_task(name: str, resolution: int, count: int, actions: int) -> str:
    """A row of the table. Batches on one thread, on all, and one environment alone take each action in turn: what else the
    machine does meets them alike, and all come to the same states."""
    kinds = {"alone": envs.make(name, 1, threads=1, resolution=resolution)}
    kinds.update({words: envs.make(name, count, threads=threads, resolution=resolution)
                  for words, threads in (("one thread", 1), ("all threads", 0))})
    policies = {kind: envs.scripted_policy(name) for kind in kinds}
    observations = {kind: made.reset(seed=0)[0] for kind, made in kinds.items()}
    rates: dict[str, list[float]] = {kind: [] for kind in kinds}
    for _ in range(actions):
        for kind, made in kinds.items():
            start = time.perf_counter()
            observations[kind], *_ = made.step(policies[kind](observations[kind]))
            rates[kind].append(made.num_envs / (time.perf_counter() - start))
    particles = kinds["alone"].worlds[0].cloths[0].vertex_count
    for made in kinds.values():
        made.close()
    alone, single, every = (statistics.harmonic_mean(rates[kind]) for kind in kinds)
    ratio = statistics.median(b / a for a, b in zip(rates["one thread"], rates["all threads"]))
    return f"| {name} | {particles} | {alone:.0f} | {single:.0f} | {every:.0f} | {ratio:.2f} |"


def make_drape(resolution: int) -> tuple[tulle.Mesh, tulle.Mesh]:
    """A sheet just above a ball."""
    sheet = tulle.make_shape("rectangle", size=(0.3, 0.3), resolution=resolution).transform(translation=(0, 0, 0.11))
    return sheet, tulle.make_shape("sphere", radius=0.1, resolution=8)


def drape_in_tulle(count: int, resolution: int, threads: int) -> tuple[float, int]:
    """Seconds of motion of a world in a second, and pairs of triangles that intersect at the end."""
    sheet, ball = make_drape(resolution)
    worlds = []
    for _ in range(count):
        world = tulle.World(threads=1)
        world.add_cloth(sheet)
        world.add_obstacle(ball)
        world.start()
        worlds.append(world)
    steps = round(FRAMES * INTERVAL / STEP)
    start = time.perf_counter()
    for _ in range(steps):
        tulle.step_worlds(worlds, STEP, threads)
    rate = count * steps * STEP / (time.perf_counter() - start)
    return rate, int(tulle.Judge().find_world_intersections(worlds[0]).pairs.size)


def drape_in_mujoco(peers: Path, resolution: int) -> Optional[tuple[float, int, str]]:
    """The same of MuJoCo as its own model of cloth on a sphere is set, on one thread, and its version; None: not there."""
    modules = peers / "node_modules"
    if not (modules / "@mujoco" / "mujoco").exists():
        return None
    sys.path.insert(0, str(HERE / "peers"))
    import cases  # what all comparisons with it use
    sheet, ball = make_drape(resolution)
    edge = float(np.mean([np.linalg.norm(sheet.positions[a] - sheet.positions[b]) for a, b, _ in sheet.triangles.astype(int)]))
    friction = (cases.COTTON["friction"] * 0.3) ** 0.5
    settings: dict[str, Any] = cases.mujoco(SimpleNamespace(thickness=min(0.2 * edge, 0.005)))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        sheet.write(folder / "cloth.obj")
        ball.write(folder / "ball.obj")
        lines = [f"cloth {folder / 'cloth.obj'}", f"obstacle {folder / 'ball.obj'} {friction:.9g}",
                 f"mass {cases.COTTON['area_density'] * 0.09:.9g}", f"gravity {cases.GRAVITY}", f"frames {FRAMES}",
                 f"interval {INTERVAL:.12g}", "limit 300"]
        lines += [f"set {key} {value if isinstance(value, str) else format(value, '.9g')}" for key, value in settings.items()]
        (folder / "case.txt").write_text("\n".join(lines) + "\n")
        subprocess.run(["node", str(HERE / "peers" / "mujoco_driver.mjs"), str(modules), str(folder / "case.txt"), str(folder)],
                       check=True)
        told = [line.split(" ", 1) for line in (folder / "told.txt").read_text().splitlines()]
        last, cpu = (float(value) for value in [rest for key, rest in told if key == "frame"][-1].split())
        frames = np.fromfile(folder / "frames.raw", np.float32).reshape(-1, sheet.vertex_count, 3)
        pairs = tulle.Judge().find_intersections([tulle.Mesh(frames[-1].astype(float), sheet.triangles)], [ball]).pairs
    return last / cpu, int(pairs.size), next(rest for key, rest in told if key == "version")


def main() -> None:
    parser = argparse.ArgumentParser(description="Steps of environments in a second.")
    parser.add_argument("--count", type=int, default=64)
    parser.add_argument("--actions", type=int, default=40)
    parser.add_argument("--resolution", type=int, default=20)
    parser.add_argument("--peers", type=Path, default=HERE.parent / "build" / "peers")
    options = parser.parse_args()
    print(f"Steps of an environment in a second; {options.count} side by side, over {options.actions} actions.\n")
    print("| task | particles | alone | one thread | all threads | all over one |")
    print("|---|---|---|---|---|---|")
    for name in envs.list_tasks():
        print(bench_task(name, options.resolution, options.count, options.actions), flush=True)
    print(f"\nSeconds of motion in a second: {options.resolution**2} particles fall on a ball.\n")
    print("| | worlds | rate | intersecting pairs at the end |")
    print("|---|---|---|---|")
    for count, threads, words in ((1, 1, "one thread"), (options.count, 1, "one thread"), (options.count, 0, "all threads")):
        rate, pairs = drape_in_tulle(count, options.resolution, threads)
        print(f"| Tulle, {words} | {count} | {rate:.2f} | {pairs} |", flush=True)
    found = drape_in_mujoco(options.peers, options.resolution)
    if found is None:
        print(f"| MuJoCo | | not there: sh bench/peers/prepare.sh {options.peers} | |")
    else:
        print(f"| MuJoCo {found[2]} | 1 | {found[0]:.2f} | {found[1]} |")


if __name__ == "__main__":
    main()
