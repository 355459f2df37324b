"""Many worlds of one task side by side, by the conventions of gymnasium's vector environments."""
from __future__ import annotations

import difflib
from collections.abc import Sequence
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tulle.envs.spaces import Box
from tulle.envs.task import Options, Task
from tulle._structs import refuse_unknown
from tulle.errors import ClosedError, Error, InvalidArgumentError, PinchedError, StepFailedError
from tulle.program import render
from tulle.world import step_worlds

Infos = dict[str, Any]
_TRIES = 10  # starts of an episode, each from other random numbers, before its failure is raised


class VectorEnv:
    """`count` environments of one task, whose worlds step together.

    >>> envs = tulle.envs.make("fold-towel", count=64)
    >>> observations, infos = envs.reset(seed=1)
    >>> observations, rewards, terminated, truncated, infos = envs.step(envs.action_space.sample())

    It follows gymnasium's vector environments (1.0 and later), which need not be installed. Environment i of a batch with
    the seed s comes to the same bits as environment 0 of a batch of one with the seed s + i, for any number of threads.

    An action has four numbers for each gripper, -1 .. 1: the velocity along x, y and z in parts of the largest one, then
    above 0 to close and else to open. Others are brought into that range. A reward is the growth of infos["score"],
    0 .. 1, and 1 more once the task is done. An episode ends as terminated when the task is done, as truncated when its
    time is up or when a step failed, and infos["error"] then says why.

    Autoreset is that of the next step (gymnasium's NEXT_STEP): the call of `step` after the end of an episode takes no
    action there, but begins the next episode and gives its first observation, with the reward 0.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 25, "autoreset_mode": "NextStep"}
    """What gymnasium asks of environments."""
    render_mode = "rgb_array"
    """`render` gives arrays."""
    spec = None
    """Gymnasium's registry does not know these environments."""

    def __init__(self, task: type[Task], count: int = 1, threads: int = 0, seed: Union[int, Sequence[int]] = 0,
                 **options: Any) -> None:
        """See `tulle.envs.make`; `options` are fields of Options."""
        refuse_unknown(options, Options.__dataclass_fields__, task.NAME)
        _check_whole(count, "count", 1, 1_000_000)
        _check_whole(threads, "threads", 0, 256)
        self.task, self.num_envs, self.threads, self.options = task, int(count), int(threads), Options(**options)
        self._seeds = self._make_seeds(seed)
        self._episodes = [0] * count  # that were begun
        self._tasks: list[Optional[Task]] = [None] * count
        self._scores = np.zeros(count)
        self._is_over = np.zeros(count, bool)
        self._is_closed, self._is_reset = False, False
        self.layout = task.get_layout(task.count_vertices(self.options))
        self.single_action_space = Box(-1, 1, (4 * task.GRIPPERS,), np.float32)
        size = sum(int(np.prod(shape)) for shape in self.layout.values())
        self.single_observation_space = Box(-np.inf, np.inf, (size,), np.float32)
        self.action_space = self.single_action_space.repeat(self.num_envs)
        self.observation_space = self.single_observation_space.repeat(self.num_envs)
        self.action_space.seed(self._seeds[0])

    def _make_seeds(self, seed: Union[int, Sequence[int]]) -> list[int]:
        if isinstance(seed, (list, tuple, np.ndarray)):
            seeds = list(seed)
            if len(seeds) != self.num_envs:
                raise InvalidArgumentError(f"there are {len(seeds)} seeds for {self.num_envs} environments")
        else:
            _check_whole(seed, "seed", 0, 2**63)
            seeds = [int(seed) + i for i in range(self.num_envs)]  # type: ignore[arg-type]
        for each in seeds:
            _check_whole(each, "seed", 0, 2**64)
        return [int(each) for each in seeds]

    # ---- episodes ----

    def reset(self, *, seed: Union[int, Sequence[int], None] = None,
              options: Optional[dict[str, Any]] = None) -> tuple[NDArray[np.float32], Infos]:
        """Begins an episode everywhere. Gives the observations (count, ...), and infos.

        seed: environment i then continues from seed + i; or a seed for each. None: the first time from the seed of `make`, later
        with the next episode of each. options: none are known.
        """
        self._check_open()
        if options:
            raise InvalidArgumentError(f"reset knows no options, such as {next(iter(options))!r}: give them to tulle.envs.make")
        if seed is not None:
            self._seeds = self._make_seeds(seed)
            self._episodes = [0] * self.num_envs
        self._begin(list(range(self.num_envs)))
        self._is_reset = True
        observations = self._observe()
        return observations, self._make_infos({}, np.zeros(self.num_envs, bool))

    def _begin(self, chosen: list[int]) -> None:
        """Begins the next episode of some environments; their worlds settle together."""
        self._is_over[chosen] = True  # where an error ends this, the next step tries again
        waiting = [(i, 0) for i in chosen]
        while waiting:
            for i, attempt in waiting:
                old = self._tasks[i]
                if old is not None:
                    old.world.close()
                words = [self._seeds[i], self._episodes[i], attempt]
                self._tasks[i] = self.task(np.random.Generator(np.random.PCG64(words)), self.options)
            waiting = [(i, attempt + 1) for i, attempt in waiting if i in self._settle([i for i, _ in waiting], attempt)]
        for i in chosen:
            task = self._get(i)
            task.begin()
            self._episodes[i] += 1
            self._scores[i] = task.measure()[0]
            self._is_over[i] = False

    def _settle(self, chosen: list[int], attempt: int) -> set[int]:
        """Lets the worlds of new episodes settle; gives those that failed or are not ready."""
        failed: set[int] = set()
        step = 0
        while True:
            moving = [i for i in chosen if i not in failed and not self._get(i).is_settled]
            if not moving:
                last = attempt + 1 >= _TRIES
                return failed | {i for i in chosen if i not in failed and not last and not self._get(i).is_ready()}
            for i in moving:
                self._get(i).settle(step)
            for i, error in self._step_worlds(moving).items():
                if attempt + 1 >= _TRIES:
                    raise error
                failed.add(i)
            step += 1

    def _step_worlds(self, chosen: Sequence[int]) -> dict[int, Error]:
        """Steps the worlds of some environments; gives what failed. Errors that no episode can end with are raised."""
        reports = step_worlds([self._get(i).world for i in chosen], self.task.TIME_STEP, self.threads)
        failures = {i: report for i, report in zip(chosen, reports) if isinstance(report, Error)}
        for failure in failures.values():
            if not isinstance(failure, (PinchedError, StepFailedError)):
                raise failure
        return failures

    def step(self, actions: ArrayLike) -> tuple[NDArray[np.float32], NDArray[np.float64], NDArray[np.bool_],
                                                NDArray[np.bool_], Infos]:
        """Takes one action (count, ...) in each environment.

        Gives observations, rewards, terminated, truncated, each (count, ...), and infos: "score" and "is_success", and
        "error" where a step failed. Raises InvalidArgumentError for actions of another shape or that are no numbers.
        """
        self._check_open()
        if not self._is_reset:
            raise InvalidArgumentError("call reset before the first step")
        rows = self._check_actions(actions)
        renewed = np.flatnonzero(self._is_over).tolist()
        if renewed:
            self._begin(renewed)
        active = [i for i in range(self.num_envs) if i not in set(renewed)]
        for i in active:
            self._get(i).act(rows[i])
        errors: dict[int, Error] = {}
        for _ in range(self.task.STEPS):
            moving = [i for i in active if i not in errors]
            if not moving:
                break
            for i in moving:
                self._get(i).move()
            errors.update(self._step_worlds(moving))
        rewards, terminated = np.zeros(self.num_envs), np.zeros(self.num_envs, bool)
        truncated = np.zeros(self.num_envs, bool)
        for i in active:
            task = self._get(i)
            score, terminated[i] = task.measure()
            rewards[i] = score - self._scores[i] + terminated[i]
            self._scores[i] = score
            truncated[i] = i in errors or (task.action_count >= task.length and not terminated[i])
        self._is_over = terminated | truncated
        return self._observe(), rewards, terminated, truncated, self._make_infos(errors, terminated)

    def _check_actions(self, actions: ArrayLike) -> NDArray[np.float64]:
        try:
            rows = np.asarray(actions, np.float64)
        except (TypeError, ValueError) as failure:
            raise InvalidArgumentError(f"actions are no array of numbers: {failure}") from None
        if rows.shape != self.action_space.shape:
            hint = "; put the action of the one environment into a list" if rows.shape == self.single_action_space.shape else ""
            raise InvalidArgumentError(f"actions should have the shape {self.action_space.shape}, not {rows.shape}{hint}")
        wrong = np.flatnonzero(np.isnan(rows).any(axis=1))
        if wrong.size:
            raise InvalidArgumentError(f"the action of environment {wrong[0]} is not a number (NaN); "
                                       "no environment has stepped")
        return np.clip(rows, -1, 1)

    def _observe(self) -> NDArray[np.float32]:
        observations = np.empty(self.observation_space.shape, np.float32)
        for i in range(self.num_envs):
            self._get(i).observe(observations[i])
        return observations

    def _make_infos(self, errors: dict[int, Error], is_success: NDArray[np.bool_]) -> Infos:
        everywhere = np.ones(self.num_envs, bool)
        infos: Infos = {"score": self._scores.copy(), "_score": everywhere, "is_success": is_success.copy(),
                        "_is_success": everywhere.copy()}
        if errors:
            told, mask = np.full(self.num_envs, None, object), np.zeros(self.num_envs, bool)
            for i, error in errors.items():
                told[i], mask[i] = f"{type(error).__name__}: {error}", True
            infos.update({"error": told, "_error": mask})
        return infos

    # ---- what there is to see ----

    def split(self, observations: NDArray[Any]) -> dict[str, NDArray[Any]]:
        """The parts of observations (count, ...) by name, as "positions" (count, vertices, 3); see `layout`."""
        return split(self.layout, observations)

    @property
    def worlds(self) -> list[Any]:
        """The worlds as they are, one for each environment; they change with every episode."""
        self._check_open()
        return [self._get(i).world for i in range(self.num_envs)]

    def get_state_hashes(self) -> list[int]:
        """The state hash of each world: equal ones have equal bits."""
        return [world.state_hash for world in self.worlds]

    def render(self, index: int = 0, *, size: tuple[int, int] = (640, 360), samples: int = 32) -> NDArray[np.uint8]:
        """A ray traced picture of the world `index`: (height, width, 3).

        size: width and height in pixels. samples: rays for each pixel.
        """
        self._check_open()
        if not self._is_reset:
            raise InvalidArgumentError("call reset before render")
        _check_whole(index, "index", -self.num_envs, self.num_envs - 1)
        return render(self._get(index).world, size=size, samples=samples, options=["--camera", self.task.CAMERA])

    def close(self) -> None:
        """Releases all worlds. Closing twice is fine."""
        for task in self._tasks:
            if task is not None:
                task.world.close()
        self._tasks = [None] * self.num_envs
        self._is_closed = True

    def __enter__(self) -> VectorEnv:
        return self

    def __exit__(self, *unused: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"VectorEnv(\"{self.task.NAME}\", count={self.num_envs}{', closed' if self._is_closed else ''})"

    def _get(self, i: int) -> Task:
        task = self._tasks[i]
        if task is None:
            raise InvalidArgumentError("call reset first")
        return task

    def _check_open(self) -> None:
        if self._is_closed:
            raise ClosedError("the environments were closed: make new ones with tulle.envs.make")


def split(layout: dict[str, tuple[int, ...]], observations: NDArray[Any]) -> dict[str, NDArray[Any]]:
    """The parts of observations by name."""
    parts, place = {}, 0
    for name, shape in layout.items():
        size = int(np.prod(shape))
        parts[name] = observations[:, place:place + size].reshape(len(observations), *shape)
        place += size
    return parts


def find_named(table: dict[str, Any], name: str, what: str) -> Any:
    """The entry of that name; an error names the nearest entry."""
    if name not in table:
        near = difflib.get_close_matches(str(name), list(table), 1)
        hint = f"did you mean \"{near[0]}\"?" if near else f"there are {', '.join(table)}"
        raise InvalidArgumentError(f"there is no {what} \"{name}\"; {hint}")
    return table[name]


def _check_whole(value: Any, what: str, least: int, most: int) -> None:
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not least <= value <= most:
        raise InvalidArgumentError(f"{what} is {value!r}; it should be a whole number from {least} to {most}")
