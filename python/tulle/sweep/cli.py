"""The command line of `python -m tulle.sweep`."""
from __future__ import annotations

import argparse
import os
import signal
import sys
import time
from pathlib import Path
from typing import Any, Optional

from . import dask_cluster, local, slurm
from .collect import collect, count_states, make_table
from .definition import SlurmOptions, Sweep, add_to_slurm, read_sweep
from .execute import Failed, Stop, execute
from .layout import SweepDirectory, is_whole, locked
from .plan import plan_sweep, remove_run
from .problems import EXIT_BAD_INPUT, EXIT_FAILED_RUNS, EXIT_FINE, EXIT_INTERRUPTED, SweepError
from .program import find_program
from .progress import Progress, describe_failure

USAGE = """python -m tulle.sweep SWEEP.yaml [options]    runs the sweep, or continues it
       python -m tulle.sweep status DIR              how far it is, and what failed
       python -m tulle.sweep collect DIR             table, arrays and page from what is there"""
TAIL = """exit codes: 0 all runs are whole, 1 a run failed or stopped, or intersections were found, 2 bad usage or a bad file, 130
interrupted: the runs under way have stopped at a checkpoint, and the same command continues"""
STATES_BEGUN = ("running", "silent")
STATES_UNDER_WAY = ("whole", "waiting", "interrupted", *STATES_BEGUN)  # of a sweep that may yet become whole


def make_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="tulle.sweep", usage=USAGE, epilog=TAIL, allow_abbrev=False,
                                     formatter_class=argparse.RawDescriptionHelpFormatter,
                                     description="Runs a scene with other values over and over, and collects the results.")
    parser.add_argument("file", metavar="SWEEP.yaml", help="what to run; its keys: docs/guide/sweeps.md")
    parser.add_argument("-o", "--output", metavar="DIR", 
                        help="directory of the sweep (default: output in the file, or SWEEP.sweep here)")
    parser.add_argument("--engine", choices=("local", "slurm", "dask"), help="where to run (default: local)")
    parser.add_argument("-j", "--jobs", type=read_count, metavar="N",
                        help="runs at a time on this machine (default: processors / threads)")
    parser.add_argument("--scheduler", metavar="ADDRESS",
                        help="of a Dask cluster (default: workers on this machine)")
    parser.add_argument("--sbatch", metavar="NAME=VALUE", action="append", default=[],
                        help="Slurm: an option of sbatch without its --; may be given again")
    parser.add_argument("--setup", metavar="LINE", action="append", default=[],
                        help="Slurm: a line of shell before each run, as 'module load python'; may be given again")
    parser.add_argument("--detach", action="store_true", help="Slurm: return when the jobs are in the queue")
    parser.add_argument("--retry-failed", action="store_true", help="repeat failed runs")
    parser.add_argument("--replace", action="store_true", help="remove runs of the directory that the sweep no longer has")
    parser.add_argument("--dry-run", action="store_true", help="print the runs, and make nothing")
    parser.add_argument("--program", metavar="TULLE",
                        help="the program tulle (default: $TULLE, in the package, in the checkout, on PATH)")
    return parser


def read_count(text: str) -> int:
    if not text.isascii() or not text.isdigit() or not 1 <= int(text) <= 4096:
        raise argparse.ArgumentTypeError(f'"{text}" should be a whole number from 1 to 4096')
    return int(text)


def main(arguments: list[str]) -> int:
    """Returns the exit code."""
    try:
        if arguments and arguments[0] in COMMANDS:
            return COMMANDS[arguments[0]](arguments[1:])
        return run_sweep(make_parser().parse_args(arguments))
    except (SweepError, Failed) as error:
        print(f"tulle.sweep: {error}", file=sys.stderr)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    except OSError as error:
        print(f"tulle.sweep: {error.filename or ''}: {error.strerror or error}", file=sys.stderr)
    return EXIT_BAD_INPUT


def catch_signals(stop: Stop) -> None:
    """Ctrl-C, SIGTERM and a terminal that closes ask to stop; under nohup the last one does not."""
    for one in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        if one == signal.SIGHUP and signal.getsignal(one) == signal.SIG_IGN:
            continue
        signal.signal(one, lambda number, frame: stop.ask("the sweep was interrupted"))


# ---- a sweep ----

def choose_engine(options: argparse.Namespace, sweep: Sweep) -> str:
    if options.engine:
        engine = options.engine
    else:
        engine = "dask" if options.scheduler else "local"
    if sweep.slurm and not options.engine:
        print(f"{sweep.file}: has options for Slurm, and the runs are {'on Dask' if options.scheduler else 'on this machine'}; "
              "--engine slurm submits them there", file=sys.stderr)
    if options.scheduler and engine != "dask":
        raise SweepError("--scheduler is for --engine dask")
    if options.detach and engine != "slurm":
        raise SweepError("--detach is for --engine slurm")
    if (options.sbatch or options.setup) and engine != "slurm":
        raise SweepError("--sbatch and --setup are for --engine slurm")
    return engine


def run_sweep(options: argparse.Namespace) -> int:
    """Plans the sweep, runs what is not whole, collects."""
    sweep = read_sweep(Path(options.file))
    engine = choose_engine(options, sweep)
    of_slurm = add_to_slurm(sweep.slurm or SlurmOptions(), options.sbatch, options.setup)
    directory = SweepDirectory(Path(options.output) if options.output else sweep.output or Path(Path(options.file).stem + ".sweep"))
    if sweep.drawn_again:
        print(f"{sweep.drawn_again} rows equal earlier ones and are left out", file=sys.stderr)
    if options.dry_run:
        for row in sweep.rows:
            print(", ".join(f"{p.name} {value.shown}" for p, value in zip(sweep.parameters, row)))
        print(f"{len(sweep.rows)} runs")
        return EXIT_FINE
    program = directory.program = find_program(options.program)
    if directory.sweep.exists():
        directory.read_sweep()  # refuses a file that is none of ours
    elif directory.path.is_dir() and any(p.name != "lock" for p in directory.path.iterdir()):
        raise SweepError(f"{directory.path}: is there and holds no sweep; give another folder by -o")
    directory.path.mkdir(parents=True, exist_ok=True)
    stop = Stop()
    catch_signals(stop)
    with locked(directory):
        queued = slurm.get_jobs_in_queue(directory)
        if queued:
            raise SweepError(f"{directory.path}: its Slurm jobs {', '.join(queued)} are in the queue; wait for them, or scancel them")
        directory.stop.unlink(missing_ok=True)
        records = plan_sweep(directory, sweep, program, options.replace)
        numbers = choose_runs(directory, records, options.retry_failed)
        progress = Progress(len(records), sum(r["state"] == "whole" for r in records))
        if numbers and not stop.level:
            start_engine(engine, options, sweep, of_slurm, directory, numbers, stop, progress)
        if options.detach and numbers:
            return EXIT_FINE
        progress.clear()
        directory.stop.unlink(missing_ok=True)
        return close_sweep(directory, stop, progress, ("whole",))


def choose_runs(directory: SweepDirectory, records: list[dict[str, Any]], is_retrying: bool) -> list[int]:
    """The numbers of the runs to execute: what is whole is left alone, and what failed but for --retry-failed."""
    numbers = []
    for record in records:
        if record["state"] == "failed" and is_retrying:
            prepare_retry(directory, record)
        elif record["state"] == "failed":
            continue
        elif record["state"] == "whole":
            if is_whole(directory, record):
                continue
            record["state"] = "waiting"
            directory.write_record(record)
        numbers.append(record["number"])
    return numbers


def prepare_retry(directory: SweepDirectory, record: dict[str, Any]) -> None:
    """A run that was killed or out of time continues from its checkpoint; one that failed by itself starts again."""
    if record.get("exit_code") in (0, 2, 3):
        remove_run(directory, record["number"])
    record.update(state="waiting", limit_used=0.0)
    directory.write_record(record)


def start_engine(engine: str, options: argparse.Namespace, sweep: Sweep, of_slurm: SlurmOptions, directory: SweepDirectory,
                 numbers: list[int], stop: Stop, progress: Progress) -> None:
    """Runs the numbers where they are to run."""
    jobs = options.jobs or max(1, len(os.sched_getaffinity(0)) // sweep.threads)
    if engine == "local":
        local.run_local(directory, numbers, jobs, stop, progress.report)
    elif engine == "dask":
        dask_cluster.run_dask(directory, numbers, options.scheduler, jobs, stop, progress.report)
    else:
        submitted = slurm.submit(directory, numbers, of_slurm, sweep.threads)
        progress.say(f"submitted: {len(numbers)} runs as Slurm jobs {', '.join(submitted)}; scripts are in {directory.slurm}")
        if not options.detach:
            slurm.watch(directory, submitted, stop, progress.report)


def close_sweep(directory: SweepDirectory, stop: Stop, progress: Progress, accepted: tuple[str, ...]) -> int:
    """Collects, says how it went, and gives the exit code."""
    was_stopped = bool(stop.level)
    collecting = Stop()
    catch_signals(collecting)
    if was_stopped:
        collecting.level = 1  # what is missing is made the next time; table and page are written
    notes = collect(directory, collecting)
    for note in notes:
        progress.say(note)
    _, rows, _ = make_table(directory)
    counts = count_states(rows)
    print(describe_counts(directory, counts, len(rows)))
    if was_stopped or collecting.level:
        print("interrupted; the same command continues", file=sys.stderr)
        return EXIT_INTERRUPTED
    return get_exit_code(counts, accepted)


def get_exit_code(counts: dict[str, int], accepted: tuple[str, ...]) -> int:
    """0 where all runs are in accepted states, and none has intersections."""
    is_fine = not any(count for state, count in counts.items() if state not in accepted)
    return EXIT_FINE if is_fine else EXIT_FAILED_RUNS


def describe_counts(directory: SweepDirectory, counts: dict[str, int], total: int) -> str:
    parts = [f"{counts.get('whole', 0)} of {total} runs whole"]
    parts += [f"{count} {state}" for state, count in counts.items() if state not in ("whole", "intersecting") and count]
    if counts["intersecting"]:
        parts.append(f"{counts['intersecting']} with intersections")
    return f"{directory.path}: " + ", ".join(parts)


# ---- the other commands ----

def find_directory(text: str) -> SweepDirectory:
    """The directory that is named, or that of the sweep file that is named."""
    path = Path(text)
    if path.is_file():
        output = read_sweep(path).output
        path = output or Path(path.stem + ".sweep")
    directory = SweepDirectory(path)
    directory.read_sweep()
    return directory


def parse_directory(name: str, about: str, arguments: list[str], calls_program: bool = False) -> SweepDirectory:
    parser = argparse.ArgumentParser(prog=f"tulle.sweep {name}", description=about)
    parser.add_argument("directory", metavar="DIR", help="directory of the sweep, or its SWEEP.yaml")
    if calls_program:
        parser.add_argument("--program", metavar="TULLE",
                            help="the program tulle (default: $TULLE, in the package, in the checkout, on PATH)")
    options = parser.parse_args(arguments)
    directory = find_directory(options.directory)
    if calls_program:
        directory.program = find_program(options.program)
    return directory


def tell_status(arguments: list[str]) -> int:
    """Counts, what runs, what failed and why."""
    directory = parse_directory("status", "Tells how far a sweep is, what runs, and what failed and why.", arguments)
    records = directory.read_records()
    rows = [{"state": r["seen_state"], "verdict": r.get("verdict")} for r in records]
    counts = count_states(rows)
    print(describe_counts(directory, counts, len(records)))
    now = time.time()
    for record in records:
        state = record["seen_state"]
        if state in STATES_BEGUN:
            sign = now - directory.get_record(record["number"]).stat().st_mtime
            place = " ".join(filter(None, [f"process {record['pid']}", record.get("place")]))
            print(f"run {record['number']:04d}: {state} on {record['host']}, {place}; "
                  f"last sign of life {sign:.0f} s ago")
        elif state == "failed":
            print(describe_failure(record))
        elif state == "interrupted" and record.get("reason"):
            print(f"run {record['number']:04d}: interrupted: {record['reason']}")
        elif state == "lost":
            reason = "its run directory is gone or another one" if record["state"] == "whole" else f"its process {record['pid']} ended"
            print(f"run {record['number']:04d}: lost: {reason}; the same command as before continues it")
    queued = slurm.get_jobs_in_queue(directory)
    if queued:
        print(f"in Slurm's queue: jobs {', '.join(queued)}")
    return get_exit_code(counts, STATES_UNDER_WAY)


def collect_again(arguments: list[str]) -> int:
    """Table, arrays and page from what is there."""
    directory = parse_directory("collect", "Makes table, arrays and page from the runs that are there.", arguments, True)
    stop = Stop()
    catch_signals(stop)
    return close_sweep(directory, stop, Progress(0, 0), STATES_UNDER_WAY)


def execute_one(arguments: list[str]) -> int:
    """One run, as a task of a cluster: `execute DIR TULLE NUMBER`."""
    if len(arguments) != 3 or not arguments[2].isdigit():
        raise SweepError("execute needs DIR, TULLE and NUMBER; clusters call it")
    directory = SweepDirectory(Path(arguments[0]))
    directory.program = find_program(arguments[1])
    stop = Stop(parent=os.getppid())
    catch_signals(stop)
    is_ending: list[bool] = []

    def note_time(number: int, frame: Optional[Any]) -> None:
        is_ending.append(True)
        stop.ask("the time of its task was over; it continues when it is queued again")

    signal.signal(signal.SIGUSR1, note_time)
    job = os.environ.get("SLURM_ARRAY_JOB_ID")
    place = f"task {job}_{os.environ.get('SLURM_ARRAY_TASK_ID')}" if job else ""
    record = execute(directory, int(arguments[2]), stop, place)
    print(f"run {record['number']:04d}: {record['state']}", record.get("reason", ""), flush=True)
    if record["state"] == "interrupted":
        if is_ending and slurm.requeue():
            time.sleep(slurm.SETTLE)  # Slurm ends this process
        return EXIT_INTERRUPTED
    return EXIT_FINE if record["state"] == "whole" else EXIT_FAILED_RUNS


COMMANDS = {"status": tell_status, "collect": collect_again, "execute": execute_one}
