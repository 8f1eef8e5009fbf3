"""`verify`: every check holds on the shipped mechanisms, and each notices what it is there to notice."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg

from mbproj import read_scene, read_scene_text
from mbproj.base.errors import SimulationError
from mbproj.commands.verify import lines
from mbproj.equations import of_motion as equations
from mbproj.equations import turning
from mbproj.equations.constraints import tangent_jacobian
from mbproj.motion.projection import Gpopm, Mmopm, Popm
from mbproj.motion.steppers.tableau import load_tableau
from mbproj.scene.records import BodyForce
from mbproj.studies.measure.solve import Mechanism
from mbproj.studies.variants import RigidMotion, rescaled
from mbproj.studies.verify import case as runs
from mbproj.studies.verify import equations as terms
from mbproj.studies.verify import invariance
from mbproj.studies.verify import motion as accelerations
from mbproj.studies.verify import motion as balance
from mbproj.studies.verify.case import Case, Finding
from mbproj.studies.verify.checks import CHECKS, verify
from mbproj.studies.verify.equations import Rounded, solve
from mbproj.studies.verify.invariance import renumbered
from tests.crossed import some
from tests.kernel.scenes import needs_kernel
from tests.support import MECHANISMS, ROOT, random_chain

SLIDER_CRANK = ROOT / "mechanisms" / "spatial_slider_crank.yaml"


@pytest.mark.parametrize("path", some(MECHANISMS, 14, 3), ids=lambda path: path.stem)
def test_everything_holds_on_the_shipped_mechanisms(path):
    found = verify(read_scene(path))
    assert not found.of("failed")
    assert [check.name for check in found.checks] == list(CHECKS)
    assert len(found.of("passed")) >= 10
    for check in found.of("does not apply"):
        assert check.remark
    for check in found.of("passed"):
        assert np.isfinite(check.measured)
    assert f"{len(found.of('passed'))} hold" in "\n".join(lines(found))


def case(path=SLIDER_CRANK) -> Case:
    return Case(Mechanism.of(read_scene(path)))


def outcome(name: str, of: Case | None = None) -> Finding:
    found = CHECKS[name].run(of or case())
    assert isinstance(found, Finding), found
    return found


@needs_kernel
@pytest.mark.parametrize("name", ["massless_coupler", "split_coupler"])
@pytest.mark.parametrize("check", ["kernel-correction", "reduced"])
def test_the_kernel_is_checked_on_bodies_without_definite_inertia(name, check):
    """A run takes them in the reduced formulation, so its checks apply."""
    found = outcome(check, case(ROOT / "mechanisms" / f"{name}.yaml"))
    assert found.measured <= found.allowed


def off(method, part=1e-9):
    """A method whose corrections are wrong by a part of them."""
    right = method.correction
    return lambda self, M, C_q, violation: (1.0 + part) * right(self, M, C_q, violation)


def tilted(method, part=1e-3):
    """A method that corrects all of the violation, but not by the shortest way."""
    right = method.correction

    def correction(self, M, C_q, violation):
        change, random = right(self, M, C_q, violation), np.random.default_rng(3).normal(size=len(M))
        aside = random - np.linalg.lstsq(C_q, C_q @ random, rcond=None)[0]
        return change + part * np.abs(change).max() * aside

    return correction


def pushed(system, pose, twist):
    """Forces that are off in the ninth digit."""
    return (1.0 + 1e-9) * equations.generalised_force(system, pose, twist)


def less_on_the_ground(bound, pose):
    """Rows that pull less at the ground than at the bodies."""
    return tangent_jacobian(bound, pose) * np.append(np.ones(len(pose.position) - 1), 0.9)[:, None]


def heavier(scene):
    """One body a millionth heavier."""
    first, *others = scene.bodies
    return replace(scene, bodies=(replace(first, mass=first.mass * (1.0 + 1e-6)), *others))


@pytest.mark.parametrize(
    ("name", "target", "attribute", "wrong"),
    [
        ("popm-gpopm", Popm, "correction", off(Popm)),
        ("alpha", Mmopm, "correction", off(Mmopm, 1e-2)),
        ("idempotent", Gpopm, "correction", off(Gpopm, -1e-4)),
        ("orthogonal", Gpopm, "correction", tilted(Gpopm)),
        ("kernel-correction", Gpopm, "correction", off(Gpopm)),
        (
            "eliminated",
            accelerations,
            "solve_eliminated",
            lambda *terms: [(1.0 + 1e-9) * part for part in equations.solve_eliminated(*terms)],
        ),
        ("power", balance, "_spun", lambda J, omega: 1.001 * np.einsum("nij,nj->ni", J, omega)),
        ("momentum", balance, "cross", lambda a, b: 1.001 * np.cross(a, b)),
        ("rotation", RigidMotion, "_direction", lambda self, given: given),
        ("translation", RigidMotion, "_point", lambda self, given: given),
        ("reduced", terms, "generalised_force", pushed),
        ("reaction", balance, "tangent_jacobian", less_on_the_ground),
        ("renumbering", invariance, "renumbered", lambda scene: heavier(renumbered(scene))),
    ],
)
def test_each_check_notices_what_is_wrong(monkeypatch, name, target, attribute, wrong):
    assert outcome(name).passed
    monkeypatch.setattr(target, attribute, wrong)
    assert not outcome(name).passed


def test_the_planar_solve_is_held_against_the_full_one(monkeypatch):
    bars = ROOT / "mechanisms" / "five_bar.yaml"
    assert outcome("planar", case(bars)).passed
    monkeypatch.setattr(terms, "generalised_force", pushed)
    assert not outcome("planar", case(bars)).passed


def test_a_unit_that_is_not_changed_everywhere_is_noticed(monkeypatch):
    bars = case(ROOT / "mechanisms" / "five_bar.yaml")
    assert outcome("units", bars).passed
    assert outcome("units", bars).remark == "gopm's correction changes by 58 %"

    def but_for_gravity(scene, k):
        return replace(rescaled(scene, k), gravity=scene.gravity)

    monkeypatch.setattr(invariance, "rescaled", but_for_gravity)
    assert not outcome("units", bars).passed


@pytest.mark.parametrize("name", ["order", "energy"])
def test_a_wrong_coefficient_of_the_tableau_is_noticed(monkeypatch, name):
    """One sixth more in a single coefficient leaves the classical method of order 1."""
    from mbproj.motion.formulations import compiled

    right = load_tableau("rk4")
    wrong = replace(right, b=right.b + np.array([1.0, -1.0, 0.0, 0.0]) / 36.0)
    assert outcome(name).passed
    monkeypatch.setattr(compiled, "tableau_of", lambda method: wrong)
    found = outcome(name)
    assert not found.passed
    assert found.measured == pytest.approx(1.0, abs=0.35)


def test_bounds_hold_what_round_off_does():
    """Pascal matrices, whose conditions go from 7e2 to 2e13, with a right-hand side and a solution in whole numbers:
    the error is below the bound, and the bound within the condition times the square of the size."""
    for size in range(4, 14, 3):
        A = scipy.linalg.pascal(size).astype(float)
        found = solve(Rounded.exact(A), Rounded.exact(A @ np.ones(size)))
        assert np.all(np.abs(found.value - 1.0) <= found.error)
        assert found.error.max() <= size**2 * np.finfo(float).eps * np.linalg.cond(A)


def test_functions_of_forces_are_moved_and_rescaled_with_the_scene():
    """A chain with a force of given components, a spring with a law and a motion: the same motion, turned and in
    millimetres."""
    text = (ROOT / "mechanisms" / "double_pendulum.yaml").read_text()
    assert "forces:" not in text
    text += (
        "forces:\n"
        "  wind: {type: force, body: inner, force: [sin(3*t) + 1, 0.3*t, 2]}\n"
        "  hinge: {type: torsion_spring_damper, joint: A, torque: -2*angle**3 - 0.1*angle_dot}\n"
    )
    names = [body.name for body in read_scene_text(text.split("forces:")[0]).bodies]
    scene = read_scene_text(text.replace("body: inner", f"body: {names[0]}"))
    assert isinstance(scene.forces[0], BodyForce)
    found = verify(scene)
    for name in ("units", "rotation", "translation", "renumbering", "momentum", "power"):
        check = next(check for check in found.checks if check.name == name)
        assert check.verdict == "passed", (name, check)


@pytest.mark.full
def test_mechanisms_of_a_thousand_kilometres_and_of_a_micrometre():
    """Their numbers are held against their own round-off. In millimetres GOPM sums rows of 1e9 and of 1."""
    bars = read_scene(ROOT / "mechanisms" / "five_bar.yaml")
    large, small = verify(rescaled(bars, 1e6)), verify(rescaled(bars, 1e-6))
    assert len(large.of("passed")) == len(small.of("passed")) == len(CHECKS) - 1  # no gears turn
    (units,) = (check for check in large.checks if check.name == "units")
    assert units.remark == "gopm has no correction there: C_qC_qᵀ is singular to working precision"


@pytest.mark.full
def test_chains_of_every_joint_verify():
    kinds = ["revolute", "universal", "prismatic", "cylindrical", "spherical", "screw", "planar", "distance", "fixed"]
    found = verify(random_chain(2, kinds))
    assert [check.name for check in found.of("failed")] == []


@pytest.mark.full
def test_without_the_kernel_what_needs_it_does_not_apply(monkeypatch):
    from mbproj.motion.formulations import choice as formulation
    from mbproj.studies.verify import case as cases

    for module in (formulation, cases):
        monkeypatch.setattr(module, "core", lambda: None)
    monkeypatch.setattr(runs, "FEWER", 5)
    found = verify(read_scene(ROOT / "mechanisms" / "physical_pendulum.yaml"))
    reasons = {check.name: check.remark for check in found.of("does not apply")}
    assert reasons["reduced"] == reasons["kernel-correction"] == "there is no compiled kernel"
    assert found.formulation == "full"
    assert found.holds


def test_a_structure_that_cannot_move_is_no_failure():
    from tests.studies.scenes import PENDULUM

    pin = "  pin2: {type: revolute, bodies: [ground, bar], location: [1, 0, 0], axis: [0, 1, 0]}\nmarkers:"
    found = {check.name: check for check in verify(read_scene_text(PENDULUM.replace("markers:", pin))).checks}
    assert [name for name, check in found.items() if check.verdict == "failed"] == []
    assert found["energy"].remark == "nothing moves, and no energy changes"
    assert found["planar"].remark in (
        "both results are nothing but round-off",
        "nothing moves: all that is compared is zero",
    )


@pytest.mark.full
def test_an_order_is_seen_where_steps_pass_over_no_edge_and_else_the_edge_is_named():
    """The check's short run of a pendulum does not reach a stop at 2 rad, and ends steps at a jump in time and at those
    of the sign of a fast function of the angle."""
    from tests.studies.scenes import PENDULUM

    def order(torque: str):
        law = f"forces:\n  stop: {{type: torsion_spring_damper, joint: pin, torque: '{torque}'}}\n"
        return {check.name: check for check in verify(read_scene_text(PENDULUM + law)).checks}["order"]

    assert order("-9*max(0, angle - 2) + sign(t - 0.01)").verdict == "passed"
    assert order("-sign(angle)").remark.endswith(
        "('sign' in '-sign(angle)', at the start)".replace("('", "(force 'stop': '")
    )
    assert order("-sign(sin(500*angle + 0.1))").verdict == "passed"


#: A table on links without mass, a pantograph's lower half, falls onto a soft stop.
PANTOGRAPH = """\
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {a: 0.3 m, tilt: 35 deg, h: a*sin(tilt), w: a*cos(tilt)}
simulation: {duration: 1 s, step: 0.5 ms, integrator: rk4}
bodies:
  one: {mass: 0, inertia: [0, 0, 0], position: [w/2, 0, h/2]}
  other: {mass: 0, inertia: [0, 0, 0], position: [w/2, 0, h/2]}
  table: {mass: 5 kg, inertia: [0.1, 0.1, 0.1], position: [w/2, 0, h]}
joints:
  foot: {type: revolute, bodies: [ground, one], location: [0, 0, 0], axis: [0, 1, 0]}
  cross: {type: revolute, bodies: [one, other], location: [w/2, 0, h/2], axis: [0, 1, 0]}
  slot: {type: point_on_line, bodies: [ground, other], location: [w, 0, 0], axis: [1, 0, 0]}
  top: {type: revolute, bodies: [other, table], location: [0, 0, h], axis: [0, 1, 0]}
  top_slot: {type: point_on_line, bodies: [table, one], location: [w, 0, h], axis: [1, 0, 0]}
  guide: {type: prismatic, bodies: [ground, table], location: [w/2, 0, h], axis: [0, 0, 1],
    limits: {displacement: {range: [-0.05, null], stiffness: 2e4, damping: 50}}}
"""


@pytest.mark.full
def test_a_soft_stop_that_makes_its_own_steps_is_no_failed_order():
    found = verify(read_scene_text(PANTOGRAPH))
    assert not found.of("failed")
    (order,) = (check for check in found.checks if check.name == "order")
    assert "pass over edges of laws" in order.remark or "has steps of its own" in order.remark


#: A valve spool and a lever, with dry friction, that are pushed to and fro between their limits.
SPOOL = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 3, integrator: dop853, tolerance: 1.0e-9, output_step: 0.01}
bodies:
  spool: {mass: 0.4, inertia: [1e-4, 2e-4, 2e-4], position: [0, 0, 0]}
  lever: {mass: 1, inertia: [1e-3, 0.02, 0.02], position: [0.2, 0, 0.3]}
joints:
  bore: {type: prismatic, bodies: [ground, spool], location: [0, 0, 0], axis: [1, 0, 0],
    limits: {displacement: {range: [-8 mm, 8 mm], rigid: true, restitution: 0.3}}}
  pin: {type: revolute, bodies: [ground, lever], location: [0, 0, 0.3], axis: [0, 1, 0],
    limits: {angle: {range: [-20 deg, 20 deg], rigid: true, restitution: 0.4}}}
forces:
  seal: {type: friction, joint: bore, coulomb: {coefficient: 0.3, static: 0.4}}
  rub: {type: friction, joint: pin, coulomb: {torque: 0.05, static: 0.08}}
  solenoid: {type: linear_spring_damper, joint: bore, force: "6 * sin(7 * t)"}
  hold: {type: torsion_spring_damper, joint: pin, stiffness: 4, damping: 0.02, free_angle: 10 deg}
"""


@pytest.mark.full
@needs_kernel
def test_runs_whose_steps_are_those_of_events_tell_no_order():
    """A step longer than the time between two events does not become shorter with the step."""
    found = verify(read_scene_text(SPOOL))
    assert not found.of("failed")
    energy = next(check for check in found.checks if check.name == "energy")
    assert energy.verdict == "passed" and energy.measured < 1e-14


FLYWHEEL = """\
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 0.5, step: 2 ms, integrator: radau5}
bodies: {a: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0], angular_velocity: [0, 0, 20]}}
joints: {A: {type: revolute, bodies: [ground, a], location: [0, 0, 0], axis: [0, 0, 1]}}
forces: {push: {type: torque, body: a, torque: [0, 0, 3], axes: global}}
"""


def test_the_order_is_seen_on_every_motion_of_what_only_turns():
    """No point of it moves: its orientation tells. From its own start it speeds up evenly."""
    keys = {"formulation": "reduced"}
    motions = Case(Mechanism.of(read_scene_text(FLYWHEEL, simulation=keys))).motions
    assert motions[0].name == "from the scene's own start"
    for motion in motions:
        order = motion.runs.order(motion.runs.errors)
        assert order is not None and order.value > 4.5, motion.name


def test_where_steps_are_split_for_a_short_move_no_order_is_claimed():
    short = FLYWHEEL.replace("[0, 0, 3]", "[0, 0, 9*exp(-((t - 0.03)/1e-5)**2)]")
    found = {check.name: check for check in verify(read_scene_text(short)).checks}["order"]
    assert found.verdict == "does not apply" and "force 'push'" in found.remark


GEARS = """\
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 0.5, step: 10 ms, integrator: rk4, formulation: full, kinematic: false}
bodies:
  wheel: {mass: 1, inertia: [0.01, 0.01, 0.02], position: [0, 0, 0]}
  pinion: {mass: 0.5, inertia: [0.001, 0.001, 0.001], position: [0.1, 0, 0]}
joints:
  A: {type: revolute, bodies: [ground, wheel], location: [0, 0, 0], axis: [0, 0, 1]}
  B: {type: revolute, bodies: [ground, pinion], location: [0.1, 0, 0], axis: [1, 0, 0]}
  G: {type: gear, joints: [A, B], teeth: [60, 20]}
motions:
  m: {joint: A, angle: {constant_speed: 1500 rpm}}
"""


def test_slipped_teeth_are_seen(monkeypatch):
    """Rows of gears to the nearest tooth: joints are closed after every step, and the pinion lags behind. The count of
    its turns notices, and the step is refused."""
    gears = Case(Mechanism.of(read_scene_text(GEARS)))
    assert outcome("turns", gears).measured <= 1e-9
    monkeypatch.setattr(turning, "to_the_tooth", lambda system, pose, teeth, rows: rows)
    with pytest.raises(SimulationError, match="the step is too long to tell its turns"):
        outcome("turns", gears)


@pytest.mark.full
def test_steps_that_cannot_tell_the_teeth_fail_the_check():
    free = GEARS[: GEARS.index("motions:")].replace("axis: [0, 0, 1]}", "axis: [0, 0, 1], speed: 2000 rpm}")
    found = {check.name: check for check in verify(read_scene_text(free)).checks}
    assert found["turns"].verdict == "failed"
    assert "the step is too long to tell its turns" in found["turns"].remark


@pytest.mark.parametrize("name", some(["quarter_car", "governor"], 3))
def test_the_energy_of_implicit_steps_converges_down_to_round_off(name):
    """What Newton's method leaves of a stage is less than the energy of stiff springs shows."""
    scene = read_scene(ROOT / "mechanisms" / f"{name}.yaml", {}, {"integrator": "esdirk4"})
    found = outcome("energy", Case(Mechanism.of(scene)))
    assert found.passed
    assert found.measured == pytest.approx(4.0, abs=0.2)


def test_a_scene_none_of_whose_runs_comes_to_its_end_fails_by_name():
    found = {
        check.name: check
        for check in verify(
            read_scene_text("""
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 1 s, step: 0.01}
bodies: {mass: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}}
joints: {rail: {type: prismatic, bodies: [ground, mass], location: [0, 0, 0], axis: [1, 0, 0]}}
forces: {push: {type: linear_spring_damper, joint: rail, force: sqrt(1e-6 - t)}}
""")
        ).of("failed")
    }
    assert found.keys() == {"order", "energy", "closed"}
    assert all("the run stops: " in check.remark and "force 'push'" in check.remark for check in found.values())


# The order that `verify` sees in errors: through the next power of the step, and never below what they show.


@pytest.mark.parametrize("order", [1, 4, 8])
def test_an_order_is_seen_through_the_next_power_of_the_step(order):
    """Steps that begin coarse show 3 less at first, as a bicycle does."""
    steps = np.array(runs.STEPS[:10], dtype=float)
    errors = 2.0 * steps**-order / (1.0 + 4.0 / steps) ** 3
    assert -np.diff(np.log2(errors))[0] / np.diff(np.log2(steps))[0] < order - 1.5
    found = runs.order_of(steps[-6:], errors[-6:])
    assert found is not None and abs(found.value - order) < 0.3


def test_an_order_is_not_bent_below_what_is_seen():
    """The dopri5 of locomotive.yaml: coarse steps show more than 5, and a bent line would fall to 4.3."""
    errors = np.array([1.14e-08, 2.1e-09, 2.31e-10, 5.34e-11, 7.59e-12, 1.96e-12])
    found = runs.order_of(np.array(runs.STEPS[1:7]), errors)
    assert found is not None and found.value == pytest.approx(5.16, abs=0.01)


#: A puck on an inclined plane, with inertia along a direction in the plane that the scene leaves to the model.
ON_A_PLANE = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 0.2 s, step: 1 ms}
bodies:
  puck: {mass: 1 kg, inertia: [0.01, 0.02, 0.03], position: [0.1, 0.2, 0.3], velocity: [0.3, 0.2, 0.1]}
joints:
  face:
    type: point_in_plane
    bodies: [ground, puck]
    location: [0.1, 0.25, 0.3]
    axis: [0.2, 1, 0.3]
    reflected_inertia: {displacement_y: 0.7 kg}
"""


def test_a_direction_that_the_model_chooses_turns_with_the_scene():
    checked = outcome("rotation", Case(Mechanism.of(read_scene_text(ON_A_PLANE))))
    assert checked.measured <= 1e-13
