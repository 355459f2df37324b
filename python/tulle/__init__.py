"""Tulle: a cloth simulator that never lets cloth pass through anything.

>>> import tulle
>>> world = tulle.World()
>>> cloth = world.add_cloth(tulle.make_shape("rectangle", resolution=20).transform(translation=(0, 0, 0.5)))
>>> ball = world.add_obstacle(tulle.make_shape("sphere", radius=0.3))
>>> for _ in range(90):
...     report = world.step(1 / 90)

All quantities are in SI units: metres, kilograms, seconds, radians. docs/guide/python.md tells the rest.
"""
from tulle._arrays import StateArray
from tulle._library import version as __version__
from tulle.detector import Detection, Detector, Judge, Verdict
from tulle.errors import *  # noqa: F403
from tulle.mesh import Mesh, make_shape
from tulle.notebook import View, show
from tulle.objects import Attachment, Body, Cloth, Object, Obstacle
from tulle.plots import plot_report
from tulle.program import check_files, convert, detect_files, find_program, render, run_program, simulate
from tulle.run import PointCache, PointCacheWriter, Run, RunBody, RunFrame, RunWriter
from tulle.scene import Scene
from tulle.structs import *  # noqa: F403
from tulle.world import STAGES, World, list_materials, make_material, replay, step_worlds
