"""Passages through singular poses, from wherever a run begins."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.integrate import quad

from mbproj import Scene, read_scene, settings_to_run, simulate
from mbproj.base.errors import InputError, SimulationError
from mbproj.base.registry import integrators
from mbproj.base.settings import Settings
from mbproj.kernel import core
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.motion.formulations.reduced import Reduced
from mbproj.motion.formulations.redundant_rows import settle_rows
from mbproj.scene.scene import read_scene_text
from tests.crossed import once, some
from tests.kernel.scenes import needs_kernel
from tests.mechanisms.closed_forms import PARALLELOGRAM
from tests.mechanisms.running import assert_close
from tests.support import ROOT, Recorder, assembled

# Passages through poses where the rows of C_q become dependent and the mechanism could go on in two ways: the run goes
# on as it came, or stops there and says so; it never jumps.
#
# A run comes near such a pose as its phase has it. Where it would land is varied from 0.03 rad to a hit within round-
# off.

#: Distances from the singular pose, rad, at which a step lands: by hits, near misses, and twentieths of a step.
OFFSETS = (
    0.0,
    1e-15,
    -1e-14,
    1e-13,
    -1e-12,
    1e-11,
    -1e-10,
    1e-9,
    -1e-8,
    1e-7,
    -1e-6,
    1e-5,
    -1e-4,
    1e-3,
    -3e-3,
    0.005,
    0.0075,
    0.01,
    0.0125,
    0.015,
    0.0175,
    0.02,
    0.0225,
    0.025,
)
#: What C sees of cranks that part by δ, at φ from the singular pose, is a φ δ + a (1 - a/l) δ²/2 with a = 0.2 m: where
#: joints close to 1e-12 m, some 1e-13 for each, |δ| <= min(SEEN / φ, sqrt(SEEN)) is left.
SEEN = 5e-11


@dataclass(frozen=True)
class Outcome:
    """What a run recorded, and why it stopped, if it did."""

    recorder: Recorder
    names: object
    stopped: SimulationError | None

    def __getitem__(self, path: str) -> np.ndarray:
        return self.recorder[path]

    def angle(self, body: str, axis: int = 1) -> np.ndarray:
        """How far the body has turned about -y (or another axis), unwrapped."""
        A = rotation_matrix(self["bodies/orientation"][:, self.names.bodies.index(body)])
        i, j = (axis + 1) % 3, (axis + 2) % 3
        return np.unwrap(np.arctan2(A[:, i, j], A[:, i, i]))


def attempt(text: str, parameters: dict | None = None, **simulation: object) -> Outcome:
    options = {key: str(value) for key, value in simulation.items()}
    scene = read_scene_text(text, "scene.yaml", parameters or {}, options)
    (system, state), recorder = assembled(scene), Recorder()
    try:
        simulate(system, state, settings_to_run(scene), recorder)
    except SimulationError as error:
        return Outcome(recorder, system.names, error)
    return Outcome(recorder, system.names, None)


def assert_stopped_with_the_reason(outcome: Outcome, singular_time: float, step: float) -> None:
    """Within two steps of the pose, as a singular one."""
    error = outcome.stopped
    assert error is not None
    assert "singular position" in error.cause, str(error)
    assert abs(error.time - singular_time) <= 2.0 * step, str(error)


def allowed(departure: np.ndarray) -> np.ndarray:
    """By how much an angle may be off where the singular pose is so far away, rad."""
    return np.minimum(SEEN / np.maximum(np.abs(departure), 1e-30), np.sqrt(SEEN))


#: How the loop may be closed: with three redundant rows in space, or with none.
FORMS = (("revolute", "planar"), ("revolute", "reduced"), ("point_on_line", "reduced"), ("point_on_line", "full"))


def assert_parallel(outcome: Outcome, start: float, speed: float, even: float = 1e-3) -> None:
    """Both cranks turn alike and the coupler does not turn, as far as C can see it; the speed is `even`."""
    left, right = outcome.angle("left"), outcome.angle("right")
    φ = start + left - left[0]
    departure = np.abs((φ + np.pi / 2) % np.pi - np.pi / 2)
    off = np.abs(right - left) / allowed(departure)
    at = np.argmax(off)
    assert off[at] <= 1.0, f"cranks part by {abs(right - left)[at]:.3g} rad at t = {outcome['time'][at]:.6g} s"
    assert_close(outcome.angle("coupler"), 0.0, 2.0 * np.sqrt(SEEN))
    rate = outcome["joints/speed"][:, outcome.names.coordinates.index("A.angle")]
    assert_close(rate[departure > 1e-3], speed, even)


@pytest.mark.parametrize(
    ("offset", "closure", "formulation"),
    some([(offset, *form) for form in FORMS for offset in (OFFSETS[::3] if form[1] == "full" else OFFSETS)], 3),
)
def test_a_parallelogram_keeps_its_cranks_parallel(offset, closure, formulation):
    """Steps land by `offset` off the line of all bars after one radian, and the same off it half a turn later."""
    start = -1.0 + offset
    outcome = attempt(PARALLELOGRAM.replace("CLOSURE", closure), {"start": start}, formulation=formulation)
    assert_parallel(outcome, start, 1.0)
    if outcome.stopped:
        assert_stopped_with_the_reason(outcome, 1.0 - offset, 0.05)
    else:
        assert outcome["time"][-1] == 2.0


@pytest.mark.parametrize(
    ("integrator", "closure", "formulation"),
    once(list(integrators()), [pytest.param(*form) for form in FORMS[:3]]),
)
def test_no_integrator_leaves_the_parallelogram(integrator, closure, formulation):
    """Eight turns, with stages of the step everywhere; each of 16 passages may cost 1 % of the speed."""
    for step in (0.02, 0.1, np.pi / 16):
        outcome = attempt(
            PARALLELOGRAM.replace("CLOSURE", closure),
            {"start": np.pi / 4, "speed": -2.0},
            step=step,
            integrator=integrator,
            duration=8 * np.pi // step * step,
            formulation=formulation,
        )
        assert_parallel(outcome, np.pi / 4, -2.0, even=0.16)
        if outcome.stopped:  # the speed may have changed: where the crank was tells the passage, not the time
            φ = np.pi / 4 + outcome.angle("left")[-1] - outcome.angle("left")[0]
            departure = (φ + np.pi / 2) % np.pi - np.pi / 2
            speed = outcome["joints/speed"][-1, outcome.names.coordinates.index("A.angle")]
            assert_stopped_with_the_reason(outcome, outcome["time"][-1] - departure / speed, step)


@pytest.mark.parametrize(
    ("integrator", "closure"),
    once([name for name, entry in integrators().items() if entry.embedded], ["revolute", "point_on_line"]),
)
def test_error_control_does_not_leave_the_parallelogram(integrator, closure):
    text = PARALLELOGRAM.replace("CLOSURE", closure).replace("step: 0.05", "tolerance: 1.0e-8, output_step: 0.05")
    for start in (-1.0, -0.4321, np.pi - 2.0):
        outcome = attempt(text, {"start": start}, integrator=integrator, duration=12, output_step=0.05)
        assert_parallel(outcome, start, 1.0)
        if outcome.stopped:
            passages = np.pi * np.arange(6) - start
            assert np.abs(passages - outcome.stopped.time).min() < 0.2
            assert "singular position" in outcome.stopped.cause


@pytest.mark.parametrize(
    ("offset", "closure", "formulation"), once(OFFSETS[::3], [pytest.param(*form) for form in FORMS[:3]])
)
def test_a_driven_parallelogram_keeps_its_cranks_parallel(offset, closure, formulation):
    """With no degree of freedom left, and at the singular pose one that the rows do not see."""
    text = PARALLELOGRAM.replace("CLOSURE", closure) + "motions:\n  m: {joint: A, angle: {constant_speed: speed}}\n"
    outcome = attempt(text, {"start": -1.0 + offset}, formulation=formulation)
    assert_parallel(outcome, -1.0 + offset, 1.0)
    if outcome.stopped:
        assert_stopped_with_the_reason(outcome, 1.0 - offset, 0.05)


#: A slider-crank whose rod is as long as its crank: at θ = 90° the slider is in the bearing, and could stay there.
EQUAL = """
mbproj: 1
gravity: [0, 0, 0]
parameters: {r: 0.2 m, start: 0.5, speed: 1.5, x: r*cos(start), z: r*sin(start)}
simulation: {duration: 1.6, step: 0.02}
bodies:
  crank: {mass: 1, inertia: [0.01, 0.02, 0.02], position: [0, 0, 0], orientation: {axis: [0, -1, 0], angle: start}}
  rod:
    mass: 0.5
    inertia: [0.001, 0.002, 0.002]
    position: [1.5*x, 0, z/2]
    orientation: {axis: [0, 1, 0], angle: start}
  slider: {mass: 0.4, inertia: [0.001, 0.001, 0.001], position: [2*x, 0, 0]}
joints:
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, -1, 0], speed: speed}
  B: {type: revolute, bodies: [crank, rod], location: [x, 0, z], axis: [0, -1, 0]}
  C: {type: point_on_line, bodies: [slider, rod], location: [2*x, 0, 0], axis: [0, -1, 0]}
  D: {type: prismatic, bodies: [ground, slider], location: [2*x, 0, 0], axis: [1, 0, 0]}
"""


def equal_moment(θ: np.ndarray) -> np.ndarray:
    """Of EQUAL: crank and rod turn by ± θ; the rod's middle is at (1.5 cos θ, 0.5 sin θ) r, the slider at 2 r cos θ."""
    sine = 0.2**2 * np.sin(θ) ** 2
    return 0.02 + 0.002 + 0.5 * (2.25 * sine + 0.25 * (0.2**2 - sine)) + 0.4 * 4 * sine


def assert_on_the_sliding_branch(outcome: Outcome, start: float, speed: float) -> None:
    """s = 2 r cos θ, the rod at -θ, and ½ I(θ) θ'² as at the start."""
    θ = start + outcome.angle("crank") - outcome.angle("crank")[0]
    departure = np.abs(np.cos(θ))
    slider = outcome["bodies/position"][:, outcome.names.bodies.index("slider"), 0]
    off = np.abs(slider - 0.4 * np.cos(θ)) / (0.4 * allowed(departure))
    at = np.argmax(off)
    assert off[at] <= 1.0, f"slider off by {0.4 * (off * allowed(departure))[at]:.3g} m at {outcome['time'][at]:.6g} s"
    rate = outcome["joints/speed"][:, outcome.names.coordinates.index("A.angle")]
    far = departure > 1e-4
    assert_close((0.5 * equal_moment(θ) * rate**2)[far], 0.5 * equal_moment(np.array(start)) * speed**2, 1e-7)


def time_at_the_branch(start: float, speed: float) -> float:
    whole = equal_moment(np.array(start)) * speed**2
    return quad(lambda θ: float(np.sqrt(equal_moment(np.array(θ)) / whole)), start, np.pi / 2, epsabs=1e-14)[0]


@pytest.mark.parametrize(
    ("offset", "formulation"),
    some([(offset, name) for name in ("planar", "reduced") for offset in OFFSETS], 3)
    + some([(each, "full") for each in OFFSETS[::3]], 9),
)
def test_a_slider_goes_on_through_the_bearing(offset, formulation):
    """50 steps to the branch point, or to `offset` s from it."""
    at = time_at_the_branch(0.5, 1.5)
    step = (at - offset) / 50
    text = EQUAL if formulation != "planar" else EQUAL.replace("point_on_line", "revolute")
    outcome = attempt(text, formulation=formulation, step=step, duration=80 * step)
    assert_on_the_sliding_branch(outcome, 0.5, 1.5)
    if outcome.stopped:
        assert_stopped_with_the_reason(outcome, at, step)
    else:
        assert len(outcome["time"]) == 81


#: Starts on the branch point itself, where a run would have to guess: the mechanism, and its coordinate there.
AT_THE_BRANCH = {
    "parallelogram": (PARALLELOGRAM.replace("CLOSURE", "revolute"), {"start": 0.0}),
    "parallelogram, regular closure": (PARALLELOGRAM.replace("CLOSURE", "point_on_line"), {"start": 0.0}),
    "slider in the bearing": (EQUAL.replace("point_on_line", "revolute"), {"start": np.pi / 2}),
    "slider in the bearing, regular closure": (EQUAL, {"start": np.pi / 2}),
}


@pytest.mark.parametrize("formulation", ["auto", "planar", "reduced", "full"])
@pytest.mark.parametrize("name", AT_THE_BRANCH)
def test_a_start_on_the_branch_point_is_refused_with_the_reason(name, formulation):
    text, parameters = AT_THE_BRANCH[name]
    with pytest.raises(InputError, match=r"stretched or folded|singular"):
        attempt(text, parameters, formulation=formulation)


# No choice of rows depends on where a run begins: from any state that a run has reached the motion is the same.

FOREVER = 100.0
#: A crank and a rocker of 0.2 m, with two couplers beside each other in planes y = 0 and y = 0.1 m: hinges throughout.
TWO_COUPLERS = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 1, step: 0.01}
bodies:
  crank: {mass: 1, inertia: [0.01, 0.01, 0.002], position: [0, 0, 0.1]}
  rocker: {mass: 2, inertia: [0.02, 0.02, 0.002], position: [0.5, 0, 0.1]}
  near: {mass: 0.5, inertia: [0.001, 0.01, 0.01], position: [0.25, 0, 0.2]}
  far: {mass: 0.7, inertia: [0.001, 0.02, 0.02], position: [0.25, 0.1, 0.15]}
joints:
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: y, speed: 9}
  B: {type: revolute, bodies: [ground, rocker], location: [0.5, 0, 0], axis: y}
  C: {type: revolute, bodies: [crank, near], location: [0, 0, 0.2], axis: y}
  D: {type: revolute, bodies: [near, rocker], location: [0.5, 0, 0.2], axis: y}
  E: {type: revolute, bodies: [crank, far], location: [0, 0.1, 0.15], axis: y}
  F: {type: revolute, bodies: [far, rocker], location: [0.5, 0.1, 0.15], axis: y}
"""


def restarted(name: str) -> Scene:
    """A scene with redundant rows: a shipped mechanism, or the two couplers."""
    shipped = ROOT / "mechanisms" / f"{name}.yaml"
    return read_scene_text(TWO_COUPLERS) if name == "two couplers" else read_scene(shipped)


def compiled_of(scene: Scene):
    """In the kernel, with its usual rows, and its start."""
    system, state = assembled(scene)
    compiled = Reduced(core(), system)
    settle_rows(compiled, state)
    return compiled, state


@needs_kernel
@pytest.mark.parametrize("name", ["bricard", "bennett", "n_four_bar", "locomotive", "two couplers"])
def test_the_usual_rows_are_those_of_the_scene_wherever_it_starts(name):
    """Walks from other poses of the motion found other rows, or other pivots, by which a step takes other rows."""
    compiled, state = compiled_of(restarted(name))
    block = compiled.run(state, Settings(duration=0.5, step=1 / 128)).advance(1000, FOREVER)
    rows = compiled.model.rows
    assert rows.redundant > 0
    for at in (13, 40, 64):
        there = compiled.samples(block, {}).state(at)
        assert settle_rows(compiled, there) == rows.redundant
        now = compiled.model.rows
        assert (now.left_out, now.pivots, now.even) == (rows.left_out, rows.pivots, rows.even)


@needs_kernel
@pytest.mark.parametrize("name", ["bricard", "bennett", "two couplers"])
def test_a_run_from_a_state_that_a_run_has_reached_is_the_same_motion(name):
    """In everything that a user's restart does anew, by `simulate`. It went its own way after some steps, by 3e-5 m."""
    scene, step, steps = restarted(name), 0.01, 90
    system, state = assembled(scene)
    settings = replace(scene.settings, step=step, tolerance=None, integrator="rk4", formulation="reduced")
    settings = replace(settings, duration=steps * step, output_step=step)
    whole = Recorder()
    simulate(system, state, settings, whole)
    for at in (7, 23, 41, 58):
        reached = simulate(system, state, replace(settings, duration=at * step), Recorder()).state
        again = Recorder()
        simulate(system, reached, replace(settings, duration=(steps - at) * step), again)
        apart = np.abs(again["bodies/position"] - whole["bodies/position"][at:])
        assert apart.max() < 1e-12


@needs_kernel
def test_a_scene_whose_bodies_start_at_a_recorded_state_has_the_motion_of_the_run():
    scene, step, steps = restarted("bricard"), 0.01, 60
    system, state = assembled(scene)
    settings = replace(scene.settings, step=step, tolerance=None, integrator="rk4", formulation="reduced")
    whole = Recorder()
    simulate(system, state, replace(settings, duration=steps * step, output_step=step), whole)
    for at in (13, 37):
        place, turn, v, w = (
            whole[f"bodies/{each}"][at] for each in ("position", "orientation", "velocity", "angular_velocity")
        )
        bodies = tuple(
            replace(body, start=(tuple(r), tuple(q)), velocity=tuple(own), angular_velocity=tuple(spin))
            for body, r, q, own, spin in zip(scene.bodies, place, turn, v, w, strict=True)
        )
        joints = tuple(replace(joint, speed={}) for joint in scene.joints)
        system, state = assembled(replace(scene, bodies=bodies, joints=joints))
        again = Recorder()
        simulate(system, state, replace(settings, duration=(steps - at) * step, output_step=step), again)
        assert np.abs(again["bodies/position"] - whole["bodies/position"][at:]).max() < 1e-12


@needs_kernel
def test_where_the_scene_draws_no_closed_mechanism_the_start_tells_the_rows():
    """Its bars are drawn where no pose closes; bodies' poses at the start close it."""
    compiled, state = compiled_of(restarted("bricard"))
    broken = replace(compiled.system, drawn=np.where(np.arange(35) % 7 < 3, 1e3, compiled.system.drawn))
    other = Reduced(core(), broken)
    assert settle_rows(other, state) == 1
    assert other.model.rows.left_out
