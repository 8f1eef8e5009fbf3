"""A rod that falls on rough ends of unequal restitution: its impacts come ever faster, and it ends in contact."""

from __future__ import annotations

import numpy as np
import pytest

from tests.stops.runs import run

ROD = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {{duration: 2, {steps}, output_step: 0.05, formulation: {formulation}, impact_law: {law}}}
bodies:
  rod:
    mass: 1
    inertia: [0.001, 0.0208, 0.0208]
    position: [0, 0, 0.5]
    orientation: {{axis: [0, 1, 0], angle: {angle} deg}}
    velocity: [{speed}, 0, 0]
joints: {{P: {{type: planar, bodies: [ground, rod], location: [0, 0, 0], axis: [0, 1, 0]}}}}
forces:
  {first}
  {second}
"""
END = (
    "{name}: {{type: stop, plane: {{body: ground, location: [0, 0, 0], normal: [0, 0, 1]}}, "
    "point: {{body: rod, location: {{rod: [{x}, 0, 0]}}}}, rigid: true, restitution: {e}, friction: {friction}}}"
)
ENDS = (("a", 0.25, 0.2), ("b", -0.25, 0.8))
STEPS = {"dop853": "integrator: dop853, tolerance: 1e-9", "rk4": "integrator: rk4, step: 1e-3"}


def rod(*, angle=20, speed=0.3, friction=0.3, steps="dop853", formulation="planar", law="newton", ends=ENDS):
    first, second = (END.format(name=name, x=x, e=e, friction=friction) for name, x, e in ends)
    return ROD.format(
        angle=angle, speed=speed, steps=STEPS[steps], formulation=formulation, law=law, first=first, second=second
    )


@pytest.mark.parametrize("law", ["newton", "poisson"])
@pytest.mark.parametrize("steps", ["dop853", "rk4"])
@pytest.mark.parametrize("formulation", ["planar", "reduced"])
@pytest.mark.parametrize("thrown", [{}, {"angle": -35, "speed": -1, "friction": 0.5}])
def test_it_ends_at_rest_on_both_ends(thrown, formulation, steps, law):
    _, recorded = run(rod(formulation=formulation, steps=steps, law=law, **thrown))
    assert len(recorded.of("impact")) > 10
    assert recorded["stops/force"][-1] == pytest.approx(np.full(2, 0.5 * 9.81), abs=1e-9)
    assert np.abs(recorded["bodies/velocity"][-1]).max() < 1e-12
    assert recorded["bodies/position"][-1, 0, 2] == pytest.approx(0.0, abs=1e-12)
    assert recorded.unbalanced < 1e-7


def test_the_order_of_its_ends_changes_nothing():
    """But round-off, which impacts that come ever faster make larger."""
    (_, one), (_, other) = (run(rod(ends=ends)) for ends in (ENDS, ENDS[::-1]))
    np.testing.assert_allclose(other["bodies/position"], one["bodies/position"], rtol=0, atol=1e-8)
    assert one["bodies/position"][-1, 0, 0] > 0.05
