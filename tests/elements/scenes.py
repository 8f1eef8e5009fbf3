"""Scenes with elements: a PID controller, a wheel and a slide, and one scene of each kind."""

from __future__ import annotations

import numpy as np

from mbproj import assemble, compile_system, initial_guess, read_scene_text, settings_to_run, simulate
from mbproj.functions.elements import Element, Force, Row, State
from mbproj.functions.program import CHANNELS, Op, Program, apply, number, variable
from mbproj.kernel import core
from mbproj.model.compile.elements import with_elements
from tests.crossed import full
from tests.support import DATA, Recorder, assembled

# A wheel and a slide, each on a joint to the ground, that elements couple and drive; and two slides.

FORMULATIONS = ["full", *(["reduced", "planar"] if core() is not None else [])]
#: Where the full one, in NumPy, takes a second or more and another test has it with such elements.
SELDOM_FULL = [full("full"), *FORMULATIONS[1:]]
SCENE = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 2, output_step: 0.1, tolerance: 1e-11, integrator: dop853}
bodies:
  wheel: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
  slide: {mass: 3, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0.3]}
joints:
  pin: {type: revolute, bodies: [ground, wheel], location: [0, 0, 0], axis: [0, 1, 0], SPEED}
  rail: {type: prismatic, bodies: [ground, slide], location: [0, 0, 0.3], axis: AXIS, speed: SLIDE}
"""
#: Two slides beside one another, with GRAVITY and FORCES.
TWO_SLIDES = """
mbproj: 1
gravity: [0, 0, GRAVITY]
simulation: {duration: 0.5, output_step: 0.05, tolerance: 1e-11, integrator: dop853}
bodies:
  left: {mass: 3, inertia: [0.1, 0.1, 0.1], position: [0, 0, -1]}
  right: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [1, 0, -1.5]}
joints:
  a: {type: prismatic, bodies: [ground, left], location: [0, 0, -1], axis: [0, 0, 1]}
  b: {type: prismatic, bodies: [ground, right], location: [1, 0, -1.5], axis: [0, 0, 1]}
markers:
  one: {body: left, location: [0, 0, -1]}
  two: {body: right, location: [1, 0, -1.5]}
  low: {body: left, location: [0, 0, -1.2]}
FORCES
"""
AXES = {"x": "[1, 0, 0]", "z": "[0, 0, 1]"}


def scene_of(axis="x", speed="speed: 0", slide=None, **options):
    text = SCENE.replace("AXIS", AXES[axis]).replace("SPEED", speed)
    text = text.replace(", speed: SLIDE", "" if slide is None else f", speed: {slide}")
    return read_scene_text(text, simulation=options)


def run(elements, **own):
    """(system, recorder, report) of the scene with elements."""
    scene = scene_of(**own)
    system = with_elements(compile_system(scene), elements)
    recorder = Recorder()
    report = simulate(system, assemble(system, initial_guess(scene, system)), settings_to_run(scene), recorder)
    return system, recorder, report


def brief(formulation):
    """The options of a run in this formulation, short in the full one, which takes milliseconds a step."""
    return {"formulation": formulation, "duration": "0.5" if formulation == "full" else "2"}


def at(found, name, names):
    return found["joints/coordinate"][:, names.index(name)]


# The pendulum with a motor's inductance and a PID controller, of which others computed the motion.

PID = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 0.5 s, output_step: 0.01 s, integrator: dop853, tolerance: 1e-12, formulation: auto}
bodies:
  rod: {mass: 1 kg, inertia: [0.02, 0.02, 0.02], position: [0, 0, -0.4]}
joints:
  pin: {type: revolute, bodies: [ground, rod], location: [0, 0, 0], axis: [0, -1, 0]}
signals:
  error: 1 rad - pin.angle
  U: 20*error + 30*integral - 2*filtered
states:
  integral: {derivative: error, initial: 0 rad*s}
  current: {derivative: (U - 0.8*current - 2*pin.angle_dot)/2e-3, scale: 1 A}
  filtered: {derivative: (pin.angle_dot - filtered)/(10 ms)}
forces:
  motor: {type: torsion_spring_damper, joint: pin, torque: 2*current}
"""


def ran(text: str, parameters=(), **simulation):
    """System, recorder and report of a run."""
    scene = read_scene_text(text, "<text>", dict(parameters), simulation)
    (system, state), found = assembled(scene), Recorder()
    return system, found, simulate(system, state, settings_to_run(scene), found)


def columns(system, found):
    """Angle, rate, current, integral and filtered rate, (T, 5)."""
    names = system.names.states
    states = [found["states/value"][:, names.index(name)] for name in ("current", "integral", "filtered")]
    return np.column_stack([found["joints/coordinate"][:, 0], found["joints/speed"][:, 0], *states])


def reference():
    """What an integration of the equations in five unknowns gives, t and those, (T, 6)."""
    return np.loadtxt(DATA / "elements" / "pid_pendulum.csv", delimiter=",", skiprows=1)


# Elements that tests use: a controller, a rack, a cam.


def pi_controller(
    name: str, coordinate: str, target: Program, gains: tuple[float, float, float], lag: float
) -> Element:
    """F = P e + I ∫e - D f with the error e = target(t) - s and the rate f' = (s' - f)/lag that a filter sees; `gains`
    P, I and D, `lag` in s."""
    s, rate, integral, filtered = (variable(CHANNELS + channel) for channel in range(4))
    error = apply(Op.SUBTRACT, target.code, s)
    proportional, whole, slowed = (number(gain) for gain in gains)
    push = apply(Op.ADD, apply(Op.MULTIPLY, proportional, error), apply(Op.MULTIPLY, whole, integral))
    push = apply(Op.SUBTRACT, push, apply(Op.MULTIPLY, slowed, filtered))
    return Element(
        name,
        reads=(coordinate, f"{coordinate}_dot", f"{name}.integral", f"{name}.filtered"),
        states=(
            State("integral", Program(error)),
            State("filtered", Program(apply(Op.DIVIDE, apply(Op.SUBTRACT, rate, filtered), number(lag)))),
        ),
        forces=(Force(coordinate, Program(push)),),
    )


def rack(name: str, angle: str, displacement: str, radius: float) -> Element:
    """s - r φ = const of two joint coordinates; `radius` r in m, negative where they go opposite ways."""
    return Element(name, rows=(Row("mesh", {displacement: 1.0, angle: -radius}),))


def cam(name: str, angle: str, follower: str, lift: Program) -> Element:
    """s - f(φ) = const of two joint coordinates, with the `lift` f of COORDINATE in m or rad. It repeats with each turn
    and is twice differentiable, as tables that are `periodic`."""
    return Element(name, rows=(Row("law", {angle: 0.0, follower: 1.0}, lift),))


def spring(name: str, coordinate: str, stiffness: float) -> Element:
    """F = -k s, which keeps ½ k s²; `stiffness` k in N/m or N m/rad."""
    s = variable(CHANNELS)
    kept = apply(Op.MULTIPLY, number(0.5 * stiffness), apply(Op.MULTIPLY, s, s))
    push = Program(apply(Op.MULTIPLY, number(-stiffness), s))
    return Element(name, reads=(coordinate,), forces=(Force(coordinate, push),), stores=Program(kept))


def motor(name: str, angle: str, voltage: float, winding: tuple[float, float], constant: float) -> Element:
    """Torque k i with L i' = U - R i - k ω: it keeps ½ L i² and loses R i²; `winding` R in Ω and L in H."""
    resistance, inductance = winding
    rate, current, heat = (variable(CHANNELS + channel) for channel in range(3))
    square = apply(Op.MULTIPLY, current, current)
    drop = apply(Op.ADD, apply(Op.MULTIPLY, number(resistance), current), apply(Op.MULTIPLY, number(constant), rate))
    grows = apply(Op.DIVIDE, apply(Op.SUBTRACT, number(voltage), drop), number(inductance))
    return Element(
        name,
        reads=(f"{angle}_dot", f"{name}.current", f"{name}.heat"),
        states=(
            State("current", Program(grows), unit="A"),
            State("heat", Program(apply(Op.MULTIPLY, number(resistance), square)), unit="J"),
        ),
        forces=(Force(angle, Program(apply(Op.MULTIPLY, number(constant), current))),),
        stores=Program(apply(Op.MULTIPLY, number(0.5 * inductance), square)),
        lost=Program(heat),
    )
