"""Flags of an MJCF model that switch parts of the physics off: the model without them."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NamedTuple


class Switch(NamedTuple):
    """What a flag switches off, and the arrays of the model that are zero without it."""

    what: str
    arrays: tuple[str, ...] = ()


_SOFT = {
    "EQUALITY": Switch("equalities", ("eq_active0",)),
    "FRICTIONLOSS": Switch("dry friction", ("dof_frictionloss", "tendon_frictionloss")),
    "LIMIT": Switch("limits of joints and tendons", ("jnt_limited", "tendon_limited")),
    "CONTACT": Switch("contacts", ("geom_contype", "geom_conaffinity")),
}
_OF_SPRINGS = tuple(f"{kind}_stiffness{ending}" for kind in ("jnt", "tendon") for ending in ("", "poly"))
_OF_DAMPERS = tuple(f"{kind}_damping{ending}" for kind in ("dof", "tendon", "actuator") for ending in ("", "poly"))
#: What the flags of `mjtDisableBit` switch off. Actuators ask `is_off`.
SWITCHES: Mapping[str, Switch] = MappingProxyType(
    {
        **_SOFT,
        "CONSTRAINT": Switch(
            "equalities, dry friction, limits and contacts", tuple(name for each in _SOFT.values() for name in each[1])
        ),
        "SPRING": Switch("springs of joints and tendons", _OF_SPRINGS),
        "DAMPER": Switch("dampers of joints and tendons", _OF_DAMPERS),
        "GRAVITY": Switch("gravity, and what compensates it", ("body_gravcomp",)),
        "CLAMPCTRL": Switch("ranges of control signals", ("actuator_ctrllimited",)),
        "ACTUATION": Switch("actuators"),
    }
)


def disabled(model: Any) -> frozenset[str]:
    """The names of the model's flags that switch something off: "GRAVITY", "CONTACT", .."""
    import mujoco

    return _bits(mujoco.mjtDisableBit, "mjDSBL_", model.opt.disableflags)


def enabled(model: Any) -> frozenset[str]:
    """The names of the flags of what the model switches on: "SLEEP", "ENERGY", .."""
    import mujoco

    return _bits(mujoco.mjtEnableBit, "mjENBL_", model.opt.enableflags)


def _bits(kind: Any, beginning: str, flags: int) -> frozenset[str]:
    members = kind.__members__.items()
    known = {name.removeprefix(beginning): int(bit) for name, bit in members if name.startswith(beginning)}
    unknown = flags & ~sum(known.values())
    names = {name for name, bit in known.items() if flags & bit}
    return frozenset(names | ({f"{unknown:#x}"} if unknown else set()))


def without_disabled(model: Any) -> Any:
    """A copy of MuJoCo's model in which all that its flags switch off is zero."""
    model, off = copy.copy(model), disabled(model)
    for name in off & SWITCHES.keys():
        for array in SWITCHES[name].arrays:
            if hasattr(model, array):
                getattr(model, array)[:] = 0
    if "GRAVITY" in off:
        model.opt.gravity[:] = 0.0
    if off >= {"SPRING", "DAMPER"}:  # then MuJoCo computes none of its passive forces
        model.body_gravcomp[:] = 0.0
        model.opt.density = model.opt.viscosity = 0.0
    if is_unlifted(model) and model.jnt_actgravcomp.all():
        model.body_gravcomp[:] = 0.0
    return model


def is_unlifted(model: Any) -> bool:
    """Whether joints, along which actuators compensate gravity, have none that does."""
    off = not model.nu or "ACTUATION" in disabled(model)
    return bool(off and model.body_gravcomp.any() and model.jnt_actgravcomp.any())


def is_off(model: Any, number: int) -> str:
    """What the model switches off so that an actuator exerts nothing; "" where it acts."""
    if "ACTUATION" in disabled(model):
        return "actuators"
    group = int(model.actuator_group[number])
    off = 0 <= group <= 30 and bool(int(model.opt.disableactuator) >> group & 1)
    return f"actuators of group {group}" if off else ""
