"""Laws of force that are added to those of the scene while stops touch and dry frictions slide."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mbproj.dataclass import dataclass
from mbproj.functions.program import Program
from mbproj.functions.program_set import flatten, joined
from mbproj.model.forces import Forces, Laws
from mbproj.model.primitive_set import Binding, bind, bindings


@dataclass(frozen=True, eq=False)
class AddedLaw:
    """A force along a coordinate s: the value of the program `push`, times the load of the bearing number `bearing`
    (-1: 1).

    `joint_coordinate`, `loses`, `partner` and `sliding` mean the same as in `Laws`; `partner` counts from the first law
    added. `owner` is the name of the force, for messages. `apart`: whether a separate integral counts the energy it
    loses."""

    along: Binding
    joint_coordinate: int
    push: Program
    owner: str
    bearing: int = -1
    apart: bool = False
    partner: int = -1
    sliding: tuple[float, float] = (0.0, 0.0)
    loses: bool = True


def with_laws(before: Forces, added: Sequence[AddedLaw]) -> Forces:
    """Return the forces with the laws `added` after the laws that they have."""
    laws = before.laws
    own = [replace(law.along, owner=laws.size + at, offset=0.0) for at, law in enumerate(added)]
    none, owners = np.zeros(len(added)), tuple(law.owner for law in added)
    return replace(
        before,
        laws=Laws(
            coordinates=bind([*bindings(laws.coordinates), *own]),
            joint_coordinate=np.append(laws.joint_coordinate, [law.joint_coordinate for law in added]).astype(np.intp),
            stiffness=np.append(laws.stiffness, none),
            damping=np.append(laws.damping, none),
            free=np.append(laws.free, none),
            program=np.append(laws.program, len(before.programs.start) - 1 + np.arange(len(added))),
            loses=np.append(laws.loses, [law.loses for law in added]),
            bearing=np.append(laws.bearing, [law.bearing for law in added]).astype(np.intp),
            apart=np.append(laws.apart, [law.apart for law in added]),
            partner=np.append(laws.partner, [_behind(laws.size, law.partner) for law in added]).astype(np.intp),
            sliding=np.concatenate([laws.sliding, [law.sliding for law in added]]),
        ),
        programs=joined([before.programs, flatten([law.push for law in added])]),
        law_owners=(*before.law_owners, *owners),
        program_owners=(*before.program_owners, *owners),
    )


def _behind(count: int, number: int) -> int:
    """Return the number of an added law among all laws, of which `count` come before; -1 stays -1."""
    return count + number if number >= 0 else -1
