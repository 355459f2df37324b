"""Finds the program `tulle` and runs it."""
import json
import os
import queue
import re
import signal
import stat
import subprocess
import threading
from typing import Any, Dict, List, Optional

import bpy

from .meshes import Refusal

FILE_NAME = "tulle.exe" if os.name == "nt" else "tulle"


class TullePreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    program: bpy.props.StringProperty(
        name="Program", subtype="FILE_PATH", description="The program tulle; empty: that of the add-on, or on PATH"
    )

    def draw(self, context):
        self.layout.prop(self, "program")
        try:
            self.layout.label(text="In use: " + find_program(), icon="CHECKMARK")
        except Refusal as refusal:
            self.layout.label(text=str(refusal), icon="ERROR")


def get_set_path() -> str:
    addon = bpy.context.preferences.addons.get(__package__)
    return bpy.path.abspath(addon.preferences.program) if addon and addon.preferences else ""


def find_program() -> str:
    """The path of the preferences, the program inside the add-on, or the one on PATH."""
    chosen = get_set_path()
    if chosen:
        if os.path.isfile(chosen) and os.access(chosen, os.X_OK):
            return os.path.abspath(chosen)
        raise Refusal("The program that the preferences of the add-on name, %s, is not there or cannot be run" % chosen)
    inside = os.path.join(os.path.dirname(__file__), "bin", FILE_NAME)
    if os.path.isfile(inside):
        if not os.access(inside, os.X_OK):  # Blender unpacks a zip without the right to run
            os.chmod(inside, os.stat(inside).st_mode | stat.S_IXUSR)
        return inside
    for folder in os.get_exec_path():  # not in the present folder, where Windows looks first
        path = os.path.join(folder, FILE_NAME)
        if os.path.isabs(folder) and os.path.isfile(path) and os.access(path, os.X_OK):
            return path
    raise Refusal(
        "The program tulle was not found. Set its path in Edit > Preferences > Add-ons > Tulle, "
        "or install the add-on's zip that holds it"
    )


def run_to_end(arguments: List[str], accepts=(0,)) -> str:
    """Standard output of a short run; other exit codes are a refusal in the program's words."""
    done = subprocess.run([find_program()] + arguments, capture_output=True, encoding="utf-8", errors="replace", check=False)
    if done.returncode not in accepts:
        raise Refusal(done.stderr.strip() or "tulle ended with code %d" % done.returncode)
    return done.stdout


class Process:
    """The program beside Blender. `poll` hands out what it said since the last call."""

    def __init__(self, arguments: List[str], folder: str):
        settings: Dict[str, Any] = (
            {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP} if os.name == "nt" else {"start_new_session": True}
        )
        self.words: List[str] = []  # for people
        self._lines: "queue.Queue[str]" = queue.Queue()
        self._process = subprocess.Popen(
            [find_program()] + arguments, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            encoding="utf-8", errors="replace", **settings,
        )  # fmt: skip
        self._readers = [
            threading.Thread(target=self._read, args=(pipe,), daemon=True)
            for pipe in (self._process.stdout, self._process.stderr)
        ]
        for reader in self._readers:
            reader.start()

    def _read(self, pipe) -> None:
        for line in pipe:
            line = line.rstrip("\n")
            is_trouble = line.startswith("trouble: ") and not line.startswith("trouble: none")
            if pipe is not self._process.stdout or is_trouble or line.startswith('{"'):  # the rest is for a terminal
                self._lines.put(line)
        pipe.close()

    def poll(self) -> List[Dict[str, Any]]:
        """Events since the last call; other lines are added to `words`."""
        events = []
        while True:
            try:
                line = self._lines.get_nowait()
            except queue.Empty:
                return events
            if line.startswith('{"'):
                events.append(json.loads(line))
            elif line:
                self.words.append(re.sub(r"^tulle \w+: ", "", line))

    def get_code(self) -> Optional[int]:
        """The exit code once the program has ended and all its lines are read."""
        code = self._process.poll()
        if code is None or any(reader.is_alive() for reader in self._readers):
            return None
        return code

    def interrupt(self) -> None:
        """A run undoes the step under way and writes a checkpoint; a second call ends it at once."""
        if self._process.poll() is None:
            self._process.send_signal(signal.CTRL_BREAK_EVENT if os.name == "nt" else signal.SIGINT)

    def wait(self, seconds: float) -> None:
        try:
            self._process.wait(seconds)
        except subprocess.TimeoutExpired:
            self._process.kill()


def register() -> None:
    bpy.utils.register_class(TullePreferences)


def unregister() -> None:
    bpy.utils.unregister_class(TullePreferences)
