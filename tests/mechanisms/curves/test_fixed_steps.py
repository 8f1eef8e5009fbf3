"""Steps of one size on curves: they end at knots, so that every method keeps its order, and return to their grid."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from tests.kernel.scenes import needs_kernel
from tests.mechanisms.curves.scenes import CAM, SLOT, scene
from tests.stops.runs import run

pytestmark = needs_kernel
#: The cam on a shaft that nothing drives; its follower may lift off.
FREE = (
    CAM.replace("LAW", "cycloidal")
    .replace("type: cam,", "type: cam_contact, limits: {gap: LIMIT},")
    .replace("x_axis: [1, 0, 0]", "x_axis: [0, 0, 1]")
    .replace("0.06]", "0.05]")
    .replace("position: [0, 0, 0]}", "position: [0, 0, 0], angular_velocity: [0, -SPEED, 0]}")
    .partition("motions:")[0]
)
RIGID = FREE.replace("LIMIT", "{range: [0, null], rigid: true, restitution: 0}")
SOFT = FREE.replace("LIMIT", "{range: [0, null], stiffness: 1.0e+6 N/m}")


def at_end(body, duration, settings, formulation="planar"):
    report, found = run(scene(body, formulation, duration, f"{duration} s", settings))
    return report, np.concatenate([found[name][-1] for name in ("joints/coordinate", "joints/speed")])


def orders(body, duration, integrator, steps):
    """Between one number of steps and twice that, and so on; what happens is the same."""
    _, exact = at_end(body, duration, "integrator: dop853, tolerance: 1.0e-13")
    reports, found = zip(
        *(at_end(body, duration, f"integrator: {integrator}, step: {duration / n!r} s") for n in steps), strict=True
    )
    assert all(report.passed == "" and report.events > 0 for report in reports)
    errors = [np.abs(state - exact).max() for state in found]
    return [np.log2(one / other) for one, other in pairwise(errors)]


@pytest.mark.parametrize(
    ("body", "duration", "integrator", "steps", "least"),
    [
        (SLOT, 0.6, "rk4", (800, 1600), 3.9),
        (SLOT, 0.6, "dop853", (25, 50, 100), 7.5),
        (RIGID, 0.2, "rk4", (200, 400, 800), 3.9),
        (RIGID, 0.2, "dop853", (25, 50), 7.5),
        (SOFT, 0.2, "rk4", (800, 1600), 3.9),
        (SOFT, 0.2, "dop853", (200, 400), 7.5),
    ],
)
def test_methods_keep_their_order(body, duration, integrator, steps, least):
    """Of slots and of contacts, rigid and compliant."""
    assert min(orders(body.replace("SPEED", "30"), duration, integrator, steps)) >= least


def test_an_implicit_method_keeps_its_order():
    assert min(orders(SLOT, 0.6, "radau5", (50, 100))) >= 4.8


@pytest.mark.parametrize(("body", "steps"), [(SLOT, 0.01), (RIGID.replace("SPEED", "30"), 0.002)])
def test_formulations_agree(body, steps):
    """To what their steps of one size err alike."""
    settings, duration = f"integrator: dop853, step: {steps} s", 10 * steps
    (_, planar), (_, full) = (at_end(body, duration, settings, each) for each in ("planar", "full"))
    np.testing.assert_allclose(planar, full, rtol=1e-9, atol=1e-9)


def test_a_knot_changes_no_other_step():
    """Samples stay on the grid, and a run goes on to the bit of a longer one."""
    settings = "integrator: rk4, step: 10 ms"
    _, whole = run(scene(SLOT, "planar", 0.6, "10 ms", settings))
    _, part = run(scene(SLOT, "planar", 0.5, "10 ms", settings))
    np.testing.assert_array_equal(whole["time"], 0.01 * np.arange(61))
    np.testing.assert_array_equal(whole["joints/coordinate"][:50], part["joints/coordinate"][:50])


def test_a_follower_lifts_off_and_lands_on_the_way():
    """In flight it follows no curve: the events are those of a run with error control."""
    body, kinds = RIGID.replace("SPEED", "120"), ("release", "impact")
    _, exact = run(scene(body, "planar", 0.04, "40 ms"))
    _, found = run(scene(body, "planar", 0.04, "40 ms", "integrator: dop853, step: 0.5 ms"))
    for kind in kinds:
        times = [[event.time for event in each.of(kind)] for each in (exact, found)]
        assert len(times[0]) > 0
        np.testing.assert_allclose(times[1], times[0], atol=1e-9)
