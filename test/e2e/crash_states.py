"""What a power failure may leave of a folder, by the calls that changed it (a log of failing_calls.c).

A file system promises little of what was not flushed. Of a file whose blocks (512 or 4096 bytes) were written, each is as it was
at any moment since the last flush of the file, independently of the others. So is the size, and bytes that are within it and
were never written are zero. A new, renamed or removed name that came after the last flush of its folder is kept or lost,
independently of others; one rename is kept or lost as a whole. A flush of a file does not flush its name.
"""

import hashlib
import os


class File:
    def __init__(self, content=b""):
        self.contents = [content]  # as flushed, then after each change since

    def now(self):
        return self.contents[-1]

    def change(self, content):
        self.contents.append(content)

    def flush(self):
        self.contents = [self.contents[-1]]

    def draw(self, random):
        """Its bytes after a failure."""
        if len(self.contents) == 1:
            return self.contents[0]
        block = random.choice((512, 4096))
        size = len(random.choice(self.contents))
        certain = random.choice((0.0, 0.5, 1.0))  # so that whole files are old or new in many states
        first = random.choice(self.contents)
        pieces = []
        for begin in range(0, size, block):
            content = first if random.random() < certain else random.choice(self.contents)
            end = min(begin + block, size)
            pieces.append(content[begin:end].ljust(end - begin, b"\0"))
        return b"".join(pieces)


class Folder:
    def __init__(self):
        self.flushed = {}  # name: File or Folder
        self.changes = []  # since the last flush: (name that goes or None, name that comes or None, its node)
        self.names = {}

    @staticmethod
    def apply(names, change):
        goes, comes, node = change
        if names.get(goes) is node:
            del names[goes]
        if comes is not None:
            names[comes] = node

    def change(self, goes, comes, node):
        self.changes.append((goes, comes, node))
        self.apply(self.names, self.changes[-1])

    def flush(self):
        self.flushed = dict(self.names)
        self.changes = []

    def draw(self, random):
        names = dict(self.flushed)
        kept = random.choice((0.0, 0.3, 0.7, 1.0))
        for change in self.changes:
            if random.random() < kept:
                self.apply(names, change)
        return names


class Disk:
    """A folder, `root`, which at the start is as on the disk and flushed; then calls change it."""

    def __init__(self, root):
        self.root = str(root)
        self.nodes = {}  # inode: File or Folder
        self.top = self._load(self.root)

    def _load(self, path):
        node = Folder() if os.path.isdir(path) else File(open(path, "rb").read())
        self.nodes[os.stat(path).st_ino] = node
        if isinstance(node, Folder):
            node.names = {name: self._load(os.path.join(path, name)) for name in os.listdir(path)}
            node.flush()
        return node

    def _find(self, path):
        """The folder that holds the path, and the name there; None outside of the root."""
        if not path.startswith(self.root + "/"):
            return None, None
        folder = self.top
        *folders, name = path[len(self.root) + 1:].replace("/./", "/").split("/")
        for part in folders:
            folder = folder.names[part]
        return folder, name

    def call(self, line, forgotten=()):
        """Makes a logged call. Forgotten are calls that flush nothing: fsync, fdatasync, syncfs, folder (fsync of one)."""
        name, *words = line.split(" ")
        is_folder = name == "fsync" and isinstance(self.nodes.get(int(words[0])), Folder)
        if ("folder" if is_folder else name) in forgotten:
            return
        getattr(self, "_" + name, lambda *_: None)(*words)

    def _open(self, inode, flags, path):
        if path == self.root:
            self.nodes[int(inode)] = self.top
        folder, name = self._find(path)
        if folder is None:
            return
        if flags[0] == "c" and name not in folder.names:
            folder.change(None, name, File())
        node = folder.names[name]
        self.nodes[int(inode)] = node
        if flags[1] == "t" and node.now():
            node.change(b"")

    def _write(self, inode, offset, digits=""):
        node, at, data = self.nodes.get(int(inode)), int(offset), bytes.fromhex(digits)
        if node is not None:
            content = node.now().ljust(at, b"\0")
            node.change(content[:at] + data + content[at + len(data):])

    def _ftruncate(self, inode, size):
        node = self.nodes[int(inode)]
        node.change(node.now()[:int(size)].ljust(int(size), b"\0"))

    def _fsync(self, inode):
        if int(inode) in self.nodes:
            self.nodes[int(inode)].flush()

    _fdatasync = _fsync

    def _syncfs(self, *_):
        folders = [self.top]
        while folders:
            folder = folders.pop()
            folder.flush()
            for node in folder.names.values():
                node.flush()
                if isinstance(node, Folder):
                    folders.append(node)

    def _rename(self, source, target):
        folder, name = self._find(source)
        if folder is not None:
            folder.change(name, self._find(target)[1], folder.names[name])

    def _unlink(self, path):
        folder, name = self._find(path)
        if folder is not None:
            folder.change(name, None, folder.names[name])

    _rmdir = _unlink

    def _mkdir(self, path):
        folder, name = self._find(path)
        if folder is not None:
            folder.change(None, name, Folder())

    def draw(self, random):
        """What a failure now may leave: {path: bytes, or None of a folder}."""
        return self._gather(lambda folder: folder.draw(random), lambda file: file.draw(random))

    def get_all(self):
        """The same if nothing is lost."""
        return self._gather(lambda folder: folder.names, File.now)

    def get_flushed(self):
        """The same if all is lost that may be."""
        return self._gather(lambda folder: folder.flushed, lambda file: file.contents[0])

    def _gather(self, get_names, get_bytes):
        state, folders = {}, [("", self.top)]
        while folders:
            prefix, folder = folders.pop()
            for name, node in get_names(folder).items():
                is_folder = isinstance(node, Folder)
                state[prefix + name] = None if is_folder else get_bytes(node)
                if is_folder:
                    folders.append((prefix + name + "/", node))
        return state


def name_state(state):
    """A key that is the same for the same state."""
    digest = hashlib.sha256()
    for path in sorted(state):
        content = state[path]
        digest.update(path.encode() + b"\0" + (b"folder" if content is None else hashlib.sha256(content).digest()))
    return digest.digest()


def put_state(state, root):
    """Makes the folder `root` hold the state and nothing else; root should not be there."""
    os.mkdir(root)
    for path in sorted(state):
        if state[path] is None:
            os.mkdir(os.path.join(root, path))
        else:
            with open(os.path.join(root, path), "wb") as file:
                file.write(state[path])
