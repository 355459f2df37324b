"""Detectors and the judge."""
from __future__ import annotations

import numpy as np
import pytest
import tulle


@pytest.fixture
def two(sheet: tulle.Mesh, ball: tulle.Mesh) -> tuple:
    """A sheet that goes through a ball, as one detector sees both."""
    start = np.concatenate([sheet.positions, ball.positions])
    end = start.copy()
    end[:sheet.vertex_count, 2] -= 1
    triangles = np.concatenate([sheet.triangles, ball.triangles + sheet.vertex_count])
    surfaces = [tulle.DetectSurface(vertex_end=sheet.vertex_count, triangle_end=sheet.triangle_count, thickness=1e-3),
                {"vertex_begin": sheet.vertex_count, "vertex_end": start.shape[0], "triangle_begin": sheet.triangle_count,
                 "triangle_end": triangles.shape[0], "is_obstacle": True, "is_static": True}]
    return triangles, surfaces, start, end


def test_events(two: tuple) -> None:
    triangles, surfaces, start, end = two
    with tulle.Detector(triangles, len(start), surfaces=surfaces, threads=1) as detector:
        found = detector.find_events(start, end)
        assert found.events.size and found.earliest_time == found.events["time"].min()
        assert found.statistics.tested_pairs >= found.events.size
        earliest = detector.find_earliest(start, end)
        assert earliest.events.size == 1 and earliest.earliest_time == found.earliest_time
        parts: list[np.ndarray] = []
        detector.stream_events(start, end, parts.append)
        assert np.array_equal(np.concatenate(parts), found.events)
        assert detector.find_events(start, start).events.size == 0
        assert detector.patches is not None and detector.patches.shape == (triangles.shape[0],)
        with pytest.raises(ZeroDivisionError):
            detector.stream_events(start, end, lambda events: 1 / 0)
        assert detector.stream_events(start, end, lambda events: True).events.size == 0
        with pytest.raises(tulle.BusyError):
            detector.stream_events(start, end, lambda events: detector.find_events(start, end))
        with pytest.raises(tulle.InvalidArgumentError, match="start should have the shape"):
            detector.find_events(start[1:], end)
        broken = end.copy()
        broken[5] = np.inf
        with pytest.raises(tulle.InvalidArgumentError, match="5"):
            detector.find_events(start, broken)
    with pytest.raises(tulle.ClosedError):
        detector.find_events(start, end)


def test_which_surfaces_meet(two: tuple) -> None:
    triangles, surfaces, start, end = two
    blind = tulle.Detector(triangles, len(start), surfaces=surfaces, collides=[[True, False], [False, False]])
    assert blind.find_events(start, end).events.size == 0
    with pytest.raises(tulle.InvalidArgumentError, match=r"\(2, 2\)"):
        tulle.Detector(triangles, len(start), surfaces=surfaces, collides=[[1]])


def test_the_judge(sheet: tulle.Mesh, ball: tulle.Mesh) -> None:
    judge = tulle.Judge(threads=1)
    assert judge.find_intersections([sheet], [ball]).is_clean
    through = judge.find_intersections([sheet.transform(translation=(0, 0, -0.5))], [ball])
    assert not through.is_clean and set(through.pairs["body_b"]) == {1} and through.tested_pair_count >= through.pairs.size
    assert judge.find_intersections([], [ball, ball]).is_clean and judge.find_intersections([]).is_clean
    with pytest.raises(tulle.InvalidMeshError):
        judge.find_intersections([tulle.Mesh(sheet.positions, [[0, 1, 9999]])])
    with pytest.raises(tulle.InvalidArgumentError):
        tulle.Judge(threads=1000).find_intersections([sheet])
