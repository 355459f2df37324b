"""Sweep files: errors with their places, the rows, the random draws."""
from __future__ import annotations

import re
from pathlib import Path

import pytest

from sweep_tools import SCENE
from tulle.sweep.definition import read_sweep
from tulle.sweep.problems import SweepError

HEAD = "scene: scene.yaml\n"


def write(folder: Path, text: str) -> Path:
    (folder / "scene.yaml").write_text(SCENE)
    path = folder / "s.yaml"
    path.write_text(text)
    return path


def list_texts(folder: Path, text: str) -> list[tuple[str, ...]]:
    return [tuple(value.text for value in row) for row in read_sweep(write(folder, text)).rows]


P = "parameters:\n  a: "


@pytest.mark.parametrize("text, said", [
    ("", "is empty"),
    ("- a\n", "s.yaml:1:1: should be a map"),
    (HEAD, "s.yaml:1:1: the key parameters is missing"),
    ("parameters: {a: {path: b, grid: [1]}}\n", "the key scene is missing"),
    ("scene: none.yaml\n" + P + "{path: b, grid: [1]}", "s.yaml:1:8: scene: there is no file"),
    (HEAD + "colour: 1\n", "s.yaml:2:1: colour: unknown key; known here: scene"),
    (HEAD + "frames: 0\n" + P + "{path: b, grid: [1]}", "s.yaml:2:9: frames: should be a whole number from 1"),
    (HEAD + "frames: 1\nframes: 2\n", "s.yaml:3:1: frames: is there twice"),
    (HEAD + "parameters: {}\n", "s.yaml:2:13: parameters: names no parameter"),
    (HEAD + "parameters: [1]\n", "parameters: should be a map"),
    (HEAD + P + "{path: b, grid: [1]}\n  a: {path: c, grid: [1]}\n", "s.yaml:4:3: parameters.a: is there twice"),
    (HEAD + P + "{path: b, grid: [1]}\n  c: {path: b, grid: [1]}\n", "parameters.c: b is set by a already"),
    (HEAD + "parameters: {verdict: {path: b, grid: [1]}}\n", "the table has a column of this name"),
    (HEAD + "parameters: {'=1': {path: b, grid: [1]}}\n", "a name for the table"),
    (HEAD + P + "{grid: [1]}\n", "s.yaml:3:6: parameters.a: needs a path"),
    (HEAD + P + "{path: 'x=1', grid: [1]}\n", "is no path of a key"),
    (HEAD + P + "{path: b}\n", "needs exactly one of grid, list, random"),
    (HEAD + P + "{path: b, grid: [1], list: [2]}\n", "needs exactly one of grid, list, random"),
    (HEAD + P + "{path: b, grid: []}\n", "s.yaml:3:22: parameters.a.grid: has no values"),
    (HEAD + P + "{path: b, grid: 1}\n", "parameters.a.grid: should be a list"),
    (HEAD + P + "{path: b, grid: [1, 2, 1]}\n", "s.yaml:3:29: parameters.a.grid[2]: the value 1 is there twice"),
    (HEAD + P + "{path: x.file, grid: [none.obj]}\n", "s.yaml:3:28: parameters.a.grid[0]: there is no file"),
    (HEAD + P + "{path: x, grid: [{file: none.obj}]}\n", "parameters.a.grid[0].file: there is no file"),
    (HEAD + P + "{path: b, random: {uniform: [0, 1]}}\n", "random values need the key count"),
    (HEAD + "count: 2\n" + P + "{path: b, grid: [1]}\n", "s.yaml:2:8: count: counts draws"),
    (HEAD + "count: 2\n" + P + "{path: b, random: {uniform: [1, 0]}}\n", "the first end should be below the second"),
    (HEAD + "count: 2\n" + P + "{path: b, random: {uniform: [1 mm, 2 m]}}\n", "should have the same unit"),
    (HEAD + "count: 2\n" + P + "{path: b, random: {uniform: [1/90 s, 2 s]}}\n", "should be a number"),
    (HEAD + "count: 2\n" + P + "{path: b, random: {log-uniform: [0, 1]}}\n", "needs ends above 0"),
    (HEAD + "count: 2\n" + P + "{path: b, random: {normal: [0, 1]}}\n", "unknown key; known here: uniform, log-uniform, choice"),
    (HEAD + P + "{path: b, list: [1, 2]}\n  c: {path: d, list: [1]}\n", "parameters.c.list: has 1 values and parameters.a.list has 2"),
    (HEAD + "limits: {runs: 3}\n" + P + "{path: b, grid: [1, 2]}\n  c: {path: d, grid: [1, 2]}\n", "these are 4 runs, and limits.runs is 3"),
    (HEAD + "limits: {time: 3 years}\n" + P + "{path: b, grid: [1]}\n", "limits.time: should be a time"),
    (HEAD + "collect: {frames: [3, 1]}\n" + P + "{path: b, grid: [1]}\n", "collect.frames: should be numbers of frames that grow"),
    (HEAD + "collect: {positions: some}\n" + P + "{path: b, grid: [1]}\n", "collect.positions: should be all, none"),
    (HEAD + "slurm: {array: 1}\n" + P + "{path: b, grid: [1]}\n", "slurm.array: is set by the sweep itself"),
    (HEAD + "slurm: {time: 'a\"b'}\n" + P + "{path: b, grid: [1]}\n", "slurm.time: may not hold quotes"),
    (HEAD + "slurm: {Time: 1}\n" + P + "{path: b, grid: [1]}\n", "slurm.Time: is neither a long option"),
    (HEAD + "slurm: {setup: [date]}\n" + P + "{path: b, grid: [1]}\n", "slurm.setup: lines of shell come from the command line alone"),
    (HEAD + "slurm: {export: 'LD_PRELOAD=/tmp/a.so'}\n" + P + "{path: b, grid: [1]}\n", "slurm.export: is no option that a file may give"),
    (HEAD + "slurm: {container: /tmp/a}\n" + P + "{path: b, grid: [1]}\n", "slurm.container: is no option that a file may give"),
    (HEAD + "dask: {scheduler: 'tcp://a:1'}\n" + P + "{path: b, grid: [1]}\n", "s.yaml:2:7: dask: where runs happen comes from the command"),
    (HEAD + P + "&x {path: b, grid: [1]}\n", "anchors and aliases are refused"),
    (HEAD + P + "!!python/none {path: b}\n", "tags are refused"),
    (HEAD + P + "{path: b, grid: [1]\n", "s.yaml:4:1:"),
    (HEAD + "---\na: 1\n", "s.yaml:2:1: but found another document"),
    ("x: " + "[" * 40 + "]" * 40, "nested more than 32 deep"),
])
def test_errors_have_places(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(SweepError) as error:
        read_sweep(write(tmp_path, text))
    assert said in str(error.value) and str(tmp_path) in str(error.value)


def test_rows(tmp_path: Path) -> None:
    text = HEAD + """
parameters:
  a: {path: x.a, grid: [1, 2]}
  b: {path: x.b, list: [p, q]}
  c: {path: x.c, list: ["p q", "r: s"]}
  d: {path: x.d, grid: [[1, "a, b"], {k: 2 mm}]}
"""
    rows = list_texts(tmp_path, text)
    assert len(rows) == 8
    assert rows[0] == ("1", "p", '"p q"', '[1, "a, b"]') and rows[1] == ("1", "q", '"r: s"', '[1, "a, b"]')
    assert rows[2] == ("1", "p", '"p q"', "{k: 2 mm}") and rows[-1] == ("2", "q", '"r: s"', "{k: 2 mm}")


def test_files_are_made_absolute(tmp_path: Path) -> None:
    for name in ("m.obj", "f_01.obj", "f_02.obj"):
        (tmp_path / name).write_text("v 0 0 0\n")
    sweep = read_sweep(write(tmp_path, HEAD + """
parameters:
  mesh: {path: "cloth[0].mesh", grid: [{file: m.obj}, {shape: rectangle}]}
  walk: {path: "obstacles[0].sequence.files", grid: [f_%02d.obj]}
  none: {path: "cloth[0].thickness", grid: [null]}
"""))
    first = sweep.rows[0]
    assert first[0].text == f'{{file: "{tmp_path}/m.obj"}}' and first[0].shown == "{file: m.obj}"
    assert first[1].files == (tmp_path / "f_01.obj", tmp_path / "f_02.obj") and first[1].shown == "f_%02d.obj"
    assert first[2].text == "" and first[2].shown == "(default)"
    assert sweep.rows[1][0].text == "{shape: rectangle}"


def test_random_values_follow_seed_and_name_alone(tmp_path: Path) -> None:
    text = HEAD + "count: 500\nseed: 7\n" + """parameters:
  a: {path: x.a, random: {uniform: [1 mm, 3 mm]}}
  b: {path: x.b, random: {log-uniform: [0.001, 1000]}}
  c: {path: x.c, random: {choice: [cotton, silk]}}
"""
    rows = list_texts(tmp_path, text)
    assert rows == list_texts(tmp_path, text) and len(rows) == 500
    a = [float(re.fullmatch(r"(\S+) mm", row[0]).group(1)) for row in rows]
    b = [float(row[1]) for row in rows]
    assert 1 <= min(a) < 1.05 and 2.95 < max(a) <= 3 and abs(sum(a) / 500 - 2) < 0.1
    assert 0.001 <= min(b) and max(b) <= 1000 and abs(sum(x < 1 for x in b) - 250) < 60
    assert abs(sum(row[2] == "silk" for row in rows) - 250) < 60
    assert list_texts(tmp_path, text.replace("seed: 7", "seed: 8")) != rows
    # Another parameter does not change the draws of the others.
    fewer = list_texts(tmp_path, "\n".join(line for line in text.splitlines() if not line.startswith("  b")))
    assert [(row[0], row[2]) for row in rows] == fewer
    assert rows[0][0] == "2.946616118261375 mm"


def test_equal_draws_are_made_once(tmp_path: Path) -> None:
    sweep = read_sweep(write(tmp_path, HEAD + "count: 50\nparameters: {c: {path: x.c, random: {choice: [cotton, silk]}}}\n"))
    assert len(sweep.rows) == 2 and sweep.drawn_again == 48


def test_many_runs_are_refused_before_they_are_made(tmp_path: Path) -> None:
    values = ", ".join(map(str, range(1000)))
    lines = "".join(f"  p{i}: {{path: x.p{i}, grid: [{values}]}}\n" for i in range(6))
    with pytest.raises(SweepError, match="these are 10{18} runs"):
        read_sweep(write(tmp_path, HEAD + "parameters:\n" + lines))
