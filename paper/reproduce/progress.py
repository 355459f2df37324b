"""How far the driver is, on standard error: bars on a terminal, elsewhere lines of JSON."""
from __future__ import annotations

import json
import sys
import time

BAR_WIDTH = 24  # [characters]
BAR_INTERVAL = 0.1  # [s] between two pictures of a bar: calm, yet alive
LINE_INTERVAL = 5.0  # [s] between two lines of JSON: a log stays readable


def format_duration(seconds: float) -> str:
    """"1:02:03", "2:03"."""
    total = round(seconds)
    hours, minutes, rest = total // 3600, total // 60 % 60, total % 60
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"


class Progress:
    """Jobs are runs that are made and judged; work is a part of the session with a known number of pieces."""

    def __init__(self) -> None:
        self.is_terminal = sys.stderr.isatty()
        self.job = self.job_count = 0
        self.work = self.work_done = 0.0  # of all jobs, see runs.weigh
        self.jobs_begin = time.monotonic()  # [s]
        self._begin = self._told = self._drawn = 0.0  # [s] of the work; of the last line, of the last picture
        self._skipped = 0  # pieces of the work that were there already
        self._is_drawn = False

    def begin_jobs(self, count: int, work: float) -> None:
        """Work: what all jobs cost together, in any unit."""
        self.job_count, self.work, self.work_done = count, work, 0.0
        self.jobs_begin = time.monotonic()

    def _estimate_jobs(self) -> float | None:
        """[s] that the jobs still take, this one too; None where nothing tells it yet."""
        left = self.work - self.work_done
        if left <= 0.0:
            return 0.0
        if self.work_done <= 0.0:
            return None
        return (time.monotonic() - self.jobs_begin) / self.work_done * left

    def show_job(self, name: str, what: str) -> None:
        """A job begins."""
        rest = self._estimate_jobs()
        if self.is_terminal:
            text = f"[{self.job}/{self.job_count}] {name}: {what}"
            if rest:
                text += f"; all runs in about {format_duration(rest)}"
            self.tell(text)
        else:
            self.tell(json.dumps({"event": "job", "job": self.job, "jobs": self.job_count, "run": name, "what": what,
                                  "rest_seconds": None if rest is None else round(rest, 1)}, separators=(",", ":")))

    def begin_work(self) -> None:
        """The pieces that follow belong to one work."""
        self._begin = self._told = time.monotonic()
        self._skipped = 0
        self._is_drawn = False

    def skip_work(self, count: int = 1) -> None:
        """Pieces of the work were there: the time left is that of the others."""
        self._skipped += count

    def show_work(self, name: str, done: int, count: int) -> None:
        """How many pieces are done."""
        made, left = done - self._skipped, count - done
        rest = (time.monotonic() - self._begin) / made * left if made > 0 else 0.0
        if self.is_terminal:
            self.draw(done, count, f"{name}  {done} of {count}  rest {format_duration(rest)}")
        elif time.monotonic() - self._told >= LINE_INTERVAL:
            self.tell(json.dumps({"event": "work", "work": name, "done": done, "count": count,
                                  "rest_seconds": round(rest, 1)}, separators=(",", ":")))
            self._told = time.monotonic()

    def end_work(self) -> None:
        """Ends the line of a bar."""
        if self._is_drawn:
            print(file=sys.stderr, flush=True)
        self._is_drawn = False

    def draw(self, done: int, count: int, text: str) -> None:
        """A bar with a text, drawn over the one before."""
        now = time.monotonic()
        if not self.is_terminal or (done < count and self._is_drawn and now - self._drawn < BAR_INTERVAL):
            return
        filled = BAR_WIDTH * done // count if 0 < done < count else BAR_WIDTH if done >= count else 0
        print(f"\r[{'#' * filled}{'.' * (BAR_WIDTH - filled)}] {text}\033[K", end="", file=sys.stderr, flush=True)
        self._is_drawn, self._drawn = True, now

    def tell(self, line: str) -> None:
        """A line of its own."""
        if self._is_drawn:
            print("\r\033[K", end="", file=sys.stderr)
        self._is_drawn = False
        print(line, file=sys.stderr, flush=True)
