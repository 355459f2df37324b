"""What tests know of the files of a run: docs/guide/run_directory.md."""

TIMES = {"run.json", "report.csv", "checksums.csv", "checkpoint.bin", "checkpoint.previous.bin"}  # hold times, or hashes of some


class Fault(Exception):
    pass


def read_files(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def drop_times(report):
    """Of report.csv: the lines without the columns of seconds."""
    lines = [line.split(b",") for line in report.splitlines()]
    kept = [column for column, name in enumerate(lines[0]) if not name.endswith(b"_seconds")]
    return [[line[column] for column in kept] for line in lines]


def compare(folder, whole):
    """The files are those of an undisturbed run, but for times, and no others are there."""
    files = read_files(folder)
    names = set(files) ^ set(whole)
    if names - {"checkpoint.previous.bin"}:
        raise Fault(f"files that only one of this and an undisturbed run has: {sorted(names)}")
    for name in set(whole) - TIMES:
        if files[name] != whole[name]:
            raise Fault(f"{name} is another one than that of an undisturbed run")
    if drop_times(files["report.csv"]) != drop_times(whole["report.csv"]):
        raise Fault("report.csv differs in more than times")
