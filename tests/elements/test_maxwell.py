"""A spring and a damper in series: its motion, its energy, and the same mechanism in other words."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import assemble, compile_system, equilibrium, initial_guess, read_scene_text, settings_to_run, simulate
from mbproj.base.errors import InputError
from mbproj.equations.derivatives import linear_equations
from mbproj.linear.equilibrium import balance
from mbproj.linear.equilibrium.solve import NoEquilibrium
from mbproj.studies.variants import RigidMotion, rescaled, with_damping, with_stiffness
from tests.crossed import crossed
from tests.elements.scenes import FORMULATIONS
from tests.support import Recorder

SCENE = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 1, integrator: dop853, tolerance: 1e-10, output_step: 0.05, formulation: FORMULATION}
bodies:
  slide: {mass: 3, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0.3]}
  wheel: {mass: 2, inertia: [0.2, 0.3, 0.2], position: [1, 0, 0]}
joints:
  rail:
    {type: prismatic, bodies: [ground, slide], location: [0, 0, 0.3], axis: [0, 0, 1], speed: 2}
  pin: {type: revolute, bodies: [ground, wheel], location: [1, 0, 0], axis: [0, 1, 0], speed: 3}
forces:
  M-1: {type: maxwell, PLACE, stiffness: 400, damping: 60 N*s/m}
  T: {type: torsion_maxwell, joint: pin, stiffness: 40, damping: 2}
"""
ON_PLANE = """
mbproj: 1
gravity: [0.4, 0, -9.81]
simulation: {duration: 1, step: 0.01}
bodies:
  body: {mass: 2, inertia: [0.3, 0.4, 0.5], position: [0.3, 0, 0.1]}
  next: {mass: 2, inertia: [0.3, 0.4, 0.5], position: [0.3, 0, 0.1]}
joints:
  B: {type: spherical, bodies: [ground, body], location: [0, 0, 0.5]}
  J: {type: point_in_plane, bodies: [body, next], location: [0, 0, 0], axis: [0, 1, 0]}
forces: {E: {type: maxwell, points: {ground: [0, 0, 3], next: [0.3, 0, 0.1]}, stiffness: 2, damping: 2}}
"""
PLACES = {
    "joint": "joint: rail",
    "points": "points: {ground: [0, 0, -5], slide: [0, 0, 0.3]}",
    "local": "bodies: [ground, slide], locations: {ground: [0, 0, -5], slide: [0, 0, 0.1]}",
}


def scene(place: str = "joint", formulation: str = "auto"):
    return read_scene_text(SCENE.replace("PLACE", PLACES[place]).replace("FORMULATION", formulation))


def ran(of):
    system, found = compile_system(of), Recorder()
    report = simulate(system, assemble(system, initial_guess(of, system)), settings_to_run(of), found)
    return system, found, report


def exact(t, inertia: float, stiffness: float, damping: float, speed: float):
    """s, s' and the stretch e at times t: m s'' = -k e, e' = s' - k e/c."""
    by = np.array([[0.0, 1, 0], [0, 0, -stiffness / inertia], [0, 1, -stiffness / damping]])
    values, vectors = np.linalg.eig(by)
    return np.real(np.exp(np.outer(t, values)) * np.linalg.solve(vectors, [0.0, speed, 0.0]) @ vectors.T).T


@pytest.mark.full_where(formulation="full")
@crossed("formulation, place", FORMULATIONS, PLACES, dear=["full"])
def test_it_moves_and_loses_as_its_equations_say(place, formulation):
    system, found, report = ran(scene(place, formulation))
    t, names = found["time"], system.names
    s, speed, stretch = exact(t, 3.0, 400.0, 60.0, 2.0)
    turn, rate, twist = exact(t, 0.3, 40.0, 2.0, 3.0)
    of = names.coordinates.index
    np.testing.assert_allclose(found["joints/coordinate"][:, of("rail.displacement")], s, atol=1e-8)
    np.testing.assert_allclose(found["joints/coordinate"][:, of("pin.angle")], turn, atol=1e-8)
    assert names.forces == ("M-1", "T")
    np.testing.assert_allclose(found["forces/force"], np.column_stack([-400.0 * stretch, -40.0 * twist]), atol=1e-5)
    assert (names.states, names.state_units) == (("M-1.stretch", "T.stretch"), ("m", "rad"))
    np.testing.assert_allclose(found["states/value"], np.column_stack([stretch, twist]), atol=1e-8)
    kept = 1.5 * speed**2 + 0.15 * rate**2 + 200.0 * stretch**2 + 20.0 * twist**2
    np.testing.assert_allclose(found["diagnostics/total_energy"], kept, atol=1e-7)
    np.testing.assert_allclose(found["diagnostics/dissipation"], kept[0] - kept, atol=1e-7)
    assert abs(report.energy.work) < 1e-12


def test_in_another_unit_of_length_it_moves_alike():
    system, found, _ = ran(scene("points"))
    _, larger, _ = ran(rescaled(scene("points"), 1000.0))
    scale = np.array([1000.0 if name != "pin.angle" else 1.0 for name in system.names.coordinates])
    np.testing.assert_allclose(larger["joints/coordinate"], scale * found["joints/coordinate"], rtol=1e-7, atol=1e-6)
    np.testing.assert_allclose(larger["forces/force"], [1e3, 1e6] * found["forces/force"], rtol=1e-5, atol=1.0)
    assert "M-1.length" in system.names.coordinates


def test_its_points_move_with_the_scene():
    turn = RigidMotion(np.array([[0.0, -1, 0], [0, 0, -1], [1, 0, 0]]), np.array([1.0, 2.0, 3.0]))
    _, found, _ = ran(scene("points"))
    _, moved, _ = ran(turn.scene(scene("points")))
    np.testing.assert_allclose(moved["forces/force"], found["forces/force"], atol=1e-6)


def test_studies_vary_what_is_a_stiffness_or_a_damping_by_its_unit():
    stiffer, damped = with_stiffness(scene(), 3.0), with_damping(scene(), 5.0)
    assert [force.element.values for force in stiffer.forces] == [
        {"stiffness": 1200.0, "damping": 60.0},
        {"stiffness": 120.0, "damping": 2.0},
    ]
    assert [force.element.values["damping"] for force in damped.forces] == [300.0, 10.0]


def test_a_search_without_an_end_stops_early(monkeypatch):
    """A body that slips along a plane, beside a Maxwell element that pulls only while it moves: nothing holds it.
    Newton's steps without damping would go 1e13 lengths there, and gain nothing in 300 of them."""
    counted = []
    monkeypatch.setattr(balance, "linear_equations", lambda *a: counted.append(a) or linear_equations(*a))
    with pytest.raises(NoEquilibrium, match=r"nothing balances 19\..* N and .* on 'next'"):
        equilibrium(read_scene_text(ON_PLANE))
    assert 10 < len(counted) < 60


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("stiffness: 400", "stiffness: 400 N*m", "'stiffness' is in N/m, this is a torque, in N\\*m"),
        (", stiffness: 400", "", "missing key 'stiffness'"),
        ("joint: rail", "joint: pin", "joint 'pin' is revolute and has no displacement to act on"),
        ("joint: rail,", "", "missing key 'joint', 'points' or 'bodies'"),
        (
            "joint: rail",
            "joint: rail, locations: [[0, 0, 1], [0, 0, 0]]",
            "'joint' and 'locations' cannot both be given",
        ),
    ],
)
def test_what_is_wrong_is_said(old, new, message):
    text = SCENE.replace("PLACE", PLACES["joint"]).replace("FORMULATION", "auto")
    with pytest.raises(InputError, match=message):
        read_scene_text(text.replace(old, new, 1))
