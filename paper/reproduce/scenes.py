"""The scenes: what --quick makes coarser and shorter, where stills are taken, what steps cost, and scenes that share a
file."""
from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Scene:
    """What is told of a scene beyond its file."""

    quick_frames: int  # at most so many with --quick
    quick: tuple[str, ...]  # other values with --quick, as --set takes them
    places: tuple[float, float, float]  # of the stills, shares of a run's frames: cloth on its way, and the end
    cost: float  # [us] about what a step takes for each triangle of cloth; foretells the time
    shared_file: str = ""  # without .yaml: stands in for a scene without a file of its own
    shared: tuple[str, ...] = field(default=())  # other values with that file


# Nets keep their holes, which must not let heads of nails through, and become smaller. Animation 1 ends where the net,
# which has slipped down the slope, meets the small nail.
SCENES = {
    "example_one_low_friction": Scene(300, ("cloth[0].mesh.resolution=[41, 27]",), (30 / 2400, 60 / 2400, 1.0), 15.0,
                                      "example_one"),
    "example_one_high_friction": Scene(300, ("cloth[0].mesh.resolution=[41, 27]",), (30 / 2400, 60 / 2400, 1.0), 10.0,
                                       "example_one", ("cloth[0].material.friction=1.28",)),
    "animation_1": Scene(45, ("cloth[0].mesh.cells=[10, 10]", "cloth[0].mesh.size=[0.75, 0.75]"),
                         (20 / 150, 80 / 150, 1.0), 250.0),
    "animation_2": Scene(80, ("cloth[0].mesh.cells=[12, 12]", "cloth[0].mesh.size=[1.2, 1.2]"),
                         (14 / 150, 26 / 150, 1.0), 80.0),
    "animation_3": Scene(150, ("cloth[0].mesh.resolution=[41, 28]",), (30 / 200, 60 / 200, 1.0), 25.0),
    "animation_4": Scene(100, ("cloth[0].mesh.resolution=[101, 7]",), (40 / 200, 70 / 200, 1.0), 40.0),
    "animation_5": Scene(150, ("cloth[0].mesh.resolution=[41, 28]",), (20 / 200, 40 / 200, 1.0), 16.0),
    "animation_6": Scene(150, ("cloth[0].mesh.resolution=[41, 41]",), (50 / 300, 180 / 300, 1.0), 20.0),
    "rings": Scene(120, ("cloth[0].mesh.resolution=[50, 14]",), (60 / 150, 75 / 150, 1.0), 30.0),
    "ribbons": Scene(80, tuple(f"cloth[{i}].mesh.resolution=[66, 3]" for i in range(9)), (20 / 150, 40 / 150, 1.0),
                     60.0),
}

@dataclass(frozen=True)
class SceneFacts:
    """What `tulle info SCENE --json` tells of a scene as it is run."""

    scene_hash: str
    frames: int  # after the start, those that are wanted
    steps_per_frame: int
    contact_distance: float  # [m]
    cloth_triangles: int


# What goes by the paper's rules gets tangled and takes about so many times as long.
PAPER_COST = 2.0

# Ways of finding pairs: the paper's method goes by its rules, which prove nothing.
METHODS = {
    "paper": ("contact.method=paper", "contact.cone=paper", "contact.certificate=off", "contact.alpha_max=85 deg"),
    "bvox": ("contact.method=bvox",),
    "refit": ("contact.method=refit",),
    "patches": ("contact.method=patches",),
}


@dataclass(frozen=True)
class Run:
    """A scene and the way of finding pairs that it is run with; an empty method: as the scene says."""

    scene: str
    method: str = ""

    @property
    def name(self) -> str:
        """"animation_1.paper"."""
        return f"{self.scene}.{self.method}" if self.method else self.scene

    @property
    def is_proven(self) -> bool:
        """Whether its rules miss nothing."""
        return self.method != "paper"
