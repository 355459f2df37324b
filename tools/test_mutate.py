#!/usr/bin/env python3
"""Shows tools/mutate.py a made-up C file, tests that end in every way, and results that still hold or do not."""
import contextlib
import io
import sys
import tempfile
import time
from collections import Counter

import mutate
from mutation_judge import WHOLE_STEPS, Test, choose_judges, run_test
from mutation_operators import OPERATORS, apply_mutant, find_mutants

CODE = r'''/* made_up.c - a < b && c == 1; */
#include <stdio.h> // x < 1
#define LARGER(a, b) ((a) > (b) \
                          ? (a) : 1 + (b))
static const int table[2] = {1, 2 + 3};
enum { COUNT = 4 };

/* if (x) return 1; */
static int work(const double *values, int count, char *text) {
    assert(count > 1 + 2);
    static const double steps[3] = {1.0, 2.0, 3.0};
    double sum = 0.0, *last = NULL, most[2] = {-1.5, 7};
    enum { LOCAL = 3 };
    char const *const said = "a < b || !c", mark = '<';
    for (int i = 0; i < count; i++) sum += values[i] * most[0]; // i > 0
    if (!text || sum >= 2.5) return COUNT;
    tell(text, "%d < 1", count - 1);
    switch (count) {
    case 1: sum = fmax(sum, -sum); break;
    default: status = forget(text);
    }
    error_set(text, "lost");
    (void)said;
    return (int)sum;
}

void TULLE_KERNEL(wide)(int a) { run(a & 6); }
'''
EXPECTED = {
    ("wide", "arithmetic", "& -> |"), ("wide", "constant", "6 -> 7"), ("wide", "statement", "run(a & 6); -> ;"),
    ("work", "arithmetic", "* -> /"), ("work", "arithmetic", "+= -> -="), ("work", "boundary", "< -> <="),
    ("work", "boundary", ">= -> >"), ("work", "condition", "!text || sum >= 2.5 -> 0"),
    ("work", "condition", "!text || sum >= 2.5 -> 1"), ("work", "constant", "0 -> 1"), ("work", "constant", "0.0 -> 1.0"),
    ("work", "constant", "1.5 -> (-1.5)"), ("work", "constant", "2.5 -> (-2.5)"), ("work", "constant", "7 -> 8"),
    ("work", "index", "[0] -> [(0) + 1]"), ("work", "index", "[i] -> [(i) + 1]"), ("work", "logical", "! -> nothing"),
    ("work", "logical", "|| -> &&"), ("work", "minmax", "fmax -> fmin"), ("work", "relational", "< -> >="),
    ("work", "relational", ">= -> <"), ("work", "return", "return COUNT; -> ;"), ("work", "sign", "- -> nothing"),
    ("work", "statement", "status = forget(text); -> ;"), ("work", "statement", "sum += values[i] * most[0]; -> ;"),
    ("work", "statement", "sum = fmax(sum, -sum); -> ;"), ("work", "statement", 'tell(text, "%d < 1", count - 1); -> ;'),
    ("work", "status", "status = forget(text); -> (void)forget(text);"),
}


def check(holds, text):
    if not holds:
        sys.exit(f"test_mutate.py: {text}")


def check_operators():
    mutants = find_mutants("src/world/made_up.c", CODE)
    found = {(m.function, m.operator, m.change) for m in mutants}
    check(found == EXPECTED, f"missing: {EXPECTED - found}; too many: {found - EXPECTED}")
    check({m.operator for m in mutants} == set(OPERATORS), "an operator finds nothing")
    check(len({m.id for m in mutants}) == len(mutants), "two mutants have one id")
    for mutant in mutants:
        changed = apply_mutant(CODE, mutant)
        check(changed != CODE and changed[:mutant.start] == CODE[:mutant.start] and changed.endswith(CODE[mutant.end:]),
              f"{mutant.change} changes more than its place")
    minmax = next(m for m in mutants if m.operator == "minmax")
    check("case 1: sum = fmin(sum, -sum); break;" in apply_mutant(CODE, minmax), "fmax did not become fmin")


def check_ids():
    ids = {m.id for m in find_mutants("src/world/made_up.c", CODE)}
    moved = {m.id for m in find_mutants("src/world/made_up.c", "int more;\n\n" + CODE)}
    check(ids == moved, "ids change when a line is added above")
    edited = {m.id for m in find_mutants("src/world/made_up.c", CODE.replace("sum >= 2.5", "sum >= 3.5"))}
    check(0 < len(ids - edited) < len(ids), "ids do not tell an edited line from the others")
    check(not ids & {m.id for m in find_mutants("src/world/other.c", CODE)}, "two files share ids")
    twice = CODE.replace("(void)said;", "tell(text);\n    tell(text);")
    ids = [m.id for m in find_mutants("src/world/made_up.c", twice)]
    check(len(set(ids)) == len(ids), "equal lines of one function share ids")


def check_newer():
    mutants = find_mutants("src/world/made_up.c", CODE)
    line = "if (!text || sum >= 2.5) return COUNT;"
    newer = mutate.find_newer(mutants, {each.strip() for each in CODE.split("\n")} - {line})
    check(newer and newer == [m for m in mutants if m.line == line], "lines that are not new are mutated, or new ones are not")
    check(mutate.find_newer(mutants, set()) == mutants, "without older lines not all are new")


def make_test(name, command="", digest="11111111", room="world"):
    return Test(name, ["sh", "-c", command], {"TULLE_GIVEN": "1"}, "/", digest, name.split(".")[0], room, name.split(".")[1])


def check_verdicts():
    def run(command, **limits):
        return run_test(make_test("world.x", command), **limits)
    check(run("exit 0").passed and run("exit 77").passed, "a test that passes or skips is said to fail")
    outcome = run("exit 3")
    check(not outcome.passed and not outcome.timed_out and outcome.detail == "code 3", "exit code 3 is no failure")
    check(not run("kill -SEGV $$").passed, "a crash is no failure")
    check(run('[ "$TULLE_GIVEN" = 1 ]').passed, "a test does not get its environment")
    began = time.monotonic()
    outcome = run("echo '[  FAILED  ] a_case' >&2; sleep 20")
    check(outcome.detail == "a_case" and not outcome.timed_out, "the case that failed is not told")
    check(run("sleep 20", wall_limit=0.1).timed_out, "a test that hangs does not time out")
    check(time.monotonic() - began < 10, "a test goes on after its first failure")


def check_order():
    tests = [make_test("world.made_up"), make_test("world.far"), make_test("world.slow", room="world/step"),
             make_test(WHOLE_STEPS[0]), make_test("io.json"), make_test("world.unmeasured")]
    times = {"world.made_up": (1.0, 1.0), "world.far": (1.0, 1.0), "world.slow": (5.0, 5.0), WHOLE_STEPS[0]: (1.0, 1.0), "io.json": (0.1, 0.1)}
    mutant = find_mutants("src/world/made_up.c", CODE)[0]
    tests = {test.name: test for test in tests}
    order = [t.name for t in choose_judges(mutant, tests, times, History())]
    check(order == ["world.made_up", "world.far", WHOLE_STEPS[0]], f"the judges are {order}")
    order = [t.name for t in choose_judges(mutant, tests, times, History({("world", WHOLE_STEPS[0]): (9, 9)}))]
    check(order[0] == WHOLE_STEPS[0], "a test that killed often does not come first")


class History(dict):
    def __missing__(self, key):
        return (0, 0)


def check_results(directory):
    path = f"{directory}/results.csv"
    killed, survivor = find_mutants("src/world/made_up.c", CODE)[:2]
    results = mutate.Results(path)
    row = {"by": "", "detail": "", "seconds": "1.0", "source": "cccccccc"}
    results.add(killed, {**row, "verdict": "killed", "by": "world.b", "judges": "world.a:11111111 world.b:11111111"})
    results.add(survivor, {**row, "verdict": "survived", "judges": "world.a:11111111 world.b:11111111"})
    results.compact()
    results = mutate.Results(path)
    same = [make_test("world.a"), make_test("world.b")]
    a_changed, b_changed = [make_test("world.a", "", "2"), same[1]], [same[0], make_test("world.b", "", "2")]

    def holds(mutant, judges, source="cccccccc", trusts_kills=False):
        return results.find_valid(mutant, source, judges, trusts_kills) is not None
    check(holds(killed, same) and holds(survivor, same), "a result is lost between two runs")
    check(not holds(killed, same, "dddddddd") and not holds(survivor, same, "dddddddd"), "a result outlives an edit of its file")
    check(holds(killed, a_changed) and not holds(killed, b_changed), "a kill depends on other tests than its own")
    check(holds(killed, b_changed, trusts_kills=True), "kills are not trusted")
    check(not holds(survivor, a_changed) and not holds(survivor, same + [make_test("world.c")]), "a new test asks no survivor")
    check(results.get_passed(survivor, "cccccccc") == {"world.a": "11111111", "world.b": "11111111"}, "passed tests run again")
    check(results.get_passed(killed, "cccccccc") == {"world.a": "11111111"}, "the test that killed counts as passed")
    check(results.count_kills()["world", "world.b"] == (1, 2), "kills are miscounted")


def check_draw_and_summary(directory):
    mutants = [m for folder in mutate.FOLDERS for m in find_mutants(f"src/{folder}/made_up.c", CODE)]
    counts = mutate.count_folders(37, mutants)
    check(sum(counts.values()) == 37 and set(counts) == set(mutate.FOLDERS), "the folders' shares are not the whole")
    check(mutate.count_folders(5, mutants[:1]) == {"contact": 5}, "one folder does not get all")
    drawn, refused = [], []

    def take(mutant):
        (drawn if mutant.operator != "sign" else refused).append(mutant)
        return mutant.operator != "sign"
    mutate.draw(mutants, counts, 1, take)
    check(Counter(m.file.split("/")[1] for m in drawn) == Counter(counts), "mutants are not spread over folders")
    check(refused and max(Counter((m.file, m.operator) for m in drawn).values()) <= 2, "mutants are not spread over operators")
    other = []
    mutate.draw(mutants, counts, 2, lambda mutant: other.append(mutant) or True)
    check(drawn != other, "the seed draws nothing else")
    verdicts = ["killed"] * 8 + ["timeout", "survived", "equivalent"]
    with contextlib.redirect_stdout(io.StringIO()) as said:
        check(mutate.summarise(list(zip(drawn, verdicts)), f"{directory}/summary.csv"), "9 of 10 are not enough")
        check(not mutate.summarise(list(zip(drawn, verdicts[1:]))), "8 of 9 are enough")
    check(drawn[9].id in said.getvalue(), "the survivor is not told")
    with open(f"{directory}/summary.csv") as file:
        check(file.read().endswith("all,,11,8,1,1,1\n"), "the summary is wrong")
    with open(f"{directory}/equivalent.csv", "w") as file:
        file.write(f"id,file,function,operator,change,line,reason\n{drawn[0].id},f,f,sign,c,l,it is\n{drawn[1].id},f,f,sign,c,l, \n")
    with contextlib.redirect_stderr(io.StringIO()) as said:
        try:
            mutate.read_equivalent(f"{directory}/equivalent.csv", mutants)
        except SystemExit as end:
            check(end.code == 2 and "equivalent.csv:3" in said.getvalue(), "the line without a reason is not told")
        else:
            check(False, "a mutant is equivalent without a reason")


def main():
    check_operators()
    check_ids()
    check_newer()
    check_verdicts()
    check_order()
    with tempfile.TemporaryDirectory() as directory:
        check_results(directory)
        check_draw_and_summary(directory)


if __name__ == "__main__":
    main()
