"""Reads the members of the structs of the headers, and what their comments say in a strict form.

The comment of a value that a caller gives begins with what holds for it, and goes on in words:

    double gust_time;        /* [s] 1e-6 .. 1e6, default 0.5: correlation time */
    const double *warps;     /* 3 * triangle_count, each -1 .. 1: directions of the warp; null: none */

[UNIT]                       of a number with a unit
LEAST .. MOST                both ends included; "> LEAST" leaves it out; "0 or LEAST .. MOST" takes 0, too; "up to MOST";
                             "finite"; "any": a number
N * COUNT, or COUNT:         of an array: its length, of which COUNT is a member of the struct or of its mesh; ", each" begins a range
default VALUE                where it is not 0, null or the first word of an enum; (VALUE, VALUE, VALUE) of a vector, of which one value stands for all

A comment of few words that ends with a colon, on a line of its own, heads a group of the members that follow.
"Since 1.2." in the words tells since which version a value is there; without, it is there since the first.
"""
from __future__ import annotations

import dataclasses
import math
import re
from pathlib import Path

NUMBER = r"-?(?:INFINITY|pi|[A-Z]+_\w+|\d[\d.]*(?:e[+-]?\d+)?)(?: / [\d.]+)?"
HEAD = re.compile(
    r"(?:\[(?P<unit>[^\]]+)\] ?)?"
    r"(?:(?:(?P<per>\d+) \* (?P<count>\w+)|(?P<items>\w+_count)(?=[,;:^]|$))(?:, each (?=[-\d>Iauf]))?)?"
    rf"(?P<range>any\b|finite\b|up to (?P<top>{NUMBER})|(?P<or_zero>0 or )?(?P<above>> )?(?P<least>{NUMBER}) \.\. (?P<most>{NUMBER}))?"
    rf"(?:,? ?default (?P<default>{NUMBER}|\([^)]*\))(?![\w(]))?")
GROUP = re.compile(r"^[a-z][^.;:]{0,39}:$")
FLAG = ("is_", "has_", "ignores_", "grows_", "keeps_", "skips_", "writes_", "records_")


@dataclasses.dataclass
class Member:
    """A member of a struct: its declaration, and what its comment says."""
    code: str     # double gravity[3]
    comment: str
    group: str
    head: re.Match[str] | None = None
    words: str = ""  # the comment behind its head

    def __post_init__(self) -> None:
        self.head = HEAD.match(self.comment)
        self.words = re.sub(r"^[:;.,]? *", "", self.comment[self.head.end():]) if self.head else self.comment
        names = re.sub(r"\[[^]]*\]", "", self.code.split("=")[0])
        callback = re.search(r"\(\*(\w+)\)", names)
        self.name = callback[1] if callback else re.split(r"[ *]+", names.strip())[-1]

    def get(self, part: str) -> str:
        """A part of the head, or an empty text."""
        return (self.head and self.head[part]) or ""

    def get_array(self) -> tuple[int, str] | None:
        """Numbers for each item of an array, and what counts the items."""
        count = self.get("count") or self.get("items")
        return (int(self.get("per") or 1), count) if count and "*" in self.code else None

    def get_facts(self) -> str:
        """The head as it stands in the header."""
        return self.comment[:self.head.end()].strip() if self.head else ""


def tidy(comment: str) -> str:
    """The words of a C comment."""
    lines = [re.sub(r"^\s*\*? ?", "", line).rstrip() for line in comment.strip().split("\n")]
    return "\n".join(lines).strip()


def read_members(body: str) -> list[Member]:
    """The declarations of a struct or an enum in their order, each with its comment."""
    members: list[list[str]] = []
    waiting: list[str] = []
    group = ""
    is_open = False  # a declaration whose comment may still follow on its line
    for line in re.findall(r"/\*.*?\*/|[^;,/]+[;,]?|\n", body.replace("\\\n", ""), re.S):
        if line.startswith("/*"):
            text = tidy(line[2:-2])
            if is_open and members:
                members[-1][1] = text
            elif GROUP.match(text):
                group = text[:-1]
            else:
                waiting.append(text)
            continue
        if "\n" in line and line.split("\n")[0].strip() == "":
            is_open = False
        code = " ".join(line.split()).rstrip(";,")
        if code:
            members.append([code, " ".join(waiting), group])
            waiting = []
            is_open = True
    return [Member(code, " ".join(text.split()) if "\n\n" not in text else text, group) for code, text, group in members]


def evaluate(text: str, constants: dict[str, int]) -> float:
    """The number that a head has in letters."""
    names = {"pi": math.pi, "INFINITY": math.inf, **constants}
    return float(eval(text, {"__builtins__": {}}, names))  # of the pattern NUMBER alone


def read_structs(include: Path) -> dict[str, list[Member]]:
    """The members of all structs and enums of the headers, by name."""
    found = {}
    for path in sorted([*include.glob("tulle/*.h"), *include.glob("tulle_io/*.h")]):
        text = path.read_text(encoding="utf-8")
        for match in re.finditer(r"typedef (struct|enum) (tulle_\w+) \{(.*?)\n\} \2;", text, re.S):
            found[match[2]] = read_members(match[3])
    return found
