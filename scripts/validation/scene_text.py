"""A reference's description of a mechanism (JSON) as a scene file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from textwrap import wrap
from typing import Any

import numpy as np

from mbproj.model.euler_parameters import rotation_matrix

from .case import Case
from .expect_text import expect_lines
from .readable import LETTERS, number, orientation, vector

JOINT_TYPES = {"revsph": "revolute_spherical"}
WIDTH = 120
Json = Mapping[str, Any]


def scene_text(case: Case, mechanism: Json) -> str:
    """The scene file of a case, whose table is there already."""
    lines = [
        *(f"# {line}" for line in wrap(f"{case.notes} Reference: {case.origin}.", WIDTH - 2)),
        "mbproj: 1",
        f"title: {case.title}",
        f"gravity: {vector(mechanism['gravity'])}".ljust(40) + " # m/s^2",
        "simulation:",
        *(f"  {key}: {value}" for key, value in case.simulation.items()),
        "bodies:                                  # kg, kg m^2 about the centre of mass in body axes, m, rad",
        *(line for body in mechanism["bodies"] for line in _body(body, case.moments)),
        "joints:",
        *(_joint(name, joint) for name, joint in joint_names(mechanism).items()),
    ]
    if "forces" in mechanism:
        lines += ["forces:", *(_force(mechanism, force) for force in mechanism["forces"])]
    return "\n".join([*lines, "markers:", *_markers(case, mechanism), *expect_lines(case)]) + "\n"


def joint_names(mechanism: Json) -> dict[str, Json]:
    """The joints in their order, called A, B, .."""
    return dict(zip(LETTERS, mechanism["joints"], strict=False))


def _body(body: Json, moments: float | None) -> Iterator[str]:
    yield f"  {body['name']}:"
    yield f"    mass: {number(body['mass'])}"
    tensor = body["inertia"] if moments is None else [moments] * 3
    yield f"    inertia: {vector(tensor[:3] if not any(tensor[3:]) else tensor)}"
    yield f"    position: {vector(body['r'])}"
    turned = orientation(body.get("q", (1.0, 0.0, 0.0, 0.0)))
    if turned is not None:
        yield f"    orientation: {turned}"
    if np.abs(body.get("v", 0.0)).max() > 1e-12:
        yield f"    velocity: {vector(_clean(body['v']))}"
    spin = rotation_matrix(np.array(body.get("q", (1.0, 0.0, 0.0, 0.0)))).T @ np.array(body.get("w", (0.0, 0.0, 0.0)))
    if np.abs(spin).max() > 1e-12:
        yield f"    angular_velocity: {vector(_clean(spin))}".ljust(60) + " # in body axes"


def _clean(values: Sequence[float]) -> list[float]:
    """Velocities that the source computed: without its round-off about zero and in the last digits."""
    return [float(f"{value:.13g}") if abs(value) > 1e-12 else 0.0 for value in values]


def _joint(name: str, joint: Json) -> str:
    kind = JOINT_TYPES.get(joint["type"], joint["type"])
    places = [f"location: {vector(joint['point'])}"]
    if "point2" in joint:
        places = [f"locations: [{vector(joint['point'])}, {vector(joint['point2'])}]"]
    if "axis2" in joint:
        places.append(f"axes: [{vector(joint['axis'])}, {vector(joint['axis2'])}]")
    elif "axis" in joint:
        places.append(f"axis: {vector(joint['axis'])}")
    return _entry(name, f"type: {kind}", f"bodies: [{joint['body1']}, {joint['body2']}]", *places)


def _force(mechanism: Json, force: Json) -> str:
    if force["type"] == "revolute_damper":
        pair = (force["body1"], force["body2"])
        joint = next(name for name, at in joint_names(mechanism).items() if (at["body1"], at["body2"]) == pair)
        return f"  damper: {{type: friction, joint: {joint}, coefficient: {number(force['c'])}}}"
    if force["type"] == "torque":
        axes = {"world": "global", "body": "body"}[force["frame"]]
        return f"  drive: {{type: torque, body: {force['body']}, torque: {vector(force['torque'])}, axes: {axes}}}"
    points = ", ".join(f"{force[f'body{k}']}: {vector(force[f'point{k}'])}" for k in (1, 2))
    damping = [f"damping: {number(force['c'])}"] if force["c"] else []
    stiffness, free = f"stiffness: {number(force['k'])}", f"free_length: {number(force['l0'])}"
    return _entry("spring", "type: spring_damper", f"points: {{{points}}}", stiffness, *damping, free)


def _entry(name: str, *items: str) -> str:
    """An entry on one line, or on several where that is too long."""
    line = f"  {name}: {{{', '.join(items)}}}"
    return line if len(line) <= WIDTH else "\n".join([f"  {name}:", *(f"    {item}" for item in items)])


def _markers(case: Case, mechanism: Json) -> Iterator[str]:
    """The case's markers, or the centre of mass of the last body, whose path is then drawn."""
    last = mechanism["bodies"][-1]["name"]
    for name, (body, point) in (case.markers or {"centre": (last, (0.0, 0.0, 0.0))}).items():
        yield f"  {name}: {{body: {body}, location: {{{body}: {vector(point)}}}}}"
