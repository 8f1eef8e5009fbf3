"""Random forces, soft enough for the runs' step: springs swing at 10 rad/s at most where they hold the lighter body."""

from __future__ import annotations

from typing import Any

import numpy as np

from mbproj.joints.table import COORDINATE_UNITS, JOINTS
from mbproj.scene.records import GROUND

from .drawing import Drawing, short
from .plan import Link

#: The square of a body's radius of gyration about a joint, m², as a rule.
GYRATION = 0.1


def load(
    draw: Drawing, force: Link, bodies: dict[str, Any], joints: dict[str, Any], floating: bool
) -> dict[str, Any] | None:
    """A force of the type, or None where the mechanism has nothing that it could act on."""
    names = list(bodies)
    body = names[force.first % len(names)]
    if force.kind in ("force", "torque"):
        size = 10.0 * bodies[body]["mass"] * (1.0 if force.kind == "force" else GYRATION)
        along = draw.direction() if force.kind == "force" else draw.axis()
        wave = f"sin({draw.number(1, 20)}*t + {draw.number(0, 6)})"
        components = [f"{short(size * x)!r}*{wave}" if not draw.flat else f"{size * x!r}*{wave}" for x in along]
        return {"type": force.kind, "body": body, force.kind: components} | (
            {"location": draw.place()} if force.kind == "force" else {}
        )
    if force.kind == "spring_damper":
        others = [name for name in (names if floating else [*names, GROUND]) if name != body]
        return _spring(draw, [body, others[force.second % len(others)]], bodies) if others else None
    return _on_coordinate(draw, force, bodies, joints)


def _lighter(names: list[str], bodies: dict[str, Any]) -> float:
    return float(min(bodies[name]["mass"] for name in names if name != GROUND))


def _spring(draw: Drawing, ends: list[str], bodies: dict[str, Any]) -> dict[str, Any]:
    first = draw.place()
    second = draw.place(float(draw.turn[:, 2] @ first) if draw.flat else None)
    mass, pulse = _lighter(ends, bodies), draw.number(1, 10)
    stiffness, damping = short(mass * pulse**2), short(mass * pulse * draw.rng.uniform(0, 1))
    length = short(float(np.linalg.norm(np.subtract(first, second))) * draw.rng.uniform(0.5, 1.5))
    spring = {"type": "spring_damper", "points": {ends[0]: first, ends[1]: second}}
    if draw.rng.uniform() < 0.3:
        return spring | {"force": f"-{stiffness}*(l - {length})*abs(l - {length}) - {damping}*l_dot*exp(-t)"}
    return spring | {"stiffness": stiffness, "damping": damping, "free_length": length}


def _on_coordinate(draw: Drawing, force: Link, bodies: dict[str, Any], joints: dict[str, Any]) -> dict[str, Any] | None:
    """On a joint's coordinate of the unit that the type acts on; None where no joint has one."""
    unit = {"torsion_spring_damper": "rad", "linear_spring_damper": "m"}.get(force.kind)
    choices = [
        (
            name,
            [key for key, row in JOINTS[joint["type"]].coordinates.items() if unit in (None, COORDINATE_UNITS[row[0]])],
        )
        for name, joint in joints.items()
    ]
    choices = [(name, keys) for name, keys in choices if keys]
    if not choices:
        return None
    name, keys = choices[force.first % len(choices)]
    mass, pulse = _lighter(joints[name]["bodies"], bodies), draw.number(1, 10)
    inertia = mass if unit == "m" else mass * GYRATION
    found: dict[str, Any] = {"type": force.kind, "joint": name}
    if force.kind == "friction":
        each = short(inertia * pulse)
        return found | {"coefficient": each if len(keys) == 1 else dict.fromkeys(keys, each)}
    if len(keys) > 1:
        found["coordinate"] = keys[force.second % len(keys)]
    free = "free_angle" if unit == "rad" else "free_displacement"
    return found | {
        "stiffness": short(inertia * pulse**2),
        "damping": short(inertia * pulse),
        free: draw.number(-0.5, 0.5),
    }
