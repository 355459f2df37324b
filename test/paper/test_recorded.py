"""Run directories: what is whole is read, what is damaged is told."""
import tempfile
import unittest
from pathlib import Path

import numpy as np
import tulle

from reproduce.recorded import is_run, read_run
from reproduce.session import DamagedRun

FRAMES, STEP = 4, 1 / 90


class Run(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.directory = Path(directory.name, "run")
        sheet = tulle.make_shape("rectangle", resolution=4)
        self.world = tulle.World(threads=1)
        for name, height in (("upper", 2), ("lower", 1)):
            self.world.add_cloth(sheet.transform(translation=(0, 0, height)), name=name)
        self.world.add_obstacle(tulle.make_shape("plane"), name="ground")
        self.positions = []
        with tulle.RunWriter(self.directory, self.world, STEP) as writer:
            for _ in range(FRAMES - 1):
                writer.write_report(self.world.step(STEP))
                writer.write_frame()
                self.positions.append(np.concatenate([cloth.positions for cloth in self.world.cloths]))

    def test_a_whole_run_is_read(self):
        run = read_run(self.directory)
        self.assertTrue(is_run(self.directory))
        self.assertEqual((run.state, run.time_step), ("finished", STEP))
        self.assertEqual([frame.step for frame in run.frames], [0, 1, 2, 3])
        self.assertEqual(run.frames[-1].state_hash, f"{self.world.state_hash:016x}")
        self.assertEqual([body.name for body in run.cloths], ["upper", "lower"])
        self.assertEqual(run.describe(), f"scene {run.scene_hash} frames 4 last {run.frames[-1].state_hash}")
        np.testing.assert_array_equal(run.read_cloth(2), self.positions[1].astype(np.float32))
        self.assertEqual(len(run.read_reports()), FRAMES - 1)

    def test_a_run_that_goes_on_is_read_up_to_its_last_whole_frame(self):
        directory = self.directory.parent / "other"
        writer = tulle.RunWriter(directory, self.world, STEP)
        self.world.step(STEP)
        writer.write_frame()
        run = read_run(directory)
        self.assertEqual((run.state, len(run.frames)), ("running", 2))
        path = directory / "frames.csv"
        path.write_bytes(path.read_bytes()[:-4])
        self.assertEqual(len(read_run(directory).frames), 1)
        writer.close()

    def test_damage_is_told(self):
        run = read_run(self.directory)
        path = self.directory / "upper.pc2"
        whole = path.read_bytes()
        path.write_bytes(whole[:-5] + b"\x07" + whole[-4:])
        run.read_cloth(1)
        with self.assertRaisesRegex(DamagedRun, "frame 3"):
            run.read_cloth(3)
        (self.directory / "run.json").write_text("{}", encoding="utf-8")
        with self.assertRaises(DamagedRun):
            read_run(self.directory)
        self.assertFalse(is_run(self.directory.parent))

    def test_reports_of_all_steps_are_needed(self):
        path = self.directory / "report.csv"
        lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
        for text in ("".join(lines[:-1]), "".join(lines).replace("0.01", "x"), "rubbish\n"):
            path.write_text(text, encoding="utf-8")
            with self.assertRaises(DamagedRun):
                read_run(self.directory).read_reports()
        path.unlink()
        with self.assertRaises(DamagedRun):
            read_run(self.directory).read_reports()


if __name__ == "__main__":
    unittest.main()
