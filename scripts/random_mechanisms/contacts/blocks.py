"""A body on feet in a row, or on three or four feet, which share its weight; a belt below it."""

from __future__ import annotations

from math import cos, sin
from typing import Any

import numpy as np

from mbproj.base.arrays import Array

from .independent import Solution, solve
from .scene import GRAVITY, Case, Draw, Load, scene_text


def block(seed: int) -> Case:
    """A block kept in a plane on two to four feet in a row, of any inertia, pushed at any height; on a belt that moves,
    and held by a spring, or on the ground.

    m x'' = Fx - k x + R,  R = -(c₁ N₁ + c₂ N₂) u,  u = x' less the belt's speed,  c = μ(|u|)/|u|
    N₁ + N₂ = m g - Fz,  Σ (h cᵢ u - xᵢ) Nᵢ + p Fx = 0, moments about the centre of mass

    Feet with the same law share the load at will: those at the ends stand for all, as long as both push.
    """
    draw, duration = Draw("block", seed), 0.8
    settings = draw.settings(duration)
    m, h = draw.decades(-0.5, 1.3), draw.number(0.01, 0.12)
    J = m * draw.decades(-4, -1)
    count = draw.pick(2, 2, 2, 3, 4)
    places = sorted(draw.number(-0.4, 0.4) for _ in range(count))
    places[0], places[-1] = min(places[0], -0.1), max(places[-1], 0.1)
    laws = [draw.law()] * count
    if count == 2 and draw.chance(0.4):
        laws = [draw.law(plain=True), draw.law(plain=True)]
    W = m * GRAVITY
    scale = W * max(law.static for law in laws)
    Fx, Fz, p = draw.load(scale, 0.8), draw.load(0.1 * W), draw.number(-1, 1) * min(h, 0.05)
    on_belt = draw.chance(0.4)
    k = draw.decades(1, 3) if on_belt or draw.chance(0.3) else 0.0
    V0, A, w = (draw.number(-0.3, 0.3), draw.number(0.05, 0.3), draw.number(3, 15)) if on_belt else (0.0, 0.0, 1.0)
    begin = V0 + A * w if on_belt else draw.pick(0.0, draw.number(-1, 1))
    ends, rubs = (places[0], places[-1]), (laws[0], laws[-1])

    def pushes(t: float, x: float, u: float, width: float) -> tuple[float, float, float, float]:
        """N₁, N₂, R and the force along x besides."""
        c = [law.drag(width, u) * u for law in rubs]
        a, b = (h * each - place for each, place in zip(c, ends, strict=True))
        weight, load = W - Fz(t), Fx(t)
        first = (-p * load - b * weight) / (a - b)
        held = min(max(first, 0.0), weight)  # where a foot lifts off, this ends to hold: no more than a bound is wanted
        return first, weight - first, -c[0] * held - c[1] * (weight - held), load - k * x

    def rate(t: float, s: Array, width: float) -> list[float]:
        x, u = s
        _, _, friction, push = pushes(t, x, u, width)
        return [u + V0 + A * w * cos(w * t), (friction + push) / m + A * w * w * sin(w * t)]

    def look(t: float, s: Array, width: float) -> tuple[list[float], float]:
        first, second, _, _ = pushes(t, s[0], s[1], width)
        return [s[0], s[1] + V0 + A * w * cos(w * t)], min(first, second)

    def answer(at: Array) -> Solution:
        return solve(rate, look, [0.0, begin - V0 - A * w], at)

    centre = draw.to_global(0, 0, h)
    bodies: dict[str, Any] = {"block": {"mass": m, "inertia": [J, J, J], "position": centre}}
    axis, x_axis = draw.to_global(0, 1, 0), draw.to_global(1, 0, 0)
    speeds = {"displacement_x": begin, "displacement_y": 0, "angle": 0}
    joints: dict[str, Any] = {
        "plane": {"type": "planar", "bodies": ["ground", "block"], "location": centre, "axis": axis}
        | {"x_axis": x_axis, "speed": speeds}
    }
    forces: dict[str, Any] = {
        f"foot{i}": draw.stop("block", [x, 0, 0], law, on="belt" if on_belt else "ground")
        for i, (x, law) in enumerate(zip(places, laws, strict=True))
    }
    at = draw.to_global(0, 0, h + p)
    forces["push"] = {"type": "force", "body": "block", "location": at, "force": draw.components(Fx, 0.0, 0.0)}
    forces["lift"] = {"type": "force", "body": "block", "force": draw.components(0.0, 0.0, Fz)}
    if k:
        forces["spring"] = {"type": "linear_spring_damper", "joint": "plane", "coordinate": "displacement_x"} | {
            "stiffness": k
        }
    motions = {}
    if on_belt:
        bodies["belt"] = {"mass": 1, "inertia": [1, 1, 1], "position": draw.to_global(0, 0, -0.1)}
        joints["rail"] = {"type": "prismatic", "bodies": ["ground", "belt"], "location": [0, 0, 0], "axis": x_axis}
        joints["rail"] |= {"speed": V0 + A * w}
        motions["runs"] = {"joint": "rail", "displacement": f"{V0!r}*t + {A!r}*sin({w!r}*t)"}
    down = draw.to_global(0, 0, -GRAVITY)
    text = scene_text(draw, settings, down, bodies=bodies, joints=joints, motions=motions, forces=forces)
    watched = tuple(draw.watch(f"bodies/{of}", "block", 1, 0, 0) for of in ("position", "velocity"))
    named = {f"foot{i}": law for i, law in enumerate(laws)}
    return Case("block", text, settings, answer, watched, named)


def plate(seed: int) -> Case:
    """A plate on three feet anywhere, of any inertia about the normal, pushed at any point: it slides and turns; or on
    four feet of a rectangle, pushed through the middle.

    Its height, roll and pitch are held: the pushes follow from the vertical force and the moments about x and y.
    """
    draw, duration = Draw("plate", seed), 0.6
    settings = draw.settings(duration)
    m, h = draw.decades(-0.5, 1.3), draw.number(0.005, 0.05)
    J = m * draw.decades(-3.5, -0.5)
    straight = draw.chance(0.25)
    law = draw.law(plain=not straight)
    W = m * GRAVITY
    scale = law.static * W
    if straight:
        a, b = draw.number(0.1, 0.4), draw.number(0.1, 0.4)
        feet = [[a, b], [-a, b], [-a, -b], [a, -b]]
        turned, px, py = draw.number(-3, 3), 0.0, 0.0
        along = draw.load(scale, 0.8)
        Fx, Fy = (Load(short * along.a, short * along.b, short * along.c, along.w, along.p) for short in _unit(turned))
        v = draw.pick(0.0, draw.number(-1, 1))
        begin = [v * each for each in _unit(turned)] + [0.0]
    else:
        start, gap = draw.number(-3, 3), [draw.number(-0.4, 0.4) for _ in range(3)]
        feet = [[draw.number(0.1, 0.4) * f(start + 2.0944 * i + g) for f in (cos, sin)] for i, g in enumerate(gap)]
        px, py = draw.number(-0.05, 0.05), draw.number(-0.05, 0.05)
        Fx, Fy = draw.load(scale, 0.6), draw.load(scale, 0.6)
        begin = [0.0] * 3 if draw.chance(0.5) else [draw.number(-1, 1), draw.number(-1, 1), draw.number(-3, 3)]
    corners = np.array(feet)

    def motion(t: float, s: Array, width: float) -> tuple[list[float], list[float]]:
        """(x'', y'', ψ''), and the pushes."""
        _, _, psi, vx, vy, spin = s
        c, n = cos(psi), sin(psi)
        if straight:
            mu = law.drag(width, vx, vy)
            push = Fx(t), Fy(t)
            tilt = [h * (mu * W * each) for each in (vx, vy)]  # the load acts at the centre of mass
            pushes = [W / 4.0 + (tilt[0] * x / (4 * a * a) + tilt[1] * y / (4 * b * b)) for x, y in _around(feet, c, n)]
            return [(push[0] - mu * W * vx) / m, (push[1] - mu * W * vy) / m, 0.0], pushes
        places = _around(feet, c, n)
        drags = []
        for x, y in places:
            ux, uy = vx - spin * y, vy + spin * x
            mu = law.drag(width, ux, uy)
            drags.append((mu * ux, mu * uy))
        # the force of a foot is N (-dx, -dy, 1) at (x, y, -h): the vertical force, the moments about x and y
        rows = np.array(
            [
                [1.0, 1.0, 1.0],
                [y - h * dy for (x, y), (dx, dy) in zip(places, drags, strict=True)],
                [h * dx - x for (x, y), (dx, dy) in zip(places, drags, strict=True)],
            ]
        )
        pushes = np.linalg.solve(rows, [W, 0.0, 0.0]).tolist()
        held = [min(max(N, 0.0), W) for N in pushes]
        fx, fy = (-sum(N * d[k] for N, d in zip(held, drags, strict=True)) for k in (0, 1))
        torque = sum(N * (y * dx - x * dy) for N, (x, y), (dx, dy) in zip(held, places, drags, strict=True))
        gx, gy, arm_x, arm_y = Fx(t), Fy(t), c * px - n * py, n * px + c * py
        torque += arm_x * gy - arm_y * gx
        return [(gx + fx) / m, (gy + fy) / m, torque / J], pushes

    def rate(t: float, s: Array, width: float) -> list[float]:
        return [*s[3:], *motion(t, s, width)[0]]

    def look(t: float, s: Array, width: float) -> tuple[list[float], float]:
        return [s[0], s[1], s[5]], min(motion(t, s, width)[1])

    def answer(at: Array) -> Solution:
        return solve(rate, look, [0.0, 0.0, 0.0, *begin], at)

    centre = draw.to_global(0, 0, h)
    body = {"mass": m, "inertia": [J, J, J], "position": centre, "velocity": draw.to_global(begin[0], begin[1], 0)}
    body |= {"angular_velocity": draw.to_global(0, 0, begin[2])}
    forces = {f"foot{i}": draw.stop("plate", [x, y, 0], law) for i, (x, y) in enumerate(corners.tolist())}
    at = draw.to_global(px, py, h)
    forces["push"] = {"type": "force", "body": "plate", "location": at, "force": draw.components(Fx, Fy, 0.0)}
    text = scene_text(draw, settings, draw.to_global(0, 0, -GRAVITY), bodies={"plate": body}, forces=forces)
    watched = (
        draw.watch("bodies/position", "plate", 1, 0, 0),
        draw.watch("bodies/position", "plate", 0, 1, 0),
        draw.watch("bodies/angular_velocity", "plate", 0, 0, 1),
    )
    return Case("plate", text, settings, answer, watched, {name: law for name in forces if "foot" in name})


def _unit(angle: float) -> tuple[float, float]:
    return cos(angle), sin(angle)


def _around(feet: list[list[float]], c: float, n: float) -> list[tuple[float, float]]:
    """The feet from the centre of mass, turned."""
    return [(c * x - n * y, n * x + c * y) for x, y in feet]
