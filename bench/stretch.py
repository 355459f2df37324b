#!/usr/bin/env python3
"""How far cloth is stretched in whole scenes: the same scene with springs and with woven cloth, every frame judged.

    python3 bench/stretch.py [SCENE.yaml ...]          all of scenes/ without names; hours

Prints a table in Markdown, a line for each scene; seconds are of the processor, on one thread. Runs are kept below --out; what
was cut short by --limit or Ctrl-C goes on when it is called again. A scene whose meshes are not there is passed over.
"""
import argparse
import csv
import json
import pathlib
import resource
import signal
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
MEMBRANES = ("springs", "woven")
HEADING = ("scene", "frames of", "stretch [%]: springs", "woven", "at [s]: springs", "woven", "steps over the limit",
           "steps cut: springs", "woven", "intersections", "s a step: springs", "woven")


def measure_children():
    """Processor time [s] of the programs that have ended: unlike time by the wall clock it hardly depends on other work."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def run_scene(options, scene, membrane, directory):
    """Runs until the end or the limit; returns whether there is a step."""
    command = [options.tulle, "run", scene, "-o", directory, "--threads", "1", "--progress", "none", "--resume",
               "--set", f"membrane={membrane}"]
    for value in options.set:
        command += ["--set", value]
    before = measure_children()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    try:
        code = process.wait(options.limit or None)
    except (subprocess.TimeoutExpired, KeyboardInterrupt) as stop:
        process.send_signal(signal.SIGINT)  # it writes a checkpoint and ends
        code = process.wait()
        if isinstance(stop, KeyboardInterrupt):
            raise
    with open(directory.with_suffix(directory.suffix + ".seconds"), "a") as file:
        print(measure_children() - before, file=file)
    there = code in (0, 3, 130) and (directory / "report.csv").read_text().count("\n") > 1
    if not there:
        print(f"{scene.stem}, {membrane}: passed over, see above", file=sys.stderr)
    return there


def judge(options, directory):
    """Pairs of triangles that intersect, over all frames."""
    answer = subprocess.run([options.tulle, "check", directory, "--threads", "1", "--json"], capture_output=True, text=True)
    if answer.returncode not in (0, 1):
        sys.exit(f"{directory} cannot be judged: {answer.stderr}")
    return json.loads(answer.stdout.splitlines()[-1])["intersections"]


def read_run(options, directory):
    with open(directory / "report.csv", newline="") as file:
        steps = list(csv.DictReader(file))
    about = json.loads((directory / "run.json").read_text())
    seconds = [float(line) for line in directory.with_suffix(directory.suffix + ".seconds").read_text().split()]
    with open(directory / "frames.csv") as file:
        frames = sum(1 for _ in file) - 2  # heading, start
    stretch = [float(step["max_stretch"]) for step in steps]
    largest = max(range(len(steps)), key=stretch.__getitem__)
    return {
        "frames": frames,
        "wanted": about["wanted_frames"],
        "stretch": 100.0 * (stretch[largest] - 1.0),
        "time": float(steps[largest]["time"]),
        "over": sum(int(step["overstretched"]) > 0 for step in steps),
        "cut": sum(int(step["substeps"]) > 1 for step in steps),
        "seconds": sum(seconds) / len(steps),
        "intersections": judge(options, directory),
    }


def make_row(name, springs, woven):
    both = f"{springs['frames']}, {woven['frames']}" if springs["frames"] != woven["frames"] else str(woven["frames"])
    return (f"`{name}`", f"{both} of {woven['wanted']}", f"{springs['stretch']:.1f}", f"{woven['stretch']:.1f}",
            f"{springs['time']:.2f}", f"{woven['time']:.2f}", woven["over"], springs["cut"], woven["cut"],
            springs["intersections"] + woven["intersections"], f"{springs['seconds']:.3f}", f"{woven['seconds']:.3f}")


def print_row(cells):
    print("| " + " | ".join(str(cell) for cell in cells) + " |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", type=pathlib.Path)
    parser.add_argument("--tulle", default=ROOT / "build/release/tulle", type=pathlib.Path)
    parser.add_argument("--out", default=ROOT / "out/stretch", type=pathlib.Path)
    parser.add_argument("--limit", default=0.0, type=float, help="seconds for each of the two runs; 0: to the end")
    parser.add_argument("--report", action="store_true", help="runs nothing, tells of the runs that are there")
    parser.add_argument("--set", action="append", default=[], metavar="PATH=VALUE", help="another value in every scene")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    print_row(HEADING)
    print_row("|".join("---" for _ in HEADING).split("|"))
    for scene in options.scenes or sorted((ROOT / "scenes").glob("*.yaml")):
        found = {}
        for membrane in MEMBRANES:
            directory = options.out / f"{scene.stem}.{membrane}"
            if options.report or run_scene(options, scene, membrane, directory):
                found[membrane] = read_run(options, directory)
        if len(found) == len(MEMBRANES):
            print_row(make_row(scene.stem, **found))


if __name__ == "__main__":
    main()
