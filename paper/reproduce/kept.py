"""Rows that are measured one by one and kept in a file, so that work that was cut off goes on where it was.

The file begins with a head that tells under what the rows were made; rows under another head are never given again.
The file is always whole: it is replaced under a temporary name, every few seconds and when asked.
"""
from __future__ import annotations

import time
from pathlib import Path

from reproduce.session import write_whole

SAVE_INTERVAL = 5.0  # [s] what a killed session loses at most


class Kept:
    """Rows of a table in a file. A row's key are its first `key_columns` columns; the last row of a key counts."""

    def __init__(self, path: Path, head: str, key_columns: int) -> None:
        """Reads the rows of the file if it is there and has this head, lines that end with a line feed."""
        self.path = path
        self.head = head
        self.key_columns = key_columns
        self.rows: list[str] = []  # without their line feeds
        self._index: dict[str, int] = {}
        self._saved = time.monotonic()
        self._is_changed = False
        try:
            text = path.read_bytes().decode()
        except (OSError, UnicodeDecodeError):
            return  # not there, or none of ours
        if text.startswith(head) and text.endswith("\n") and "\0" not in text:
            for row in text[len(head):].split("\n")[:-1]:
                self._append(row)

    def _append(self, row: str) -> None:
        self._index[",".join(row.split(",")[:self.key_columns])] = len(self.rows)
        self.rows.append(row)

    def find(self, key: str) -> str | None:
        """What follows the key and its comma in the row that begins with it; None: there is none."""
        index = self._index.get(key)
        return None if index is None else self.rows[index][len(key) + 1:]

    def add(self, row: str) -> None:
        """Adds a row. Saves when that was not done for some seconds."""
        self._append(row)
        self._is_changed = True
        if time.monotonic() - self._saved > SAVE_INTERVAL:
            self.save()

    def forget(self) -> None:
        """Drops all rows."""
        self._is_changed |= bool(self.rows)
        self.rows.clear()
        self._index.clear()

    def save(self) -> None:
        """Writes the file, if it is to change."""
        if self._is_changed:
            write_whole(self.path, self.head + "".join(row + "\n" for row in self.rows))
        self._is_changed = False
        self._saved = time.monotonic()
