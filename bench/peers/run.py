#!/usr/bin/env python3
"""Runs the same scenes in Tulle and in other tools, one after the other on one processor, and compares.

usage: run.py [--tulle PROGRAM] [--scenes sphere,needles,spikes] [--tools Tulle,Blender,...] [--frames 24] [--limit 300]
              [--work build/peers] [--csv build/peers.csv]
       run.py --table CSV [--fill PAGE]      prints the tables of CSV, or puts them into PAGE between their marks

Each run has a folder below --work: the case as its driver reads it (`case.txt`), what the driver told (`told.txt`: `version TEXT`,
`message TEXT`, and `frame TIME CPU`: seconds of motion and of processor time since the scene was loaded), the frames
(`frames.raw`: float32 x, y, z of each vertex) and all that the tool printed (`log`).
A tool that is not there is skipped, and the table says so. --limit is seconds of processor time for a run.
"""
import argparse
import csv
import os
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "tools")]
import cases  # noqa: E402
import drivers  # noqa: E402
import meshes  # noqa: E402
import table  # noqa: E402


def measure(result, cloth, run, tulle, folder):
    """What the frames are like: a part of a CSV row."""
    obstacles = sorted(path for path in pathlib.Path(run).glob("*.obj") if path.name != "cloth.obj")
    finite = []
    for frame in result.frames:
        if not meshes.is_finite(frame):
            result.message = f"positions are no numbers from {result.times[len(finite)]:.3f} s on. {result.message}"
            break
        finite.append(frame)
    pairs = meshes.judge(tulle, folder, finite, pathlib.Path(run) / "cloth.obj", obstacles)
    stretches = [cloth.get_stretches(frame) for frame in finite]
    return {
        "frames": len(finite) - 1,
        "bad_frames": sum(own + other > 0 for own, other in pairs),
        "self_pairs": max(own for own, _ in pairs),
        "obstacle_pairs": max(other for _, other in pairs),
        "stretch_99": f"{max(meshes.get_percentile(values, 99) for values in stretches):.5f}",
        "stretch_most": f"{max(values[-1] for values in stretches):.5f}",
        "lowest": f"{min(min(frame[2::3]) for frame in finite):.4f}",
    }


def make_row(scene, tool, variant, settings, result):
    motion, cpu = result.times[-1], result.cpu[-1]
    return {
        "scene": scene, "tool": tool, "variant": variant, "version": result.version, "settings": settings,
        "motion": f"{motion:.4f}", "cpu": f"{cpu:.3f}",
        "cpu_per_frame": f"{cpu / motion * cases.INTERVAL:.4f}" if motion > 0 else "",
        "memory_mb": f"{result.memory / 1e6:.0f}", "message": result.message,
    }  # fmt: skip


def interpolate(times, values, at):
    """Of a curve from (0, 0) on; beyond its end the end's value."""
    for k in range(1, len(times)):
        if at <= times[k]:
            share = (at - times[k - 1]) / (times[k] - times[k - 1])
            return values[k - 1] + share * (values[k] - values[k - 1])
    return values[-1]


def run_scene(options, scene, rows, write):
    work = options.work / scene
    first = drivers.run_tulle(options, scene, work / "tulle")
    cloth = meshes.Mesh(work / "tulle" / "run" / "cloth.obj")
    physics = cases.Physics(work / "tulle" / "run", cloth)

    def add(tool, variant, settings, result, folder):
        row = make_row(scene, tool, variant, settings, result)
        if result.frames and len(result.times) > 1:
            row.update(measure(result, cloth, work / "tulle" / "run", options.tulle, folder))
            if row["motion"] and tool != "Tulle":
                row["tulle_cpu"] = f"{interpolate(first.times, first.cpu, result.times[-1]):.3f}"
        rows.append(row)
        write()

    add("Tulle", *cases.TULLE, first, work / "tulle")
    long_steps = drivers.run_tulle(options, scene, work / "tulle_long", frame_rate=round(1 / cases.INTERVAL))
    add("Tulle", *cases.TULLE_LONG_STEPS, long_steps, work / "tulle_long")
    for tool, variant, settings, make in cases.PEERS:
        if tool in options.tools:
            folder = work / f"{tool} {variant}".lower().replace(" ", "_")
            result = drivers.run_peer(options, tool, make(physics), physics, work / "tulle" / "run", folder)
            add(tool, variant, settings, result, folder)
    second = drivers.run_tulle(options, scene, work / "tulle_again")
    add("Tulle", "once more, after the others", cases.TULLE[1], second, work / "tulle_again")


def write_rows(path, rows):
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_name(path.name + ".tmp")
    with open(beside, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, table.COLUMNS, restval="", lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    beside.replace(path)


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tulle", default="build/release/tulle", type=pathlib.Path)
    parser.add_argument("--scenes", default=",".join(cases.SCENES), type=lambda text: text.split(","))
    parser.add_argument("--tools", default="Tulle,Blender,MuJoCo,Bullet", type=lambda text: text.split(","))
    parser.add_argument("--frames", default=24, type=int, help="of 1/24 s")
    parser.add_argument("--limit", default=300.0, type=float, help="seconds of processor time for a run")
    parser.add_argument("--work", default="build/peers", type=pathlib.Path)
    parser.add_argument("--csv", default="build/peers.csv", type=pathlib.Path)
    parser.add_argument("--table", type=pathlib.Path)
    parser.add_argument("--fill", type=pathlib.Path)
    options = parser.parse_args(arguments)
    options.tulle = str(options.tulle.resolve())
    options.work = options.work.resolve()
    return options


def main(arguments):
    options = parse(arguments)
    if options.table:
        table.show(options.table, options.fill)
        return
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})  # all runs, this one too, on one processor
    rows = []
    for scene in options.scenes:
        run_scene(options, scene, rows, lambda: write_rows(options.csv, rows))
    table.show(options.csv, None)


if __name__ == "__main__":
    main(sys.argv[1:])
