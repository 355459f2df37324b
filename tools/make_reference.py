#!/usr/bin/env python3
"""Makes the reference pages of the book from the public headers, one page a header.

usage: make_reference.py OUT [ROOT]   writes OUT/NAME.md for each header; exit 1 if something public is undocumented
       make_reference.py --check [ROOT]   only judges
       make_reference.py --filter FILE    what Doxygen reads instead of FILE
       make_reference.py --self-test      shows the check each fault that it is to find

Doxygen parses the headers and gives XML. Our comments are plain C comments; the filter marks them for Doxygen and wraps
their text in \\verbatim, so that Doxygen takes no word of them for a command. A comment at the end of a line describes the
name before it, a comment on lines of its own the name after it, the first comment the header, and /* ---- words ---- */
opens a section of the page.

Every macro, type, field, enumerator, callback and function needs a comment of its own. A parameter needs a word in the
function's comment unless its type says it all: an error, an id, a view, or a pointer to one of our structs.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree

sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "python"))
from field_comments import GROUP  # noqa: E402

FOLDERS = ("tulle", "tulle_io")
COMMENT = re.compile(r"/\*.*?\*/", re.S)
SECTION = re.compile(r"^/\* -{2,} (.*?) -{2,} \*/$")
# Macros that are no part of the interface: include guards and what the build passes on.
HIDDEN_MACRO = re.compile(r"_H$|^TULLE_API$|^TULLE_IO_API$|^TULLE_BUILD_|^TULLE_IO_BUILD_")
NAME = re.compile(r"\b(?:tulle|TULLE)_\w+\b")
CONFIGURATION = """
INPUT = {folders}
RECURSIVE = YES
FILE_PATTERNS = *.h
INPUT_FILTER = "{python} {script} --filter"
OUTPUT_DIRECTORY = {out}
GENERATE_XML = YES
XML_PROGRAMLISTING = NO
GENERATE_HTML = NO
GENERATE_LATEX = NO
EXTRACT_ALL = YES
OPTIMIZE_OUTPUT_FOR_C = YES
TYPEDEF_HIDES_STRUCT = YES
MARKDOWN_SUPPORT = NO
AUTOLINK_SUPPORT = NO
MACRO_EXPANSION = YES
EXPAND_ONLY_PREDEF = YES
PREDEFINED = TULLE_API= TULLE_IO_API=
STRIP_FROM_PATH = {include}
QUIET = YES
WARNINGS = NO
"""


def clean(comment):
    """The text of a C comment: without its marks and the stars that begin its lines."""
    lines = [re.sub(r"^\s*\*? ?", "", line) if i else line for i, line in enumerate(comment[2:-2].split("\n"))]
    return "\n".join(line.rstrip() for line in lines)


def mark_comments(text):
    """The header as Doxygen is to read it."""
    first = True

    def mark(match):
        nonlocal first
        before = text[:match.start()].rsplit("\n", 1)[-1].strip()
        if SECTION.match(match.group(0)) or (not before and GROUP.match(clean(match.group(0)).strip())):
            return ""
        opening, closing = "/**< " if before else "/** ", " \\file */" if first else " */"
        first = False
        return opening + "\\verbatim " + clean(match.group(0)) + " \\endverbatim" + closing

    return COMMENT.sub(mark, text)


def get_text(element):
    """The comment of a member, or of a header, as it was written."""
    found = [text for part in element.findall("detaileddescription") for text in part.iter("verbatim")]
    return "\n".join(text.text for text in found if text.text).strip()


def get_plain(element):
    return "" if element is None else "".join(element.itertext()).strip()


def get_line(element):
    return int(element.find("location").get("line"))


class Entry:
    """A public name: its kind, declaration, comment, and fields or enumerators as (name, declaration, comment)."""

    def __init__(self, kind, name, declaration, comment, line):
        self.kind, self.name, self.declaration, self.comment, self.line = kind, name, declaration, comment, line
        self.members, self.parameters = [], []


def lay_out_function(kind, name, result, parameters):
    opening = f"{result}{'' if result.endswith('*') else ' '}{name}("
    if kind == "callback":
        opening = f"typedef {result} (*{name})("
    one_line = opening + ", ".join(parameters or ["void"]) + ");"
    if len(one_line) <= 90:
        return one_line
    return opening + "\n    " + ",\n    ".join(parameters) + ");"


def read_function(member):
    parameters = []
    for parameter in member.findall("param"):
        type_name, name = get_plain(parameter.find("type")), get_plain(parameter.find("declname"))
        if not name:
            continue
        parameters.append((type_name, name, get_plain(parameter.find("array"))))
    entry = Entry("function", get_plain(member.find("name")), "", get_text(member), get_line(member))
    result = re.sub(r"\s+", " ", get_plain(member.find("type")))
    words = [f"{t}{'' if t.endswith('*') else ' '}{n}{a}" for t, n, a in parameters]
    entry.declaration = lay_out_function("function", entry.name, result, words)
    entry.parameters = parameters
    return entry


def read_typedef(member):
    name, text = get_plain(member.find("name")), get_plain(member.find("definition"))
    arguments = get_plain(member.find("argsstring"))
    if arguments.startswith(")("):
        result = get_plain(member.find("type")).replace("(*", "").strip()
        words = [re.sub(r"\s+", " ", word).strip() for word in arguments[2:].rstrip(")").split(",")]
        entry = Entry("callback", name, lay_out_function("callback", name, result, words), get_text(member), get_line(member))
        entry.parameters = [(*re.match(r"(.*?)(\w+)$", word).groups(), "") for word in words]
        return entry
    return Entry("type", name, text + ";", get_text(member), get_line(member))


def read_enum(member):
    entry = Entry("enum", get_plain(member.find("name")), "", get_text(member), get_line(member))
    entry.declaration = f"typedef enum {entry.name} {entry.name};"
    for value in member.findall("enumvalue"):
        name, initial = get_plain(value.find("name")), get_plain(value.find("initializer"))
        entry.members.append((name, f"{name} {initial}".strip(), get_text(value)))
    return entry


def read_struct(path):
    compound = ElementTree.parse(path).getroot().find("compounddef")
    name = get_plain(compound.find("compoundname"))
    entry = Entry("struct", name, f"typedef struct {name} {name};", "", get_line(compound))
    entry.comment = get_text(compound)
    for member in sorted(compound.iter("memberdef"), key=get_line):
        words = get_plain(member.find("definition")).replace(f"{name}::", "")
        words = re.sub(r"\* +", "*", words).replace(") (", ")(")
        words = re.sub(r"(\w)(\*|\(\*)", r"\1 \2", words)
        entry.members.append((get_plain(member.find("name")), words, get_text(member)))
    return entry


def read_header(xml, compound):
    """The entries of one header in the order in which they stand."""
    entries = []
    for member in compound.iter("memberdef"):
        kind, name = member.get("kind"), get_plain(member.find("name"))
        if kind == "define" and not HIDDEN_MACRO.search(name):
            words = f"#define {name} {get_plain(member.find('initializer'))}"
            entries.append(Entry("macro", name, words, get_text(member), get_line(member)))
        elif kind == "function":
            entries.append(read_function(member))
        elif kind == "typedef":
            entries.append(read_typedef(member))
        elif kind == "enum":
            entries.append(read_enum(member))
    for inner in compound.findall("innerclass"):
        entries.append(read_struct(os.path.join(xml, inner.get("refid") + ".xml")))
    return sorted(entries, key=lambda entry: entry.line)


def read_headers(root):
    """{"tulle/world.h": (comment of the header, entries)} by Doxygen."""
    include = os.path.join(root, "include")
    folders = [os.path.join(include, folder) for folder in FOLDERS if os.path.isdir(os.path.join(include, folder))]
    headers = {}
    with tempfile.TemporaryDirectory() as out:
        words = CONFIGURATION.format(folders=" ".join(f'"{folder}"' for folder in folders), python=sys.executable,
                                     script=os.path.abspath(__file__), out=out, include=include)
        subprocess.run(["doxygen", "-"], input=words, text=True, check=True, stdout=subprocess.DEVNULL)
        xml = os.path.join(out, "xml")
        for reference in ElementTree.parse(os.path.join(xml, "index.xml")).getroot().findall("compound[@kind='file']"):
            compound = ElementTree.parse(os.path.join(xml, reference.get("refid") + ".xml")).getroot().find("compounddef")
            path = os.path.relpath(os.path.join(include, compound.find("location").get("file")), include)
            headers[path] = (get_text(compound), read_header(xml, compound))
    return headers


def says_it_all(type_name):
    """Whether a parameter of this type needs no word: what it is stands with the type."""
    bare = type_name.replace("const", "").strip()
    return bool(re.fullmatch(r"tulle_\w+ ?\*?", bare))


def find_faults(root, headers):
    faults = []
    for path, (comment, entries) in sorted(headers.items()):
        if not comment:
            faults.append(f"{path}: the header has no comment")
        for entry in entries:
            if not entry.comment:
                faults.append(f"{path}:{entry.line}: {entry.kind} {entry.name} has no comment")
            for name, _, words in entry.members:
                if not words:
                    faults.append(f"{path}:{entry.line}: {entry.name}: {name} has no comment")
            for type_name, name, _ in entry.parameters:
                if entry.comment and not says_it_all(type_name) and not re.search(rf"\b{name}\b", entry.comment):
                    faults.append(f"{path}:{entry.line}: {entry.name}: the comment does not name the parameter {name}")
        with open(os.path.join(root, "include", path), encoding="utf-8") as file:
            declared = len(re.findall(r"^TULLE(?:_IO)?_API ", COMMENT.sub("", file.read()), re.M))
        read = sum(entry.kind == "function" for entry in entries)
        if declared != read:
            faults.append(f"{path}: declares {declared} functions, Doxygen reads {read}")
    return faults


def find_sections(path):
    with open(path, encoding="utf-8") as file:
        found = [(number, SECTION.match(line.strip())) for number, line in enumerate(file, 1)]
    return [(number, match.group(1)) for number, match in found if match]


def make_link_to(homes, page):
    def link(match):
        home = homes.get(match.group(0))
        if home is None:
            return match.group(0)
        return f"[{match.group(0)}]({'' if home[0] == page else home[0]}#{home[1]})"
    return link


def format_words(words, link):
    """A comment as Markdown: names are links, signs that Markdown reads are escaped, indented lines are code, and lines
    that begin with "- " are a list."""
    result = []
    for paragraph in re.split(r"\n\s*\n", words):
        lines = paragraph.split("\n")
        if lines[0].startswith("- "):
            items = re.split(r"\n(?=- )", paragraph)
            result.append("\n".join("- " + format_words(item[2:], link) for item in items))
            continue
        if all(line.startswith("    ") for line in lines):
            result.append("\n".join(lines))
            continue
        pieces = re.split(r"(`[^`]*`)", " ".join(line.strip() for line in lines))
        for i, piece in enumerate(pieces):
            if i % 2 == 0:
                piece = piece.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
                piece = re.sub(r"([\\*\[\]|])", r"\\\1", piece)
                piece = re.sub(r"(?<!\w)_|_(?!\w)", r"\\_", piece)
                piece = re.sub(r"\bdocs/([\w/]+\.md)", r"[\1](../\1)", piece)
                pieces[i] = NAME.sub(link, piece)
        result.append("".join(pieces))
    return "\n\n".join(result)


def write_page(out, root, path, header, homes):
    comment, entries = header
    page = make_page_name(path)
    link = make_link_to(homes, page)
    summary, _, rest = comment.partition(" - ")
    lines = [f"# {summary}", "", format_words(rest[:1].upper() + rest[1:], link), "", "```c", f'#include "{path}"', "```", ""]
    sections = find_sections(os.path.join(root, "include", path))
    for entry in entries:
        while sections and sections[0][0] < entry.line:
            title = sections.pop(0)[1]
            lines += [f"## {title[:1].upper() + title[1:]}", ""]
        lines += [f"### {entry.name} {{#{entry.name}}}", "", ""]
        if not entry.members:
            lines += ["```c", entry.declaration, "```", ""]
        lines += [format_words(entry.comment, link), ""]
        if entry.members:
            lines += [f"| {'Value' if entry.kind == 'enum' else 'Field'} | Meaning |", "|---|---|"]
            for name, declaration, words in entry.members:
                words = format_words(words, link).replace("\n\n", "<br>")
                lines.append(f"| `{declaration.replace('|', '&#124;')}` | {words} |")
            lines.append("")
    with open(os.path.join(out, page), "w", encoding="utf-8") as file:
        file.write("\n".join(lines))


def make_page_name(path):
    """tulle/world.h -> world.md, tulle_io/run.h -> io_run.md"""
    folder, name = path.split("/")
    return (folder.replace("tulle_", "") + "_" if folder != "tulle" else "") + name.replace(".h", ".md")


def make(out, root):
    headers = read_headers(root)
    faults = find_faults(root, headers)
    if out:
        os.makedirs(out, exist_ok=True)
        homes = {}
        for path, (_, entries) in headers.items():
            for entry in entries:
                homes[entry.name] = (make_page_name(path), entry.name)
                if entry.kind == "enum":
                    homes.update({name: (make_page_name(path), entry.name) for name, _, _ in entry.members})
        for path, header in headers.items():
            write_page(out, root, path, header, homes)
    for fault in faults:
        print(fault)
    names = sum(1 + len(entry.members) for _, entries in headers.values() for entry in entries)
    print(f"reference: {len(headers)} headers, {names} names, {len(faults)} faults")
    return 1 if faults else 0


GOOD = """/* tulle/x.h - a header. */
#ifndef TULLE_X_H
#define TULLE_X_H
/* How many. */
#define TULLE_X_MAX 3
/* A thing that nobody looks into. */
typedef struct tulle_thing tulle_thing;
/* ---- the rest ---- */
/* Where it is. */
typedef struct tulle_x {
    double place; /* [m] with a * and 0 < x */
    /* [kg] on lines
     * of its own */
    double mass;
    int (*ask)(void *context); /* quick */
} tulle_x;
/* What it is. */
typedef enum tulle_kind {
    TULLE_KIND_A, /* one */
    TULLE_KIND_B  /* the other */
} tulle_kind;
/* Called with `context` at each step. */
typedef int (*tulle_call)(void *context);
/* Takes `count` things. */
TULLE_API int tulle_take(tulle_thing *thing, size_t count,
                         const tulle_x *x);
TULLE_API void tulle_drop(tulle_thing *thing); /* null is fine */
#endif
"""
FAULTS = (  # what is cut out of the good header or changed, what is then found
    ("/* tulle/x.h - a header. */\n", "/* ---- x ---- */\n", "macro TULLE_X_MAX has no comment"),
    ("/* How many. */\n", "", "macro TULLE_X_MAX has no comment"),
    ("/* A thing that nobody looks into. */\n", "", "type tulle_thing has no comment"),
    ("/* Where it is. */\n", "", "struct tulle_x has no comment"),
    (" /* [m] with a * and 0 < x */", "", "tulle_x: place has no comment"),
    ("    /* [kg] on lines\n     * of its own */\n", "", "tulle_x: mass has no comment"),
    (" /* quick */", "", "tulle_x: ask has no comment"),
    ("/* What it is. */\n", "", "enum tulle_kind has no comment"),
    (" /* one */", "", "tulle_kind: TULLE_KIND_A has no comment"),
    (" /* the other */", "", "tulle_kind: TULLE_KIND_B has no comment"),
    ("/* Called with `context` at each step. */\n", "", "callback tulle_call has no comment"),
    ("with `context` at", "at", "tulle_call: the comment does not name the parameter context"),
    ("/* Takes `count` things. */\n", "", "function tulle_take has no comment"),
    ("`count` things", "things", "tulle_take: the comment does not name the parameter count"),
    (" /* null is fine */", "", "function tulle_drop has no comment"),
)


def find_faults_of(text):
    with tempfile.TemporaryDirectory() as root:
        os.makedirs(os.path.join(root, "include", "tulle"))
        with open(os.path.join(root, "include", "tulle", "x.h"), "w", encoding="utf-8") as file:
            file.write(text)
        return find_faults(root, read_headers(root))


def self_test():
    wrong = 0
    for old, new, expected in (("", "", None),) + FAULTS:
        assert old in GOOD
        faults = find_faults_of(GOOD.replace(old, new, 1))
        if expected is None and faults or expected and not any(fault.endswith(expected) for fault in faults):
            wrong += 1
            print(f"self-test: without {old!r}: {faults}")
    print(f"self-test: {len(FAULTS) + 1 - wrong} of {len(FAULTS) + 1} cases right")
    return 1 if wrong else 0


def main():
    arguments = sys.argv[1:]
    if arguments[:1] == ["--filter"]:
        with open(arguments[1], encoding="utf-8") as file:
            sys.stdout.write(mark_comments(file.read()))
        return 0
    if not arguments or arguments[0] in ("-h", "--help"):
        print(__doc__)
        return 0 if arguments else 2
    if not shutil.which("doxygen"):
        print("skipped: doxygen is not installed; tools/install_packages.sh docs installs it")
        return 77
    if arguments == ["--self-test"]:
        return self_test()
    root = arguments[1] if len(arguments) > 1 else os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    return make(None if arguments[0] == "--check" else arguments[0], root)


if __name__ == "__main__":
    sys.exit(main())
