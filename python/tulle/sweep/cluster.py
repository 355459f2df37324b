"""What engines have in common whose runs happen in processes elsewhere: how these are called, and what they leave."""
from __future__ import annotations

import sys
from typing import Any

from .layout import SweepDirectory
from .program import get_package_path


def get_command(directory: SweepDirectory) -> list[str]:
    """The command of one run, to which its number is added. It finds this package wherever the folder is seen."""
    return ["env", f"PYTHONPATH={get_package_path()}", sys.executable, "-m", "tulle.sweep", "execute", str(directory.path),
            str(directory.program)]


def close_record(directory: SweepDirectory, number: int, reason: str, last_lines: list[str]) -> dict[str, Any]:
    """The record of a run whose process has ended; one that did not end in good order is noted as interrupted."""
    record = directory.read_record(number)
    if record is None:
        record = {"number": number, "state": "lost"}
    if record["state"] in ("waiting", "running"):
        record.update(state="interrupted", reason=reason, last_lines=last_lines)
        directory.write_record(record)
    return record
