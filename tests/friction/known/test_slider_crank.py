"""A slider-crank whose guide resists by the force across it, which friction itself changes: against the equations of
its bodies, integrated by SciPy."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import InputError
from tests.friction import slider_crank as crank
from tests.stops.runs import run


@pytest.mark.parametrize("rate", [12.0, -12.0])
def test_the_equations_of_the_bodies_keep_their_energy(rate):
    """What SciPy integrates loses what friction takes, by energies that it does not know."""
    motion = crank.Motion(crank.START, rate, 0.3, 0.4, 0.5)
    φ, speed, lost = motion(0.5)
    assert crank.energy(crank.START, rate) - crank.energy(φ, speed) == pytest.approx(lost, abs=1e-9)
    assert lost > 0.3


@pytest.mark.parametrize(("formulation", "rate"), [("reduced", 12.0), ("reduced", -12.0), ("full", -12.0)])
def test_it_turns_as_the_equations_of_its_bodies_have_it(formulation, rate):
    """Through two reversals of the slider, at its dead centres, where the crank goes on."""
    duration = 0.08 if formulation == "full" else 0.5
    motion = crank.Motion(crank.START, rate, 0.3, 0.4, duration)
    assert len(motion.times) == (1 if formulation == "full" else 2)
    _, recorded = run(crank.linkage(rate, 0.3, 0.4, duration, formulation))
    found = np.array([motion(t) for t in recorded["time"]])
    assert recorded["joints/coordinate"][:, 0] == pytest.approx(found[:, 0] - crank.START, abs=1e-8)
    assert recorded["joints/speed"][:, 0] == pytest.approx(found[:, 1], abs=1e-7)
    assert recorded["friction/dissipation"][:, 0] == pytest.approx(found[:, 2], abs=1e-7)
    assert recorded["joints/violation"].max() < 2e-13
    assert recorded.unbalanced < 1e-7


def test_it_comes_to_rest_between_its_dead_centres_and_stays():
    motion = crank.Motion(crank.START, 6.0, 0.3, 0.6, 1.3)
    assert motion.rests < 1.1
    _, recorded = run(crank.linkage(6.0, 0.3, 0.6, 1.3, "reduced"))
    last = recorded.of("stick")[-1]
    assert last.time == pytest.approx(motion.rests, abs=1e-8)
    assert recorded["joints/speed"][-1] == pytest.approx(0.0, abs=1e-11)
    assert recorded["joints/coordinate"][-1, 0] == pytest.approx(motion(1.3)[0] - crank.START, abs=1e-8)


#: Four joints that each hold the plane: what they carry across it is not unique.
REDUNDANT = f"""
  B: {{type: revolute, bodies: [crank, rod], location: [{crank.PIN[0]}, {crank.PIN[1]}, 0], axis: [0, 0, 1]}}
  C: {{type: revolute, bodies: [rod, slider], location: [{crank.END}, 0, 0], axis: [0, 0, 1]}}
"""


def test_friction_by_what_redundant_joints_share_is_refused_and_a_constant_one_is_not():
    text = crank.linkage(12.0, 0.3, 0.4, 0.02, "reduced").replace(crank.PINS.strip("\n"), REDUNDANT.strip("\n"))
    with pytest.raises(
        InputError, match=r"'guide' depends on the load of joint 'D', which is not unique.*'A', 'B', 'C'"
    ):
        run(text)
    _, recorded = run(text.replace("coefficient: 0.3, static: 0.4", "force: 3"))
    slid = crank.slider(crank.START, 0.0)[0] - crank.slider(crank.START + recorded["joints/coordinate"][-1, 0], 0.0)[0]
    assert recorded["friction/dissipation"][-1, 0] == pytest.approx(3.0 * slid, rel=1e-8)
