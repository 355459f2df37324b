#!/usr/bin/env python3
"""Makes the reference pages of the Python package from its docstrings: python.md (classes and functions) and
python_structs.md (settings, results and enums, which follow from the headers of C).

usage: make_python_reference.py OUT [ROOT]       writes both pages; exit 1 if something public is undocumented
       make_python_reference.py --check [ROOT]   only judges; exit 77 where no python3 has cffi
       make_python_reference.py --self-test      shows the check each fault that it is to find

The modules are read, not imported, so no library needs to be built. The module of structs is made by python/generate.py from the
headers, which takes a C compiler and cffi.

Public is what python/tulle/_names.py imports and what SUBMODULES have, with all that does not begin with `_`. Every class, function,
method, property, field and value of an enum needs a docstring; a field's stands below it. A parameter needs a word in the docstring of
its function, or of its class, unless its type says it all: one of the package's own classes, or a path. A class that callers make has an
`__init__` with a docstring; the parameters of other classes are not public.
"""
import ast
import os
import re
import subprocess
import sys
import tempfile

import make_reference

PACKAGE = "python/tulle"
SUBMODULES = ("envs", "sensitivity", "datasets")
STRUCTS = "structs"
PAGES = "python.md", "python_structs.md"
TITLES = {"world": "Worlds", "objects": "Objects of a world", "mesh": "Meshes", "detector": "Detection and the judge", "scene": "Scenes",
          "run": "Runs and point caches", "animation": "Animations", "program": "The program", "fit": "Fitting", "plots": "Plots",
          "notebook": "Notebooks", "_arrays": "Arrays of a state", "errors": "Errors", "envs": "Learning: tulle.envs",
          "sensitivity": "Derivatives: tulle.sensitivity", "datasets": "Data sets: tulle.datasets"}
PAGE_WORDS = {
    PAGES[0]: "# Python\n\nThe public classes and functions of the package `tulle`, made from their docstrings. [Python](../guide/python.md) tells how to\n"
              "use them. Settings, results and enums have a page of their own: [Python: structs](python_structs.md). `help(tulle.World)` shows\n"
              "the same text. Quantities are in SI units.\n",
    PAGES[1]: "# Python: structs\n\nSettings, results, enums and records of the package `tulle`, made from the structs of the C headers. A call takes the fields of\n"
              "its settings as keywords: `World(gravity=(0, 0, -1.6))`. The classes and functions: [Python](python.md).\n"}
CAMEL = re.compile(r"\b(?:[A-Z][a-z]+){2,}\b")


class Item:
    """A class, function, method, attribute or constant."""

    def __init__(self, kind, name, declaration, words, line):
        self.kind, self.name, self.declaration, self.words, self.line = kind, name, declaration, words, line
        self.items, self.parameters, self.bases = [], [], []


def parse(path):
    with open(path, encoding="utf-8") as file:
        return ast.parse(file.read())


def get_docstring_below(body, i):
    """The words that stand below a field."""
    following = body[i + 1] if i + 1 < len(body) else None
    is_text = isinstance(following, ast.Expr) and isinstance(following.value, ast.Constant) and isinstance(following.value.value, str)
    return re.sub(r"\n +", "\n", following.value.value) if is_text else ""


def shorten(annotation):
    """A type as people write it: without the module of structs."""
    return re.sub(r"\bstructs\.", "", ast.unparse(annotation).replace("'", ""))


def read_function(node, owner=""):
    """A function or a method; the first parameter of a method is left out."""
    is_bound = owner and "staticmethod" not in [ast.unparse(d) for d in node.decorator_list]
    arguments = node.args
    plain = arguments.posonlyargs + arguments.args
    defaults = [None] * (len(plain) - len(arguments.defaults)) + arguments.defaults
    entries = list(zip(plain, defaults, [""] * len(plain)))[1 if is_bound else 0:]
    if arguments.vararg:
        entries.append((arguments.vararg, None, "*"))
    elif arguments.kwonlyargs:
        entries.append((None, None, "*"))
    entries += list(zip(arguments.kwonlyargs, arguments.kw_defaults, [""] * len(arguments.kwonlyargs)))
    if arguments.kwarg:
        entries.append((arguments.kwarg, None, "**"))
    words, parameters = [], []
    for argument, default, mark in entries:
        if argument is None:
            words.append(mark)
            continue
        text = mark + argument.arg + (f": {shorten(argument.annotation)}" if argument.annotation else "")
        words.append(text + (f" = {ast.unparse(default)}" if default is not None else ""))
        parameters.append((argument.arg, shorten(argument.annotation) if argument.annotation else ""))
    name = f"{owner}.{node.name}" if owner and node.name != "__init__" else owner or node.name
    result = f" -> {shorten(node.returns)}" if node.returns and node.name != "__init__" else ""
    declaration = f"{name}({', '.join(words)}){result}"
    if len(declaration) > 100:
        declaration = f"{name}(\n    " + ",\n    ".join(words) + f"){result}"
    item = Item("method" if owner else "function", node.name, declaration, ast.get_docstring(node) or "", node.lineno)
    item.parameters = parameters
    return item


def read_class(node):
    item = Item("class", node.name, f"class {node.name}", ast.get_docstring(node) or "", node.lineno)
    item.bases = [ast.unparse(base) for base in node.bases]
    for i, child in enumerate(node.body):
        name = getattr(child, "name", "")
        if isinstance(child, ast.FunctionDef):
            decorators = [ast.unparse(decorator) for decorator in child.decorator_list]
            if any(decorator.endswith((".setter", "overload")) for decorator in decorators):
                continue
            if name == "__init__":
                made = read_function(child, node.name)
                if made.words:
                    item.declaration, item.parameters = f"class {made.declaration}", made.parameters
                    item.words += f"\n\n{made.words}"
            elif name.startswith("_"):
                continue
            elif any(decorator.endswith("property") for decorator in decorators):
                hint = f": {shorten(child.returns)}" if child.returns else ""
                item.items.append(Item("property", name, name + hint, ast.get_docstring(child) or "", child.lineno))
            else:
                item.items.append(read_function(child, node.name))
        elif isinstance(child, ast.AnnAssign) and isinstance(child.target, ast.Name):
            name = child.target.id
            if not name.startswith("_") and "ClassVar" not in ast.unparse(child.annotation):
                item.items.append(Item("field", name, f"{name}: {shorten(child.annotation)}", get_docstring_below(node.body, i), child.lineno))
        elif isinstance(child, ast.Assign) and isinstance(child.targets[0], ast.Name) and not child.targets[0].id.startswith("_"):
            name = child.targets[0].id
            value = ast.unparse(child.value)
            item.items.append(Item("value", name, f"{name} = {value}", get_docstring_below(node.body, i), child.lineno))
    return item


def read_module(path):
    """The words of a module, and {name: item} of what it defines."""
    tree = parse(path)
    items = {}
    for i, node in enumerate(tree.body):
        if isinstance(node, ast.FunctionDef):
            items[node.name] = read_function(node)
        elif isinstance(node, ast.ClassDef):
            items[node.name] = read_class(node)
        elif isinstance(node, (ast.Assign, ast.AnnAssign)):
            target = node.targets[0] if isinstance(node, ast.Assign) else node.target
            if isinstance(target, ast.Name) and get_docstring_below(tree.body, i):
                value = ast.unparse(node.value)
                declaration = f"{target.id} = {value}" if len(value) < 60 else target.id
                items[target.id] = Item("constant", target.id, declaration, get_docstring_below(tree.body, i), node.lineno)
    return ast.get_docstring(tree) or "", items


def find_file(folder, module):
    path = os.path.join(folder, *module.split("."))
    return path + ".py" if os.path.exists(path + ".py") else os.path.join(path, "__init__.py")


def read_imports(path):
    """[(module, name or "*")] of what a module imports from the package, relative to it."""
    found = []
    for node in parse(path).body:
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("tulle."):
            found += [(node.module[len("tulle."):], name.name) for name in node.names if name.asname is None]
    return found


def get_all(path):
    """What `__all__` lists, or None."""
    for node in parse(path).body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__" and isinstance(node.value, ast.List):
            return ast.literal_eval(node.value)
    return None


def read_package(root):
    """[(module, its words, its public items)] in the order of the page, the structs last."""
    folder = os.path.join(root, PACKAGE)
    modules = {}
    for module, name in read_imports(os.path.join(folder, "_names.py")):
        if module != STRUCTS and name != "version":
            modules.setdefault(module, []).append(name)
    order = [module for module in TITLES if module in modules] + [module for module in modules if module not in TITLES]
    result = []
    for module in order:
        words, items = read_module(find_file(folder, module))
        names = [name for name in items if not name.startswith("_") and items[name].kind == "class"] if modules[module] == ["*"] else modules[module]
        # A name may come from a module that this one imports it from.
        chosen = [items.get(name) or find_elsewhere(folder, module, name) for name in names]
        result.append((module, words, chosen))
    for module in SUBMODULES:
        path = find_file(folder, module)
        if not os.path.exists(path):
            continue
        words, items = read_module(path)
        names = get_all(path) or [name for name, item in items.items() if not name.startswith("_") and item.kind != "constant"]
        result.append((module, words, [items.get(name) or find_elsewhere(folder, module, name) for name in names]))
    result.append((STRUCTS, *read_structs(root)))
    return result


def find_elsewhere(folder, module, name):
    for other, imported in read_imports(find_file(folder, module)):
        if imported == name:
            return read_module(find_file(folder, other))[1][name]
    return Item("constant", name, name, "", 1)


def find_python(root):
    """A python3 that has cffi, or None."""
    answer = subprocess.run(["sh", os.path.join(root, "paper/find_python.sh"), "cffi"], capture_output=True, text=True, check=False)
    return answer.stdout.strip() or None


def read_structs(root):
    """The module that python/generate.py makes from the headers."""
    generator = os.path.join(root, "python/generate.py")
    if not os.path.exists(generator):
        return "", []
    with tempfile.TemporaryDirectory() as out:
        python = find_python(root)
        if python is None:
            sys.exit("make_python_reference.py: no python3 has cffi; `make docs` installs it")
        answer = subprocess.run([python, generator, os.path.join(root, "include"), out], capture_output=True, text=True, check=False)
        if answer.returncode:
            sys.exit(f"make_python_reference.py: python/generate.py failed:\n{answer.stderr}")
        words, items = read_module(os.path.join(out, "structs.py"))
    return words, [item for name, item in items.items() if not name.startswith("_")]


def find_faults(package):
    faults = []
    classes = {item.name for _, _, items in package for item in items if item.kind == "class"}

    def judge(module, owner, item, more_words=""):
        name = f"{owner}.{item.name}" if owner else item.name
        if not item.words:
            faults.append(f"{PACKAGE}/{module.replace('.', '/')}: {item.kind} {name} has no docstring")
        words = item.words + more_words + " ".join(child.name for child in item.items if child.kind != "method" and child.words)
        for parameter, hint in item.parameters:
            says_all = set(re.findall(r"\w+", hint)) & {*classes, "PathLike"}
            if words and not says_all and not re.search(rf"\b{parameter}\b", words):
                faults.append(f"{PACKAGE}/{module.replace('.', '/')}: {name}: no word on the parameter {parameter}")

    for module, words, items in package:
        if not words:
            faults.append(f"{PACKAGE}/{module}: the module has no docstring")
        for item in items:
            judge(module, "", item)
            for child in item.items:
                judge(module, item.name, child, item.words)
    return faults


def format_docstring(words, link):
    """A docstring as Markdown: examples are code, names of classes are links."""
    result, paragraph, code = [], [], []

    def close():
        if paragraph:
            result.append(make_reference.format_words("\n".join(paragraph), link).replace("\n\n", "\n"))
        if code:
            result.append("```python\n" + "\n".join(code) + "\n```")
        paragraph.clear()
        code.clear()

    for line in words.strip().split("\n"):
        if line.startswith(">>>") or (code and line.strip()):
            if not code:
                close()
            code.append(line)
        elif not line.strip():
            close()
        else:
            paragraph.append(line)
    close()
    return re.sub(CAMEL, link, "\n\n".join(result)) if ">>>" not in words else "\n\n".join(
        part if part.startswith("```") else re.sub(CAMEL, link, part) for part in result)


def write_item(lines, item, link, record_link):
    lines += [f"### {item.name} {{#{item.name}}}", "", "```python", item.declaration, "```", ""]
    bases = [base for base in item.bases if base not in ("Settings", "Result", "Unique", "Generic", "IntEnum", "IntFlag")]
    if bases:
        lines += ["Base: " + ", ".join(CAMEL.sub(link, f"`{base}`" if not CAMEL.fullmatch(base) else base) for base in bases) + ".", ""]
    lines += [format_docstring(item.words, link) + record_link(item), ""]
    table = [child for child in item.items if child.kind != "method"]
    if table:
        lines += ["| name | meaning |", "|---|---|"]
        for child in table:
            words = format_docstring(child.words, link).replace("\n", " ")
            lines.append(f"| `{child.declaration.replace('|', '&#124;')}` | {words} |")
        lines.append("")
    for child in item.items:
        if child.kind == "method":
            lines += [f"#### {item.name}.{child.name} {{#{item.name}.{child.name}}}", "", "```python", child.declaration, "```", "",
                      format_docstring(child.words, link), ""]


def find_record_page(root, name):
    for folder in make_reference.FOLDERS:
        path = os.path.join(root, "include", folder)
        for header in sorted(os.listdir(path)):
            with open(os.path.join(path, header), encoding="utf-8") as file:
                if re.search(rf"}} {name};", file.read()):
                    return make_reference.make_page_name(f"{folder}/{header}")
    return None


def write_pages(out, root, package):
    homes = {item.name: PAGES[module == STRUCTS] for module, _, items in package for item in items}
    for page in PAGES:
        def link(match):
            home = homes.get(match.group(0))
            return match.group(0) if home is None else f"[{match.group(0)}]({'' if home == page else home}#{match.group(0)})"

        def record_link(item):
            match = re.search(r'make_record\("(\w+)"\)', item.declaration.replace("'", '"'))
            home = match and find_record_page(root, match.group(1))
            return f" A record of numpy with the fields of [{match.group(1)}]({home}#{match.group(1)})." if home else ""

        lines = [PAGE_WORDS[page]]
        for module, words, items in package:
            if (module == STRUCTS) != (page == PAGES[1]):
                continue
            if module != STRUCTS:
                lines += [f"## {TITLES.get(module, module)}", "", format_docstring(words, link), ""]
            heading, order = None, ("class", "function", "constant")
            for item in items if module == STRUCTS else sorted(items, key=lambda item: order.index(item.kind)):
                kind = get_kind(item) if module == STRUCTS else None
                if kind != heading:
                    lines += [f"## {kind}", ""]
                    heading = kind
                write_item(lines, item, link, record_link)
        os.makedirs(out, exist_ok=True)
        with open(os.path.join(out, page), "w", encoding="utf-8") as file:
            file.write("\n".join(lines).rstrip() + "\n")


def get_kind(item):
    if item.kind == "constant":
        return "Records" if "make_record" in item.declaration else "Numbers"
    if "Settings" in item.bases:
        return "Settings"
    return "Results" if "Result" in item.bases else "Enums"


def make(out, root):
    package = read_package(root)
    faults = find_faults(package)
    if out:
        write_pages(out, root, package)
    for fault in faults:
        print(fault)
    names = sum(1 + len(item.items) for _, _, items in package for item in items)
    print(f"Python reference: {len(package)} modules, {names} names, {len(faults)} faults")
    return 1 if faults else 0


GOOD = '''"""A module."""
class Thing:
    """A thing, made of `count` parts."""
    size: float
    """[m] its size."""
    def __init__(self, count: int) -> None:
        """Makes it."""
    @property
    def mass(self) -> float:
        """[kg] what it weighs."""
        return 1.0
    def move(self, way: float, other: Thing) -> None:
        """Moves it by `way`."""
        self.place += way
    def _hidden(self, x):
        pass
def take(thing: Thing, number: int = 3, *, is_fast: bool = False) -> Thing:
    """Takes `number` things, fast if `is_fast`."""
    return thing
'''
FAULTS = (  # what is taken out or put in its place, what is then found
    ('"""A module."""', "", "the module has no docstring"),
    ('"""A thing, made of `count` parts."""', '"""A thing."""', "Thing: no word on the parameter count"),
    ('"""A thing, made of `count` parts."""\n', "\n", "no word on the parameter count"),
    ('"""Takes `number` things, fast if `is_fast`."""', "", "function take has no docstring"),
    ('"""[m] its size."""', "", "field Thing.size has no docstring"),
    ('"""[kg] what it weighs."""', "", "property Thing.mass has no docstring"),
    ('"""Moves it by `way`."""', '"""Moves it."""', "Thing.move: no word on the parameter way"),
    ('"""Moves it by `way`."""', "", "method Thing.move has no docstring"),
    (", fast if `is_fast`", "", "take: no word on the parameter is_fast"),
)


def self_test():
    wrong = 0
    for old, new, expected in ((None, None, None), *FAULTS):
        with tempfile.TemporaryDirectory() as root:
            os.makedirs(os.path.join(root, PACKAGE))
            os.makedirs(os.path.join(root, "include/tulle"))
            os.makedirs(os.path.join(root, "include/tulle_io"))
            for name, text in (("_names", "from tulle.thing import Thing, take\n"), ("thing", GOOD.replace(old, new) if old else GOOD)):
                with open(os.path.join(root, PACKAGE, name + ".py"), "w", encoding="utf-8") as file:
                    file.write(text)
            package = [entry for entry in read_package(root) if entry[0] != STRUCTS]
            faults = find_faults(package)
            is_right = (not faults) if expected is None else any(expected in fault for fault in faults)
            if expected is None:
                write_pages(root, root, package)
                with open(os.path.join(root, PAGES[0]), encoding="utf-8") as file:
                    page = file.read()
                is_right = is_right and all(words in page for words in (
                    "class Thing(count: int)", "Thing.move(way: float, other: Thing) -> None", "| `mass: float` | \\[kg\\] what it weighs. |",
                    "take(thing: Thing, number: int = 3, *, is_fast: bool = False) -> Thing")) and "_hidden" not in page
        if not is_right:
            wrong += 1
            print(f"self-test {old!r}: {faults}")
    print(f"self-test: {len(FAULTS) + 1 - wrong} of {len(FAULTS) + 1} cases right")
    return 1 if wrong else 0


def main():
    arguments = sys.argv[1:]
    if arguments == ["--self-test"]:
        return self_test()
    if not arguments or len(arguments) > 2:
        sys.exit(__doc__)
    root = arguments[1] if len(arguments) > 1 else os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    if arguments[0] == "--check" and find_python(root) is None:
        print("skipped: no python3 has cffi")
        return 77
    return make(None if arguments[0] == "--check" else arguments[0], root)


if __name__ == "__main__":
    sys.exit(main())
