"""From a plan to the text of a scene: every joint is put where its bodies are, so that all are closed to begin with."""

from __future__ import annotations

from typing import Any

from mbproj.joints.table import COORDINATE_UNITS, JOINTS
from mbproj.scene.records import GROUND

from .drawing import Drawing, flow, short
from .loads import GYRATION, load
from .plan import Link, Plan
from .solvable import is_solvable

HEAD = """mbproj: 1
title: {title}
gravity: {gravity}
simulation: {{duration: {duration}, step: {step}, output_step: {step}, integrator: rk4}}
"""
#: The step and the duration of the runs, s: a tenth of a radian at most of what forces and motions set swinging.
STEP, STEPS = 1e-3, 4
#: Joints with one angle, which gears can couple.
WHEELS = ("revolute", "cylindrical", "screw")
#: The part of the coordinates that turn flywheels.
TURNED = 0.2
Entries = dict[str, dict[str, Any]]


def scene_text(plan: Plan) -> str:
    """The scene; a loop is left out that would hold the mechanism, or whose equations have no unique solution."""
    draw = Drawing(plan.seed, plan.flat)
    bodies = {f"b{number}": draw.body(limb.decade) for number, limb in enumerate(plan.limbs)}
    names, joints = list(bodies), dict[str, dict[str, Any]]()
    for number, limb in enumerate(plan.limbs):
        before = names[:number] if plan.floating else [GROUND, *names[:number]]
        if before:
            joints[f"J{number}"] = _joint(draw, limb.kind, [before[limb.parent % len(before)], names[number]])
    for number, loop in enumerate(plan.loops):
        closing = _loop(draw, loop, names if plan.floating else [*names, GROUND], joints)
        extended = joints | {f"L{number}": closing} if closing else joints
        if closing and is_solvable(_text(plan, bodies, extended, {})):
            joints = extended
    for joint in joints.values():
        _turn_flywheels(draw, joint, bodies)
    loads = [load(draw, force, bodies, joints, plan.floating) for force in plan.forces]
    return _text(plan, bodies, joints, {f"F{number}": entry for number, entry in enumerate(loads) if entry})


def _joint(draw: Drawing, kind: str, ends: list[str]) -> dict[str, Any]:
    """A joint closed at the pose of the scene."""
    joint, at = JOINTS[kind], draw.place()
    found: dict[str, Any] = {"type": kind, "bodies": ends}
    if joint.separate:
        depth = float(draw.turn[:, 2] @ at) if draw.flat else None
        found["locations"] = [at, draw.place(depth)]
    else:
        found["location"] = at
    if joint.frame == "axes":
        second = draw.axis()
        found["axes"] = [draw.normal_to(second), second]
    elif joint.frame != "point":
        in_plane = draw.flat and kind in ("prismatic", "point_in_plane", "point_on_line")
        found["axis"] = draw.direction() if in_plane else draw.axis()
    if "pitch" in joint.parameters:
        found["pitch"] = short(draw.rng.choice([-1, 1]) * draw.rng.uniform(0.05, 0.5))
    if joint.merges and draw.rng.uniform() < 0.7:
        found["reaction"] = "true"
    return found


def _turn_flywheels(draw: Drawing, joint: dict[str, Any], bodies: Entries) -> None:
    """Gives some coordinates of a joint a reflected inertia, a tenth to ten times that of its lighter body."""
    lightest = min((bodies[name]["mass"] for name in joint.get("bodies", ()) if name in bodies), default=0.0)
    rows = JOINTS[joint["type"]].coordinates
    sizes = {name: lightest * (1.0 if COORDINATE_UNITS[row[0]] == "m" else GYRATION) for name, row in rows.items()}
    found = {
        name: short(size * 10.0 ** draw.added.uniform(-1, 1))
        for name, size in sizes.items()
        if draw.added.uniform() < TURNED
    }
    if found:
        joint["reflected_inertia"] = found if len(rows) > 1 else next(iter(found.values()))


def _loop(draw: Drawing, loop: Link, names: list[str], joints: Entries) -> dict[str, Any] | None:
    """A joint between any two bodies, or a gear between any two joints; None where there are no two."""
    if loop.kind == "gear":
        names = [name for name, joint in joints.items() if joint["type"] in WHEELS]
    if len(names) < 2:
        return None
    first = loop.first % len(names)
    second = (first + 1 + loop.second % (len(names) - 1)) % len(names)
    ends = [names[first], names[second]]
    if loop.kind == "gear":
        teeth = [int(draw.rng.integers(10, 60)), int(draw.rng.choice([-1, 1]) * draw.rng.integers(10, 60))]
        return {"type": "gear", "joints": ends, "teeth": teeth}
    return _joint(draw, loop.kind, ends)


def _text(plan: Plan, bodies: Entries, joints: Entries, forces: Entries) -> str:
    where = "floating" if plan.floating else "in a plane" if plan.flat else "in space"
    down = Drawing(plan.seed, plan.flat).turn @ [0.0, -9.81 if plan.gravity else 0.0, 0.0]
    title = f"Random mechanism {plan.seed}, {where}"
    text = HEAD.format(title=title, gravity=flow(down + 0.0), duration=STEP * STEPS, step=STEP)
    for block, entries in (("bodies", bodies), ("joints", joints), ("forces", forces)):
        if entries:
            text += f"{block}:\n" + "".join(f"  {name}: {flow(entry)}\n" for name, entry in entries.items())
    return text
