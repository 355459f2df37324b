"""Figs. 8 and 9 and the stills of Fig. 6: three pictures of each run, by `tulle render`."""
from __future__ import annotations

import struct
import sys
from pathlib import Path

from reproduce.children import call
from reproduce.figures import Figure
from reproduce.recorded import RecordedRun
from reproduce.runs import get_directory, open_run
from reproduce.scenes import SCENES, Run
from reproduce.session import Exit, Failure, Session

PNG_BEGIN = b"\x89PNG\r\n\x1a\n"
PNG_END = b"\0\0\0\0IEND\xae\x42\x60\x82"
PNG_SIZE_OFFSET, PNG_HEAD_SIZE = 16, 24  # [bytes] width and height stand in the first chunk
SAMPLES, SAMPLES_QUICK = 32, 8  # rays of a pixel


def choose_stills(recorded: RecordedRun, run: Run) -> list[int]:
    """Which frames are shown, ascending; none where there is no frame."""
    frames: list[int] = []
    count = len(recorded.frames)
    for place in SCENES[run.scene].places if count > 0 else ():
        least = frames[-1] + 1 if frames and frames[-1] + 1 < count else 0
        frames.append(max(int(place * (count - 1) + 0.5), least))
    return frames


def name_still(run: Run, frame: int) -> str:
    """The picture's name in the directory of the results."""
    return f"stills/{run.name}_{frame:04}.png"


def is_whole_picture(picture: bytes) -> bool:
    """Whether these are the bytes of a PNG from its head to its end."""
    return (len(picture) >= PNG_HEAD_SIZE + len(PNG_END) and picture.startswith(PNG_BEGIN)
            and picture.endswith(PNG_END))


def _is_fresh(session: Session, run: Run, picture: Path) -> bool:
    """Whether the picture is there, whole, of the size that is asked for and younger than the run's frames."""
    try:
        data = picture.read_bytes()
        is_younger = picture.stat().st_mtime >= (get_directory(session, run) / "frames.csv").stat().st_mtime
    except OSError:
        return False
    size = tuple(int(side) for side in session.still_size.split("x"))
    has_size = is_whole_picture(data) and struct.unpack_from(">II", data, PNG_SIZE_OFFSET) == size
    return is_younger and has_size


def _render(session: Session, run: Run, picture: Path, frame: int) -> bool:
    """Whether stills can be made at all."""
    samples = SAMPLES_QUICK if session.is_quick else SAMPLES
    words = [str(session.program), "render", str(get_directory(session, run)), "--frame", str(frame),
             "-o", str(picture), "--size", session.still_size, "--samples", str(samples), "--progress", "none"]
    if session.threads:
        words += ["--threads", str(session.threads)]
    code, _, errors = call(session.interrupts, words)
    session.stop_if_interrupted()
    if code == Exit.BAD_INPUT and "without Embree" in errors:
        session.lack("no stills are made: the program was built without Embree, the ray tracer (Debian's package is "
                     "libembree-dev)")
        return False
    if code != Exit.FINE:
        print(errors, end="", file=sys.stderr, flush=True)
        raise Failure(code if code > 0 else Exit.CANNOT_GO_ON)
    return True


def make_stills(session: Session, figure: Figure) -> None:
    """Stills of all runs that are there."""
    wanted = []
    for run in figure.runs:
        recorded = open_run(session, run)
        wanted += [(run, frame) for frame in (choose_stills(recorded, run) if recorded else [])]
    session.progress.begin_work()
    for done, (run, frame) in enumerate(wanted, start=1):
        session.stop_if_interrupted()
        picture = session.path(name_still(run, frame))
        if _is_fresh(session, run, picture):
            session.progress.skip_work()
        elif not _render(session, run, picture, frame):
            break
        session.progress.show_work("stills", done, len(wanted))
    session.progress.end_work()
