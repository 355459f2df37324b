"""What the tests share."""
from __future__ import annotations

from pathlib import Path

import pytest
import tulle

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def sheet() -> tulle.Mesh:
    """A sheet half a metre above the origin."""
    return tulle.make_shape("rectangle", size=(1, 1), resolution=12).transform(translation=(0, 0, 0.5))


@pytest.fixture
def ball() -> tulle.Mesh:
    """A ball at the origin."""
    return tulle.make_shape("sphere", radius=0.3, resolution=6)


@pytest.fixture
def world(sheet: tulle.Mesh, ball: tulle.Mesh) -> tulle.World:
    """A sheet over a ball, not started."""
    made = tulle.World(threads=1)
    made.add_cloth(sheet, name="sheet")
    made.add_obstacle(ball, name="ball")
    return made
