"""A scotch yoke and a slider-crank whose slider stands on feet in a row, driven by a motor or by a torque."""

from __future__ import annotations

from math import cos, sin, sqrt
from typing import Any

import numpy as np

from mbproj.base.arrays import Array

from .independent import Law, Solution, solve
from .scene import GRAVITY, Case, Draw, Load, Watched, scene_text

#: What the crank's angle f and its rate make of the slider: its speed over f', and from the friction coefficients over
#: the speed, c, the acceleration f'' or the motor's torque, and the pushes of the outer feet.
Answer = tuple[float, float, float]


def yoke(seed: int) -> Case:
    """The pin of the crank slides in an upright slot of the slider: x = r cos f.

    P on the slider at the height r sin f of the pin; J f'' = T + P r sin f; m x'' = P - Σ cᵢ Nᵢ; N₁ + N₂ = m g;
    (r sin f + e) Σ cᵢ Nᵢ - Σ xᵢ Nᵢ = -r sin f m x'', moments about the centre of mass, e above the feet.
    """
    return _crank("yoke", seed)


def slider_crank(seed: int) -> Case:
    """A rod of length l at the angle g joins the crank's pin to the slider's centre: x = r cos f + l cos g,
    r sin f + l sin g = z.

    Lagrange's equation in f, with the friction -x₁ Σ cᵢ Nᵢ; the pushes from the force B of the rod on the slider, with
    x₁ = dx/df: Bx = m x'' + Σ cᵢ Nᵢ, Bz from the moments on the rod about the pin.
    """
    return _crank("slider_crank", seed)


def _crank(family: str, seed: int) -> Case:
    draw, duration = Draw(family, seed), 0.8
    settings = draw.settings(duration)
    m, r, J, e = draw.decades(-0.5, 1), draw.number(0.03, 0.15), draw.decades(-3, -1), draw.number(0.02, 0.1)
    own = m * draw.decades(-3.5, -1.5)
    count = draw.pick(2, 2, 3, 4)
    places = sorted(draw.number(-0.3, 0.3) for _ in range(count))
    places[0], places[-1] = min(places[0], -0.15), max(places[-1], 0.15)
    laws = [draw.law()] * count
    if count == 2 and draw.chance(0.4):
        laws = [draw.law(plain=True), draw.law(plain=True)]
    mean, W = sum(law.static for law in laws) / count, m * GRAVITY
    f0, driven = draw.number(0.2, 6.0), draw.chance(0.4)
    T = Load(0.0) if driven else draw.load(2.0 * mean * W * r, 0.8)
    start = draw.pick(0.0, draw.number(-12, 12))
    A, w, turns = draw.number(0.5, 2.0), draw.number(3, 12), draw.chance(0.5)
    l, rod, z = draw.number(2.2, 4.0) * r, draw.decades(-1, 0), draw.number(-0.3, 0.3) * r
    joint = (rod, rod * l * l / 12.0)
    ends, rubs = (places[0], places[-1]), (laws[0], laws[-1])
    if driven and turns:
        start = A * w
    elif driven:
        start = draw.number(3, 12)

    def drive(t: float) -> tuple[float, float, float]:
        """The angle, its rate and acceleration."""
        if turns:
            return f0 + A * sin(w * t), A * w * cos(w * t), -A * w * w * sin(w * t)
        return f0 + start * t, start, 0.0

    def slide(f: float) -> tuple[float, float, float]:
        """x, dx/df and d²x/df² of the slider."""
        if family == "yoke":
            return r * cos(f), -r * sin(f), -r * cos(f)
        c, s = _rod(f)
        g1, g2 = _rod_rates(f, c, s)
        x1, x2 = -r * sin(f) - l * s * g1, -r * cos(f) - l * c * g1 * g1 - l * s * g2
        return r * cos(f) + l * c, x1, x2

    def _rod(f: float) -> tuple[float, float]:
        s = (z - r * sin(f)) / l
        return sqrt(1.0 - s * s), s

    def _rod_rates(f: float, c: float, s: float) -> tuple[float, float]:
        """dg/df and d²g/df²."""
        g1 = -r * cos(f) / (l * c)
        return g1, r * sin(f) / (l * c) + s / c * g1 * g1

    def balance(t: float, f: float, f1: float, width: float, known: float | None) -> Answer:
        """f'' and the pushes; T in the place of f'' where that is known."""
        _, x1, x2 = slide(f)
        u = x1 * f1
        c = [law.drag(width, u) * u for law in rubs]
        # rows in (f'', N₁, N₂): Lagrange's equation, upright forces on the slider, moments on it
        if family == "yoke":
            pin = r * sin(f)
            inertia, gyro, weight = J + m * x1 * x1, m * x1 * x2, 0.0
            up, up_0, up_c = 0.0, 0.0, 0.0
        else:
            pin = 0.0
            k, s = _rod(f)
            g1, g2 = _rod_rates(f, k, s)
            mr, Jr = joint
            gx1, gz1 = -r * sin(f) - 0.5 * l * s * g1, r * cos(f) + 0.5 * l * k * g1
            gx2 = -r * cos(f) - 0.5 * l * (k * g1 * g1 + s * g2)
            gz2 = -r * sin(f) + 0.5 * l * (k * g2 - s * g1 * g1)
            inertia = J + mr * (gx1 * gx1 + gz1 * gz1) + Jr * g1 * g1 + m * x1 * x1
            gyro = mr * (gx1 * gx2 + gz1 * gz2) + Jr * g1 * g2 + m * x1 * x2
            weight = mr * GRAVITY * gz1
            # Bz = up f'' + up_0 + up_c Σ cᵢ Nᵢ
            up = (-Jr * g1 / l - 0.5 * mr * (k * gz1 - s * gx1)) / k + s / k * m * x1
            up_0 = (-Jr * g2 / l - 0.5 * mr * (k * gz2 - s * gx2)) / k * f1 * f1 - 0.5 * mr * GRAVITY
            up_0 += s / k * m * x2 * f1 * f1
            up_c = s / k
        rows = [[inertia, x1 * c[0], x1 * c[1]], [up, 1.0 + up_c * c[0], 1.0 + up_c * c[1]]]
        rows.append([pin * m * x1, *((pin + e) * each - place for each, place in zip(c, ends, strict=True))])
        right = [T(t) - gyro * f1 * f1 - weight, W - up_0, -pin * m * x2 * f1 * f1]
        if known is not None:
            right = [b - row[0] * known for row, b in zip(rows, right, strict=True)]
            rows = [[-1.0 if i == 0 else 0.0, *row[1:]] for i, row in enumerate(rows)]
        first, one, two = np.linalg.solve(np.array(rows), right).tolist()
        return first, one, two

    def rate(t: float, y: Array, width: float) -> list[float]:
        if driven:
            return [0.0, 0.0]
        return [y[1], balance(t, y[0], y[1], width, None)[0]]

    def look(t: float, y: Array, width: float) -> tuple[list[float], float]:
        f, f1, f2 = drive(t) if driven else (y[0], y[1], None)
        found, one, two = balance(t, f, f1, width, f2)
        x, x1, _ = slide(f)
        return [x, x1 * f1, *([found] if driven else [])], min(one, two)

    def answer(at: Array) -> Solution:
        return solve(rate, look, [f0, start], at)

    moved = f"{A!r}*sin({w!r}*t)" if turns else f"{start!r}*t"
    sizes, rod_sizes = (m, own, J, r, e, f0, start, slide(f0)[0]), (l, z, *joint, _rod(f0))
    text, watched = _scene(draw, settings, family, sizes, rod_sizes, places, laws, moved if driven else T)
    return Case(family, text, settings, answer, watched, {f"foot{i}": law for i, law in enumerate(laws)})


def _scene(
    draw: Draw,
    settings: dict[str, Any],
    family: str,
    sizes: tuple[float, ...],
    rod: tuple[Any, ...],
    places: list[float],
    laws: list[Law],
    drive: Load | str,
) -> tuple[str, tuple[Watched, ...]]:
    """The text, and what is compared. `sizes`: of slider, crank, foot and start; `rod`: its length, the height of the
    slider, its mass and inertia, its cosine and sine at the start."""
    m, own, J, r, e, f0, start, x = sizes
    l, z, mr, Jr, (k, s) = rod
    axis = draw.to_global(0, -1, 0)
    pin, height = [r * cos(f0), 0.0, r * sin(f0)], 0.0 if family == "yoke" else z
    centre = draw.to_global(x, 0, height)
    bodies: dict[str, Any] = {
        "crank": {"mass": 1, "inertia": [J, J, J], "position": [0, 0, 0]},
        "slider": {"mass": m, "inertia": [own, own, own], "position": centre},
    }
    joints: dict[str, Any] = {
        "A": {"type": "revolute", "bodies": ["ground", "crank"], "location": [0, 0, 0], "axis": axis, "speed": start}
    }
    if family == "yoke":
        joints["slot"] = {"type": "point_on_line", "bodies": ["slider", "crank"], "location": draw.to_global(*pin)}
        joints["slot"]["axis"] = draw.to_global(0, 0, 1)
        joints["plane"] = {"type": "planar", "bodies": ["ground", "slider"], "location": centre, "axis": axis}
        joints["plane"] |= {"x_axis": draw.to_global(1, 0, 0), "speed": {"displacement_y": 0, "angle": 0}}
    else:
        bodies["rod"] = {"mass": mr, "inertia": [Jr, Jr, Jr]}
        bodies["rod"]["position"] = draw.to_global(*(np.array(pin) + 0.5 * l * np.array([k, 0, s])))
        joints["B"] = {"type": "revolute", "bodies": ["crank", "rod"], "location": draw.to_global(*pin), "axis": axis}
        joints["C"] = {"type": "revolute", "bodies": ["rod", "slider"], "location": centre, "axis": axis}
        joints["B"]["speed"] = start * (-r * cos(f0) / (l * k) - 1.0)
        joints["C"]["speed"] = start * r * cos(f0) / (l * k)
    forces: dict[str, Any] = {
        f"foot{i}": draw.stop("slider", [x + place, 0, height - e], law)
        for i, (place, law) in enumerate(zip(places, laws, strict=True))
    }
    for foot in forces.values():
        foot["plane"]["location"] = draw.to_global(0, 0, height - e)
    motions = {}
    watched = [draw.watch(f"bodies/{of}", "slider", 1, 0, 0) for of in ("position", "velocity")]
    if isinstance(drive, str):
        motions["motor"] = {"joint": "A", "angle": drive}
        watched.append(Watched("motions/force", "motor"))
    else:
        forces["torque"] = {"type": "torque", "body": "crank", "torque": draw.components(0.0, f"(-{drive})", 0.0)}
    down = draw.to_global(0, 0, -GRAVITY)
    text = scene_text(draw, settings, down, bodies=bodies, joints=joints, motions=motions, forces=forces)
    return text, tuple(watched)
