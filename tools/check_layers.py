#!/usr/bin/env python3
"""Checks that every folder of src/ includes only itself, the folders before it, and public headers.

usage: check_layers.py [ROOT]        prints each breach as FILE:LINE: REASON; exit 1 if there is one
       check_layers.py --self-test   proves that breaches are found

Beside the order of the folders:
  - check/ shares nothing with the code it judges: base/, math/vec3.h, geom/*predicates* and itself only;
  - scene/, render/ and app/ see the library from outside: public headers, base/, themselves, math/vec3.h for render/,
    scene/ and render/ for app/;
  - the library needs libc, libm and threads only, so yaml.h stays in scene/, png.h and Embree in render/, expat.h
    and zlib.h in app/, omp.h in base/parallel_openmp.c; immintrin.h in math/simd*.h and in kernels;
  - the library's memory comes through base/memory.c, and the library never ends the process.
"""
import os
import re
import sys
import tempfile

LAYERS = ["base", "math", "geom", "detect", "dynamics", "contact", "world", "check", "io", "scene", "render", "app"]
OUTSIDE = {"scene": {"base", "scene"}, "render": {"base", "render"}, "app": {"base", "scene", "render", "app"}}
FOREIGN_HEADERS = {"yaml.h": ("src/scene/",), "png.h": ("src/render/",), "embree3/rtcore.h": ("src/render/embree_",),
                   "omp.h": ("src/base/parallel_openmp.c",), "pthread.h": ("src/base/",),
                   "expat.h": ("src/app/",), "zlib.h": ("src/app/",),
                   "gmp.h": (), "immintrin.h": ("src/math/simd", "/kernels/"), "x86intrin.h": (), "arm_neon.h": ()}
INCLUDE = re.compile(r'^\s*#\s*include\s*(["<])([^">]+)[">]')
PRAGMA_OMP = re.compile(r"^\s*#\s*pragma\s+omp\b(?!\s+simd)")
HEAP_CALL = re.compile(r"(?<![\w.>])(malloc|calloc|realloc|free|strdup|aligned_alloc|posix_memalign)\s*\(")
ENDING_CALL = re.compile(r"(?<![\w.>])(abort|exit|_exit|quick_exit)\s*\(")
COMMENT_OR_TEXT = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', re.S)


def is_allowed(folder, header):
    """Whether a file of src/FOLDER may include "HEADER", a path below src/ or include/."""
    target = header.split("/")[0]
    if target in ("tulle", folder):
        return True
    if folder == "render" and header == "math/vec3.h":
        return True
    if folder in OUTSIDE:
        return target in OUTSIDE[folder]
    if folder == "check":
        name = os.path.basename(header)
        return target == "base" or header == "math/vec3.h" or (target == "geom" and "predicates" in name)
    return LAYERS.index(target) < LAYERS.index(folder)


def judge_quoted(folder, header):
    """Why a file of FOLDER must not include "HEADER", or None. FOLDER is "tulle" for public headers."""
    target = header.split("/")[0]
    if "/" not in header or target not in LAYERS + ["tulle"]:
        return f'"{header}" should be written from src/ or include/: "FOLDER/{os.path.basename(header)}"'
    if folder == "tulle":
        return None if target == "tulle" else f'a public header must not include "{header}"'
    if is_allowed(folder, header):
        return None
    return f'{folder}/ must not include "{header}"'


def judge_system(path, header):
    places = FOREIGN_HEADERS.get(header)
    if places is None and not header.startswith(("CGAL", "boost")):
        return None
    if any(path.startswith(place) or (place == "/kernels/" and place in path) for place in places or ()):
        return None
    where = " or ".join(places or ()) or "test/"
    return f"<{header}> belongs to {where} only"


def without_comments_and_texts(text):
    return COMMENT_OR_TEXT.sub(lambda match: re.sub(r"[^\n]", " ", match.group()), text)


def judge_calls(path, folder, line):
    if folder in OUTSIDE or folder == "tulle":
        return
    for match in HEAP_CALL.finditer(line):
        if path != "src/base/memory.c":
            yield f"{match.group(1)}() is called; memory comes through base/memory.h"
    for match in ENDING_CALL.finditer(line):
        yield f"{match.group(1)}() is called; the library returns a status"
    if PRAGMA_OMP.match(line) and path != "src/base/parallel_openmp.c":
        yield "#pragma omp; threads are started by base/parallel.h only"


def judge_file(root, path):
    """Breaches of one file as (line number, reason)."""
    folder = "tulle" if path.startswith("include/") else path.split("/")[1]
    if folder not in LAYERS + ["tulle"]:
        yield 1, f"src/{folder} is no layer; the layers are {', '.join(LAYERS)}"
        return
    with open(os.path.join(root, path), encoding="utf-8") as file:
        text = file.read()
    bare_lines = without_comments_and_texts(text).split("\n")
    for number, line in enumerate(text.split("\n"), 1):
        match = INCLUDE.match(line)
        if match:
            judge = judge_quoted(folder, match.group(2)) if match.group(1) == '"' else judge_system(path, match.group(2))
            if judge:
                yield number, judge
        for reason in judge_calls(path, folder, bare_lines[number - 1]):
            yield number, reason


def find_breaches(root):
    """All breaches below root as "FILE:LINE: REASON", and the number of files read."""
    breaches, file_count = [], 0
    for top in ("src", "include"):
        for folder, _, names in sorted(os.walk(os.path.join(root, top))):
            for name in sorted(names):
                if not name.endswith((".c", ".h")):
                    continue
                path = os.path.relpath(os.path.join(folder, name), root).replace(os.sep, "/")
                file_count += 1
                breaches += [f"{path}:{number}: {reason}" for number, reason in judge_file(root, path)]
    return breaches, file_count


# Path, contents, and the text that a breach must hold (None: no breach).
SELF_TEST = [
    ("src/geom/a.c", '#include "geom/a.h"\n#include "base/b.h"\n#include "math/vec3.h"\n#include "tulle/mesh.h"\n', None),
    ("src/base/a.c", '#include "math/vec3.h"\n', "base/ must not include"),
    ("src/detect/a.c", '#include "world/world.h"\n', "detect/ must not include"),
    ("src/detect/b.c", '#  include  "contact/c.h"\n', "detect/ must not include"),
    ("src/check/a.c", '#include "math/vec3.h"\n#include "geom/exact_predicates.h"\n', None),
    ("src/check/b.c", '#include "geom/distance.h"\n', "check/ must not include"),
    ("src/check/c.c", '#include "detect/trees/broad_phase.h"\n', "check/ must not include"),
    ("src/io/a.c", '#include "world/world.h"\n', None),
    ("src/scene/a.c", '#include "base/error.h"\n#include <yaml.h>\n', None),
    ("src/scene/b.c", '#include "io/run/run_directory.h"\n', "scene/ must not include"),
    ("src/render/a.c", '#include "math/vec3.h"\n#include <png.h>\n', None),
    ("src/render/b.c", '#include "scene/scene.h"\n', "render/ must not include"),
    ("src/render/c.c", "#include <embree3/rtcore.h>\n", "belongs to src/render/embree_"),
    ("src/app/a.c", '#include "scene/scene.h"\n#include "app/cli/options.h"\n', None),
    ("src/app/b.c", '#include "world/world.h"\n', "app/ must not include"),
    ("src/geom/b.c", '#include "../detect/a.h"\n', "should be written from src/"),
    ("src/geom/c.c", '#include "a.h"\n', "should be written from src/"),
    ("src/geom/d.c", "#include <yaml.h>\n", "belongs to src/scene/"),
    ("src/app/c.c", "#include <expat.h>\n#include <zlib.h>\n", None),
    ("src/io/b.c", "#include <zlib.h>\n", "belongs to src/app/"),
    ("src/geom/e.c", "#include <gmp.h>\n", "belongs to test/"),
    ("src/geom/f.c", "void *p(void) { return malloc(3); }\n", "memory comes through"),
    ("src/geom/g.c", '/* malloc(3) */ const char *t = "free(x)"; void *q = a->release(b); int x = memory_free(c);\n', None),
    ("src/geom/h.c", "void f(void) { exit(1); }\n", "returns a status"),
    ("src/geom/i.c", "#pragma omp parallel for\n", "base/parallel.h"),
    ("src/misc/a.c", "\n", "is no layer"),
    ("include/tulle/a.h", '#include "tulle/base.h"\n', None),
    ("include/tulle/b.h", '#include "base/error.h"\n', "public header"),
]


def self_test():
    failures = 0
    for path, contents, expected in SELF_TEST:
        with tempfile.TemporaryDirectory() as root:
            os.makedirs(os.path.join(root, os.path.dirname(path)))
            with open(os.path.join(root, path), "w", encoding="utf-8") as file:
                file.write(contents)
            breaches, _ = find_breaches(root)
        is_right = (not breaches) if expected is None else (len(breaches) == 1 and expected in breaches[0])
        if not is_right:
            failures += 1
            print(f"self-test {path}: expected {expected!r}, found {breaches}")
    print(f"self-test: {len(SELF_TEST) - failures} of {len(SELF_TEST)} cases right")
    return 1 if failures else 0


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    root = sys.argv[1] if len(sys.argv) > 1 else os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    breaches, file_count = find_breaches(root)
    for breach in breaches:
        print(breach)
    print(f"layers: {file_count} files, {len(breaches)} breaches")
    return 1 if breaches or not file_count else 0


if __name__ == "__main__":
    sys.exit(main())
