#!/usr/bin/env python3
"""Checks that the C code of README.md stands in examples/hello_cloth.c, line for line, and that its links lead somewhere.

usage: check_readme.py [ROOT]        exit 1 if a line or a linked file is missing
       check_readme.py --self-test   proves that both are found
"""
import os
import re
import sys
import tempfile

C_BLOCK = re.compile(r"^```c\n(.*?)^```", re.S | re.M)
LINK = re.compile(r"\]\(([^)#:]+)\)")
EXAMPLE = "examples/hello_cloth.c"


def read(root, path):
    with open(os.path.join(root, path), encoding="utf-8") as file:
        return file.read()


def bare_lines(text):
    return [line.strip() for line in text.splitlines() if line.strip()]


def find_faults(root):
    readme = read(root, "README.md")
    blocks = C_BLOCK.findall(readme)
    if len(blocks) != 1:
        return [f"README.md has {len(blocks)} blocks of C; one, of the lines of {EXAMPLE}, is expected"]
    faults = []
    wanted, lines = bare_lines(blocks[0]), bare_lines(read(root, EXAMPLE))
    if "\n".join(wanted) not in "\n".join(lines):
        missing = [line for line in wanted if line not in lines]
        faults.append(f"README.md: not in {EXAMPLE}, or in another order: {missing or wanted}")
    for target in LINK.findall(readme):
        if not os.path.exists(os.path.join(root, target)):
            faults.append(f"README.md: the link to {target} leads nowhere")
    return faults


def self_test():
    cases = [("a();\n\nb();\n", "docs", 0), ("a();\n", "docs", 0), ("b();\na();\n", "docs", 1),
             ("c();\n", "docs", 1), ("a();\nb();\n", "nowhere.md", 1)]
    failures = 0
    for code, link, expected in cases:
        with tempfile.TemporaryDirectory() as root:
            os.makedirs(os.path.join(root, "examples"))
            os.makedirs(os.path.join(root, "docs"))
            for path, text in (("README.md", f"# R\n[x]({link})\n```c\n{code}```\n"), (EXAMPLE, "  a();\n  b();\n")):
                with open(os.path.join(root, path), "w", encoding="utf-8") as file:
                    file.write(text)
            faults = find_faults(root)
        if len(faults) != expected:
            failures += 1
            print(f"self-test {code!r}, {link}: {faults}")
    print(f"self-test: {len(cases) - failures} of {len(cases)} cases right")
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
