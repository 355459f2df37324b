"""Cloth to learn with: many worlds of one task side by side, by the conventions of gymnasium's vector environments.

>>> import tulle.envs
>>> envs = tulle.envs.make("fold-towel", count=64)
>>> policy = tulle.envs.scripted_policy("fold-towel")
>>> observations, infos = envs.reset()
>>> for _ in range(100):
...     observations, rewards, terminated, truncated, infos = envs.step(policy(observations))

docs/guide/learning.md says more.
"""
from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Union

from tulle.envs.drape_hanger import DrapeHanger, DrapeHangerPolicy
from tulle.envs.dress_arm import DressArm, DressArmPolicy
from tulle.envs.fold_towel import FoldTowel, FoldTowelPolicy
from tulle.envs.policy import Policy
from tulle.envs.spaces import Box
from tulle.envs.straighten import Straighten, StraightenPolicy
from tulle.envs.task import Gripper, Options, Task
from tulle.envs.vector import VectorEnv, find_named

__all__ = ["Box", "Gripper", "Options", "Policy", "Task", "VectorEnv", "list_tasks", "make", "scripted_policy"]

_POLICIES: dict[str, type[Policy]] = {policy.task.NAME: policy for policy in (
    FoldTowelPolicy, DrapeHangerPolicy, DressArmPolicy, StraightenPolicy)}


def list_tasks() -> list[str]:
    """The names of all tasks."""
    return list(_POLICIES)


def make(name: str, count: int = 1, threads: int = 0, seed: Union[int, Sequence[int]] = 0, **options: Any) -> VectorEnv:
    """`count` environments of the task `name`, one of `list_tasks()`.

    threads: 0 .. 256 on which worlds step; 0: one per processor. seed: of environment 0, that of i is i more; or one for each.
    options: fields of Options by name, as `resolution=20`. Raises InvalidArgumentError.
    """
    return VectorEnv(find_named(_POLICIES, name, "task").task, count, threads, seed, **options)


def scripted_policy(name: str) -> Policy:
    """A policy written by hand that solves the task `name`: a function of observations that gives actions."""
    return find_named(_POLICIES, name, "task")()  # type: ignore[no-any-return]
