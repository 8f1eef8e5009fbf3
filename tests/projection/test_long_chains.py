"""Chains whose far end closes no better than to round-off that is large at the near one: that is no failure."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import Scene
from mbproj.base.settings import Settings
from mbproj.motion.simulate import simulate
from mbproj.scene.records import Body, Joint, Pair
from tests.kernel.scenes import assembled, needs_kernel
from tests.support import scene_of

Y = (0.0, 1.0, 0.0)


def chain(lengths: np.ndarray) -> Scene:
    """Rods that hang on each other in one line, in a plane; the first turns at 1 rad/s."""
    bodies, joints, above, depth = [], [], "ground", 0.0
    for number, length in enumerate(map(float, lengths)):
        name, moment, at = f"rod{number}", length * length / 12.0, (0.0, 0.0, -depth)
        moments = ((moment, 0.0, 0.0), (0.0, moment, 0.0), (0.0, 0.0, 0.01 * moment))
        bodies.append(Body(name, 1.0, moments, (0.0, 0.0, -depth - 0.5 * length)))
        speed = {} if number else {"angle": 1.0}
        joints.append(Joint(f"pin{number}", "revolute", (above, name), Pair(at, at), Pair(Y, Y), speed=speed))
        above, depth = name, depth + length
    return scene_of(bodies, joints)


@needs_kernel
@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_each_step_of_a_chain_from_a_centimetre_to_a_kilometre_takes_one_factor_beyond_its_stages(formulation):
    """The last joints are 20 km away, where positions are known to 4e-12 m; the first are open by 1e-13 m at most."""
    system, state = assembled(chain(np.geomspace(1e-2, 1e3, 100)))
    steps = 200
    settings = Settings(duration=steps * 1e-3, step=1e-3, output_step=0.2, formulation=formulation)
    counters = simulate(system, state, settings).counters
    assert counters["projection_failures"] == 0
    assert counters["factorisations"] <= 4.2 * steps
