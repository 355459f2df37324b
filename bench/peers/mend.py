#!/usr/bin/env python3
"""Mends what Blender's own cloth makes of the scenes of bench-peers, and judges it before and after.

usage: mend.py [--tulle PROGRAM] [--scenes sphere,needles,spikes] [--frames 24] [--limit 300] [--work build/peers] [--fresh]

Blender runs with its default quality, as in run.py; its frames are taken from there where they are. Beside them are written
`blender.pc2`, `mended.pc2`, `mended.csv` (the report by frame) and `away.ply` (the departures of the worst frame as colours).
Both are judged by `tulle check`. Prints a table for docs/guide/mend.md.
"""
import argparse
import csv
import json
import pathlib
import subprocess
import sys

SCENES = ("sphere", "needles", "spikes")
HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import cases  # noqa: E402
import drivers  # noqa: E402
import meshes  # noqa: E402


def simulate(options, scene):
    """The frames of Blender, the mesh and the obstacles."""
    folder, run = options.work / scene / "blender_default_quality", options.work / scene / "tulle" / "run"
    if options.fresh or not (folder / "frames.raw").exists():
        drivers.run_tulle(options, scene, options.work / scene / "tulle")
        physics = cases.Physics(run, meshes.Mesh(run / "cloth.obj"))
        result = drivers.run_peer(options, "Blender", cases.blender_matched(physics, 5, 2), physics, run, folder)
        if not result.frames:
            sys.exit(f"mend.py: {scene}: {result.message}")
    cloth = meshes.Mesh(run / "cloth.obj")
    frames = meshes.read_frames(folder / "frames.raw", len(cloth.vertices))
    obstacles = sorted(path for path in run.glob("*.obj") if path.name != "cloth.obj")
    return folder, run / "cloth.obj", frames, obstacles, cloth.mean_edge


def mend(options, folder, mesh, obstacles):
    bodies = [word for obstacle in obstacles for word in ("--body", obstacle)]
    command = [options.tulle, "mend", folder / "blender.pc2", "--mesh", mesh, *bodies, "-o", folder / "mended.pc2",
               "--report", folder / "mended.csv", "--colors", folder / "away.ply", "--json"]  # fmt: skip
    said = subprocess.run(command, capture_output=True, text=True, check=False)
    if said.returncode not in (0, 1):
        sys.exit(f"mend.py: {said.stderr}")
    summary = json.loads(said.stdout.splitlines()[-1])
    with open(folder / "mended.csv", encoding="utf-8") as file:
        summary["slowest"] = max(float(row["seconds"]) for row in csv.DictReader(file))
    return summary


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tulle", default="build/release/tulle", type=pathlib.Path)
    parser.add_argument("--scenes", default=",".join(SCENES), type=lambda text: text.split(","))
    parser.add_argument("--frames", default=24, type=int, help="of 1/24 s")
    parser.add_argument("--limit", default=300.0, type=float, help="seconds of processor time for Blender")
    parser.add_argument("--work", default="build/peers", type=pathlib.Path)
    parser.add_argument("--fresh", action="store_true", help="run Blender anew")
    options = parser.parse_args()
    options.tulle, options.work = str(options.tulle.resolve()), options.work.resolve()
    print("| scene | pairs before: itself, bodies | after | departure at most | mean acceleration given, mended "
          "| jitter given, mended | time a frame, at most |")
    print("|---|---|---|---|---|---|---|")
    for scene in options.scenes:
        folder, mesh, frames, obstacles, edge = simulate(options, scene)
        meshes.write_cache(folder / "blender.pc2", frames)
        summary = mend(options, folder, mesh, obstacles)
        before = meshes.judge(options.tulle, folder, frames, mesh, obstacles)
        mended = meshes.read_frames(folder / "mended.pc2", len(frames[0]) // 3, skipped=32)
        after = meshes.judge(options.tulle, folder, mended, mesh, obstacles)
        most = [[max(pairs[k] for pairs in frames_pairs) for k in range(2)] for frames_pairs in (before, after)]
        print(f"| {scene} | {most[0][0]}, {most[0][1]} | {most[1][0]}, {most[1][1]} "
              f"| {1000 * summary['largest_departure']:.0f} mm, {summary['largest_departure'] / edge:.1f} edges "
              f"| {1000 * summary['given_acceleration']:.2f}, {1000 * summary['mended_acceleration']:.2f} mm "
              f"| {1000 * summary['given_jitter']:.2f}, {1000 * summary['mended_jitter']:.2f} mm "
              f"| {summary['seconds'] / summary['frames']:.2f}, {summary['slowest']:.1f} s |", flush=True)  # fmt: skip


main()
