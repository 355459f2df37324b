"""Run directories: what is whole is read, what is damaged is told."""
import json
import struct
import tempfile
import unittest
from pathlib import Path

import numpy as np

from reproduce.recorded import RESCUES, STAGES, read_reports, read_run
from reproduce.session import DamagedRun

FRAMES, VERTICES = 4, 3
COLUMNS = ["step", "time", "total_seconds", *(f"{stage}_seconds" for stage in STAGES), "contacts", "stick_contacts",
           "slip_contacts", *RESCUES, "smallest_gap"]


class Run(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.directory = Path(directory.name)
        bodies = [{"name": "sheet", "role": "cloth", "vertices": VERTICES, "triangles": 1, "cache": "sheet.pc2"},
                  {"name": "ground", "role": "obstacle", "vertices": 4, "triangles": 2, "cache": None}]
        self.write("run.json", json.dumps({"state": "finished", "scene_hash": "0123456789abcdef", "time_step": 0.02,
                                           "bodies": bodies}))
        self.write("frames.csv", "frame,time,step,state_hash,absent,lags\n"
                   + "".join(f"{i},{0.02 * i},{i},{i:016x},,\n" for i in range(FRAMES)))
        self.positions = np.arange(FRAMES * VERTICES * 3, dtype="<f4").reshape(FRAMES, VERTICES, 3)
        self.write_cache()
        self.write("report.csv", ",".join(COLUMNS) + "\n"
                   + "".join(",".join([str(step), *["0.5"] * (len(COLUMNS) - 2), ""]) + "\n"
                             for step in range(FRAMES - 1)))

    def write(self, name: str, text: str):
        (self.directory / name).write_text(text, encoding="utf-8")

    def write_cache(self, vertices: int = VERTICES, frames: int = FRAMES):
        head = struct.pack("<12siiffi", b"POINTCACHE2\0", 1, vertices, 0.0, 1.0, frames)
        (self.directory / "sheet.pc2").write_bytes(head + self.positions.tobytes())

    def change(self, name: str, old: str, new: str):
        text = (self.directory / name).read_text(encoding="utf-8")
        self.assertIn(old, text)
        self.write(name, text.replace(old, new))

    def test_a_whole_run_is_read(self):
        run = read_run(self.directory)
        self.assertEqual((run.state, run.scene_hash, run.time_step), ("finished", "0123456789abcdef", 0.02))
        self.assertEqual([frame.step for frame in run.frames], [0, 1, 2, 3])
        self.assertEqual([body.name for body in run.cloths], ["sheet"])
        self.assertEqual(run.describe(), "scene 0123456789abcdef frames 4 last 0000000000000003")
        np.testing.assert_array_equal(run.read_cloth(2), self.positions[2])
        self.assertEqual(run.read_reports().count, 3)

    def test_frames_are_those_that_are_in_every_file(self):
        self.write_cache(frames=3)
        self.assertEqual(len(read_run(self.directory).frames), 3)
        self.write_cache()
        with open(self.directory / "sheet.pc2", "r+b") as file:
            file.truncate(32 + 12 * VERTICES * 2 + 5)
        self.assertEqual(len(read_run(self.directory).frames), 2)
        self.write_cache()
        text = (self.directory / "frames.csv").read_text(encoding="utf-8")
        self.write("frames.csv", text[:-4])
        self.assertEqual(len(read_run(self.directory).frames), 3)
        (self.directory / "frames.csv").unlink()
        self.assertEqual(read_run(self.directory).frames, [])

    def test_older_frames_know_no_lags(self):
        text = (self.directory / "frames.csv").read_text(encoding="utf-8")
        self.write("frames.csv", text.replace(",lags\n", "\n").replace(",,\n", ",\n"))
        self.assertEqual(len(read_run(self.directory).frames), FRAMES)

    def test_damage_is_told(self):
        for name, old, new, told in (("frames.csv", ",,\n", ",\n", "frames.csv:2: this should be frame 0"),
                                     ("frames.csv", "\n2,", "\n7,", "frames.csv:4: this should be frame 2"),
                                     ("frames.csv", "frame,time", "time,frame", "does not begin with"),
                                     ("run.json", "}]", "}", "is no record of a run"),
                                     ("run.json", "\"state\"", "\"stage\"", "is no record of a run")):
            self.setUp()
            self.change(name, old, new)
            with self.assertRaisesRegex(DamagedRun, told):
                read_run(self.directory)
        self.setUp()
        self.write_cache(vertices=5)
        with self.assertRaisesRegex(DamagedRun, "holds 5 vertices, but run.json says 3"):
            read_run(self.directory)
        (self.directory / "sheet.pc2").unlink()
        with self.assertRaisesRegex(DamagedRun, "cannot be opened"):
            read_run(self.directory)

    def test_positions_are_finite(self):
        self.positions[2, 1, 0] = np.nan
        self.write_cache()
        run = read_run(self.directory)
        run.read_cloth(1)
        with self.assertRaisesRegex(DamagedRun, "frame 2: a coordinate is not finite"):
            run.read_cloth(2)

    def test_reports_of_all_steps_are_needed(self):
        path = self.directory / "report.csv"
        whole = path.read_text(encoding="utf-8")
        run = read_run(self.directory)
        self.write("report.csv", "".join(whole.splitlines(keepends=True)[:-1]) + "2,0.5")
        with self.assertRaisesRegex(DamagedRun, "tells of 2 steps, its frames of 3"):
            run.read_reports()
        for text, told in ((whole.replace("0.5", "x", 1), "report.csv:2: the line should have"),
                           (whole.replace("\n0,", "\n0,0,", 1), "report.csv:2: the line should have"),
                           ("rubbish\n", "the heading has no column step"),
                           (whole.replace("solve_motion", "motion"), "no column solve_motion_seconds")):
            self.write("report.csv", text)
            with self.assertRaisesRegex(DamagedRun, told):
                run.read_reports()
        path.unlink()
        with self.assertRaisesRegex(DamagedRun, "cannot be opened"):
            run.read_reports()

    def test_stages_of_older_reports_are_those_that_hold_them(self):
        old = [part for parts in STAGES.values() for part in parts]
        self.assertEqual(len(old), 12)
        names = [name for name in COLUMNS if name[:-8] not in STAGES] + [f"{part}_seconds" for part in old]
        self.write("report.csv", ",".join(names) + "\n"
                   + ",".join(str(old.index(name[:-8]) if name[:-8] in old else 0) for name in names) + "\n")
        reports = read_reports(self.directory / "report.csv")
        for stage, parts in STAGES.items():
            self.assertEqual(reports.get_stage(stage)[0], sum(old.index(part) for part in parts))


if __name__ == "__main__":
    unittest.main()
