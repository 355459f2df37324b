"""Cuts the power of runs, resumes, replacements and conversions at every moment, on paper.

The calls of the program are logged (failing_calls.c). At each prefix of the log, crash_states.py makes states that a failure there
could leave. Of each state:
- `tulle check` and `tulle info` take only frames whose bytes are those of an undisturbed run, else they name what is damaged.
- `tulle run --resume` ends with the files of an undisturbed run. It goes on at least from the last checkpoint that was told of.
- What a conversion wrote is whole, and there if the conversion had ended.

With flushes taken out of a log there must be faults: the test can see them. In the long form each kind of flush is taken out alone.
TULLE_TEST_LONG=1: every prefix, with many draws; else some that a seed chooses (TULLE_TEST_SEED).
"""

import copy
import json
import os
import pathlib
import random
import re
import shutil
import subprocess
import sys

import crash_states
from run_files import Fault, compare, read_files

TULLE = os.environ["TULLE"]
LIBRARY = os.environ["FAILING_CALLS"]
SCENE = pathlib.Path(os.environ["TULLE_SOURCE_DIR"]) / "test/e2e/scenes/tiny.yaml"
IS_LONG = os.environ.get("TULLE_TEST_LONG") == "1"
SEED = int(os.environ.get("TULLE_TEST_SEED", random.randrange(1 << 30)))
DRAWS = 6 if IS_LONG else 1  # of each prefix
MOMENTS = None if IS_LONG else 3  # of each scenario; None: all
FLUSHES = ("fsync", "fdatasync", "syncfs", "folder")
COMMON = ("--threads", "1", "--checkpoint-every", "3")
ALL = ("--record", "debug", "--write", "vtp")

counts = {"prefixes": 0, "states": 0, "resumed": 0, "whole or absent": 0}


def call(*arguments, log=None):
    environment, errors = dict(os.environ), subprocess.PIPE
    if log:
        environment.update(LD_PRELOAD=LIBRARY, TULLE_CALLS_LOG=str(log))
        errors = open(log, "a")
    done = subprocess.run([TULLE, *map(str, arguments)], env=environment, stdout=subprocess.PIPE, stderr=errors, text=True, timeout=120)
    if log:
        errors.close()
        if done.returncode != 0:
            sys.exit(f"{arguments}: exit {done.returncode}: {log.read_text()[-500:]}")
    return done


def run(folder, *options, log=None, scene=SCENE):
    return call("run", scene, "-o", folder, *COMMON, "--progress", "json", *options, log=log)


def expect_refusal(done, folder, advice):
    """Exit 2 with a message that names the folder or one of its files, and has one of the words of advice."""
    if done.returncode != 2 or str(folder) not in done.stderr:
        raise Fault(f"exit {done.returncode}: {done.stderr[-400:]}")
    if not any(word in done.stderr for word in advice):
        raise Fault(f"it does not say what to do: {done.stderr[-400:]}")


def compare_frames(folder, whole, frame_count):
    """All that is of the first frames is as in an undisturbed run."""
    for line in whole["checksums.csv"].decode().splitlines()[1:]:
        name, frame, begin, end, *_ = line.split(",")
        if not frame or int(frame) >= frame_count or name == "report.csv":
            continue
        with open(folder / name, "rb") as file:
            file.seek(int(begin))
            if file.read(int(end) - int(begin)) != whole[name][int(begin):int(end)]:
                raise Fault(f"{name}: frame {frame} has wrong bytes, which nobody told of")


def judge_readers(folder, whole, is_ended):
    """What `tulle check` and `tulle info` accept is right."""
    done = call("check", folder, "--json", "--threads", "1")
    if done.returncode == 0:
        compare_frames(folder, whole, json.loads(done.stdout.splitlines()[-1])["frames"])
    else:
        expect_refusal(done, folder, ("--resume", "holds no run.json", "holds no whole frame"))
    done = call("info", folder)
    if done.returncode == 0:
        compare_frames(folder, whole, int(re.search(r"frames +(\d+) of", done.stdout)[1]))
    else:
        expect_refusal(done, folder, ("--resume", "holds no run.json"))
    if is_ended and (done.returncode != 0 or ": run, finished" not in done.stdout):
        raise Fault("the run had ended, but is not finished")


def judge_run(scenario, told):
    """told: the steps of the newest checkpoint that was told of; -1: none; True: the run has ended."""
    folder = scenario.root / "run"
    if folder.is_dir() and any(folder.iterdir()):
        judge_readers(folder, scenario.wholes[-1], told is True)
    done = run(folder, *scenario.options, "--resume")
    if done.returncode != 0:
        raise Fault(f"it does not go on, exit {done.returncode}: {done.stderr[-400:]}")
    begin = json.loads(next(line for line in done.stderr.splitlines() if line.startswith('{"event":"begin"')))
    wanted = begin["steps"] if told is True else told
    if (begin["step"] if begin["goes_on"] else -1) < wanted:
        raise Fault(f"the checkpoint of step {wanted} was told of, but is lost: {begin}")
    compare(folder, scenario.wholes[-1])
    done = call("check", folder, "--threads", "1")
    if done.returncode != 0:
        raise Fault(f"resumed, but tulle check says: {done.stderr}")
    return "resumed"


def judge_file(scenario, told):
    """A file is whole or not there."""
    path = scenario.root / "sheet.pc2"
    if path.exists() and path.read_bytes() not in scenario.wholes:
        raise Fault(f"{path.name} is half a file")
    if told is True and (not path.exists() or path.read_bytes() != scenario.wholes[-1]):
        raise Fault(f"{path.name} is not there, but the conversion had ended")
    return "whole or absent"


class Scenario:
    """A command, logged; what may be left of its folder; and who judges that."""

    def __init__(self, work, name, judge, wholes, options=(), told=-1):
        self.name, self.judge, self.wholes, self.options, self.told = name, judge, wholes, options, told
        self.live = work / "live"  # the folder that the command works in
        self.root = work / "disk"  # the same after a failure
        shutil.rmtree(self.live, ignore_errors=True)
        self.live.mkdir()

    def record(self, command, *arguments, **more):
        self.disk = crash_states.Disk(self.live)
        log = self.live.parent / "log"
        log.unlink(missing_ok=True)
        command(*arguments, log=log, **more)
        self.lines = log.read_text().splitlines()
        return self

    def crash(self, moment_count=None, forgotten=()):
        """Replays the log and judges what failures leave, at all moments or some; returns how many states are faulty. Where flushes
        are forgotten, it ends with the first."""
        dice, disk, told, seen, faults = random.Random(f"{SEED} {self.name}"), copy.deepcopy(self.disk), self.told, set(), 0
        moments = range(len(self.lines) + 1)
        chosen = moments if moment_count is None else dice.sample(moments, min(moment_count, len(moments)))
        for moment in moments:
            line = self.lines[moment - 1] if moment > 0 else ""
            if line.startswith("{"):
                event = json.loads(line)
                told = event["step"] if event["event"] == "checkpoint" else told
            elif line:
                disk.call(line, forgotten)
            if moment not in chosen:
                continue
            counts["prefixes"] += not forgotten
            told = True if moment == len(self.lines) else told
            plain = [disk.get_all(), disk.get_flushed()]
            for state in (*(plain if IS_LONG else dice.sample(plain, 1)), *(disk.draw(dice) for _ in range(DRAWS))):
                key = (crash_states.name_state(state), told)
                if key in seen:
                    continue
                seen.add(key)
                shutil.rmtree(self.root, ignore_errors=True)
                crash_states.put_state(state, self.root)
                try:
                    counts[self.judge(self, told)] += not forgotten
                except Fault as fault:
                    faults += 1
                    if forgotten:
                        return faults
                    print(f"fault: {self.name}, seed {SEED}, {moment} of {len(self.lines)} lines, state {len(seen)}: {fault}")
        counts["states"] += 0 if forgotten else len(seen)
        return faults


def make_scenarios(work):
    """Of each: a new run, one that goes on, one that gets longer, one that is replaced; then a conversion."""
    for kind, options in (("plain", ()), ("all files", ALL)):
        short, longer = work / "short", work / "longer"
        for folder, frames in ((short, 3), (longer, 4)):
            shutil.rmtree(folder, ignore_errors=True)
            run(folder, *options, "--frames", frames)
        wholes = [read_files(short), read_files(longer)]
        options = (*options, "--frames", "4")

        def make(name, **more):
            return Scenario(work, f"{name}, {kind}", judge_run, wholes, options, **more)

        scenario = make("a new run")
        yield scenario.record(run, scenario.live / "run", *options)
        half = copy.deepcopy(scenario.disk)
        cut = next(i for i, line in enumerate(scenario.lines) if '"step":5,' in line)
        for line in scenario.lines[:cut]:
            if not line.startswith("{"):
                half.call(line)

        scenario = make("a run that goes on after a failure", told=3)
        scenario.live.rmdir()
        crash_states.put_state(half.draw(random.Random(f"{SEED} {kind}")), scenario.live)
        yield scenario.record(run, scenario.live / "run", *options, "--resume")

        scenario = make("a run that gets longer", told=6)
        shutil.copytree(short, scenario.live / "run")
        yield scenario.record(run, scenario.live / "run", *options, "--resume")

        scenario = make("a run whose checkpoint is damaged", told=3)
        shutil.copytree(short, scenario.live / "run")
        (scenario.live / "run/checkpoint.bin").write_bytes(b"damaged")
        yield scenario.record(run, scenario.live / "run", *options, "--resume")

        scenario = make("a run that is replaced")
        shutil.copytree(short, scenario.live / "run")
        yield scenario.record(run, scenario.live / "run", *options, "--force")

    scenario = Scenario(work, "a conversion", judge_file, [])
    call("convert", longer, work / "whole.pc2", "--body", "sheet")
    (scenario.live / "sheet.pc2").write_bytes(b"before")
    scenario.wholes = [b"before", (work / "whole.pc2").read_bytes()]
    yield scenario.record(call, "convert", longer, scenario.live / "sheet.pc2", "--body", "sheet")


def main():
    work = pathlib.Path(sys.argv[1])
    print(f"seed {SEED}")
    faults = 0
    for scenario in make_scenarios(work):
        faults += scenario.crash(MOMENTS)
        calls = {line.split()[0] for line in scenario.lines}
        flushes = [name for name in FLUSHES if name in calls or name == "folder"]
        for forgotten in [[name] for name in flushes] if IS_LONG else [flushes]:
            if not scenario.crash(None, forgotten):
                print(f"fault: {scenario.name}, seed {SEED}: nothing is seen without {forgotten}")
                faults += 1
    print(", ".join(f"{number} {what}" for what, number in counts.items()) + f", {faults} faults")
    sys.exit(1 if faults else 0)


main()
