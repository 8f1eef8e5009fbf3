"""A ball and a wheel that slip and roll on a plane, level or inclined, with Stribeck's friction in most of them.

With the slip u of the lowest point as a coordinate of its own, which is 0 to round-off where it rolls:
m v' = Q - μ N u/|u|,  u' = v' - μ N (u/|u|) r²/J - T × n r/J,  N = m g·n - Fz.
"""

from __future__ import annotations

from math import pi, sin
from typing import Any

from mbproj.base.arrays import Array

from .independent import Solution, solve
from .scene import GRAVITY, Case, Draw, Load, scene_text


def ball(seed: int) -> Case:
    """A ball that is thrown, pushed and turned, with any spin about the normal, which acts on nothing."""
    draw, duration = Draw("ball", seed), 0.8
    settings = draw.settings(duration)
    m, r = draw.decades(-1, 1), draw.number(0.03, 0.3)
    J, law, lean = _inertia(draw, m, r), draw.law(), draw.pick(0.0, draw.number(0, 0.5))
    down = GRAVITY * sin(lean), -GRAVITY * sin(pi / 2 - lean)
    grip = -m * down[1]
    Fx, Fy, Fz, Tx, Ty = (draw.load(law.static * grip * size) for size in (1.0, 1.0, 0.2, r, r))
    if draw.chance(0.3):
        Fx = Fy = Tx = Ty = Load(0.0)
    start = [0.0] * 4 if draw.chance(0.3) else [draw.number(-2, 2) for _ in range(4)]  # of v and r ω × n
    spin = draw.number(-5, 5)

    def rate(t: float, s: Array, width: float) -> list[float]:
        _, _, vx, vy, ux, uy = s
        rub = law.drag(width, ux, uy) * (grip - Fz(t))
        ax, ay = (Fx(t) - rub * ux) / m + down[0], (Fy(t) - rub * uy) / m
        turn = r / J
        return [vx, vy, ax, ay, ax - turn * (r * rub * ux + Ty(t)), ay - turn * (r * rub * uy - Tx(t))]

    def look(t: float, s: Array, width: float) -> tuple[list[float], float]:
        return [s[0], s[1], s[2], s[3]], grip - Fz(t)

    def answer(at: Array) -> Solution:
        vx, vy, sx, sy = start
        return solve(rate, look, [0.0, 0.0, vx, vy, vx - sx, vy - sy], at)

    centre = draw.to_global(0, 0, r)
    velocity, turning = draw.to_global(start[0], start[1], 0), draw.to_global(-start[3] / r, start[2] / r, spin)
    body = {"mass": m, "inertia": [J, J, J], "position": centre, "velocity": velocity, "angular_velocity": turning}
    floor = draw.stop("ball", [0, 0, r], law, radius=r)
    forces: dict[str, Any] = {"floor": floor}
    forces["push"] = {"type": "force", "body": "ball", "force": draw.components(Fx, Fy, Fz)}
    forces["turn"] = {"type": "torque", "body": "ball", "torque": draw.components(Tx, Ty, 0.0)}
    text = scene_text(draw, settings, draw.to_global(down[0], 0, down[1]), bodies={"ball": body}, forces=forces)
    floor_axes = ((1, 0, 0), (0, 1, 0))
    watched = tuple(draw.watch(f"bodies/{of}", "ball", *way) for of in ("position", "velocity") for way in floor_axes)
    return Case("ball", text, settings, answer, watched, {"floor": law})


def wheel(seed: int) -> Case:
    """A wheel that a planar joint keeps upright, with a torque on it and a spring on its axle."""
    draw, duration = Draw("wheel", seed), 0.8
    settings = draw.settings(duration)
    m, r = draw.decades(-1, 1), draw.number(0.03, 0.3)
    J, law, lean = _inertia(draw, m, r), draw.law(), draw.pick(0.0, draw.number(-0.5, 0.5))
    down = GRAVITY * sin(lean), -GRAVITY * sin(pi / 2 - lean)
    grip = -m * down[1]
    F, Fz, T = (draw.load(law.static * grip * size) for size in (1.0, 0.2, 2.0 * r))
    k = draw.pick(0.0, draw.decades(1, 3))
    v, turned = (0.0, 0.0) if draw.chance(0.4) else (draw.number(-2, 2), draw.number(-2, 2))

    def rate(t: float, s: Array, width: float) -> list[float]:
        x, v, u = s
        friction = -law.drag(width, u) * (grip - Fz(t)) * u
        a = (F(t) - k * x + friction) / m + down[0]
        return [v, a, a + r / J * (r * friction - T(t))]

    def look(t: float, s: Array, width: float) -> tuple[list[float], float]:
        return [s[0], s[1], (s[1] - s[2]) / r], grip - Fz(t)

    def answer(at: Array) -> Solution:
        return solve(rate, look, [0.0, v, v - turned], at)

    centre, axis = draw.to_global(0, 0, r), draw.to_global(0, 1, 0)
    speeds = {"displacement_x": v, "displacement_y": 0, "angle": turned / r}
    plane = {"type": "planar", "bodies": ["ground", "wheel"], "location": centre, "axis": axis}
    joints = {"plane": plane | {"x_axis": draw.to_global(1, 0, 0), "speed": speeds}}
    forces: dict[str, Any] = {"floor": draw.stop("wheel", [0, 0, r], law, radius=r, axis=axis)}
    forces["push"] = {"type": "force", "body": "wheel", "force": draw.components(F, 0.0, Fz)}
    forces["turn"] = {"type": "torque", "body": "wheel", "torque": draw.components(0.0, T, 0.0)}
    if k:
        spring = {"type": "linear_spring_damper", "joint": "plane", "coordinate": "displacement_x", "stiffness": k}
        forces["spring"] = spring
    bodies = {"wheel": {"mass": m, "inertia": [J, J, J], "position": centre}}
    gravity = draw.to_global(down[0], 0, down[1])
    text = scene_text(draw, settings, gravity, bodies=bodies, joints=joints, forces=forces)
    watched = (
        draw.watch("bodies/position", "wheel", 1, 0, 0),
        draw.watch("bodies/velocity", "wheel", 1, 0, 0),
        draw.watch("bodies/angular_velocity", "wheel", 0, 1, 0),
    )
    return Case("wheel", text, settings, answer, watched, {"floor": law})


def _inertia(draw: Draw, m: float, r: float) -> float:
    """Of a shell, of a solid, or of much less."""
    return float(f"{m * r * r * draw.decades(-2, -0.17):.4g}")
