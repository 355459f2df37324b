"""Rows that are kept: found in any order, never under another head, and of a cut file only whole rows."""
import tempfile
import unittest
from pathlib import Path

from reproduce.kept import Kept

HEAD = "# build 1\nframe,count\n"
ROWS = 300


class Rows(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.path = Path(directory.name) / "rows.csv"
        kept = self.open()
        for row in range(ROWS):
            kept.add(f"{row},{7 * row}")
        kept.save()

    def open(self, head: str = HEAD) -> Kept:
        return Kept(self.path, head, 1)

    def test_rows_are_found_in_any_order(self):
        kept = self.open()
        for row in [*range(ROWS), *reversed(range(ROWS)), *(i * 91 % ROWS for i in range(ROWS))]:
            self.assertEqual(kept.find(str(row)), str(7 * row))
        self.assertIsNone(kept.find(str(ROWS)))
        kept.add(f"{ROWS},5")
        self.assertEqual(kept.find(str(ROWS)), "5")
        self.assertEqual(kept.find("1"), "7")
        kept.forget()
        self.assertIsNone(kept.find("1"))
        kept.save()
        self.assertEqual(self.path.read_text(), HEAD)

    def test_a_key_is_whole_columns(self):
        kept = self.open()
        kept.add("1000,paper,3")
        self.assertIsNone(kept.find("100"[:2] + "x"))
        self.assertEqual(kept.find("1000"), "paper,3")
        self.assertEqual(Kept(self.path, HEAD, 2).find("10,70"), "")

    def test_the_last_row_of_a_key_counts(self):
        kept = self.open()
        kept.add("3,damaged")
        kept.add("3,21")
        self.assertEqual(kept.find("3"), "21")
        self.assertEqual(len(kept.rows), ROWS + 2)

    def test_rows_under_another_head_are_not_given(self):
        for head in ("# build 2\nframe,count\n", "# build 1\nframe,number\n", "# build 1\nframe,count\n0,0,0\n"):
            kept = self.open(head)
            for row in range(ROWS):
                self.assertIsNone(kept.find(str(row)))
        self.assertEqual(self.open().find(str(ROWS - 1)), str(7 * (ROWS - 1)))  # looking does not change the file

    def test_of_a_cut_file_only_whole_rows_are_given(self):
        data = self.path.read_bytes()
        for cut in range(len(data)):
            self.path.write_bytes(data[:cut])
            kept = self.open()
            for row in range(0, ROWS, 37):
                self.assertIn(kept.find(str(row)), (None, str(7 * row)))
        middle = len(data) // 2
        for byte in (b"\0", b"\xff"):
            self.path.write_bytes(data[:middle] + byte + data[middle + 1:])
            self.assertIsNone(self.open().find("0"))


if __name__ == "__main__":
    unittest.main()
