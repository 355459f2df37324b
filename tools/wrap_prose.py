#!/usr/bin/env python3
"""Keeps the prose of README.md, docs/ and the pages beside the code within 140 columns.

usage: wrap_prose.py               wraps each paragraph and list item with a longer line; leaves all others as they are
       wrap_prose.py --check       exit 1 if there is one, or if the book has become too long
       wrap_prose.py --self-test   shows it text of each kind

The hour of the book, the first part of `nav` in mkdocs.yml, has at most HOUR words, all of docs/ at most BOOK. A word has a letter or
a digit. Tables, code, headings and HTML stay as they are. Code between backticks is not broken.
"""
import os
import re
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
WIDTH = 140
HOUR, BOOK = 12000, 60500
FENCE = re.compile(r"^ *(```|~~~)")
ITEM = re.compile(r"^( *)([-*+]|\d+[.)]) +")
ALONE = re.compile(r"^ *(#|\||<|!\[|\[[^\]]+\]: |>)")
# What would begin a list, a heading, a quotation or a table at the start of a line.
UNFIT_FIRST = re.compile(r"^([-+*]|\d+[.)]|[#>|].*)$")
WORD = re.compile(r"(?:`+[^`]*`+|[^\s`])+")


def find_blocks(lines):
    """(first, end, indent of its other lines) of each paragraph and list item."""
    blocks, fence, begin, indent = [], None, None, 0

    def close(end):
        nonlocal begin
        if begin is not None:
            blocks.append((begin, end, indent))
        begin = None

    is_code_before = True  # whether an indented line may begin code
    for i, line in enumerate(lines):
        mark = FENCE.match(line)
        if fence or mark:
            close(i)
            if mark:
                fence = None if fence == mark.group(1) else fence or mark.group(1)
            is_code_before = True
        elif not line.strip():
            close(i)
            is_code_before = True
        elif is_code_before and line.startswith("    ") and not ITEM.match(line) and not is_in_item(blocks, lines, i):
            pass  # indented code goes on until the indent ends
        elif ALONE.match(line):
            close(i)
            is_code_before = False
        elif ITEM.match(line):
            close(i)
            begin, indent = i, len(ITEM.match(line).group(0))
            is_code_before = False
        else:
            if begin is None:
                begin, indent = i, len(line) - len(line.lstrip())
            is_code_before = False
    close(len(lines))
    return blocks


def is_in_item(blocks, lines, i):
    """Whether an indented line after a blank one goes on with the list item above, whose text has the same indent."""
    if not blocks:
        return False
    first, _, indent = blocks[-1]
    return bool(ITEM.match(lines[first])) and 0 < indent <= len(lines[i]) - len(lines[i].lstrip()) < indent + 4


def wrap(lines, indent):
    text = " ".join(line.strip() for line in lines)
    first = lines[0][:len(lines[0]) - len(lines[0].lstrip())]
    result = [first]
    for word in WORD.findall(text):
        is_empty = not result[-1].strip()
        if not is_empty and len(result[-1]) + 1 + len(word) > WIDTH and not UNFIT_FIRST.match(word):
            result.append(" " * indent)
            is_empty = True
        result[-1] += word if is_empty else " " + word
    return result


def find_long(lines):
    return [block for block in find_blocks(lines) if any(len(line) > WIDTH for line in lines[block[0]:block[1]])
            and wrap(lines[block[0]:block[1]], block[2]) != lines[block[0]:block[1]]]


def wrap_page(text):
    lines = text.split("\n")
    for first, end, indent in reversed(find_long(lines)):
        lines[first:end] = wrap(lines[first:end], indent)
    return "\n".join(lines)


def find_pages(root):
    pages = [name for name in ("README.md", "test/README.md", "fuzz/README.md", "web/PROTOCOL.md", "src/io/run/FORMAT.md") if os.path.exists(os.path.join(root, name))]
    for folder, _, names in os.walk(os.path.join(root, "docs")):
        here = os.path.relpath(folder, root).replace(os.sep, "/")
        pages += [f"{here}/{name}" for name in names if name.endswith(".md")]
    return sorted(pages)


def count_words(text):
    return sum(bool(re.search(r"\w", word)) for word in text.split())


def find_hour(nav):
    """The pages of the first part of the contents."""
    part = re.split(r"(?m)^  - ", nav.partition("\nnav:")[2])
    return re.findall(r"(?m)^ +- ([\w/]+\.md)$", part[1]) if len(part) > 1 else []


def judge_length(texts, nav):
    """What is wrong with the length of the book, of {page: text}."""
    hour, book = sum(count_words(texts[f"docs/{page}"]) for page in find_hour(nav)), sum(count_words(text) for page, text in texts.items() if page.startswith("docs/"))
    return [f"{what}: {words} words, more than {most}" for what, words, most in (("the hour", hour, HOUR), ("the book", book, BOOK)) if words > most]


def self_test():
    word, wide = "word " * 40, "x" * 150
    cases = (  # page, number of blocks that are too long, lines after
        ("a\nb\n", 0, None), (word, 1, 2), (f"| {word} |", 0, None), (f"```\n{word}\n```", 0, None), (f"    {word}", 0, None),
        (f"# {word}", 0, None), (wide, 0, None), (f"{wide} a", 1, 2), (f"- {word}\n- b\n- {word}", 2, 5), (f"1. {word}\n   more", 1, 2),
        (f"- a\n\n        {word}", 0, None), (f"- a\n\n    {word}", 1, 4), ("y" * 138 + " - z", 1, 2), ("y" * 138 + " `a b c`", 1, 2), (f"short\n\n{word}\n\nshort", 1, 6),
    )
    wrong = 0
    for text, count, lines in cases:
        after = wrap_page(text)
        found = len(find_long(text.split("\n")))
        is_right = found == count and not find_long(after.split("\n")) and after.split() == text.split()
        is_right = is_right and (len(after.split("\n")) == lines if count else after == text)
        if not is_right:
            wrong += 1
            print(f"self-test {text[:40]!r}: {found} blocks, {after!r}")
    nav = "x: 1\nnav:\n  - A:\n      - a.md\n      - b/c.md\n  - B:\n      - d.md\n"
    for a, d, faults in ((HOUR, 0, 0), (HOUR + 1, 0, 1), (1, BOOK, 1), (0, BOOK, 0), (HOUR + 1, BOOK, 2)):
        texts = {f"docs/{page}.md": text for page, text in (("a", "a | " * a), ("b/c", "| -"), ("d", "d " * d))} | {"README.md": "e " * BOOK}
        if find_hour(nav) != ["a.md", "b/c.md"] or len(judge_length(texts, nav)) != faults:
            wrong += 1
            print(f"self-test of the length: {a}, {d}: {judge_length(texts, nav)}")
    print(f"self-test: {len(cases) + 5 - wrong} of {len(cases) + 5} cases right")
    return 1 if wrong else 0


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    if sys.argv[1:] not in ([], ["--check"]):
        sys.exit(__doc__)
    faults, texts = [], {}
    for page in find_pages(ROOT):
        with open(os.path.join(ROOT, page), encoding="utf-8") as file:
            text = texts[page] = file.read()
        lines = text.split("\n")
        faults += [f"{page}:{first + 1}: more than {WIDTH} columns" for first, _, _ in find_long(lines)]
        if len(sys.argv) == 1 and wrap_page(text) != text:
            with open(os.path.join(ROOT, page), "w", encoding="utf-8") as file:
                file.write(wrap_page(text))
    for fault in faults:
        print(fault)
    is_checked = len(sys.argv) > 1
    print(f"prose: {len(faults)} paragraphs " + ("are too wide; tools/wrap_prose.py wraps them" if is_checked else "wrapped"))
    with open(os.path.join(ROOT, "mkdocs.yml"), encoding="utf-8") as file:
        too_long = judge_length(texts, file.read())
    for fault in too_long:
        print(fault)
    return 1 if (faults or too_long) and is_checked else 0


if __name__ == "__main__":
    sys.exit(main())
