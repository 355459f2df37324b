"""Under what something was measured: the build, the number of threads and the processor, as a short name of all three.

conditions.csv tells what each name stands for, made/RUN.csv under which ones a run was made. Times of different
conditions are not compared. The build is a hash of the program and of paper_measure: any change of them or of how they
were compiled is another build.
"""
from __future__ import annotations

import hashlib
from pathlib import Path

from reproduce.kept import Kept
from reproduce.session import Exit, Failure, Session

BUILD_DIGITS, NAME_DIGITS = 16, 8  # hexadecimal
MADE_HEAD = "conditions\n"


def get_processor() -> str:
    """As the system names it, without commas: the name is a cell of a table."""
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines():
            key, _, value = line.partition(":")
            if key.strip() == "model name":
                return value.strip().replace(",", ";")
    except OSError:
        pass
    return "not known"


def hash_programs(*programs: Path) -> str:
    """A hash of the bytes of the files."""
    digest = hashlib.sha256()
    for program in programs:
        try:
            digest.update(program.read_bytes())
        except OSError as error:
            raise Failure(Exit.BAD_INPUT,
                          f"{program} cannot be read: {error.strerror}; `make paper` builds it") from error
    return digest.hexdigest()[:BUILD_DIGITS]


def note_conditions(session: Session) -> None:
    """Sets the session's build and conditions and writes down what the latter stands for."""
    session.build = hash_programs(session.program, session.measure)
    session.build_facts = session.find_build_facts()
    row = f"{session.build},{session.used_threads},{get_processor()}"
    session.conditions = hashlib.sha256(row.encode()).hexdigest()[:NAME_DIGITS]
    table = Kept(session.path("conditions.csv"), "conditions,build,threads,processor\n", 1)
    if table.find(session.conditions) is None:
        table.add(f"{session.conditions},{row}")
    table.save()


def open_made(session: Session, name: str) -> Kept:
    """The conditions that the run was made under."""
    return Kept(session.path(f"made/{name}.csv"), MADE_HEAD, 1)


def note_run(session: Session, name: str, goes_on: bool) -> None:
    """Writes down that the run begins or goes on under the session's conditions."""
    made = open_made(session, name)
    if not goes_on:
        made.forget()
    elif not made.rows:
        made.add("unknown")
    if made.find(session.conditions) is None:
        made.add(session.conditions)
    made.save()


def read_conditions(session: Session, name: str) -> str:
    """The conditions of all steps of the run; "mixed" or "unknown"."""
    rows = open_made(session, name).rows
    return "unknown" if not rows else rows[0] if len(rows) == 1 else "mixed"
