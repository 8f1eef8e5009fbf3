"""The transmission and the energy of a shaft with Hooke's joint."""

from __future__ import annotations

import numpy as np

from tests.mechanisms.closed_forms import Of
from tests.mechanisms.running import Run


def ratio(done: Run, φ1):
    """ω2 / ω1."""
    β = done.parameters["bend"]
    return np.cos(β) / (1.0 - np.sin(β) ** 2 * np.cos(φ1) ** 2)


def energy(done: Run) -> tuple[Of, Of]:
    """Moment of inertia on the driving shaft, of its angle, and no potential energy."""
    driving, driven, _ = done.scene.bodies
    return lambda φ1: driving.inertia[0][0] + driven.inertia[0][0] * ratio(done, φ1) ** 2, lambda φ1: 0.0
