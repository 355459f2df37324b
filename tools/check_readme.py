#!/usr/bin/env python3
"""Checks that the C code of README.md, and of pages of the book that explain examples, stands in one of these, line for line.
README.md has one block of it, of 20 lines at most. Links are check_links.py's.

usage: check_readme.py [ROOT]        exit 1 if a line is missing or in another order
       check_readme.py --self-test   shows it each fault
"""
import os
import re
import sys
import tempfile

C_BLOCK = re.compile(r"^```c\n(.*?)^```", re.S | re.M)
README = "README.md"
BOOK = "docs/start/first_program.md"
EMBED = "docs/guide/embed.md"
EXAMPLE = "examples/hello_cloth.c"
EXAMPLES = {README: (EXAMPLE,), BOOK: (EXAMPLE,),
            EMBED: ("examples/live_character.c", "examples/tear_off.c", "examples/pick_and_drag.c", "examples/gripper.c",
                    "examples/record_calls.c")}
LINES_MAX = 20


def read(root, path):
    with open(os.path.join(root, path), encoding="utf-8") as file:
        return file.read()


def bare_lines(text):
    return [line.strip() for line in text.splitlines() if line.strip()]


def find_faults(root):
    faults = []
    blocks = {page: C_BLOCK.findall(read(root, page)) for page in EXAMPLES}
    if len(blocks[README]) != 1:
        faults.append(f"{README} has {len(blocks[README])} blocks of C; one, of the lines of {EXAMPLE}, is expected")
    faults += [f"{page} has no block of C" for page in (BOOK, EMBED) if not blocks[page]]
    faults += [f"{README}: {len(bare_lines(block))} lines of C; at most {LINES_MAX} are expected"
               for block in blocks[README] if len(bare_lines(block)) > LINES_MAX]
    for page, found in blocks.items():
        texts = ["\n".join(bare_lines(read(root, example))) for example in EXAMPLES[page]]
        for block in found:
            wanted = "\n".join(bare_lines(block))
            if not any(wanted in text for text in texts):
                faults.append(f"{page}: as a whole in none of {', '.join(EXAMPLES[page])}: {wanted}")
    return faults


LIVE = "e();\nf();\n"
CASES = (  # C of the README, of the first program, of the page on embedding, faults
    ("a();\n\nb();\n", "a();\n", LIVE, 0), ("a();\n", "b();\n", LIVE, 0), ("b();\na();\n", "a();\n", LIVE, 1),
    ("c();\n", "a();\n", LIVE, 1), ("a();\nb();\n", "c();\n", LIVE, 1), ("a();\n", "b();\na();\n", LIVE, 1),
    ("a();\n", None, LIVE, 1), (None, "a();\n", LIVE, 1), ("d();\n" * 21, "a();\n", LIVE, 1), ("a();\n", "a();\n", None, 1),
    ("a();\n", "a();\n", "h();\n", 0), ("a();\n", "a();\n", "f();\ng();\n", 1),
    ("a();\n", "a();\n", "f();\ne();\n", 1), ("a();\n", "a();\n", "a();\n", 1),
)


def self_test():
    failures = 0
    for readme, book, embed, expected in CASES:
        with tempfile.TemporaryDirectory() as root:
            pages = {page: "# R\n" if code is None else f"# R\n```c\n{code}```\n" for page, code in ((README, readme), (BOOK, book), (EMBED, embed))}
            for path, text in (*pages.items(), (EXAMPLE, "  a();\n  b();\n" + "d();\n" * 21), *((example, "g();\nh();\n" if i else LIVE) for i, example in enumerate(EXAMPLES[EMBED]))):
                os.makedirs(os.path.dirname(os.path.join(root, path)), exist_ok=True)
                with open(os.path.join(root, path), "w", encoding="utf-8") as file:
                    file.write(text)
            faults = find_faults(root)
        if len(faults) != expected:
            failures += 1
            print(f"self-test {readme!r}, {book!r}, {embed!r}: {faults}")
    print(f"self-test: {len(CASES) - failures} of {len(CASES)} cases right")
    return 1 if failures else 0


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    root = sys.argv[1] if len(sys.argv) > 1 else os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    faults = find_faults(root)
    for fault in faults:
        print(fault)
    print(f"readme: {len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
