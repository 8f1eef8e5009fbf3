"""The diagnosis of the rows of C by `check`: dependent rows, reactions that are not unique, and the distance to
singular poses."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

from mbproj.analysis.reactions import REACTIONS, in_words, open_components
from mbproj.dataclass import dataclass
from mbproj.dynamics import State
from mbproj.dynamics.equations.kinematics import pose_of
from mbproj.dynamics.rank.conditioning import Conditioning, conditioning
from mbproj.dynamics.rank.diagnosis import problems_of
from mbproj.dynamics.rank.massless import MasslessMotion, massless_motions, massless_problem
from mbproj.dynamics.rank.redundancy import DependentSet, Redundancy, redundancy
from mbproj.dynamics.rank.uniqueness import unique_components
from mbproj.errors import Problem, shortened
from mbproj.model import System

#: The most loops that are listed, and the most joints and rows of each; --json has all.
MOST_SETS, MOST_WORDS = 12, 8
WHERE = {
    True: "along the whole motion",
    False: "at this pose only",
    None: "at this pose (too many bodies to see whether elsewhere)",
}


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """The dependent sets of rows, the motions without mass, the condition numbers, and the reaction components that are
    not unique ("Fy Tx") by joint."""

    redundancy: Redundancy
    massless: tuple[MasslessMotion, ...]
    conditioning: Conditioning
    not_unique: dict[str, str]

    def problems(self, system: System, *, runs: bool) -> list[Problem]:
        """The problems that keep the mechanism from running. Where the equations can be solved (`runs`), these are the
        problems that make a run wrong."""
        massless = [massless_problem(system, self.massless)] if self.massless else []
        return [*problems_of(system, self.redundancy, runs=runs), *massless]

    def facts(self) -> dict[str, Any]:
        """The diagnosis as a dictionary for JSON."""
        return {
            "redundancy": {
                "sets": [_set_facts(entry) for entry in self.redundancy.sets],
                "freedom": self.redundancy.freedom,
                "moves": self.redundancy.moves,
                "bodies_of_loop_left_out": self.redundancy.left_out,
            },
            "reactions_not_unique": self.not_unique,
            "massless_motions": [dict(motion.bodies) for motion in self.massless],
            "conditioning": {**asdict(self.conditioning), "verdict": self.verdict},
        }

    def lines(self) -> Iterator[str]:
        """Yield the diagnosis as lines of text: one line where nothing is special."""
        for permanent, where in WHERE.items():
            sets = [entry for entry in self.redundancy.sets if entry.permanent is permanent]
            if sets:
                yield from _sets(sets, where)
        if self.redundancy.freedom == 0:
            yield "  the joints leave no freedom: a structure, and its dependent rows stay dependent"
        if self.redundancy.freedom and not self.redundancy.moves:
            yield "  the freedom exists to first order only: no motion away from the pose was found"
        if self.not_unique:
            yield f"  reactions that are not unique: {in_words(self.not_unique)}"
        yield f"  {self._conditions()}"

    @property
    def verdict(self) -> str:
        """The distance of the pose from a singular one, in words."""
        passing = any(entry.permanent is False for entry in self.redundancy.sets)
        return "the pose is singular" if passing else self.conditioning.words

    def _conditions(self) -> str:
        of_rows, left_out, parts = self.conditioning, self.redundancy.left_out, []
        if of_rows.as_written is not None:
            parts.append(f"condition of C_q {of_rows.as_written:.3g} as written, {of_rows.scaled:.3g} scaled")
        if left_out:
            parts.append(f"rank and distance to singular poses not computed (a loop of {left_out} bodies)")
        else:
            is_regular = of_rows.distance is not None and self.verdict == of_rows.words
            distance = f" (distance {of_rows.distance:.2g}, {of_rows.owner})" if is_regular else ""
            parts.append(f"{self.verdict}{distance}")
        return "; ".join(parts)


def diagnose(system: System, state: State) -> Diagnosis:
    """The diagnosis of a mechanism at its start."""
    pose = pose_of(state.q)
    unique = unique_components(system, state)
    return Diagnosis(
        redundancy(system, state),
        massless_motions(system, pose),
        conditioning(system, pose),
        open_components(system.names.joints, *(unique[f"{path}_unique"].astype(bool) for path in REACTIONS))
        if unique
        else {},
    )


def _sets(sets: list[DependentSet], where: str) -> Iterator[str]:
    """Yield a line for each loop: the dependent sets with the same joints. --json lists the sets one by one."""
    rows = "1 row follows from others" if len(sets) == 1 else f"{len(sets)} rows follow from others"
    odds = sum(entry.contradictory for entry in sets)
    yield f"  {rows} {where}, {'without contradiction' if not odds else f'{odds} in contradiction'}:"
    loops: dict[tuple[str, ...], list[DependentSet]] = {}
    for entry in sets:
        loops.setdefault(tuple(sorted({row.name for row in entry.held})), []).append(entry)
    for names, members in list(loops.items())[:MOST_SETS]:
        held = list(dict.fromkeys(row.holds for entry in members for row in entry.held if row.holds))
        yield f"    {len(members)} in {shortened(names, MOST_WORDS)}, of the rows {shortened(held, MOST_WORDS)}"
    if len(loops) > MOST_SETS:
        yield f"    ... and in {len(loops) - MOST_SETS} more loops"


def _set_facts(entry: DependentSet) -> dict[str, Any]:
    return {
        "rows": [asdict(row) for row in entry.held],
        "permanent": entry.permanent,
        "contradictory": entry.contradictory,
        "velocity_residual": entry.residual[0],
        "acceleration_residual": entry.residual[1],
    }
