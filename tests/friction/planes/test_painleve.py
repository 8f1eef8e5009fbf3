"""Painlevé's rod: one end of it slides on a rough floor."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import SimulationError
from tests.stops.runs import run

ROD = """
mbproj: 1
gravity: [0, 0, -10]
parameters: {tilt: {tilt}, a: 0.5}
simulation: {duration: 0.02, output_step: 0.01, integrator: dopri5, tolerance: 1.0e-9, formulation: {formulation}}
bodies:
  rod:
    mass: 2
    inertia: [2 * a**2 / 3, 2 * a**2 / 3, 0.001]
    position: [0, 0, a * sin(tilt)]
    orientation: {axis: [0, 1, 0], angle: 90 deg - tilt}
    velocity: [{speed}, 0, 0]
forces:
  floor:
    type: stop
    plane: {body: ground, location: [0, 0, 0], normal: [0, 0, 1]}
    point: {body: rod, location: {rod: [0, 0, -a]}}
    rigid: true
    friction: {friction}
"""


def rod(tilt, speed, friction, formulation="auto"):
    text = ROD
    for name, value in (("tilt", tilt), ("speed", speed), ("friction", friction), ("formulation", formulation)):
        text = text.replace(f"{{{name}}}", str(value))
    return run(text)


def push(tilt, friction):
    """N of a rod that slides, m g / (1 + 3 cos² + 3 μ sin cos), with μ < 0 where it leans towards its motion."""
    return 20.0 / (1.0 + 3.0 * np.cos(tilt) ** 2 + 3.0 * friction * np.sin(tilt) * np.cos(tilt))


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", ["auto", "full"])
@pytest.mark.parametrize(("tilt", "friction"), [(0.7, 0.3), (np.arctan(2.0), 1.2), (0.7, 3.0), (1.4, 4.0)])
def test_trailing_it_slides_whatever_the_friction(tilt, friction, formulation):
    """Friction relieves the end that trails: the push is smaller, and there is always one."""
    _, recorded = rod(tilt, 2.0, friction, formulation)
    assert recorded["stops/force"][0, 0] == pytest.approx(push(tilt, friction), rel=1e-9)
    assert recorded["friction/force"][0, 0] == pytest.approx(-friction * push(tilt, friction), rel=1e-9)


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", ["auto", "full"])
def test_pushed_before_itself_it_presses_harder(formulation):
    _, recorded = rod(np.arctan(2.0), -2.0, 1.2, formulation)
    assert recorded["stops/force"][0, 0] == pytest.approx(push(np.arctan(2.0), -1.2), rel=1e-9)


@pytest.mark.parametrize("formulation", ["auto", "full"])
@pytest.mark.parametrize(("tilt", "friction"), [(np.arctan(2.0), 1.4), (0.7, 3.0), (1.4, 4.0)])
def test_pushed_before_itself_with_much_friction_it_has_no_motion(tilt, friction, formulation):
    """Above μ = (1 + 3 cos²)/(3 sin cos), 4/3 at the least, no push keeps the end on the floor (Painlevé 1895)."""
    assert push(tilt, -friction) < 0.0
    with pytest.raises(SimulationError, match=r"friction 'floor.*no solution or two.*Painlevé"):
        rod(tilt, -2.0, friction, formulation)
