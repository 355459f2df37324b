"""The directory of a run as the figures use it, read by the package `tulle`, which compares what it reads with its checksums."""
from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import tulle

from reproduce.session import DamagedRun

STAGES = tulle.STAGES
RESCUES = ("rescue_impact_zones", "rescue_component_scalings", "rescue_global_scalings")


@dataclass(frozen=True)
class Frame:
    """A whole frame."""

    step: int  # steps done
    time: float  # [s]
    state_hash: str  # 16 hexadecimal digits


@dataclass(frozen=True)
class RecordedRun:
    """What a run directory holds."""

    directory: Path
    state: str  # "running" (or killed), "finished", "interrupted", "failed"
    scene_hash: str
    time_step: float  # [s]
    bodies: tuple[tulle.RunBody, ...]
    frames: list[Frame]

    @property
    def cloths(self) -> list[tulle.RunBody]:
        """Its cloths."""
        return [body for body in self.bodies if not body.is_obstacle]

    def describe(self) -> str:
        """Which frames these are, on one line: what is measured in them depends on it."""
        return f"scene {self.scene_hash} frames {len(self.frames)} last {self.frames[-1].state_hash}"

    def read_cloth(self, frame: int) -> np.ndarray:
        """Positions [m] of the vertices of all cloths, one behind the other."""
        try:
            return np.concatenate([body.read_positions(frame) for body in self.cloths])
        except tulle.Error as error:
            raise DamagedRun(str(error)) from error

    def read_reports(self) -> np.ndarray:
        """The reports of all steps that the frames tell of, as STEP_REPORT records; DamagedRun where there are fewer."""
        try:
            with tulle.Run(self.directory) as run:
                reports = run.reports
        except tulle.Error as error:
            raise DamagedRun(str(error)) from error
        steps = self.frames[-1].step if self.frames else 0
        if len(reports) < steps:
            raise DamagedRun(f"its report.csv tells of {len(reports)} steps, its frames of {steps}")
        return reports


def is_run(directory: Path) -> bool:
    """Whether the directory holds a run.json."""
    return (directory / "run.json").is_file()


def read_run(directory: Path) -> RecordedRun:
    """Opens a run directory; runs that go on or were killed are read up to their last whole frame."""
    try:
        run = tulle.Run(directory)
        frames = [Frame(frame.step, frame.time, f"{frame.state_hash:016x}") for frame in run.frames]
    except tulle.Error as error:
        raise DamagedRun(str(error)) from error
    return RecordedRun(directory, run.state.name.lower(), f"{run.scene_hash:016x}", run.time_step, run.bodies, frames)
