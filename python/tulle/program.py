"""What the program `tulle` does, from Python: whole runs, pictures, verdicts on files, conversions, fits.

Each call starts the program, which comes with the package. So a run survives what happens to the interpreter, can be
interrupted and resumed, and is the same to the bit as one from the command line. Ctrl-C ends the program as it does there:
after a checkpoint; a second one ends it at once.
"""
from __future__ import annotations

import json
import os
import signal
import struct
import subprocess
import tempfile
import threading
import zlib
from collections.abc import Callable, Sequence
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import NDArray

from tulle import _find_program
from tulle.errors import ParseError, ProgramError
from tulle.mesh import PathLike
from tulle.run import Run, RunWriter
from tulle.scene import Overrides, format_overrides
from tulle.world import World

Progress = Callable[[dict[str, Any]], None]


def find_program() -> str:
    """The path of the program: that of the environment variable TULLE, of the package, of its build directory, or on PATH."""
    try:
        return str(_find_program.find_program())
    except FileNotFoundError as failure:
        raise ProgramError(str(failure)) from None


def run_program(*arguments: Union[str, PathLike], on_line: Optional[Callable[[str], None]] = None,
                accepts: Sequence[int] = (0,)) -> str:
    """Runs `tulle ARGUMENTS` and gives what it prints. `on_line` gets each line of its standard error as it comes.

    Raises ProgramError with its last lines where the exit code is none of `accepts`, and KeyboardInterrupt after Ctrl-C.
    """
    command = [find_program(), *(os.fspath(each) for each in arguments)]
    # In a group of its own, the program gets Ctrl-C from here alone, and once.
    child = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                             errors="replace", start_new_session=True)
    printed: list[str] = []
    told: list[str] = []
    failure: list[BaseException] = []

    def listen() -> None:
        assert child.stderr is not None
        for line in child.stderr:
            line = line.rstrip("\n")
            told.append(line)
            del told[:-50]
            if on_line is not None and not failure:
                try:
                    on_line(line)
                except BaseException as problem:  # noqa: B902 - it is raised below, by the thread that called
                    failure.append(problem)
                    child.send_signal(signal.SIGINT)

    def read() -> None:
        assert child.stdout is not None
        printed.append(child.stdout.read())

    threads = [threading.Thread(target=each, daemon=True) for each in (listen, read)]
    for thread in threads:
        thread.start()
    is_interrupted = False
    while True:
        try:
            code = child.wait()
            for thread in threads:
                thread.join()
            break
        except KeyboardInterrupt:
            is_interrupted = True
            child.send_signal(signal.SIGINT)
        except BaseException:
            child.kill()
            child.wait()
            raise
    if failure:
        raise failure[0]
    if is_interrupted:
        raise KeyboardInterrupt
    if code not in accepts:
        words = [line for line in told if not line.startswith("{")][-10:]
        raise ProgramError("\n".join(words) or f"tulle {arguments[0]} ended with the exit code {code}", code)
    return "".join(printed)


class _Bar:
    """A progress bar of tqdm, where that is installed; else nothing is shown."""

    def __init__(self) -> None:
        self._bar: Any = None

    def show(self, event: dict[str, Any]) -> None:
        """Shows an event of `--progress json`."""
        if event["event"] == "begin":
            try:
                from tqdm.auto import tqdm
            except ImportError:
                return
            self._bar = tqdm(total=event["steps"], initial=event["step"], unit="step")
        elif event["event"] == "step" and self._bar is not None:
            self._bar.update(event["step"] - self._bar.n)
            self._bar.set_postfix(frame=f"{event['frame']}/{event['frames']}", contacts=event["contacts"], refresh=False)

    def close(self) -> None:
        """Leaves the bar as it is."""
        if self._bar is not None:
            self._bar.close()


def simulate(scene: PathLike, output: PathLike, *, frames: Optional[int] = None, threads: int = 0, resume: bool = False,
             force: bool = False, overrides: Overrides = (), record: str = "plain", writes_vtp: bool = False,
             checkpoint_every: Optional[str] = None, progress: Union[bool, Progress] = True) -> Run:
    """Simulates a scene file into the directory `output`, as `tulle run` does, and opens the run.

    resume: goes on from the last checkpoint, or starts where there is none. force: replaces a run that is there.
    threads: 0: one per processor; the states do not depend on it. writes_vtp: each frame also as VTP files.
    overrides: other values for keys of the scene, as {"time.frames": 10}. record: "debug" keeps contacts too.
    checkpoint_every: "100" steps or "30s". progress: a bar where tqdm is there, or a function that gets each event of
    `--progress json` as a dictionary. Ctrl-C stops at a checkpoint and raises KeyboardInterrupt; `resume` goes on from it.
    Raises ProgramError with the exit code of the program: 2 for a scene that is wrong, 3 where the run could not go on.
    """
    arguments: list[Union[str, PathLike]] = ["run", scene, "-o", output, "--progress", "json", "--record", record]
    arguments += ["-n", str(frames)] if frames is not None else []
    arguments += ["-t", str(threads)] if threads else []
    arguments += ["--resume"] if resume else []
    arguments += ["--force"] if force else []
    arguments += ["--write", "vtp"] if writes_vtp else []
    arguments += ["--checkpoint-every", checkpoint_every] if checkpoint_every else []
    for text in format_overrides(overrides):
        arguments += ["--set", text]
    bar = _Bar()
    show = progress if callable(progress) else bar.show if progress else None

    def take(line: str) -> None:
        if show is not None and line.startswith("{"):
            show(json.loads(line))

    try:
        run_program(*arguments, on_line=take)
    finally:
        bar.close()
    return Run(output)


def check_files(*paths: PathLike, obstacles: Sequence[PathLike] = (), threads: int = 0) -> list[dict[str, Any]]:
    """Judges mesh files and every frame of runs by exact arithmetic, as `tulle check --json` does: a dictionary for each
    frame or file. threads: 0: one per processor. Raises ProgramError for what cannot be judged."""
    arguments: list[Union[str, PathLike]] = ["check", *paths, "--json", "-t", str(threads)]
    for path in obstacles:
        arguments += ["--obstacle", path]
    return [json.loads(line) for line in run_program(*arguments, accepts=(0, 1)).splitlines()]


def detect_files(start: PathLike, end: PathLike, *options: str) -> dict[str, Any]:
    """What collides while a surface moves from one mesh file to another, as `tulle detect --json` tells it.

    options: further options of it, one by one, as "--thickness", "1mm".
    """
    return json.loads(run_program("detect", start, end, "--json", *options))  # type: ignore[no-any-return]


def convert(source: PathLike, output: PathLike, *options: str) -> str:
    """Meshes, point caches and runs from one format to another, as `tulle convert SOURCE OUTPUT` does; its last words.

    options: further options of it, one by one, as "--up", "y".
    """
    return run_program("convert", source, output, *options)


def render(source: Union[PathLike, Run, World], *, frame: Optional[int] = None, size: tuple[int, int] = (640, 360),
           samples: int = 32, options: Sequence[str] = ()) -> NDArray[np.uint8]:
    """A ray traced picture of a run's frame, or of a world as it is: (height, width, 3), sRGB, 0 .. 255.

    size: width and height in pixels. samples: rays for each pixel. options: further options of `tulle render`, as
    ["--camera", "orbit=30deg,20deg"].
    """
    with tempfile.TemporaryDirectory(prefix="tulle-") as directory:
        if isinstance(source, World):
            path: PathLike = os.path.join(directory, "run")
            with RunWriter(path, source, 1.0):
                pass
        else:
            path = source.path if isinstance(source, Run) else source
            if frame is not None and frame < 0:
                frame += Run(path).frame_count
        picture = os.path.join(directory, "picture.png")
        run_program("render", path, "-o", picture, "--size", f"{size[0]}x{size[1]}", "--samples", str(samples),
                    "--progress", "none", *([] if frame is None else ["--frame", str(frame)]), *options)
        return read_png(picture)


def read_png(path: PathLike) -> NDArray[np.uint8]:
    """The pixels of a PNG file of 8 bits without a palette and not interlaced: (height, width, channels)."""
    with open(path, "rb") as file:
        data = file.read()
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        raise ParseError("this is no PNG file", os.fspath(path))
    header: tuple[int, ...] = ()
    pixels, place = b"", 8
    while place + 12 <= len(data):
        length, kind = struct.unpack_from(">I4s", data, place)
        body = data[place + 8:place + 8 + length]
        if kind == b"IHDR":
            header = struct.unpack(">IIBBBBB", body)
        elif kind == b"IDAT":
            pixels += body
        place += 12 + length
    if not header or header[2] != 8 or header[3] not in (0, 2, 4, 6) or header[6]:
        raise ParseError("this kind of PNG file is not read", os.fspath(path))
    width, height, channels = header[0], header[1], {0: 1, 2: 3, 4: 2, 6: 4}[header[3]]
    rows = np.frombuffer(zlib.decompress(pixels), np.uint8).reshape(height, 1 + width * channels)
    out = np.zeros((height + 1, width + 1, channels), np.uint8)  # a row and a column of zeros around
    for y in range(height):
        _undo_filter(int(rows[y, 0]), rows[y, 1:].reshape(width, channels), out[y], out[y + 1])
    return out[1:, 1:]


def _undo_filter(kind: int, row: NDArray[np.uint8], above: NDArray[np.uint8], out: NDArray[np.uint8]) -> None:
    """Undoes the filter of a row of a PNG file. `above` and `out` begin with a pixel of zeros."""
    if kind == 0:
        out[1:] = row
    elif kind == 1:
        out[1:] = np.cumsum(row, axis=0, dtype=np.uint8)
    elif kind == 2:
        out[1:] = row + above[1:]
    else:
        for c in range(row.shape[1]):
            values, up, left, corner = row[:, c].tolist(), above[:, c].tolist(), 0, 0
            line = []
            for x, value in enumerate(values, 1):
                if kind == 3:
                    guess = (left + up[x]) // 2
                else:  # Paeth's: the neighbour that is nearest to left + above - corner
                    corner = up[x - 1]
                    a, b, d = abs(up[x] - corner), abs(left - corner), abs(left + up[x] - 2 * corner)
                    guess = left if a <= b and a <= d else up[x] if b <= d else corner
                left = (value + guess) & 255
                line.append(left)
            out[1:, c] = line
