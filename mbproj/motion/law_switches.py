"""The switches in a system's functions: the branch that each is on, and the event where one changes its branch."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property, lru_cache

import numpy as np

from mbproj.base.arrays import Array, Numbers
from mbproj.base.dataclass import dataclass
from mbproj.equations.forces import law_coordinates
from mbproj.equations.instant import Instant
from mbproj.functions.program import Op
from mbproj.functions.program_set import FREE, JUMPING, ProgramSet, all_switches, argument, natural
from mbproj.functions.series import walk
from mbproj.model.contacts import CONTACT_OF
from mbproj.model.couplings import FollowedKind
from mbproj.model.followed import feet, rows_on_branches
from mbproj.model.system import System
from mbproj.motion.time_events import Event


@dataclass(frozen=True, eq=False)
class LawSwitches:
    """K switches: the number of each one's program in the system's set, and of its instruction."""

    system: System
    program: tuple[int, ...]
    at: tuple[int, ...]

    @property
    def programs(self) -> ProgramSet:
        """The programs whose instructions the switches are."""
        return self.system.programs

    def branches(self, instant: Instant) -> Array:
        """Return the branches of all switches at a state, (K,); NaN for one on an edge."""
        programs, laws, values = self.programs, self._laws, dict[int, float]()
        free = np.full(len(programs.op), FREE)
        value, rate = law_coordinates(instant) if laws else (np.zeros(0), np.zeros(0))
        rows, bound = self.system.curved, self.system.coordinates
        coordinate = bound.value(instant.pose.places(bound)) if rows else np.zeros(0)
        on_curves = self._feet(instant, free)
        with np.errstate(all="ignore"):
            for program in dict.fromkeys(self.program):
                along: tuple[Numbers, ...] = (value[laws[program]], rate[laws[program]]) if program in laws else ()
                if program in rows:
                    along = (coordinate[rows[program][1]],)
                if program in on_curves:
                    along = (np.asarray(on_curves[program]),)
                for at, stack in walk(programs, program, instant.variables(*along), free):
                    if at in self.at:
                        value_at = argument(programs, at, FREE, [each[0] for each in stack[-2:]])
                        values[at] = natural(programs, at, value_at)
        return np.array([values[at] for at in self.at])

    def _feet(self, instant: Instant, held: Array) -> dict[int, float]:
        """Return the parameter of the foot of each distance from a curve; NaN for stops, which follow curves only as
        rows or laws."""
        system = self.system
        values = dict.fromkeys(_following(system, FollowedKind.STOP), np.nan)
        if signs := _following(system, FollowedKind.COORDINATE):
            value = system.coordinates.value(instant.pose.places(system.coordinates))
            values |= {program: float(value[at]) for program, (at, _) in signs.items()}
        for kind, bound in ((FollowedKind.ROW, system.joints), (FollowedKind.LAW, system.forces.laws.coordinates)):
            if following := _following(system, kind):
                values |= feet(bound, self.programs, following, held, instant.pose.places(bound))
        return values

    @cached_property
    def _laws(self) -> dict[int, int]:
        """The number of the law of each program."""
        return {p: law for law, p in enumerate(self.system.forces.laws.program.tolist()) if p >= 0}

    def owner(self, k: int) -> str:
        """Return the owner of a switch, in words."""
        program, rows = self.program[k], self.system.curved
        if program in rows:
            return self.system.row_owner(self.system.bodies + rows[program][0])
        if program in self.system.following:
            return self._follower(*self.system.following[program][:2])
        if program >= self.system.first_rate:
            return f"state '{self.system.names.states[program - self.system.first_rate]}'"
        return f"force '{self.system.forces.program_owners[program]}'"

    def _follower(self, kind: FollowedKind, number: int) -> str:
        system = self.system
        if kind is FollowedKind.STOP:
            assert system.stops is not None
            return system.stops.owners[number]
        if kind is FollowedKind.COORDINATE:
            return f"rope '{system.names.coordinates[number].partition('.')[0]}'"
        if kind is FollowedKind.LAW:
            return f"joint '{system.forces.law_owners[number]}'"
        name = system.names.joints[system.joints.owner[number]]
        return name.removeprefix(CONTACT_OF) if name.startswith(CONTACT_OF) else f"joint '{name}'"

    def what(self, k: int) -> str:
        """Return the description of a switch, in the scene's words: "'sign' in '-20*sign(angle_dot)'"."""
        if self.program[k] in self.system.following:
            return "a knot of its curve" if self._sheave(k) is None else f"its place {self._sheave(k)}"
        text = self.programs.texts[self.program[k]]
        name = self._name(k)
        return f"'{name}' in '{text}'" if text else name

    def jumps(self, k: int) -> bool:
        """Whether the law has a jump at a switch, and not only a kink."""
        return Op(int(self.programs.op[self.at[k]])) in JUMPING

    def event(self, t: float, k: int, direction: int) -> Event:
        """Return the event that is recorded where a switch changes its branch."""
        if (sheave := self._sheave(k)) is not None:
            how = "comes back to" if direction > 0 else "leaves"
            return Event(t, self.owner(k), f"{how} its place {sheave}", direction)
        if self.program[k] in self.system.following:
            return Event(t, self.owner(k), "knot of its curve", direction)
        return Event(t, self.owner(k), f"{'jump' if self.jumps(k) else 'kink'} of {self._name(k)}", direction)

    def _sheave(self, k: int) -> str | None:
        """The number of the place that a rope leaves where its switch changes."""
        followed = self.system.following.get(self.program[k])
        if followed is None or followed.kind is not FollowedKind.COORDINATE:
            return None
        return self.system.names.coordinates[followed.number].rpartition("_")[2]

    def _name(self, k: int) -> str:
        return Op(int(self.programs.op[self.at[k]])).name.lower()


@lru_cache(maxsize=64)
def switches_of(system: System) -> LawSwitches | None:
    """Return the switches of all functions; None without any."""
    switches = all_switches(system.programs)
    return LawSwitches(system, *zip(*switches, strict=True)) if switches else None


def on_branches(system: System, held: Array) -> System:
    """Return the system with the switches of its rows and laws that follow curves on these branches, one for each
    instruction."""
    rows = {program: (row, 0) for program, (row, _) in system.curved.items()} | _following(system, FollowedKind.ROW)
    held_system, laws = system, _following(system, FollowedKind.LAW)
    if rows:
        held_system = replace(held_system, joints=rows_on_branches(system.joints, system.programs, rows, held))
    if laws:
        all_laws = system.forces.laws
        along = rows_on_branches(all_laws.coordinates, system.programs, laws, held)
        held_system = replace(held_system, forces=replace(system.forces, laws=replace(all_laws, coordinates=along)))
    return held_system


def _following(system: System, kind: FollowedKind) -> dict[int, tuple[int, int]]:
    """Return the number of each distance from a curve among the rows, the laws or the stops, by program. The second
    number tells which of two curves has the foot."""
    return {program: (at, second) for program, (followed, at, second) in system.following.items() if followed is kind}
