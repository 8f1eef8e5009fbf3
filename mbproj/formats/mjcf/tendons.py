"""Tendons of an MJCF model: between two points a spring, a stop or a rod; what else acts along one is said."""

from __future__ import annotations

from typing import Any

import numpy as np

from mbproj.arrays import Array
from mbproj.formats.chains import free_name
from mbproj.formats.mechanism import Mechanism, Quantity, Same
from mbproj.formats.mjcf.compiled import Compiled
from mbproj.formats.mjcf.parts import Called


def two_points(
    compiled: Compiled, mechanism: Mechanism, called: Called, number: int
) -> tuple[tuple[str, str], Array] | None:
    """The bodies that a straight tendon between two sites joins, and a point (2, 3) in each; None of other tendons."""
    import mujoco

    model, data = compiled.model, compiled.data
    first, count = int(model.tendon_adr[number]), int(model.tendon_num[number])
    kinds = model.wrap_type[first : first + count]
    if count != 2 or any(kind != int(mujoco.mjtWrap.mjWRAP_SITE) for kind in kinds):
        return None
    sites = model.wrap_objid[first : first + 2]
    bodies = [called[int(model.site_bodyid[site])] for site in sites]
    if bodies[0] == bodies[1]:
        return None
    points = [mechanism.part(body).local(data.site_xpos[site]) for body, site in zip(bodies, sites, strict=True)]
    return (bodies[0], bodies[1]), np.array(points)


def add_tendons(compiled: Compiled, mechanism: Mechanism, called: Called) -> None:
    """Springs, dampers and stops of tendons between two points. One that only couples is said with its equality."""
    import mujoco

    model = compiled.model
    for number in range(model.ntendon):
        name = compiled.name("tendon", number) or f"tendon_{number}"
        place = compiled.place_in("tendon", name)
        found = two_points(compiled, mechanism, called, number)
        first = int(model.tendon_adr[number])
        path = int(model.wrap_type[first]) != int(mujoco.mjtWrap.mjWRAP_JOINT)
        acts = [word for word, values in _acting(model).items() if np.any(values[number])]
        done = set() if found is None else _between(compiled, mechanism, name, number, *found)
        acts = [word for word in acts if word not in done]
        what = "a scene has no ropes over sites or pulleys" if path else "a scene has no forces on sums of coordinates"
        if acts and found is not None:
            what = "a scene has none along the line between two points"
        if acts:
            mechanism.say(f"tendon '{name}'", place, f"left out with its {', '.join(acts)}: {what}", Same.NO)
        elif path and found is None:
            mechanism.say(f"tendon '{name}'", place, f"left out: {what}; nothing acts along it by itself", Same.YES)


def _acting(model: Any) -> dict[str, Array]:
    """What may act along a tendon."""
    found = {
        "limit": model.tendon_limited,
        "spring": model.tendon_stiffness,
        "damping": model.tendon_damping,
        "dry friction": model.tendon_frictionloss,
        "armature": model.tendon_armature,
    }
    for word in ("stiffness", "damping"):
        values = getattr(model, f"tendon_{word}poly", None)
        if values is not None:
            found[f"{word} that is not linear"] = values
    return found


def _between(
    compiled: Compiled, mechanism: Mechanism, name: str, number: int, bodies: tuple[str, str], points: Array
) -> set[str]:
    """Adds the spring, the damper and the limit along the line; which of them have a counterpart."""
    model, done = compiled.model, set()
    ends = dict(zip(bodies, points, strict=True))
    stiffness, damping = float(model.tendon_stiffness[number]), float(model.tendon_damping[number])
    low, high = (float(each) for each in model.tendon_lengthspring[number])
    if low == high or not stiffness:
        done |= {"spring", "damping"}
        if stiffness or damping:
            entry: dict[str, Any] = {"type": "spring_damper", "bodies": list(bodies), "locations": ends}
            if stiffness:
                entry |= {"stiffness": Quantity(stiffness, "N/m"), "free_length": Quantity(low, "m")}
            if damping:
                entry["damping"] = Quantity(damping, "N*s/m")
            mechanism.forces[free_name(mechanism, name)] = entry
    if model.tendon_limited[number]:
        done.add("limit")
        least, most = (float(each) for each in model.tendon_range[number])
        entry = {"type": "stop", "bodies": list(bodies), "locations": ends, "rigid": True}
        if least > 0.0:
            entry["shortest"] = Quantity(least, "m")
        if most < 1e5:
            entry["longest"] = Quantity(most, "m")
        here = float(compiled.data.ten_length[number])
        if not least <= here <= most:
            return done - {"limit"}
        mechanism.forces[free_name(mechanism, f"{name}_limit" if name in mechanism.forces else name)] = entry
        place = compiled.place_in("tendon", name)
        what = "a stiff spring in MuJoCo, a rigid stop in the scene"
        mechanism.say(f"limit of tendon '{name}'", place, what, Same.UNTIL)
    return done
