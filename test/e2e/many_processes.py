"""Many processes at one run directory: they write, go on, replace, judge, tell, draw and convert in random order, and some are killed.

- One process at a time writes; others are told that the folder is locked, or that there is a run already: exit code 2.
- A reader gives what an undisturbed run holds, for the first so many frames; or exit code 2 and one of the messages below.
- At the end `--resume` makes the files of an undisturbed run, and no others are there.
TULLE_TEST_LONG=1: hundreds of rounds. TULLE_TEST_SEED repeats one choice of processes and moments.
"""

import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import time

from run_files import Fault, compare, read_files

TULLE = os.environ["TULLE"]
SCENE = pathlib.Path(os.environ["TULLE_SOURCE_DIR"]) / "test/e2e/scenes/tiny.yaml"
IS_LONG = os.environ.get("TULLE_TEST_LONG") == "1"
SEED = int(os.environ.get("TULLE_TEST_SEED", random.randrange(1 << 30)))
ROUNDS, WAVES, PROCESSES = (400 if IS_LONG else 6), 2, 6
SPREAD = 0.08  # [s] within which the processes of a wave start; about a run's time
SHORT, LONG = 20, 40  # frames
LEAST_JUDGED = 0.2  # of the readers; the others were refused
TIMEOUT = 120  # [s] a process that takes longer hangs
OPTIONS = ("--threads", "1", "--checkpoint-every", "7", "--progress", "none", "--record", "debug", "--write", "vtp")
LOCKED = "is locked: another process is writing a run here"
REFUSALS = {  # what may be said of a directory that others write to
    "run": (LOCKED, "another process removed the checkpoint while the scene was loaded"),
    "create": (LOCKED, "holds a run already"),
    "read": ("No such file or directory", "holds no run.json", "goes with the directory of a run alone",
             "holds no whole frame yet", "does not exist; ", "is a directory, not a file", "another process changed the run while it was read"),
}


def make_commands():
    """Name: (arguments, kind of refusals, judge of the output or None)."""
    frame, body = "3", ("--body", "sheet")
    return {
        "create": (["run", SCENE, "-o", "run", *OPTIONS, "--set", f"time.frames={LONG}"], "create", None),
        "resume": (["run", SCENE, "-o", "run", *OPTIONS, "--set", f"time.frames={LONG}", "--resume"], "run", None),
        "resume short": (["run", SCENE, "-o", "run", *OPTIONS, "--set", f"time.frames={SHORT}", "--resume"], "run", None),
        "replace": (["run", SCENE, "-o", "run", *OPTIONS, "--set", f"time.frames={SHORT}", "--force"], "run", None),
        "check": (["check", "run", "--json", "--threads", "1"], "read", judge_check),
        "info": (["info", "run"], "read", judge_info),
        "convert": (["convert", "run", "OUTPUT.pc2", *body], "read", judge_cache),
        "convert frame": (["convert", "run", "OUTPUT.ply", *body, "--frame", frame], "read", judge_file),
        "render": (["render", "run", "-o", "OUTPUT.png", "--frame", frame, "--size", "16x12", "--samples", "1", "--threads", "1"],
                   "read", judge_file),
    }


# Judges of what a reader that succeeded gave; `whole` is the same of the undisturbed run: (standard output, bytes of its file).


def judge_check(text, _, whole):
    *frames, summary = text.splitlines()
    if frames != whole[0].splitlines()[:len(frames)] or f'"frames":{len(frames)},' not in summary or len(frames) == 0:
        raise Fault(f"it judges otherwise: {text[-300:]}")


def judge_info(text, _, whole):
    hashes = whole[2]
    count = int(re.search(r"frames +(\d+) of", text)[1])
    last = re.search(r"state hash (\w+)", text)
    if (last is None and count > 0) or (last and last[1] != hashes[count - 1]) or "as the run wrote them" not in text:
        raise Fault(f"it tells otherwise: {text[-800:]}")


def judge_cache(_, content, whole):
    frame_count = int.from_bytes(content[28:32], "little")
    if content[:28] != whole[1][:28] or content[32:] != whole[1][32:len(content)] or frame_count * (len(whole[1]) - 32) != (LONG + 1) * (
            len(content) - 32):
        raise Fault("the cache is no beginning of the undisturbed one")


def judge_file(_, content, whole):
    if content != whole[1]:
        raise Fault("the file is another one")


class Process:
    def __init__(self, work, name, command, number, stop):
        """stop: None, or (signal, seconds after the start)."""
        self.name, self.number, self.stop = name, number, stop
        words, self.kind, self.judge = command
        self.words = [str(word).replace("OUTPUT", f"output{number}") for word in words]
        self.output = next((work / word for word in self.words if word.startswith("output")), None)
        self.texts = work / f"{number}.out", work / f"{number}.err"
        with open(self.texts[0], "w") as out, open(self.texts[1], "w") as err:
            self.process = subprocess.Popen([TULLE, *self.words], cwd=work, stdout=out, stderr=err)

    def kill(self):
        self.process.send_signal(self.stop[0])

    def end(self, whole):
        """Waits for it and judges it. Returns what became of it, in a word."""
        try:
            code = self.process.wait(TIMEOUT)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise Fault("it hangs")
        text, errors = (path.read_text() for path in self.texts)
        if self.stop and code in (-self.stop[0], 130):
            return "killed"
        if code == 2 and any(words in errors for words in REFUSALS[self.kind]):
            return "locked" if LOCKED in errors else "refused"
        if code != 0:
            raise Fault(f"exit {code}: {errors[-400:]} {text[-200:]}")
        if self.judge:
            self.judge(text, self.output.read_bytes() if self.output else b"", whole[self.name])
        return "done"


class Test:
    def __init__(self, work):
        self.work, self.dice, self.number, self.faults = work, random.Random(SEED), 0, 0
        self.ends = {"done": 0, "killed": 0, "locked": 0, "refused": 0}
        self.readers = self.judged = 0  # that were let end; that gave something to judge
        self.commands = make_commands()
        first = Process(work, "create", self.commands["create"], 0, None)
        first.end({})
        self.files = read_files(work / "run")
        hashes = [line.split(",")[3] for line in self.files["frames.csv"].decode().splitlines()[1:]]
        self.whole = {}
        for name, command in list(self.commands.items()):
            if command[2]:
                reader = Process(work, name, command, 0, None)
                code = reader.process.wait()
                if code != 0 and name == "render" and "Embree" in reader.texts[1].read_text():
                    del self.commands[name]
                elif code != 0:
                    sys.exit(f"{name}: exit {code}: {reader.texts[1].read_text()}")
                else:
                    self.whole[name] = reader.texts[0].read_text(), reader.output.read_bytes() if reader.output else b"", hashes

    def tell(self, what, fault):
        self.faults += 1
        print(f"fault: seed {SEED}, {what}: {fault}")

    def run_wave(self, what):
        dice, events, processes = self.dice, [], []
        for _ in range(PROCESSES):
            begin = dice.uniform(0, SPREAD)
            name = dice.choice(list(self.commands))
            stop = (dice.choice((signal.SIGKILL, signal.SIGINT)), dice.uniform(0, SPREAD)) if dice.random() < 0.4 else None
            self.number += 1
            events.append((begin, self.number, name, stop))
            if stop:
                events.append((begin + stop[1], self.number, None, None))
        clock = time.monotonic()
        for moment, number, name, stop in sorted(events, key=lambda event: event[:2]):
            time.sleep(max(0.0, clock + moment - time.monotonic()))
            if name:
                processes.append(Process(self.work, name, self.commands[name], number, stop))
            else:
                next(process for process in processes if process.number == number).kill()
        for process in processes:
            try:
                end = process.end(self.whole)
                self.ends[end] += 1
                self.readers += process.judge is not None and end != "killed"
                self.judged += process.judge is not None and end == "done"
            except Fault as fault:
                self.tell(f"{what}, {process.name} among {[other.name for other in processes]}", fault)
        return processes

    def run_round(self, number):
        shutil.rmtree(self.work / "run", ignore_errors=True)
        for wave in range(WAVES):
            for process in self.run_wave(f"round {number}, wave {wave}"):
                for path in self.work.glob(f"output{process.number}.*"):
                    path.unlink()
                for path in process.texts:
                    path.unlink()
        try:
            Process(self.work, "resume", self.commands["resume"], 0, None).end(self.whole)
            compare(self.work / "run", self.files)
            Process(self.work, "check", self.commands["check"], 0, None).end(self.whole)
        except Fault as fault:
            self.tell(f"round {number}, resumed at the end", fault)


def main():
    test = Test(pathlib.Path(sys.argv[1]))
    for number in range(ROUNDS):
        test.run_round(number)
    print(f"seed {SEED}, {ROUNDS} rounds, {test.number} processes: " + ", ".join(f"{count} {end}" for end, count in test.ends.items()) +
          f"; {test.judged} of {test.readers} readers gave something; {test.faults} faults")
    if test.judged < max(1, LEAST_JUDGED * test.readers):
        sys.exit("fault: too few readers gave something")
    sys.exit(1 if test.faults else 0)


main()
