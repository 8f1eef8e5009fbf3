"""Pins in slots, in the plane and in space."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import InputError, read_scene_text
from tests.kernel.scenes import needs_kernel
from tests.mechanisms.curves.scenes import WIRE, scene
from tests.stops.runs import run

pytestmark = needs_kernel


# A pin on a curve in space: its speed, its force, its ends, order of the methods, messages.


def state(found):
    return np.hstack([found["bodies/position"][-1].ravel(), found["bodies/velocity"][-1].ravel()])


def test_a_bead_keeps_its_energy_and_its_place():
    """In full and in the kernel; the knots of the spline are located."""
    runs = {name: run(scene(WIRE, name, 0.06 if name == "full" else 0.3, "20 ms"))[1] for name in ("reduced", "full")}
    found, full = runs["reduced"], runs["full"]
    assert found.unbalanced < 1e-10
    assert len(found.of("knot of its curve")) >= 1
    np.testing.assert_allclose(full["bodies/position"], found["bodies/position"][:4], atol=1e-12)
    np.testing.assert_allclose(full["joints/reaction_force"], found["joints/reaction_force"][:4], atol=1e-9)
    along = np.diff(found["joints/coordinate"][:, 1])
    assert (along > 0.0).all()


def test_a_wire_in_a_plane_is_its_slot():
    """The same points flat, once as a slot of the plane and once as a slot in space: motions, places and forces."""
    points = [[0.3, 0.0], [0.1, 0.25], [-0.2, 0.2], [-0.3, -0.1], [0.0, -0.28]]
    flat = WIRE[: WIRE.index("[[0.3")] + str([[*each, 0.0] for each in points]) + WIRE[WIRE.index("\nbodies") :]
    flat = flat.replace("[0.3, 0, 0.02]", "[0.3, 0, 0]")
    slot = flat.replace(str([[*each, 0.0] for each in points]), str(points)).replace("space_points", "points")
    slot = slot.replace("space_slot", "slot")
    (_, found), (_, expected) = (run(scene(each, "reduced", 0.3, "20 ms")) for each in (flat, slot))
    np.testing.assert_allclose(found["bodies/position"], expected["bodies/position"], atol=1e-11)
    np.testing.assert_allclose(found["joints/coordinate"], expected["joints/coordinate"], atol=1e-11)
    np.testing.assert_allclose(found["joints/reaction_force"], expected["joints/reaction_force"], atol=1e-8)


def test_the_order_of_the_methods_is_kept():
    """Steps end at the knots: 0.2 s in fixed steps, against the finest."""
    ends = {}
    for method, steps in (("rk4", (200, 400)), ("dop853", (4, 8))):
        for count in (*steps, 40):
            settings = f"integrator: {method}, step: {0.2 / count!r}"
            ends[method, count] = state(run(scene(WIRE, "reduced", 0.2, "0.2", settings))[1])
    for method, (coarse, fine), least in (("rk4", (200, 400), 3.9), ("dop853", (4, 8), 7.5)):
        errors = [np.abs(ends[method, count] - ends["dop853", 40]).max() for count in (coarse, fine)]
        assert np.log2(errors[0] / errors[1]) >= least, errors


def test_a_bead_stops_at_the_ends_of_its_wire():
    """Down a straight wire from 10 mm on: s = s0 + g sin(α) t² / 2, and the end is met when that is its limit."""
    text = """
curves: {wire: {space_points: [[0, 0, 0], [0.12, 0.16, -0.15], [0.24, 0.32, -0.3]]}}
bodies: {bead: {mass: 0.5, inertia: [1.0e-4, 1.0e-4, 1.0e-4], position: [0.0048, 0.0064, -0.006]}}
joints:
  K: {type: space_slot, bodies: [ground, bead], curve: wire, locations: [[0, 0, 0], [0.0048, 0.0064, -0.006]],
      axis: [0, 0, 1], x_axis: [1, 0, 0],
      limits: {displacement: {range: [0, 0.4 m], rigid: true, restitution: 0.5}}}
"""
    _, found = run(scene(text, "reduced", 0.5, "10 ms"))
    (first, *_) = found.of("impact")
    assert abs(first.time - np.sqrt(2.0 * 0.39 / (9.81 * 0.6))) < 1e-10
    way = found["joints/coordinate"][:, 0]
    early = found["time"] < first.time
    np.testing.assert_allclose(way[early], 0.01 + 0.5 * 9.81 * 0.6 * found["time"][early] ** 2, atol=1e-12)
    assert way.max() <= 0.4 + 1e-12


def test_a_pin_may_be_at_the_origin_of_its_curve():
    """The curve goes through its own origin, and both locations are one point."""
    text = WIRE.replace("[0.3, 0, 0.02]", "[0, 0, 0]").replace("velocity: [0, 1.44, 0.3]", "velocity: [0, 0, 0]")
    assert "locations: [[0, 0, 0], [0, 0, 0]]" in text
    _, found = run(scene(text, "reduced", 0.02, "10 ms"))
    np.testing.assert_allclose(found["curves/contact"][:, 0], found["bodies/position"][:, 1], atol=1e-13)


def test_friction_along_a_wire_takes_its_work():
    """A constant force against the motion: the energy lost is the force times the way."""
    text = WIRE + "forces: {rubs: {type: friction, joint: K, coulomb: {force: 0.2 N}}}\n"
    _, found = run(scene(text, "reduced", 0.15, "10 ms"))
    way = found["joints/coordinate"][-1, 1] - found["joints/coordinate"][0, 1]
    np.testing.assert_allclose(found["friction/dissipation"][-1, 0], 0.2 * way, rtol=1e-10)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("    closed: true\n", "", "may leave its curve, which ends"),
        ("type: space_slot", "type: slot", "curve 'wire' is in space"),
        ("curve: wire", "curve: disc", "curve 'disc' is in a plane"),
        ("x_axis: [1, 0, 0]", "x_axis: x, limits: {displacement: {range: [0, 1], rigid: true}}", "begins anew"),
        ("[0.1, 0.25, -0.03]", "[0.1, 0.25]", "[a number in m, a number in m, a number in m]"),
        ("[0.1, 0.25, -0.03]", "[0.3, 0, 0.02]", "has the same point twice"),
    ],
)
def test_what_is_refused(old, new, message):
    assert old in WIRE
    text = WIRE.replace(old, new).replace("curves:\n", "curves:\n  disc: {circle: 0.1}\n")
    with pytest.raises(InputError) as caught:
        read_scene_text(scene(text))
    assert message in str(caught.value)


# Archimedes' trammel: a rod whose ends slide in two straight slots; its points draw ellipses.

LENGTH, RATE, START = 0.5, 3.0, 0.3
#: Free of gravity its centre goes round a circle, so that it turns at a constant rate.
TRAMMEL = f"""
curves: {{track: {{points: [[-1, 0], [-0.5, 0], [0.5, 0], [1, 0]]}}}}
bodies:
  rod:
    mass: 2
    inertia: [0.1, 0.1, 0.1]
    position: [{LENGTH / 2}*cos({START}), 0, {LENGTH / 2}*sin({START})]
    velocity: [-{RATE * LENGTH / 2}*sin({START}), 0, {RATE * LENGTH / 2}*cos({START})]
    angular_velocity: [0, {RATE}, 0]
joints:
  plane: {{type: planar, bodies: [ground, rod], location: [0, 0, 0], axis: [0, 1, 0]}}
  level: {{type: slot, bodies: [ground, rod], curve: track, axis: [0, -1, 0], x_axis: [1, 0, 0],
    locations: [[0, 0, 0], [{LENGTH}*cos({START}), 0, 0]],
    limits: {{displacement: {{range: [0.1, 1.9], rigid: true}}}}}}
  upright: {{type: slot, bodies: [ground, rod], curve: track, axis: [0, -1, 0], x_axis: [0, 0, 1],
    locations: [[0, 0, 0], [0, 0, {LENGTH}*sin({START})]],
    limits: {{displacement: {{range: [0.1, 1.9], rigid: true}}}}}}
markers:
  pen: {{body: rod, location: {{rod: [0.25*{LENGTH}*cos({START}), 0, -0.25*{LENGTH}*sin({START})]}}}}
"""


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_a_trammel_draws_an_ellipse(formulation):
    text = scene(TRAMMEL, formulation, 2.5, "0.05 s").replace("[0, 0, -9.81]", "[0, 0, 0]")
    _, recorded = run(text)
    angle = START + RATE * recorded["time"]
    pen = recorded["markers/position"][:, 0]
    expected = [0.75 * LENGTH * np.cos(angle), 0.0 * angle, 0.25 * LENGTH * np.sin(angle)]
    np.testing.assert_allclose(pen.T, expected, atol=1e-11)
    along = recorded["joints/coordinate"][:, [3, 4]] - 1.0
    np.testing.assert_allclose(along.T, [LENGTH * np.cos(angle), LENGTH * np.sin(angle)], atol=1e-11)
