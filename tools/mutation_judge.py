"""Where mutants are built and judged: a copy of the tree, its tests with their limits of time, and the order of the tests.

Used by tools/mutate.py.
"""
import csv
import glob
import hashlib
import json
import os
import re
import resource
import signal
import subprocess
import sys
import time
from collections import namedtuple

from mutation_operators import apply_mutant

# Of 300 mutants, how many fall on a folder; and which tests of others judge it, too.
FOLDERS = {
    "contact": (80, r"(step|world)\."),
    "detect": (70, r"api\.arguments|world\.(queries|query_state|filters|values)"),
    "step": (50, r"world\."),
    "world": (30, r"step\.|api\.(world|query|live|objects|bodies|events|attach)_arguments|scene\.build_world"),
    "dynamics": (30, r"(step|world)\."),
    "io": (40, r"api\.(io|run|record|animation)_arguments|e2e\.run_(far_away|left|without_cloth|input|messages|damage|trouble|interrupted_start|locked)"),
}
# Whole steps judge all but io.
WHOLE_STEPS = ("world.golden", "world.scratch_failures")
# Tests of what a step costs depend on what else the machine does.
NO_JUDGES = ("step.bodies_cost", "world.soak")
# A test that takes more seconds of processor time does not judge what is in another folder, another room, its own room.
OTHER_FOLDER_SECONDS, OTHER_ROOM_SECONDS, OWN_ROOM_SECONDS = 1.0, 1.5, 10.0
SKIPPED = 77
MEMORY_BYTES = 8 << 30
JUDGES = re.compile("^(" + "|".join([rf"{folder}\." for folder in FOLDERS] + [others for _, others in FOLDERS.values()]) + ")")
Test = namedtuple("Test", "name command environment directory digest folder room stem")
Outcome = namedtuple("Outcome", "passed timed_out detail processor_seconds")


def fail(code, text):
    print(f"mutate.py: {text}", file=sys.stderr)
    sys.exit(code)


def hash_text(text):
    return hashlib.sha1(text if isinstance(text, bytes) else text.encode()).hexdigest()[:8]


def read_file(path):
    with open(path, "rb") as file:
        return file.read()


def write_if_other(path, data):
    """Writes bytes unless the file holds them, so that what is built from it stays."""
    if not os.path.exists(path) or read_file(path) != data:
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "wb") as file:
            file.write(data)


def read_rows(path):
    if not os.path.exists(path):
        return []
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def get_folder(path):
    return path.split("/")[1]


def get_room(path):
    """contact/solve of src/contact/solve/x.c and of test/contact/solve/test_x.c; kernels belong to the room above."""
    return "/".join(part for part in os.path.dirname(path).split("/")[1:] if part != "kernels")


class Tree:
    """The copy of the checkout in which mutants are built and judged."""

    def __init__(self, root, directory):
        self.root, self.tree, self.objects = root, f"{directory}/tree", f"{directory}/objects"

    def update(self):
        """Makes the copy equal to the checkout: files that git knows or would take."""
        names = subprocess.run(["git", "ls-files", "-co", "--exclude-standard", "-z"], cwd=self.root, check=True,
                               capture_output=True, text=True).stdout.split("\0")
        names = {name for name in names if name and os.path.isfile(f"{self.root}/{name}")}
        for name in names:
            write_if_other(f"{self.tree}/{name}", read_file(f"{self.root}/{name}"))
            os.chmod(f"{self.tree}/{name}", os.stat(f"{self.root}/{name}").st_mode & 0o777)
        for folder, _, files in os.walk(self.tree):
            for name in files:
                if os.path.relpath(f"{folder}/{name}", self.tree) not in names:
                    os.remove(f"{folder}/{name}")

    def configure(self):
        launcher = ["-DCMAKE_C_COMPILER_LAUNCHER=ccache"] if has_program("ccache") else []
        generator = ["-G", "Ninja"] if has_program("ninja") else []
        linker = ["-DCMAKE_SHARED_LINKER_FLAGS=-fuse-ld=lld"] if has_program("ld.lld") else []
        run_or_fail(["cmake", "-S", self.tree, "-B", self.objects, *generator, "-DCMAKE_BUILD_TYPE=Release", "-DTULLE_BUILD_TESTS=ON",
                     "-DTULLE_SHARED_INSIDE=ON", "-DCMAKE_LINK_DEPENDS_NO_SHARED=ON", "-DTULLE_EMBREE=off", "-DTULLE_VIEW=off",
                     f"-DTULLE_DATA_DIR={os.path.dirname(self.root)}/shared/data", *launcher, *linker])

    def build(self, targets, may_fail=False):
        """True if the targets are built; ends the program if they are not, unless that may be."""
        command = ["cmake", "--build", self.objects, "-j", str(os.cpu_count() or 1), "--target", *targets]
        if may_fail:
            return subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode == 0
        return run_or_fail(command)

    def hash_objects(self, source):
        """What the objects of a source file hold: one, or one for each vector width."""
        paths = sorted(glob.glob(f"{self.objects}/CMakeFiles/*.dir/{source}.o"))
        return [hash_text(read_file(path)) for path in paths]

    def write(self, source, code):
        with open(f"{self.tree}/{source}", "w") as file:
            file.write(code)

    def list_test_programs(self):
        """The targets that the judges need."""
        targets = []
        for path in sorted(glob.glob(f"{self.tree}/test/*/**/test_*.c", recursive=True)):
            folder, stem = path[len(self.tree) + 6:].split("/")[0], os.path.basename(path)[:-2]
            if JUDGES.match(f"{folder}.{stem[5:]}"):
                targets.append(f"{folder}_{stem}")
        return targets + ["tulle_program"]

    def find_parts(self, path, parts):
        """A test's source and what it includes of test/, with the .c file of each header."""
        if path not in parts and os.path.exists(path):
            parts.add(path)
            for name in re.findall(r'^#include "([^"]+)"', read_file(path).decode(), re.M):
                self.find_parts(f"{self.tree}/test/{name}", parts)
            if path.endswith(".h"):
                self.find_parts(path[:-1] + "c", parts)
        return parts

    def read_tests(self):
        """The judges among the tests of CTest by name, with the hash of what they are made of."""
        out = subprocess.run(["ctest", "--show-only=json-v1"], cwd=self.objects, check=True, capture_output=True, text=True)
        tests = {}
        for entry in json.loads(out.stdout)["tests"]:
            folder, _, short = entry["name"].partition(".")
            sources = glob.glob(f"{self.tree}/test/{folder}/**/test_{short}.c", recursive=True) + \
                glob.glob(f"{self.tree}/test/{folder}/{short}.sh")
            if not sources or "command" not in entry or not JUDGES.match(entry["name"]) or entry["name"] in NO_JUDGES:
                continue
            properties = {item["name"]: item["value"] for item in entry.get("properties", [])}
            environment = dict(item.split("=", 1) for item in properties.get("ENVIRONMENT", []))
            digest = hash_text("".join(sorted(hash_text(read_file(path)) for path in self.find_parts(sources[0], set()))))
            tests[entry["name"]] = Test(entry["name"], entry["command"], environment, properties["WORKING_DIRECTORY"], digest, folder,
                                        get_room(os.path.relpath(sources[0], self.tree)), short)
        return tests


def has_program(name):
    return any(os.access(f"{folder}/{name}", os.X_OK) for folder in os.environ.get("PATH", "").split(":"))


def run_or_fail(command):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode != 0:
        fail(3, f"{' '.join(command[:6])} ... failed:\n{done.stdout[-4000:]}")
    return True


def run_test(test, processor_limit=None, wall_limit=3600.0):
    """Runs a test until it ends, its limit is over, or it says that one of its cases failed."""
    def limit():
        os.setsid()
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        if processor_limit:
            seconds = int(processor_limit) + 1
            resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))

    environment = {key: value for key, value in os.environ.items() if not key.startswith("TULLE_")}
    began, used = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
    process = subprocess.Popen(test.command, cwd=test.directory, env={**environment, **test.environment}, preexec_fn=limit,
                               stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    os.set_blocking(process.stdout.fileno(), False)
    said, failed, over = b"", None, False
    try:
        while True:
            part = process.stdout.read()
            said = (said + (part or b""))[-20000:]
            failed = failed or re.search(rb"\[  FAILED  \] ([a-z]\w*)", said)
            over = time.monotonic() - began > wall_limit
            if failed or over or (process.poll() is not None and not part):
                break
            time.sleep(0.005)
    finally:
        try:
            os.killpg(process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        code = process.wait()
        process.stdout.close()
    now = resource.getrusage(resource.RUSAGE_CHILDREN)
    processor = now.ru_utime + now.ru_stime - used.ru_utime - used.ru_stime
    if failed:
        return Outcome(False, False, failed.group(1).decode(), processor)
    timed_out = over or code == -signal.SIGXCPU or (processor_limit is not None and code < 0 and processor >= processor_limit)
    return Outcome(code in (0, SKIPPED), timed_out, "" if code in (0, SKIPPED) else f"code {code}", processor)


def choose_judges(mutant, tests, times, history):
    """The tests that judge a mutant: the likely and quick ones first."""
    folder, room = get_folder(mutant.file), get_room(mutant.file)
    stem = os.path.splitext(os.path.basename(mutant.file))[0]
    judges = []
    for test in tests.values():
        is_whole = test.name in WHOLE_STEPS and folder != "io"
        if test.name not in times or not (test.folder == folder or is_whole or re.match(FOLDERS[folder][1], test.name)):
            continue
        seconds = times[test.name][0]
        most = OWN_ROOM_SECONDS if test.room == room else OTHER_ROOM_SECONDS if test.folder == folder else OTHER_FOLDER_SECONDS
        if seconds > most and not is_whole:
            continue
        guess = 0.6 if test.stem in (stem, stem + "s") else 0.35 if test.room == room else 0.3 if is_whole else 0.12
        kills, runs = history[room, test.name]
        judges.append((-(kills + 3 * guess) / (runs + 3) / (seconds + 0.03), test.name))
    return [tests[name] for _, name in sorted(judges)]


def judge(mutant, tree, judges, times, known):
    """Builds a mutant and lets the judges run that do not stand in `known` (name: hash) as passed; its row of results."""
    began = time.monotonic()
    code = read_file(f"{tree.tree}/{mutant.file}").decode()
    row = {"verdict": "survived", "by": "", "detail": "", "source": hash_text(code)}
    asked = []
    try:
        original = tree.hash_objects(mutant.file)
        tree.write(mutant.file, apply_mutant(code, mutant))
        if not tree.build(["tulle_inside", "tulle_io_inside"], may_fail=True):
            row["verdict"], judges = "not built", []
        elif tree.hash_objects(mutant.file) == original:
            row["verdict"], judges = "same code", []
        for test in judges:
            asked.append(f"{test.name}:{test.digest}")
            if known.get(test.name) == test.digest:
                continue
            processor, wall = times[test.name]
            outcome = run_test(test, 4 * processor + 2, 10 * wall + 20)
            if not outcome.passed:
                row.update(verdict="timeout" if outcome.timed_out else "killed", by=test.name, detail=outcome.detail)
                break
    finally:
        tree.write(mutant.file, code)
    row.update(judges=" ".join(asked), seconds=f"{time.monotonic() - began:.1f}")
    return row


def measure_tests(tests, path):
    """Processor and wall seconds of each test without a mutant; those known of the same test are kept."""
    known = {row["test"]: row for row in read_rows(path)}
    rows, failures = [], []
    for number, test in enumerate(sorted(tests.values())):
        row = known.get(test.name)
        if not row or row["digest"] != test.digest:
            show(f"without a mutant: {number + 1} of {len(tests)}, {test.name}")
            began = time.monotonic()
            outcome = run_test(test)
            if not outcome.passed:
                failures.append(f"{test.name} ({outcome.detail})")
                continue
            row = {"test": test.name, "digest": test.digest, "processor": f"{outcome.processor_seconds:.3f}",
                   "wall": f"{time.monotonic() - began:.3f}"}
        rows.append(row)
        if row is not known.get(test.name) or number + 1 == len(tests):
            with open(path, "w", newline="") as file:
                writer = csv.DictWriter(file, ["test", "digest", "processor", "wall"])
                writer.writeheader()
                kept = [item for name, item in known.items() if name not in {r["test"] for r in rows}]
                writer.writerows(rows + kept)
    if failures:
        fail(3, "tests fail without a mutant: " + ", ".join(failures))
    return {row["test"]: (float(row["processor"]), float(row["wall"])) for row in rows}


def show(text):
    print(("\r\x1b[K" if sys.stdout.isatty() else "") + text, end="" if sys.stdout.isatty() else "\n", flush=True)


