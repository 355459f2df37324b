#!/usr/bin/env python3
"""Makes src/world/fields/field_rows.c from the comments of the public headers: a row for each value of a def.

usage: make_fields.py [ROOT]           writes the file
       make_fields.py --check [ROOT]   exit 1 if it is not what the headers say
       make_fields.py --self-test      shows the reader each fault that it is to find

python/field_comments.py tells the form of the comments. All values of a struct of TABLES get a row; numbers need a range,
and comments may not promise what the row does not hold. The file is committed, so that a build needs no Python.
"""
import re
import sys
import tempfile
import zlib
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "python"))
from field_comments import FLAG, evaluate, read_structs  # noqa: E402

TABLES = ("mesh_view wind world_detection paper_options world_def curve springs material keyframe motion pin crease cloth_def "
          "body obstacle_def contact_law attachment_def body_drive event_watch").split()
SEEN = "wind paper_options world_def material pin cloth_def obstacle_def contact_law attachment_def body_drive event_watch".split()
OUT = "src/world/fields/field_rows.c"
KINDS = {"double": "FIELD_DOUBLE", "int": "FIELD_INT", "unsigned": "FIELD_U32", "uint32_t": "FIELD_U32", "uint64_t": "FIELD_U64",
         "size_t": "FIELD_SIZE", "unsigned char": "FIELD_U8"}
MACROS = """#define AT(type, member) .name = #member, .offset = offsetof(type, member)
#define ITEMS(type, member, words) .is_array = true, .length = offsetof(type, member), .item = (words)
#define IN(low, high) .least = (low), .most = (high), .range = #low " to " #high
#define ZERO_OR(low, high) .takes_zero = true, .least = (low), .most = (high), .range = "0 or " #low " to " #high
#define ABOVE_ZERO(high) .least = DBL_TRUE_MIN, .most = (high), .range = "above 0 to " #high
#define UP_TO(high) .least = -(double)INFINITY, .most = (high), .range = "at most " #high
#define FINITE .least = -DBL_MAX, .most = DBL_MAX, .range = "finite"
#define ANY .least = -(double)INFINITY, .most = (double)INFINITY, .range = "a number"
#define CHOICE(first, last) .least = (first), .most = (last), .range = #first " to " #last
"""
IDS = {"tulle_cloth_id", "tulle_obstacle_id"}  # two numbers each
# Of the process alone: neither recorded nor hashed.
OF_HOST = {"void", "tulle_allocator"}


class FaultError(Exception):
    """A comment that does not hold to the form."""


def read_version(root):
    """The library's version, as 0.1."""
    text = (root / "include/tulle/base.h").read_text(encoding="utf-8")
    return ".".join(re.search(rf"TULLE_VERSION_{part} (\d+)", text)[1] for part in ("MAJOR", "MINOR"))


def write_number(value):
    """A double in C."""
    if value in (float("inf"), float("-inf")):
        return "-INFINITY" if value < 0 else "INFINITY"
    short = f"{value:g}" if float(f"{value:g}") == value else f"{value!r}"
    return re.sub(r"e([+-])0*(\d)", lambda m: "e" + m[1].strip("+") + m[2], short)


def get_range(member, structs, kind):
    """The range of a number in C, or an empty text."""
    if kind.startswith("tulle_"):
        names = [value.name for value in structs[kind] if not value.name.endswith("_COUNT")]
        return f"CHOICE({names[0]}, {names[-1]})"
    words = member.get("range")
    if words in ("", "any", "finite"):
        return words.upper()
    if member.get("top"):
        return f"UP_TO({member.get('top')})"
    least, most = member.get("least"), member.get("most")
    if not evaluate(least, {}) <= evaluate(most, {}):
        raise FaultError("the range has its ends the wrong way round")
    if member.get("above") and evaluate(least, {}) != 0.0:
        raise FaultError("only 0 may be left out of a range")
    return f"ABOVE_ZERO({most})" if member.get("above") else f"{'ZERO_OR' if member.get('or_zero') else 'IN'}({least}, {most})"


def get_default(member, structs, kind, count):
    """The numbers of a default, none where it is 0."""
    text = member.get("default")
    if not text:
        return []
    if kind.startswith("tulle_"):
        names = [value.name for value in structs[kind]]
        if text not in names:
            raise FaultError(f"the default {text} is no value of {kind}")
        return [float(names.index(text))]
    values = [evaluate(part, {}) for part in text.strip("()").split(",")]
    if len(values) not in (1, count):
        raise FaultError(f"the default has {len(values)} numbers of {count}")
    return values if len(values) == count else values * count


def make_row(name, member, structs):
    """The row of a member in C; None: the cookie."""
    match = re.match(r"(?:const )?(?:struct )?((?:unsigned )?\w+) (\**)(?:\w+)(?:\[(\d+)\])?$", member.code)
    start = f"AT(tulle_{name}, {member.name})"
    if member.name == "cookie":
        return None
    if not match or match[1] in OF_HOST:
        return f"{start}, .kind = FIELD_HOST"
    kind, is_pointer, count = match[1], match[2] == "*", int(match[3] or 1)
    if kind in IDS:
        kind, count = "uint32_t", 2
    is_struct, is_flag = kind.removeprefix("tulle_") in TABLES, kind == "int" and member.name.startswith(FLAG)
    is_enum = kind in structs and not is_struct and all(" " not in value.code for value in structs[kind])
    if kind == "char":
        return f"{start}, .kind = FIELD_TEXT"
    if kind.startswith("tulle_") and not is_struct and not is_enum:
        return f"{start}, .kind = FIELD_CALL"
    parts, limits = [], "" if is_struct else get_range(member, structs, kind)
    if is_pointer and is_struct and not member.get_array():
        parts.append(".is_pointer = true")
    elif is_pointer:
        if not member.get_array():
            raise FaultError("the comment should say how long the array is, as 3 * vertex_count")
        count, length = member.get_array()
        owner = "" if any(other.name == length for other in structs[f"tulle_{name}"]) else "mesh."
        parts.append(f"ITEMS(tulle_{name}, {owner}{length}, \"{length.removesuffix('_count')}\")")
    if is_flag and limits:
        raise FaultError("a flag has no range")
    if not limits and not is_flag and (kind == "double" or (kind in ("int", "unsigned") and not is_pointer)):
        raise FaultError("a number needs a range")
    parts += [limits] if limits else []
    if member.get("unit"):
        parts.append(f".unit = \"{member.get('unit')}\"")
    default = get_default(member, structs, kind, count)
    if any(default):
        parts.append(".fallback = {" + ", ".join(write_number(value) for value in default) + "}")
    if is_struct:
        parts.append(f".inner = &{kind.removeprefix('tulle_')}_fields")
    if member.group:
        parts.append(f".group = \"{member.group}\"")
    is_length = any(other.get_array() and other.get_array()[1] == member.name for other in structs[f"tulle_{name}"])
    code = "FIELD_STRUCT" if is_struct else "FIELD_ENUM" if is_enum else "FIELD_LENGTH" if is_length else KINDS[kind]
    return ", ".join([f"{start}, .kind = {code}, .count = {count}", *parts])


def list_sizes(root):
    """Lines with the sizes of all structs of libtulle, by name."""
    texts = [path.read_text(encoding="utf-8") for path in sorted(root.glob("include/tulle/*.h"))]
    names = sorted(name for text in texts for name in re.findall(r"typedef struct (tulle_\w+) \{", text))
    sizes = [f"SIZE({name})," for name in names]
    return ["    " + " ".join(sizes[i:i + 4]) for i in range(0, len(sizes), 4)]


def write_rows(root):
    """The text of the file."""
    structs, version, lines, shapes = read_structs(root / "include"), read_version(root), [], []
    for name in TABLES:
        rows, has_cookie = [], False
        for member in structs[f"tulle_{name}"]:
            try:
                row = make_row(name, member, structs)
                since = re.search(r"Since (\S+)\.(?!\d)", member.words)
                if since and [int(n) for n in since[1].split(".")] > [int(n) for n in version.split(".")]:
                    raise FaultError(f"there is no version {since[1]} yet")
            except FaultError as fault:
                raise FaultError(f"tulle_{name}.{member.name}: {fault}: {member.comment[:60]!r}") from None
            has_cookie |= row is None
            rows += [row] if row else []
        shape = f"tulle_{name}: " + "; ".join(member.code for member in structs[f"tulle_{name}"])
        shapes.append(shape)
        cookie = f"{zlib.crc32(shape.encode()):#010x}" if has_cookie else "0"
        lines.append(f"{'' if name in SEEN else 'static '}const field_table {name}_fields = "
                     f"{{\"tulle_{name}\", {len(rows)}, sizeof(tulle_{name}), {cookie}, (const field[]){{")
        lines += [*(f"    {{{row}}}," for row in rows), "}};"]
    version = zlib.crc32("\n".join(shapes).encode())
    return "\n".join([
        "/* world/fields/field_rows.c - the values of all defs of a world. Made by tools/make_fields.py",
        " * of the comments of the public headers; not to be edited. */",
        "/* clang-format off */",
        "#include \"world/fields/fields.h\"", "",
        "#include \"tulle/tulle.h\"", "",
        "#include <float.h>", "#include <math.h>", "", MACROS, *lines, "",
        f"const uint32_t fields_version = {version:#010x};", "",
        "#define SIZE(type) {#type, sizeof(type)}",
        "const struct_size struct_sizes[] = {", *list_sizes(root), "};",
        "const size_t struct_size_count = sizeof struct_sizes / sizeof struct_sizes[0];", ""])


GOOD = """
typedef enum tulle_kind {
    TULLE_KIND_A, /* one */
    TULLE_KIND_B  /* other */
} tulle_kind;
typedef struct tulle_wind {
    double mass; /* [kg] 0 or 1e-3 .. 10, default 2: of it. Since 0.1. */
    double grain[3]; /* -1 .. 1, default (1, 0, 0): along it */
    /* others: */
    tulle_kind kind; /* default TULLE_KIND_B; which */
    int is_there; /* default 1: it is */
    const double *places; /* [m] 3 * place_count, each > 0 .. INFINITY: of it; null: none */
    size_t place_count; /* length of `places` */
} tulle_wind;
"""
ROWS = """    {AT(tulle_wind, mass), .kind = FIELD_DOUBLE, .count = 1, ZERO_OR(1e-3, 10), .unit = "kg", .fallback = {2}},
    {AT(tulle_wind, grain), .kind = FIELD_DOUBLE, .count = 3, IN(-1, 1), .fallback = {1, 0, 0}},
    {AT(tulle_wind, kind), .kind = FIELD_ENUM, .count = 1, CHOICE(TULLE_KIND_A, TULLE_KIND_B), .fallback = {1}, .group = "others"},
    {AT(tulle_wind, is_there), .kind = FIELD_INT, .count = 1, .fallback = {1}, .group = "others"},
    {AT(tulle_wind, places), .kind = FIELD_DOUBLE, .count = 3, ITEMS(tulle_wind, place_count, "place"), ABOVE_ZERO(INFINITY), \
.unit = "m", .group = "others"},
    {AT(tulle_wind, place_count), .kind = FIELD_LENGTH, .count = 1, .group = "others"},"""
FAULTS = (("[kg] 0 or 1e-3 .. 10, default 2: of it", "[kg] of it", "a number needs a range"),
          ("Since 0.1", "Since 9.1", "there is no version 9.1 yet"),
          ("(1, 0, 0)", "(1, 0)", "the default has 2 numbers of 3"),
          ("default TULLE_KIND_B", "default TULLE_KIND_C", "the default TULLE_KIND_C is no value of tulle_kind"),
          ("3 * place_count, each", "", "the comment should say how long the array is, as 3 * vertex_count"),
          ("default 1: it is", "0 .. 1: it is", "a flag has no range"),
          ("-1 .. 1,", "1 .. -1,", "the range has its ends the wrong way round"),
          ("0 or 1e-3 ..", "> 1 ..", "only 0 may be left out of a range"))


def self_test():
    """Reads headers that are right and wrong."""
    global TABLES
    tables, wrong = TABLES, 0
    TABLES = ["wind"]
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        (root / "include/tulle").mkdir(parents=True)
        (root / "include/tulle/base.h").write_text("#define TULLE_VERSION_MAJOR 0\n#define TULLE_VERSION_MINOR 1\n", encoding="utf-8")
        for old, new, expected in (("", "", None), *FAULTS):
            (root / "include/tulle/x.h").write_text(GOOD.replace(old, new, 1), encoding="utf-8")
            try:
                found = "" if ROWS in write_rows(root) else "other rows"
            except FaultError as fault:
                found = str(fault)
            if (expected or "") not in found or (expected is None and found):
                wrong += 1
                print(f"self-test: with {new!r}: {found}, not {expected}")
    TABLES = tables
    print(f"self-test: {len(FAULTS) + 1 - wrong} of {len(FAULTS) + 1} cases right")
    return 1 if wrong else 0


def main():
    arguments = sys.argv[1:]
    if arguments[:1] == ["--self-test"]:
        return self_test()
    is_check = arguments[:1] == ["--check"]
    rest = arguments[is_check:]
    root = Path(rest[0]) if rest else Path(__file__).resolve().parent.parent
    try:
        text = write_rows(root)
    except FaultError as fault:
        print(fault)
        return 1
    out = root / OUT
    if not is_check:
        out.write_text(text, encoding="utf-8")
    elif out.read_text(encoding="utf-8") != text:
        print(f"{OUT} is not what the headers say; run tools/make_fields.py")
        return 1
    print(f"fields: {text.count('{AT(')} values of {len(TABLES)} structs")
    return 0


if __name__ == "__main__":
    sys.exit(main())
