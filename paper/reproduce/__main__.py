"""The command line: which figures, where, how large; see `--help` and lab/paper.md."""
from __future__ import annotations

import argparse
import difflib
import errno
import os
import re
import sys
from collections.abc import Callable
from pathlib import Path

from reproduce import counterexamples, fig6, fig7, stills, table1
from reproduce.children import Interrupts
from reproduce.conditions import note_conditions
from reproduce.figures import FIGURES, Figure, add_runs
from reproduce.judge import judge, write_runs
from reproduce.progress import Progress
from reproduce.report import write_report
from reproduce.runs import has_reports, has_scene, make_run, open_moving_run, weigh
from reproduce.scenes import Run
from reproduce.session import Exit, Failure, Session, say

REPOSITORY = Path(__file__).resolve().parents[2]
THREADS_MAX = 256
SIDE_MAX, PIXELS_MAX = 16384, 1 << 26  # of a still, as `tulle render` takes it

MAKERS: dict[str, Callable[[Session, Figure], None]] = {
    "fig6": fig6.make, "fig7": fig7.make, "table1": table1.make, "fig8": stills.make_stills,
    "fig9": stills.make_stills, "counterexamples": counterexamples.make}
DIRECTORIES = ("", "runs", "made", "judged", "measured", "stills")


def read_threads(text: str) -> int:
    """The value of --threads."""
    if not text.isdecimal() or not 1 <= int(text) <= THREADS_MAX:
        raise argparse.ArgumentTypeError(f"\"{text}\" should be a whole number from 1 to {THREADS_MAX}")
    return int(text)


def read_size(text: str) -> str:
    """The value of --size."""
    match = re.fullmatch(r"([0-9]{1,6})x([0-9]{1,6})", text)
    if not match:
        raise argparse.ArgumentTypeError(f"\"{text}\" should be WIDTHxHEIGHT in pixels, as 640x360")
    width, height = int(match[1]), int(match[2])
    if not (1 <= width <= SIDE_MAX and 1 <= height <= SIDE_MAX and width * height <= PIXELS_MAX):
        raise argparse.ArgumentTypeError(f"\"{text}\": each side should be 1 to {SIDE_MAX} pixels, and both together "
                                         f"{PIXELS_MAX // 1_000_000} million at most")
    return f"{width}x{height}"


def read_figure(text: str) -> str:
    """A name of a figure, or `all`."""
    names = ["all", *MAKERS]
    if text in names:
        return text
    nearest = difflib.get_close_matches(text, names, 1)
    hint = f"; did you mean \"{nearest[0]}\"?" if nearest else f"; there are {', '.join(names)}"
    raise argparse.ArgumentTypeError(f"there is no figure \"{text}\"{hint}")


def read_words(words: list[str]) -> argparse.Namespace:
    """The command line; ends the program with 2 where it is wrong."""
    parser = argparse.ArgumentParser(
        prog="reproduce", formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Makes the experiments of Wong and Baciu (2005) again: fig6, fig7, table1, fig8, fig9,\n"
                    "counterexamples, or all of them. Runs the scenes, judges every frame, and writes\n"
                    "tables (CSV), plots (SVG), stills and report.html. Runs that are whole are not made\n"
                    "again, others go on where they were cut short: Ctrl-C (130) keeps what there is.",
        epilog="Exit codes: 0 fine; 2 bad usage or input, or with all else made: a scene, matplotlib,\n"
               "Embree or the report of a run is missing; 3 a run could not go on, or a file could not\n"
               "be written; 4 out of memory; 130 interrupted.")
    parser.add_argument("figures", metavar="FIGURE", nargs="+", type=read_figure, help="what to make")
    parser.add_argument("-o", "--output", metavar="DIR", type=Path,
                        help="where the results go (default: reproduced, with --quick reproduced-quick)")
    parser.add_argument("--quick", action="store_true",
                        help="coarse cloth and short runs: minutes in place of hours")
    parser.add_argument("--scenes", metavar="DIR", type=Path, default=REPOSITORY / "scenes" / "paper",
                        help="where the paper's scenes are (default: scenes/paper)")
    parser.add_argument("--size", metavar="WxH", type=read_size,
                        help="pixels of stills (default: 640x400, with --quick 320x200)")
    parser.add_argument("-t", "--threads", metavar="N", type=read_threads,
                        help="threads; only times depend on it (default: one per processor)")
    parser.add_argument("--tulle", metavar="FILE", type=Path, default=REPOSITORY / "build" / "release" / "tulle",
                        help="the program (default: build/release/tulle)")
    parser.add_argument("--measure", metavar="FILE", type=Path,
                        help="the program that asks the detector (default: paper/paper_measure beside tulle)")
    return parser.parse_args(words)


def make_session(words: argparse.Namespace) -> Session:
    """The session that the words ask for."""
    measure = words.measure or words.tulle.parent / "paper" / "paper_measure"
    return Session(directory=words.output or Path("reproduced-quick" if words.quick else "reproduced"),
                   scenes=words.scenes, program=words.tulle.resolve(), measure=measure.resolve(), is_quick=words.quick,
                   still_size=words.size or ("320x200" if words.quick else "640x400"), threads=words.threads,
                   interrupts=Interrupts(), progress=Progress())


def make_directories(session: Session) -> None:
    """Makes the directories, or finds them and that files can be made in them."""
    if not session.scenes.is_dir():
        raise Failure(Exit.BAD_INPUT, f"--scenes: {session.scenes} is no directory")
    for name in DIRECTORIES:
        path = session.path(name)
        try:
            if not path.exists():
                path.mkdir()
            elif not path.is_dir():
                raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR))
            elif not os.access(path, os.W_OK | os.X_OK):
                raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        except OSError as error:
            code = Exit.CANNOT_GO_ON if error.errno == errno.ENOSPC else Exit.BAD_INPUT
            raise Failure(code, f"-o: {path} cannot be made or written to: {error.strerror}") from error


def leave_out_missing(session: Session, runs: list[Run]) -> list[Run]:
    """The runs whose scenes are there; says which are not."""
    kept = []
    for run in runs:
        if has_scene(session, run):
            kept.append(run)
        else:
            session.lack(f"{session.scenes}/{run.scene}.yaml is missing; what needs it is left out")
    return kept


def make_runs(session: Session, runs: list[Run]) -> int:
    """Makes and judges the runs. One that could not go on is judged up to there, and the rest is made. A scene that
    cannot be read is found before any is made. Exit.FINE or Exit.CANNOT_GO_ON."""
    work = {run: weigh(session, run) for run in runs}
    session.progress.begin_jobs(len(runs), sum(work.values()))
    worst = Exit.FINE
    for job, run in enumerate(runs, start=1):
        session.progress.job = job
        code = make_run(session, run)
        if code == Exit.CANNOT_GO_ON:
            worst = Exit.CANNOT_GO_ON
        session.progress.work_done += work[run]
        if code not in (Exit.FINE, Exit.CANNOT_GO_ON):
            session.stop_if_interrupted()
            raise Failure(code)
        session.stop_if_interrupted()
        if open_moving_run(session, run):
            judge(session, run)
            session.is_lacking |= not has_reports(session, run)
    return worst


def make(session: Session, names: list[str]) -> int:
    """Makes the figures and the report; the exit code."""
    figures = [figure for figure in FIGURES if figure.name in names or "all" in names]
    runs: list[Run] = []
    for figure in figures:
        add_runs(figure, runs)
    worst = make_runs(session, leave_out_missing(session, runs))
    write_runs(session)
    for figure in figures:
        session.stop_if_interrupted()
        MAKERS[figure.name](session, figure)
    write_report(session)
    print(f"report: {session.directory}/report.html", flush=True)
    return Exit.BAD_INPUT if worst == Exit.FINE and session.is_lacking else worst


def main(words: list[str]) -> int:
    """The exit code."""
    arguments = read_words(words)
    session = make_session(arguments)
    session.interrupts.catch()
    try:
        make_directories(session)
        note_conditions(session)
        return make(session, arguments.figures)
    except Failure as failure:
        if failure.message:
            say(failure.message)
        return failure.code
    except MemoryError:
        say("out of memory")
        return Exit.OUT_OF_MEMORY


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
