"""Arrays given and got: shapes, types, stale ones."""
from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
import tulle

STEP = 1 / 90


@pytest.mark.parametrize(("positions", "words"), [
    (np.zeros((3, 4)), "transpose"), (np.zeros(12), "reshape"), (np.zeros((4, 2)), r"\(n, 3\)"),
    (np.zeros((4, 3), complex), "complex128"), (np.zeros((4, 3), "U1"), "real numbers"), ([[0, 0, 0], [1, 2]], "numbers"),
    (None, "real numbers"), (np.zeros((4, 3), object), "object")])
def test_positions_that_are_wrong(positions: object, words: str) -> None:
    with pytest.raises(tulle.InvalidArgumentError, match=words):
        tulle.Mesh(positions, [[0, 1, 2]])


@pytest.mark.parametrize(("triangles", "words"), [
    (np.zeros((1, 3)), "astype"), ([[0, 1, -1]], "from 0"), ([[0, 1, 2**32]], "from 0"), ([0, 1, 2], "reshape"),
    (np.array([["a", "b", "c"]]), "whole")])
def test_triangles_that_are_wrong(triangles: object, words: str) -> None:
    with pytest.raises(tulle.InvalidArgumentError, match=words):
        tulle.Mesh(np.zeros((4, 3)), triangles)


def test_arrays_with_gaps_and_other_types_are_taken(sheet: tulle.Mesh) -> None:
    wide = np.zeros((sheet.vertex_count, 7))
    wide[:, 2:5] = sheet.positions
    gaps = tulle.Mesh(wide[:, 2:5], np.asfortranarray(sheet.triangles.astype(np.int64)))
    assert gaps.get_info().area == sheet.get_info().area
    assert tulle.Mesh(sheet.positions, sheet.triangles).positions is sheet.positions, "what fits is not copied"
    coarse = tulle.Mesh(sheet.positions.astype(np.float32), sheet.triangles)
    assert coarse.positions.dtype == np.float64


def test_nan_is_refused(sheet: tulle.Mesh) -> None:
    broken = tulle.Mesh(sheet.positions.copy(), sheet.triangles)
    broken.positions[7, 1] = np.nan
    with pytest.raises(tulle.InvalidMeshError, match="vertex 7"):
        tulle.World().add_cloth(broken)
    with pytest.raises(tulle.InvalidMeshError):
        broken.validate()
    with pytest.raises(tulle.InvalidMeshError, match="99"):
        tulle.World().add_obstacle(tulle.Mesh(sheet.positions[:3], [[0, 1, 99]]))


def test_a_stale_array_cannot_be_read(world: tulle.World) -> None:
    world.step(STEP)
    positions, kept = world.cloths[0].positions, world.cloths[0].positions.copy()
    row, half = positions[3], positions[:72]
    sums = positions + 0
    assert type(sums) is np.ndarray and positions is world.cloths[0].positions, "one array for a state"
    world.step(STEP)
    reads = [lambda: positions + 1, lambda: 1 - positions, lambda: positions[0], lambda: positions.sum(), lambda: positions.max(),
             lambda: np.mean(positions), lambda: np.linalg.norm(positions, axis=1), lambda: np.concatenate([positions, kept]),
             lambda: positions.tolist(), lambda: list(positions), lambda: repr(positions), lambda: row * 2, lambda: half[0],
             lambda: positions.copy(), lambda: np.array_equal(positions, kept), lambda: pickle.dumps(positions),
             lambda: positions.reshape(-1), lambda: np.stack([positions]), lambda: f"{positions}", lambda: positions == kept,
             lambda: positions.astype(np.float32), lambda: copy.deepcopy(positions), lambda: positions.T + 1, lambda: np.dot(positions, kept.T),
             lambda: np.asarray(positions), lambda: np.array(positions), lambda: np.array([positions, kept]), lambda: positions.flat,
             lambda: kept.__setitem__(slice(None), positions), lambda: np.full(kept.shape, positions), lambda: np.eye(144).dot(positions),
             lambda: list(np.nditer(positions)), lambda: positions.data, lambda: positions.view(np.ndarray), lambda: positions.ctypes,
             lambda: copy.copy(positions), lambda: np.random.default_rng(1).permutation(positions), lambda: half.T[0], lambda: 0.5 in positions,
             lambda: tulle.Mesh([positions[0]], np.zeros((0, 3), int)), lambda: float(row[0])]
    for read in reads:
        with pytest.raises(tulle.StaleError, match="copy"):
            read()
    assert not np.array_equal(kept, world.cloths[0].positions)
    with pytest.raises(tulle.StaleError):
        world.obstacles[0].set_next_positions(positions)


def test_an_array_of_a_state_does_what_an_array_does(world: tulle.World) -> None:
    world.step(STEP)
    guarded, velocities = world.cloths[0].positions, world.cloths[0].velocities
    plain, filled = np.array(guarded), np.zeros(guarded.shape)
    filled[:] = guarded
    filled[3] += guarded[3]
    assert np.array_equal(filled[4:], plain[4:]) and type(np.asarray(guarded)) is np.ndarray
    for name in ("shape", "dtype", "ndim", "size", "nbytes", "strides", "itemsize"):
        assert getattr(guarded, name) == getattr(plain, name)
    for compute in (lambda a: a.T, lambda a: 1 - a, lambda a: a @ np.eye(3), lambda a: a[a[:, 2] > 0.4], lambda a: a.mean(axis=0), lambda a: a[3, 1],
                    lambda a: a > 0, lambda a: np.asarray(a, np.float32), lambda a: np.einsum("ij,ij->i", a, velocities), lambda a: list(zip(a, a))[5][0],
                    lambda a: np.linalg.norm(a, axis=1), lambda a: np.stack([a, a]), lambda a: a.reshape(-1), lambda a: [float(x) for x in a[:, 2]],
                    lambda a: max(a[:, 0]), lambda a: f"{a[3, 1]:.4f} {a} {len(a)}", lambda a: 0.123 in a, lambda a: a.tobytes(), lambda a: bool(a[0, 0])):
        assert np.array_equal(compute(guarded), compute(plain))  # type: ignore[no-untyped-call]
    with pytest.raises(AttributeError):
        guarded.no_such_thing


def test_arrays_of_a_state_are_read_only(world: tulle.World) -> None:
    world.start()
    positions = world.cloths[0].positions
    with pytest.raises(ValueError, match="read-only"):
        positions[0] = 0
    with pytest.raises(ValueError, match="read-only"):
        positions += 1
    for protected in (positions, np.asarray(positions)):
        with pytest.raises(ValueError, match="WRITEABLE"):
            protected.flags.writeable = True
    with pytest.raises(ValueError, match="read-only"):
        world.cloths[0].triangles[0] = 0
    assert pickle.loads(pickle.dumps(positions)).tolist() == positions.tolist()


def test_values_are_copied_into_memory_of_the_caller(world: tulle.World) -> None:
    world.step(STEP)
    cloth = world.cloths[0]
    vertices = np.zeros(cloth.vertex_count, [("position", "f4", 3), ("normal", "f4", 3), ("tag", "u4")])
    cloth.copy_values("positions", vertices["position"])
    cloth.copy_values(tulle.Values.NORMALS, vertices["normal"])
    assert np.array_equal(vertices["position"], cloth.positions.astype(np.float32)) and not vertices["tag"].any()
    rows = np.zeros((2 * cloth.vertex_count, 3))
    cloth.copy_values("velocities", rows[::2])
    assert np.array_equal(rows[::2], cloth.velocities) and not rows[1::2].any()
    count = cloth.vertex_count
    for out, words in ((np.zeros((count, 4)), "shape"), (np.zeros((count, 3), np.int32), "int32"), (np.zeros((3, count)).T, "side by side"),
                       (np.zeros((count, 3))[::-1], "ascending"), (np.broadcast_to(np.zeros(3), (count, 3)), "read only"), ([], "shape")):
        with pytest.raises(tulle.InvalidArgumentError, match=words):
            cloth.copy_values("positions", out)  # type: ignore[arg-type]
    with pytest.raises(tulle.InvalidArgumentError, match="velocities"):
        cloth.copy_values("speed")
    with pytest.raises(tulle.InvalidArgumentError):
        world.obstacles[0].copy_values("strains")


def test_reports_can_be_kept_and_pickled(world: tulle.World) -> None:
    report = world.step(STEP)
    again = pickle.loads(pickle.dumps(report))
    assert again == report and again.to_dict()["step"] == 0 and len(report.stage_seconds) == tulle.STAGE_COUNT
    hit = world.cast_ray((0, 0, 2), (0, 0, -2))
    assert hit is not None and pickle.loads(pickle.dumps(hit)).object.kind == tulle.ObjectKind.CLOTH
