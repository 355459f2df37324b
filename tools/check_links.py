#!/usr/bin/env python3
"""Checks the links of README.md, CHANGELOG.md, of the book, of the pages beside the code and of the diaries in lab/: every file and every anchor that a page
links to is there, every source file (`src/world/world.c`, `detect/surface_set.h`) and every public name (`tulle_world_step`)
that a page of the book names in code is there, every page that a source file names (docs/guide/scene.md) is there, every .c or
.h file that a comment in C names (`world/world.c`, or `run.h` alone) is there, and every page of docs/ stands in the `nav` of
mkdocs.yml. The changelog and the diaries may name files and functions that are gone.

usage: check_links.py [ROOT]        exit 1 if a link leads nowhere or a page is missing in the book's contents
       check_links.py --self-test   shows it each fault

The anchor of a link to a page is a heading's: its words in small letters, joined by "-". The anchor of a link to a header
is a name that the header declares; the site turns such a link into one to the page of the header. A comment names foreign
headers in angle brackets (<stdio.h>), and patterns with signs or three capitals (`untangle_*.c`, `test_NAME.c`).
"""
import os
import posixpath
import re
import sys
import tempfile

FENCE = re.compile(r"^( *)(```|~~~).*?^\1\2[ \t]*$", re.S | re.M)
CODE = re.compile(r"(`+)(?!`).*?(?<!`)\1(?!`)", re.S)
LINK = re.compile(r"\]\(\s*<?([^()\s<>]+)>?(?:\s+\"[^\"]*\")?\s*\)|(?:src|href)=\"([^\"]+)\"")
HEADING = re.compile(r"^#{1,6} +(.*?)\s*(?:\{#([\w-]+)\})?\s*$", re.M)
ANCHOR = re.compile(r"\b(?:id|name)=\"([^\"]+)\"")
SCHEME = re.compile(r"^[a-z][a-z0-9+.-]*:")
# A path to a source file in code of one line; names with three capitals and more stand for any (`test/FOLDER/test_NAME.c`).
SOURCE = re.compile(r"`((?:[\w.-]+/)+[\w.-]+\.(?:c|h|py|sh|yaml|md))`")
PUBLIC = re.compile(r"`(tulle_\w+)(?:\([^`]*\))?`")
ANY_NAME = re.compile(r"[A-Z]{3}")
SOURCE_FOLDERS = ("", "src", "include", "test")
CODE_FOLDERS = ("src", "include", "test", "fuzz", "examples", "bench", "tools", "cmake", "paper", "scenes")
CODE_ENDINGS = (".c", ".h", ".cpp", ".py", ".sh", ".cmake", ".txt", ".yaml")
PAGE = re.compile(r"\b(?:docs|lab|src|test|fuzz|web)/[\w/]+\.md\b")
COMMENT_OR_TEXT = re.compile(r'(/\*.*?\*/|//[^\n]*)|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', re.S)
NAMED_FILE = re.compile(r"(?<![\w./*?<>{}$-])(?:[\w-]+/)*[\w-]+\.[ch]\b(?![\w/*>])")
COMMENT_FOLDERS = ("src", "include", "test", "fuzz", "examples", "bench", "paper")
NAV_PAGE = re.compile(r"^\s*- (?:[^:#\n]+: *)?([\w/-]+\.md)\s*$", re.M)


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def strip_code(text):
    """The page without code, in which nothing is a link; lines stay where they are."""
    blank = lambda match: "\n" * match.group(0).count("\n")
    return CODE.sub(blank, FENCE.sub(blank, text))


def make_slug(heading):
    """The anchor of a heading: as Python-Markdown makes it, and as forges do wherever no sign is dropped between spaces."""
    words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "")
    words = re.sub(r"[^\w\s-]", "", words).strip().lower()
    return re.sub(r"[-\s]+", "-", words)


def get_anchors(path):
    text = read(path)
    if not path.endswith(".md"):
        return set(re.findall(r"\b(?:tulle|TULLE)_\w+", text))
    anchors, counts = set(), {}
    for words, name in HEADING.findall(FENCE.sub("", text)):
        slug = name or make_slug(words)
        counts[slug] = counts.get(slug, -1) + 1
        anchors.add(f"{slug}_{counts[slug]}" if counts[slug] else slug)
    return anchors | set(ANCHOR.findall(text))


def find_pages(root):
    pages = [name for name in ("README.md", "CHANGELOG.md", "test/README.md", "fuzz/README.md", "web/PROTOCOL.md", "src/io/run/FORMAT.md") if os.path.exists(os.path.join(root, name))]
    for top in ("docs", "lab"):
        for folder, _, names in os.walk(os.path.join(root, top)):
            here = os.path.relpath(folder, root).replace(os.sep, "/")
            pages += [posixpath.join(here, name) for name in names if name.endswith(".md")]
    return sorted(pages)


def find_links(text):
    """(line, target) of each link that stays within the project."""
    plain = strip_code(text)
    for match in LINK.finditer(plain):
        target = match.group(1) or match.group(2)
        if not SCHEME.match(target) and not target.startswith("//"):
            yield plain.count("\n", 0, match.start()) + 1, target


def find_public_names(root):
    """Words of the public headers and of the build, whose targets bear such names too."""
    words = set()
    for folder, folders, names in os.walk(root):
        folders[:] = [name for name in folders if name not in (".git", "build", "out")]
        for name in names:
            if folder.startswith(os.path.join(root, "include")) or name == "CMakeLists.txt" or name.endswith(".cmake"):
                words |= set(re.findall(r"\btulle_\w+", read(os.path.join(folder, name))))
    return words


def find_missing_names(root, page, public):
    if page == "CHANGELOG.md" or page.startswith("lab/"):  # they name what was
        return []
    text = FENCE.sub(lambda match: "\n" * match.group(0).count("\n"), read(os.path.join(root, page)))
    faults = [f"{page}:{text.count(chr(10), 0, match.start()) + 1}: there is no public name {match.group(1)}"
              for match in PUBLIC.finditer(text) if match.group(1) not in public]
    return faults + [f"{page}:{text.count(chr(10), 0, match.start()) + 1}: there is no file {match.group(1)}" for match in SOURCE.finditer(text)
            if not ANY_NAME.search(match.group(1))
            and not any(os.path.exists(os.path.join(root, folder, match.group(1))) for folder in SOURCE_FOLDERS)]


def find_missing_pages(root):
    """Pages that source files name and that are not there; this script shows some on purpose."""
    paths = [os.path.join(root, name) for name in ("Makefile", ".clang-format") if os.path.exists(os.path.join(root, name))]
    for folder in CODE_FOLDERS:
        for here, _, names in os.walk(os.path.join(root, folder)):
            paths += [os.path.join(here, name) for name in sorted(names) if name.endswith(CODE_ENDINGS) and name != "check_links.py"]
    return [f"{os.path.relpath(path, root)}: there is no page {page}" for path in paths
            for page in sorted(set(PAGE.findall(read(path)))) if not os.path.exists(os.path.join(root, page))]


def find_missing_files(root):
    """Files that a comment in C names and that are not there: by path, by a path's end, or by a name anywhere in the tree."""
    paths, known = [], set()
    for here, folders, names in os.walk(root):
        folders[:] = sorted(name for name in folders if name not in (".git", "build", "out"))
        paths += [os.path.relpath(os.path.join(here, name), root).replace(os.sep, "/") for name in sorted(names)
                  if name.endswith((".c", ".h", ".cpp"))]
    for path in paths:
        parts = path.split("/")
        known |= {"/".join(parts[k:]) for k in range(len(parts))}
    faults = []
    for path in paths:
        if path.split("/")[0] not in COMMENT_FOLDERS:
            continue
        text = read(os.path.join(root, path))
        for comment in COMMENT_OR_TEXT.finditer(text):
            for match in NAMED_FILE.finditer(comment.group(1) or ""):
                if match.group() not in known and not ANY_NAME.search(match.group()):
                    line = text.count("\n", 0, comment.start() + match.start()) + 1
                    faults.append(f"{path}:{line}: there is no file {match.group()}")
    return faults


def find_faults(root):
    faults = []
    pages, public = find_pages(root), find_public_names(root)
    for page in pages:
        faults += find_missing_names(root, page, public)
        for line, target in find_links(read(os.path.join(root, page))):
            path, _, anchor = target.partition("#")
            place = posixpath.normpath(posixpath.join(posixpath.dirname(page), path)) if path else page
            found = os.path.join(root, place)
            if place.startswith("../") or not os.path.exists(found):
                faults.append(f"{page}:{line}: the link to {target} leads nowhere")
            elif anchor and (os.path.isdir(found) or anchor not in get_anchors(found)):
                faults.append(f"{page}:{line}: {place} has no anchor {anchor}")
    faults += find_missing_pages(root) + find_missing_files(root)
    contents = NAV_PAGE.findall(read(os.path.join(root, "mkdocs.yml")).partition("\nnav:")[2])
    wanted = [page[len("docs/"):] for page in pages if page.startswith("docs/")]
    wanted += [f"reference/{name}" for name in find_reference_pages(root)]
    faults += [f"mkdocs.yml: nav lacks {page}" for page in wanted if page not in contents]
    faults += [f"mkdocs.yml: nav names {page}, which is not there" for page in contents if page not in wanted]
    faults += [f"mkdocs.yml: nav names {page} twice" for page in sorted(set(contents)) if contents.count(page) > 1]
    return faults


def find_reference_pages(root):
    """The pages that tools/make_reference.py makes, a header each: world.md of tulle/world.h, io_run.md of tulle_io/run.h; and
    those of tools/make_python_reference.py."""
    pages = []
    for folder, prefix in (("tulle", ""), ("tulle_io", "io_")):
        path = os.path.join(root, "include", folder)
        names = sorted(os.listdir(path)) if os.path.isdir(path) else []
        pages += [prefix + name[:-2] + ".md" for name in names if name.endswith(".h")]
    return pages + (["python.md", "python_structs.md"] if os.path.isdir(os.path.join(root, "python", "tulle")) else [])


SELF_TEST = (  # page, contents beyond index.md, faults
    ("[a](index.md) ![b](p.png) <img src=\"p.png\"> [c](#the-head) [d](https://x.org/y)", "", 0),
    ("[a](index.md#the-head) [b](../include/tulle/x.h#tulle_x) [c](../README.md)", "", 0),
    ("`[a](nowhere.md)`\n\n```\n[b](nowhere.md)\n```\n", "", 0),
    ("[a](nowhere.md)", "", 1),
    ("![a](nowhere.png) <a href=\"nowhere.md\">b</a>", "", 2),
    ("[a](index.md#nothing) [b](#nothing)", "", 2),
    ("[a](../include/tulle/x.h#tulle_nothing)", "", 1),
    ("[a](../../outside.md)", "", 1),
    ("`docs/index.md` `tulle/x.h` `out/x.png` `test/ROOM/test_NAME.c`\n\n```\n`src/nothing.c`\n```\n", "", 0),
    ("`src/nothing.c` and `tulle/y.h`", "", 2),
    ("`tulle_x`, `tulle_x(y)`, `tulle_x_*`", "", 0),
    ("`tulle_gone` and `tulle_gone()`", "", 2),
    ("GONE", "", 1),
    ("COMMENT", "", 3),
    ("LAB", "", 2),
    ("", "  - B: b.md\n", 1),
    ("", "  - index.md\n", 1),
)


def self_test():
    wrong = 0
    for text, contents, expected in SELF_TEST + (("", None, 1),):
        with tempfile.TemporaryDirectory() as root:
            files = {"README.md": "# R\n", "docs/index.md": "# The `head`\n" + text, "docs/p.png": "",
                     "include/tulle/x.h": "int tulle_x;\n", "src/x.c": "/* docs/index.md */\n"}
            if text == "GONE":
                files["src/x.c"] = "/* docs/gone.md */\n"
            if text == "LAB":
                files["lab/x.md"] = "# X\n[a](../docs/index.md#the-head) `src/gone.c` [b](gone.md)\n"
                files["src/x.c"] = "/* lab/x.md, lab/gone.md */\n"
            if text == "COMMENT":
                files["src/x.c"] = ("/* x.c: see tulle/x.h, x.h,\n * gone.h, src/gone.c. */ // old/x.c\nconst char *t = \"away.c\";\n"
                                    "/* <stdio.h> x_*.c test_NAME.c */\n")
            files["mkdocs.yml"] = "nav:\n" if contents is None else "x: 1\nnav:\n  - T: index.md\n  - reference/x.md\n" + contents
            if contents is None:
                files["mkdocs.yml"] = "x: 1\nnav:\n  - T: index.md\n"
            for path, words in files.items():
                os.makedirs(os.path.dirname(os.path.join(root, path)), exist_ok=True)
                with open(os.path.join(root, path), "w", encoding="utf-8") as file:
                    file.write(words)
            faults = find_faults(root)
        if len(faults) != expected:
            wrong += 1
            print(f"self-test {text!r}, {contents!r}: {faults}")
    count = len(SELF_TEST) + 1
    print(f"self-test: {count - wrong} of {count} cases right")
    return 1 if wrong else 0


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    root = sys.argv[1] if len(sys.argv) > 1 else os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    faults = find_faults(root)
    for fault in faults:
        print(fault)
    print(f"links: {len(find_pages(root))} pages, {len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
