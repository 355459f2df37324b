"""Data sets: labels are those of the judge, bytes those of the seed, and what was cut short goes on."""
from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import tulle
from tulle import datasets

TINY = {"resolution": 6, "steps": 24}


def read_all(directory: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(directory.iterdir())}


@pytest.fixture(scope="module")
def samples() -> list[datasets.Sample]:
    return list(datasets.drapes(40, seed=11, negatives=0.4, **TINY))


def test_labels_are_those_of_the_judge(samples: list[datasets.Sample]) -> None:
    assert [sample.index for sample in samples] == list(range(40))
    for sample in samples:
        cloth, obstacles = sample.get_meshes()
        verdict = tulle.Judge().find_intersections([cloth], [obstacles])
        assert verdict.pairs.tobytes() == sample.pairs.tobytes()
        assert verdict.is_clean == sample.is_accepted
    accepted = [sample.is_accepted for sample in samples]
    assert 10 < sum(accepted) < 35
    assert {sample.kind for sample in samples} == {"drape", "crumple"} and len({sample.material for sample in samples}) > 4
    # Cloth has moved, and some lies on what is there.
    assert np.mean([np.linalg.norm(sample.positions.mean(axis=0)) < 0.25 for sample in samples]) > 0.5
    assert any(pair["body_a"] == pair["body_b"] == 0 for sample in samples for pair in sample.pairs)
    assert any(pair["body_b"] == 1 for sample in samples for pair in sample.pairs)


def test_a_sample_depends_on_seed_and_number_alone(samples: list[datasets.Sample]) -> None:
    data = datasets.drapes(1000, seed=11, negatives=0.4, threads=1, **TINY)
    assert len(data) == 1000
    for i in (0, 17):
        alone = data[i]
        for name in ("positions", "pairs"):
            assert getattr(alone, name).tobytes() == getattr(samples[i], name).tobytes()
    other = datasets.drapes(1, seed=12, negatives=0.4, **TINY)[0]
    assert other.positions.shape != samples[0].positions.shape or not np.array_equal(other.positions, samples[0].positions)
    with pytest.raises(IndexError):
        data[1000]


def test_bytes_do_not_depend_on_threads_and_can_be_read(samples: list[datasets.Sample], tmp_path: Path) -> None:
    for threads in (1, 2):
        datasets.drapes(40, seed=11, negatives=0.4, threads=threads, **TINY).write(tmp_path / str(threads))
    assert read_all(tmp_path / "1") == read_all(tmp_path / "2")
    index = json.loads((tmp_path / "1" / "index.json").read_text())
    assert index["is_complete"] and index["seed"] == 11 and index["version"] == tulle.__version__
    assert index["licence"].startswith("MIT") and index["totals"]["samples"] == 40
    assert index["totals"]["positives"] == sum(sample.is_accepted for sample in samples)
    for sample, read in zip(samples, datasets.read(tmp_path / "1")):
        for name in ("positions", "triangles", "rest_positions", "obstacle_positions", "obstacle_triangles", "pairs"):
            assert getattr(sample, name).tobytes() == getattr(read, name).tobytes()
        assert (sample.kind, sample.material, sample.is_accepted) == (read.kind, read.material, read.is_accepted)


def test_writing_goes_on_where_it_was_cut_short(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    data = datasets.drapes(120, seed=2, resolution=4, steps=3)
    data.write(tmp_path / "whole")
    made: list[int] = []
    make = datasets.Drapes._make

    def count(self: datasets.Drapes, indices: range) -> list[datasets.Sample]:
        if len(made) == 2:
            raise KeyboardInterrupt
        made.append(indices[0])
        return make(self, indices)

    monkeypatch.setattr(datasets.Drapes, "_make", count)
    with pytest.raises(KeyboardInterrupt):
        data.write(tmp_path / "cut")
    assert not json.loads((tmp_path / "cut" / "index.json").read_text())["is_complete"]
    (tmp_path / "cut" / "drapes-00000.npz").write_bytes(b"damaged")
    made[:] = [-1]
    data_again = datasets.drapes(120, seed=2, resolution=4, steps=3)
    monkeypatch.setattr(datasets.Drapes, "_make", lambda self, indices: (made.append(indices[0]), make(self, indices))[1])
    data_again.write(tmp_path / "cut")
    assert made == [-1, 0, 100]  # the damaged file, and what was missing
    assert read_all(tmp_path / "cut") == read_all(tmp_path / "whole")


def test_bad_input_is_told(tmp_path: Path) -> None:
    for changes, text in (({"count": -1}, "count"), ({"negatives": 2}, "negatives"), ({"steps": 0}, "steps"),
                          ({"seed": 1.5}, "seed")):
        with pytest.raises(tulle.InvalidArgumentError, match=text):
            datasets.drapes(**{"count": 1, **changes})  # type: ignore[arg-type]
    datasets.drapes(1, seed=1, resolution=4, steps=2).write(tmp_path)
    with pytest.raises(tulle.InvalidArgumentError, match="another directory"):
        datasets.drapes(1, seed=2, resolution=4, steps=2).write(tmp_path)
    (tmp_path / "drapes-00000.npz").write_bytes(b"")
    with pytest.raises(tulle.ParseError, match="not as it was written"):
        list(datasets.read(tmp_path))
    (tmp_path / "index.json").write_text("{}")
    with pytest.raises(tulle.ParseError, match="no index"):
        list(datasets.read(tmp_path))
