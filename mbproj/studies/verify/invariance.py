"""Checks that results do not depend on the unit of length, the mechanism's place, or the order of its parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np

from mbproj.base.arrays import Array, Integers
from mbproj.equations.assembly.assemble import State
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.constraints import constraint_at
from mbproj.model.euler_parameters import product
from mbproj.model.system import System
from mbproj.motion.projection import Gopm, Gpopm
from mbproj.scene.blocks.signals import names_channels
from mbproj.scene.scene import Scene
from mbproj.studies.variants import RigidMotion, rescaled
from mbproj.studies.verify.case import Case, Finding, Found, difference, worse
from mbproj.studies.verify.equations import (
    EPS,
    OPERATIONS,
    Rounded,
    RoundedEquations,
    correction,
    equations_at,
    penalised,
)

#: The reason why a mechanism cannot be moved.
PLACES = "an element reads places on the ground, or distances of its own, which are not moved"
#: Millimetres in a metre.
MILLIMETRES = 1e3
#: A rotation that mixes all three axes.
ROTATION = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
ROTATION = ROTATION * np.linalg.det(ROTATION)
#: The reason why the unit of length cannot be changed.
NO_UNITS = "elements, signals and states are data without units"
#: The shift of the mechanism, in units of its length.
SHIFT = np.array([3.0, -2.0, 5.0])


def units(case: Case) -> Found:
    """Check that in millimetres GPOPM's correction and the accelerations are the same motion. The remark gives the
    difference for GOPM."""
    if case.scene.elements or names_channels(case.scene):
        return NO_UNITS
    scene, scale = rescaled(case.scene, MILLIMETRES), np.tile([MILLIMETRES] * 3 + [1.0] * 4, case.system.bodies)
    finding = _compared(case, scene, np.diag(scale), np.zeros(len(scale)))
    return replace(finding, remark=_change_of_gopm(case, scene, scale)) if isinstance(finding, Finding) else finding


def _change_of_gopm(case: Case, scene: Scene, scale: Array) -> str:
    """Say by how much the change of unit changes GOPM's correction."""
    known, other = case.equations, _equations_of(case, scene, np.diag(scale), np.zeros(len(scale)))
    unit, shift = _scale(case.system), case.displacement
    before = Gopm().correction(known.M.value, known.C_q.value, known.C_q.value @ shift) / unit
    try:
        after = Gopm().correction(other.M.value, other.C_q.value, other.C_q.value @ (scale * shift)) / (scale * unit)
    except np.linalg.LinAlgError:
        return "gopm has no correction there: C_qC_qᵀ is singular to working precision"
    return f"gopm's correction changes by {100.0 * np.abs(after - before).max() / np.abs(before).max():.2g} %"


def rotation(case: Case) -> Found:
    """Check that turning the whole mechanism about all axes changes nothing."""
    if _reads_places(case):
        return PLACES
    motion = RigidMotion(ROTATION, np.zeros(3))
    return _compared(case, motion.scene(case.scene), _turning(case.system, motion), np.zeros(7 * case.system.bodies))


def translation(case: Case) -> Found:
    """Check that shifting the whole mechanism changes nothing."""
    if _reads_places(case):
        return PLACES
    motion = RigidMotion(np.eye(3), case.system.length * SHIFT)
    shift = np.tile([*motion.shift, 0.0, 0.0, 0.0, 0.0], case.system.bodies)
    return _compared(case, motion.scene(case.scene), np.eye(len(shift)), shift)


def renumbering(case: Case) -> Found:
    """Check that another order of bodies, joints, forces and motions changes nothing."""
    scene = renumbered(case.scene)
    order = _carriers(compile_system(scene), case.system)
    if order is None:
        return "fixed joints unite bodies, and the axes of the whole are those of the first"
    T = np.zeros((len(order), 7, len(order), 7))
    T[np.arange(len(order)), :, order, :] = np.eye(7)
    return _compared(case, scene, T.reshape(7 * len(order), -1), np.zeros(7 * len(order)))


def _compared(case: Case, scene: Scene, T: Array, shift: Array) -> Found:
    """Compare the case with the mechanism of another scene, whose coordinates are T q + shift. Compared are the
    violation of the constraints, the correction of a displacement, and the accelerations."""
    if case.too_large:
        return case.too_large
    system, q = compile_system(scene), T @ case.state.q + shift
    known, other = case.equations, _equations_of(case, scene, T, shift)
    scale = np.abs(T) @ _scale(case.system)
    reach = OPERATIONS * EPS * (np.abs(q).max() + system.length)
    C = constraint_at(system, q, case.state.t)
    differences = [difference(C, np.zeros(len(C)), _left_open(case) * system.row_scale + reach, system.row_scale, 1.0)]
    violation, theirs = (
        Rounded.exact(case.displacement) if each is known else Rounded.exact(T @ case.displacement)
        for each in (known, other)
    )
    one, two = _correction(known, violation), _correction(other, theirs)
    differences.append(difference(two.value, T @ one.value, two.error + np.abs(T) @ one.error, scale))
    one, two = (each.accelerations()[: len(scale)] for each in (known, other))
    differences.append(difference(two.value, T @ one.value, two.error + np.abs(T) @ one.error, scale))
    return worse(differences)


def _equations_of(case: Case, scene: Scene, T: Array, shift: Array) -> RoundedEquations:
    """The equations of another scene's mechanism at the state of the case, moved to T q + shift."""
    state, system = case.state, compile_system(scene)
    turns = np.zeros(system.coordinates.size, dtype=np.intp)
    names = case.system.names.coordinates
    for index, name in enumerate(system.names.coordinates):
        turns[index] = state.turns[names.index(name)]
    moved = State.of(system, state.t, positions=T @ state.q + shift, velocities=T @ state.v, turns=turns)
    return equations_at(system, moved)


def _reads_places(case: Case) -> bool:
    """Whether some elements add coordinates of their own to those of the joints."""
    return compile_system(replace(case.scene, elements=())).coordinates.size < case.system.coordinates.size


def _left_open(case: Case) -> float:
    """The largest violation that assembly leaves in the joints, in the mechanism's length or rad."""
    C = constraint_at(case.system, case.state.q, case.state.t)
    return float(np.abs(C / case.system.row_scale).max())


def _correction(known: RoundedEquations, displacement: Rounded) -> Rounded:
    """GPOPM's correction, with its error bound, of the violation that a displacement makes."""
    bound = correction(penalised(known.M, known.C_q, 1.0), known.C_q, known.C_q @ displacement)
    value = Gpopm().correction(known.M.value, known.C_q.value, known.C_q.value @ displacement.value)
    return Rounded(value, bound.error)


def _turning(system: System, motion: RigidMotion) -> Array:
    """The matrix (7n, 7n) that turns all bodies: R acts on positions, the quaternion product with p on Euler
    parameters."""
    n = system.bodies
    T = np.zeros((n, 7, n, 7))
    index = np.arange(n)
    T[index, :3, index, :3] = motion.rotation
    T[index, 3:, index, 3:] = product(motion.parameters[None, :], np.eye(4)).T
    return T.reshape(7 * n, 7 * n)


def _carriers(system: System, before: System) -> Integers | None:
    """For each carrier of a system, its number in the system `before`. None where fixed joints unite bodies, as the
    carriers' axes then differ."""
    if len(system.names.carriers) < len(system.names.bodies):
        return None
    return np.array([before.names.carriers.index(name) for name in system.names.carriers], dtype=np.intp)


def _scale(system: System) -> Array:
    return np.tile([system.length] * 3 + [1.0] * 4, system.bodies)


Item = TypeVar("Item")


def renumbered(scene: Scene, seed: int = 0) -> Scene:
    """The same scene with its parts in a random order."""
    random = np.random.default_rng(seed)

    def shuffled(items: Sequence[Item]) -> tuple[Item, ...]:
        return tuple(items[number] for number in random.permutation(len(items)))

    return replace(
        scene,
        bodies=shuffled(scene.bodies),
        joints=shuffled(scene.joints),
        markers=shuffled(scene.markers),
        forces=shuffled(scene.forces),
        motions=shuffled(scene.motions),
    )
