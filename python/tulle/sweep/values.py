"""The values of a parameter, and the rows of a sweep: all grids against each other, lists row by row, random draws.

A row takes a combination of the grids, then a row of the lists, then a random draw; the last one changes fastest. Each
random parameter has a generator of its own, seeded by the sweep's seed and its name: another parameter does not change
its draws."""
from __future__ import annotations

import itertools
import math
import random
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Optional

import yaml

from .document import NUMBER, Entry, resolve, write_flow
from .problems import SweepError

FILE_KEYS = ("file", "files", "cache")  # keys of a scene whose values are paths
DRAWS = ("uniform", "log-uniform", "choice")


@dataclass(frozen=True)
class Value:
    """A value: as --set takes it, as the table shows it, and the files that it names."""

    text: str
    shown: str
    files: tuple[Path, ...] = ()


@dataclass
class Parameter:
    """What is varied: a name for the table, keys of the scene, and one of the three kinds of values."""

    name: str
    paths: list[str]
    kind: str  # grid, list or random
    entry: Entry
    values: list[Value] = field(default_factory=list)  # of a grid, a list or a choice
    draw: str = ""
    ends: tuple[float, float] = (0.0, 0.0)
    unit: str = ""


def find_files(path: Path) -> list[Path]:
    """The files that a path of a scene names: one, or numbered ones where it has a part like %04d."""
    if not re.search(r"%0?\d*d", path.name):
        return [path] if path.is_file() else []
    pattern = re.compile(re.sub(r"%0?\d*d", r"\\d+", re.escape(path.name)))
    return sorted(one for one in path.parent.glob("*") if pattern.fullmatch(one.name)) if path.parent.is_dir() else []


def read_value(entry: Entry, paths: list[str]) -> Value:
    """Reads one value. Files are made absolute, since --set would look for them beside the scene."""
    if entry.is_null():
        return Value("", "(default)")
    files: list[Path] = []
    shown = write_flow(entry.node)
    if isinstance(entry.node, yaml.ScalarNode):
        if re.split(r"[.\]]", paths[0])[-1] in FILE_KEYS:
            entry = replace_file(entry, files)
        shown = entry.node.value if not files else shown.strip('"')
    else:
        entry = Entry(entry.file, replace_files(entry, files), entry.key)
    text = write_flow(entry.node)
    if "\n" in text or "\r" in text:
        raise entry.make_problem("should stand on one line")
    if not text:
        raise entry.make_problem("is empty; write null for the scene's default")
    return Value(text, shown, tuple(files))


def replace_file(entry: Entry, files: list[Path]) -> Entry:
    """The entry with an absolute path; notes the files, which must be there."""
    path = resolve(entry.file, entry.get_text())
    found = find_files(path)
    if not found:
        raise entry.make_problem(f"there is no file {path}")
    files += found
    node = yaml.ScalarNode(entry.node.tag, str(path), entry.node.start_mark, entry.node.end_mark, style='"')
    return Entry(entry.file, node, entry.key)


def replace_files(entry: Entry, files: list[Path]) -> yaml.Node:
    """The node of a list or map with absolute paths in place of all files that it names by their keys."""
    if entry.is_list():
        parts = [replace_files(one, files) for one in entry.get_list()]
        return yaml.SequenceNode(entry.node.tag, parts, entry.node.start_mark, entry.node.end_mark)
    if not entry.is_map():
        return entry.node
    pairs = []
    for (key_node, _), (name, one) in zip(entry.node.value, entry.get_map().items()):
        named = name in FILE_KEYS and isinstance(one.node, yaml.ScalarNode) and not one.is_null()
        pairs.append((key_node, replace_file(one, files).node if named else replace_files(one, files)))
    return yaml.MappingNode(entry.node.tag, pairs, entry.node.start_mark, entry.node.end_mark)


def read_values(entry: Entry, paths: list[str], may_repeat: bool) -> list[Value]:
    """The values of a list; refuses an empty one, and equal values where they would make equal runs."""
    entries = entry.get_list()
    if not entries:
        raise entry.make_problem("has no values")
    values: list[Value] = []
    for one in entries:
        value = read_value(one, paths)
        if not may_repeat and value in values:
            raise one.make_problem(f"the value {value.shown} is there twice")
        values.append(value)
    return values


def read_parameter(name: str, entry: Entry) -> Parameter:
    """Reads a parameter: its path or paths, and exactly one of grid, list and random."""
    keys = entry.get_map(("path", "grid", "list", "random"))
    if "path" not in keys:
        raise entry.make_problem("needs a path, a key of the scene as --set takes it")
    path = keys["path"]
    entries = path.get_list() if path.is_list() else [path]
    paths = [one.get_text() for one in entries]
    for one, text in zip(entries, paths):
        if not re.fullmatch(r"[A-Za-z_][\w.\[\]-]*", text):
            raise one.make_problem(f'"{text}" is no path of a key, as cloth[0].material.friction')
    if not paths:
        raise path.make_problem("has no path")
    kinds = [kind for kind in ("grid", "list", "random") if kind in keys]
    if len(kinds) != 1:
        raise entry.make_problem("needs exactly one of grid, list, random")
    parameter = Parameter(name, paths, kinds[0], keys[kinds[0]])
    if parameter.kind == "random":
        read_draw(parameter)
    else:
        parameter.values = read_values(parameter.entry, paths, may_repeat=parameter.kind == "list")
    return parameter


def read_draw(parameter: Parameter) -> None:
    """Reads what a random parameter is drawn from: {uniform: [LOW, HIGH]}, log-uniform alike, or {choice: [...]}."""
    entry = parameter.entry
    keys = entry.get_map(DRAWS)
    if len(keys) != 1:
        raise entry.make_problem("needs exactly one of " + ", ".join(DRAWS))
    (parameter.draw, source), = keys.items()
    if parameter.draw == "choice":
        parameter.values = read_values(source, parameter.paths, may_repeat=True)
        return
    ends = source.get_list()
    if len(ends) != 2:
        raise source.make_problem("should have two ends, as [0.1, 0.8]")
    read = []
    for end in ends:
        text = end.get_text()
        number = NUMBER.match(text)
        if not number or re.match(r"\s*[/\d]", text[number.end():]) or not math.isfinite(float(number.group())):
            raise end.make_problem("should be a number, with a unit or without one")
        read.append((float(number.group()), text[number.end():].strip()))
    (low, unit), (high, other) = read
    if unit != other:
        raise source.make_problem("both ends should have the same unit")
    if not low < high:
        raise source.make_problem("the first end should be below the second")
    if parameter.draw == "log-uniform" and low <= 0:
        raise source.make_problem("log-uniform needs ends above 0")
    parameter.ends, parameter.unit = (low, high), unit


def draw_values(parameter: Parameter, seed: int, count: int) -> list[Value]:
    """The draws of a random parameter."""
    generator = random.Random(f"{seed}/{parameter.name}")
    draws = []
    for _ in range(count):
        share = generator.random()
        if parameter.draw == "choice":
            draws.append(parameter.values[int(share * len(parameter.values))])
            continue
        low, high = parameter.ends
        if parameter.draw == "uniform":
            number = low + share * (high - low)
        else:
            number = math.exp(math.log(low) + share * (math.log(high) - math.log(low)))
        text = repr(min(max(number, low), high)) + (f" {parameter.unit}" if parameter.unit else "")
        draws.append(Value(text, text))
    return draws


def list_rows(parameters: list[Parameter], seed: int, count: Optional[int], most: int) -> list[list[Value]]:
    """The rows, each with a value for each parameter in their order; rows that equal an earlier one are left out.
    Refuses more than `most` before it makes them."""
    grids = [p for p in parameters if p.kind == "grid"]
    lists = [p for p in parameters if p.kind == "list"]
    randoms = [p for p in parameters if p.kind == "random"]
    for one in lists[1:]:
        if len(one.values) != len(lists[0].values):
            raise one.entry.make_problem(f"has {len(one.values)} values and {lists[0].entry.key} has "
                                         f"{len(lists[0].values)}; lists go together row by row")
    if randoms and count is None:
        raise randoms[0].entry.make_problem("random values need the key count beside parameters: how many draws")
    row_count = math.prod(len(p.values) for p in grids) * (len(lists[0].values) if lists else 1)
    row_count *= (count or 1) if randoms else 1
    if row_count > most:
        raise SweepError(f"{parameters[0].entry.file}: these are {row_count} runs, and limits.runs is {most}; "
                         "take fewer values, or set limits.runs higher")
    list_part = list(zip(*(p.values for p in lists))) if lists else [()]
    random_part = list(zip(*(draw_values(p, seed, count or 1) for p in randoms))) if randoms else [()]
    order = {p.name: i for i, p in enumerate(grids + lists + randoms)}
    rows: dict[tuple[Value, ...], None] = {}
    for parts in itertools.product(itertools.product(*(p.values for p in grids)), list_part, random_part):
        flat = [value for part in parts for value in part]
        rows[tuple(flat[order[p.name]] for p in parameters)] = None
    return [list(row) for row in rows]
