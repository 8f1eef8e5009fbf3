"""A beam on a rigid foot without friction between two compliant ones, some of them in touch at the start."""

from __future__ import annotations

from math import cos, sin

from mbproj.base.arrays import Array

from .independent import Solution, solve
from .scene import GRAVITY, Case, Draw, Watched, scene_text


def beam(seed: int) -> Case:
    """The beam turns by f about its rigid foot, a from its centre of mass along the beam and h below it:
    z = h cos f - a sin f, and that of a soft foot at b, higher by e, is zᵢ = (b - a) sin f + e cos f.

    J f'' + m z₁ z'' = -(m g - F) z₁ + Σ pᵢ dzᵢ/df, z₁ = dz/df,  p = k dⁿ (1 + c d') where d = -zᵢ > 0.
    """
    draw, duration = Draw("beam", seed), 0.6
    settings = draw.settings(duration)
    m, h, a = draw.decades(-0.5, 1.3), draw.number(0.02, 0.3), draw.number(-0.1, 0.1)
    J, F = m * draw.decades(-2.5, -1), draw.load(0.3 * m * GRAVITY)
    soft = [
        (side * draw.number(0.15, 0.5), draw.pick(0.0, draw.number(0, 1e-3)), draw.decades(3, 5), draw.pick(1.0, 1.5))
        for side in (-1, 1)
    ]
    c = draw.pick(0.0, draw.number(0.1, 2))

    def heights(f: float) -> list[tuple[float, float]]:
        """Of the soft feet, and their derivatives by f."""
        return [((b - a) * sin(f) + gap * cos(f), (b - a) * cos(f) - gap * sin(f)) for b, gap, *_ in soft]

    def pushes(f: float, f1: float) -> list[float]:
        found = []
        for (_, _, k, power), (z, z1) in zip(soft, heights(f), strict=True):
            found.append(max(k * (-z) ** power * (1.0 - c * z1 * f1), 0.0) if z < 0.0 else 0.0)
        return found

    def turn(t: float, f: float, f1: float) -> tuple[float, float]:
        """f'', and the push of the rigid foot."""
        z1, z2 = -a * cos(f) - h * sin(f), a * sin(f) - h * cos(f)
        up = pushes(f, f1)
        arms = sum(p * arm for p, (_, arm) in zip(up, heights(f), strict=True))
        weight = m * GRAVITY - F(t)
        f2 = (arms - weight * z1 - m * z1 * z2 * f1 * f1) / (J + m * z1 * z1)
        return f2, m * (z1 * f2 + z2 * f1 * f1) + weight - sum(up)

    def rate(t: float, s: Array, width: float) -> list[float]:
        return [s[1], turn(t, s[0], s[1])[0]]

    def look(t: float, s: Array, width: float) -> tuple[list[float], float]:
        f, f1 = s
        return [h * cos(f) - a * sin(f) - h, -f], turn(t, f, f1)[1]

    def answer(at: Array) -> Solution:
        return solve(rate, look, [0.0, 0.0], at)

    centre, axis = draw.to_global(0, 0, 0), draw.to_global(0, 1, 0)
    bodies = {"beam": {"mass": m, "inertia": [J, J, J], "position": centre}}
    joints = {"plane": {"type": "planar", "bodies": ["ground", "beam"], "location": centre, "axis": axis}}
    forces = {"rigid": draw.stop("beam", [a, 0, -h], None)}
    for number, (b, gap, k, power) in enumerate(soft):
        forces[f"soft{number}"] = draw.stop("beam", [b, 0, gap - h], None, stiffness=k, exponent=power, damping=c)
    for stop in forces.values():
        stop["plane"]["location"] = draw.to_global(0, 0, -h)
    forces["lift"] = {"type": "force", "body": "beam", "force": draw.components(0.0, 0.0, F)}
    down = draw.to_global(0, 0, -GRAVITY)
    text = scene_text(draw, settings, down, bodies=bodies, joints=joints, forces=forces)
    # speeds of what rings at some kHz are known less well than a tolerance on places says
    watched = draw.watch("bodies/position", "beam", 0, 0, 1), Watched("joints/coordinate", "plane.angle")
    return Case("beam", text, settings, answer, watched, {})
