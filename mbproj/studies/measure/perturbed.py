"""A mechanism with a start that differs by round-off."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbproj.linear.equilibrium.started import beside
from mbproj.model import initial_guess
from mbproj.studies.measure.mechanism import Mechanism

#: Size of the perturbation in units of the round-off of the mechanism's coordinates.
UNITS = 4.0


def perturbed(mechanism: Mechanism, seed: int) -> Mechanism:
    """Return the mechanism with a perturbed start that is consistent too. A random number of a few units in the last
    place of the largest changes each coordinate and velocity."""
    random, system, state = np.random.default_rng(seed), mechanism.system, mechanism.state
    size = np.tile([system.length] * 3 + [1.0] * 4, system.bodies)
    ulp = UNITS * np.finfo(float).eps
    q = state.q + ulp * np.maximum(size, np.abs(state.q)) * random.uniform(-1.0, 1.0, len(size))
    fastest = float(np.abs(state.v).max(initial=0.0))
    v = state.v + ulp * fastest * random.uniform(-1.0, 1.0, len(size))
    guess = replace(initial_guess(mechanism.scene, system), q=q, v=v)
    return Mechanism(mechanism.scene, system, beside(mechanism.scene, system, guess))
