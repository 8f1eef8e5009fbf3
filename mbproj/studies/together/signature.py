"""What scenes that differ in numbers alone share: they are compiled, assembled and looked through as one, whose numbers
are Lanes. What the code decides for one of them is decided for all, or they are parted."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from mbproj.dataclass import dataclass
from mbproj.integrate.events.law_switches import switches_of
from mbproj.integrate.formulations.choice import Choice, choose
from mbproj.kernel import core
from mbproj.lanes import Lanes, OfLanes
from mbproj.linear.equilibrium.started import start_state
from mbproj.model import compile_system
from mbproj.registry import AUTOMATIC, EQUILIBRIUM
from mbproj.scene.records import Scene, Settings
from mbproj.studies.measure.mechanism import Mechanism


class OneByOne(Exception):
    """Something that arrays do not do: the cases go one by one."""


@dataclass(frozen=True, eq=False)
class Signature:
    """What the cases of a block share, with their numbers as Lanes: a system, its start, and the formulation."""

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
    return Signature(Mechanism(scene, system, state), settings, choice)
