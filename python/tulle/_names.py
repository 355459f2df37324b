"""The public names of the package."""
from tulle._arrays import StateArray
from tulle._library import version as __version__
from tulle.animation import Animation, write_animation
from tulle.detector import Detection, Detector, Judge, Verdict
from tulle.errors import *  # noqa: F403
from tulle.fit import Fit, fit_material
from tulle.mesh import Mesh, make_shape
from tulle.notebook import View, show
from tulle.objects import Attachment, Body, Cloth, Object, Obstacle
from tulle.plots import plot_report
from tulle.program import check_files, convert, detect_files, find_program, render, run_program, simulate
from tulle.run import PointCache, PointCacheWriter, Run, RunBody, RunFrame, RunWriter
from tulle.scene import Scene
from tulle.structs import *  # noqa: F403
from tulle.world import STAGES, World, list_materials, make_material, replay, step_worlds

__all__ = [name for name in dir() if not name.startswith("_")]
