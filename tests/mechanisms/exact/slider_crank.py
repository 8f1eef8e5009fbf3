"""A slider-crank's piston by the crank's angle."""

from __future__ import annotations

import numpy as np

from tests.mechanisms.running import Run


def piston(done: Run, θ: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """s = r cos θ + sqrt(l² - r² sin² θ) and its first two derivatives."""
    r, l = done.parameters["crank"], done.parameters["rod"]
    sine, cosine = np.sin(θ), np.cos(θ)
    root = np.sqrt(l**2 - r**2 * sine**2)
    slope = -(r**2) * sine * cosine / root
    return r * cosine + root, -r * sine + slope, -r * cosine - r**2 * (cosine**2 - sine**2) / root - slope**2 / root
