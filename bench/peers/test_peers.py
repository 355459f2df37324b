#!/usr/bin/env python3
"""Checks what bench-peers reads, measures and prints, without any of the peers: stand-ins take their place."""
import array
import pathlib
import struct
import sys
import tempfile
import types
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "tools")]
import cases  # noqa: E402
import drivers  # noqa: E402
import meshes  # noqa: E402
import run  # noqa: E402
import table  # noqa: E402
from markdown_tables import read_rows  # noqa: E402

SQUARE = "v 0 0 1\nv 2 0 1\nv 2 2 1\nv 0 2 1\nf 1 2 3\nf 1 3 4\n"
SCENE = """gravity: [0, 0, -9.81]
cloth:
  -
    name: "cloth"
    material:
      friction: 9
obstacles:
  -
    name: "ground"
    friction: 0.40000000000000002
    restitution: 0
  -
    name: "spike"
    friction: 0.1
"""
# A driver's stand-in: two frames and half of a third, a line of told.txt without an end, and a last word.
STAND_IN = """
import array, sys
with open(sys.argv[1] + "/frames.raw", "wb") as raw:
    array.array("f", [0.0] * 30).tofile(raw)
with open(sys.argv[1] + "/told.txt", "w") as told:
    told.write("version 7.1\\nmessage slow today\\nframe 0 0\\nframe 0.041666667 1.250\\nframe 0.0833")
print("Error: out of wool")
sys.exit(3)
"""


def make_row(**values):
    row = dict.fromkeys(table.COLUMNS, "")
    row.update(scene="sphere", variant="as it is", motion="1.0", cpu="20", cpu_per_frame="0.8333", self_pairs="0", obstacle_pairs="0",
               bad_frames="0", frames="24", stretch_99="0.04", stretch_most="0.2", lowest="0.5", memory_mb="80")  # fmt: skip
    return {**row, **values}


class InFolder(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.temporary.name)
        (self.folder / "cloth.obj").write_text(SQUARE, encoding="utf-8")
        (self.folder / "ground.obj").write_text(SQUARE, encoding="utf-8")
        (self.folder / "spike.001.obj").write_text(SQUARE, encoding="utf-8")
        (self.folder / "scene.yaml").write_text(SCENE, encoding="utf-8")

    def tearDown(self):
        self.temporary.cleanup()


class Meshes(InFolder):
    def test_stretch_is_of_each_edge_once(self):
        mesh = meshes.Mesh(self.folder / "cloth.obj")
        self.assertEqual((len(mesh.edges), mesh.area), (5, 4.0))
        wide = [value * (1.5 if k % 3 == 0 else 1) for k, value in enumerate(sum(mesh.vertices, ()))]
        stretches = mesh.get_stretches(wide)
        self.assertEqual([round(value, 6) for value in stretches], [0, 0, round(13**0.5 / 8**0.5 - 1, 6), 0.5, 0.5])

    def test_percentile_is_the_least_that_enough_do_not_pass(self):
        self.assertEqual(meshes.get_percentile(list(range(1, 101)), 99), 99)
        self.assertEqual(meshes.get_percentile([1, 2, 3], 99), 3)

    def test_frames_are_read_whole_or_not(self):
        path = self.folder / "raw"
        path.write_bytes(b"head" + array.array("f", range(15)).tobytes())
        self.assertEqual([list(frame) for frame in meshes.read_frames(path, 2, skipped=4)], [list(range(6)), list(range(6, 12))])

    def test_cache_is_a_point_cache(self):
        meshes.write_cache(self.folder / "c.pc2", [array.array("f", [1, 2, 3])] * 2)
        data = (self.folder / "c.pc2").read_bytes()
        self.assertEqual(struct.unpack("<12siiffi", data[:32]), (b"POINTCACHE2\0", 1, 1, 0.0, 1.0, 2))
        self.assertEqual(len(data), 32 + 24)

    def test_what_is_not_finite_is_seen(self):
        self.assertFalse(meshes.is_finite([0.0, float("nan"), 1.0]))
        self.assertFalse(meshes.is_finite([float("inf")]))
        self.assertTrue(meshes.is_finite([0.0, -5.0]))

    def test_the_judges_sums_are_not_a_file(self):
        text = '{"source":"a.obj","intersections":3,"pairs":[]}\n{"frames":1,"frames_with_intersections":1,"intersections":3}\n'
        self.assertEqual(meshes.parse_counts(text), [3])


class Drivers(InFolder):
    def make_physics(self):
        return cases.Physics(self.folder, meshes.Mesh(self.folder / "cloth.obj"))

    def test_physics_come_from_the_scene(self):
        physics = self.make_physics()
        self.assertAlmostEqual(physics.mass, 0.6)
        self.assertAlmostEqual(physics.get_friction("x/ground.obj"), 0.4)
        self.assertAlmostEqual(physics.get_friction("x/spike.001.obj"), 0.2)

    def test_every_case_can_be_written(self):
        options = types.SimpleNamespace(frames=24, limit=60.0)
        for tool, variant, settings, make in cases.PEERS:
            drivers.write_case(self.folder / "case.txt", self.make_physics(), self.folder, options, make(self.make_physics()))
            lines = (self.folder / "case.txt").read_text(encoding="utf-8").splitlines()
            self.assertEqual(sum(line.startswith("obstacle ") for line in lines), 2, (tool, variant))
            self.assertTrue(settings and all(len(line.split(" ")) in (2, 3, 4) for line in lines))

    def test_a_driver_that_fails_leaves_what_it_reached(self):
        options = types.SimpleNamespace(frames=24, limit=5.0)
        kept = drivers.get_command
        drivers.get_command = lambda tool, folder: ([sys.executable, "-c", STAND_IN, str(folder)], None)
        try:
            result = drivers.run_peer(options, "Wool", {}, self.make_physics(), self.folder, self.folder / "out")
        finally:
            drivers.get_command = kept
        self.assertEqual((result.times, result.cpu, len(result.frames)), ([0.0, 0.041666667], [0.0, 1.25], 2))
        self.assertEqual((result.version, result.message), ("7.1", "slow today exit code 3: Error: out of wool"))
        self.assertGreater(result.memory, 1e6)

    def test_what_is_not_there_is_skipped(self):
        kept, drivers.shutil = drivers.shutil, types.SimpleNamespace(which=lambda name: None)
        try:
            result = drivers.run_peer(types.SimpleNamespace(frames=1, limit=1.0), "Blender", {}, self.make_physics(), self.folder, self.folder)
        finally:
            drivers.shutil = kept
        self.assertEqual((result.message, result.frames), ("skipped: not installed: blender", []))

    def test_progress_gives_frames(self):
        lines = [f'{{"event":"step","step":{k},"time":{k / 90}}}\n' for k in range(1, 7)] + ["tulle run: a word\n", '{"event":"end"}\n']
        times, cpu = drivers.read_progress(lines, 3, iter([0.5, 0.75]).__next__)
        self.assertEqual((times, cpu), ([3 / 90, 6 / 90], [0.5, 0.75]))

    def test_drivers_in_python_are_python(self):
        compile((HERE / "blender_driver.py").read_text(encoding="utf-8"), "blender_driver.py", "exec")


class Tables(unittest.TestCase):
    def test_interpolation(self):
        self.assertAlmostEqual(run.interpolate([0, 1, 3], [0, 2, 4], 2), 3)
        self.assertEqual(run.interpolate([0, 1, 3], [0, 2, 4], 9), 4)

    def test_rows(self):
        row = make_row(tool="Blender", variant="x", tulle_cpu="5", obstacle_pairs="12", lowest="-0.2", stretch_most="5e3")
        cells = table.format_row(row)
        self.assertEqual(cells, ["sphere", "Blender, x", "0.833", "4 x", "1.00", "0", "12 (under the ground)", "0 of 24", "4.0 %",
                                 "over 1000 %", "80"])  # fmt: skip
        self.assertEqual(len(cells), len(table.HEAD))
        skipped = table.format_row(make_row(tool="Bullet", stretch_99="", message="skipped: not installed: x"))
        self.assertEqual((skipped[2], len(skipped)), ("skipped: not installed: x", len(table.HEAD)))

    def test_goals_are_told_as_they_are(self):
        rows = [make_row(tool="Tulle", stretch_99="0.051"),
                make_row(tool="Blender", variant="default quality", tulle_cpu="19", cpu="20"),
                make_row(tool="MuJoCo", variant="ipc", tulle_cpu="5", cpu="500")]  # fmt: skip
        lines = table.judge_goals(rows).splitlines()[2:]
        self.assertEqual([line.endswith("**does not hold** |") for line in lines], [True, False, False, False, True])
        self.assertIn("1.1 times over 1.00 s", lines[0])
        self.assertIn("not measured", lines[1])
        rows.append(make_row(tool="Tulle", variant="one step a frame", cpu_per_frame="0.1"))
        self.assertIn("| 8.3 times | holds |", table.judge_goals(rows))
        rows.pop()
        rows.pop()
        self.assertIn("not measured", table.judge_goals(rows))

    def test_the_page_holds_the_committed_rows(self):
        texts = table.make_texts(read_rows(HERE.parent / "peers.csv"))
        page = (HERE.parents[1] / "lab" / "benchmarks.md").read_text(encoding="utf-8")
        for name, text in texts.items():
            self.assertIn(f"<!-- begin {name} -->\n{text}\n<!-- end {name} -->", page)


if __name__ == "__main__":
    unittest.main()
