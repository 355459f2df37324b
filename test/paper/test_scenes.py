"""Every run that the figures need has a scene in the source tree, which --quick makes coarser and shorter."""
import json
import os
import subprocess
import unittest
from pathlib import Path

from reproduce.children import Interrupts
from reproduce.figures import FIGURES, list_runs
from reproduce.frames import choose_frames, choose_stride
from reproduce.progress import Progress
from reproduce.recorded import Frame, RecordedRun
from reproduce.runs import find_scene_file, has_scene, list_words
from reproduce.scenes import SCENES, Run
from reproduce.session import Session
from reproduce.stills import choose_stills


def make_session(is_quick: bool) -> Session:
    """The session as it is in the source tree."""
    return Session(directory=Path("none"), scenes=Path(os.environ["TULLE_SOURCE_DIR"]) / "scenes" / "paper",
                   program=Path(os.environ["TULLE"]), measure=Path("none"), is_quick=is_quick, still_size="16x10",
                   threads=1, interrupts=Interrupts(), progress=Progress())


def read_facts(session: Session, scene: str) -> dict:
    """What the program tells of a scene as it is run."""
    words = [str(session.program), "info", "--json", *list_words(session, Run(scene))]
    return json.loads(subprocess.run(words, check=True, capture_output=True, text=True).stdout)


class Scenes(unittest.TestCase):
    def test_every_run_has_a_scene(self):
        runs = list_runs()
        self.assertGreater(len(runs), 24)
        self.assertEqual(len(runs), len(set(runs)))
        for run in runs:
            self.assertTrue(has_scene(make_session(False), run), run)
            self.assertIn(run.scene, SCENES)

    def test_quick_scenes_are_coarser_and_shorter(self):
        for scene in SCENES:
            with self.subTest(scene=scene):
                whole, coarse = (read_facts(make_session(is_quick), scene) for is_quick in (False, True))
                vertices = [sum(cloth["vertices"] for cloth in facts["cloths"]) for facts in (whole, coarse)]
                self.assertLess(3 * vertices[1], 2 * vertices[0])
                self.assertLessEqual(SCENES[scene].quick_frames, whole["frames"])

    def test_scenes_that_share_a_file_differ_in_a_value(self):
        low, high = (find_scene_file(make_session(False), run) for run in FIGURES[0].runs)
        self.assertEqual(low[0], high[0])
        self.assertEqual((low[1], high[1]), ((), ("cloth[0].material.friction=1.28",)))


class Frames(unittest.TestCase):
    def test_frames_that_are_looked_at_are_few(self):
        for frames in range(2, 300):
            for most in range(1, 40):
                looked_at = range(1, frames, choose_stride(frames, most))
                self.assertEqual(looked_at, choose_frames(frames, most))
                self.assertTrue(1 <= len(looked_at) <= most)
                self.assertTrue(frames > most or len(looked_at) == frames - 1)

    def test_stills_ascend_and_end_with_the_last_frame(self):
        for scene in SCENES:
            for count in range(1, 200):
                frames = [Frame(0, 0.0, "0")] * count
                stills = choose_stills(RecordedRun(Path(), "finished", "0", 0.01, (), frames), Run(scene))
                self.assertEqual(len(stills), 3)
                self.assertEqual(stills[-1], count - 1)
                if count > 3:
                    self.assertEqual(stills, sorted(set(stills)))
        self.assertEqual(choose_stills(RecordedRun(Path(), "running", "0", 0.01, (), []), Run("rings")), [])


if __name__ == "__main__":
    unittest.main()
