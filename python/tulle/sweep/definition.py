"""What a sweep file says: SWEEP.yaml read, checked and with every default filled in."""
from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Optional, Union

from .document import Entry, read_document, resolve
from .problems import SweepError
from .values import Parameter, Value, list_rows, read_parameter

KEYS = ("scene", "title", "parameters", "count", "seed", "frames", "threads", "output", "collect", "limits", "slurm")
RUNS_DEFAULT, RUNS_MAX = 1000, 100_000
SEED_MAX = (1 << 53) - 1
THREADS_MAX = 256      # as of `tulle run`
FRAMES_MAX = 10_000_000
NAME = re.compile(r"[^\W\d][\w .-]{0,59}")

# The columns of the table beside the parameters.
OWN_COLUMNS = ("run", "state", "verdict", "exit_code", "frames", "steps", "state_hash", "largest_stretch",
               "largest_stretch_time", "unconverged_steps", "worst_residual", "cut_steps", "rescues", "pinched_steps",
               "overstretched_steps", "largest_lag", "wall_seconds", "attempts", "tulle_version", "scene_hash", "reason")


@dataclass(frozen=True)
class Limits:
    """When a run is given up: time [s] of all its attempts (None: never), tries after the first one; most runs."""

    time: Optional[float] = None
    retries: int = 0
    runs: int = RUNS_DEFAULT


@dataclass(frozen=True)
class Collect:
    """Which arrays are kept: of the cloths named ("all", or none), at which frames ("last", "all" or numbers)."""

    positions: Union[str, list[str]] = "all"
    frames: Union[str, list[int]] = "last"


@dataclass(frozen=True)
class SlurmOptions:
    """How the array job is submitted; `options` go to sbatch as they are."""

    options: dict[str, Any] = field(default_factory=dict)
    throttle: Optional[int] = None    # most tasks at a time
    stop_before: int = 60             # [s] before the time limit at which a run stops
    array_size: int = 1000            # most tasks of an array; Slurm's MaxArraySize less one
    setup: tuple[str, ...] = ()       # lines of shell before a run; of the command line


@dataclass
class Sweep:
    """A sweep file, checked."""

    file: Path
    scene: Path
    title: str
    parameters: list[Parameter]
    rows: list[list[Value]]
    frames: Optional[int]
    threads: int
    output: Optional[Path]
    collect: Collect
    limits: Limits
    slurm: Optional[SlurmOptions]
    drawn_again: int  # rows left out since they equal earlier ones


def read_sweep(path: Path) -> Sweep:
    """Reads and checks a sweep file."""
    root = read_document(path)
    if "dask" in root.get_map():
        raise root.get_map()["dask"].make_problem("where runs happen comes from the command line alone: --engine dask, and --scheduler ADDRESS "
                                                  "for a cluster that is there")
    keys = root.get_map(KEYS)
    for needed in ("scene", "parameters"):
        if needed not in keys:
            raise root.make_problem(f"the key {needed} is missing")
    limits = read_limits(keys["limits"]) if "limits" in keys else Limits()
    parameters = read_parameters(keys["parameters"])
    count = keys["count"].get_whole(1, RUNS_MAX) if "count" in keys else None
    if count is not None and not any(p.kind == "random" for p in parameters):
        raise keys["count"].make_problem("counts draws of random values, and no parameter has such")
    seed = keys["seed"].get_whole(0, SEED_MAX) if "seed" in keys else 1
    rows = list_rows(parameters, seed, count, limits.runs)
    return Sweep(
        file=path.resolve(), scene=keys["scene"].get_file(), parameters=parameters, rows=rows, limits=limits,
        title=keys["title"].get_text() if "title" in keys else path.stem,
        frames=keys["frames"].get_whole(1, FRAMES_MAX) if "frames" in keys else None,
        threads=keys["threads"].get_whole(1, THREADS_MAX) if "threads" in keys else 1,
        output=resolve(path, keys["output"].get_text()) if "output" in keys else None,
        collect=read_collect(keys["collect"]) if "collect" in keys else Collect(),
        slurm=read_slurm(keys["slurm"]) if "slurm" in keys else None,
        drawn_again=count_rows(parameters, count) - len(rows))


def count_rows(parameters: list[Parameter], count: Optional[int]) -> int:
    """The rows with those that are equal."""
    total, seen_list = 1, False
    for one in parameters:
        if one.kind == "grid":
            total *= len(one.values)
        elif one.kind == "list" and not seen_list:
            total, seen_list = total * len(one.values), True
    return total * (count or 1)


def read_parameters(entry: Entry) -> list[Parameter]:
    """Reads the map of parameters; names must differ from the table's own columns, paths from one another."""
    parameters: list[Parameter] = []
    taken: dict[str, str] = {}
    for name, one in entry.get_map().items():
        if not NAME.fullmatch(name):
            raise one.make_problem("a name for the table has letters, digits, blanks and _ . - and begins with a letter")
        if name in OWN_COLUMNS:
            raise one.make_problem("the table has a column of this name already; take another one")
        parameter = read_parameter(name, one)
        for path in parameter.paths:
            if path in taken:
                raise one.make_problem(f"{path} is set by {taken[path]} already")
            taken[path] = name
        parameters.append(parameter)
    if not parameters:
        raise entry.make_problem("names no parameter")
    return parameters


def read_limits(entry: Entry) -> Limits:
    keys = entry.get_map(("time", "retries", "runs"))
    return Limits(time=keys["time"].get_seconds() if "time" in keys else None,
                  retries=keys["retries"].get_whole(0, 100) if "retries" in keys else 0,
                  runs=keys["runs"].get_whole(1, RUNS_MAX) if "runs" in keys else RUNS_DEFAULT)


def read_collect(entry: Entry) -> Collect:
    keys = entry.get_map(("positions", "frames"))
    positions: Union[str, list[str]] = "all"
    frames: Union[str, list[int]] = "last"
    if "positions" in keys:
        one = keys["positions"]
        if one.is_list():
            positions = [name.get_text() for name in one.get_list()]
        elif one.get_text() not in ("all", "none"):
            raise one.make_problem("should be all, none, or a list of cloths as [shirt]")
        elif one.get_text() == "none":
            positions = []
    if "frames" in keys:
        one = keys["frames"]
        if one.is_list():
            frames = [frame.get_whole(0, FRAMES_MAX) for frame in one.get_list()]
            if not frames or sorted(set(frames)) != frames:
                raise one.make_problem("should be numbers of frames that grow, as [0, 10, 20]")
        elif one.get_text() not in ("last", "all"):
            raise one.make_problem("should be last, all, or a list of frames as [0, 10, 20]")
        else:
            frames = one.get_text()
    return Collect(positions, frames)


RESERVED_BY_US = ("array", "requeue", "no-requeue", "open-mode", "signal", "output", "error", "wrap", "cpus-per-task",
                  "chdir", "parsable", "wait", "dependency")


# Options of sbatch that a file may give: what a job needs and how it waits. Others make a job run programs, load code, hand on the
# environment, or write elsewhere; they come from the command line.
OF_FILES = ("account", "begin", "comment", "constraint", "contiguous", "core-spec", "deadline", "exclude", "exclusive", "gpus",
            "gpus-per-task", "gres", "hint", "hold", "job-name", "licenses", "mem", "mem-per-cpu", "mem-per-gpu", "nice", "nodelist",
            "oversubscribe", "partition", "prefer", "priority", "qos", "reservation", "spread-job", "switches", "thread-spec",
            "threads-per-core", "time", "time-min", "tmp", "wckey")


def add_to_slurm(slurm: SlurmOptions, options: list[str], setup: list[str]) -> SlurmOptions:
    """Adds options of sbatch, each NAME or NAME=VALUE, and lines of shell, both from the command line."""
    merged = dict(slurm.options)
    for option in options:
        name, has_value, value = option.partition("=")
        if name in RESERVED_BY_US or not re.fullmatch(r"[a-z][a-z0-9-]+", name):
            raise SweepError(f'--sbatch "{option}": is set by the sweep itself, or no long option of sbatch without its --')
        merged[name] = value if has_value else True
    return replace(slurm, options=merged, setup=tuple(setup))


def read_slurm(entry: Entry) -> SlurmOptions:
    """Own keys have an underscore or one word of ours; all others are options of sbatch."""
    options: dict[str, Any] = {}
    own: dict[str, Any] = {}
    for name, one in entry.get_map().items():
        if name == "throttle":
            own[name] = one.get_whole(1, RUNS_MAX)
        elif name == "stop_before":
            own[name] = int(min(65535, max(1, one.get_seconds())))
        elif name == "array_size":
            own[name] = one.get_whole(1, 4_000_000)
        elif name == "setup":
            raise one.make_problem('lines of shell come from the command line alone: --setup "module load python"')
        elif name in RESERVED_BY_US:
            raise one.make_problem("is set by the sweep itself" +
                                   ("; threads says how many" if name == "cpus-per-task" else ""))
        elif not re.fullmatch(r"[a-z][a-z0-9-]+", name):
            raise one.make_problem("is neither a long option of sbatch without its --, as mem-per-cpu, nor one of "
                                   "throttle, stop_before, array_size")
        elif name not in OF_FILES:
            raise one.make_problem(f"is no option that a file may give to sbatch; if you want it: --sbatch {name}=VALUE on the command "
                                   "line")
        elif one.node.tag.endswith(":bool"):
            if one.get_truth():
                options[name] = True
        elif re.search(r'["\\\n\r]', one.get_text()):
            raise one.make_problem("may not hold quotes, backslashes or line ends")
        else:
            options[name] = one.get_text()
    return SlurmOptions(options=options, **own)
