"""The extremes, as data: mechanism, exact motion, values."""

from __future__ import annotations

from functools import partial
from math import sqrt

import numpy as np

from mbproj.equations.assembly.assemble import State
from mbproj.model.system import System

from .mechanisms import PARALLELOGRAM, TOP, TWO_PINS, WHEEL, axis_of_top, chain, pendulum, swinging
from .trial import Done, Extreme

DECADES = (1e-12, 1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9, 1e12)
ENDS = (1e-12, 1e12)


def swing_error(done: Done, value: float = 0.0) -> float:
    """The largest error of the pendulum's angle, rad, and of its first angular acceleration, relative to K/I."""
    scene, joint = done.scene.parameters, "pin.angle" if "bar" in done.scene.parameters else "A.angle"
    body = "bar" if joint == "pin.angle" else "left"
    I, K = pendulum(scene)
    start = scene["start"]
    exact = swinging(start, sqrt(K / I), done["time"])
    angle = float(np.abs(scene["start"] - done.of("joints/coordinate", joint) - exact).max())
    first = -done.of("bodies/angular_acceleration", body)[0, 1]
    return max(angle, abs(first + K / I * np.sin(start)) / (K / I))


def wheel_error(done: Done, value: float = 0.0) -> float:
    """The same, and the error of the wheel's rate relative to the larger of spin and pendulum's frequency."""
    I, K = pendulum(done.scene.parameters)
    spin = done.scene.parameters["spin"]
    rate = done.of("joints/speed", "pin.angle") + done.of("joints/speed", "axle.angle")
    return max(swing_error(done), float(np.abs(rate - spin).max()) / max(spin, sqrt(K / I)))


def _step(length: float = 1.0) -> float:
    """h with h ω = 0.1 for small swings of the mechanism of that length, at most."""
    return 0.1 / sqrt(1.5 * 9.81 / length)


def _top_error(done: Done, value: float) -> float:
    """Of the direction of the top's axis, rad."""
    found = done["bodies/position"][:, 0] / done.scene.parameters["height"]
    return float(np.abs(found - axis_of_top(done.scene.parameters, done["time"])).max())


def _held_error(done: Done, value: float, *, tells: float = 1e-8) -> float:
    """Two pins out of line lock the bar; what is below round-off's reach of parallel may swing as on one."""
    assert done.report is not None
    if done.report.degrees_of_freedom == 2:
        return swing_error(done) if value <= tells else float("inf")
    moved = float(np.abs(done["bodies/position"] - done["bodies/position"][0]).max())
    return moved if value > 0.0 else float("inf")


def _chain_error(done: Done, value: float) -> float:
    """Of the bodies' places on their circles, and of the first joint's tension, both relative."""
    x = np.array([body.position[0] for body in done.scene.bodies])
    mass = np.array([body.mass for body in done.scene.bodies])
    t = done["time"][:, None]
    exact = np.stack([x * np.cos(t), x * np.sin(t), 0.0 * x * t], axis=-1)
    tension = np.linalg.norm(done.of("joints/reaction_force", "J0"), axis=-1)
    return max(float(np.abs(done["bodies/position"] - exact).max()), float(np.abs(tension / (mass @ x) - 1.0).max()))


def _chain_step(links: int, heavy: float) -> float:
    """h with h ω = 0.1 for the quickest wave of a light link under the tension of the heavy one."""
    return 0.05 / sqrt(1.0 + (heavy + 1e-3 * links) * links / 1e-3)


def _opened(system: System, state: State, value: float, *, in_plane: bool = False) -> State:
    """Every body moved by `value` of a link and turned by as many radians; `in_plane`: that of x and z."""
    pose, rng = state.q.reshape(-1, 7).copy(), np.random.default_rng(3)
    keep = np.array([1.0, 0.0, 1.0]) if in_plane else np.ones(3)
    for body in pose:
        move, turn = (keep * rng.normal(size=3), (1.0 - keep if in_plane else keep) * rng.normal(size=3))
        body[:3] += value * move / np.linalg.norm(move)
        x, y, z = 0.5 * value * turn / np.linalg.norm(turn)
        a, b, c, d = body[3:]
        body[3:] += [-x * b - y * c - z * d, x * a + y * d - z * c, y * a + z * b - x * d, z * a + x * c - y * b]
        body[3:] /= np.linalg.norm(body[3:])
    return state.changed(positions=pose.ravel())


def _closing_error(done: Done, value: float) -> float:
    """How far the joints are open after the first step on, in m or rad, and the bodies have gone, beyond ten gaps."""
    gone = float(np.abs(done["bodies/position"][1] - done["bodies/position"][0]).max())
    return max(float(done["diagnostics/position_violation"][1:].max()), max(0.0, gone - 10.0 * value))


def _long_error(done: Done, value: float) -> float:
    """Of the swing; infinite where the times are not t = k h to the last bit."""
    assert done.report is not None and done.report.settings.step is not None
    h = done.report.settings.step
    inner = done["time"][:-1]
    return swing_error(done) if np.array_equal(inner, np.round(inner / h) * h) else float("inf")


def _swing(parameters: dict[str, float], text: str = PARALLELOGRAM) -> tuple[str, dict[str, str]]:
    return text, {name: repr(float(value)) for name, value in parameters.items()}


EXTREMES: dict[str, Extreme] = {
    extreme.name: extreme
    for extreme in (
        Extreme(
            "mass of the outer body",
            lambda r: _swing({"wheel": r}, WHEEL),
            lambda r: (30, _step()),
            wheel_error,
            DECADES,
            ENDS,
        ),
        Extreme(
            "mass of the inner body",
            lambda r: _swing({"bar": r}, WHEEL),
            lambda r: (30, _step()),
            wheel_error,
            DECADES,
            ENDS,
        ),
        Extreme(
            "inertia of the outer body",
            lambda r: _swing({"moment": r}, WHEEL),
            lambda r: (30, _step()),
            wheel_error,
            DECADES,
            (1e-12, 1e9, 1e12),
        ),
        Extreme(
            "mass of the coupler in a loop",
            lambda r: _swing({"coupler": r}),
            lambda r: (30, _step()),
            swing_error,
            DECADES,
            ENDS,
        ),
        Extreme(
            "mass of one crank in a loop",
            lambda r: _swing({"right": r}),
            lambda r: (30, _step()),
            swing_error,
            DECADES,
            ENDS,
        ),
        Extreme(
            "all masses",
            lambda r: _swing({"left": r, "coupler": r, "right": r}),
            lambda r: (30, _step()),
            swing_error,
            DECADES,
            ENDS,
        ),
        Extreme(
            "masses to zero",
            lambda r: _swing({"coupler": r}),
            lambda r: (30, _step()),
            swing_error,
            (1e-20, 1e-100, 1e-300, 0.0),
            (1e-300, 0.0),
        ),
        Extreme(
            "lengths",
            lambda L: _swing({"length": L}),
            lambda L: (30, _step(L)),
            swing_error,
            (1e-6, 1e-4, 1e-2, 1.0, 1e2, 1e4, 1e6),
            (1e-6, 1e6),
        ),
        Extreme(
            "length of the coupler",
            lambda L: _swing({"reach": L}),
            lambda L: (30, _step()),
            swing_error,
            (1e-6, 1e-3, 1.0, 1e3, 1e6),
            (1e-6, 1e6),
        ),
        Extreme(
            "spin of a wheel",
            lambda w: _swing({"spin": w}, WHEEL),
            lambda w: (60, 0.1 / max(w, 3.9)),
            wheel_error,
            (1.0, 1e3, 1e6),
            (1e6,),
        ),
        Extreme(
            "spin of a top",
            lambda w: _swing({"spin": w}, TOP),
            lambda w: (60, 0.1 / w),
            _top_error,
            (1.0, 1e3, 1e6),
            (1e6,),
            formulations=("full", "reduced"),
        ),
        Extreme(
            "step times frequency",
            lambda x: _swing({}),
            lambda x: (30, x * 10.0 * _step()),
            swing_error,
            (0.1, 0.3, 1.0, 2.0, 3.0, 10.0, 100.0, 1e6),
            (1.0, 10.0, 100.0),
            right=1e-3,
        ),
        Extreme(
            "start open in the plane",
            lambda r: _swing({}),
            lambda r: (3, 1e-6),
            _closing_error,
            (1e-6, 1e-3, 0.1),
            (0.1,),
            start=partial(_opened, in_plane=True),
            right=1e-3,
        ),
        Extreme(
            "start open in space",
            lambda r: _swing({}),
            lambda r: (3, 1e-6),
            _closing_error,
            (1e-6, 1e-3, 0.1),
            (0.1,),
            formulations=("full", "reduced"),
            start=_opened,
            right=1e-3,
        ),
        Extreme(
            "angle between axes",
            lambda r: _swing({"tilt": r}, TWO_PINS),
            lambda r: (30, _step()),
            _held_error,
            (0.0, 1e-15, 1e-13, 1e-11, 1e-10, 1e-9, 1e-8, 1e-6, 1e-3),
            (1e-15, 1e-3),
            slack=lambda r: min(r, 1e-8),
        ),
        Extreme(
            "distance of a joint's double",
            lambda r: _swing({"offset": r}, TWO_PINS),
            lambda r: (30, _step()),
            _held_error,
            (0.0, 1e-15, 1e-13, 1e-11, 1e-10, 1e-9, 1e-8, 1e-6, 1e-3),
            (0.0, 1e-15, 1e-3),
            slack=lambda r: min(r, 1e-8),
        ),
        Extreme(
            "heavy end of a chain of 20",
            lambda r: (chain(20, 1e-3 * r), {}),
            lambda r: (20, _chain_step(20, 1e-3 * r)),
            _chain_error,
            (1.0, 1e3, 1e6, 1e9, 1e12),
            ENDS[1:],
        ),
        Extreme(
            "heavy end of a chain of 1000",
            lambda r: (chain(1000, 1e-3 * r), {}),
            lambda r: (20, _chain_step(1000, 1e-3 * r)),
            _chain_error,
            (1.0, 1e3, 1e6, 1e9, 1e12),
            ENDS[1:],
            formulations=("reduced", "planar"),
        ),
        # The phase runs away by the drift of the energy times the time, however well the joints are closed.
        Extreme(
            "steps in the kernel",
            lambda n: _swing({}),
            lambda n: (int(n), _step()),
            _long_error,
            (1e5, 1e6, 1e7),
            (1e4,),
            formulations=("reduced", "planar"),
            right=1e-3,
            limit=600.0,
        ),
        Extreme(
            "steps of the full formulation",
            lambda n: _swing({}),
            lambda n: (int(n), _step()),
            _long_error,
            (1e3, 1e4, 1e5),
            (100.0,),
            formulations=("full",),
            right=1e-3,
            limit=3600.0,
        ),
    )
}
