"""The switches of a system's laws: which branch each is on, and what happens where one changes it."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.dynamics.equations.forces import law_coordinates, law_variables
from mbproj.dynamics.equations.kinematics import Pose, Twist
from mbproj.functions.program import Op
from mbproj.functions.series import walk
from mbproj.functions.switches import FREE, JUMPING, beyond, interval, law_switches, natural
from mbproj.integrate.events.crossing import Bounds
from mbproj.integrate.events.time_events import Event
from mbproj.model.forces import Forces


@dataclass(frozen=True, eq=False)
class LawSwitches:
    """K switches: the law of each, and its instruction. What is held is a branch for each instruction of the set."""

    forces: Forces
    law: tuple[int, ...]
    at: tuple[int, ...]

    @property
    def size(self) -> int:
        """K."""
        return len(self.at)

    @property
    def free(self) -> Array:
        """Nothing is held, (N,)."""
        return np.full(len(self.forces.programs.op), FREE)

    def arguments(self, pose: Pose, twist: Twist, t: float, reference: Array, held: Array) -> Array:
        """Of all switches at a state, (K,)."""
        value, rate = law_coordinates(self.forces, pose, twist, reference)
        found: dict[int, float] = {}
        for law in dict.fromkeys(self.law):
            found |= self._of_law(law, value, rate, t, held)
        return np.array([found[at] for at in self.at])

    def _of_law(self, law: int, value: Array, rate: Array, t: float, held: Array) -> Mapping[int, float]:
        programs, found = self.forces.programs, {}
        with np.errstate(all="ignore"):
            variables = law_variables(t, value, rate, law)
            for at, stack in walk(programs, int(self.forces.laws.program[law]), variables, held):
                if at in self.at:
                    two = Op(int(programs.op[at])) in (Op.MIN, Op.MAX)
                    found[at] = float(stack[-2][0] - stack[-1][0] if two else stack[-1][0])
        return found

    def bounds(self, held: Array) -> Bounds:
        """Where the branches held hold."""
        low, high = zip(*(interval(self.forces.programs, at, float(held[at])) for at in self.at), strict=True)
        return Bounds(np.array(low), np.array(high))

    def settled(self, held: Array, x: Array) -> Array:
        """With the branches at x for those that are free."""
        found = held.copy()
        for at, value in zip(self.at, x.tolist(), strict=True):
            if np.isnan(held[at]):
                found[at] = natural(self.forces.programs, at, value)
        return found

    def freed(self, held: Array, which: npt.NDArray[np.bool_]) -> Array:
        """Without the branches of these."""
        return self.turned_to(held, which, np.full(self.size, FREE))

    def crossed(self, held: Array, leaving: npt.NDArray[np.bool_], direction: Integers) -> Array:
        """With the branches beyond for those that are leaving theirs."""
        found = held.copy()
        for k in np.flatnonzero(leaving):
            at = self.at[k]
            found[at] = beyond(self.forces.programs, at, float(held[at]), int(direction[k]))
        return found

    def is_free(self, held: Array) -> Array:
        """Which are, (K,): those of a sign that is not told yet."""
        return np.isnan(held[list(self.at)])

    def turned_to(self, held: Array, which: npt.NDArray[np.bool_], direction: Array) -> Array:
        """With the branches of these signs."""
        found = held.copy()
        found[np.array(self.at)[which]] = direction[which]
        return found

    def owner(self, k: int) -> str:
        """Whose switch it is."""
        return f"force '{self.forces.law_owners[self.law[k]]}'"

    def what(self, k: int) -> str:
        """What it is, in the scene's words: "'sign' in '-20*sign(angle_dot)'"."""
        text = self.forces.programs.texts[int(self.forces.laws.program[self.law[k]])]
        name = self._name(k)
        return f"'{name}' in '{text}'" if text else name

    def jumps(self, k: int) -> bool:
        """Whether the law has a jump there, and not only a kink."""
        return Op(int(self.forces.programs.op[self.at[k]])) in JUMPING

    def event(self, t: float, k: int, direction: int) -> Event:
        """What is recorded where a switch changes its branch."""
        return Event(t, self.owner(k), f"{'jump' if self.jumps(k) else 'kink'} of {self._name(k)}", direction)

    def _name(self, k: int) -> str:
        return Op(int(self.forces.programs.op[self.at[k]])).name.lower()


@lru_cache(maxsize=64)
def switches_of(forces: Forces | None) -> LawSwitches | None:
    """Those of all laws; None where there are none."""
    if forces is None:
        return None
    found = law_switches(forces.programs, forces.laws.program)
    return LawSwitches(forces, *zip(*found, strict=True)) if found else None
