#!/usr/bin/env python3
"""What the stages of a step cost, scene by scene and size by size: runs bench_scene of each, keeps its inputs, counts
instructions, and compares with a baseline. lab/benchmarks.md tells what is measured.

usage: bench.py [OPTIONS] SCENE ...     scenes by name, or all, or scene files of yours; --help names the options
"""
import argparse
import difflib
import hashlib
import os
import platform
import re
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

from measures import Comparison, Failed, print_counts, print_scaling, print_times, put, read_rows, were_disturbed, write_rows

ROOT = Path(__file__).resolve().parent.parent
GARMENT = ROOT / "bench/garment.py"

# Name: steps that are timed, fewer where they take long.
SIZES = {"0.1k": 30, "0.4k": 4, "1k": 30, "2k": 8, "2.5k": 8, "9.8k": 8, "10k": 8, "40k": 4, "160k": 2, "1m": 1}
PARTICLES = {"0.1k": 100, "0.4k": 400, "1k": 1024, "2k": 2000, "2.5k": 2540, "9.8k": 9800, "10k": 10102, "40k": 40000,
             "160k": 160000, "1m": 1000000}
APART = {"0.4k", "1m", "landing"}  # not among "all"
SMALL = {"0.1k", "0.4k", "1k", "2k", "2.5k"}  # small enough to count their instructions
USUAL = ("0.4k", "2k", "9.8k", "40k", "160k")


def resolutions(*texts):
    """Changes of a cloth's mesh, a list for each size."""
    return [[f"cloth[0].mesh.resolution=[{text}]"] for text in texts]


def nets(*holes):
    return [[f"cloth[0].mesh.cells=[{cells}, {cells}]", f"cloth[0].mesh.size=[{size}, {size}]",
             f"cloth[0].mesh.strand_resolution={columns}"] for cells, size, columns in holes]


def usual(changes):
    return dict(zip(USUAL, changes, strict=True))


SQUARE = usual(resolutions("20, 20", "45, 45", "99, 99", "200, 200", "400, 400"))

# Name: the file below the directory of scenes, the steps from the start to where contact is in full swing, how it comes to each
# size. Materials and obstacles stay as the file has them; only the mesh of the cloth gets finer. A net keeps its holes, which
# decide what slips through: it gets finer strands and, as far as that alone does not give the number, more or fewer holes. A
# million particles would simulate for hours until contact is in full swing: `landing` is `sphere` when the cloth has just met it.
# `small` is cloth as games and robots have it, in sizes of its own, as `garment`, whose files bench/garment.py makes, has them.
SCENES = {
    "small": ("bench/small", 30, dict(zip(("0.1k", "1k"), resolutions("10, 10", "32, 32"), strict=True))),
    "needles": ("needles", 45, SQUARE),
    "sphere": ("sphere", 72, SQUARE),
    "spikes": ("spikes", 54, SQUARE),
    "ribbon": ("ribbon", 135, usual(resolutions("201, 2", "401, 5", "897, 11", "1819, 22", "3639, 44"))),
    "net": ("net", 45, usual(nets((4, 0.4107, 1), (9, 0.904, 1), (12, 1.2, 2), (13, 1.2987, 4), (13, 1.2987, 8)))),
    "boxes": ("boxes", 45, SQUARE),
    "hammock": ("hammock", 72, usual(resolutions("27, 15", "59, 34", "132, 74", "267, 150", "535, 299"))),
    "example_one": ("paper/example_one", 72, usual(resolutions("25, 16", "55, 37", "121, 81", "245, 163", "489, 327"))),
    "garment": (None, 104, {size: [f"cloth[0].mesh.file=dress_{size}.obj"] for size in ("2.5k", "10k")}),
    "landing": ("sphere", 12, {**SQUARE, "1m": resolutions("1000, 1000")[0]}),
}


class Interrupted(Exception):
    pass


def name_file(file):
    """The name of a scene file in rows."""
    return Path(file).stem.replace(",", "_")


def say(text):
    print(f"bench: {text}", file=sys.stderr, flush=True)


def choose(words, known, kind):
    """The chosen names, in the order of `known`; "all" stands for those that are not apart."""
    wanted = set()
    for word in (word for word in words if not word.endswith(".yaml")):
        if word == "all":
            wanted |= {name for name in known if name not in APART}
        elif word in known:
            wanted.add(word)
        else:
            near = difflib.get_close_matches(word, ["all", *known], 1)
            hint = f'; did you mean "{near[0]}"?' if near else "; --help names them"
            raise Failed(f'there is no {kind} "{word}"{hint}')
    return [name for name in known if name in wanted]


# ---- the program ----

class Program:
    def __init__(self, path):
        self.path = path
        self.child = None

    def run(self, arguments, quiet=False, command=()):
        """Runs the program (by `command`, if given) and gives exit code and standard output. Ctrl-C ends both."""
        stderr = subprocess.PIPE if quiet else None
        try:
            self.child = subprocess.Popen([*command, self.path, *arguments], stdout=subprocess.PIPE, stderr=stderr, text=True,
                                          start_new_session=True)  # a terminal sends Ctrl-C to this process alone
        except OSError as fault:
            raise Failed(f"{self.path} cannot be run: {fault.strerror}; `make bench` builds it")
        output, errors = self.child.communicate()
        code, self.child = self.child.returncode, None
        if code in (130, -signal.SIGINT):
            raise Interrupted
        return code, output, errors or ""

    def check(self, arguments):
        code, output, _ = self.run(arguments)
        if code != 0:
            raise Failed("", code)
        return output


def name_processor():
    """As the system has it; the name of its family where it has none."""
    try:
        names = re.findall(r"^model name\s*: *(.+)$", Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace"), re.M)
    except OSError:
        names = []
    return (names or [platform.machine()])[0].replace(",", " ")


def find_fingerprint(program):
    """The hash of a short simulation: two builds of one fingerprint nearly always make the same inputs, bit for bit."""
    with tempfile.TemporaryDirectory() as folder:
        scene = str(ROOT / "bench/fingerprint.yaml")
        output = program.check(["run", scene, "-o", folder + "/run", "--threads", "1", "--progress", "none"])
    return re.search(r"^state hash: ([0-9a-f]{16})$", output, re.M)[1]


# ---- cases ----

class Bench:
    def __init__(self, options):
        self.options = options
        self.tulle = Program(options.tulle)
        self.program = Program(options.program or str(Path(options.tulle).parent / "bench/bench_scene"))
        self.rows = {}
        self.whole_cases = 0
        self.counts_instructions = options.instructions
        self.fingerprint = ""

    def name_input(self, scene, size, file, changes):
        key = hashlib.sha256()
        for part in (self.fingerprint.encode(), file.read_bytes(), "\n".join(changes).encode()):
            key.update(part + b"\0")
        if not SCENES[scene][0]:
            key.update(GARMENT.read_bytes())
        return Path(self.options.inputs) / f"{scene}-{size}-{SCENES[scene][1]}-{key.hexdigest()[:16]}.state"

    def find_scene(self, scene):
        """The file of a scene. Files of a garment are made where they are not there; their folder's name tells by what."""
        if SCENES[scene][0]:
            file = Path(self.options.scenes) / f"{SCENES[scene][0]}.yaml"
            if not file.is_file():
                raise Failed(f"--scenes: {file} is not there")
            return file
        folder = Path(self.options.inputs) / f"{scene}-{hashlib.sha256(GARMENT.read_bytes()).hexdigest()[:16]}"
        if not (folder / "garment.yaml").is_file():
            say(f"makes the meshes of {scene}, half a minute")
            if subprocess.run([sys.executable, str(GARMENT), str(folder)], check=False).returncode != 0:
                raise Failed(f"{GARMENT} made no {folder}", 3)
        return folder / "garment.yaml"

    def measure_case(self, scene, size):
        _, skip, sizes = SCENES[scene]
        changes = sizes[size]
        file = self.find_scene(scene)
        state = self.name_input(scene, size, file, changes)
        if self.options.renew:
            state.unlink(missing_ok=True)
        self.measure_file(file, scene, size, ["--skip", str(skip), "--steps", str(SIZES[size]), "--state", str(state)], changes)

    def measure_file(self, file, scene, size, arguments, changes):
        """size: the number of particles if empty."""
        arguments = [str(file), *arguments, "--seconds", str(self.options.seconds), *(word for change in changes for word in ("--set", change))]
        output = self.program.check([*arguments, "--threads", self.options.threads, "--repeat", str(self.options.repeat)])
        lines = [line.split(",", 3) for line in output.splitlines()]
        size = size or next(value for _, _, name, value in lines if name == "particles")
        for threads, kind, name, value in lines:
            case = (scene, size, threads) if threads else ("", "", "")
            put(self.rows, case, kind, name, [float(sample) for sample in value.split(",")] if kind == "time" else value.replace(",", " "))
        self.tell(scene, size)
        if self.counts_instructions and (size in SMALL or scene not in SCENES):
            self.count_instructions(scene, size, arguments)

    def tell(self, scene, size):
        for key, fields in self.rows.items():
            if key[:2] == (scene, size) and key[3:] == ("time", "step"):
                median, least, spread = (1e3 * float(text) for text in fields[5:])
                disturbed = "; other work ran beside" if were_disturbed(self.rows, key[:3]) else ""
                print(f"{scene} {size}, {key[2]} thread{'' if key[2] == '1' else 's'}: {median:.4g} ms a step, least {least:.4g}, "
                      f"spread {spread:.2g}; {self.rows[(*key[:3], 'about', 'repeats')][5]} repeats{disturbed}", file=sys.stderr)

    def describe(self, tulle):
        self.fingerprint = find_fingerprint(tulle)
        for name, value in (("program", tulle.check(["--version"]).strip()), ("processor", name_processor()),
                            ("processors", os.cpu_count()), ("fingerprint", self.fingerprint)):
            put(self.rows, ("", "", ""), "about", name, value)

    def count_instructions(self, scene, size, arguments):
        """Instructions of the timed steps on one thread, by callgrind."""
        with tempfile.TemporaryDirectory() as folder:
            output = folder + "/callgrind.out"
            command = ["valgrind", "--tool=callgrind", "--collect-atstart=no", "--toggle-collect=bench_make_steps",
                       f"--callgrind-out-file={output}"]
            try:
                code, _, errors = self.program.run([*arguments, "--threads", "1", "--repeat", "1"], True, command)
            except Failed:
                say("skipped: instructions are counted by valgrind, which is not on the PATH (Debian's package is valgrind)")
                self.counts_instructions = False
                return
            text = Path(output).read_text(encoding="utf-8", errors="replace") if os.path.exists(output) else ""
        found = re.search(r"^(?:summary|totals): (\d+)", text, re.M)
        if not found or int(found[1]) == 0:
            raise Failed(f"valgrind ended with {code} and no count; it said:\n" + "\n".join(errors.splitlines()[-10:]), 3)
        put(self.rows, (scene, size, "1"), "instructions", "steps", found[1])
        print(f"{scene} {size}: {int(found[1]) * 1e-6:.4g} million instructions", file=sys.stderr)

    def end_case(self):
        if self.options.csv:
            write_rows(self.options.csv, self.rows)
        self.whole_cases += 1

    def measure(self, scenes, sizes, files):
        try:
            os.makedirs(self.options.inputs, exist_ok=True)
        except OSError as fault:
            raise Failed(f"--inputs: {self.options.inputs} cannot be made: {fault.strerror}")
        if not os.path.isdir(self.options.scenes):
            raise Failed(f"--scenes: {self.options.scenes} is no directory")
        self.describe(self.tulle)
        for file in files:
            self.measure_file(file, name_file(file), "", ["--skip", str(self.options.skip), "--steps", str(self.options.steps)],
                              self.options.set)
            self.end_case()
        for scene in scenes:
            made = [size for size in sizes if size in SCENES[scene][2]]
            if not made:
                say(f"{scene} is made in none of these sizes, but in {', '.join(SCENES[scene][2])}")
            for size in made:
                self.measure_case(scene, size)
                self.end_case()

    def take_rows(self, scenes, sizes, files):
        """The rows of the chosen scenes, sizes and threads."""
        threads = self.options.threads.split(",")
        for path in self.options.from_:
            for key, fields in read_rows(path).items():
                is_chosen = (key[0] in scenes and key[1] in sizes) or key[0] in map(name_file, files)
                if not key[0] or (is_chosen and key[2] in threads):
                    self.rows[key] = fields
        if self.options.csv:
            write_rows(self.options.csv, self.rows)

    def show(self):
        """Tables, and what differs from the baseline; an exit code."""
        print_scaling(self.rows, SIZES)
        print_times(self.rows)
        print_counts(self.rows)
        if not self.options.compare:
            return 0
        comparison = Comparison(read_rows(self.options.compare), self.rows)
        worse = comparison.compare()
        if comparison.compared == 0:
            raise Failed(f"--compare: {self.options.compare} has nothing to compare with")
        return 1 if worse else 0


# ---- the command line ----

def read_options(words):
    reader = argparse.ArgumentParser(prog="bench.py", description=__doc__.split("\n\n")[0], add_help=True)
    reader.add_argument("scenes_", metavar="SCENE", nargs="+", help=", ".join(SCENES) + ", all but landing, or a file SCENE.yaml")
    reader.add_argument("-p", "--particles", help=f"sizes: {', '.join(SIZES)}, all (default: 0.1k,1k,2k,2.5k,9.8k,10k; a scene is made in those that it has)")
    reader.add_argument("-t", "--threads", help="numbers of threads (default: 1,2)")
    reader.add_argument("-r", "--repeat", type=int, help="how often the steps of a case are made (default: 7)")
    reader.add_argument("--seconds", type=int, default=60, help="no further repeat of a case after that many, but three")
    reader.add_argument("--skip", type=int, default=30, help="of a file: steps from the start to those that are timed (default: 30)")
    reader.add_argument("--steps", type=int, default=8, help="of a file: steps that are timed (default: 8)")
    reader.add_argument("--set", metavar="PATH=VALUE", action="append", default=[], help="of a file: change a key; may be repeated")
    reader.add_argument("--quick", action="store_true", help="size 0.4k on one thread, twice: to see that it works")
    reader.add_argument("--instructions", action="store_true", help="also count the instructions of sizes up to 2.5k, by valgrind")
    reader.add_argument("--csv", metavar="FILE", help="write all measures to FILE")
    reader.add_argument("--compare", metavar="FILE", help="compare with FILE; exit code 1 if anything got worse")
    reader.add_argument("--from", dest="from_", metavar="FILE", action="append", default=[],
                        help="take the measures from FILE, measure nothing; may be repeated")
    reader.add_argument("--inputs", metavar="DIR", default="bench-inputs", help="where inputs are kept")
    reader.add_argument("--renew", action="store_true", help="make inputs anew that are there")
    reader.add_argument("--scenes", metavar="DIR", default=str(ROOT / "scenes"), help="where the scenes are")
    reader.add_argument("--tulle", metavar="FILE", default=str(ROOT / "build/release/tulle"), help="the program")
    reader.add_argument("--program", metavar="FILE", help="what measures (default: bench/bench_scene beside the program)")
    options = reader.parse_args(words)
    if options.particles is None:
        options.particles = "0.4k" if options.quick else "0.1k,1k,2k,2.5k,9.8k,10k"
    if options.threads is None:
        options.threads = "1" if options.quick else "1,2"
    if options.repeat is None:
        options.repeat = 2 if options.quick else 7
    if min(options.repeat, options.seconds, options.steps, options.skip + 1) < 1:
        raise Failed("--repeat, --seconds and --steps should be whole numbers from 1, --skip from 0")
    for word in options.threads.split(","):
        if not re.fullmatch(r"[1-9]\d{0,2}", word) or int(word) > 256:
            raise Failed(f'--threads: "{word}" should be whole numbers from 1 to 256, as 1,2')
    return options


def main(words):
    bench = None

    def interrupt(_signal, _frame):
        child = bench and (bench.program.child or bench.tulle.child)
        if child:
            child.send_signal(signal.SIGINT)  # it ends in good order, and Program.run tells
        else:
            raise Interrupted

    signal.signal(signal.SIGINT, interrupt)
    try:
        options = read_options(words)
        scenes = choose(options.scenes_, SCENES, "scene")
        sizes = choose(options.particles.split(","), SIZES, "size")
        files = [word for word in options.scenes_ if word.endswith(".yaml")]
        bench = Bench(options)
        if options.compare:
            read_rows(options.compare)
        if options.csv and not os.path.isdir(os.path.dirname(options.csv) or "."):
            raise Failed(f"{options.csv}: cannot be written: its directory is not there")
        if options.from_:
            bench.take_rows(scenes, sizes, files)
        else:
            bench.measure(scenes, sizes, files)
        return bench.show()
    except Failed as fault:
        if str(fault):
            say(fault)
        return fault.code
    except Interrupted:
        whole = bench.whole_cases if bench else 0
        kept = f", which are in {bench.options.csv}" if whole and bench.options.csv else ""
        say(f"interrupted after {whole} whole cases{kept}")
        return 130


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
