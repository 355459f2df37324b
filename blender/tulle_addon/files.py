"""Files of the add-on. They lie in its own folder, whoever made what is there: names are checked, links are refused, and files are
written beside and then take the place of older ones."""
import contextlib
import json
import os
import re
import stat
from typing import Any, Dict, Iterator, List, Optional

SCENE_FILE, LINK_FILE, RUN_FOLDER, CACHE_FOLDER = "scene.yaml", "blender.json", "run", "cache"
BEFORE_FOLDER = "run.before"  # the run whose frames a bake from a frame keeps, until that has begun
MESH_FOLDER, MEND_FOLDER = "meshes", "mend"
ROLES = ("CLOTH", "BODY", "OBSTACLE", "MENDED")
JUNCTION = getattr(stat, "IO_REPARSE_TAG_MOUNT_POINT", 0)  # what Windows has beside symbolic links


class Refusal(Exception):
    """What cannot be done, in words for the artist; `objects` are the names of those that it is about."""

    def __init__(self, words: str, objects: Optional[List[str]] = None):
        super().__init__(words)
        self.objects = objects or []


def is_name(name: Any) -> bool:
    """Whether a name out of a file stays in its folder, as all names that the add-on and the program make."""
    return isinstance(name, str) and re.fullmatch(r"[A-Za-z0-9_-][A-Za-z0-9._-]*", name) is not None


def is_link(path: str) -> bool:
    try:
        facts = os.lstat(path)
    except OSError:
        return False
    return stat.S_ISLNK(facts.st_mode) or (JUNCTION != 0 and getattr(facts, "st_reparse_tag", 0) == JUNCTION)


def check_folder(folder: str) -> None:
    """Refuses a folder that is a link, or holds one, there or in a folder of the add-on: files would be written and removed elsewhere."""
    inside = [os.path.join(folder, name) for name in (RUN_FOLDER, BEFORE_FOLDER, CACHE_FOLDER, MESH_FOLDER, MEND_FOLDER)]
    for place in [folder] + inside:
        paths = [place] + [os.path.join(place, name) for name in sorted(os.listdir(place))] if os.path.isdir(place) else [place]
        for path in paths:
            if is_link(path):
                raise Refusal("%s is a link, and may lead out of the folder: remove it, or choose another Folder" % path)


def read_json(path: str) -> Optional[Dict[str, Any]]:
    """None: there is no such file, or it holds something else."""
    try:
        with open(path, encoding="utf-8") as file:
            read = json.load(file)
    except (OSError, ValueError, RecursionError):
        return None
    return read if isinstance(read, dict) else None


def read_links(folder: str) -> Optional[Dict[str, Any]]:
    """blender.json, which may come from others; None: there is none that can be read."""
    links = read_json(os.path.join(folder, LINK_FILE))
    if links is None or links.get("format") != "tulle blender":
        return None
    bodies, names = links.get("bodies"), set()
    for body in bodies if isinstance(bodies, list) else [None]:
        is_known = isinstance(body, dict) and isinstance(body.get("object"), str) and body.get("role") in ROLES
        if not is_known or not is_name(body.get("name")) or body["name"].lower() in names:
            name = body.get("name") if isinstance(body, dict) else None
            raise Refusal("%s names %r, which is no name of a body: export or bake anew" % (os.path.join(folder, LINK_FILE), name))
        names.add(body["name"].lower())
    return links


@contextlib.contextmanager
def replacing(path: str, mode: str = "", **options: Any) -> Iterator[Any]:
    """A file to write, which takes the place of an older one once it is whole."""
    beside = path + ".tmp"
    remove(beside)  # what is there may be a link
    try:
        with open(beside, "x" + mode, **options) as file:
            yield file
        os.replace(beside, path)
    except BaseException:
        remove(beside)
        raise


def remove(path: str) -> None:
    """Removes a file, or a link itself."""
    if os.path.lexists(path):
        os.remove(path)
