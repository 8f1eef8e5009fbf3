"""Which forces and motions of a scene need not be smooth: `abs min max sign floor ceil`, tables, smooth steps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from mbproj.functions.kinks import BRANCHED
from mbproj.functions.program import Op
from mbproj.functions.program_set import ProgramSet
from mbproj.model.system import System

#: Forces and motions that are named, at most.
SHOWN = 3


def uneven(system: System) -> Mapping[str, tuple[str, ...]]:
    """What has several branches, by the force or motion that has it: {"force 'stop'": ("max", "sign")}."""
    found: dict[str, tuple[str, ...]] = {}
    if system.forces is not None:
        owners = [f"force '{name}'" for name in system.forces.program_owners]
        found |= _of(system.forces.programs, owners)
    if system.motions is not None:
        found |= _of(system.motions.programs, [f"motion '{name}'" for name in system.names.motions])
    return found


def not_smooth(found: Mapping[str, tuple[str, ...]]) -> str:
    """What `uneven` has found, in words: "force 'stop' (max, sign) is not smooth"."""
    names = [f"{owner} ({', '.join(what)})" for owner, what in found.items()]
    more = [f"{len(names) - SHOWN} more"] if len(names) > SHOWN else []
    *others, last = [*names[:SHOWN], *more]
    return f"{', '.join(others)} and {last} are not smooth" if others else f"{last} is not smooth"


def _of(programs: ProgramSet, owners: Sequence[str]) -> dict[str, tuple[str, ...]]:
    found: dict[str, tuple[str, ...]] = {}
    for index, owner in enumerate(owners):
        code = programs.op[programs.start[index] : programs.start[index + 1]]
        names = [Op(int(op)).name.lower() for op in code if Op(int(op)) in BRANCHED]
        if names:
            found[owner] = tuple(dict.fromkeys([*found.get(owner, ()), *names]))
    return found
