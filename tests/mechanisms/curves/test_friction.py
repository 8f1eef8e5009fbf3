"""Dry friction along slots, cams and wires, and where profiles slide on each other."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import InputError, read_scene_text
from tests.crossed import full
from tests.kernel.scenes import needs_kernel
from tests.mechanisms.curves.scenes import WIRE, scene
from tests.stops.runs import run

pytestmark = needs_kernel


# Dry friction by load where profiles slide on each other, and along a wire: against closed forms.

G = 9.81
#: A disc that turns under a tappet of 2 kg, beside its axis.
TAPPET = """
curves: {disc: {circle: 0.1}}
bodies:
  cam: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [0, 0, 0], angular_velocity: [0, -20, 0]}
  tappet: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [0.03, 0, 0.1]}
joints:
  axle: {type: revolute, bodies: [ground, cam], location: [0, 0, 0], axis: [0, -1, 0]}
  guide: {type: prismatic, bodies: [ground, tappet], location: [0.03, 0, 0.1], axis: z}
  T: {type: flat_follower, bodies: [cam, tappet], curve: disc, locations: [[0, 0, 0], [0.03, 0, 0.1]],
      axis: [0, -1, 0], x_axis: [1, 0, 0], normal: z}
forces: {rubs: {type: friction, joint: T, coulomb: {coefficient: 0.2}}}
"""
#: A disc that turns under another one of 2 kg, which a link holds beside.
WHEELS = """
curves: {one: {circle: 0.1}, two: {circle: 0.2}}
bodies:
  a: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [0, 0, 0], angular_velocity: [0, -20, 0]}
  b: {mass: 2, inertia: [0.08, 0.08, 0.08], position: [0, 0, 0.3]}
joints:
  A: {type: revolute, bodies: [ground, a], location: [0, 0, 0], axis: [0, -1, 0]}
  P: {type: planar, bodies: [ground, b], location: [0, 0, 0.3], axis: [0, -1, 0], x_axis: [1, 0, 0]}
  L: {type: distance, bodies: [ground, b], locations: [[-0.5, 0, 0.3], [0, 0, 0.3]]}
  T: {type: curve_on_curve, bodies: [a, b], curves: [one, two], sides: [outside, outside],
      locations: [[0, 0, 0], [0, 0, 0.3]], axis: [0, -1, 0], x_axis: [1, 0, 0]}
forces: {rubs: {type: friction, joint: T, coulomb: {coefficient: 0.2}}}
"""


@pytest.mark.parametrize("formulation", ["planar", "reduced", full("full")])
def test_a_tappet_brakes_its_disc_until_it_sticks(formulation):
    """By μ m g R, and then both are at rest."""
    slower = 0.2 * 2.0 * G * 0.1 / 0.01
    _, found = run(scene(TAPPET, formulation, 0.6 if formulation != "full" else 0.05, "10 ms"))
    expected = np.maximum(20.0 - slower * found["time"], 0.0)
    np.testing.assert_allclose(np.abs(found["joints/speed"][:, 0]), expected, atol=1e-9)
    np.testing.assert_allclose(np.abs(found["friction/rate"][:, 0]), 0.1 * expected, atol=1e-10)
    if formulation != "full":
        assert found["friction/state"][-1, 0] == 0.0
        np.testing.assert_allclose(found["friction/dissipation"][-1, 0], 0.5 * 0.01 * 400.0, rtol=1e-9)
    assert found.unbalanced < 1e-8


@pytest.mark.parametrize("formulation", ["planar", "reduced", full("full")])
def test_one_disc_drives_another_until_they_roll(formulation):
    """P = μ m g t along the rims: they roll once R ω is the same of both, and go on so, round after round."""
    force, (Ra, Rb), (Ja, Jb) = 0.2 * 2.0 * G, (0.1, 0.2), (0.01, 0.08)
    rolls = 20.0 * Ra / (force * (Ra**2 / Ja + Rb**2 / Jb))
    _, found = run(scene(WHEELS, formulation, 0.05 if formulation == "full" else 4.0, "50 ms"))
    pushed = force * np.minimum(found["time"], rolls)
    a, b = found["bodies/angular_velocity"][:, :, 1].T
    np.testing.assert_allclose(a, -20.0 + pushed * Ra / Ja, atol=1e-8)
    np.testing.assert_allclose(b, pushed * Rb / Jb, atol=1e-8)
    np.testing.assert_allclose(np.abs(found["friction/rate"][:, 0]), np.abs(Ra * a + Rb * b), atol=1e-10)
    if formulation != "full":
        assert 0.2 < rolls < 1.0 and found["friction/state"][-1, 0] == 0.0
        assert np.abs(a[-1]) * (found["time"][-1] - rolls) > 4.0 * np.pi


def test_smooth_friction_of_a_tappet_takes_as_much():
    """Regularised to 1 µm/s it is that of the sliding one."""
    smooth = TAPPET.replace("coefficient: 0.2", "coefficient: 0.2, regularised: 1.0e-6 m/s")
    _, found = run(scene(smooth, "planar", 0.2, "10 ms"))
    slower = 0.2 * 2.0 * G * 0.1 / 0.01
    np.testing.assert_allclose(np.abs(found["joints/speed"][:, 0]), 20.0 - slower * found["time"], atol=1e-8)


@pytest.mark.parametrize("formulation", ["reduced", full("full")])
def test_what_a_straight_wire_bears_slows_its_bead(formulation):
    """Down a wire of 3 : 4, whatever way the bead is turned: s'' = g (sin α - μ cos α)."""
    text = """
curves: {wire: {space_points: [[0, 0, 0], [0.12, 0.16, -0.15], [0.24, 0.32, -0.3]]}}
bodies: {bead: {mass: 0.5, inertia: [1.0e-4, 1.0e-4, 1.0e-4], position: [0.0048, 0.0064, -0.006]}}
joints:
  K: {type: space_slot, bodies: [ground, bead], curve: wire, locations: [[0, 0, 0], [0.0048, 0.0064, -0.006]],
      axis: z, x_axis: x, limits: {displacement: {range: [0, 0.49 m], rigid: true}}}
forces: {rubs: {type: friction, joint: K, coulomb: {coefficient: 0.2}}}
"""
    _, found = run(scene(text, formulation, 0.3, "10 ms"))
    gain = G * (0.6 - 0.2 * 0.8)
    np.testing.assert_allclose(found["joints/coordinate"][:, 0], 0.01 + 0.5 * gain * found["time"] ** 2, atol=1e-12)


def test_what_a_bent_wire_bears_is_its_reaction():
    """The force of friction is μ times the reaction at each sample, and the energy is balanced."""
    _, found = run(
        scene(
            WIRE + "forces: {rubs: {type: friction, joint: K, coulomb: {coefficient: 0.1}}}\n", "reduced", 0.2, "10 ms"
        )
    )
    borne = np.linalg.norm(found["joints/reaction_force"][:, 1], axis=-1)
    np.testing.assert_allclose(np.abs(found["friction/force"][:, 0]), 0.1 * borne, rtol=1e-8)
    assert found.unbalanced < 1e-9


@pytest.mark.parametrize("dry", ["{torque: 1}", "{coefficient: 0.2, radius: 0.1}", "{displacement: {force: 1}}"])
def test_friction_between_profiles_is_a_force(dry):
    with pytest.raises(InputError, match="is where its profiles slide on each other, on no coordinate"):
        read_scene_text(scene(TAPPET.replace("{coefficient: 0.2}", dry)))


# Dry friction along slots and cams, against its closed form.

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
