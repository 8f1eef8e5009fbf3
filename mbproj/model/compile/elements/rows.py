"""Constraint rows of elements, which couple coordinates or drive one, and inertias reflected to coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mbproj.elements.element import Element, Row
from mbproj.errors import InputError, Problem
from mbproj.functions.program import TIME, Op, Program
from mbproj.functions.program_set import flatten, joined
from mbproj.model.channels import Motions
from mbproj.model.compile.coupled import bound
from mbproj.model.compile.elements.measured import coordinate_of
from mbproj.model.compile.elements.named import VARIABLES, expression_of, named_within
from mbproj.model.couplings import compile_couplings
from mbproj.model.primitive_set import Binding, bind, bindings
from mbproj.model.reflected import ReflectedInertias
from mbproj.model.system import System
from mbproj.scene.coupled import Coupled

#: The smallest number with a reciprocal: a smaller inertia counts as none.
LEAST = float(np.finfo(float).tiny)


def with_rows(system: System, elements: Sequence[Element]) -> System:
    """Return the system with the rows of the elements. Raises InputError where a function is not admissible in a
    row."""
    coupled, driven = list[tuple[Element, Row]](), list[tuple[Element, Row]]()
    for element in elements:
        for row in element.rows:
            function = row.function
            if isinstance(function, str):
                row = replace(row, function=expression_of(element, function, VARIABLES))
            (driven if _drives(row) else coupled).append((element, row))
    return _with_motions(_with_couplings(system, coupled), driven)


def _drives(row: Row) -> bool:
    """Whether a row is a motion: it has one coordinate and a function of time alone."""
    return (
        list(row.of.values()) == [1.0]
        and isinstance(row.function, Program)
        and all(each.operand == TIME for each in row.function.code if each.op is Op.VARIABLE)
    )


def _with_couplings(system: System, rows: Sequence[tuple[Element, Row]]) -> System:
    """Return the system with rows that couple coordinates, each as a joint of its own."""
    if not rows:
        return system
    names, own, coordinates = system.names, bindings(system.joints), bindings(system.coordinates)
    body, local = system.reaction_body.tolist(), system.reaction_local.tolist()
    for element, row in rows:
        parts = [coordinates[coordinate_of(system, element, name)] for name in row.of]
        assert not isinstance(row.function, str)
        coupled = Coupled(dict(row.of), row.function, row.constant, row.period)
        own.append(bound(f"row '{element.name}.{row.name}'", coupled, row.constant, parts, len(body)))
        body.append(next(body for body, side, _ in reversed(own[-1].slots) if side == 2))
        local.append([0.0] * 3)
    return replace(
        system,
        names=replace(names, joints=(*names.joints, *(named_within(element, row.name) for element, row in rows))),
        joints=bind(own),
        couplings=compile_couplings(own, coordinates),
        reaction_body=np.array(body, dtype=np.intp),
        reaction_local=np.array(local).reshape(-1, 3),
        joint_places=(*system.joint_places, *(row.place for _, row in rows)),
    )


def _with_motions(system: System, rows: Sequence[tuple[Element, Row]]) -> System:
    """Return the system with rows that drive coordinates; they are the last rows of C."""
    if not rows:
        return system
    names, before = system.names, system.motions
    at = [coordinate_of(system, element, name) for element, row in rows for name in row.of]
    own = flatten([row.function for _, row in rows if isinstance(row.function, Program)])
    return replace(
        system,
        names=replace(
            names,
            motions=(*names.motions, *(named_within(element, row.name) for element, row in rows)),
            motion_units=(*names.motion_units, *(names.coordinate_units[number] for number in at)),
        ),
        motions=Motions(
            np.array([*before.joint_coordinate, *at], dtype=np.intp),
            np.array([*before.start, *(row.constant for _, row in rows)]),
            joined([before.programs, own]) if before.size else own,
            (*before.places, *(row.place for _, row in rows)),
        ),
    )


def with_inertias(system: System, elements: Sequence[Element]) -> System:
    """Return the system with inertias reflected to coordinates. Raises InputError where one is negative or not
    finite."""
    own = dict[int, float]()
    for element in elements:
        for name, inertia in element.inertias.items():
            if not 0.0 <= inertia < np.inf:
                what = f"element '{element.name}' has an inertia along '{name}' of {inertia}"
                raise InputError(Problem(what, hint="give a finite number that is not negative"))
            if inertia >= LEAST:
                at = coordinate_of(system, element, name)
                own[at] = own.get(at, 0.0) + inertia
    if not own:
        return system
    names, before, bound_to = system.names, system.reflected, bindings(system.coordinates)
    forces = len(names.forces) - before.size
    for at, inertia in zip(before.joint_coordinate.tolist(), before.inertia.tolist(), strict=True):
        own[at] = own.get(at, 0.0) + inertia
    rows = [Binding(bound_to[at].primitive, owner, bound_to[at].slots) for owner, at in enumerate(own)]
    return replace(
        system,
        names=replace(
            names,
            forces=(*names.forces[:forces], *(f"{names.coordinates[at]}.inertia" for at in own)),
            force_units=(*names.force_units[:forces], *(names.coordinate_units[at] for at in own)),
        ),
        reflected=ReflectedInertias(bind(rows), np.array([*own], dtype=np.intp), np.array([*own.values()])),
    )
