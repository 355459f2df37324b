"""Programs that the driver starts. They end with it, however it ends, and an interrupt is theirs, too.

A child has a process group of its own, so that Ctrl-C in a terminal reaches the driver alone, which hands it on once:
`tulle run` then writes a checkpoint, a second signal would end it at once.
"""
from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from functools import partial
from types import FrameType

PR_SET_PDEATHSIG = 1  # of prctl(2): the signal that a child gets when its parent is gone


def _begin_child(driver: int) -> None:
    """In the child, before it becomes the program; driver: the process that started it."""
    os.setpgid(0, 0)
    libc = ctypes.CDLL(None)
    if hasattr(libc, "prctl"):
        libc.prctl(PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
        if os.getppid() != driver:  # which ended before the call
            os.kill(os.getpid(), signal.SIGKILL)


class Interrupts:
    """Notes SIGINT and SIGTERM, and hands them on to the child that works; a second one has its usual effect."""

    def __init__(self) -> None:
        self.are_pending = False
        self._child: subprocess.Popen | None = None
        self._signal = signal.SIGTERM  # what ends the child

    def catch(self) -> None:
        """Begins to note signals."""
        signal.signal(signal.SIGINT, self._note)
        signal.signal(signal.SIGTERM, self._note)

    def _note(self, number: int, frame: FrameType | None) -> None:
        signal.signal(number, signal.SIG_DFL)
        self.are_pending = True
        if self._child is not None and self._child.poll() is None:
            self._child.send_signal(self._signal)

    def start(self, words: Sequence[str], ending: signal.Signals = signal.SIGTERM, **streams) -> subprocess.Popen:
        """Starts a program that `ending` is sent to when an interrupt comes."""
        self._signal = ending
        child = subprocess.Popen(list(words), preexec_fn=partial(_begin_child, os.getpid()), **streams)
        self._child = child
        if self.are_pending:
            child.send_signal(ending)
        return child

    def finish(self, child: subprocess.Popen) -> int:
        """Waits for the child; its exit code."""
        code = child.wait()
        self._child = None
        return code


def call(interrupts: Interrupts, words: Sequence[str], take_line: Callable[[str], None] | None = None,
         ending: signal.Signals = signal.SIGTERM) -> tuple[int, str, str]:
    """Runs a program to its end: exit code, standard output, standard error.

    With take_line each line of standard output is handed over as it comes, and the output that is returned is empty.
    """
    with tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace") as errors:
        child = interrupts.start(words, ending, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=errors,
                                 text=True, encoding="utf-8", errors="replace")
        assert child.stdout is not None
        output = ""
        with child.stdout:
            if take_line:
                for line in child.stdout:
                    take_line(line)
            else:
                output = child.stdout.read()
        code = interrupts.finish(child)
        errors.seek(0)
        return code, output, errors.read()
