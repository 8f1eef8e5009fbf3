"""The mechanisms: each with its scene, its exact motion, where its error is measured, and the steps that are tried."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import cos, pi, radians, sin
from pathlib import Path
from typing import Any

import numpy as np

from mbproj.scene.scene import Scene, read_scene, read_scene_text

from .compiled import by_gauss, by_rattle
from .exact import PI, Real, angle_of, axis_of_top

Array = np.ndarray
MECHANISMS = Path(__file__).parents[2] / "mechanisms"
MS = 1e-3


@dataclass(frozen=True, eq=False)
class Case:
    """A mechanism. `exact`: where it is after t s, (k,) in `unit`, and how certain that is; `seen`: the same of
    results; `reached`: of a state of Gauss's methods on system `which` with `parts` from `start`; `turned`: of RATTLE,
    whose first body turns as two numbers of its `column` say. `steps` in ms by method."""

    name: str
    freedoms: int
    unit: str
    scene: Scene
    exact: Callable[[float], tuple[Array, float]]
    seen: Callable[[Any], Array]
    which: int
    parts: Sequence[float]
    start: Sequence[float]
    reached: Callable[[Array], Array]
    turned: Callable[[float, Array], Array]
    steps: Mapping[str, Sequence[float]]
    moments: Sequence[Sequence[float]] = ()
    column: Sequence[int] = (3, 5)

    def by_gauss(self, order: int, span: float, steps: int) -> tuple[Array, int]:
        """Where it is after a span, and the evaluations."""
        y, evaluations = by_gauss(self.which, self.parts, order, self.start, span, steps)
        return self.reached(y), evaluations

    def by_rattle(self, span: float, steps: int) -> tuple[Array, int]:
        angle, q = by_rattle(self.scene, span, steps, (0, *self.column), self.moments, hinged=self.freedoms == 3)
        return self.turned(angle, q), steps


def _angle(results: Any) -> Array:
    return np.asarray(results["joints/coordinate"])[-1, :1]


def _centre(results: Any) -> Array:
    return np.asarray(results["markers/position"])[-1, 0]


def crank_rocker() -> Case:
    """Two bars' moments out of the plane are others for RATTLE, whose mass matrix a flat body makes singular."""
    a, b, c, d = (Real(x) / 100 for x in (10, 30, 25, 30))
    (m1, J1), (m2, J2), (m3, J3) = ((Real(m) / 100, Real(J) / 10000) for m, J in ((200, 100), (30, 24), (25, 13)))
    g = Real(981) / 100

    def angles(φ: Array) -> tuple[Array, ...]:
        x, z = d - a * np.cos(φ), -a * np.sin(φ)
        span2 = x * x + z * z
        ψ = np.arctan2(z, x) + np.arccos((b * b + span2 - c * c) / (2 * b * np.sqrt(span2)))
        χ = np.arctan2(a * np.sin(φ) + b * np.sin(ψ), a * np.cos(φ) + b * np.cos(ψ) - d)
        return ψ, χ, a * np.sin(χ - φ) / (b * np.sin(ψ - χ)), a * np.sin(ψ - φ) / (c * np.sin(ψ - χ))

    def inertia(φ: Array) -> Array:
        ψ, _, ψ1, χ1 = angles(φ)
        coupler = (J2 + m2 * b * b / 4) * ψ1 * ψ1 + m2 * (a * a + a * b * np.cos(φ - ψ) * ψ1)
        return J1 + m1 * a * a / 4 + coupler + (J3 + m3 * c * c / 4) * χ1 * χ1

    def potential(φ: Array) -> Array:
        ψ, χ, _, _ = angles(φ)
        return g * (m1 * a / 2 * np.sin(φ) + m2 * (a * np.sin(φ) + b / 2 * np.sin(ψ)) + m3 * c / 2 * np.sin(χ))

    start = PI / 3
    return Case(
        name="crank-rocker",
        freedoms=1,
        unit="rad",
        scene=read_scene(MECHANISMS / "planar_four_bar.yaml"),
        exact=lambda t: (np.array([angle_of(inertia, potential, start, 12.0, t) - float(start)]), 1e-9),
        seen=_angle,
        which=0,
        parts=(),
        start=(float(start), float(inertia(start) * 12)),
        reached=lambda y: y[:1] - float(start),
        turned=lambda angle, q: np.array([angle]),
        steps={
            "dop853": (40, 20, 10, 5),
            "rk4": (20, 10, 5),
            "Gauss 4": (20, 10, 5),
            "Gauss 6": (40, 20, 10),
            "Gauss 8": (40, 20, 10),
            "RATTLE": (20, 10),
        },
        moments=((0.01, 0.01, 0.01), (1e-4, 2.4e-3, 2.4e-3), (1e-5, 1.3e-3, 1.3e-3)),
    )


def slider_crank() -> Case:
    r, L, rod, slider, crank, along, across, g = (
        Real(x) for x in ("0.08", "0.3", "0.5", "2", "1e-4", "4e-4", "4e-3", "9.8")
    )
    y0, z0 = Real(1) / 10, Real(12) / 100

    def inertia(p: Array) -> Array:
        y, z = y0 - r * np.sin(p), z0 + r * np.cos(p)
        s = np.sqrt(L * L - y * y - z * z)
        s1 = r * (y0 * np.cos(p) + z0 * np.sin(p)) / s
        f1 = r * (z0 * np.cos(p) - y0 * np.sin(p) + r) / (y * y + z * z)
        common, spin = rod / 4 + across / (L * L), along / (L * L)
        return crank + common * (s1 * s1 + r * r) + slider * s1 * s1 + spin * s * s * f1 * f1

    return Case(
        name="spatial slider-crank",
        freedoms=1,
        unit="rad",
        scene=read_scene(MECHANISMS / "spatial_slider_crank.yaml"),
        exact=lambda t: (
            np.array([angle_of(inertia, lambda p: rod * g * r * np.cos(p) / 2, Real(0), 6.0, t)]),
            1e-9,
        ),
        seen=_angle,
        which=1,
        parts=(),
        start=(0.0, float(inertia(Real(0)) * 6)),
        reached=lambda y: y[:1],
        turned=lambda angle, q: np.array([angle]),
        steps={
            "dop853": (20, 10, 5),
            "rk4": (10, 5, 2.5),
            "Gauss 4": (10, 5, 2.5),
            "Gauss 6": (20, 10, 5),
            "Gauss 8": (20, 10, 5),
            "RATTLE": (20, 10),
        },
        column=(10, 11),
    )


def heavy_top() -> Case:
    """It nods: its spin is 50 rad/s below that of steady precession."""
    scene = read_scene(MECHANISMS / "heavy_top.yaml", {"excess": "-50"})
    body, θ, precession = scene.bodies[0], radians(30.0), 1.5136100923704108
    A, C, weight = body.inertia[0][0] + 15.0, body.inertia[2][2], 15.0 * 9.81
    axial = body.angular_velocity[2]
    along = C * axial
    vertical = A * sin(θ) ** 2 * precession + along * cos(θ)
    flat = (A, A, C)

    def axis(y: Array) -> Array:
        side = np.sin(y[0]) * np.array([-np.sin(y[1]), np.cos(y[1])])
        return np.append(side, np.cos(y[0]))

    return Case(
        name="heavy top",
        freedoms=3,
        unit="m",
        scene=scene,
        exact=lambda t: (axis_of_top(A, C, weight, θ, (precession, axial), t), 1e-9),
        seen=_centre,
        which=2,
        parts=(A, C, weight),
        start=(θ, 0.0, 0.0, 0.0, vertical, along),
        reached=axis,
        turned=lambda angle, q: q[0, 9:12],
        steps={
            "dop853": (4, 2, 1),
            "rk4": (2, 1),
            "Gauss 4": (40, 20),
            "Gauss 6": (80, 40, 20),
            "Gauss 8": (160, 80, 40),
            "RATTLE": (2, 1),
        },
        moments=(flat,),
    )


def _chain(name: str, scene: Scene, bars: int, J: float, start: float, down: float, finest: int) -> Case:
    """Bars in a row from rest, all at `start` from hanging; that is `down` from the x axis, rad."""
    way, side = np.array([cos(down), 0.0, -sin(down)]), np.array([sin(down), 0.0, cos(down)])
    g = float(np.linalg.norm(scene.gravity))
    parts, begin = (bars, J, g), (*[start] * bars, *[0.0] * bars)

    def tip(y: Array) -> Array:
        θ = y[:bars]
        return np.cos(θ).sum() * way + np.sin(θ).sum() * side

    def exact(t: float) -> tuple[Array, float]:
        """By the Gauss method of order 12 in extended precision, and how far steps of twice the size lead from that."""
        fine, coarse = (
            tip(by_gauss(3, parts, 12, begin, t, max(round(t * each), 1), extended=True)[0])
            for each in (finest, finest // 2)
        )
        return fine, float(np.abs(fine - coarse).max())

    return Case(
        name=name,
        freedoms=bars,
        unit="m",
        scene=scene,
        exact=exact,
        seen=_centre,
        which=3,
        parts=parts,
        start=begin,
        reached=tip,
        turned=lambda angle, q: _end_of(q[:, :3]),
        steps={
            "dop853": (40, 20, 10),
            "rk4": (20, 10, 5),
            "Gauss 4": (20, 10, 5),
            "Gauss 6": (40, 20, 10),
            "Gauss 8": (40, 20),
            "RATTLE": (20, 10),
        },
    )


def _end_of(places: Array) -> Array:
    """The tip from the centres of bars of 1 m."""
    joint = np.zeros(3)
    for place in places:
        joint = 2.0 * place - joint
    return np.asarray(joint)


def _finest(start: float) -> int:
    """Steps a second of the reference: swings from large angles are chaotic, and have fast events."""
    return 50 if start < 45.0 else 2000


def double_pendulum(start: float = 20.0) -> Case:
    given = {"start_upper": f"{start} deg", "start_lower": f"{start} deg"}
    scene = read_scene(MECHANISMS / "double_pendulum.yaml", given)
    return _chain("double pendulum", scene, 2, 1.0 / 12.0, radians(start), pi / 2, _finest(start))


def five_bar(start: float = 10.0) -> Case:
    """Gravity is turned, so that the bars, which lie along x, hang at `start` degrees."""
    down = pi / 2 - radians(90.0 - start)
    text = (MECHANISMS / "five_bar.yaml").read_text(encoding="utf-8")
    gravity = f"gravity: [{9.8 * cos(down)!r}, 0, {-9.8 * sin(down)!r}]"
    scene = read_scene_text(text.replace("gravity: [0, 0, -9.8]", gravity).partition("expect:")[0])
    return _chain("five-bar pendulum", scene, 5, 1.01 / 12.0, radians(start), down, _finest(start))


CASES = (crank_rocker, slider_crank, heavy_top, double_pendulum, five_bar)
