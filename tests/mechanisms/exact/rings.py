"""Poses of Bennett's linkage and of Bricard's ring in closed form."""

from __future__ import annotations

import numpy as np

from tests.mechanisms.running import Run


def turn(axis: str, angle: complex) -> np.ndarray:
    """The rotation about a coordinate axis, analytic in the angle."""
    k = "xyz".index(axis)
    c, s = np.cos(angle), np.sin(angle)
    matrix = np.zeros((3, 3), dtype=complex)
    matrix[k, k] = 1.0
    i, j = (k + 1) % 3, (k + 2) % 3
    matrix[i, i], matrix[j, j], matrix[i, j], matrix[j, i] = c, c, -s, s
    return matrix


def bennett_ratio(done: Run) -> float:
    alpha, beta = done.parameters["alpha"], done.parameters["beta"]
    return np.sin((alpha + beta) / 2) / np.sin((beta - alpha) / 2)


def bennett_poses(done: Run, theta: complex) -> tuple[np.ndarray, np.ndarray]:
    """By Denavit & Hartenberg's frames from both ends of the frame, with θ2 of the closed relation."""
    p = done.parameters
    a, b, alpha, beta = (p[name] for name in ("short", "long", "alpha", "beta"))
    half = theta / 2  # θ2/2 = atan2(k cos θ1/2, sin θ1/2), free of poles: cos and sin of θ2 are rational in these
    x, y = np.sin(half), bennett_ratio(done) * np.cos(half)
    cosine, sine = (x * x - y * y) / (x * x + y * y), 2 * x * y / (x * x + y * y)
    next_turn = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]])
    crank = turn("z", theta)
    coupler = crank @ turn("x", alpha) @ next_turn
    rocker = turn("x", -beta) @ next_turn
    centres = a / 2 * crank[:, 0], a * crank[:, 0] + b / 2 * coupler[:, 0], [-b, 0, 0] - a / 2 * rocker[:, 0]
    return np.array(centres), np.array([crank, coupler, rocker])


def bricard_poses(done: Run, u: complex) -> tuple[np.ndarray, np.ndarray]:
    """The chain of five bars, pin after pin."""
    x = np.sqrt(3) * np.sin(u)
    beta = 2 * np.arctan(x) - np.pi / 2
    alpha = 2 * np.arctan(np.sqrt(3) * np.cos(u) / np.sqrt(1 + x * x)) - np.pi / 2
    corner, rotation, centres, rotations = np.array([1.0, 1.0, 0.0]), np.eye(3), [], []
    for axis, angle, bar in zip("zyxzy", (beta, alpha, beta, alpha, beta), BARS, strict=True):
        rotation = rotation @ turn(axis, angle)
        centres.append(corner + rotation @ bar / 2)
        rotations.append(rotation)
        corner = corner + rotation @ bar
    return done.parameters["side"] * np.array(centres), np.array(rotations)


#: Along the bars at the start, for a cube of side 1.
BARS = np.array([[-1.0, 0, 0], [0, 0, 1], [0, -1, 0], [1, 0, 0], [0, 0, -1]])
