"""Sampled controllers: against matrix exponentials, in every method, step by step from Python, and many at once."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

import mbproj
from mbproj import (
    assemble,
    compile_system,
    equilibrium,
    initial_guess,
    modes,
    read_scene_text,
    settings_to_run,
    simulate,
)
from mbproj.base.errors import InputError, SimulationError
from mbproj.equations.forces import law_state, state_rates
from mbproj.functions import values
from mbproj.kernel import core
from tests.crossed import crossed, full
from tests.elements.scenes import FORMULATIONS, SELDOM_FULL, ran
from tests.support import Recorder, assembled

CART = """
mbproj: 1
gravity: [0, 0, 0]
parameters: {T: 20 ms, start: 0.1}
simulation: {duration: 1 s, output_step: 10 ms, integrator: dop853, tolerance: 1e-10, formulation: auto}
bodies:
  cart: {mass: 2 kg, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
joints:
  rail:
    {type: prismatic, bodies: [ground, cart], location: [0, 0, 0], axis: [1, 0, 0], displacement: start, speed: 0.5}
controllers:
  pd: {period: T, hold: {u: -80*rail.displacement - 8*rail.displacement_dot}}
forces:
  drive: {type: linear_spring_damper, joint: rail, force: pd.u}
"""
SLOW_COMPUTER = CART.replace(
    "{period: T, hold: {u: -80*rail.displacement - 8*rail.displacement_dot}}",
    """
    period: T
    delay: 3 ms
    hold: {u: {value: -80*rail.displacement - 8*rail.displacement_dot - 5*sum, initial: 1}}
    states: {sum: {next: sum + rail.displacement, initial: 0.2}}""",
)


def over(T: float):
    """From one place, speed and force on a cart of 2 kg to those T later."""
    return expm(np.array([[0, 1, 0], [0, 0, 0.5], [0, 0, 0.0]]) * T)


def end(found):
    return np.array([found["joints/coordinate"][-1, 0], found["joints/speed"][-1, 0]])


RUNS = [
    {"formulation": "full", "duration": 0.3},
    *({"formulation": formulation} for formulation in FORMULATIONS[1:]),
    {"integrator": "radau5"},
    {"integrator": "auto"},
    {"integrator": "esdirk4", "formulation": "full", "duration": 0.2},  # in NumPy: seconds
    {"integrator": "rk4", "tolerance": None, "step": 0.01},
    {"integrator": "rk4", "tolerance": None, "step": 0.025, "output_step": 0.1},  # the period does not divide it
    full({"integrator": "rk4", "tolerance": None, "step": 0.025, "output_step": 0.1, "formulation": "full"}),
]


@pytest.mark.parametrize("options", RUNS, ids=str)
def test_a_held_force_moves_a_cart_as_the_matrix_exponential_says(options):
    x = np.array([0.1, 0.5, 0.0])
    for _ in range(round(options.get("duration", 1.0) / 0.02)):
        x[2] = -80.0 * x[0] - 8.0 * x[1]
        x = over(0.02) @ x
    _, found, _ = ran(CART, **options)
    assert np.abs(end(found) - x[:2]).max() < 1e-13


@pytest.mark.parametrize("formulation", SELDOM_FULL)
def test_a_delay_and_a_state_of_its_own(formulation):
    x, total, computed = np.array([0.1, 0.5, 1.0]), 0.2, 0.0
    periods = 20 if formulation == "full" else 50
    for _ in range(periods):
        computed, total = -80.0 * x[0] - 8.0 * x[1] - 5.0 * total, total + x[0]
        x = over(0.003) @ x
        x[2] = computed
        x = over(0.017) @ x
    system, found, _ = ran(SLOW_COMPUTER, formulation=formulation, duration=periods * 0.02)
    assert np.abs(end(found) - x[:2]).max() < 1e-13
    states = dict(zip(system.names.states, found["states/value"][-1], strict=True))
    assert states == pytest.approx({"pd.u": computed, "pd.sum": total, "pd.u.computed": computed}, abs=1e-12)


def test_at_one_time_controllers_act_in_the_order_of_the_scene():
    text = CART.replace(
        "  pd:", "  first: {period: T, hold: {n: n + 1}}\n  second: {period: 2*T, hold: {m: first.n}}\n  pd:"
    )
    system, found, _ = ran(text, duration=0.09)
    states = dict(zip(system.names.states, found["states/value"][-1], strict=True))
    assert (states["first.n"], states["second.m"]) == (5.0, 5.0)
    text = CART.replace(
        "  pd:", "  second: {period: 2*T, hold: {m: first.n}}\n  first: {period: T, hold: {n: n + 1}}\n  pd:"
    )
    system, found, _ = ran(text, duration=0.09)
    assert dict(zip(system.names.states, found["states/value"][-1], strict=True))["second.m"] == 4.0


def test_the_limit_of_its_period_is_that_of_the_discrete_equations():
    """x⁺ = (Φ + Γ K) x is stable below T = 2 d/k = 0.2 s; each run over one period gives a column of it."""

    def radius(T: float) -> float:
        columns = []
        for place, speed in ((0.1, 0.0), (0.0, 0.1)):
            text = CART.replace("speed: 0.5", f"speed: {speed}")
            found = ran(text, {"T": T, "start": place}, duration=T, output_step=T)[1]
            columns.append(end(found) / 0.1)
        return float(np.abs(np.linalg.eigvals(np.array(columns).T)).max())

    assert brentq(lambda T: radius(T) - 1.0, 0.15, 0.25, xtol=1e-9) == pytest.approx(0.2, abs=1e-6)


BLOCKS = SLOW_COMPUTER.replace(
    "forces:\n",
    """signals:
  seen: {delay: {of: rail.displacement, time: 60 ms, period: 20 ms}}
  smooth: {filter: {of: rail.displacement_dot, time: 10 ms, order: 2}}
  lead: {transfer_function: {of: seen, num: [0.1, 1], den: [0.01, 1]}}
  most: {rate_limit: {of: -5*lead - smooth, rate: 40, time: 5 ms}}
forces:
  other: {type: linear_spring_damper, joint: rail, force: most}
""",
)


@pytest.mark.full_where(formulation="full")
@crossed(
    "options, formulation, text",
    [pytest.param({}, id="error"), pytest.param({"tolerance": None, "step": 0.003, "output_step": 0.03}, id="fixed")],
    [
        *(pytest.param(each, SLOW_COMPUTER, id=f"computer-{each}") for each in FORMULATIONS),
        pytest.param("planar", BLOCKS, id="blocks-planar"),
        pytest.param("reduced", BLOCKS, id="blocks-reduced"),
    ],
    dear=["full"],
)
def test_a_run_goes_on_to_the_bit(text, formulation, options):
    system, state = assembled(read_scene_text(text, "<text>", {}, {"formulation": formulation, **options}))

    def part(duration, resumed=None):
        found, marks = Recorder(), []
        settings = settings_to_run(
            read_scene_text(text, "<text>", {}, {"formulation": formulation, "duration": duration, **options})
        )
        simulate(system, state, settings, found, keep=lambda *mark: marks.append(mark[-1]), resumed=resumed or {})
        return found, marks[-1]

    until = 0.2 if formulation == "full" else 0.6
    whole, (first, mark) = part(until)[0], part(0.5 * until)
    rest = part(until, mark)[0]
    for name in ("states/value", "joints/coordinate", "joints/speed"):
        both = np.concatenate([first[name][first["time"] <= mark["t"]], rest[name]])
        assert np.array_equal(both, whole[name])


BOUNCING = CART.replace("gravity: [0, 0, 0]", "gravity: [-9.81, 0, 0]").replace(
    "displacement: start,",
    "displacement: start, limits: {displacement: {range: [0, 2], rigid: true, restitution: 0.6}},",
)


def test_it_acts_once_at_each_instant_also_where_stops_are_met():
    text = BOUNCING.replace("hold: {", "hold: {n: n + 1, ")
    ends = [ran(text, formulation=formulation, duration=0.5) for formulation in FORMULATIONS]
    for system, found, _ in ends:
        assert found["states/value"][-1, system.names.states.index("pd.n")] == 25.0
        assert np.abs(end(found) - end(ends[0][1])).max() < 1e-7


def test_it_rests_where_the_held_value_holds_it():
    text = CART.replace("gravity: [0, 0, 0]", "gravity: [-9.81, 0, 0]")
    found = equilibrium(read_scene_text(text))
    assert found.coordinates["rail.displacement"] == pytest.approx(-2.0 * 9.81 / 80.0, abs=1e-12)
    assert found.states["pd.u"] == pytest.approx(19.62, abs=1e-10)
    assert found.stable is None
    with pytest.raises(InputError, match="acts at instants"):
        modes(read_scene_text(text))


def test_what_has_no_value_is_named_with_its_time():
    text = CART.replace("{u: -80", "{u: log(0.05 - t) - 80")
    for formulation in FORMULATIONS:
        with pytest.raises(SimulationError, match="controller 'pd'") as caught:
            ran(text, formulation=formulation)
        assert caught.value.time == pytest.approx(0.06)


WRONG = {
    "delay": ("period: T,", "period: T, delay: 20 ms,", "the delay is shorter than the period"),
    "nothing": ("hold: {u: -80*rail.displacement - 8*rail.displacement_dot}", "hold: {}", "holds nothing"),
    "a name": ("-80*rail", "-80*rails", "did you mean 'rail.displacement'"),
    "outside": ("force: pd.u", "force: pd.v", "did you mean 'pd.u'"),
    "twice": ("hold: {", "states: {u: {next: 1}}, hold: {", "has 'u' twice"),
    "a period": ("period: T,", "period: 0 s,", "must be greater than 0"),
    "many": ("period: T,", "period: 1e-8 s,", "instants"),
}


@pytest.mark.parametrize("case", WRONG)
def test_mistakes_are_told(case):
    before, after, message = WRONG[case]
    assert before in CART
    with pytest.raises(InputError) as caught:
        ran(CART.replace(before, after, 1))
    assert message in str(caught.value)


# A run that goes on step by step from Python: against matrix exponentials, and what cannot be run so.

PUSHED_CART = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 1 s, output_step: 10 ms}
bodies:
  cart: {mass: 2 kg, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
joints:
  rail: {type: prismatic, bodies: [ground, cart], location: [0, 0, 0], axis: [1, 0, 0], displacement: 0.1, speed: 0.5}
states: {u: {derivative: 0, initial: 0 N}}
signals: {x: rail.displacement, v: rail.displacement_dot}
forces:
  drive: {type: linear_spring_damper, joint: rail, force: u}
"""
STEP = expm(np.array([[0, 1, 0], [0, 0, 0.5], [0, 0, 0.0]]) * 0.02)
METHODS = [
    {"tolerance": 1e-10, "formulation": "planar"},
    {"tolerance": 1e-8, "integrator": "radau5"},
    {"step": 0.005, "integrator": "rk4", "formulation": "reduced"},
]


@pytest.mark.skipif(core() is None, reason="a run step by step is made in the kernel")
@pytest.mark.parametrize("options", METHODS, ids=str)
def test_inputs_from_python_move_a_cart_as_the_matrix_exponential_says(options):
    run, x = mbproj.start(PUSHED_CART, period=0.02, **options), np.array([0.1, 0.5, 0.0])
    times = [run.t]
    while not run.is_over:
        seen = run.signals
        assert seen == pytest.approx({"x": x[0], "v": x[1]}, abs=1e-13)
        x[2] = -80.0 * x[0] - 8.0 * x[1]
        times.append(run.advance(inputs={"u": -80.0 * seen["x"] - 8.0 * seen["v"]}))
        x = STEP @ x
    assert np.allclose(times, np.linspace(0.0, 1.0, 51), atol=1e-15)
    assert run.state.x == pytest.approx([x[2]], abs=1e-12)


@pytest.mark.skipif(core() is None, reason="a run step by step is made in the kernel")
def test_it_goes_on_to_the_first_instant_that_is_not_before_a_time():
    run = mbproj.start(PUSHED_CART, period=0.02, step=0.005, integrator="rk4")
    assert run.advance(until=0.05, inputs={"u": 4.0}) == pytest.approx(0.06)
    assert run.signals["v"] == pytest.approx(0.5 + 2.0 * 0.06, abs=1e-13)
    assert run.advance(until=9.0) == pytest.approx(1.0)
    with pytest.raises(InputError, match="is over"):
        run.advance()


@pytest.mark.skipif(core() is None, reason="a run step by step is made in the kernel")
def test_what_it_cannot_do_is_said():
    run = mbproj.start(PUSHED_CART, period=0.02, tolerance=1e-6)
    with pytest.raises(InputError, match="no state of the scene"):
        run.advance(inputs={"force": 1.0})
    for options, words in (
        ({"period": -1.0}, "must be a time"),
        ({"period": 0.1, "formulation": "full"}, "in the kernel"),
        ({"period": 0.1, "integrator": "auto"}, "integrator auto"),
    ):
        with pytest.raises(InputError, match=words):
            mbproj.start(PUSHED_CART, **{"tolerance": 1e-6, **options})
    with pytest.raises(TypeError, match=r"^start\(\) has no argument 'tolerances'; did you mean 'tolerance'"):
        mbproj.start(PUSHED_CART, period=0.1, tolerances=1e-3)
    with pytest.raises(InputError, match="give way"):
        limited = PUSHED_CART.replace("speed: 0.5", "speed: 0.5, limits: {displacement: {range: [0, 1], rigid: true}}")
        mbproj.start(limited, period=0.1, tolerance=1e-6)


@pytest.mark.skipif(core() is None, reason="a run step by step is made in the kernel")
@pytest.mark.parametrize("options", METHODS, ids=str)
def test_a_controller_from_python_acts_as_one_of_the_scene(options):
    """The same law, as a function and in the scene: the same run to the bit, and what the matrix exponential says."""
    asked = []

    def controller(t, seen):
        asked.append(t)
        return {"u": -80.0 * seen["x"] - 8.0 * seen["v"]}

    own = mbproj.run(PUSHED_CART, controller=controller, period=0.02, **options)
    law = "controllers: {pd: {period: 20 ms, hold: {u: -80*rail.displacement - 8*rail.displacement_dot}}}\n"
    of_scene = PUSHED_CART.replace("states: {u: {derivative: 0, initial: 0 N}}\n", law).replace(
        "force: u", "force: pd.u"
    )
    other = mbproj.run(of_scene, **options)
    for path in ("joints/coordinate", "joints/speed", "states/value"):
        np.testing.assert_array_equal(own[path][:-1], other[path][:-1])
    assert np.allclose(asked, np.linspace(0.0, 0.98, 50), atol=1e-15)
    x = np.array([0.1, 0.5, 0.0])
    for _ in range(50):
        x[2] = -80.0 * x[0] - 8.0 * x[1]
        x = STEP @ x
    assert own["joints/coordinate"][-1, 0] == pytest.approx(x[0], abs=1e-13)


@pytest.mark.skipif(core() is None, reason="a run step by step is made in the kernel")
def test_a_controller_may_set_nothing_and_its_mistakes_are_told():
    still = mbproj.run(PUSHED_CART, controller=lambda t, seen: None, period=0.1, tolerance=1e-8)
    assert still["joints/coordinate"][-1, 0] == pytest.approx(0.6, abs=1e-12)
    for again in (mbproj.rerun, mbproj.continue_run):
        with pytest.raises(InputError, match="a function in Python acted on the run"):
            again(still)
    for options, words in (
        ({"period": None}, "acts each period"),
        ({"period": 0.1, "certify": True}, "is not certified"),
        ({"period": 0.1, "formulation": "full"}, "in the kernel"),
        ({"period": 0.1, "controller": lambda t, seen: {"v": 1.0}}, "'v' is no state of the scene"),
        ({"period": 0.1, "controller": lambda t, seen: {"u": float("nan")}}, "input 'u' is nan, which is not finite"),
        ({"period": 0.1, "controller": None}, "add controller=f"),
    ):
        with pytest.raises(InputError, match=words):
            mbproj.run(PUSHED_CART, **{"tolerance": 1e-6, "controller": lambda t, seen: {}, **options})


# What a program costs does not go by how many others there are: of controllers on a chain.

HEAD = "mbproj: 1\ngravity: [0, 0, -9.81]\nsimulation: {duration: 0.02, step: 0.001, integrator: rk4}\n"


def chain(links: int) -> str:
    """A chain with a controller at each joint."""
    bodies = [f"  b{i}: {{mass: 1, inertia: [0.01, 0.1, 0.1], position: [{i + 0.5}, 0, 0]}}" for i in range(links)]
    joints = [
        f"  j{i}: {{type: revolute, bodies: [{f'b{i - 1}' if i else 'ground'}, b{i}], "
        f"location: [{i}, 0, 0], axis: [0, 1, 0]}}"
        for i in range(links)
    ]
    held = [f"  c{i}: {{period: 2 ms, hold: {{u: -20*j{i}.angle - j{i}.angle_dot}}}}" for i in range(links)]
    drives = [f"  f{i}: {{type: torsion_spring_damper, joint: j{i}, torque: c{i}.u}}" for i in range(links)]
    blocks = {"bodies": bodies, "joints": joints, "controllers": held, "forces": drives}
    return HEAD + "\n".join(line for name, lines in blocks.items() for line in (f"{name}:", *lines)) + "\n"


def test_programs_make_the_variables_that_they_name(monkeypatch):
    """Each of a chain of n names two or three of the 3 n; all of them would be a cost by n squared."""
    counted, made = [], values.numbers
    monkeypatch.setattr(values, "numbers", lambda x: counted.append(x) or made(x))
    numbers = []
    for links in (10, 20):
        scene = read_scene_text(chain(links))
        system = compile_system(scene)
        instant = assemble(system, initial_guess(scene, system)).instant(system)
        counted.clear()
        law_state(instant)
        state_rates(instant)
        numbers.append(len(counted))
    assert 0 < numbers[0] <= 4 * 10
    assert numbers[1] == 2 * numbers[0]
