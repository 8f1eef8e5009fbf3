"""Cams and slots: against closed forms, references that others computed, and in every formulation."""

from __future__ import annotations

import csv

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
