"""Animations: every format that is written is read with the same numbers; frames on demand; what is refused."""
import numpy as np
import pytest

import tulle

TRIANGLES = [[0, 1, 2], [0, 2, 3]]


def make_frames(count, dtype=np.float32):
    return np.random.default_rng(5).normal(size=(count, 4, 3)).astype(dtype)


@pytest.mark.parametrize("name", ["a.glb", "a.gltf", "a.usda", "a.npz", "a.mdd"])
def test_formats_come_back(tmp_path, name):
    frames = make_frames(5)
    tulle.write_animation(tmp_path / name, {"sheet": (frames, TRIANGLES)}, fps=4)
    with tulle.Animation(tmp_path / name) as read:
        assert len(read) == read.frame_count == 5 and read.vertex_count == 4
        assert np.array_equal(read.times, np.arange(5) / 4)
        assert read.triangles.tolist() == ([] if name.endswith("mdd") else TRIANGLES)
        for i, positions in enumerate(read):
            assert np.array_equal(positions, frames[i])
        assert np.array_equal(read[-1], frames[-1])
        with pytest.raises(IndexError):
            read[5]
    with pytest.raises(tulle.ClosedError):
        read[0]


def test_surfaces_become_one_mesh(tmp_path):
    frames = make_frames(3, np.float64)
    path = tmp_path / "two.npz"
    tulle.write_animation(path, {"a": (frames, TRIANGLES), "b": frames + 10}, times=[0, 0.1, 0.5], is_double=True)
    read = tulle.Animation(path)
    assert read.vertex_count == 8 and read.triangles.tolist() == TRIANGLES
    assert np.array_equal(read[1], np.concatenate([frames[1], frames[1] + 10]))
    assert read.times.tolist() == [0, 0.1, 0.5]
    assert np.array_equal(read.make_mesh(2).positions, read[2])
    assert list(np.load(path)["names"]) == ["a", "b"]


def test_axes_and_units_are_told(tmp_path):
    path = tmp_path / "a.usda"
    tulle.write_animation(path, {"a": make_frames(2)}, is_y_up=True, meters_per_unit=0.01, colors={"a": (0, 1, 0)})
    read = tulle.Animation(path)
    assert read.is_y_up and read.meters_per_unit == 0.01 and read.note == ""
    assert "displayColor = [(0, 1, 0)]" in path.read_text()


def test_an_animation_is_what_gives_frames(tmp_path):
    first, second = tmp_path / "a.usda", tmp_path / "b.glb"
    tulle.write_animation(first, {"a": (make_frames(4), TRIANGLES)})
    walk = tulle.Animation(first)
    tulle.write_animation(second, {"a": (walk, walk.triangles)}, times=walk.times)
    assert all(np.array_equal(a, b) for a, b in zip(tulle.Animation(second), walk))


def test_point_caches_are_read(tmp_path):
    frames = make_frames(2)
    with tulle.PointCacheWriter(tmp_path / "a.pc2", 4) as cache:
        for positions in frames:
            cache.append(positions)
    read = tulle.Animation(tmp_path / "a.pc2")
    assert np.isnan(read.times).all() and np.array_equal(read[1], frames[1])


def test_numpy_writes_what_is_read(tmp_path):
    frames = np.asfortranarray(make_frames(3, ">f8"))
    np.savez_compressed(tmp_path / "n.npz", positions=frames, triangles=np.array(TRIANGLES, "u1"), times=[1, 2, 4])
    read = tulle.Animation(tmp_path / "n.npz")
    assert read.times.tolist() == [1, 2, 4] and read.triangles.tolist() == TRIANGLES
    assert all(np.array_equal(a, b) for a, b in zip(read, frames))


class Broken:
    def __len__(self):
        return 3

    def __getitem__(self, frame):
        if frame == 2:
            raise RuntimeError("no such frame")
        return np.zeros((4, 3))


def test_what_is_refused(tmp_path):
    path = tmp_path / "x.usda"
    with pytest.raises(RuntimeError, match="no such frame"):
        tulle.write_animation(path, {"a": Broken()})
    assert not path.exists()
    for surfaces, how in [({}, {}), ({"a": make_frames(2), "b": make_frames(3)}, {}), ({"a": make_frames(2)}, {"times": [0]}),
                          ({"a": make_frames(2)}, {"times": [1, 1]}), ({"a": make_frames(2)}, {"colors": {"a": (2, 0, 0)}})]:
        with pytest.raises(tulle.InvalidArgumentError):
            tulle.write_animation(path, surfaces, **how)
    with pytest.raises(tulle.InvalidMeshError):
        tulle.write_animation(path, {"a": (make_frames(2), [[0, 1, 4]])})
    path.write_text("#usda 1.0\ndef Mesh \"m\" { point3f[] points = [(0, 0, x)] }\n")
    with pytest.raises(tulle.ParseError) as caught:
        tulle.Animation(path)
    assert (caught.value.line, caught.value.column) == (2, 43)
