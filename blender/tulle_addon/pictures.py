"""Pictures of the fabrics, as the icons of their names."""
import os
from typing import List, Tuple

import bpy.utils.previews

FOLDER = os.path.join(os.path.dirname(__file__), "fabrics")

_loaded = None


def load_fabrics(fabrics: List[Tuple[str, str, str]]) -> List[Tuple[str, str, str, int, int]]:
    """Items of an enumeration, each with the icon of its picture; without one where the file is missing."""
    global _loaded
    release()
    _loaded = bpy.utils.previews.new()
    items = []
    for number, (name, title, words) in enumerate(fabrics):
        path = os.path.join(FOLDER, name + ".png")
        icon = _loaded.load(name, path, "IMAGE").icon_id if os.path.isfile(path) else 0
        items.append((name, title, words, icon, number))
    return items


def release() -> None:
    global _loaded
    if _loaded is not None:
        bpy.utils.previews.remove(_loaded)
        _loaded = None
