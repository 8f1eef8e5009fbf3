"""What scenes that differ in numbers alone share: they are compiled, assembled and looked through as one, whose numbers
are Lanes. What the code decides for one of them is decided for all, or they are parted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np

from mbproj.dataclass import dataclass
from mbproj.integrate.events.law_switches import switches_of
from mbproj.integrate.formulations.choice import Choice, choose
from mbproj.integrate.formulations.kinematic import settings_along
from mbproj.kernel import core
from mbproj.lanes import Lanes, OfLanes, Parted, restacked
from mbproj.linear.equilibrium.started import start_state
from mbproj.model import compile_system
from mbproj.registry import AUTOMATIC, EQUILIBRIUM
from mbproj.scene.records import Scene, Settings
from mbproj.studies.measure.mechanism import Mechanism


class OneByOne(Exception):
    """Something that arrays do not do: the cases go one by one."""


@dataclass(frozen=True, eq=False)
class Signature:
    """What the cases of a block share, with their numbers as Lanes: a system, its start, the settings of the runs, and
    the formulation."""

    mechanism: Mechanism
    settings: Settings
    choice: Choice


def values_of(cases: Sequence[Sequence[float | str]]) -> list[Any]:
    """The values of cases (B, k) as k values of a scene: numbers as Lanes where they differ. Raises OneByOne where
    texts differ."""
    columns = []
    for column in zip(*cases, strict=True):
        if all(each == column[0] for each in column):
            columns.append(column[0])
        elif all(isinstance(each, float) for each in column):
            columns.append(Lanes(np.array(column)))
        else:
            raise OneByOne
    return columns


def as_one(records: Sequence[Any]) -> Any:
    """One record for several that differ in numbers alone, which are Lanes of it. Raises Parted where they differ in
    other things."""
    first = records[0]
    if all(each is first for each in records):
        return first
    if len({type(each) for each in records}) > 1:
        raise Parted([type(each) for each in records])
    if is_dataclass(first) and not isinstance(first, type):
        names = [
            each.name
            for each in fields(first)
            if any(getattr(one, each.name) is not getattr(first, each.name) for one in records)
        ]
        return replace(first, **{name: as_one([getattr(each, name) for each in records]) for name in names})
    if isinstance(first, Mapping):
        return {key: as_one([each[key] for each in records]) for key in first}
    if isinstance(first, tuple):
        return tuple(as_one(each) for each in zip(*records, strict=True))
    return first if all(each == first for each in records) else restacked(records)


def signature_of(scene: Scene, settings: Settings) -> Signature:
    """The signature of the cases whose numbers a scene has. Raises Parted where they go different ways, OneByOne where
    arrays do not know their way."""
    if settings.start == EQUILIBRIUM or settings.integrator == AUTOMATIC or core() is None:
        raise OneByOne
    system = compile_system(scene)
    if system.has_contacts or switches_of(system) is not None or system.actions.size:
        raise OneByOne
    state = start_state(scene, system)
    choice = choose(system, state, settings, OfLanes(core()))
    if choice.compiled is None:
        raise OneByOne
    own = settings_along(system, settings) if choice.kinematic else settings
    return Signature(Mechanism(scene, system, state), own, choice)
