"""What elements read and act along beside joints: places of markers, distances, forces of laws."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import Mechanism
from mbproj.base.errors import InputError
from mbproj.equations.assembly.assemble import assemble
from mbproj.equations.assembly.compiled import compile_system
from mbproj.functions.elements import Element, Force, Row, State
from mbproj.functions.program import Instruction, Op, Program, variable
from mbproj.functions.program_set import flatten
from mbproj.functions.table import spline
from mbproj.kernel import core
from mbproj.model.compile.elements import with_elements
from mbproj.model.compile.mechanism import initial_guess
from mbproj.motion.simulate import simulate
from mbproj.scene.scene import read_scene_text
from mbproj.scene.settings import settings_to_run
from mbproj.studies.verify.case import Case
from mbproj.studies.verify.checks import CHECKS, _check
from tests.elements.scenes import FORMULATIONS, SELDOM_FULL, TWO_SLIDES
from tests.support import Recorder

POST = (0.2, 0.0, 0.9)
PENDULUM = """
mbproj: 1
gravity: [0, 0, GRAVITY]
simulation: {duration: 1, output_step: 0.1, tolerance: 1e-11, integrator: dop853}
bodies:
  rod: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [0.6, 0, 0]}
joints:
  pin: {type: revolute, bodies: [ground, rod], location: [0, 0, 0], axis: [0, 1, 0]}
markers:
  centre: {body: rod, location: [0.6, 0, 0]}
  tip: {body: rod, location: [1, 0, 0]}
FORCES
"""
SPRING = """
forces:
  spring:
    {type: spring_damper, points: {ground: [0.2, 0, 0.9], rod: [1, 0, 0]},
     stiffness: 40, damping: 0.7, free_length: 0.5}
"""


def run(text, elements, forces="", gravity=-9.81, **options):
    scene = read_scene_text(text.replace("FORCES", forces).replace("GRAVITY", str(gravity)), simulation=options)
    system = with_elements(compile_system(scene), elements)
    recorder = Recorder()
    simulate(system, assemble(system, initial_guess(scene, system)), settings_to_run(scene), recorder)
    return system, recorder


@pytest.mark.parametrize("formulation", SELDOM_FULL)
def test_a_weight_along_a_markers_height_is_gravity(formulation):
    weight = Element("weight", reads=("centre.z", "centre.z_dot"), forces=(Force("centre.z", f"-{2 * 9.81}"),))
    system, pushed = run(PENDULUM, [weight], gravity=0, formulation=formulation)
    _, pulled = run(PENDULUM, [], formulation=formulation)
    np.testing.assert_allclose(pushed["bodies/position"], pulled["bodies/position"], atol=1e-10)
    height = pushed["joints/coordinate"][:, system.names.coordinates.index("centre.z")]
    np.testing.assert_allclose(height, pushed["bodies/position"][:, 0, 2], atol=1e-14)
    assert system.names.coordinate_units[-1] == "m"


@pytest.mark.parametrize("formulation", SELDOM_FULL)
def test_a_spring_on_a_length_is_a_spring_between_points(formulation):
    push = "-40*(s - 0.5) - 0.7*s_dot"
    own = Element("own", lengths={"length": (POST, "tip")}, forces=(Force("own.length", push),))
    _, ours = run(PENDULUM, [own], formulation=formulation)
    _, theirs = run(PENDULUM, [], SPRING, formulation=formulation)
    np.testing.assert_allclose(ours["bodies/position"], theirs["bodies/position"], atol=1e-10)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_rope_over_two_points_is_atwoods_machine(formulation):
    """(m - M) g/(m + M) with 2 and 3 kg."""
    lengths = {"left": ((0.0, 0.0, 0.0), "one"), "right": ("two", (1.0, 0.0, 0.0))}
    row = Row("length", {"rope.left": 1.0, "rope.right": 1.0}, constant=2.5)
    rope = Element("rope", lengths=lengths, rows=(row,))
    system, found = run(TWO_SLIDES, [rope], formulation=formulation)
    fall = 9.81 / 5 * found["time"] ** 2 / 2
    np.testing.assert_allclose(found["bodies/position"][:, :, 2], np.column_stack([-1 - fall, fall - 1.5]), atol=1e-10)
    assert np.abs(found["joints/violation"]).max() < 1e-14
    assert system.names.joints[-1] == "rope.length"


@pytest.mark.skipif(core() is None, reason="needs the compiled kernel")
@pytest.mark.full
def test_the_checks_of_verify_pass_where_an_element_pulls_on_a_length_by_a_height():
    """With a winch, whose pull goes by the height of another marker."""
    push = "-60*(s - 0.5) - 0.7*s_dot - 8*centre_z"
    winch = Element("winch", ("centre.z",), forces=(Force("winch.cable", push),), lengths={"cable": (POST, "tip")})
    text = PENDULUM.replace("FORCES", "").replace("GRAVITY", "-9.81").replace("duration: 1,", "duration: 0.3,")
    scene = read_scene_text(text, simulation={"tolerance": "1e-9"})
    system = with_elements(compile_system(scene), [winch])
    case = Case(Mechanism(scene, system, assemble(system, initial_guess(scene, system))))
    names = ("power", "momentum", "closed", "energy", "reduced", "planar", "linear", "order")
    found = {name: _check(name, CHECKS[name], case).verdict for name in names}
    assert found == dict.fromkeys(names, "passed")


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize("along", ["own.cable", "one.z", "a.displacement"])
def test_an_inerter_slows_a_fall(formulation, along):
    """m g/(m + I) with 3 kg and I = 2 kg along a length, a marker's height, or a joint's displacement."""
    own = Element("own", lengths={"cable": ((0.0, 0.0, 0.0), "one")}, inertias={along: 1.5})
    more = Element("more", lengths={"cable": ((0.0, 0.0, 0.0), "one")}, inertias={along.replace("own", "more"): 0.5})
    system, found = run(TWO_SLIDES, [own, more], formulation=formulation)
    fall = 9.81 * 3 / 5 * found["time"] ** 2 / 2
    np.testing.assert_allclose(found["bodies/position"][:, 0, 2], -1 - fall, atol=1e-10)
    assert np.abs(found["diagnostics/energy_balance"]).max() < 1e-10
    assert system.names.forces[-1].endswith(".inertia")


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize("along", ["own.cable", "one.z"])
def test_a_row_of_the_time_drives_a_length_or_a_markers_height(formulation, along):
    """s = constant + 0.1 sin 5t; the motion pulls with m (g + z'') along it."""
    down = along == "own.cable"
    row = Row("lift", {along: 1.0}, "0.1*sin(5*t)", constant=1.0 if down else -1.0)
    own = Element("own", lengths={"cable": ((0.0, 0.0, 0.0), "one")}, rows=(row,))
    system, found = run(TWO_SLIDES, [own], formulation=formulation)
    sine, sign = 0.1 * np.sin(5 * found["time"]), -1.0 if down else 1.0
    np.testing.assert_allclose(found["bodies/position"][:, 0, 2], -1 + sign * sine, atol=1e-13)
    np.testing.assert_allclose(found["motions/force"][:, 0], sign * 3 * (9.81 - sign * 25 * sine), atol=1e-10)
    assert system.names.motions == ("own.lift",)
    assert system.row_owner(system.constraints - 1) == "motion 'own.lift'"


FORCE_OF_ALL_KINDS = """
forces:
  given:
    {type: linear_spring_damper, joint: a, force: "30*t + 40*max(displacement, 0.02) - displacement_dot"}
"""
PULL = """
forces:
  pull:
    {type: spring_damper, points: {ground: [0, 0, 0], left: [0, 0, -1]},
     stiffness: 30, damping: 1, free_length: 0.4}
"""


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize(("name", "forces", "sign"), [("given", FORCE_OF_ALL_KINDS, 1), ("pull", PULL, -1)])
def test_the_integral_of_a_force_that_is_read_is_momentum(name, forces, sign, formulation):
    element = Element("scale", reads=(f"{name}.force",), states=(State("impulse", f"{name}_force"),))
    _, found = run(TWO_SLIDES, [element], forces, gravity=0, formulation=formulation)
    momentum = 3 * found["bodies/velocity"][:, 0, 2]
    assert np.abs(momentum).max() > 1
    np.testing.assert_allclose(sign * found["states/value"][:, 0], momentum, atol=1e-9)


def test_a_program_comes_back_as_it_was():
    table = spline([(0.0, 1.0), (1.0, 3.0), (2.0, 0.5)], "natural")
    of_table = Program((*variable(1), Instruction(Op.TABLE, 0.0, table)), "a table")
    given = [Program(variable(0), "t"), of_table, Program((*variable(2), Instruction(Op.POWER, 2.0)), "s_dot^2")]
    assert [flatten(given).program(index) for index in range(3)] == given


ROUGH = """
forces:
  rubs: {type: friction, joint: a, coulomb: {coefficient: 0.2, regularised: 1e-3 m/s}}
"""


@pytest.mark.parametrize(
    ("element", "forces", "message"),
    [
        (
            Element("rope", lengths={"left": ("two", "ones")}),
            "",
            "error: the length 'rope.left' ends at the marker 'ones', which does not exist; did you mean 'one'?",
        ),
        (
            Element("rope", lengths={"left": ("one", "low")}),
            "",
            "error: the length 'rope.left' has both ends on one rigid body; name another marker",
        ),
        (
            Element("eye", reads=("one.w",)),
            "",
            "error: element 'eye' reads 'one.w', which does not exist; did you mean 'one.",
        ),
        (
            Element("eye", reads=("rubs.force",)),
            ROUGH,
            "error: the force of 'rubs' cannot be read: it depends on a load, which would depend on the reader",
        ),
        (
            Element("lift", forces=(Force("two.u", "1"),)),
            "",
            "error: element 'lift' acts on 'two.u', which does not exist; did you mean 'two.z'?",
        ),
    ],
)
def test_what_cannot_be_measured_is_refused(element, forces, message):
    with pytest.raises(InputError) as caught:
        run(TWO_SLIDES, [element], forces)
    assert str(caught.value).startswith(message)
