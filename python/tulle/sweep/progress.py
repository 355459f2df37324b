"""What people see of a sweep under way: a line that is written over on a terminal, a line for each run elsewhere."""
from __future__ import annotations

import sys
import time
from typing import Any, TextIO

from .execute import CLEAN

LINE_INTERVAL = 0.2  # [s] between two looks of the line on a terminal


class Progress:
    """Counts the runs that end and tells of them on standard error."""

    def __init__(self, total: int, whole: int, stream: TextIO = sys.stderr) -> None:
        self.total, self.at_start, self.stream = total, whole, stream
        self.whole, self.failed, self.stopped, self.intersecting = whole, 0, 0, 0
        self.began, self.next_line, self.width = time.monotonic(), 0.0, 0
        self.is_terminal = stream.isatty()

    def report(self, record: dict[str, Any]) -> None:
        """Takes note of a run that has ended. Failures are told wherever one looks."""
        state = record["state"]
        self.whole += state == "whole"
        self.failed += state == "failed"
        self.stopped += state not in ("whole", "failed")
        self.intersecting += state == "whole" and record.get("verdict") != CLEAN
        if state == "failed":
            self.say(describe_failure(record))
        elif not self.is_terminal or record.get("notes"):
            self.say(f"run {record['number']:04d}: {describe_end(record)}")
        if self.is_terminal and (time.monotonic() >= self.next_line or self.whole + self.failed == self.total):
            self.next_line = time.monotonic() + LINE_INTERVAL
            self.write_line(self.describe())

    def say(self, text: str) -> None:
        """Prints lines that stay."""
        self.clear()
        print(text, file=self.stream, flush=True)

    def describe(self) -> str:
        """The counts, and about how long it will take."""
        text = f"{self.whole} of {self.total} runs whole"
        if self.failed:
            text += f", {self.failed} failed"
        done = self.whole - self.at_start
        rest = self.total - self.whole - self.failed
        if rest and done:
            text += f", about {format_seconds((time.monotonic() - self.began) / done * rest)} left"
        return text

    def write_line(self, text: str) -> None:
        self.stream.write("\r" + text.ljust(self.width))
        self.stream.flush()
        self.width = len(text)

    def clear(self) -> None:
        """Takes the line away."""
        if self.width:
            self.stream.write("\r" + " " * self.width + "\r")
            self.width = 0


def describe_end(record: dict[str, Any]) -> str:
    text = record["state"]
    if text == "whole":
        text += f", {record.get('verdict')}, {record.get('wall_seconds', 0):.3g} s"
    elif record.get("reason"):
        text += f": {record['reason']}"
    return "; ".join([text, *record.get("notes", [])])


def describe_failure(record: dict[str, Any]) -> str:
    """A run that failed: its values, the reason, its last lines."""
    values = ", ".join(f"{name} {value}" for name, value in record.get("values", {}).items())
    reason = record.get("reason", "")
    lines = [line for line in record.get("last_lines", []) if reason not in line]
    return "\n".join([f"run {record['number']:04d}: failed: {reason} ({values})", *("    " + line for line in lines)])


def format_seconds(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"
