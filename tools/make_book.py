#!/usr/bin/env python3
"""Gathers the pages of the book for mkdocs: docs/, the pages of the public headers and of the Python package, and the files that pages
link to.

usage: make_book.py OUT [ROOT]   exit 1 if a public name is undocumented

A page in docs/ links to a header by its path in the tree; in the book that is the header's page in reference/. A link to the Python
package, or to what makes its structs, leads to its page there, too. A link to
another file outside docs/ (a scene, an example, a script) leads to a page source/PATH that shows it. The diaries in lab/ and the pages beside
the code (test/README.md) do not belong to the book: if a page links to one, the book has the file's name.
"""
import json
import os
import posixpath
import re
import shutil
import sys

import check_links
import make_python_reference
import make_reference

PYTHON_PAGES = {"python/tulle": "reference/python.md", "python/generate.py": "reference/python_structs.md"}
LANGUAGES = {".c": "c", ".h": "c", ".py": "python", ".sh": "bash", ".yaml": "yaml", ".yml": "yaml", ".cmake": "cmake"}
LINK = re.compile(r"\]\(([^()\s<>#]+)((?:#[^()\s]*)?)\)")
OUTSIDE_LINK = re.compile(r"\[([^\[\]]*)\]\((?:\.\./)+((?:lab|src|test|fuzz|web)/[^()\s#]*\.md|lab/)(?:#[^()\s]*)?\)")


def format_notebook(words):
    """The cells of a notebook as a page."""
    cells = ((cell["cell_type"], "".join(cell["source"])) for cell in json.loads(words)["cells"])
    return "\n\n".join(text if kind == "markdown" else f"```python\n{text}\n```" for kind, text in cells) + "\n"


class Book:
    def __init__(self, out, root):
        self.out, self.root, self.sources = out, root, set()

    def find_new_place(self, place):
        """Where the book has a file of the tree, or None if it stays."""
        parts = place.split("/")
        if place in PYTHON_PAGES:
            return PYTHON_PAGES[place]
        if parts[0] == "include" and place.endswith(".h"):
            return "reference/" + make_reference.make_page_name("/".join(parts[1:]))
        self.sources.add(place)
        return f"source/{place}.md"

    def mend_links(self, page, text):
        """The page's text with links to files outside docs/ led to their pages in the book."""

        def mend(match):
            target = match.group(1)
            if check_links.SCHEME.match(target):
                return match.group(0)
            place = posixpath.normpath(posixpath.join("docs", posixpath.dirname(page), target))
            if place.startswith("docs/"):
                return match.group(0)
            new = self.find_new_place(place)
            return f"]({posixpath.relpath(new, posixpath.dirname(page) or '.')}{match.group(2)})"

        name_file = lambda match: f"`{match.group(2)}`" if match.group(1).strip("`") == match.group(2) else f"{match.group(1)} (`{match.group(2)}`)"
        text = OUTSIDE_LINK.sub(name_file, text)
        result, end = "", 0
        for fence in check_links.FENCE.finditer(text):
            result += LINK.sub(mend, text[end:fence.start()]) + fence.group(0)
            end = fence.end()
        return result + LINK.sub(mend, text[end:])

    def write(self, place, text):
        path = os.path.join(self.out, place)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)

    def copy_docs(self):
        docs = os.path.join(self.root, "docs")
        for folder, _, names in os.walk(docs):
            for name in names:
                place = os.path.relpath(os.path.join(folder, name), docs).replace(os.sep, "/")
                if name.endswith(".md"):
                    self.write(place, self.mend_links(place, check_links.read(os.path.join(folder, name))))
                elif name.endswith((".png", ".svg", ".css", ".csv")):
                    os.makedirs(os.path.dirname(os.path.join(self.out, place)), exist_ok=True)
                    shutil.copy(os.path.join(folder, name), os.path.join(self.out, place))

    def write_sources(self):
        for place in sorted(self.sources):
            path = os.path.join(self.root, place)
            if os.path.isdir(path):
                names = sorted(name for name in os.listdir(path) if os.path.splitext(name)[1] in LANGUAGES)
                text = "\n".join(f"- `{name}`" for name in names)
            else:
                words = check_links.read(path)
                if place.endswith(".ipynb"):
                    self.write(f"source/{place}.md", format_notebook(words))
                    continue
                text = words if place.endswith(".md") else f"```{LANGUAGES.get(os.path.splitext(place)[1], 'text')}\n{words}```"
            self.write(f"source/{place}.md", text if place.endswith(".md") else f"# {place}\n\n{text}\n")


def main():
    if len(sys.argv) < 2:
        print(__doc__)
        return 2
    out = sys.argv[1]
    root = sys.argv[2] if len(sys.argv) > 2 else os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    shutil.rmtree(out, ignore_errors=True)
    book = Book(out, root)
    book.copy_docs()
    book.write_sources()
    reference = os.path.join(out, "reference")
    return make_reference.make(reference, root) | make_python_reference.make(reference, root)


if __name__ == "__main__":
    sys.exit(main())
