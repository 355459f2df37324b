#!/usr/bin/env python3
"""Checks that the C code of README.md, and of the book's first C program, stands in examples/hello_cloth.c, line for line.
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
EXAMPLE = "examples/hello_cloth.c"
LINES_MAX = 20


def read(root, path):
    with open(os.path.join(root, path), encoding="utf-8") as file:
        return file.read()


def bare_lines(text):
    return [line.strip() for line in text.splitlines() if line.strip()]


def find_faults(root):
    faults = []
    blocks = {page: C_BLOCK.findall(read(root, page)) for page in (README, BOOK)}
    if len(blocks[README]) != 1:
        faults.append(f"{README} has {len(blocks[README])} blocks of C; one, of the lines of {EXAMPLE}, is expected")
    if not blocks[BOOK]:
        faults.append(f"{BOOK} has no block of C")
    faults += [f"{README}: {len(bare_lines(block))} lines of C; at most {LINES_MAX} are expected"
               for block in blocks[README] if len(bare_lines(block)) > LINES_MAX]
    lines = bare_lines(read(root, EXAMPLE))
    for page, found in blocks.items():
        for block in found:
            wanted = bare_lines(block)
            if "\n".join(wanted) not in "\n".join(lines):
                missing = [line for line in wanted if line not in lines]
                faults.append(f"{page}: not in {EXAMPLE}, or in another order: {missing or wanted}")
    return faults


CASES = (  # C of the README, C of the book, faults
    ("a();\n\nb();\n", "a();\n", 0), ("a();\n", "b();\n", 0), ("b();\na();\n", "a();\n", 1), ("c();\n", "a();\n", 1),
    ("a();\nb();\n", "c();\n", 1), ("a();\n", "b();\na();\n", 1), ("a();\n", None, 1), (None, "a();\n", 1),
    ("d();\n" * 21, "a();\n", 1),
)


def self_test():
    failures = 0
    for readme, book, expected in CASES:
        with tempfile.TemporaryDirectory() as root:
            pages = {page: "# R\n" if code is None else f"# R\n```c\n{code}```\n" for page, code in ((README, readme), (BOOK, book))}
            for path, text in (*pages.items(), (EXAMPLE, "  a();\n  b();\n" + "d();\n" * 21)):
                os.makedirs(os.path.dirname(os.path.join(root, path)), exist_ok=True)
                with open(os.path.join(root, path), "w", encoding="utf-8") as file:
                    file.write(text)
            faults = find_faults(root)
        if len(faults) != expected:
            failures += 1
            print(f"self-test {readme!r}, {book!r}: {faults}")
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
