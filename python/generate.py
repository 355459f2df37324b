#!/usr/bin/env python3
"""Writes the two modules of the package that follow from the headers, so that nothing can drift from them.

usage: generate.py INCLUDE_DIRECTORY PACKAGE_DIRECTORY

_bindings.py   what cffi needs to call both libraries: every function, struct and enum of the public headers
structs.py     the structs and enums as typed Python classes, with the comments of the headers

A struct that a caller fills in becomes a dataclass (SETTINGS). What a call gives becomes a class that reads the C
struct (RESULTS). The fields of both are found in the headers. What C tells by a pointer and a count is one array here;
The comment of a pointer says how long the array is (field_comments.py); a pointer without is an error, so a new field of
a header is not forgotten.
"""
from __future__ import annotations

import contextlib
import io
import os
import re
import subprocess
import sys
import tempfile
import textwrap
from pathlib import Path

import cffi
from field_comments import FLAG, Member, read_structs, tidy  # beside this file

# Structs that a caller fills in, and the C function that makes the defaults of each ("": all zero; None: no default).
SETTINGS = {
    "wind": None, "curve": None, "springs": None, "material": None, "allocator": "",
    "keyframe": "", "motion": "", "pin": "tulle_pin_default", "crease": "", "body": "", "contact_law": "",
    "world_detection": None, "paper_options": "tulle_paper_options_default",
    "world_def": "tulle_world_def_default", "cloth_def": "tulle_cloth_def_default",
    "obstacle_def": "tulle_obstacle_def_default", "attachment_def": "tulle_attachment_def_default",
    "body_drive": "tulle_body_drive_default", "event_watch": "tulle_event_watch_default",
    "detect_surface": "", "detect_def": "tulle_detect_def_default", "patch_options": "",
    "subdivision_def": "tulle_subdivision_def_default"}
# Where the defaults of a struct are a member of those of another one.
DEFAULTS_WITHIN = {"wind": ("world_def", "wind"), "world_detection": ("paper_options", "detection"),
                   "material": ("cloth_def", "material"), "curve": ("cloth_def", "material.warp"),
                   "springs": ("cloth_def", "material.springs")}
# Structs that a call gives.
RESULTS = ["untangle_report", "step_report", "step_progress", "transform", "stretch", "fineness", "counts", "hit",
           "attachment_report", "mesh_info", "detect_statistics", "run_outcome", "replay_report", "object_id"]
# Structs of which calls give many: a record of numpy each.
RECORDS = ["contact", "intersection", "overlap", "event", "found_triangle", "detect_event", "check_pair", "step_report",
           "run_lag"]
# Defaults of fields where zero is not what one who leaves them out would expect.
OTHER_DEFAULTS = {("contact_law", "dynamic_friction"): "-1.0"}
# What the package fills in by itself.
HIDDEN = {"cookie", "mesh", "read_frame", "frame_context", "frame_count"} | {
    ("detect_def", "triangles"), ("detect_def", "triangle_count"), ("detect_def", "vertex_count"),
    ("attachment_def", "cloth"), ("attachment_def", "obstacle"), ("attachment_def", "other_cloth")}
PUBLIC_HEADERS = ("tulle/tulle.h", "tulle_io/tulle_io.h")


RENAMED = {"tulle_body": "BodyDef"}  # Body is the object itself


def make_class_name(name: str) -> str:
    """tulle_world_def -> WorldDef."""
    return RENAMED.get(name) or "".join(part.capitalize() for part in name.removeprefix("tulle_").split("_"))


def preprocess(include: Path) -> str:
    """All declarations of the headers, for cffi."""
    with tempfile.TemporaryDirectory() as empty:
        for name in ("stddef.h", "stdint.h"):
            Path(empty, name).touch()
        text = "".join(f"#include <{name}>\n" for name in PUBLIC_HEADERS)
        command = [*os.environ.get("CC", "cc").split(), "-E", "-P", "-nostdinc", "-I", empty, "-I", str(include), "-x", "c", "-"]
        answer = subprocess.run(command, input=text, capture_output=True, text=True, check=False)
    if answer.returncode:
        raise SystemExit(f"generate.py: {' '.join(command)} failed:\n{answer.stderr}")
    return answer.stdout


class Header:
    """What the text of the headers says beside the declarations: comments, and numbers that are macros."""

    def __init__(self, include: Path) -> None:
        self.comments: dict[str, str] = {}
        self.members: dict[str, list[Member]] = read_structs(include)
        self.constants: dict[str, tuple[str, str]] = {}
        for path in sorted([*include.glob("tulle/*.h"), *include.glob("tulle_io/*.h")]):
            text = path.read_text(encoding="utf-8")
            for match in re.finditer(r"/\*((?:(?!\*/).)*)\*/\s*typedef (?:struct|enum) (tulle_\w+) \{(.*?)\n\} \2;", text, re.S):
                self.comments[match[2]] = tidy(match[1])
            for match in re.finditer(r"/\*((?:(?!\*/).)*)\*/\s*#define TULLE_(\w+) ([\w()<> +*-]+)$", text, re.S | re.M):
                self.constants[match[2]] = (match[3], tidy(match[1]))

    def get_comment(self, struct: str, member: str) -> str:
        """The comment of a field or of a value of an enum."""
        return next((found.comment for found in self.members.get(struct, []) if found.name == member), "")


PYTHON_NAMES: dict[str, str] = {}  # TULLE_ON_PINCH_LAG -> OnPinch.LAG


def quote(text: str, indent: str) -> str:
    """A docstring, in which the values of enums have their Python names."""
    text = re.sub(r"\bTULLE_\w+", lambda match: PYTHON_NAMES.get(match[0], match[0]), text)
    text = re.sub(r"\n(?! |\n)", " ", text) if not re.search(r"\n {2,}", text) else text
    text = "\n".join(textwrap.wrap(text, 110 - len(indent))) if "\n" not in text else text
    text = text.replace("\\", "\\\\").replace('"""', "'''")
    lines = text.split("\n")
    ending = '."""' if not text.endswith((".", ":", "?", "!", ")")) else '"""'
    return f'{indent}"""' + ("\n" + indent).join(lines) + ending + "\n"


def list_enum(ffi: cffi.FFI, name: str) -> dict[str, tuple[str, int]]:
    """The values of an enum: their names in C, those in Python, their numbers."""
    numbers = dict(sorted(ffi.typeof(name).relements.items(), key=lambda item: item[1]))
    keys = [key for key in numbers if not key.endswith("_COUNT")]
    prefix = os.path.commonprefix(keys)
    prefix = "TULLE_" if name == "tulle_status" else prefix[:prefix.rindex("_") + 1]
    return {key: (key[len(prefix):].removeprefix("ERROR_"), numbers[key]) for key in keys}


def write_enums(ffi: cffi.FFI, header: Header, names: list[str]) -> list[str]:
    """An IntEnum for each enum; sets of bits become an IntFlag."""
    out = []
    for name in names:
        for key, (short, _) in list_enum(ffi, name).items():
            PYTHON_NAMES[key] = f"{make_class_name(name)}.{short}"
    for name in names:
        base = "IntFlag" if name in ("tulle_lock", "tulle_measured") else "IntEnum"
        out.append(f"\n\nclass {make_class_name(name)}({base}):\n" + quote(header.comments[name], "    ") + "\n")
        for key, (short, value) in list_enum(ffi, name).items():
            out.append(f"    {short} = {value}\n")
            comment = header.get_comment(name, key)
            if comment:
                out.append(quote(comment, "    "))
    return out


def find_arrays(header: Header, name: str) -> dict[str, tuple[str, int, str | None]]:
    """The pointers of a struct that are arrays: field -> (type of an element, numbers for each, field of the count that it sets)."""
    members = header.members[f"tulle_{name}"]
    free = {member.name for member in members} - {field for field in HIDDEN if isinstance(field, str)}
    arrays: dict[str, tuple[str, int, str | None]] = {}
    for member in members:
        found = member.get_array()
        if found and not is_hidden(name, member.name):
            kind = re.sub(r"^const |\*.*", "", member.code).strip()
            element = {"double": "double", "uint32_t": "uint32", "unsigned char": "uint8"}.get(kind) or make_class_name(kind)
            count = found[1] if found[1] in free and not is_hidden(name, found[1]) else None
            free.discard(found[1])
            arrays[member.name] = (element, found[0], count)
    return arrays


def is_hidden(name: str, field: str) -> bool:
    """Whether the package fills in a field by itself."""
    return field in HIDDEN or (name, field) in HIDDEN


def describe(arrays: dict[str, tuple[str, int, str | None]], name: str, field: str,
             kind: cffi.FFI.CType) -> tuple[str, str] | None:
    """The Python type of a field and how it is converted; None: it is hidden."""
    if is_hidden(name, field):
        return None
    if field in arrays:
        element = arrays[field][0]
        return (f"Sequence[{element}]" if element[0].isupper() else "ArrayLike | None"), "array"
    if any(entry[2] == field for entry in arrays.values()):
        return None
    if kind.kind == "primitive":
        if kind.cname in ("double", "float"):
            return "float", "number"
        if kind.cname == "int" and field.startswith(FLAG):
            return "bool", "bool"
        return "int", "number"
    if kind.kind == "enum":
        return make_class_name(kind.cname), "enum"
    if kind.kind == "struct":
        return make_class_name(kind.cname), "struct"
    if kind.kind == "array":
        if kind.item.cname == "char":
            return "str", "text"
        return ("Sequence[float]" if kind.item.cname == "double" else "Sequence[int]"), "vector"
    if kind.kind == "pointer" and kind.item.kind == "struct" and f"{kind.item.cname.split()[-1]}"[6:] in SETTINGS:
        return make_class_name(kind.item.cname.split()[-1]) + " | None", "pointer"
    if kind.kind == "pointer" and kind.item.cname == "char":
        return "str | None", "text"
    if kind.kind == "function" or (kind.kind == "pointer" and kind.item.cname == "void"):
        return None
    raise SystemExit(f"generate.py: {name}.{field} is a {kind.cname}: say in its comment how long it is, or add it to HIDDEN")


def write_settings(ffi: cffi.FFI, header: Header) -> list[str]:
    """A dataclass for each struct that a caller fills in."""
    out = []
    order = [name for name in SETTINGS if f"tulle_{name}" in header.members]
    for name in order:
        maker = SETTINGS[name]
        class_name = make_class_name(f"tulle_{name}")
        out.append(f"\n\n@dataclass\nclass {class_name}(Settings):\n" + quote(header.comments[f"tulle_{name}"], "    ") + "\n")
        fields, words, arrays = [], {}, find_arrays(header, name)
        for field, entry in ffi.typeof(f"tulle_{name}").fields:
            described = describe(arrays, name, field, entry.type)
            if described is None:
                continue
            hint, how = described
            fields.append((field, how))
            other = OTHER_DEFAULTS.get((name, field))
            out.append(f"    {field}: {hint} = {other}\n" if other else f'    {field}: {hint} = default("{name}", "{field}")\n')
            comment = header.get_comment(f"tulle_{name}", field)
            if comment:
                out.append(quote(comment, "    "))
                words[field] = comment
        where = DEFAULTS_WITHIN.get(name)
        out.append(f'\n    _struct: ClassVar[str] = "tulle_{name}"\n')
        out.append(f"    _maker: ClassVar[str | None] = {maker or None!r}\n")
        out.append(f"    _within: ClassVar[tuple[str, str] | None] = {where!r}\n")
        out.append(f"    _fields: ClassVar[dict[str, str]] = {dict(fields)!r}\n")
        out.append(f"    _words: ClassVar[dict[str, str]] = {words!r}\n")
        if arrays:
            out.append(f"    _arrays: ClassVar[dict[str, tuple[str, int, str | None]]] = {arrays!r}\n")
    return out


def write_results(ffi: cffi.FFI, header: Header) -> list[str]:
    """A class that reads the C struct for each struct that a call gives."""
    out = []
    for name in RESULTS:
        out.append(f"\n\nclass {make_class_name(f'tulle_{name}')}(Result):\n" + quote(header.comments[f"tulle_{name}"], "    "))
        fields = []
        out.append("    __slots__ = ()\n")
        for field, entry in ffi.typeof(f"tulle_{name}").fields:
            kind, where = entry.type, f"self._c.{field}"
            described = describe({}, name, field, kind)
            if described is None:
                raise SystemExit(f"generate.py: {name}.{field} cannot be read")
            hint, how = described
            if how == "enum":
                value = f"{hint}({where})"
            elif how == "struct":
                value = f"{hint}({where}, self)"
            elif how == "vector":
                kinds = "float" if kind.item.cname == "double" else "int"
                hint = f"tuple[{kinds}, ...]"
                value = f"tuple({where})"
            elif how == "bool":
                value = f"bool({where})"
            elif how == "text":
                value, hint = f"decode({where})", "str"
            else:
                value = where
            ignore = "  # type: ignore[no-any-return]" if how == "number" else ""
            fields.append(field)
            out.append(f"\n    @property\n    def {field}(self) -> {hint}:\n")
            out.append(quote(header.get_comment(f"tulle_{name}", field) or field.replace("_", " ").capitalize(), "        "))
            out.append(f"        return {value}{ignore}\n")
        out.append(f"\n    _fields: ClassVar[tuple[str, ...]] = {tuple(fields)!r}\n")
    return out


def write_structs(ffi: cffi.FFI, header: Header) -> str:
    """The text of structs.py."""
    enums = [name for name in header.members if ffi.typeof(name).kind == "enum"]
    out = ['"""Structs and enums of the C headers as Python classes. Made by generate.py from the headers; not to be edited.\n\n'
           'All quantities are in SI units: metres, kilograms, seconds, radians.\n"""\n'
           "from __future__ import annotations\n\nfrom collections.abc import Sequence\nfrom dataclasses import dataclass\n"
           "from enum import IntEnum, IntFlag\nfrom typing import ClassVar\n\n"
           "from numpy.typing import ArrayLike\n\nfrom tulle._structs import Result, Settings, decode, default, make_record\n"]
    out.append("\n# ---- numbers ----\n\n")
    values = {"UINT32_MAX": str(2**32 - 1)}
    for name, (value, comment) in header.constants.items():
        value = values.get(value, value)
        out.append(f"{name} = {value}\n" + (quote(comment, "") if comment else ""))
    out += ["\n# ---- enums ----\n", *write_enums(ffi, header, enums)]
    out += ["\n\n# ---- what calls are given ----\n", *write_settings(ffi, header)]
    out += ["\n\n# ---- what calls give ----\n", *write_results(ffi, header)]
    out.append("\n\n# ---- records of arrays ----\n\n")
    for name in RECORDS:
        out.append(f'{name.upper()} = make_record("tulle_{name}")\n' + quote(header.comments[f"tulle_{name}"], ""))
    return "".join(out)


def main() -> None:
    if len(sys.argv) != 3:
        raise SystemExit(__doc__)
    include, package = Path(sys.argv[1]), Path(sys.argv[2])
    ffi = cffi.FFI()
    ffi.cdef(preprocess(include) + "int atoi(const char *);")  # of the C library: world.py tells what for
    ffi.set_source("tulle._bindings", None)
    header = Header(include)
    package.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=package) as partial:
        with contextlib.redirect_stdout(io.StringIO()):
            ffi.emit_python_code(f"{partial}/_bindings.py")
        structs = Path(partial, "structs.py")
        structs.write_text(write_structs(ffi, header), encoding="utf-8")
        for path in Path(partial).iterdir():
            os.replace(path, package / path.name)


if __name__ == "__main__":
    main()
