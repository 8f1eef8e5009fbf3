"""Tendons of an MJCF model: between two points a spring, a stop or a rod; what else acts along one is said."""

from __future__ import annotations

from typing import Any

import numpy as np

from mbproj.arrays import Array
from mbproj.formats.chains import Coordinates, free_name
from mbproj.formats.mechanism import Bare, Mechanism, Quantity, Same
from mbproj.formats.mjcf.along import Along, act_along, along_tendon, length_of, names_along, two_points
from mbproj.formats.mjcf.compiled import Compiled
from mbproj.formats.mjcf.drives import free_symbol
from mbproj.formats.mjcf.laws import summed
from mbproj.formats.mjcf.parts import Called
from mbproj.formats.yaml_text import number as shown


def add_tendons(compiled: Compiled, mechanism: Mechanism, called: Called, coordinates: Coordinates) -> None:
    """Springs and dampers of tendons between two points or of joints, stops between points. One that only couples is
    said with its equality."""
    import mujoco

    model = compiled.model
    for number in range(model.ntendon):
        name = compiled.name("tendon", number) or f"tendon_{number}"
        place = compiled.place_in("tendon", name)
        found = two_points(compiled, mechanism, called, number)
        first = int(model.tendon_adr[number])
        path = int(model.wrap_type[first]) != int(mujoco.mjtWrap.mjWRAP_JOINT)
        acts = [word for word, values in _acting(model).items() if np.any(values[number])]
        along = along_tendon(compiled, mechanism, called, coordinates, number)
        done = set() if found is None else _between(compiled, mechanism, name, number, *found)
        done |= _pulled(compiled, mechanism, name, number, along, done)
        acts = [word for word in acts if word not in done]
        what = "a scene has no ropes over sites or pulleys" if path else "a scene has none of a sum of coordinates"
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
    if not _bent(model, number) and (low == high or not stiffness):
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


def _bent(model: Any, number: int) -> bool:
    """Whether the spring or the damper of a tendon is not linear."""
    return any(np.any(_powers(model, word, number)[1:]) for word in ("stiffness", "damping"))


def _powers(model: Any, word: str, number: int) -> list[float]:
    """The factors of x, x², .. in the force of a spring or a damper."""
    more = getattr(model, f"tendon_{word}poly", None)
    return [float(getattr(model, f"tendon_{word}")[number]), *(map(float, more[number]) if more is not None else ())]


def _pulled(
    compiled: Compiled, mechanism: Mechanism, name: str, number: int, along: list[Along] | None, done: set[str]
) -> set[str]:
    """Adds the spring and the damper along coordinates, as one force that is a signal; which of them it has."""
    model = compiled.model
    springs, dampers = _powers(model, "stiffness", number), _powers(model, "damping", number)
    if along is None or "spring" in done or not (any(springs) or any(dampers)):
        return set()
    names = names_along(mechanism, name, along)
    length, rate = length_of(along, names)
    low, high = (float(each) for each in model.tendon_lengthspring[number])
    x = free_symbol(mechanism, f"{name}_stretch")
    stretch = (
        f"{length} - ({shown(low)})" if low == high else f"({length}) - clip({length}, {shown(low)}, {shown(high)})"
    )
    v = free_symbol(mechanism, f"{name}_rate")
    spring = [(-factor, x if not power else f"{x}**{power + 1}") for power, factor in enumerate(springs)]
    odd = [v, f"{v}*abs({v})", f"{v}**3"]
    act_along(
        mechanism, name, along, names, summed([*spring, *((-c, text) for c, text in zip(dampers, odd, strict=False))])
    )
    if any(springs):
        mechanism.signals[x] = Bare(stretch)
    if any(dampers):
        mechanism.signals[v] = Bare(rate)
    return {"spring", "damping", "stiffness that is not linear", "damping that is not linear"}
