"""A controller, a rack and a cam as elements: beside closed forms, in the energy account, and in the studies."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mbproj import Mechanism, solve
from mbproj.base.errors import InputError
from mbproj.equations.assembly.assemble import assemble
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.derivatives import second_derivatives, third_derivatives
from mbproj.functions.elements import Element, Force, Row, State
from mbproj.functions.program import COORDINATE, TIME, Instruction, Op, Program, apply, number, variable
from mbproj.functions.standard import Curve
from mbproj.functions.table import CubicTable, periodic
from mbproj.joints.primitives.coupling import Coupling
from mbproj.model.compile.elements import with_elements
from mbproj.model.compile.mechanism import initial_guess
from mbproj.scene.scene import read_scene_text
from mbproj.studies.recommend import recommend
from mbproj.studies.stability import stability
from mbproj.studies.verify.case import Case
from mbproj.studies.verify.checks import CHECKS, _check, verify
from tests.crossed import full
from tests.elements.scenes import (
    FORMULATIONS,
    SELDOM_FULL,
    TWO_SLIDES,
    at,
    brief,
    cam,
    motor,
    pi_controller,
    rack,
    run,
    scene_of,
    spring,
)
from tests.kernel.scenes import needs_kernel

# A controller, a rack and a cam as elements: beside closed forms and equations of their own, in every formulation.


def push(along, value):
    return Force(along, Program(number(value)))


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_controller_drives_a_coordinate_as_its_linear_equations_say(formulation):
    """A slide of 3 kg on level rails with gains P, I and D and a filter: four first-order equations."""
    gains, lag, target = (40.0, 30.0, 12.0), 0.02, 0.25
    law = pi_controller("drive", "rail.displacement", Program(number(target)), gains, lag)
    system, found, _ = run([law], **brief(formulation))
    A = np.array(
        [[0, 1, 0, 0], [-gains[0] / 3, 0, gains[1] / 3, -gains[2] / 3], [-1, 0, 0, 0], [0, 1 / lag, 0, -1 / lag]]
    )
    b = np.array([0, gains[0] * target / 3, target, 0])
    values, vectors = np.linalg.eig(A)
    steady = -np.linalg.solve(A, b)
    weights = np.linalg.solve(vectors, -steady)
    exact = steady + np.real(np.exp(np.outer(found["time"], values)) * weights @ vectors.T)
    assert system.names.states == ("drive.integral", "drive.filtered")
    np.testing.assert_allclose(at(found, "rail.displacement", system.names.coordinates), exact[:, 0], atol=1e-10)
    np.testing.assert_allclose(found["states/value"], exact[:, 2:], atol=1e-10)
    assert np.abs(found["diagnostics/energy_balance"]).max() < 1e-9


@pytest.mark.parametrize("formulation", SELDOM_FULL)
def test_a_rack_moves_under_a_force_as_one_mass_does(formulation):
    """F on the slide moves m + I/r²; the wheel makes turns, and the tooth force turns it."""
    r, F = 0.05, 60.0
    pull = Element("pull", forces=(push("rail.displacement", F),))
    elements = [rack("gear", "pin.angle", "rail.displacement", r), pull]
    system, found, report = run(elements, formulation=formulation)
    t, names = found["time"], system.names.coordinates
    a = F / (3 + 0.1 / r**2)
    np.testing.assert_allclose(at(found, "rail.displacement", names), a * t**2 / 2, atol=1e-9)
    np.testing.assert_allclose(at(found, "pin.angle", names) * r, a * t**2 / 2, atol=1e-9)
    assert at(found, "pin.angle", names)[-1] > 6 * np.pi
    assert report.degrees_of_freedom == 1
    assert np.abs(found["joints/violation"]).max() < 1e-12


HEIGHT = 0.08


def lift(count=0):
    """h (1 - cos φ)/2, or by a periodic table of so many rows, which begin in the middle of a turn."""
    if not count:
        cosine = apply(Op.COS, variable(COORDINATE))
        return Program(apply(Op.MULTIPLY, number(0.5 * HEIGHT), apply(Op.SUBTRACT, number(1.0), cosine)))
    angles = np.linspace(-2.0, -2.0 + 2 * np.pi, count, endpoint=False)
    table = periodic([(float(x), 0.5 * HEIGHT * (1 - np.cos(x))) for x in angles], 2 * np.pi)
    return Program((Instruction(Op.VARIABLE, COORDINATE), Instruction(Op.TABLE, 0.0, table)))


CAM = cam("cam", "pin.angle", "rail.displacement", lift())


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_free_cam_moves_as_its_one_equation_says(formulation):
    """(I + m f'²) φ'' + m f' f'' φ'² + m g f' = 0 with f of the cosine, over two turns; and the energy is kept."""
    own = {"axis": "z", "speed": "speed: 14", "formulation": formulation, "duration": "1", "tolerance": "1e-10"}
    _, found, report = run([CAM], **own)

    def rates(_, y):
        slope, bend = 0.5 * HEIGHT * np.sin(y[0]), 0.5 * HEIGHT * np.cos(y[0])
        return [y[1], -(3 * slope * bend * y[1] ** 2 + 3 * 9.81 * slope) / (0.1 + 3 * slope**2)]

    t = found["time"]
    exact = solve_ivp(rates, (0, t[-1]), [0, 14], "DOP853", t_eval=t, rtol=1e-12, atol=1e-13).y
    angle, way = found["joints/coordinate"].T
    assert angle[-1] > 4 * np.pi
    np.testing.assert_allclose(angle, exact[0], atol=1e-7)
    np.testing.assert_allclose(way, 0.5 * HEIGHT * (1 - np.cos(angle)), atol=1e-12)
    assert np.abs(found["diagnostics/energy_balance"]).max() < 1e-7
    assert np.abs(found["joints/violation"]).max() < 1e-12
    assert np.abs(found["diagnostics/acceleration_violation"]).max() < 1e-8
    assert report.degrees_of_freedom == 1
    assert report.formulation == formulation


@pytest.mark.parametrize("formulation", FORMULATIONS[1:] or FORMULATIONS)
def test_a_cam_by_a_periodic_table_is_near_the_function_that_it_is_of(formulation):
    """The slope of a cubic spline errs with the third power of its spacing, and so does the motion."""
    own = {"axis": "z", "speed": "speed: 14", "formulation": formulation, "duration": "0.5", "tolerance": "1e-8"}
    exact, errors = run([CAM], **own)[1]["joints/coordinate"], []
    for count in (12, 24):
        _, found, _ = run([cam("cam", "pin.angle", "rail.displacement", lift(count))], **own)
        errors.append(np.abs(found["joints/coordinate"] - exact).max())
    assert exact[-1, 0] > 2 * np.pi
    assert 7 < errors[0] / errors[1] < 10


RISE, SPAN = 0.3, np.radians(80.0)


def parabolas(first=0.0, begin=RISE):
    """A lift of h and back from the angle RISE on, by four parabolas and a dwell: accelerations jump at four knots a
    turn. `first`: the slope with which the rise begins, where it has a corner."""
    c = HEIGHT / (2 * SPAN**2)
    rise = (0.0, first, c), (c * SPAN**2, 2 * c * SPAN, -c), (HEIGHT, 0.0, -c), (c * SPAN**2, -2 * c * SPAN, c)
    knots = tuple(begin + SPAN * k for k in range(5))
    pieces = tuple((*piece, 0.0) for piece in (*rise, (0.0, 0.0, 0.0)))
    table = CubicTable(knots, knots, pieces, 2 * np.pi)
    return Program((Instruction(Op.VARIABLE, COORDINATE), Instruction(Op.TABLE, 0.0, table)))


def when(angles, speed):
    """The times at which the free cam of parabolas is at these angles, from 0 on with this speed: ∫ dφ/φ', with φ' by
    the energy, piece by piece."""
    curve, (nodes, weights) = Curve(parabolas()), np.polynomial.legendre.leggauss(40)
    knots = [RISE + SPAN * piece + 2 * np.pi * turn for turn in range(6) for piece in range(5)]

    def took(low, high):
        height, slope, _ = curve(0.5 * (low + high) + 0.5 * (high - low) * nodes)
        slower = np.sqrt((0.1 + 3 * slope**2) / (0.1 * speed**2 - 2 * 3 * 9.81 * height))
        return 0.5 * (high - low) * weights @ slower

    ends = [[0.0, *(knot for knot in knots if knot < angle), angle] for angle in angles]
    return np.array([sum(took(low, high) for low, high in pairwise(each)) for each in ends])


@pytest.mark.parametrize("formulation", SELDOM_FULL)
def test_steps_end_at_the_knots_of_a_cam(formulation):
    """f'' jumps there, and the run is still as near as its tolerance asks for. Steps of one size are split there."""
    own = {"axis": "z", "speed": "speed: 14", "formulation": formulation, "duration": "0.6"}
    element, errors = cam("cam", "pin.angle", "rail.displacement", parabolas()), []
    fine, step = ("1e-9", "0.0025") if formulation == "full" else ("1e-11", "0.00125")
    for options in ({"tolerance": "1e-7"}, {"tolerance": fine}, {"step": step}):
        _, found, report = run([element], **options, **own)
        angle = found["joints/coordinate"][:, 0]
        assert angle[-1] > 2 * np.pi + RISE
        errors.append(np.abs(when(angle, 14.0) - found["time"]).max())
        assert (report.events, report.passed) == (5, "")
        assert np.abs(found["joints/violation"]).max() < 1e-12
    assert errors[0] < 1e-7
    assert errors[1] < float(fine)
    assert errors[2] < 1e-12


@pytest.mark.parametrize("formulation", SELDOM_FULL)
def test_a_function_with_a_smooth_switch_is_located(formulation):
    """φ = 40 max(s - 0.2, 0)³ of a slide that comes with 1 m/s: t = ∫ √(1 + I φ'(s)²/m) ds by the energy. The third
    derivative jumps where the switch is, and a step ends there."""
    lag = Row("lag", {"rail.displacement": 0.0, "pin.angle": 1.0}, "40*max(s - 0.2, 0)**3")
    own = {"slide": 1.0, "formulation": formulation, "duration": "0.5", "tolerance": "1e-11"}
    _, found, report = run([Element("x", rows=(lag,))], **own)
    angle, way = found["joints/coordinate"].T
    nodes, weights = np.polynomial.legendre.leggauss(40)
    s = np.maximum(way[:, None] - 0.2, 0.0) * (0.5 + 0.5 * nodes)
    inside = 0.5 * np.sqrt(1.0 + 0.1 / 3.0 * (120.0 * s**2) ** 2) @ weights
    t = np.minimum(way, 0.2) + np.maximum(way - 0.2, 0.0) * inside
    assert angle[-1] > 0.5
    np.testing.assert_allclose(t, found["time"], atol=1e-10)
    np.testing.assert_allclose(angle, 40.0 * np.maximum(way - 0.2, 0.0) ** 3, atol=1e-12)
    assert report.events == 1


@pytest.mark.parametrize("formulation", SELDOM_FULL)
def test_a_cam_knows_its_own_knots_beside_tables_of_forces(formulation):
    """A force by a table that is 0 where the follower is changes nothing, and has pieces of its own."""
    pieces = *((0.0, 0.0, 0.0, 0.0),) * 3, (0.0, 1.0, 0.0, 0.0)
    table = CubicTable((-np.inf, -2.0, 1.0, 2.0), (-2.0, -2.0, 1.0, 2.0), pieces)
    code = (Instruction(Op.VARIABLE, COORDINATE), Instruction(Op.TABLE, 0.0, table))
    nothing = Element("nothing", forces=(Force("rail.displacement", Program(code)),))
    element = cam("cam", "pin.angle", "rail.displacement", parabolas())
    own = {"axis": "z", "speed": "speed: 14", "formulation": formulation, "duration": "0.3", "tolerance": "1e-9"}
    found = [run(elements, **own)[1]["joints/coordinate"] for elements in ([element], [nothing, element])]
    np.testing.assert_allclose(*found, rtol=0, atol=1e-9)


@needs_kernel
def test_steps_end_where_the_third_derivative_of_a_cam_jumps():
    """At the knots of a spline, once a turn each; and no method keeps its order over them."""
    element = cam("cam", "pin.angle", "rail.displacement", lift(12))
    own = {"axis": "z", "speed": "speed: 14", "duration": "0.5", "tolerance": "1e-8"}
    _, found, report = run([element], **own)
    angles = -2.0 + 2 * np.pi / 12 * np.arange(40)
    last = found["joints/coordinate"][-1, 0]
    assert report.events == np.count_nonzero((angles > 0.0) & (angles < last))


def test_the_formulations_agree_on_a_cam_that_a_controller_drives():
    """A controller on the cam's angle, with a spring on the follower: motions, states and reactions are the same."""
    target = Program(apply(Op.MULTIPLY, number(9.0), variable(TIME)))
    law = pi_controller("drive", "pin.angle", target, (20, 9, 2), 0.01)
    pull = Program(apply(Op.MULTIPLY, number(-800.0), variable(COORDINATE)))
    elements = [law, CAM, Element("spring", forces=(Force("rail.displacement", pull),))]
    own = {"axis": "z", "duration": "0.2", "tolerance": "1e-10"}
    runs = {each: run(elements, formulation=each, **own)[1] for each in FORMULATIONS}
    for path, atol in {"joints/coordinate": 1e-8, "states/value": 1e-7, "joints/reaction_force": 1e-4}.items():
        for found in runs.values():
            np.testing.assert_allclose(found[path][:, :2], runs["full"][path][:, :2], atol=atol, err_msg=path)


APPLYING = ("popm-gpopm", "idempotent", "eliminated", "power", "momentum", "reaction", "closed", "energy")


@needs_kernel
@pytest.mark.parametrize(
    ("element", "also"),
    [
        (CAM, ("kernel-correction", "reduced", "planar", "linear", "order", "turns")),
        full(rack("gear", "pin.angle", "rail.displacement", 0.05), ("kernel-correction", "reduced", "planar", "turns")),
        full(
            pi_controller("drive", "rail.displacement", Program(number(0.2)), (40, 30, 12), 0.02),
            ("reduced", "planar", "linear"),
        ),
    ],
    ids=["cam", "rack", "controller"],
)
def test_the_checks_of_verify_that_know_the_system_alone_pass(element, also):
    """Those of invariance make the mechanism from its scene again, which has no elements."""
    scene = scene_of("z", "speed: 5", duration="0.3", tolerance="1e-9")
    system = with_elements(compile_system(scene), [element])
    case = Case(Mechanism(scene, system, assemble(system, initial_guess(scene, system))))
    found = {name: _check(name, CHECKS[name], case) for name in (*APPLYING, *also)}
    assert {name: check.verdict for name, check in found.items()} == dict.fromkeys(found, "passed")


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("kinds", [("angle", "along"), ("along", "distance"), ("distance", "distance")])
def test_derivatives_of_a_row_with_a_function_are_those_of_its_gradient(kinds):
    """∂g/∂x and its rate along a motion, which linear models take, by the complex step of g."""
    row, random = Coupling(kinds, (0.0, 1.0), 0.0, Curve(lift())), np.random.default_rng(0)
    x, x_dot = random.normal(size=(2, 1, len(row.slots), 3))
    along = row.gradient(x + 1e-100j * x_dot).imag / 1e-100
    np.testing.assert_allclose((second_derivatives(row, x) @ x_dot.ravel())[0, 0], along.ravel(), atol=1e-13)
    np.testing.assert_allclose(row.rate(x, x_dot).ravel(), np.sum(row.gradient(x) * x_dot), atol=1e-14)
    np.testing.assert_allclose(row.curvature(x, x_dot).ravel(), np.sum(along * x_dot), atol=1e-13)
    h = 1e-4
    near = [second_derivatives(row, x + side * h * x_dot) for side in (-1, 1)]
    bend = ((near[1] - near[0]) / (2 * h) @ x_dot.ravel())[0, 0]
    np.testing.assert_allclose(third_derivatives(row, x, x_dot)[0, 0], bend, atol=1e-6)


def test_an_expression_is_the_program_that_it_says():
    gains, lag = (40.0, 30.0, 12.0), 0.02
    of = ("rail.displacement", "rail.displacement_dot", "drive.integral", "drive.filtered")
    said = Element(
        "drive",
        of,
        (
            State("integral", "0.25 - rail_displacement"),
            State("filtered", "(rail_displacement_dot - drive_filtered)/0.02"),
        ),
        (Force(of[0], "40*(0.25 - rail_displacement) + 30*drive_integral - 12*drive_filtered"),),
    )
    law = pi_controller("drive", of[0], Program(number(0.25)), gains, lag)
    by_text, by_code = (run([each], duration="0.5")[1]["states/value"] for each in (said, law))
    np.testing.assert_allclose(by_text, by_code, atol=1e-13)


def _of_length(function):
    return Row("r", {"rail.displacement": 0.0, "pin.angle": 1.0}, function)


EDGE, ONCE = apply(Op.ABS, variable(COORDINATE)), apply(Op.MULTIPLY, variable(COORDINATE), variable(COORDINATE))
WRONG = {
    "element 'x': 'pin.angle': 'pin.angle' cannot be used here": Element(
        "x", ("pin.angle",), (State("a", "pin.angle"),)
    ),
    "element 'x' reads 'pin.angel', which does not exist": Element("x", reads=("pin.angel",)),
    "element 'x' acts on 'rail.angle', which does not exist": Element("x", forces=(push("rail.angle", 1.0),)),
    "the function of row 'x.r' has edges, at s = 0": cam("x", "pin.angle", "rail.displacement", Program(EDGE)),
    "function of row 'x.r' has edges, at s = 0.3": cam("x", "pin.angle", "rail.displacement", parabolas(first=0.01)),
    "the function of row 'x.r' has edges, at s = 0.02": Element("x", rows=(_of_length("max(s - 0.02, 0)"),)),
    "the function of row 'x.r' has edges, at s = -300": Element("x", rows=(_of_length("abs(s + 300)"),)),
    "the function of row 'x.r' changes with a turn": cam("x", "pin.angle", "rail.displacement", Program(ONCE)),
    "the function of row 'x.r' names more": cam("x", "pin.angle", "rail.displacement", Program(variable(TIME))),
}


@pytest.mark.parametrize("said", WRONG)
def test_what_cannot_be_is_refused_with_words(said):
    element = WRONG[said]
    element = replace(element, rows=tuple(replace(row, name="r") for row in element.rows))
    with pytest.raises(InputError, match=said):
        with_elements(compile_system(scene_of()), [element])


@pytest.mark.parametrize(
    "function", ["0.05*max(sin(s), 0)**3", "0.01*s**2*sign(s)*max(s - 1, 0)**3 + max(s, 0)**2", "abs(s)**3", "sqrt(s)"]
)
def test_functions_without_edges_are_rows(function):
    of = {"pin.angle": 0.0, "rail.displacement": 1.0} if "sin" in function else None
    row = Row("r", of, function) if of else _of_length(function)
    assert with_elements(compile_system(scene_of()), [Element("x", rows=(row,))]).couplings.size == 1


def test_a_knot_may_be_where_a_turn_ends():
    for begin in (np.pi, np.pi - SPAN, -np.pi):
        assert Curve(parabolas(begin=begin)).repeats(2 * np.pi, 0.0)
    assert not Curve(Program(apply(Op.POWER_OF, number(2.0), variable(COORDINATE)))).repeats(2 * np.pi, 0.0)


def test_periodic_splines_repeat_and_are_smooth():
    rows = [(0.3, 1.0), (1.1, -0.5), (2.9, 0.7), (4.0, 0.2)]
    f = Curve(Program((Instruction(Op.VARIABLE, COORDINATE), Instruction(Op.TABLE, 0.0, periodic(rows, 5.0)))))
    x, y = np.array(rows).T
    inside = x - 5.0 * np.round(x / 5.0)
    np.testing.assert_allclose(f(inside)[0], y, atol=1e-15)
    ends = np.array([-2.5, 2.5])
    for each in f(ends):
        np.testing.assert_allclose(each[0], each[1], atol=1e-12)
    for knot in inside:
        np.testing.assert_allclose(*np.array(f(np.array([knot - 1e-12, knot]))).T, atol=1e-9)


# What elements keep and lose, in the energy account of a run.


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_spring_that_is_an_element_does_no_work(formulation):
    """A slide of 3 kg that swings with 2 m/s at the start: T + V is 6 J all the time."""
    system, found, report = run([spring("coil", "rail.displacement", 48.0)], slide=2.0, **brief(formulation))
    t, s = found["time"], at(found, "rail.displacement", system.names.coordinates)
    np.testing.assert_allclose(s, 0.5 * np.sin(4.0 * t), atol=1e-9)
    weight = 3 * 9.81 * 0.3
    np.testing.assert_allclose(found["diagnostics/potential_energy"], weight + 24.0 * s**2, atol=1e-9)
    np.testing.assert_allclose(found["diagnostics/total_energy"], weight + 6.0, atol=1e-8)
    np.testing.assert_allclose(found["diagnostics/work"], 0.0, atol=1e-8)
    assert abs(report.energy.work) < 1e-8
    assert np.abs(found["diagnostics/energy_balance"]).max() < 1e-8


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_the_account_of_a_motor_is_electric(formulation):
    """J ω = k ∫i, so that W = ∫U i = U J ω/k; of it the winding keeps ½ L i² and loses ∫R i²."""
    U, R, L, k, J = 12.0, 0.8, 0.05, 0.3, 0.1
    system, found, report = run([motor("motor", "pin.angle", U, (R, L), k)], **brief(formulation))
    rate = found["joints/speed"][:, system.names.coordinates.index("pin.angle")]
    current, heat = found["states/value"].T
    exact = np.array([[0.0, k / J], [-k / L, -R / L]])
    values, vectors = np.linalg.eig(exact)
    steady = np.array([U / k, 0.0])
    moved = np.real(np.exp(np.outer(found["time"], values)) * np.linalg.solve(vectors, -steady) @ vectors.T)
    np.testing.assert_allclose(np.column_stack([rate, current]), steady + moved, atol=1e-7)
    np.testing.assert_allclose(found["diagnostics/work"], U * J * rate / k, atol=1e-7)
    np.testing.assert_allclose(found["diagnostics/dissipation"], heat, atol=1e-12)
    kept = 3 * 9.81 * 0.3 + 0.5 * J * rate**2 + 0.5 * L * current**2
    np.testing.assert_allclose(found["diagnostics/total_energy"], kept, atol=1e-10)
    assert heat[-1] > 1.0
    assert report.energy.dissipation == pytest.approx(heat[-1], abs=1e-12)
    assert np.abs(found["diagnostics/energy_balance"]).max() < 1e-7


# Scenes with elements in the studies: checks, searches, maps; and what is kept tells them apart.

LIFT = Row("lift", {"pin.angle": 0.0, "rail.displacement": 1.0}, "0.04*(1 - cos(s))")
CAM_SCENE = Element("cam", rows=(LIFT,))
LENGTHS = {"left": ((0.0, 0.0, 0.0), "one"), "right": ("two", (1.0, 0.0, 0.0))}
ROPE = Element("rope", lengths=LENGTHS, rows=(Row("length", {"rope.left": 1.0, "rope.right": 1.0}, constant=2.5),))


def cam_scene():
    return replace(scene_of("z", "speed: 14", duration=0.2, tolerance=1e-8, output_step=0.02), elements=(CAM_SCENE,))


def rope_scene():
    text = TWO_SLIDES.replace("GRAVITY", "-9.81").replace("FORCES", "")
    return replace(read_scene_text(text), elements=(ROPE,))


@needs_kernel
@pytest.mark.parametrize(
    ("scene", "left_out"),
    [(cam_scene, {"units"}), full(rope_scene, {"units", "rotation", "translation"})],
    ids=["cam", "rope"],
)
def test_verify_looks_at_elements_from_all_sides(scene, left_out):
    found = {check.name: check for check in verify(scene()).checks}
    assert [name for name, check in found.items() if check.verdict == "failed"] == []
    of_elements = {name for name, check in found.items() if "element" in check.remark}
    assert of_elements == left_out
    moved = {"renumbering", "energy", "closed", "power", "reduced", "turns"} | ({"rotation", "translation"} - left_out)
    assert {found[name].verdict for name in moved} == {"passed"}


@needs_kernel
def test_a_study_runs_what_the_elements_do():
    """The slide is where the cam lifts it, with every setting that is found."""
    scene = cam_scene()
    found = recommend(scene, 1e-7, timed=False)
    assert found.reached
    run = solve(scene, found.setting, np.linspace(0.0, 0.2, 11))
    assert run.failure is None
    slide = run.body_position[:, 1, 2] - 0.3
    angle = 2.0 * np.arctan2(run.body_orientation[:, 0, 2], run.body_orientation[:, 0, 0])
    np.testing.assert_allclose(slide, 0.04 * (1.0 - np.cos(angle)), atol=1e-13)
    assert slide.max() > 0.07


@needs_kernel
def test_what_is_kept_of_a_study_tells_elements_apart():
    scene = scene_of("z")
    higher = replace(CAM_SCENE, rows=(replace(LIFT, function="0.05*(1 - cos(s))"),))
    scenes = [scene, *(replace(scene, elements=(element,)) for element in (CAM_SCENE, higher))]
    assert len({repr(Mechanism.of(each).identity) for each in scenes}) == 3


@needs_kernel
def test_the_unit_of_length_cannot_be_varied():
    with pytest.raises(InputError, match="'cam' is data without units"):
        stability(cam_scene(), "length-scale", projections=("gpopm",), points=3, processes=1)


@needs_kernel
def test_wrong_elements_of_a_scene_are_named():
    with pytest.raises(InputError, match=r"element 'x' reads 'pin\.angel', which does not exist"):
        compile_system(replace(scene_of(), elements=(Element("x", reads=("pin.angel",)),)))
