"""What the parts of a session share: where things are, what was asked for, messages and exit codes."""
from __future__ import annotations

import enum
import os
import sys
from dataclasses import dataclass, field
from pathlib import Path

from reproduce.children import Interrupts
from reproduce.progress import Progress
from reproduce.scenes import Run, SceneFacts


class Exit(enum.IntEnum):
    """Exit codes, those of the program `tulle`."""

    FINE = 0
    FALSE = 1  # of `tulle check`: something intersects
    BAD_INPUT = 2  # bad usage or input; also: something is missing, all else is made
    CANNOT_GO_ON = 3  # a run could not go on, or a file could not be written
    OUT_OF_MEMORY = 4
    INTERRUPTED = 130


class Failure(Exception):
    """Ends the session. `message` is empty where the reason is printed already."""

    def __init__(self, code: int, message: str = "") -> None:
        super().__init__(message)
        self.code = code
        self.message = message


class DamagedRun(Exception):
    """A run directory, or a file in it, that cannot be read."""


def say(message: str) -> None:
    """Prints a message to people on standard error."""
    print(f"reproduce: {message}", file=sys.stderr, flush=True)


@dataclass
class Session:
    """One call of the driver."""

    directory: Path  # of the results
    scenes: Path  # directory of the scene files
    program: Path  # `tulle`
    measure: Path  # `paper_measure`
    is_quick: bool
    still_size: str  # of stills, as --size of `tulle render` takes it
    threads: int | None  # None: one per processor
    interrupts: Interrupts
    progress: Progress
    build: str = ""  # hash of the programs
    build_facts: tuple = ()  # their sizes and times when they were hashed
    conditions: str = ""  # of build, threads and processor
    is_lacking: bool = False  # something that was asked for could not be made
    scene_facts: dict[Run, SceneFacts] = field(default_factory=dict)  # of the scenes that were asked for
    told: set[str] = field(default_factory=set)  # messages that are said once

    @property
    def used_threads(self) -> int:
        """Threads that are used: as asked for, or one per processor."""
        return self.threads or len(os.sched_getaffinity(0))

    def path(self, name: str) -> Path:
        """A file in the directory of the results."""
        return self.directory / name

    def lack(self, message: str) -> None:
        """Says once what is missing; the exit code tells it, too."""
        self.is_lacking = True
        if message not in self.told:
            say(message)
        self.told.add(message)

    def find_build_facts(self) -> tuple:
        """Sizes and times of the programs' files."""
        facts = [os.stat(program) for program in (self.program, self.measure)]
        return tuple((fact.st_size, fact.st_mtime_ns, fact.st_ino) for fact in facts)

    def stop_if_rebuilt(self) -> None:
        """Ends the session where the programs are others than at its begin: what they measure would be noted under the
        wrong build."""
        try:
            is_same = self.find_build_facts() == self.build_facts
        except OSError:
            is_same = False
        if not is_same:
            raise Failure(Exit.CANNOT_GO_ON, "the program was built anew meanwhile; the same command goes on with it")

    def stop_if_interrupted(self) -> None:
        """Ends the session after Ctrl-C or a request to end."""
        if self.interrupts.are_pending:
            raise Failure(Exit.INTERRUPTED, "interrupted; the same command goes on from here")


def write_whole(path: Path, content: str | bytes) -> None:
    """Writes a file that appears whole or not at all: under a temporary name beside it, flushed, renamed."""
    data = content.encode() if isinstance(content, str) else content
    temporary = path.with_name(f"{path.name}.{os.getpid()}.tmp")
    try:
        with open(temporary, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        raise Failure(Exit.CANNOT_GO_ON, f"{path} cannot be written: {error.strerror}") from error


def write_table(session: Session, name: str, lines: list[str]) -> None:
    """Writes a table, whose first line names its columns, to the directory of the results."""
    write_whole(session.path(name), "".join(line + "\n" for line in lines))
