"""Makes the table, the arrays and the page from the runs that are there."""
from __future__ import annotations

import csv
import io
from typing import Any

from .arrays import make_arrays, read_frames
from .definition import OWN_COLUMNS
from .execute import CLEAN, Child, Failed, Stop, Stopped, make_picture
from .layout import SweepDirectory, get_temporary, read_json, write_text
from .page import make_page

OUTCOME = ("steps", "largest_stretch", "largest_stretch_time", "unconverged_steps", "worst_residual", "cut_steps", "rescues",
           "pinched_steps", "overstretched_steps", "largest_lag")
PARQUET_TYPES = {"run": int, "exit_code": int, "frames": int, "attempts": int, "wall_seconds": float, "steps": int,
                 "largest_stretch": float, "largest_stretch_time": float, "unconverged_steps": int, "worst_residual": float,
                 "cut_steps": int, "rescues": int, "pinched_steps": int, "overstretched_steps": int, "largest_lag": float}


def make_row(directory: SweepDirectory, record: dict[str, Any]) -> dict[str, Any]:
    """The row of a run: its parameters, then the table's own columns. Figures are those of run.json, where there is one."""
    number = record["number"]
    run = read_json(directory.get_run(number) / "run.json")
    run = run if isinstance(run, dict) else {}
    frames = read_frames(directory.get_run(number)) if run else []
    outcome = run.get("outcome") or {}
    row: dict[str, Any] = {"run": number, **record["values"]}
    row.update({name: outcome.get(name) for name in OUTCOME})
    row.update(state=record["seen_state"], verdict=record.get("verdict") if record["state"] == "whole" else None,
               exit_code=record.get("exit_code"), frames=len(frames) or None, state_hash=frames[-1][2] if frames else None,
               wall_seconds=record.get("wall_seconds"), attempts=record.get("attempts"),
               tulle_version=run.get("tulle_version"), scene_hash=run.get("scene_hash"), reason=record.get("reason"))
    return row


def make_table(directory: SweepDirectory) -> tuple[dict[str, Any], list[dict[str, Any]], list[str]]:
    """The resolved sweep, the rows and the names of the columns: run, parameters, the others."""
    sweep = directory.read_sweep()
    rows = [make_row(directory, record) for record in directory.read_records()]
    parameters = [one["name"] for one in sweep["parameters"]]
    return sweep, rows, ["run", *parameters, *OWN_COLUMNS[1:]]


def write_table(directory: SweepDirectory, rows: list[dict[str, Any]], columns: list[str]) -> None:
    """table.csv; numbers have the digits that read back to the same double, unknown figures are empty."""
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, lineterminator="\n", extrasaction="ignore")
    writer.writeheader()
    writer.writerows(rows)
    write_text(directory.table, text.getvalue())


def write_parquet(directory: SweepDirectory, rows: list[dict[str, Any]], columns: list[str]) -> bool:
    """table.parquet, where pyarrow is installed; parameters are texts, as they were set."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        return False
    types = {int: pyarrow.int64(), float: pyarrow.float64(), str: pyarrow.string()}
    schema = pyarrow.schema([(name, types[PARQUET_TYPES.get(name, str)]) for name in columns])
    data = {name: [None if row.get(name) is None else PARQUET_TYPES.get(name, str)(row[name]) for row in rows] for name in columns}
    path = directory.path / "table.parquet"
    temporary = get_temporary(path)
    try:
        pyarrow.parquet.write_table(pyarrow.table(data, schema=schema), temporary)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
    return True


def collect(directory: SweepDirectory, stop: Stop) -> list[str]:
    """Makes what is missing of pictures and arrays, then table and page anew. Returns what could not be made."""
    notes = []
    for record in directory.read_records():
        if record["seen_state"] != "whole" or stop.level:
            continue
        made = []
        try:
            if not directory.get_picture(record["number"]).exists():
                made.append(make_picture(Child(directory, record["number"], stop), record))
            made.append(make_arrays(directory, record))
        except (Failed, Stopped, OSError) as reason:
            made.append(str(reason))
        notes += [f"run {record['number']:04d}: {note}" for note in made if note]
    sweep, rows, columns = make_table(directory)
    write_table(directory, rows, columns)
    write_parquet(directory, rows, columns)
    write_text(directory.page, make_page(directory, sweep, rows))
    return notes + list_mixed_versions(rows)


def list_mixed_versions(rows: list[dict[str, Any]]) -> list[str]:
    """A warning where runs of different versions of the program stand in one table."""
    versions = sorted({row["tulle_version"] for row in rows if row["tulle_version"]})
    return [f"the runs are of different versions of tulle: {', '.join(versions)}; see the table"] if len(versions) > 1 else []


def count_states(rows: list[dict[str, Any]]) -> dict[str, int]:
    """How many runs are in each state, and how many whole ones the judge found intersections in."""
    counts: dict[str, int] = {}
    for row in rows:
        counts[row["state"]] = counts.get(row["state"], 0) + 1
    counts["intersecting"] = sum(row["state"] == "whole" and row["verdict"] != CLEAN for row in rows)
    return counts
