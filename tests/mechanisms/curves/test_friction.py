"""Dry friction along slots and cams, against its closed form."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import InputError, read_scene_text
from tests.kernel.scenes import needs_kernel
from tests.mechanisms.curves.scenes import scene
from tests.stops.runs import run

pytestmark = needs_kernel
#: A bead in a slot that is straight, and then a quarter of a circle of 0.5 m.
BEAD = """
curves: {track: {polyline: [[0, 0], [1, 0], [1, 4]], fillet: 0.5}}
bodies: {bead: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [0.3, 0, 0], velocity: [2, 0, 0]}}
joints:
  K: {type: KIND, bodies: [ground, bead], curve: track, locations: [[0, 0, 0], [0.3, 0, 0]], axis: [0, -1, 0],
      x_axis: [1, 0, 0], limits: {displacement: {range: [0.1, 3.5], rigid: true}}}
  P: {type: planar, bodies: [ground, bead], location: [0, 0, 0], axis: [0, -1, 0], x_axis: [1, 0, 0]}
forces:
  rubs: {type: friction, joint: K, coulomb: {FRICTION}}
"""


def text(kind, formulation="auto", friction="force: 5 N", **how):
    body = BEAD.replace("KIND", kind).replace("FRICTION", friction)
    return scene(body, formulation, 1.0, "0.05 s", **how).replace("[0, 0, -9.81]", "[0, 0, 0]")


@pytest.mark.parametrize(
    ("kind", "formulation"), [("slot", "planar"), ("slot", "reduced"), ("cam, side: left", "planar")]
)
def test_friction_brings_a_bead_to_rest(kind, formulation):
    """By 5 N: s = v t - F t²/2m until it sticks, on the straight and on the arc alike."""
    _, recorded = run(text(kind, formulation))
    t = np.minimum(recorded["time"], 2.0 * 2.0 / 5.0)
    np.testing.assert_allclose(recorded["joints/coordinate"][:, 0], 0.3 + 2.0 * t - 1.25 * t**2, atol=1e-10)
    assert recorded["friction/state"][-1, 0] == 0.0
    np.testing.assert_allclose(recorded["friction/dissipation"][-1, 0], 4.0, atol=1e-9)


ROUND = BEAD.replace("{polyline: [[0, 0], [1, 0], [1, 4]], fillet: 0.5}", "{circle: 0.5}").replace(
    ", limits: {displacement: {range: [0.1, 3.5], rigid: true}}", ""
)


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize(
    ("kind", "formulation"), [("slot", "planar"), ("cam", "planar"), ("cam", "reduced"), ("slot", "full")]
)
def test_what_a_curve_carries_slows_a_bead_round_after_round(kind, formulation):
    """N = m v²/r: so v = v₀ / (1 + μ v₀ t/r), over more than a turn of the closed curve."""
    body = ROUND.replace("KIND", kind).replace("FRICTION", "coefficient: 0.2")
    body = body.replace("[0.3, 0, 0], velocity: [2, 0, 0]", "[0.5, 0, 0], velocity: [0, 0, 4]").replace("0.3,", "0.5,")
    duration = 0.1 if formulation == "full" else 2.5
    _, recorded = run(scene(body, formulation, duration, "0.05 s").replace("[0, 0, -9.81]", "[0, 0, 0]"))
    slower = 1.0 + 0.2 * 4.0 * recorded["time"] / 0.5
    angle = np.log(slower) / 0.2
    np.testing.assert_allclose(recorded["joints/speed"][:, 0], 4.0 / slower, atol=1e-10)
    np.testing.assert_allclose(recorded["bodies/position"][:, 0, 0], 0.5 * np.cos(angle), atol=1e-10)
    assert formulation == "full" or angle[-1] > 2.0 * np.pi


@pytest.mark.parametrize(("slope", "slides"), [(0.15, False), (0.3, True)])
def test_what_a_straight_slot_carries_holds_a_bead_up_to_its_angle(slope, slides):
    """At tan α = 0.15 or 0.3 with μ = 0.2: it stays, or it slides by g (sin α - μ cos α)."""
    angle = np.arctan(slope)
    gravity = f"[{float(9.81 * np.sin(angle))!r}, 0, {float(-9.81 * np.cos(angle))!r}]"
    body = BEAD.replace("KIND", "slot").replace("FRICTION", "coefficient: 0.2").replace(", velocity: [2, 0, 0]", "")
    body = body.replace("polyline: [[0, 0], [1, 0], [1, 4]], fillet: 0.5", "polyline: [[0, 0], [4, 0]]")
    _, recorded = run(scene(body, "planar", 1.0, "0.1 s").replace("[0, 0, -9.81]", gravity))
    own = 9.81 * (np.sin(angle) - 0.2 * np.cos(angle)) if slides else 0.0
    np.testing.assert_allclose(recorded["joints/coordinate"][:, 0], 0.3 + 0.5 * own * recorded["time"] ** 2, atol=1e-10)


def test_what_a_roller_carries_is_no_measure_of_friction():
    body = ROUND.replace("KIND", "cam, roller: 0.1").replace("FRICTION", "coefficient: 0.2").replace("0.3,", "0.6,")
    with pytest.raises(InputError, match="has a roller, which rolls"):
        read_scene_text(scene(body))
