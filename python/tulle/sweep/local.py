"""Runs on this machine, some at a time. Each has a thread that waits for its programs."""
from __future__ import annotations

import concurrent.futures
from typing import Any, Callable

from .execute import Stop, execute
from .layout import SweepDirectory

POLL = 0.2  # [s] between two looks at what has ended, in which signals are handled

Report = Callable[[dict[str, Any]], None]  # is told the record of each run that has ended


def run_local(directory: SweepDirectory, numbers: list[int], jobs: int, stop: Stop, report: Report) -> None:
    """Executes the runs, at most `jobs` at a time, in their order. Returns when all have ended or stopped."""
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        waiting = iter(numbers)
        under_way: set[concurrent.futures.Future[dict[str, Any]]] = set()
        while True:
            while len(under_way) < jobs and not stop.level:
                number = next(waiting, None)
                if number is None:
                    break
                under_way.add(pool.submit(execute, directory, number, stop))
            if not under_way:
                return
            done, under_way = concurrent.futures.wait(under_way, POLL, concurrent.futures.FIRST_COMPLETED)
            for one in done:
                report(one.result())
