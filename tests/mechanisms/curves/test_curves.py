"""Cams and slots in every formulation and with fixed steps."""

from __future__ import annotations

import csv
from itertools import pairwise

import numpy as np
import pytest

from mbproj import InputError, read_scene_text
from mbproj.functions.plane_curve import LAWS
from tests.kernel.scenes import needs_kernel
from tests.linear.closed_forms import modes_of
from tests.mechanisms.curves.scenes import CAM, SLOT, scene
from tests.stops.runs import run
from tests.support import DATA

pytestmark = needs_kernel


# Cams and slots: against closed forms, references that others computed, and in every formulation.

FORMULATIONS = ("planar", "reduced", "full")
#: A bead at the lowest point of an ellipse.
BEAD = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 1, tolerance: 1.0e-10}
curves: {oval: {ellipse: [WIDE, 0.4]}}
bodies: {bead: {mass: 0.5, inertia: [1.0e-4, 1.0e-4, 1.0e-4], position: [0, 0, -0.4]}}
joints:
  K: {type: slot, bodies: [ground, bead], curve: oval, locations: [[0, 0, 0], [0, 0, -0.4]], axis: [0, -1, 0],
      x_axis: [1, 0, 0]}
  P: {type: planar, bodies: [ground, bead], location: [0, 0, -0.4], axis: [0, -1, 0], x_axis: [1, 0, 0]}
"""


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_the_torque_of_a_cycloidal_cam(formulation):
    """Against the closed form, each 10 deg of a turn: lift, acceleration, torque, and the force on the roller."""
    with (DATA / "cam_cycloidal.csv").open() as file:
        rows = list(csv.DictReader(file))
    step = float(rows[0]["t_s"])
    count = 13 if formulation == "full" else len(rows)
    _, found = run(scene(CAM.replace("LAW", "cycloidal"), formulation, count * step, f"{step!r} s"))
    expected = {name: np.array([float(row[name]) for row in rows[:count]]) for name in rows[0]}
    lift = found["joints/coordinate"][1:, 1] + 0.01  # the scene's pose is half way
    np.testing.assert_allclose(lift, expected["lift_m"], atol=1e-14)
    np.testing.assert_allclose(found["joints/speed"][1:, 1], expected["velocity_m_s"], atol=1e-12)
    torque = found["motions/force"][1:, 0]
    np.testing.assert_allclose(torque, expected["torque_on_cam_Nm"], atol=1e-12 * np.abs(torque).max())
    push = np.linalg.norm(found["joints/reaction_force"][1:, 2], axis=1)
    np.testing.assert_allclose(push, expected["normal_force_N"], rtol=1e-12)


def law(name, x):
    """The rise of a law, as handbooks write it."""
    sine = np.sin(2.0 * np.pi * x) / (2.0 * np.pi)
    modified = np.select(
        [x <= 0.125, x <= 0.875],
        [
            np.pi * x - 0.25 * np.sin(4.0 * np.pi * x),
            2.0 + np.pi * x - 2.25 * np.sin(np.pi / 3.0 * (1.0 + 4.0 * x)),
        ],
        4.0 + np.pi * x - 0.25 * np.sin(4.0 * np.pi * x),
    ) / (4.0 + np.pi)
    return {
        "cycloidal": x - sine,
        "harmonic": 0.5 - 0.5 * np.cos(np.pi * x),
        "polynomial_345": 10.0 * x**3 - 15.0 * x**4 + 6.0 * x**5,
        "polynomial_4567": 35.0 * x**4 - 84.0 * x**5 + 70.0 * x**6 - 20.0 * x**7,
        "modified_sine": modified,
    }[name]


@pytest.mark.parametrize("name", sorted({*LAWS} - {"dwell", "modified_trapezoid"}))
def test_a_follower_moves_by_the_law(name):
    """From a law to a profile, by the dynamics, and back."""
    _, found = run(scene(CAM.replace("LAW", name), "planar", 0.2))
    angle = np.mod(np.pi / 2.0 - found["joints/coordinate"][:, 0], 2.0 * np.pi)
    x = angle / (2.0 * np.pi / 3.0)
    expected = np.select([x <= 1.0, x <= 1.5, x <= 2.5], [law(name, x), 1.0 + 0.0 * x, 1.0 - law(name, x - 1.5)], 0.0)
    np.testing.assert_allclose(found["joints/coordinate"][:, 1] + 0.01, 0.02 * expected, atol=1e-13)


@pytest.mark.full
def test_formulations_agree_on_a_slot():
    settings = "integrator: dop853, tolerance: 1.0e-7"
    reports, ends = zip(*(run(scene(SLOT, each, 0.6, "600 ms", settings)) for each in FORMULATIONS), strict=True)
    for name, size in (("joints/coordinate", 1e-12), ("joints/reaction_force", 1e-9)):
        for other in ends[:2]:
            np.testing.assert_allclose(other[name][-1], ends[2][name][-1], atol=size)
    assert [report.events for report in reports] == [1, 1, 1]  # a knot


def test_steps_that_end_at_knots_keep_the_energy():
    """Those of one size, too, to what they err by."""
    _, located = run(scene(SLOT, "planar", 2, "1 s"))
    report, fixed = run(scene(SLOT, "planar", 2, "1 s", "integrator: dop853, step: 1 ms"))
    assert located.unbalanced < 1e-10
    assert fixed.unbalanced < 1e-9
    assert (report.passed, report.events) == ("", 19)


@pytest.mark.parametrize(("wide", "expected"), [(0.4, 4.95227), (0.7, 2.82987), (0.3, 6.60303)])
def test_a_bead_swings_in_an_ellipse(wide, expected):
    """ω = sqrt(g b) / a."""
    found = np.abs(modes_of(BEAD.replace("WIDE", str(wide))).eigenvalues.imag).max()
    assert found == pytest.approx(np.sqrt(9.81 * 0.4) / wide, rel=1e-12)
    assert found == pytest.approx(expected, abs=1e-5)


def test_a_slot_ends_where_its_limits_are():
    """A bead bounces between the ends of a level slot: its displacement is as far as it has gone."""
    text = """
curves: {track: {polyline: [[0, 0], [1, 0], [1, 1]], fillet: 0.2}}
bodies: {bead: {mass: 1, inertia: [1, 1, 1], position: [0.4, 0, 0], velocity: [1, 0, 0]}}
joints:
  K: {type: slot, bodies: [ground, bead], curve: track, locations: [[0, 0, 0], [0.4, 0, 0]], axis: [0, -1, 0],
      x_axis: [1, 0, 0], limits: {displacement: {range: [0.2, 0.7], rigid: true, restitution: 1}}}
  P: {type: planar, bodies: [ground, bead], location: [0, 0, 0], axis: [0, -1, 0], x_axis: [1, 0, 0]}
"""
    for formulation in ("planar", "reduced"):
        _, found = run(scene(text, formulation, 1.0, "0.1 s"))
        t = found["time"]
        np.testing.assert_allclose(found["joints/coordinate"][:, 0], np.abs(np.abs(t - 0.3) - 0.5) + 0.2, atol=1e-12)


WRONG = {
    "points: [[0, 0], [1, 1], [1, 0], [0, 1]]": "crosses itself near [",
    "polyline: [[0, 0], [1, 0], [1, 1]]": "has corners; give the radius of their arcs as 'fillet'",
    "polyline: [[0, 0], [1, 0], [1, 1]], fillet: 2": "has no room for the arc at its point 2",
    "circle: 1, fillet: 2": "has no use for 'fillet'; it goes with polyline",
    "lift: {base: 1, rises: [[90 deg, 1, cycloidal]]}": "goes over 90 deg; the angles of its rises add up to 360 deg",
    "lift: {base: 1, rises: [[90 deg, 1, cosine], [270 deg, 0, dwell]]}": "unknown lift law 'cosine'",
    "lift: {base: 0.01, rises: [[30 deg, 0.1, harmonic], [330 deg, 0, harmonic]]}, flat: true": "is undercut at",
    "lift: {base: 0.01, rises: [[30 deg, 0.1, harmonic], [330 deg, 0, harmonic]]}, roller: 0.1": "is undercut where",
    "table: [[0, 1], [1, 1.1], [2, 1]]": "has 3 rows; give four or more",
    "points: [[0, 0], [0, 0], [1, 1]]": "has the same point twice",
}


@pytest.mark.parametrize(("curve", "message"), WRONG.items())
def test_wrong_curves(curve, message):
    with pytest.raises(InputError) as caught:
        read_scene_text(BEAD.replace("ellipse: [WIDE, 0.4]", curve))
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("curve: lift,", "curve: lift, roller: 60 mm, side: inside,", "does not fit curve 'lift'"),
        ("curve: lift,", "curve: lift, side: left,", "curve 'lift' is closed; give outside or inside"),
        ("curve: lift,", "curve: lfit,", "unknown curve 'lfit'; did you mean 'lift'?"),
        ("curve: lift,", "curve: open,", "joint 'K' may leave its curve, which ends; give limits"),
        ("{joint: A, angle: {constant_speed: 30 rad/s}", "{joint: K, displacement: 1", "acts along a closed curve"),
    ],
)
def test_what_does_not_fit_a_curve(old, new, message):
    text = scene(CAM.replace("LAW", "cycloidal")).replace(old, new)
    with pytest.raises(InputError) as caught:
        read_scene_text(text.replace("curves:\n", "curves:\n  open: {points: [[0, 0.05], [0.1, 0.06], [0.2, 0.05]]}\n"))
    assert message in str(caught.value)


# Steps of one size on curves: they end at knots, so that every method keeps its order, and return to their grid.

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
