"""A point on an xy stage that rubs on a floor: carriages with masses of their own, a spring, a driven carriage."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np

from mbproj.base.arrays import Array

from .independent import Solution, solve
from .scene import GRAVITY, Case, Draw, Load, scene_text


def stage(seed: int) -> Case:
    """Carriage x on the ground, y on x, z on y; the foot of z on the floor.

    (mx + my + mz) x'' = Fx - k x - μ N x'/|u|,  (my + mz) y'' = Fy - μ N y'/|u|,  N = mz g - Fz,  u = (x', y').
    """
    draw, duration = Draw("stage", seed), 0.8
    settings = draw.settings(duration)
    mx, my, mz = (draw.decades(-1, 1.3), draw.decades(-1.3, 0.7), draw.decades(-0.7, 0.7))
    law, grip = draw.law(), mz * GRAVITY
    limit = law.static * grip
    at_rest, grows = draw.chance(0.6), draw.chance(0.5)
    Fx, Fy, Fz = draw.load(limit, 0.6), draw.load(limit, 0.6), draw.load(0.15 * grip)
    if grows:
        (Fx, Fy), Fz = _growing(draw, limit), Load(0.0)
    k = draw.decades(1, 3) if draw.chance(0.3) else 0.0
    driven = draw.chance(0.25)
    A, w = draw.number(0.02, 0.2), draw.number(3, 15)
    begin = [0.0, 0.0] if at_rest or grows else [draw.number(-1, 1), draw.number(-1, 1)]
    if driven:
        begin[0] = A * w
    mX, mY = mx + my + mz, my + mz

    def push(t: float) -> float:
        return grip - Fz(t)

    def rate(t: float, s: Array, width: float) -> list[float]:
        x, _, u, v = s
        if driven:
            u = A * w * cos(w * t)
        rub = law.drag(width, u, v) * push(t)
        along = -A * w * w * sin(w * t) if driven else (Fx(t) - k * x - rub * u) / mX
        return [u, v, along, (Fy(t) - rub * v) / mY]

    def look(t: float, s: Array, width: float) -> tuple[list[float], float]:
        return [s[0], s[1], s[3]], push(t)

    def answer(at: Array) -> Solution:
        return solve(rate, look, [0.0, 0.0, *begin], at)

    inertia = [1, 1, 1]
    bodies = {
        "x": {"mass": mx, "inertia": inertia, "position": draw.to_global(0, 0, 0.5)},
        "y": {"mass": my, "inertia": inertia, "position": draw.to_global(0, 0, 0.4)},
        "z": {"mass": mz, "inertia": inertia, "position": draw.to_global(0, 0, 0.1)},
    }
    axes = {"X": ("ground", "x", 0.5), "Y": ("x", "y", 0.4), "Z": ("y", "z", 0.1)}
    joints = {
        name: {
            "type": "prismatic",
            "bodies": [first, second],
            "location": draw.to_global(0, 0, height),
            "axis": draw.to_global(*np.eye(3)[number]),
            "speed": [*begin, 0.0][number],
        }
        for number, (name, (first, second, height)) in enumerate(axes.items())
    }
    forces = {
        "foot": draw.stop("z", [0, 0, 0], law),
        "push": {"type": "force", "body": "z", "force": draw.components(Fx, Fy, Fz)},
    }
    if k:
        forces["spring"] = {"type": "linear_spring_damper", "joint": "X", "stiffness": k}
    swing = {"joint": "X", "displacement": {"harmonic": {"amplitude": A, "frequency": w}}}
    motions = {"drive": swing} if driven else {}
    down = draw.to_global(0, 0, -GRAVITY)
    text = scene_text(draw, settings, down, bodies=bodies, joints=joints, motions=motions, forces=forces)
    watched = (
        draw.watch("bodies/position", "z", 1, 0, 0),
        draw.watch("bodies/position", "z", 0, 1, 0),
        draw.watch("bodies/velocity", "z", 0, 1, 0),
    )
    return Case("stage", text, settings, answer, watched, {"foot": law})


def _growing(draw: Draw, limit: float) -> tuple[Load, Load]:
    """A load that reaches the limit along one direction while it changes along any other."""
    at, along = draw.number(0.05, 0.3), draw.number(-pi, pi)
    change, speed = along + draw.number(-1.5, 1.5), limit * draw.number(0.3, 3)
    parts = [(limit * f(along), speed * f(change)) for f in (cos, sin)]
    x, y = (Load(value - rate * at, rate) for value, rate in parts)
    return x, y
