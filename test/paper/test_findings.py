"""What is said of the numbers: rankings and claims of Table 1, ratios and angles of Fig. 7, slipping and staying."""
import contextlib
import io
import math
import unittest

from reproduce import counterexamples, fig6, fig7, table1
from reproduce.judge import Verdict
from reproduce.recorded import STAGES
from reproduce.table1 import CGM, CS, DYN, Cell


def make_cells(cs: dict[str, float], cgm: float = 1.0, conditions: str = "01234567", steps: int = 10) -> table1.Cells:
    """Cells with costs of detection [ms]."""
    cells = {}
    for method in table1.METHODS:
        verdict = Verdict(7, 0, 0, "finished", 0.02, conditions, 81, 128, 8, 6, has_reports=True, steps=steps)
        sums = {CS: cs[method] * steps / 1000.0, DYN: 0.001, CGM: cgm * steps / 1000.0}
        cells[method] = Cell(verdict, steps, sums, 0.5)
    return cells


class Table1(unittest.TestCase):
    def test_costs_are_of_stages_that_there_are(self):
        self.assertLessEqual(set(table1.STAGE_COSTS), set(STAGES))
        self.assertEqual(set(table1.STAGE_COSTS.values()), {CS, CGM})

    def test_ranking_tells_what_the_noise_hides(self):
        cells = make_cells({"paper": 3.0, "bvox": 1.0, "refit": 2.0, "patches": 2.1})
        self.assertEqual(table1.rank(cells, table1.PAPER_METHODS, 1.1), "bvox < refit < paper")
        self.assertEqual(table1.rank(cells, tuple(table1.METHODS), 1.1), "bvox < refit ~ patches < paper")
        self.assertEqual(table1.rank(cells, tuple(table1.METHODS), 1.04), "bvox < refit < patches < paper")

    def test_a_claim_is_confirmed_beyond_the_noise_only(self):
        costs = {"paper": 1.0, "bvox": 2.0, "refit": 4.0, "patches": 1.0}
        self.assertEqual(table1.judge_claim(make_cells(costs), 1.5), "confirmed")
        self.assertEqual(table1.judge_claim(make_cells(costs), 2.5), "within the noise")
        self.assertEqual(table1.judge_claim(make_cells({**costs, "refit": 0.5}), 1.5), "not confirmed")
        self.assertEqual(table1.judge_claim(make_cells({**costs, "bvox": 1.0, "refit": 0.9}), 1.2), "within the noise")

    def test_the_disturbance_is_that_of_the_same_work(self):
        cells = make_cells({method: 1.0 for method in table1.METHODS})
        self.assertEqual(table1.compute_disturbance(cells), 1.0)
        cells["paper"].sums[CGM] *= 9.0
        cells["refit"].sums[CGM] *= 1.25
        self.assertAlmostEqual(table1.compute_disturbance(cells), 1.25)

    def test_runs_of_different_conditions_or_without_times_are_not_compared(self):
        cells = make_cells({method: 1.0 for method in table1.METHODS})
        self.assertEqual(table1.format_finding(1, cells), "1,paper < bvox < refit,paper ~ bvox ~ refit,"
                         "within the noise,paper ~ bvox ~ refit ~ patches,1")
        not_compared = "1,paper < bvox < refit,,not compared,,"
        said = io.StringIO()
        with contextlib.redirect_stderr(said):
            for conditions in ("mixed", "unknown"):
                self.assertEqual(table1.format_finding(1, make_cells({m: 1.0 for m in cells}, conditions=conditions)),
                                 not_compared)
            cells["bvox"].verdict.conditions = "76543210"
            self.assertEqual(table1.format_finding(1, cells), not_compared)
        self.assertEqual(said.getvalue().count("animation 1: its times are not compared"), 3)
        cells["bvox"].verdict.conditions = "01234567"
        cells["refit"].verdict.has_reports = False
        self.assertEqual(table1.format_finding(1, cells), not_compared)
        del cells["paper"]
        self.assertIsNone(table1.format_finding(1, cells))

    def test_a_cell_without_times_is_empty(self):
        cell = make_cells({method: 1.0 for method in table1.METHODS})["bvox"]
        self.assertEqual(table1.format_cell(3, "bvox", cell), "3,bvox,81,128,8,6,10,1,0.1,1,50,finished,0,01234567")
        cell.steps = 0
        self.assertEqual(table1.format_cell(3, "bvox", cell), "3,bvox,81,128,8,6,0,,,,,finished,0,01234567")


class Fig7(unittest.TestCase):
    def test_a_ratio_is_judged_beyond_the_noise_only(self):
        self.assertEqual([fig7.judge_ratio(ratio, 1.1) for ratio in (1.2, 1.05, 0.95, 0.8)],
                         ["yes", "within the noise", "within the noise", "no"])

    def test_the_best_angle_is_that_of_the_paper_or_near_to_it(self):
        means = {30: 3.0, 60: 2.0, 85: 1.0, 89: 1.5}
        self.assertEqual(fig7.judge_best(means, 1.1), (85, "yes"))
        self.assertEqual(fig7.judge_best({**means, 89: 0.95}, 1.1), (89, "within the noise"))
        self.assertEqual(fig7.judge_best({**means, 89: 0.5}, 1.1), (89, "no"))

    def test_rows_are_whole_numbers_to_their_end(self):
        row = "0.5,1e-06,2.5e-3,0.25,1,0,3,4,5"
        self.assertEqual(fig7.parse_times(row), fig7.Times(0.5, 1e-6, 2.5e-3, 0.25, 1.0, 0.0, 3, 4, 5))
        for damaged in (None, "", row + "7x", row[:-1], row + ",1", " " + row, row.replace("0.25", "nan"),
                        row.replace("0.25", "")):
            self.assertIsNone(fig7.parse_times(damaged), damaged)

    def test_shares_are_of_the_whole(self):
        self.assertEqual(fig7.Times(total=4.0).compute_share(1.0), 25.0)
        self.assertEqual(fig7.Times().compute_share(1.0), 0.0)


class Counterexamples(unittest.TestCase):
    def test_rows_are_whole_numbers_to_their_end(self):
        self.assertEqual(counterexamples.parse_counts("9,1,7,2,0"), counterexamples.Counts(9, 1, 7, 2, 0))
        for damaged in (None, "", "9,1,7,2", "9,1,7,2,", "9,1,7,2,0,", "9,1,7,2,0x", "9,1,7,-2,0"):
            self.assertIsNone(counterexamples.parse_counts(damaged), damaged)


class Fig6(unittest.TestCase):
    def test_findings(self):
        self.assertEqual(fig6.format_finding("higher", 1.0, 2.0, True), "higher,1,2,yes")
        self.assertEqual(fig6.format_finding("higher", 2.0, 1.0, True), "higher,2,1,no")
        self.assertEqual(fig6.format_finding("lower", 2.0, 1.0, False), "lower,2,1,yes")
        self.assertEqual(fig6.format_finding("higher", math.nan, 1.0, True), "higher,,,not known")

    def test_the_end_is_the_last_quarter(self):
        facts = [fig6.FrictionFacts(0.5, float(frame), 1.0) for frame in range(1, 41)]
        self.assertEqual(fig6.compute_last(facts).way, sum(range(30, 41)) / 11)
        self.assertEqual(fig6.compute_last(facts[:1]).way, 1.0)
        facts[-1].stick_share = math.nan
        self.assertEqual(fig6.compute_last(facts).format(), ",35,1")


if __name__ == "__main__":
    unittest.main()
