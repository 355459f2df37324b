"""A YAML file whose values know where they stand, so that errors name file, line, column and key."""
from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Iterable, Optional

import yaml

from .problems import SweepError

FILE_BYTES_MAX = 4 << 20
DEPTH_MAX = 32
SECONDS_OF = {"": 1.0, "s": 1.0, "min": 60.0, "h": 3600.0, "d": 86400.0}
NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
TAG = "tag:yaml.org,2002:"


class Entry:
    """A value of the file: its node, and the key by which messages name it."""

    def __init__(self, file: Path, node: yaml.Node, key: str) -> None:
        self.file, self.node, self.key = file, node, key

    def make_problem(self, text: str) -> SweepError:
        """The error for this value, to be raised."""
        mark = self.node.start_mark
        key = f"{self.key}: " if self.key else ""
        return SweepError(f"{self.file}:{mark.line + 1}:{mark.column + 1}: {key}{text}")

    # ---- kinds ----

    def is_map(self) -> bool:
        return isinstance(self.node, yaml.MappingNode)

    def is_list(self) -> bool:
        return isinstance(self.node, yaml.SequenceNode)

    def is_null(self) -> bool:
        return self.node.tag == TAG + "null"

    # ---- values ----

    def get_map(self, known: Optional[Iterable[str]] = None) -> dict[str, Entry]:
        """The entries of a map; refuses keys twice and, with `known`, keys that are not among these."""
        if not self.is_map():
            raise self.make_problem("should be a map of keys and values")
        names = None if known is None else list(known)
        entries: dict[str, Entry] = {}
        for key_node, node in self.node.value:
            at_key = Entry(self.file, key_node, self.key)
            if not isinstance(key_node, yaml.ScalarNode):
                raise at_key.make_problem("a key should be a word")
            name = key_node.value
            at_key.key = f"{self.key}.{name}" if self.key else name
            if names is not None and name not in names:
                raise at_key.make_problem("unknown key; known here: " + ", ".join(names))
            if name in entries:
                raise at_key.make_problem("is there twice")
            entries[name] = Entry(self.file, node, at_key.key)
        return entries

    def get_list(self) -> list[Entry]:
        if not self.is_list():
            raise self.make_problem("should be a list, as [1, 2, 3]")
        return [Entry(self.file, node, f"{self.key}[{i}]") for i, node in enumerate(self.node.value)]

    def get_text(self) -> str:
        if not isinstance(self.node, yaml.ScalarNode) or self.is_null() or not self.node.value:
            raise self.make_problem("should be a text")
        return self.node.value

    def get_truth(self) -> bool:
        if self.node.tag != TAG + "bool":
            raise self.make_problem("should be true or false")
        return self.node.value.lower() in ("true", "yes", "on")

    def get_number(self) -> float:
        text = self.node.value if isinstance(self.node, yaml.ScalarNode) else ""
        if not NUMBER.fullmatch(text) or not math.isfinite(float(text)):
            raise self.make_problem("should be a number")
        return float(text)

    def get_whole(self, lowest: int, highest: int) -> int:
        text = self.node.value if isinstance(self.node, yaml.ScalarNode) else ""
        if not re.fullmatch(r"[-+]?\d+", text) or not lowest <= int(text) <= highest:
            raise self.make_problem(f"should be a whole number from {lowest} to {highest}")
        return int(text)

    def get_seconds(self) -> float:
        """A time above 0: a number of seconds, or one with s, min, h or d."""
        text = self.node.value if isinstance(self.node, yaml.ScalarNode) else ""
        number = NUMBER.match(text)
        factor = SECONDS_OF.get(text[number.end():].strip()) if number else None
        seconds = float(number.group()) * factor if number and factor else 0.0
        if not 0 < seconds < math.inf:
            raise self.make_problem("should be a time above 0, as 90 s, 10 min or 2 h")
        return seconds

    def get_file(self) -> Path:
        """The path of a file that is there; relative names start at the folder of this file."""
        path = resolve(self.file, self.get_text())
        if not path.is_file():
            raise self.make_problem(f"there is no file {path}")
        return path


def resolve(file: Path, name: str) -> Path:
    """The absolute path of what `file` calls `name`."""
    return Path(file.parent, Path(name).expanduser()).resolve()


def write_flow(node: yaml.Node, is_inner: bool = False) -> str:
    """The value of a node on one line, as --set takes it. Plain words and numbers stay as they were written."""
    if isinstance(node, yaml.SequenceNode):
        return "[" + ", ".join(write_flow(item, True) for item in node.value) + "]"
    if isinstance(node, yaml.MappingNode):
        return "{" + ", ".join(f"{write_flow(key, True)}: {write_flow(item, True)}" for key, item in node.value) + "}"
    is_plain = getattr(node, "style", None) is None and not (is_inner and re.search(r"[][{},]", node.value))
    return node.value if is_plain else json.dumps(node.value, ensure_ascii=False)


def read_document(path: Path) -> Entry:
    """The root of a YAML file. Refused are broken files, several documents, aliases, tags and deep nesting."""
    try:
        with open(path, "rb") as stream:
            data = stream.read(FILE_BYTES_MAX + 1)
    except OSError as error:
        raise SweepError(f"{path}: cannot be read: {error.strerror}") from None
    if len(data) > FILE_BYTES_MAX:
        raise SweepError(f"{path}: has more than {FILE_BYTES_MAX >> 20} MiB")
    try:
        text = data.decode("utf-8")
        check_events(path, text)
        node = yaml.compose(text, Loader=yaml.SafeLoader)
    except UnicodeDecodeError as error:
        raise SweepError(f"{path}: byte {error.start} is not UTF-8") from None
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        place = f"{mark.line + 1}:{mark.column + 1}: " if mark else ""
        raise SweepError(f"{path}:{place or ' '}{error.problem or error.context}") from None
    except yaml.YAMLError as error:
        raise SweepError(f"{path}: {' '.join(str(error).split())}") from None
    if node is None:
        raise SweepError(f"{path}: is empty")
    return Entry(path, node, "")


def check_events(path: Path, text: str) -> None:
    """Refuses what would make a document more than the tree that one sees."""
    depth = 0
    for event in yaml.parse(text, Loader=yaml.SafeLoader):
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        reason = ""
        if isinstance(event, yaml.AliasEvent) or getattr(event, "anchor", None):
            reason = "anchors and aliases are refused; write the value out"
        elif getattr(event, "tag", None):
            reason = "tags are refused"
        elif depth > DEPTH_MAX:
            reason = f"is nested more than {DEPTH_MAX} deep"
        if reason:
            mark = event.start_mark
            raise SweepError(f"{path}:{mark.line + 1}:{mark.column + 1}: {reason}")
