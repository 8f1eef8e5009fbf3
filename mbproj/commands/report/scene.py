"""The report on a scene that is assembled but not run: whether it closes, whether it can run, and what it is like."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from math import pi
from typing import Any, TypedDict

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem, SimulationError, shortened
from mbproj.equations.askew import askew
from mbproj.equations.assembly.assemble import State, coordinates, moved_from_scene
from mbproj.equations.assembly.compiled import adjustment_notes, compile_system
from mbproj.equations.constraints import constraint_at, constraint_velocity_at
from mbproj.equations.contacts import refuse_driven_beyond
from mbproj.equations.friction import refuse_shared_loads
from mbproj.equations.kinematics import pose_of
from mbproj.equations.rank.mobility import MasslessMotion, Mobility, massless_motions, massless_problem, mobility
from mbproj.equations.rank.redundancy import (
    Conditioning,
    DependentSet,
    Redundancy,
    conditioning,
    jammed_wheels,
    problems_of,
    redundancy,
)
from mbproj.equations.rank.uniqueness import unique_components
from mbproj.equations.tensions import length_and_wraps
from mbproj.linear.equilibrium.start import start_state
from mbproj.model.system import System
from mbproj.motion.contacts import RubsAtStart, frictions_at_start, gaps_at_start, refuse_penetration
from mbproj.motion.formulations.choice import Choice, choose
from mbproj.motion.formulations.full import FullFormulation
from mbproj.motion.stiffness import FastMode, fastest_at, stable_steps
from mbproj.results.analysis.loads import REACTIONS, in_words, open_components
from mbproj.results.views import Table, Tabled
from mbproj.scene.blocks.oversights import notes_on
from mbproj.scene.meshes import meshes_of
from mbproj.scene.scene import Scene
from mbproj.scene.settings import placed, placed_in

# --- The fastest modes, and the steps that explicit integrators need --------------------------------------------------


#: A mode decays rather than vibrates where its imaginary part is less than this part of |λ|.
VIBRATES = 0.5


def facts(modes: Sequence[FastMode], steps: Mapping[str, float]) -> dict[str, Any]:
    """`fast_modes` and `stable_steps` as a dictionary for JSON, in Hz, 1/s and s."""
    return {
        "fast_modes": [
            {
                "forces": list(mode.forces),
                "states": list(mode.states),
                "bodies": list(mode.bodies),
                "frequency": abs(mode.eigenvalue.imag) / (2.0 * pi),
                "growth": mode.eigenvalue.real,
                "time_constant": mode.time_constant,
            }
            for mode in modes
        ],
        "stable_steps": dict(steps),
    }


def lines(modes: Sequence[FastMode], steps: Mapping[str, float]) -> list[str]:
    """A line of text for each mode and for each step; none without modes."""
    if not modes:
        return []
    width = max(map(len, steps), default=0)
    largest = [f"    {name:{width}}  {_short(step)}" for name, step in steps.items()]
    rows = [f"    {_quoted(mode.forces or mode.states)}{_on_bodies(mode)} {_motion(mode)}" for mode in modes]
    by = "forces and states" if any(mode.states for mode in modes) else "forces"
    return [f"  fastest by their {by}, at the start", *rows, "  stable up to steps of", *largest]


def _on_bodies(mode: FastMode) -> str:
    return f" on {_quoted(mode.bodies)}" if mode.bodies else ""


def _motion(mode: FastMode) -> str:
    size = abs(mode.eigenvalue)
    if abs(mode.eigenvalue.imag) < VIBRATES * size:
        return f"decays, time constant {_short(mode.time_constant)}"
    hertz = abs(mode.eigenvalue.imag) / (2.0 * pi)
    return f"vibrates with {hertz:.3g} Hz, time constant {_short(mode.time_constant)}"


def _short(seconds: float) -> str:
    """A time with three digits in s, ms or µs."""
    for unit, size in (("s", 1.0), ("ms", 1e-3)):
        if seconds >= 0.1 * size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 1e-6:.3g} µs"


def _quoted(names: Sequence[str]) -> str:
    return ", ".join(f"'{name}'" for name in names)


# --- The ropes of a scene at its start --------------------------------------------------------------------------------
# Their lengths, and their angles of wrap on sheaves, wheels and drums.


class Wrap(TypedDict):
    """The wrap on a circle between the ends of a rope. `place` counts the places of the path from 1; `body` carries the
    circle; `angle` is in rad."""

    place: int
    body: str
    angle: float


class RopeAtStart(TypedDict):
    """The length of a rope in m, without the rope on the drums at its ends, and its wraps."""

    length: float
    wraps: list[Wrap]


def ropes_at_start(scene: Scene, system: System, state: State) -> dict[str, RopeAtStart]:
    """The lengths and wraps of all ropes of a scene, by name."""
    ropes, pose = dict[str, RopeAtStart](), pose_of(state.q)
    for joint in scene.joints:
        if "path" not in joint.parameters:
            continue
        length, angles = length_and_wraps(system, pose, joint.name)
        circles = [(k, node.body) for k, node in enumerate(joint.parameters["path"].nodes[1:-1], 2) if node.radius]
        wraps = [Wrap(place=k, body=body, angle=angle) for (k, body), angle in zip(circles, angles, strict=True)]
        ropes[joint.name] = RopeAtStart(length=length, wraps=wraps)
    return ropes


# --- `mbproj.check` ---------------------------------------------------------------------------------------------------


_NOTHING: Mapping[str, object] = {}


@dataclass(frozen=True, eq=False)
class SceneCheck(Tabled):
    """The report on a scene at its assembled `state`.

    `choice` is the formulation, or None where none can run. `diagnosis` names the rows that depend on others.
    `problems` keep the scene from running; `notes` are on possible mistakes. `frictions` are the dry frictions at the
    start, `fast` the fast motions of its forces. `mobility` is None where a loop is too large to compute it.
    """

    scene: Scene
    system: System
    state: State
    choice: Choice | None
    diagnosis: Diagnosis
    problems: Sequence[Problem]
    notes: Sequence[Problem]
    frictions: Mapping[str, RubsAtStart]
    fast: Sequence[FastMode]
    mobility: Mobility | None

    @property
    def can_run(self) -> bool:
        """Whether no problem keeps the scene from running."""
        return not self.problems

    @property
    def degrees_of_freedom(self) -> int | None:
        """The number of degrees of freedom, from the rank, or else from the kernel; None where neither is known."""
        if self.mobility is not None:
            return self.mobility.degrees_of_freedom
        return None if self.choice is None else self.choice.degrees_of_freedom

    @property
    def coordinates(self) -> dict[str, dict[str, Any]]:
        """The joints' coordinates and their speeds at the start, by name."""
        values, speeds = coordinates(self.system, self.state.q, self.state.v)
        values = values + 2.0 * pi * self.state.turns
        units, names = self.system.names.coordinate_units, self.system.names.coordinates
        return {
            name: {"value": float(value), "speed": float(speed), "unit": unit}
            for name, unit, value, speed in zip(names, units, values, speeds, strict=True)
        }

    @property
    def facts(self) -> dict[str, Any]:
        """The object that `mbproj check --json` prints."""
        system, state, choice, ranks = self.system, self.state, self.choice, self.mobility
        return {
            "title": self.scene.title,
            "coordinates": 7 * system.bodies,
            "constraints": system.constraints,
            "rank": None if ranks is None else ranks.rank,
            "degrees_of_freedom": self.degrees_of_freedom,
            "positions": self.degrees_of_freedom if ranks is None else ranks.positions,
            "kinematic": choice is not None and choice.kinematic,
            "formulation": None if choice is None else choice.name,
            "formulation_why": None if choice is None else choice.why,
            "elimination": None if choice is None else choice.elimination,
            "position_violation": float(abs(constraint_at(system, state.q)).max()),
            "velocity_violation": float(abs(constraint_velocity_at(system, state.q, state.v)).max()),
            "moved_by": moved_from_scene(self.scene, system, state.q),
            "coordinates_at_start": self.coordinates,
            "stops_at_start": gaps_at_start(system, state),
            "frictions_at_start": self.frictions,
            "ropes_at_start": ropes_at_start(self.scene, system, state),
            **self.diagnosis.facts(),
            **facts(self.fast, stable_steps(self.fast)),
            "expectations": [each.name for each in self.scene.expectations],
            "can_run": self.can_run,
            "problems": [_problem(problem) for problem in self.problems],
            "adjusted_joints": {each.joint: {"shift": each.shift, "tilt": each.tilt} for each in system.adjustments},
            "notes": [_problem(note) for note in self.notes],
        }

    @property
    def table(self) -> Table:
        """A table with a row for each joint coordinate at the start."""
        rows = ((name, *entry.values()) for name, entry in self.coordinates.items())
        return Table(("coordinate", "value", "speed", "unit"), tuple(rows))

    @property
    def line(self) -> str:
        """A line with the degrees of freedom, and whether the scene can run."""
        freedom = self.degrees_of_freedom
        said = f"{'unknown' if freedom is None else freedom} degrees of freedom"
        why = "can run" if self.can_run else "cannot run: " + "; ".join(problem.message for problem in self.problems)
        return f"{self.scene.title or 'scene'}: {said}, {why}"

    __repr__ = Tabled.__repr__


def assembled(what: Scene) -> tuple[System, State]:
    """The compiled system and its start."""
    meshes_of(what)  # raises for missing meshes, which a run records
    system = compile_system(what)
    return system, start_state(what, system)


def checked(what: Scene, system: System, state: State) -> SceneCheck:
    """The report on a scene at its start."""
    with placed_in(what):
        refuse_penetration(system, state, what.settings.start)
        refuse_driven_beyond(system, state.t, state.t + (what.settings.duration or 0.0))
        refuse_shared_loads(system, state)
    choice, problems = None, []
    try:
        choice = choose(system, state, what.settings)
        if choice.name == "full":
            FullFormulation.of(system, state, what.settings)
    except InputError as error:
        problems = [placed(problem, what) for problem in error.problems]
    diagnosis = diagnose(system, state)
    problems = diagnosis.problems(system, runs=choice is not None) or problems
    rubs: dict[str, RubsAtStart] = {}
    try:
        rubs = {} if problems else frictions_at_start(system, state)
    except SimulationError as error:
        problems = [Problem(f"{error.where}: {error.cause}" if error.where else error.cause, hint=error.hint or "")]
    # A dense decomposition of a loop of hundreds of bodies would take minutes.
    ranks = None if diagnosis.redundancy.left_out else mobility(system, pose_of(state.q))
    notes = [*notes_on(what), *adjustment_notes(what, system), *jammed_wheels(system, pose_of(state.q))]
    return SceneCheck(
        scene=what,
        system=system,
        state=state,
        choice=choice,
        diagnosis=diagnosis,
        problems=problems,
        notes=[*notes, *_locked(what, system, state, ranks)],
        frictions=rubs,
        fast=[] if choice is None else fastest_at(choice, system, state),
        mobility=ranks,
    )


def _locked(what: Scene, system: System, state: State, ranks: Mobility | None) -> list[Problem]:
    """Return a note where couplings, or an axis that is a little askew, leave no degree of freedom."""
    couplings = [joint.name for joint in what.joints if joint.couples is not None]
    if what.motions or ranks is None or ranks.degrees_of_freedom:
        return []
    if tilted := askew(system, pose_of(state.q)):
        return [Problem(f"nothing can move: {tilted}", what.place("joints"), "make it parallel to them")]
    if not couplings:
        return []
    names = ", ".join(f"'{name}'" for name in couplings)
    said = f"nothing can move: with {names} the joints leave no degree of freedom, and there is no motion"
    return [Problem(said, what.place("joints", couplings[-1]), "take a coupling out, or let it couple others")]


def _problem(problem: Problem) -> dict[str, Any]:
    """A problem as a dictionary for JSON."""
    place = problem.place
    where = {} if place is None else {"file": place.file, "line": place.line, "column": place.column}
    return {"message": problem.message, "hint": problem.hint, **where}


# --- The diagnosis of the rows of C by `check` ------------------------------------------------------------------------
# Dependent rows, reactions that are not unique, and the distance to singular poses.


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
