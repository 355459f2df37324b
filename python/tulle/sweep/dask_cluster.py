"""Runs on a Dask cluster: one that is there, by its scheduler's address, or workers on this machine.

A task calls this package as a process of its own. So the workers need Python, the folder of the sweep and this package
at the same paths as here, but nothing of it loaded. A worker that dies takes its runs along; Dask gives them to another
one, where they go on from their checkpoints."""
from __future__ import annotations

import signal
import subprocess
import time
from typing import Any, Optional

from .cluster import close_record, get_command
from .execute import Stop
from .layout import SweepDirectory
from .local import Report
from .problems import SweepError

POLL = 0.3             # [s] between two looks at what has ended
CONNECT_TIME = 10.0    # [s] to reach a scheduler
CLOSE_TIME = 10.0      # [s] for the workers to end
STOP_TIME = 3.0        # [s] for a task that was just starting to see that the sweep stops
NOT_BEGUN = "the sweep ended before it began"


def run_dask(directory: SweepDirectory, numbers: list[int], scheduler: Optional[str], jobs: int, stop: Stop, report: Report) -> None:
    """Executes the runs on the cluster. Returns when all have ended or stopped."""
    try:
        import distributed
    except ImportError:
        raise SweepError("Dask is not installed here: install python3-distributed, or run with --engine local") from None
    local = None
    try:
        if scheduler is None:
            local = start_workers(distributed, jobs)
        client = distributed.Client(local or scheduler, timeout=CONNECT_TIME, set_as_default=False)
    except (OSError, ValueError) as error:
        if local:
            local.close()
        raise SweepError(f"the Dask scheduler {scheduler or 'on this machine'} cannot be reached: {error}") from None
    try:
        submit_and_wait(directory, numbers, client, stop, report)
    finally:
        client.close(timeout=CLOSE_TIME)
        if local:
            local.close(timeout=CLOSE_TIME)


def start_workers(distributed: Any, jobs: int) -> Any:
    """Workers on this machine. Ctrl-C at a terminal reaches them as well; they leave it to us, so they can be closed
    in good order."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        return distributed.LocalCluster(n_workers=jobs, threads_per_worker=1, dashboard_address=None, silence_logs=50)
    finally:
        signal.signal(signal.SIGINT, before)


def submit_and_wait(directory: SweepDirectory, numbers: list[int], client: Any, stop: Stop, report: Report) -> None:
    """Hands the runs to the cluster. A wish to stop takes back what has not begun, and leaves a file for the rest."""
    command = get_command(directory)
    futures = {number: client.submit(subprocess.run, [*command, str(number)], stdin=subprocess.DEVNULL,
                                     capture_output=True, text=True, errors="replace", start_new_session=True,
                                     pure=False, retries=2)
               for number in numbers}
    stopped_at = 0.0
    while futures:
        if stop.level and not stopped_at:
            stopped_at = time.monotonic()
            directory.stop.touch()
            for number in [n for n in futures if (directory.read_record(n) or {}).get("state") != "running"]:
                futures[number].cancel()
        if stop.level > 1:
            break
        for number in [n for n, future in futures.items() if future.done()]:
            future = futures.pop(number)
            said, reason = describe_result(future)
            report(close_record(directory, number, stop.reason or reason, said))
        time.sleep(POLL)
    if stopped_at and stop.level == 1:
        # A task that was just starting has yet to see the file.
        time.sleep(max(0.0, stopped_at + STOP_TIME - time.monotonic()))
    for number in futures:
        report(close_record(directory, number, stop.reason or NOT_BEGUN, []))


def describe_result(future: Any) -> tuple[list[str], str]:
    """What a task printed last, and what to say where it left no result."""
    if future.cancelled():
        return [], NOT_BEGUN
    if future.status == "error":
        return [], f"its task was lost: {future.exception()}"
    done = future.result()
    return (done.stderr or "").splitlines()[-6:], f"its process ended with exit code {done.returncode}"
