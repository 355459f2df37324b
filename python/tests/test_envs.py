"""Environments: policies solve them, chance does not, bits do not depend on threads or company, bad input is told."""
from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import tulle
from tulle import envs

SMALL = {"resolution": 10}


def run(name: str, actor: Any, count: int, seed: int = 0, **options: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """One episode each: whether it ended as done, the sum of rewards, the score at the start."""
    with envs.make(name, count=count, seed=seed, **{**SMALL, **options}) as made:
        observations, infos = made.reset()
        start, rewards = infos["score"], np.zeros(count)
        is_over, is_done = np.zeros(count, bool), np.zeros(count, bool)
        while not is_over.all():
            observations, reward, terminated, truncated, infos = made.step(actor(made, observations))
            assert "error" not in infos
            rewards += np.where(is_over, 0, reward)
            is_done |= terminated & ~is_over
            assert (infos["is_success"] == terminated).all()
            is_over |= terminated | truncated
            for world in made.worlds[:1]:
                assert tulle.Judge().find_world_intersections(world).is_clean
    return is_done, rewards, start


@pytest.mark.parametrize("name", envs.list_tasks())
def test_scripted_policy_solves(name: str) -> None:
    policy = envs.scripted_policy(name)
    is_done, rewards, start = run(name, lambda made, observations: policy(observations), 4, seed=30)
    assert is_done.all()
    # The growth of the score adds up, and 1 for the end.
    assert (rewards <= 2 - start + 1e-9).all() and (rewards > 1.2).all()


@pytest.mark.parametrize("name", envs.list_tasks())
def test_chance_does_not_solve(name: str) -> None:
    is_done, rewards, _ = run(name, lambda made, observations: made.action_space.sample(), 4, seed=60, episode_length=60)
    assert not is_done.any() and (rewards < 1).all()


@pytest.mark.parametrize("name", envs.list_tasks())
def test_bits_do_not_depend_on_threads_or_company(name: str) -> None:
    def walk(count: int, seed: int, threads: int) -> tuple[list[list[int]], np.ndarray]:
        made = envs.make(name, count=count, seed=seed, threads=threads, episode_length=5, **SMALL)
        observations, _ = made.reset()
        hashes = [made.get_state_hashes()]
        for step in range(9):  # over the end of an episode
            rows = [np.random.default_rng([seed + i, step]).uniform(-1, 1, 8) for i in range(count)]
            observations, *_ = made.step(np.array(rows))
            hashes.append(made.get_state_hashes())
        return hashes, observations

    together, observations = walk(3, 5, 2)
    assert walk(3, 5, 1)[0] == together
    for i in range(3):
        alone, own = walk(1, 5 + i, 1)
        assert [row[0] for row in alone] == [row[i] for row in together]
        assert np.array_equal(own[0], observations[i])
    assert len({row[0] for row in together}) == len(together)


def test_seeds_vary_the_start_and_repeat_it() -> None:
    made = envs.make("straighten", count=3, seed=[4, 4, 5], **SMALL)
    first, _ = made.reset()
    hashes = made.get_state_hashes()
    assert hashes[0] == hashes[1] != hashes[2]
    second, _ = made.reset()
    assert not np.array_equal(first, second)
    third, _ = made.reset(seed=[4, 4, 5])
    assert np.array_equal(first, third) and made.get_state_hashes() == hashes


def test_spaces_and_shapes() -> None:
    made = envs.make("drape-hanger", count=2, **SMALL)
    assert made.num_envs == 2 and made.metadata["autoreset_mode"] == "NextStep"
    observations, infos = made.reset()
    assert observations in made.observation_space and observations.dtype == np.float32
    assert observations[0] in made.single_observation_space
    assert made.action_space.shape == (2, *made.single_action_space.shape)
    parts = made.split(observations)
    assert parts["positions"].shape == (2, 100, 3) and parts["grippers"].shape == (2, 2, 3)
    assert np.allclose(parts["positions"][1], np.array(made.worlds[1].cloths[0].positions), atol=1e-6)
    assert (parts["holds"] == 1).all() and (parts["time"] == 0).all() and infos["score"].shape == (2,)
    values = made.step(made.action_space.sample())
    assert [each.shape for each in values[:4]] == [observations.shape, (2,), (2,), (2,)]
    space = envs.Box([-1, 0, -np.inf], [1, np.inf, np.inf], seed=3)
    again = envs.Box([-1, 0, -np.inf], [1, np.inf, np.inf], seed=3)
    samples = np.array([space.sample() for _ in range(200)])
    assert all(sample in space for sample in samples) and np.array_equal(samples, [again.sample() for _ in range(200)])
    assert samples[:, 0].min() < -0.9 and samples[:, 1].max() > 2 and samples[:, 2].min() < -1
    assert np.array([2, 0, 0], np.float32) not in space and [0.0, 0.0] not in space
    assert space == again and space != envs.Box(-1, 1, (3,))


def test_autoreset_is_that_of_the_next_step() -> None:
    made = envs.make("fold-towel", count=2, episode_length=3, **SMALL)
    made.reset()
    still = np.zeros(made.action_space.shape)
    for _ in range(2):
        assert not made.step(still)[3].any()
    last, _, terminated, truncated, _ = made.step(still)
    assert truncated.all() and not terminated.any() and (made.split(last)["time"] == 1).all()
    first, rewards, terminated, truncated, _ = made.step(np.ones_like(still))
    assert (rewards == 0).all() and not terminated.any() and not truncated.any()
    assert (made.split(first)["time"] == 0).all() and made.worlds[0].time < made.worlds[0].step_count
    fresh = envs.make("fold-towel", count=2, episode_length=3, **SMALL)
    fresh.reset()
    assert np.array_equal(fresh.reset()[0], first)


def test_a_step_that_fails_ends_its_episode_alone() -> None:
    made = envs.make("fold-towel", count=3, **SMALL)
    made.reset()
    still = np.zeros(made.action_space.shape)
    press = tulle.make_shape("box", size=(1, 1, 0.02)).transform(translation=(0, 0, 0.3))
    plate = made.worlds[1].add_obstacle(press, drive="rigid")
    plate.set_next_transform(translation=(0, 0, -0.3))  # through the towel and the table
    before = made.worlds[1].state_hash
    observations, _, terminated, truncated, infos = made.step(still)
    assert truncated.tolist() == [False, True, False] and not terminated.any() and np.isfinite(observations).all()
    assert infos["_error"].tolist() == [False, True, False] and "PinchedError" in infos["error"][1]
    assert made.worlds[1].state_hash == before
    _, _, _, truncated, infos = made.step(still)
    assert not truncated.any() and "error" not in infos


def test_gripper_lets_go_where_the_force_is_too_large() -> None:
    made = envs.make("dress-arm", **SMALL)
    observations, _ = made.reset()
    apart = np.array([[0, 1, 0, 1, 0, -1, 0, 1]], float)  # one to each side
    for _ in range(25):
        observations, *_ = made.step(apart)
        assert made.worlds[0].largest_stretch.stretch < 1.3
    assert made.split(observations)["holds"].min() == 0


def test_render() -> None:
    made = envs.make("dress-arm", count=2, **SMALL)
    made.reset()
    picture = made.render(1, size=(64, 48), samples=2)
    assert picture.shape == (48, 64, 3) and picture.dtype == np.uint8 and picture.std() > 5


def test_bad_input_is_told() -> None:
    with pytest.raises(tulle.InvalidArgumentError, match="did you mean \"fold-towel\""):
        envs.make("fold-towl")
    with pytest.raises(tulle.InvalidArgumentError, match="there are fold-towel"):
        envs.scripted_policy("xyz")
    with pytest.raises(TypeError, match="did you mean \"resolution\""):
        envs.make("fold-towel", resolutoin=3)
    for options, text in (({"resolution": 3}, "resolution is 3"), ({"episode_length": 1.5}, "episode_length"),
                          ({"count": 0}, "count"), ({"threads": -1}, "threads"), ({"seed": -1}, "seed"),
                          ({"material": "tin"}, "no material"), ({"count": 2, "seed": [1]}, "1 seeds for 2")):
        with pytest.raises(tulle.InvalidArgumentError, match=text):
            envs.make("fold-towel", **options)  # type: ignore[arg-type]
    made = envs.make("fold-towel", count=2, **SMALL)
    still = np.zeros(made.action_space.shape)
    with pytest.raises(tulle.InvalidArgumentError, match="call reset before the first step"):
        made.step(still)
    with pytest.raises(tulle.InvalidArgumentError, match="call reset before render"):
        made.render()
    made.reset()
    hashes = made.get_state_hashes()
    with pytest.raises(tulle.InvalidArgumentError, match=r"shape \(2, 8\), not \(8,\); put"):
        made.step(still[0])
    with pytest.raises(tulle.InvalidArgumentError, match="environment 1 is not a number"):
        made.step(np.where(np.arange(2)[:, None] == 1, np.nan, still))
    with pytest.raises(tulle.InvalidArgumentError, match="no array of numbers"):
        made.step([["a"] * 8] * 2)
    with pytest.raises(tulle.InvalidArgumentError, match="give them to tulle.envs.make"):
        made.reset(options={"resolution": 3})
    with pytest.raises(tulle.InvalidArgumentError, match="these are no observations"):
        envs.scripted_policy("fold-towel")(np.zeros((2, 7)))
    assert made.get_state_hashes() == hashes
    made.close()
    made.close()
    with pytest.raises(tulle.ClosedError, match="make new ones"):
        made.step(still)
    with pytest.raises(tulle.ClosedError):
        made.reset()
