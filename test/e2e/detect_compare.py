#!/usr/bin/env python3
"""Judges reports of `tulle detect`. usage: detect_compare.py JOBS

JOBS is a file with a job a line, its words set off by tabs; all are done at once, since starting Python takes long:
  sound TEXT JSON          the JSON document is sound in itself, and says what the text, with its list, says
  within A B               every event of the JSON document A with a list is one of B's
  values JSON KEY=VALUE... the document has these values; KEY as events.vertex_face, VALUE as JSON, or >NUMBER for a larger one,
                           or =FILE for the same as in another document
"""
import json
import re
import sys

STAGES = ["patches", "trees", "search", "traversal", "filter", "impact", "events", "total"]
STATES = ["hit", "touching_at_start", "unresolved"]
EVENT = re.compile(r"(vertex_face|edge_edge) (\S+) (\S+) (\S+) (hit|touching_at_start|unresolved)$")
faults = []


def require(condition, what):
    if not condition:
        faults.append(what)


def load(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def get_value(report, path):
    value = report
    for key in path.split("."):
        value = value[key]
    return json.dumps(value)


def as_key(event):
    """Kind and features, comparable."""
    features = tuple(tuple(f) if isinstance(f, list) else (f,) for f in event["features"])
    return (["vertex_face", "edge_edge"].index(event["kind"]),) + features


def check_sums(report):
    events, listed, counts = report["events"], report["list"], report["counts"]
    require(events["all"] == len(listed), "events.all is not the length of the list")
    for kind in ("vertex_face", "edge_edge"):
        require(events[kind] == sum(e["kind"] == kind for e in listed), f"events.{kind} is not what the list has")
    for state in STATES:
        require(events[state] == sum(e["state"] == state for e in listed), f"events.{state} is not what the list has")
    times = [e["time"] for e in listed]
    require(events["earliest_time"] == min(times, default=None), "events.earliest_time is not the list's")
    times = [e["time"] for e in listed if e["state"] != "touching_at_start"]
    require(events["earliest_hit_time"] == min(times, default=None), "events.earliest_hit_time is not the list's")
    require(all(0 <= e["time"] <= 1 for e in listed), "a time is not in [0, 1]")
    require(all(e["time"] == 0 for e in listed if e["state"] == "touching_at_start"), "a touching event has a time")
    keys = [as_key(e) for e in listed]
    require(keys == sorted(set(keys)), "the list is not sorted, or an event comes twice")
    require(all(f[0] < f[1] for key in keys if key[0] for f in key[1:]), "an edge has its larger vertex first")
    if not report["settings"]["earliest"]:
        require(counts["box_pairs"] >= counts["after_patches"] >= counts["after_filter"] >= counts["tested"],
                f"candidates grow: {counts}")
        require(counts["tested"] >= events["all"] or counts["after_filter"] >= events["all"],
                "more events than candidates")


def check_times(report):
    require(list(report["time_ms"]) == STAGES, "stages of time_ms")
    for stage, times in report["time_ms"].items():
        require(0 <= times["minimum"] <= times["median"] < 1e6, f"times of {stage}: {times}")
        require(report["settings"]["repeat"] or times["first"] == times["median"], f"times of one call of {stage}: {times}")


def check_text(report, path):
    with open(path, encoding="utf-8", errors="replace") as file:
        lines = file.read().splitlines()
    found = [EVENT.match(line) for line in lines]
    found = [m.groups() for m in found if m]
    require(len(found) == len(report["list"]), "the text lists another number of events")
    for (kind, first, second, time, state), event in zip(found, report["list"]):
        features = ["-".join(map(str, f)) if isinstance(f, list) else str(f) for f in event["features"]]
        require([kind, first, second, state, float(time)] ==
                [event["kind"], *features, event["state"], event["time"]], f"text and JSON differ in {event}")
    row = next(line.split() for line in lines if line.startswith("  all "))
    events = report["events"]
    require([int(n) for n in row[1:]] == [events["vertex_face"], events["edge_edge"], events["all"]], f"sums in the text: {row}")


def check_values(path, pairs):
    report = load(path)
    for key, wanted in (pair.split("=", 1) for pair in pairs):
        value = get_value(report, key)
        if wanted.startswith(">"):
            require(float(value) > float(wanted[1:]), f"{key} is {value}, not {wanted}")
        elif wanted.startswith("="):
            require(value == get_value(load(wanted[1:]), key), f"{key} is {value}, not as in {wanted[1:]}")
        else:
            require(value == wanted, f"{key} is {value}, not {wanted}")


def do_job(words):
    if words[0] == "sound":
        report = load(words[2])
        require(report["format"] == "tulle detect" and report["format_version"] == 1, "format")
        check_sums(report)
        check_times(report)
        check_text(report, words[1])
    elif words[0] == "within":
        first, second = [{as_key(e) for e in load(path)["list"]} for path in words[1:]]
        require(first <= second, f"{len(first - second)} events are missing, as {min(first - second, default=None)}")
    elif words[0] == "values":
        check_values(words[1], words[2:])
    else:
        sys.exit(__doc__)


def main():
    fault_count = job_count = 0
    with open(sys.argv[1], encoding="utf-8", errors="surrogateescape") as jobs:
        for line in jobs:
            faults.clear()
            try:
                do_job(line.rstrip("\n").split("\t"))
            except (OSError, ValueError, KeyError, StopIteration) as error:
                faults.append(f"{type(error).__name__}: {error}")
            job_count += 1
            fault_count += bool(faults)
            for fault in faults:
                print(f"fault: {ascii(line.rstrip())}: {fault}")
    print(f"{job_count} comparisons")
    sys.exit(1 if fault_count or not job_count else 0)


main()
