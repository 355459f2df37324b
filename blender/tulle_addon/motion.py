"""How something moves: whether matrices are a rigid motion, and keyframes of one."""
from typing import Any, Dict, List, Optional

import numpy as np

# Matrices of Blender hold floats; turns that are read from them are exact to some 1e-7.
RIGID_TOLERANCE = 1e-5
WHOLE_TURN_TOLERANCE = 1e-6  # [rad]


def find_turn(first: np.ndarray, later: np.ndarray) -> Optional[np.ndarray]:
    """The rotation that leads from one matrix to another; None where the way also scales, shears or mirrors."""
    turn = later[:3, :3] @ np.linalg.inv(first[:3, :3])
    if np.linalg.det(turn) < 0 or np.abs(turn.T @ turn - np.eye(3)).max() > RIGID_TOLERANCE:
        return None
    u, _, vt = np.linalg.svd(turn)
    return u @ vt


def find_axis_angle(turn: np.ndarray) -> Dict[str, Any]:
    """Axis and angle [rad], 0 to pi, by the largest part of the quaternion, which is exact at every angle."""
    m = turn
    squares = np.array([1 + m[0, 0] + m[1, 1] + m[2, 2], 1 + m[0, 0] - m[1, 1] - m[2, 2],
                        1 - m[0, 0] + m[1, 1] - m[2, 2], 1 - m[0, 0] - m[1, 1] + m[2, 2]])  # fmt: skip
    largest = int(np.argmax(squares))
    products = [
        [squares[0], m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]],
        [m[2, 1] - m[1, 2], squares[1], m[0, 1] + m[1, 0], m[0, 2] + m[2, 0]],
        [m[0, 2] - m[2, 0], m[0, 1] + m[1, 0], squares[2], m[1, 2] + m[2, 1]],
        [m[1, 0] - m[0, 1], m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], squares[3]],
    ]
    q = np.array(products[largest]) / np.linalg.norm(products[largest])
    if q[0] < 0:
        q = -q
    length = float(np.linalg.norm(q[1:]))
    if length < 1e-12:
        return {"axis": [1.0, 0.0, 0.0], "angle": 0.0}
    return {"axis": (q[1:] / length).tolist(), "angle": 2.0 * float(np.arctan2(length, q[0]))}


def unwind(turn: Dict[str, Any], before: Dict[str, Any]) -> Dict[str, Any]:
    """The same turn with the axis and the whole turns that lie nearest to those before: angles of a scene go as they are given."""
    axis, last = np.array(turn["axis"]), np.array(before["axis"]) * before["angle"]
    length = float(np.linalg.norm(last))
    if turn["angle"] < WHOLE_TURN_TOLERANCE and length > 0.0:  # whole turns have the axis of the way there
        axis = last / length
    turns = round((float(axis @ last) - turn["angle"]) / (2.0 * np.pi))
    return {"axis": axis.tolist(), "angle": turn["angle"] + 2.0 * np.pi * turns}


def make_keyframes(matrices: List[np.ndarray], interval: float, scale: float) -> Optional[List[Dict[str, Any]]]:
    """Keyframes about the origin of the first matrix, without those within a rest; None where the motion is not rigid."""
    keyframes: List[Dict[str, Any]] = []
    for number, matrix in enumerate(matrices):
        if 0 < number < len(matrices) - 1 and all(np.array_equal(matrix, matrices[number + k]) for k in (-1, 1)):
            continue
        turn = find_turn(matrices[0], matrix)
        if turn is None:
            return None
        shift = (matrix[:3, 3] - matrices[0][:3, 3]) * scale
        rotate = find_axis_angle(turn)
        if keyframes:
            rotate = unwind(rotate, keyframes[-1]["rotate"])
        keyframes.append({"time": number * interval, "translate": shift.tolist(), "rotate": rotate})
    return keyframes


def is_still(matrices: List[np.ndarray]) -> bool:
    return all(np.array_equal(matrices[0], matrix) for matrix in matrices)
