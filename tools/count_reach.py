#!/usr/bin/env python3
"""Counts the functions that a step of the world can reach, and how deep the deepest of them lies.

usage: count_reach.py [ROOT] [--from FUNCTION] [--without FUNCTION[,FUNCTION...]] [--rooms] [--once FOLDER]
                      [--path FUNCTION] [--kernels]
       count_reach.py --self-test

A function reaches every function whose name stands in its body, as a call or as a callback. A static name means the
function of the same file; any other name means the one that is visible in all files. A macro reaches what its text
names, and so does a table of functions; its own name is that of the variable. A call of a member, a->name(...), reaches
what stands for that member in the tables that the whole reaches: one function may pick a table, and another use it. A
function that a file gives in several variants (#if) counts once, and so does one that several files give, of which the
build takes one. Other members (a.name, .name = ...) and names in comments and texts do not count. Kernels, the loops
over lanes in src/**/kernels/*.c, are not followed unless --kernels says so. Depth is the least number of calls that
lead to a function, so the depth of the whole is that of the function that lies farthest away.

  --from FUNCTION   where to start (default: tulle_world_step)
  --without FUNCTION  leaves out these functions, and what only they reach. --without world_start gives what a step reaches
                    in a world that has started
  --rooms           also: functions reached by folder
  --once FOLDER     also: static functions below src/FOLDER that one function alone names, with their lines
  --path FUNCTION   also: a shortest chain of calls to FUNCTION
  --kernels         follow kernels, too
A name that is not there is an error. tools/check_limits.py holds the limits.
"""
import argparse
import collections
import os
import re
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import check_sizes  # noqa: E402

WORD = re.compile(r"(?<![\w.])(?<!->)[A-Za-z_]\w*")
MACRO = re.compile(r"^[ \t]*#[ \t]*define[ \t]+([A-Za-z_]\w*)((?:\\\n|[^\n])*)", re.M)
TEXT = re.compile(r'"(?:\\.|[^"\\])*"|/\*.*?\*/', re.S)
KERNEL = re.compile(r"\bTULLE_KERNEL\(\s*(\w+)\s*\)")
TABLE = re.compile(r"([A-Za-z_]\w*)\s*(?:\[[^\]]*\]\s*)*=\s*$|\(\s*\*\s*(?:const\s+)?([A-Za-z_]\w*)[^()]*\)\s*\([^()]*\)\s*=\s*$")

CALL_OF_MEMBER = re.compile(r"(?:\.|->)\s*([A-Za-z_]\w*)\s*\(")
ENTRY = re.compile(r"\.\s*([A-Za-z_]\w*)\s*(?:\[[^\]]*\]\s*)*=\s*&?\s*([A-Za-z_]\w*)\s*[,}]")

# members: of a function those that it calls, of a table {(member, function)}
Function = collections.namedtuple("Function", "path name is_static line_count words members")
Graph = collections.namedtuple("Graph", "callees tables members")


def read_functions(root, with_kernels=False):
    """All functions below src/, the variables with a value in braces, and the words that each macro names."""
    functions, tables, macros = [], [], collections.defaultdict(set)
    for folder, _, names in sorted(os.walk(os.path.join(root, "src"))):
        for name in sorted(names):
            is_kernel = name.endswith(".c") and os.path.basename(folder) == "kernels"
            if not name.endswith((".c", ".h")) or is_kernel and not with_kernels:
                continue
            full = os.path.join(folder, name)
            path = os.path.relpath(full, root).replace(os.sep, "/")
            with open(full, encoding="utf-8") as file:
                text = file.read()
            for match in MACRO.finditer(text):
                macros[match.group(1)].update(WORD.findall(TEXT.sub(" ", match.group(2))))
            code = KERNEL.sub(r"\1", check_sizes.TOKEN.sub(check_sizes.blank, text))
            for head, opened, closed in check_sizes.split_top_level(code):
                parsed, table = check_sizes.parse_head(code[head:opened]), TABLE.search(code[head:opened])
                if parsed or table:
                    name = parsed[0] if parsed else table.group(1) or table.group(2)
                    body = code[opened:closed + 1]
                    (functions if parsed else tables).append(
                        Function(path, name, bool(re.search(r"\bstatic\b", code[head:opened])), body.count("\n") + 1,
                                 frozenset(WORD.findall(body)), frozenset((CALL_OF_MEMBER if parsed else ENTRY).findall(body))))
    return join_variants(functions), tables, macros


def join_variants(functions):
    """One function for those of the same name in a file, or visible in all files, with the words of all."""
    joined = {}
    for function in functions:
        key = (function.path if function.is_static or function.name == "main" else None, function.name)
        known = joined.get(key, function)
        joined[key] = function._replace(words=function.words | known.words, members=function.members | known.members,
                                        line_count=max(function.line_count, known.line_count))
    return list(joined.values())


def widen(words, macros):
    """The words, and those of the macros among them."""
    seen, waiting = set(words), list(words)
    while waiting:
        for word in macros.get(waiting.pop(), ()):
            if word not in seen:
                seen.add(word)
                waiting.append(word)
    return seen


def make_graph(functions, tables, macros):
    """For each function the functions and the tables that it names, itself or by a table; and what tables hold for members."""
    by_name, is_table = collections.defaultdict(list), set(tables)
    for entry in functions + tables:
        by_name[entry.name].append(entry)

    def find(word, path):
        candidates = by_name.get(word, ())
        return [f for f in candidates if f.path == path] or [f for f in candidates if not f.is_static or f.path.endswith(".h")]

    named = {entry: [f for word in sorted(widen(entry.words, macros)) for f in find(word, entry.path)]
             for entry in functions + tables}
    callees, picked = {}, {}
    for function in functions:
        seen = dict.fromkeys(named[function])
        waiting = [entry for entry in seen if entry in is_table]
        while waiting:
            for entry in named[waiting.pop()]:
                if entry not in seen and entry in is_table:
                    waiting.append(entry)
                seen.setdefault(entry)
        callees[function] = [f for f in seen if f != function and f not in is_table]
        picked[function] = [f for f in seen if f in is_table]
    members = {table: [(member, f) for member, word in sorted(table.members) for f in find(word, table.path) if f not in is_table]
               for table in tables}
    return Graph(callees, picked, members)


def walk(graph, roots, left_out, tables):
    """{function: (depth, the function that names it)} of all that the roots reach, themselves at depth 0, not over `left_out`."""
    by_member = collections.defaultdict(list)
    for table in tables:
        for member, function in graph.members[table]:
            by_member[member].append(function)
    reached = {root: (0, None) for root in roots}
    waiting = collections.deque(roots)
    while waiting:
        function = waiting.popleft()
        by_tables = [f for member in sorted(function.members) for f in by_member.get(member, ())]
        for callee in graph.callees[function] + by_tables:
            if callee not in reached and callee.name not in left_out:
                reached[callee] = (reached[function][0] + 1, function)
                waiting.append(callee)
    return reached


def find_reached(graph, start, without=()):
    """What `start` reaches, see walk. To start from, or to leave out, what is not there ends the program."""
    if not any(f.name == start for f in graph.callees):
        sys.exit(f"count_reach: there is no function {start} below src/")
    roots = [f for f in graph.callees if f.name == start]
    tables, known = {}, None
    while known != len(tables):
        known = len(tables)
        reached = walk(graph, roots, (), tables)
        tables = dict.fromkeys(table for function in reached for table in graph.tables[function])
    for name in without:
        if not any(f.name == name for f in reached):
            sys.exit(f"count_reach: {start} reaches no function {name}")
    return walk(graph, roots, without, tables) if without else reached


def print_rooms(reached):
    rooms = collections.Counter("/".join(f.path.split("/")[1:-1]) for f in reached)
    for room, count in sorted(rooms.items()):
        print(f"{count:5}  {room}")


def print_once(graph, reached, folder):
    if not any(f.path.startswith(f"src/{folder}") for f in graph.callees):
        sys.exit(f"count_reach: there is no function below src/{folder}")
    users = collections.defaultdict(set)
    for function in reached:
        for callee in graph.callees[function]:
            users[callee].add(function)
    for function in sorted(reached, key=lambda f: (f.path, f.name)):
        if function.is_static and len(users[function]) == 1 and function.path.startswith(f"src/{folder}"):
            print(f"{function.path}: {function.name}, {function.line_count} lines, in {next(iter(users[function])).name}")


def print_path(reached, name):
    if not any(f.name == name for f in reached):
        sys.exit(f"count_reach: no function {name} is reached")
    for function in [f for f in reached if f.name == name]:
        chain = []
        while function:
            chain.append(f"{function.name} ({function.path})")
            function = reached[function][1]
        print("\n  ".join(reversed(chain)))


SELF_TEST = {
    "src/world/a.c": """
/* not_called_in_a_comment */
#define EACH(list) walk(list)
static void once(int x) { x++; }
static int (*const table[])(int) = {unreached};
static const struct doings doings = {.does = listed, .other[0] = 1};
static const struct doings picked = {.go = gone}, not_reached = {.go = not_gone};
static void pick(void) { world->way = &picked; }
void tulle_world_step(void) { pick(); world->way->go(); doings.does(); once(1); b.member(); c->member(); run(callback); EACH(3); "quoted()"; }
static void callback(void) { deep(); }
static void listed(void) { }
static void gone(void) { }
static void not_gone(void) { }
""",
    "src/world/b.c": """
static void once(int x) { wrong(); }
void walk(int list) { }
void deep(void) { deeper(); PICK(lanes)(); }
void wrong(void) { }
void member(void) { }
void quoted(void) { }
int unreached(int x) { return x; }
void not_called_in_a_comment(void) { }
""",
    "src/base/c.h": """
#if WIDE
static inline void deeper(void) { tulle_world_step(); }
#else
static inline void deeper(void) { tulle_world_step(); }
#endif
""",
    "src/base/kernels/lanes.c": """
static int inner(int x) { return x; }
void TULLE_KERNEL(lanes)(void) { inner(1); }
""",
    "src/base/other_deep.c": """
void deep(void) { other(); }
static void other(void) { }
""",
}


def self_test():
    with tempfile.TemporaryDirectory() as root:
        for path, text in SELF_TEST.items():
            os.makedirs(os.path.join(root, os.path.dirname(path)), exist_ok=True)
            with open(os.path.join(root, path), "w", encoding="utf-8") as file:
                file.write(text)
        graph = make_graph(*read_functions(root))
        with_kernels = make_graph(*read_functions(root, True))
    reached = find_reached(graph, "tulle_world_step")
    more = {f.name for f in find_reached(with_kernels, "tulle_world_step")} - {f.name for f in reached}
    rest = {f.name for f in find_reached(graph, "tulle_world_step", ["callback", "pick"])}
    found = {(f.name, f.path, depth) for f, (depth, _) in reached.items()}
    expected = {("tulle_world_step", "src/world/a.c", 0), ("once", "src/world/a.c", 1), ("callback", "src/world/a.c", 1),
                ("listed", "src/world/a.c", 1), ("pick", "src/world/a.c", 1), ("gone", "src/world/a.c", 1),
                ("walk", "src/world/b.c", 1), ("deep", "src/world/b.c", 2), ("deeper", "src/base/c.h", 3)}
    if len(reached) != len(expected) or found != expected:
        print(f"self-test: found {sorted(found)}, expected {sorted(expected)}")
        return 1
    if more != {"lanes", "inner"}:
        print(f"self-test: found {sorted(more)} more with kernels")
        return 1
    if rest != {"tulle_world_step", "once", "walk", "listed", "gone"}:
        print(f"self-test: found {sorted(rest)} without callback and pick")
        return 1
    for start, without in (("tulle_world_step", ["no_such_function"]), ("no_such_function", [])):
        try:
            find_reached(graph, start, without)
        except SystemExit:
            continue
        print("self-test: a name that is not there is no error")
        return 1
    print("self-test: reached functions and depths are right")
    return 0


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", nargs="?", default=os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
    parser.add_argument("--from", dest="start", default="tulle_world_step")
    parser.add_argument("--without", metavar="FUNCTION", type=lambda text: text.split(","), default=[])
    parser.add_argument("--rooms", action="store_true")
    parser.add_argument("--once", metavar="FOLDER")
    parser.add_argument("--path", metavar="FUNCTION")
    parser.add_argument("--kernels", action="store_true")
    options = parser.parse_args()
    graph = make_graph(*read_functions(options.root, options.kernels))
    reached = find_reached(graph, options.start, options.without)
    if options.rooms:
        print_rooms(reached)
    if options.once is not None:
        print_once(graph, reached, options.once)
    if options.path:
        print_path(reached, options.path)
    depth = max(depth for depth, _ in reached.values())
    left_out = f" without {', '.join(options.without)}" if options.without else ""
    left_out += " with kernels" if options.kernels else ""
    print(f"{options.start}{left_out}: {len(reached)} functions in {len({f.path for f in reached})} files, {depth} deep")
    return 0


if __name__ == "__main__":
    sys.exit(main())
