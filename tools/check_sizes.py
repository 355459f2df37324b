#!/usr/bin/env python3
"""Checks the sizes of files and functions in C, and on which side of a pointer's type `const` stands.

usage: check_sizes.py [ROOT]        prints each breach as FILE:LINE: REASON; exit 1 if there is one
       check_sizes.py --self-test   proves that breaches are found

A file has at most 800 lines (a warning above 400). A function has at most 100 lines from its opening to its closing
brace, and at most 6 parameters. A pointer to what is not changed is `const T *p`, not `T const *p`.
"""
import os
import re
import sys
import tempfile

FILE_LINES, FILE_WARNING_LINES = 800, 400
FUNCTION_LINES = 100
PARAMETERS = 6
TOKEN = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'|^[ \t]*#(?:\\\n|[^\n])*', re.S | re.M)
CONST_ON_THE_RIGHT = re.compile(r"\b(?!restrict\b)([A-Za-z_]\w*)\s+const\s*\*")
ATTRIBUTE = re.compile(r"\b__attribute__\s*\(\((?:[^()]|\([^()]*\))*\)\)")


def blank(match):
    """Spaces in place of a comment, text or directive; the line ends stay."""
    return re.sub(r"[^\n]", " ", match.group())


def split_top_level(code):
    """Yields (head start, brace start, brace end) of each outermost {...} and the text before it since the last ; or }."""
    head, depth, opened = 0, 0, 0
    for match in re.finditer(r"[{};]", code):
        mark, at = match.group(), match.start()
        if mark == "{":
            if depth == 0 and re.search(r"\bextern\s*$", code[head:at]):
                head = at + 1  # extern "C" { is no block of its own
                continue
            if depth == 0:
                opened = at
            depth += 1
        elif mark == "}":
            if depth == 0:
                head = at + 1
                continue
            depth -= 1
            if depth == 0:
                yield head, opened, at
                head = at + 1
        elif depth == 0:
            head = at + 1


def count_parameters(text):
    """Number of parameters between parentheses, without the outer pair; ... does not count."""
    depth, parts, start = 0, [], 0
    for at, mark in enumerate(text):
        if mark in "([":
            depth += 1
        elif mark in ")]":
            depth -= 1
        elif mark == "," and depth == 0:
            parts.append(text[start:at])
            start = at + 1
    parts.append(text[start:])
    return sum(part.strip() not in ("", "void", "...") for part in parts)


def parse_head(head):
    """(name, parameter count) when the text before a brace declares a function, else None."""
    head = ATTRIBUTE.sub(blank, head)
    if "=" in re.sub(r"\([^()]*\)", "", head):
        return None
    match = re.search(r"([A-Za-z_]\w*)\s*\(", head)
    if not match or not head.rstrip().endswith(")"):
        return None
    depth, begin = 0, match.end()
    for at in range(match.end() - 1, len(head)):
        depth += {"(": 1, ")": -1}.get(head[at], 0)
        if depth == 0:
            return match.group(1), count_parameters(head[begin:at])
    return None


def find_functions(text):
    """Yields (name, first line, line count, parameter count)."""
    code = TOKEN.sub(blank, text)
    for head, opened, closed in split_top_level(code):
        parsed = parse_head(code[head:opened])
        if not parsed:
            continue
        line_count = code.count("\n", opened, closed) + 1
        yield parsed[0], code.count("\n", 0, opened) + 1, line_count, parsed[1]


def judge_text(path, text):
    """Breaches and warnings of one file, two lists of texts."""
    breaches, warnings = [], []
    line_count = text.count("\n")
    if line_count > FILE_LINES:
        breaches.append(f"{path}:1: {line_count} lines; at most {FILE_LINES}")
    elif line_count > FILE_WARNING_LINES:
        warnings.append(f"{path}:1: warning: {line_count} lines; aim for at most {FILE_WARNING_LINES}")
    for name, line, lines, parameters in find_functions(text):
        if lines > FUNCTION_LINES:
            breaches.append(f"{path}:{line}: {name} has {lines} lines; at most {FUNCTION_LINES}")
        if parameters > PARAMETERS:
            breaches.append(f"{path}:{line}: {name} has {parameters} parameters; at most {PARAMETERS}, then a struct")
    code = TOKEN.sub(blank, text)
    for match in CONST_ON_THE_RIGHT.finditer(code):
        breaches.append(f"{path}:{code.count(chr(10), 0, match.start()) + 1}: write `const {match.group(1)} *`, not `{match.group()}`")
    return breaches, warnings


def list_files(root):
    for top in ("src", "include", "test", "fuzz", "examples", "bench", "paper", "scenes"):
        for folder, _, names in sorted(os.walk(os.path.join(root, top))):
            for name in sorted(names):
                if name.endswith((".c", ".h", ".cpp")):
                    yield os.path.relpath(os.path.join(folder, name), root).replace(os.sep, "/")


def judge_tree(root):
    breaches, warnings, file_count = [], [], 0
    for path in list_files(root):
        with open(os.path.join(root, path), encoding="utf-8") as file:
            found = judge_text(path, file.read())
        breaches += found[0]
        warnings += found[1]
        file_count += 1
    return breaches, warnings, file_count


def make_function(lines, parameters="int a"):
    return f"static int f({parameters}) {{\n" + "    x++;\n" * (lines - 2) + "}\n"


# Contents and the text that the one breach must hold (None: no breach).
SELF_TEST = [
    (make_function(100), None),
    (make_function(101), "101 lines; at most 100"),
    ("int g(void) { return 0; }\n" + make_function(101), ":2: f has 101 lines"),
    (make_function(3, parameters="int a, int b, int c, int d, int e, int f"), None),
    (make_function(3, parameters="int a, int b, int c, int d, int e, int f, int g"), "7 parameters"),
    (make_function(3, parameters="int a, int (*b)(int, int), int c, int d, int e, const char *f, ..."), None),
    ('extern "C" {\n' + make_function(101) + "}\n", "101 lines"),
    ("#define M(a) \\\n    {{{ \\\n    }\n" + make_function(101), "101 lines"),
    ("static const char *t = \"{{{\"; /* }}} */ char c = '{';\n" + make_function(101), "101 lines"),
    ("static const int table[] = {\n" + "    1,\n" * 200 + "};\n", None),
    ("struct s {\n" + "    int a;\n" * 200 + "};\n", None),
    ("__attribute__((target_clones(\"avx2\", \"default\")))\n" + make_function(101), "101 lines"),
    ("int x;\nint const *p;\n", ":2: write `const int *`, not `int const *`"),
    ("const int *const *restrict const *p; double const x = a * b; /* int const *p */\n", None),
    ("int x;\n" * 801, "801 lines"),
    ("int x;\n" * 800, None),
]


def self_test():
    failures = 0
    for number, (contents, expected) in enumerate(SELF_TEST):
        with tempfile.TemporaryDirectory() as root:
            os.makedirs(os.path.join(root, "src/base"))
            with open(os.path.join(root, "src/base/a.c"), "w", encoding="utf-8") as file:
                file.write(contents)
            breaches, _, _ = judge_tree(root)
        is_right = (not breaches) if expected is None else (len(breaches) == 1 and expected in breaches[0])
        if not is_right:
            failures += 1
            print(f"self-test {number}: expected {expected!r}, found {breaches}")
    print(f"self-test: {len(SELF_TEST) - failures} of {len(SELF_TEST)} cases right")
    return 1 if failures else 0


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    root = sys.argv[1] if len(sys.argv) > 1 else os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    breaches, warnings, file_count = judge_tree(root)
    for line in warnings + breaches:
        print(line)
    print(f"sizes: {file_count} files, {len(breaches)} breaches, {len(warnings)} warnings")
    return 1 if breaches or not file_count else 0


if __name__ == "__main__":
    sys.exit(main())
