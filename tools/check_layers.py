#!/usr/bin/env python3
"""Checks that every folder of src/ includes only itself, the folders before it, and public headers.

usage: check_layers.py [ROOT]        prints each breach as FILE:LINE: REASON; exit 1 if there is one
       check_layers.py --self-test   proves that breaches are found

Beside the order of the folders of libtulle:
  - check/ shares nothing with the code it judges: base/, math/vec3.h, geom/*predicates* and itself only;
  - io/, scene/ and subdivision/ are libtulle_io: they see libtulle through its public headers, and the files of base/ and
    geom/ of which they have a copy (COMMON); threads and clocks are not among these;
  - render/ and app/ see both libraries from outside: public headers, base/, themselves, and what PARTS says;
  - rooms within a folder see each other as ROOMS says;
  - libtulle needs libc, libm and threads only, so yaml.h stays in scene/, expat.h in io/vtk/, zlib.h in io/vtk/ and io/animation/, png.h
    and Embree in render/, libwebsockets.h in app/view/server.c, omp.h in base/parallel_openmp.c; immintrin.h in math/simd*.h and in kernels;
  - memory of both libraries comes through base/memory.c, and no library ends the process;
  - public headers of libtulle include those of libtulle only, public headers of libtulle_io those of both.
"""
import os
import re
import sys
import tempfile

ENGINE = ["base", "math", "geom", "detect", "dynamics", "contact", "step", "world", "check"]
IO = ["io", "scene", "subdivision"]
LAYERS = ENGINE + IO + ["render", "app"]
PUBLIC = {"tulle": {"tulle"}, "tulle_io": {"tulle", "tulle_io"}}
# Of which libtulle_io is compiled with a copy, with the headers that have no file of their own: cmake/library.cmake.
COMMON = {"base/arena.h", "base/error.h", "base/hash.h", "base/memory.h", "base/sort.h", "base/text.h", "base/words.h",
          "base/integer.h", "geom/cut_polygon.h", "geom/mesh_indices.h", "geom/topology.h", "math/quaternion.h", "math/vec3.h"}
# What else a folder may include.
PARTS = {"check": ("math/vec3.h", "geom/exact_predicates.h"), "render": ("math/vec3.h",),
         "app": ("scene/scene.h", "scene/picture.h", "scene/units.h", "render/", "io/text/json_quote.h",
                 "io/text/json_read.h", "io/text/number.h", "io/file_data.h", "io/animation/animation_read.h", "io/run/run_rounding.h"),
         "scene": ("io/file_data.h", "io/text/json_quote.h", "io/text/number.h")}
# Rooms that see few others of their folder.
ROOMS = {"detect": {"impact": set(), "patches": set(), "pairs": {"trees"}, "trees": {"impact", "pairs", "patches"}},
         "contact": {"pairs": {"rows"}, "rows": {"pairs", "commit"}, "solve": {"rows", "pairs"}},
         "io": {"text": set(), "cache": set(), "mesh": {"text"}, "vtk": {"text"}, "animation": {"text"}}}
FOREIGN_HEADERS = {"yaml.h": ("src/scene/",), "png.h": ("src/render/",), "embree3/rtcore.h": ("src/render/embree_",),
                   "omp.h": ("src/base/parallel_openmp.c",), "pthread.h": ("src/base/", "src/app/view/"), "libwebsockets.h": ("src/app/view/server.c",),
                   "expat.h": ("src/io/vtk/",), "zlib.h": ("src/io/vtk/", "src/io/animation/"),
                   "gmp.h": (), "immintrin.h": ("src/math/simd", "/kernels/"), "x86intrin.h": (), "arm_neon.h": ()}
INCLUDE = re.compile(r'^\s*#\s*include\s*(["<])([^">]+)[">]')
PRAGMA_OMP = re.compile(r"^\s*#\s*pragma\s+omp\b(?!\s+simd)")
HEAP_CALL = re.compile(r"(?<![\w.>])(malloc|calloc|realloc|free|strdup|aligned_alloc|posix_memalign)\s*\(")
ENDING_CALL = re.compile(r"(?<![\w.>])(abort|exit|_exit|quick_exit)\s*\(")
COMMENT_OR_TEXT = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', re.S)


def get_room(path):
    """The room of "FOLDER/ROOM/FILE", or None for "FOLDER/FILE"."""
    parts = path.split("/")
    return parts[1] if len(parts) > 2 else None


def is_allowed(folder, header):
    """Whether a file of src/FOLDER may include "HEADER", a path below src/ or include/."""
    target = header.split("/")[0]
    if target in (folder, "tulle") or header.startswith(PARTS.get(folder, ("?",))):
        return True
    if folder in ENGINE:
        return target == "base" if folder == "check" else target in ENGINE[:ENGINE.index(folder)]
    if target == "tulle_io":
        return True
    return header in COMMON if folder in IO else target == "base"


def judge_quoted(path, folder, header):
    """Why the file of FOLDER must not include "HEADER", or None. FOLDER is that of include/ for public headers."""
    target = header.split("/")[0]
    if "/" not in header or target not in LAYERS + list(PUBLIC):
        return f'"{header}" should be written from src/ or include/: "FOLDER/{os.path.basename(header)}"'
    if folder in PUBLIC:
        return None if target in PUBLIC[folder] else f'a public header of {folder} must not include "{header}"'
    if not is_allowed(folder, header):
        return f'{folder}/ must not include "{header}"'
    room, other = get_room(path[len("src/"):]), get_room(header)
    if target == folder and other not in (None, room) and other not in ROOMS.get(folder, {}).get(room, {other}):
        return f'{folder}/{room}/ must not include "{header}"'
    return None


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
    if folder not in ENGINE + IO:
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
    top, folder = path.split("/")[:2]
    known = LAYERS if top == "src" else list(PUBLIC)
    if folder not in known:
        yield 1, f"{top}/{folder} is no layer; the layers are {', '.join(known)}"
        return
    with open(os.path.join(root, path), encoding="utf-8") as file:
        text = file.read()
    bare_lines = without_comments_and_texts(text).split("\n")
    for number, line in enumerate(text.split("\n"), 1):
        match = INCLUDE.match(line)
        if match:
            judge = judge_quoted(path, folder, match.group(2)) if match.group(1) == '"' else judge_system(path, match.group(2))
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
    ("src/io/a.c", '#include "base/memory.h"\n#include "tulle/world.h"\n#include "tulle_io/run.h"\n', None),
    ("src/io/c.c", '#include "world/world_state.h"\n', "io/ must not include"),
    ("src/io/d.c", '#include "base/parallel.h"\n', "io/ must not include"),
    ("src/io/e.c", '#include "scene/scene.h"\n', "io/ must not include"),
    ("src/io/f.c", "void f(void) { exit(1); }\n", "returns a status"),
    ("src/io/text/a.c", '#include "io/run/run_directory.h"\n', "io/text/ must not include"),
    ("src/subdivision/a.c", '#include "geom/topology.h"\n#include "math/vec3.h"\n#include "tulle_io/subdivision.h"\n', None),
    ("src/subdivision/b.c", '#include "geom/mesh.h"\n', "subdivision/ must not include"),
    ("src/world/a.c", '#include "tulle_io/run.h"\n', "world/ must not include"),
    ("src/world/b.c", '#include "io/text/number.h"\n', "world/ must not include"),
    ("src/detect/detector/a.c", '#include "detect/trees/broad_phase.h"\n#include "detect/surface_set.h"\n', None),
    ("src/detect/trees/a.c", '#include "detect/detector/detector_parts.h"\n', "detect/trees/ must not include"),
    ("src/detect/impact/a.c", '#include "detect/trees/broad_phase.h"\n', "detect/impact/ must not include"),
    ("src/contact/pairs/a.c", '#include "contact/solve/solve_motion.h"\n', "contact/pairs/ must not include"),
    ("src/contact/solve/a.c", '#include "contact/commit/commit_safely.h"\n', "contact/solve/ must not include"),
    ("src/contact/commit/a.c", '#include "contact/solve/solve_motion.h"\n', None),
    ("src/scene/a.c", '#include "base/error.h"\n#include <yaml.h>\n', None),
    ("src/scene/b.c", '#include "io/run/run_directory.h"\n', "scene/ must not include"),
    ("src/scene/c.c", '#include "world/world_state.h"\n', "scene/ must not include"),
    ("src/render/a.c", '#include "math/vec3.h"\n#include <png.h>\n', None),
    ("src/render/b.c", '#include "scene/scene.h"\n', "render/ must not include"),
    ("src/render/c.c", "#include <embree3/rtcore.h>\n", "belongs to src/render/embree_"),
    ("src/app/a.c", '#include "scene/scene.h"\n#include "app/cli/options.h"\n', None),
    ("src/app/b.c", '#include "world/world.h"\n', "app/ must not include"),
    ("src/app/d.c", '#include "scene/scene_data.h"\n', "app/ must not include"),
    ("src/app/e.c", '#include "io/run/run_writer.h"\n', "app/ must not include"),
    ("src/geom/b.c", '#include "../detect/a.h"\n', "should be written from src/"),
    ("src/geom/c.c", '#include "a.h"\n', "should be written from src/"),
    ("src/geom/d.c", "#include <yaml.h>\n", "belongs to src/scene/"),
    ("src/io/vtk/c.c", "#include <expat.h>\n#include <zlib.h>\n", None),
    ("src/io/b.c", "#include <zlib.h>\n", "belongs to src/io/vtk/"),
    ("src/app/f.c", "#include <zlib.h>\n", "belongs to src/io/vtk/"),
    ("src/geom/e.c", "#include <gmp.h>\n", "belongs to test/"),
    ("src/geom/f.c", "void *p(void) { return malloc(3); }\n", "memory comes through"),
    ("src/geom/g.c", '/* malloc(3) */ const char *t = "free(x)"; void *q = a->release(b); int x = memory_free(c);\n', None),
    ("src/geom/h.c", "void f(void) { exit(1); }\n", "returns a status"),
    ("src/geom/i.c", "#pragma omp parallel for\n", "base/parallel.h"),
    ("src/misc/a.c", "\n", "is no layer"),
    ("include/tulle/a.h", '#include "tulle/base.h"\n', None),
    ("include/tulle/b.h", '#include "base/error.h"\n', "public header"),
    ("include/tulle/c.h", '#include "tulle_io/run.h"\n', "public header"),
    ("include/tulle_io/a.h", '#include "tulle/world.h"\n#include "tulle_io/run.h"\n', None),
    ("include/other/a.h", "\n", "is no layer"),
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
