"""Lets every kind of system call of the program fail, at places spread over its whole work.

After each failure: the exit code is one of the documented ones; what failed is told on standard error; `tulle check` finds
whole, free frames; and the run goes on, without failures, to the state and the files of an undisturbed run. A call that is
merely interrupted or short changes nothing at all. TULLE_TEST_LONG=1 tries 100 places of each kind of call, else two.
"""

import errno
import os
import pathlib
import shutil
import subprocess
import sys

TULLE = os.environ["TULLE"]
LIBRARY = os.environ["FAILING_CALLS"]
SCENE = pathlib.Path(os.environ["TULLE_SOURCE_DIR"]) / "test/e2e/scenes/small.yaml"
PLACES = 100 if os.environ.get("TULLE_TEST_LONG") else 2  # of each kind of call
FAILED = {2, 3, 4}  # exit codes of what could not be done
TOLD = {"write", "pwrite", "fsync", "fdatasync", "syncfs", "ftruncate", "rename", "mkdir"}  # no such failure passes in silence

WAYS = {  # call: (how it fails, errno)
    "open": [("once", errno.EACCES), ("ever", errno.EMFILE)],
    "read": [("once", errno.EIO), ("once", errno.EINTR), ("short", 0)],
    "pread": [("once", errno.EIO), ("once", errno.EINTR), ("short", 0)],
    "write": [("once", errno.ENOSPC), ("ever", errno.EIO), ("once", errno.EINTR), ("short", 0)],
    "pwrite": [("once", errno.ENOSPC), ("ever", errno.EIO), ("once", errno.EINTR), ("short", 0)],
    "fsync": [("once", errno.EIO), ("ever", errno.EIO)],
    "fdatasync": [("once", errno.EIO)],
    "syncfs": [("once", errno.EIO)],
    "ftruncate": [("once", errno.EIO)],
    "rename": [("once", errno.EACCES), ("ever", errno.ENOSPC)],
    "mkdir": [("once", errno.EACCES)],
    "flock": [("once", errno.EWOULDBLOCK)],
    "unlink": [("once", errno.EACCES)],
    "unlinkat": [("once", errno.EACCES)],
    "rmdir": [("once", errno.EACCES)],
    "malloc": [("once", errno.ENOMEM), ("ever", errno.ENOMEM)],
    "calloc": [("once", errno.ENOMEM), ("ever", errno.ENOMEM)],
    "realloc": [("once", errno.ENOMEM)],
}
if os.environ.get("TULLE_COVERAGE"):
    del WAYS["malloc"]  # gcov calls it when the program ends, and crashes where it fails

faults = []
tried = 0


def call(*arguments, fail=None, counts=None):
    environment = dict(os.environ)
    if fail or counts:
        environment["LD_PRELOAD"] = LIBRARY
    if fail:
        environment["TULLE_FAIL"] = fail
    if counts:
        environment["TULLE_FAIL_COUNTS"] = str(counts)
    return subprocess.run([TULLE, *map(str, arguments)], env=environment, capture_output=True, text=True, timeout=120)


def count_calls(folder, *arguments):
    path = folder / "counts"
    path.unlink(missing_ok=True)
    done = call(*arguments, counts=path)
    if done.returncode != 0 or not path.is_file():
        sys.exit(f"{arguments}: exit {done.returncode}: {done.stderr}")
    return {name: int(number) for name, number in map(str.split, path.read_text().splitlines())}


def places(count):
    """Of 1 .. count: all, or some spread evenly, the first and the last among them."""
    if count <= PLACES:
        return list(range(1, count + 1))
    return sorted({1 + round(k * (count - 1) / max(PLACES - 1, 1)) for k in range(PLACES)})


def cases(counts, names=WAYS):
    turn = 0  # so that places differ between kinds of failure
    for name in names:
        for way, code in WAYS[name]:
            for place in places(counts.get(name, 0)):
                shifted = place if PLACES > 2 else 1 + (place - 1 + 7 * turn) % counts[name]
                turn += 1
                yield f"{name}:{shifted}:{way}:{code}", way == "short" or code == errno.EINTR


def fault(what, done=None):
    faults.append(what)
    print(f"fault: {what}")
    if done:
        print(f"  exit {done.returncode}\n  {done.stdout.strip()[-300:]}\n  {done.stderr.strip()[-300:]}")


def expect(done, what, is_harmless):
    """Judges the end of a command; returns whether it succeeded."""
    global tried
    tried += 1
    if done.returncode == 0:
        if not is_harmless and not done.stderr.strip() and what.split()[-1].split(":")[0] in TOLD:
            fault(f"{what}: nothing is said of it", done)
        return True
    if done.returncode not in FAILED:
        fault(f"{what}: an exit code that is not documented", done)
    elif is_harmless:
        fault(f"{what}: what is only short or interrupted should be tried again", done)
    elif not done.stderr.strip():
        fault(f"{what}: no message", done)
    return False


def judge(folder, what):
    if not (folder / "run.json").is_file():
        return
    if (folder / "checkpoint.previous.bin").exists() and not (folder / "checkpoint.bin").exists() and ":once:" in what:
        fault(f"{what}: the checkpoint before is the only one")
    done = call("check", folder)
    if done.returncode != 0 and "holds no whole frame yet" not in done.stderr:
        fault(f"{what}: check of what is left", done)


def same_run(folder, whole, what):
    for path in sorted(whole.rglob("*")):
        name = path.relative_to(whole)
        if path.is_file() and path.suffix in (".pc2", ".obj", ".vtp", ".pvd") or path.name in ("debug.bin", "frames.csv"):
            if not (folder / name).is_file() or (folder / name).read_bytes() != path.read_bytes():
                fault(f"{what}: {name} is another one than that of an undisturbed run")
                return


def try_runs(work):
    whole, folder = work / "whole", work / "run"
    options = ("--record", "debug", "--write", "vtp", "--progress", "none", "--checkpoint-every", "3", "--frames", "8", "--threads", "1")
    counts = count_calls(work, "run", SCENE, "-o", whole, *options)
    if sum(counts.values()) == 0:
        print("skipped: the program does not take a preloaded library")
        sys.exit(77)
    last = call("run", SCENE, "-o", whole, *options, "--resume").stdout.splitlines()[-1]
    part = work / "part"
    call("run", SCENE, "-o", part, *options, "--frames", "5")

    for mode, option, names in (("run", (), WAYS), ("resume", ("--resume",), WAYS), ("replace", ("--force",), ("rename", "unlink", "rmdir"))):
        if option:
            counting = work / "counting"
            shutil.rmtree(counting, ignore_errors=True)
            shutil.copytree(part, counting)
            counts = count_calls(work, "run", SCENE, "-o", counting, *options, *option)
        for fail, is_harmless in cases(counts, names):
            what = f"{mode} with {fail}"
            shutil.rmtree(folder, ignore_errors=True)
            if option:
                shutil.copytree(part, folder)
            done = call("run", SCENE, "-o", folder, *options, *option, fail=fail)
            if expect(done, what, is_harmless):
                if done.stdout.splitlines()[-1:] != [last]:
                    fault(f"{what}: another state", done)
            else:
                judge(folder, what)
                done = call("run", SCENE, "-o", folder, *options, "--resume")
                if done.returncode != 0 or done.stdout.splitlines()[-1:] != [last]:
                    fault(f"{what}: it does not go on to the same state", done)
            same_run(folder, whole, what)
            if any(path.name.endswith(".tmp") for path in folder.rglob("*")):
                fault(f"{what}: a temporary file is left")
    return whole


def try_files(work, whole):
    """Conversions, judgements and pictures: all or nothing."""
    render = ("render", whole, "-o", "sheet.png", "--size", "16x9", "--samples", "1", "--threads", "1", "--progress", "none")
    commands = [
        ("convert", whole / "sheet.obj", "sheet.ply"),
        ("convert", whole, "sheet.pc2"),
        ("check", whole, "--json"),
        ("info", whole),
        *([render] if call("render", "--help").returncode == 0 else []),
    ]
    for command in commands:
        outputs = work / "outputs"
        shutil.rmtree(outputs, ignore_errors=True)
        outputs.mkdir()
        arguments = [outputs / text if text in ("sheet.ply", "sheet.pc2", "sheet.png") else text for text in command]
        counts = count_calls(work, *arguments)
        wanted = {path.name: path.read_bytes() for path in outputs.iterdir()}
        told = call(*arguments).stdout
        for fail, is_harmless in cases(counts):
            shutil.rmtree(outputs)
            outputs.mkdir()
            what = f"{command[0]} with {fail}"
            done = call(*arguments, fail=fail)
            left = {path.name: path.read_bytes() for path in outputs.iterdir()}
            if expect(done, what, is_harmless):
                if left != wanted or (not wanted and done.stdout != told):
                    fault(f"{what}: another result", done)
            elif any(wanted.get(name) != text for name, text in left.items()):
                fault(f"{what}: half a file is left", done)


def main():
    work = pathlib.Path(sys.argv[1])
    whole = try_runs(work)
    try_files(work, whole)
    print(f"{tried} failures, {len(faults)} faults")
    sys.exit(1 if faults else 0)


main()
