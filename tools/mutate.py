#!/usr/bin/env python3
"""Changes the engine's code in one small place after the other, and asks whether a test notices.

usage: mutate.py [--count N] [--seed N] [--file PART] [--operator NAME] [--since COMMIT] [--trust-kills] [--list] [--summary]
                 [--build DIR]

Mutants (tools/mutation_operators.py) are drawn by the seed: so many a folder (FOLDERS in tools/mutation_judge.py), in turn from
each operator. A mutant that does not compile, or compiles to the same code, does not count; the next one takes its place.

A mutant is made in a copy of the tree, DIR/tree (default build/mutate), never in the checkout. There the tests stand on
shared libraries of the inside, so that a mutant costs the compilation of one file and two links. The tests of its folder
judge it, and the golden ones: those first that are likely to fail and quick, none after the first that fails. A test may take
some times the processor time that it takes without a mutant.

Verdicts: killed (by which test), timeout (killed, too), survived, equivalent (test/mutation/equivalent.csv, with the reason).
They are kept in DIR/results.csv. A kill holds while the mutated file and the test stay as they are; of a survivor only tests
that are new or changed run again. So the same command goes on after Ctrl-C, and asks only what is new after an edit.

Exit code 0; 1 if less than 90 % of those that are not equivalent are killed; 2 for wrong usage; 3 if the tests fail without
a mutant; 130 when interrupted. --summary counts all verdicts on today's code, of whatever runs, in test/mutation/summary.csv.
"""
import argparse
import csv
import fcntl
import glob
import hashlib
import os
import signal
import subprocess
import sys
import time
from collections import Counter, defaultdict

from mutation_judge import FOLDERS, Tree, choose_judges, fail, get_folder, get_room, hash_text, judge, measure_tests, read_file, read_rows
from mutation_operators import OPERATORS, find_mutants

LEAST_KILLED = 0.9
COLUMNS = ["id", "verdict", "by", "detail", "seconds", "source", "judges", "file", "function", "operator", "change", "line"]
UNCOUNTED = ("not built", "same code")
EQUIVALENT, SUMMARY = "test/mutation/equivalent.csv", "test/mutation/summary.csv"


class Results:
    """What is known of mutants, in a file that grows by a line for each verdict."""

    def __init__(self, path):
        self.path = path
        self.rows = {row["id"]: row for row in read_rows(path)}

    def compact(self):
        """Leaves the last line of each id, which is the one that counts."""
        if self.rows:
            with open(self.path + ".new", "w", newline="") as file:
                writer = csv.DictWriter(file, COLUMNS)
                writer.writeheader()
                writer.writerows(self.rows.values())
            os.replace(self.path + ".new", self.path)

    def add(self, mutant, row):
        row = {**row, **{key: getattr(mutant, key) for key in ("id", "file", "function", "operator", "change", "line")}}
        is_new = not os.path.exists(self.path)
        with open(self.path, "a", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS)
            if is_new:
                writer.writeheader()
            writer.writerow(row)
        self.rows[mutant.id] = row

    def get_judges(self, mutant, digest):
        """The tests that judged a mutant of this very code, with their hashes."""
        row = self.rows.get(mutant.id)
        if not row or row["source"] != digest:
            return {}
        return dict(part.split(":") for part in row["judges"].split())

    def get_passed(self, mutant, digest):
        """Those that it passed."""
        judges = self.get_judges(mutant, digest)
        return {name: judges[name] for name in judges if name != self.rows[mutant.id]["by"]}

    def find_valid(self, mutant, digest, judges, trusts_kills):
        """The row of a mutant if its verdict still holds, else none."""
        row, known = self.rows.get(mutant.id), self.get_judges(mutant, digest)
        if not row or row["source"] != digest:
            return None
        if row["verdict"] == "survived":
            return row if all(known.get(test.name) == test.digest for test in judges) else None
        if row["verdict"] in UNCOUNTED:
            return row
        return row if any(test.name == row["by"] and (trusts_kills or known[test.name] == test.digest) for test in judges) else None

    def count_kills(self):
        """(kills, runs) of each test in each room."""
        counts = defaultdict(lambda: (0, 0))
        for row in self.rows.values():
            for part in row["judges"].split():
                key = get_room(row["file"]), part.split(":")[0]
                kills, runs = counts[key]
                counts[key] = kills + (key[1] == row["by"]), runs + 1
        return counts


def draw(mutants, counts, seed, judge_one):
    """Gives judge_one mutants, folder by folder in turn, each operator in turn, until counts[folder] of them count."""
    queues = defaultdict(lambda: defaultdict(list))
    for mutant in mutants:
        queues[get_folder(mutant.file)][mutant.operator].append(mutant)
    for operators in queues.values():
        for queue in operators.values():
            queue.sort(key=lambda m: hashlib.sha1(f"{seed} {m.id}".encode()).digest(), reverse=True)
    done, turns = Counter(), Counter()
    while True:
        # The folder that is most behind its share.
        open_folders = [f for f in counts if done[f] < counts[f] and any(queues[f].values())]
        if not open_folders:
            return
        folder = min(open_folders, key=lambda f: done[f] / counts[f])
        operator = list(OPERATORS)[turns[folder] % len(OPERATORS)]
        turns[folder] += 1
        queue = queues[folder][operator]
        while queue:
            if judge_one(queue.pop()):
                done[folder] += 1
                break


def count_folders(total, mutants):
    """How many mutants of `total` fall on each folder that has some."""
    folders = {get_folder(mutant.file) for mutant in mutants}
    weights = {folder: weight for folder, (weight, _) in FOLDERS.items() if folder in folders}
    shares = {folder: total * weight / sum(weights.values()) for folder, weight in weights.items()}
    counts = {folder: int(share) for folder, share in shares.items()}
    for folder in sorted(shares, key=lambda f: counts[f] - shares[f])[:total - sum(counts.values())]:
        counts[folder] += 1
    return counts


def read_equivalent(path, mutants):
    """Ids of the mutants that are argued to change nothing; each needs a reason and a place in today's code."""
    rows, known = read_rows(path), {mutant.id for mutant in mutants}
    for number, row in enumerate(rows):
        if not row["reason"].strip():
            fail(2, f"{path}:{number + 2}: mutant {row['id']} has no reason; say why no test can tell it from the code")
        if row["id"] not in known:
            print(f"{path}:{number + 2}: the code of mutant {row['id']} is gone; remove the line", file=sys.stderr)
    return {row["id"] for row in rows}


def summarise(judged, path=None):
    """Prints verdicts by folder and operator, and the survivors; true if enough are killed."""
    kinds = ["judged", "killed", "timeout", "survived", "equivalent"]
    table = []
    for title, keys, get in (("folder", FOLDERS, lambda m: get_folder(m.file)), ("operator", OPERATORS, lambda m: m.operator)):
        for key in keys:
            counts = Counter(verdict for mutant, verdict in judged if get(mutant) == key)
            table.append([title, key, sum(counts.values())] + [counts[kind] for kind in kinds[1:]])
    counts = Counter(verdict for _, verdict in judged)
    table.append(["all", "", len(judged)] + [counts[kind] for kind in kinds[1:]])
    for row in [["", ""] + kinds] + table:
        if row[2]:
            print(f"{row[0]:9}{row[1]:12}" + "".join(f"{cell:>11}" for cell in row[2:]))
    for mutant, verdict in judged:
        if verdict == "survived":
            print(f"survived: {mutant.id} {mutant.file}: {mutant.function}: {mutant.operator}: {mutant.change} in `{mutant.line}`")
    if path:
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([["of", "name"] + kinds] + table)
    killed, different = counts["killed"] + counts["timeout"], len(judged) - counts["equivalent"]
    if different:
        print(f"{100 * killed / different:.1f} % of {different} mutants that are not equivalent are killed")
    return killed >= LEAST_KILLED * different


def read_options(arguments):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--count", type=int, default=300, help="how many mutants")
    parser.add_argument("--seed", type=int, default=1, help="which mutants")
    parser.add_argument("--file", default="", help="only files whose path holds this")
    parser.add_argument("--operator", choices=list(OPERATORS), help="only this operator")
    parser.add_argument("--since", metavar="COMMIT", help="only lines that no C file of src/ had at this commit")
    parser.add_argument("--trust-kills", action="store_true", help="a kill holds although its test has changed since")
    parser.add_argument("--list", action="store_true", help="lists mutants and what is known of them, judges none")
    parser.add_argument("--summary", action="store_true", help="counts all verdicts on today's code, judges none")
    parser.add_argument("--build", default="build/mutate", help="where the copy of the tree and results are")
    return parser.parse_args(arguments)


def read_older_lines(commit):
    """The lines of all C files of src/ at a commit, without the spaces around them."""
    done = subprocess.run(["git", "grep", "-h", "", commit, "--", "src/*.c"], capture_output=True, text=True,
                          cwd=os.path.dirname(os.path.abspath(__file__)) + "/..")
    if done.returncode != 0:
        fail(2, f"git knows no C files of src/ at {commit}: {done.stderr.strip()}")
    return {line.strip() for line in done.stdout.splitlines()}


def find_newer(mutants, older):
    """Those on lines that are not among the older ones. A line that moved to another place or file is not new."""
    return [mutant for mutant in mutants if mutant.line not in older]


def read_mutants(root, options):
    """Mutants of the folders' C files that the options choose, and the hash of each file."""
    mutants, digests = [], {}
    for folder in FOLDERS:
        for path in sorted(glob.glob(f"src/{folder}/**/*.c", root_dir=root, recursive=True)):
            code = read_file(f"{root}/{path}").decode()
            digests[path] = hash_text(code)
            mutants += find_mutants(path, code)
    equivalent = read_equivalent(f"{root}/{EQUIVALENT}", mutants)
    mutants = [m for m in mutants if options.file in m.file and options.operator in (None, m.operator)]
    if options.since:
        mutants = find_newer(mutants, read_older_lines(options.since))
    if not mutants:
        fail(2, f"no mutant of operator {options.operator or 'any'} in files with \"{options.file}\" in their path")
    return mutants, digests, equivalent


def list_mutants(mutants, counts, seed, results, equivalent):
    """Prints which mutants the options choose, as far as is known which of them count."""
    def show_one(mutant):
        verdict = "equivalent" if mutant.id in equivalent else results.rows.get(mutant.id, {}).get("verdict", "unknown")
        print(f"{mutant.id} {verdict:10} {mutant.file}: {mutant.function}: {mutant.operator}: {mutant.change} in `{mutant.line}`")
        return verdict not in UNCOUNTED
    draw(mutants, counts, seed, show_one)


def run(options, root, directory):
    """Judges what the options choose; the exit code."""
    results, tree = Results(f"{directory}/results.csv"), Tree(root, directory)
    if options.list or options.summary:
        mutants, digests, equivalent = read_mutants(root, options)
        if options.summary:
            kept = [(mutant, "equivalent" if mutant.id in equivalent else results.rows[mutant.id]["verdict"]) for mutant in mutants
                    if mutant.id in equivalent or results.rows.get(mutant.id, {}).get("source") == digests[mutant.file]]
            return 0 if summarise([pair for pair in kept if pair[1] not in UNCOUNTED], f"{root}/{SUMMARY}") else 1
        list_mutants(mutants, count_folders(options.count, mutants), options.seed, results, equivalent)
        return 0
    results.compact()
    tree.update()
    mutants, digests, equivalent = read_mutants(tree.tree, options)  # the checkout may change meanwhile
    tree.configure()
    tree.build(["tulle_inside", "tulle_io_inside", *tree.list_test_programs()])
    tests = tree.read_tests()
    times = measure_tests(tests, f"{directory}/times.csv")
    judged, began, spent = [], time.monotonic(), []

    def judge_one(mutant):
        if mutant.id in equivalent:
            judged.append((mutant, "equivalent"))
            return True
        judges = choose_judges(mutant, tests, times, results.count_kills())
        row = results.find_valid(mutant, digests[mutant.file], judges, options.trust_kills)
        if not row:
            row = judge(mutant, tree, judges, times, results.get_passed(mutant, digests[mutant.file]))
            results.add(mutant, row)
            spent.append(float(row["seconds"]))
            left = (options.count - len(judged)) * (time.monotonic() - began) / max(1, len(judged))
            print(f"{len(judged) + 1}/{options.count}, about {left / 60:.0f} min left: {row['verdict']} {row['by']} {row['detail']}: "
                  f"{mutant.id} {mutant.file}: {mutant.function}: {mutant.operator}: {mutant.change} in `{mutant.line}`", flush=True)
        if row["verdict"] not in UNCOUNTED:
            judged.append((mutant, row["verdict"]))
        return row["verdict"] not in UNCOUNTED

    try:
        draw(mutants, count_folders(options.count, mutants), options.seed, judge_one)
    except KeyboardInterrupt:
        summarise(judged)
        raise
    finally:
        if spent:
            print(f"{len(spent)} mutants built and judged, {sum(spent) / len(spent):.1f} s each")
    return 0 if summarise(judged) else 1


def main():
    options = read_options(sys.argv[1:])
    if options.count < 1:
        fail(2, f"--count is {options.count}; it should be 1 or more")
    root = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    directory = os.path.join(root, options.build)
    os.makedirs(directory, exist_ok=True)
    with open(f"{directory}/lock", "w") as lock:
        try:
            if not options.list and not options.summary:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            fail(2, f"another run works in {directory}; wait for it, or choose another place with --build")
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.default_int_handler)
        try:
            return run(options, root, directory)
        except KeyboardInterrupt:
            print(f"interrupted; the same command goes on with what is in {directory}")
            return 130


if __name__ == "__main__":
    sys.exit(main())
