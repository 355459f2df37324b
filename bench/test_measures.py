#!/usr/bin/env python3
"""Measures of the bench: medians, CSV there and back and damaged, and the comparison, which must flag what is worse and nothing
else."""
import contextlib
import io
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import measures  # noqa: E402

ABOUT, CASE = ("", "", ""), ("sphere", "2k", "1")
TIMES = {"step": 0.0101, "processor": 0.01, "solve_motion": 0.006, "accept_state": 1e-5}


def make_rows():
    rows = {}
    for case, kind, name, value in (
        (ABOUT, "about", "processor", "one"), (ABOUT, "about", "compiler", "gcc"), (CASE, "hash", "start", "0123456789abcdef"),
        (CASE, "hash", "end", "fedcba9876543210"), (CASE, "count", "contacts", 123456789012), (CASE, "memory", "most_bytes", 1000000),
        (CASE, "memory", "allocator_calls", 0), (CASE, "instructions", "steps", 100000000)):  # fmt: skip
        measures.put(rows, case, kind, name, value)
    for name, median in TIMES.items():
        measures.put(rows, CASE, "time", name, [0.99 * median, median, 1.01 * median])
    return rows


def scale(rows, kind, name, factor):
    fields = rows[(*CASE, kind, name)]
    fields[5:] = [f"{float(text) * factor:.15g}" if text else "" for text in fields[5:]]


def compare(rows):
    """The number of measures that got worse beside the rows above, how many were compared, and what was said."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        comparison = measures.Comparison(make_rows(), rows)
        worse = comparison.compare()
    return worse, comparison.compared, said.getvalue()


class Rows(unittest.TestCase):
    def test_samples_are_summarized(self):
        for samples, summary in (([5.0, 1.0, 3.0, 100.0, 2.0], ["3", "1", "2"]), ([4.0, 1.0, 2.0, 8.0], ["3", "1", "1.5"]),
                                 ([7.0], ["7", "7", "0"])):  # fmt: skip
            rows = {}
            measures.put(rows, CASE, "time", "step", samples)
            self.assertEqual(rows[(*CASE, "time", "step")][5:], summary)

    def test_a_row_replaces_its_like(self):
        rows = make_rows()
        count = len(rows)
        measures.put(rows, CASE, "time", "step", [0.5])
        self.assertEqual(len(rows), count)
        self.assertEqual(measures.get_value(rows, CASE, "time", "step"), 0.5)

    def test_csv_comes_back(self):
        with tempfile.TemporaryDirectory() as folder:
            measures.write_rows(f"{folder}/rows.csv", make_rows())
            self.assertEqual(measures.read_rows(f"{folder}/rows.csv"), make_rows())
            self.assertEqual(len(list(pathlib.Path(folder).iterdir())), 1)

    def test_damaged_csv_is_refused(self):
        head = ",".join(measures.HEAD) + "\n"
        for text, message, line in (
            ("", "no table", 1), ("a,b\n1,2\n", "no table", 1), (head[:-1], "cut off", 1),
            (head + "sphere,2k,1,count,contacts,12,,\nsphere,2k,1,count", "cut off", 3),
            (head + "sphere,2k,1,count,contacts,12,\n", "has 7 fields", 2), (head + "sphere,2k,1,count,contacts,12,,,\n", "has 9 fields", 2),
            (head + "sphere,2k,x,count,contacts,12,,\n", '"threads"', 2), (head + "sphere,2k,1,thyme,contacts,12,,\n", '"kind"', 2),
            (head + "sphere,2k,1,count,,12,,\n", '"name"', 2), (head + "sphere,2k,1,count,contacts,twelve,,\n", '"value"', 2),
            (head + "sphere,2k,1,count,contacts,nan,,\n", '"value"', 2), (head + "sphere,2k,1,count,contacts,-1,,\n", '"value"', 2),
            (head + "sphere,2k,1,time,step,1,1,\n", '"minimum" and "spread"', 2)):  # fmt: skip
            with tempfile.TemporaryDirectory() as folder:
                path = pathlib.Path(folder, "damaged.csv")
                path.write_text(text, encoding="utf-8")
                with self.assertRaisesRegex(measures.Failed, rf"damaged\.csv:{line}: .*{message}"):
                    measures.read_rows(path)
        with self.assertRaisesRegex(measures.Failed, "cannot be read"):
            measures.read_rows("/no/such/file.csv")


class Compared(unittest.TestCase):
    def test_equal_rows_are_not_flagged(self):
        worse, compared, said = compare(make_rows())
        self.assertEqual(worse, 0)
        self.assertEqual(compared, 8)  # all but those about, the start and a tiny stage
        self.assertIn("0 slower, 0 changed", said)

    def test_worse_rows_are_flagged(self):
        for kind, name, factor, expected, text in (
            ("time", "solve_motion", 1.02, 0, "0 slower"),
            ("time", "solve_motion", 1.06, 1, "slower:  sphere 2k, 1 thread, solve_motion: 6.36 ms, was 6 ms, 1.060 times"),
            ("time", "solve_motion", 0.9, 0, "faster:  sphere 2k, 1 thread, solve_motion"),
            ("time", "accept_state", 3.0, 0, "0 slower"),  # a thousandth of the step
            ("time", "accept_state", 100.0, 1, "slower:  sphere 2k, 1 thread, accept_state"),
            ("count", "contacts", 1.0 + 1e-9, 1, "changed: sphere 2k, 1 thread, contacts"),
            ("count", "contacts", 0.5, 1, "changed: sphere 2k, 1 thread, contacts"),
            ("memory", "most_bytes", 1.04, 0, "0 more"),
            ("memory", "most_bytes", 1.06, 1, "more:    sphere 2k, 1 thread, most_bytes"),
            ("instructions", "steps", 1.004, 0, "0 more"),
            ("instructions", "steps", 1.006, 1, "more:    sphere 2k, 1 thread, steps: 100600000 instructions, was 100000000"),
            ("instructions", "steps", 0.9, 0, "less:    sphere 2k, 1 thread, steps")):  # fmt: skip
            with self.subTest(name=name, factor=factor):
                rows = make_rows()
                scale(rows, kind, name, factor)
                worse, _, said = compare(rows)
                self.assertEqual(worse, expected, said)
                self.assertIn(text, said)

    def test_other_results_are_flagged(self):
        rows = make_rows()
        rows[(*CASE, "hash", "end")][5] = "0edcba9876543210"
        rows[(*CASE, "memory", "allocator_calls")][5] = "1"
        worse, _, said = compare(rows)
        self.assertEqual(worse, 2)
        self.assertIn("end in another state", said)
        self.assertIn("allocator_calls: 1, was 0", said)

    def test_other_conditions_are_told(self):
        rows = make_rows()
        scale(rows, "time", "solve_motion", 2.0)
        scale(rows, "instructions", "steps", 2.0)
        rows[(*ABOUT, "about", "processor")][5], rows[(*ABOUT, "about", "compiler")][5] = "two", "clang"
        worse, _, said = compare(rows)
        self.assertEqual(worse, 0)
        self.assertIn("another processor", said)
        self.assertIn("another compiler", said)

        rows = make_rows()
        rows[(*CASE, "hash", "start")][5], rows[(*CASE, "count", "contacts")][5] = "f", "1"
        worse, _, said = compare(rows)
        self.assertEqual(worse, 0)
        self.assertIn("starts from another state", said)

        rows = make_rows()
        scale(rows, "time", "step", 3.0)
        scale(rows, "time", "solve_motion", 3.0)
        worse, _, said = compare(rows)
        self.assertEqual(worse, 0)
        self.assertIn("other work ran beside", said)
        scale(rows, "time", "processor", 1.2)
        self.assertEqual(compare(rows)[0], 0)
        scale(rows, "time", "processor", 1.1)
        self.assertEqual(compare(rows)[0], 1)

    def test_a_case_that_is_new_is_told(self):
        rows = {**make_rows()}
        measures.put(rows, ("net", "2k", "1"), "time", "step", [1.0])
        worse, _, said = compare(rows)
        self.assertEqual(worse, 0)
        self.assertIn("1 cases are not in the baseline", said)


if __name__ == "__main__":
    unittest.main()
