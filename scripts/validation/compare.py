"""Runs a case, and holds what it records against the reference table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from mbproj import assemble, compile_system, initial_guess, settings_to_run, simulate
from mbproj.base.arrays import Array, Integers, Numbers
from mbproj.equations.recorded import Block
from mbproj.scene.scene import read_scene_text

from .case import Case
from .quantities import COMPONENTS, Column, Done, quantity

#: A component that is smaller than this part of the vector's largest one is held to that part: what is zero in truth
#: has only the errors of the source in it.
FLOOR = 0.02
#: What a vector that is zero is held to, in SI units.
ROUND_OFF = 1e-8
#: Tables have their times rounded, s.
SAME_TIME = 1e-8


class History:
    """Keeps the blocks of a run in memory; indexing joins them."""

    def __init__(self) -> None:
        self.blocks: list[Block] = []

    def write(self, block: Block) -> None:
        """Takes a block of samples."""
        self.blocks.append(block)

    def joined(self) -> dict[str, Numbers]:
        """All samples by path."""
        return {path: np.concatenate([block[path] for block in self.blocks]) for path in self.blocks[0]}


@dataclass(frozen=True)
class Deviation:
    """How far a column is from the reference at most, over `count` times, and how far it may be, in SI units."""

    column: str
    error: float
    tolerance: float
    largest: float
    count: int

    @property
    def ratio(self) -> float:
        """Below 1 where the column is within its tolerance."""
        return self.error / self.tolerance


def regular_text(case: Case) -> str:
    """The scene with each planar loop closed by a point on a line in place of a revolute: no row is redundant."""
    lines = case.scene.read_text(encoding="utf-8").splitlines(keepends=True)
    starts = tuple(f"  {joint}: " for joint in case.loops)
    return "".join(
        line.replace("type: revolute", "type: point_on_line") if line.startswith(starts) and starts else line
        for line in lines
    )


def run_case(case: Case, text: str | None = None, **simulation: str) -> Done:
    """Simulates the case with its own settings or these; `text` in place of its scene."""
    given = case.scene.read_text(encoding="utf-8") if text is None else text
    scene = read_scene_text(given, case.scene.name, {}, simulation)
    system, history = compile_system(scene), History()
    report = simulate(system, assemble(system, initial_guess(scene, system)), settings_to_run(scene), history)
    return Done(scene, system, history.joined(), report)


def reference(case: Case) -> Mapping[str, Array]:
    """The columns of the case's table by name."""
    lines = case.table.read_text(encoding="utf-8").splitlines()
    values = np.array([[float(cell) for cell in line.split(",")] for line in lines[2:]])
    return dict(zip(lines[1].split(","), values.T, strict=True))


def deviations(case: Case, done: Done) -> list[Deviation]:
    """One for each column, over the reference's times that were recorded. Raises ValueError where there are none."""
    table = reference(case)
    at, rows = common_times(table["t"], done.recorded["time"])
    if len(rows) < 2 and len(table["t"]) > 1:
        raise ValueError(f"{case.name}: the run has none of the reference's times")
    found = []
    for (owner, name), columns in _by_quantity(table).items():
        values = quantity(done, owner, name)[at].reshape(len(at), -1)
        exact = np.stack([table[column][rows] for column in columns], axis=1)
        if name == "orientation":  # q and -q are the same
            values = values * np.sign(np.sum(values * exact, axis=1, keepdims=True))
        whole = max(float(np.abs(table[column]).max()) for column in columns)
        for column, truth in zip(columns, exact.T, strict=True):
            largest = float(np.abs(table[column]).max())
            error = float(np.abs(values[:, COMPONENTS[Column.of(column).component]] - truth).max())
            found.append(Deviation(column, error, _tolerance(case, name, largest, whole), largest, len(rows)))
    return found


def common_times(exact: Array, recorded: Array) -> tuple[Integers, Integers]:
    """Where the times that both have stand: in the recorded ones, and in the reference's."""
    at = np.searchsorted(recorded, exact - SAME_TIME).clip(max=len(recorded) - 1)
    rows = np.flatnonzero(np.abs(recorded[at] - exact) < SAME_TIME)
    return at[rows], rows


def _by_quantity(table: Mapping[str, Array]) -> dict[tuple[str, str], list[str]]:
    """The columns of each quantity, their components in order."""
    groups: dict[tuple[str, str], list[str]] = {}
    for name in _columns(table):
        column = Column.of(name)
        groups.setdefault((column.owner, column.quantity), []).append(name)
    return {key: sorted(names) for key, names in groups.items()}


def _columns(table: Mapping[str, Array]) -> Iterator[str]:
    return (name for name in table if name != "t")


def _tolerance(case: Case, name: str, largest: float, whole: float) -> float:
    """The case's own absolute tolerance, or a part of the column's largest magnitude."""
    if name in case.tolerances:
        return case.tolerances[name]
    return max(case.relative[name] * max(largest, FLOOR * whole), ROUND_OFF)
