"""Which recorded frames are looked at, and the program that is asked about them."""
from __future__ import annotations

import subprocess
import sys
import tempfile
from types import TracebackType

from reproduce.recorded import RecordedRun
from reproduce.scenes import SceneFacts
from reproduce.session import Exit, Failure, Session


def choose_stride(frame_count: int, most: int) -> int:
    """Frames that are looked at: every stride-th from 1 on, so that there are at most `most`."""
    return 1 if frame_count <= most else (frame_count - 2) // most + 1


def choose_frames(frame_count: int, most: int) -> range:
    """The frames that are looked at, each with the motion from the one before it."""
    return range(1, frame_count, choose_stride(frame_count, most))


def describe(recorded: RecordedRun, facts: SceneFacts) -> str:
    """Which frames these are and the contact distance, on one line."""
    return f"{recorded.describe()} distance {facts.contact_distance!r}"


class Measure:
    """paper_measure at work on the frames of a run; it is started when it is asked first."""

    def __init__(self, session: Session, part: str, recorded: RecordedRun, facts: SceneFacts) -> None:
        self._session = session
        self._words = [str(session.measure), part, str(recorded.directory), repr(facts.contact_distance),
                       str(session.used_threads)]
        self._child: subprocess.Popen | None = None
        self._errors = tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace")

    def __enter__(self) -> Measure:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        if self._child is not None:
            if error is not None:
                self._child.kill()
            self._child.communicate()
            self._session.interrupts.finish(self._child)
        self._errors.close()

    def ask(self, lines: list[str]) -> None:
        """Sends lines, the answers to which read_row gives in their order."""
        self._session.stop_if_interrupted()
        if self._child is None:
            self._session.stop_if_rebuilt()
            self._child = self._session.interrupts.start(self._words, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                                         stderr=self._errors, text=True, encoding="utf-8")
        assert self._child.stdin is not None
        try:
            self._child.stdin.write("".join(line + "\n" for line in lines))
            self._child.stdin.flush()
        except BrokenPipeError:
            self._fail()

    def read_row(self) -> str:
        """The next row of the answers."""
        assert self._child is not None and self._child.stdout is not None
        row = self._child.stdout.readline()
        if not row.endswith("\n"):
            self._fail()
        return row[:-1]

    def _fail(self) -> None:
        """The program has ended before its answers were whole."""
        assert self._child is not None
        self._session.stop_if_interrupted()
        code = self._child.wait()
        self._errors.seek(0)
        print(self._errors.read(), end="", file=sys.stderr, flush=True)
        raise Failure(code if code > 0 else Exit.CANNOT_GO_ON, f"{self._words[0]} ended with {code}")
