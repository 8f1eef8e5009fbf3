"""Projection: the methods, and the iteration to C = 0. `make_method` finds one by its name."""

from __future__ import annotations

from collections.abc import Mapping

from mbproj.projection.methods import (
    Baumgarte,
    Gopm,
    Gpopm,
    GpopmPinv,
    MassOrthogonal,
    Method,
    Mmopm,
    Popm,
    Projection,
    Unprojected,
)
from mbproj.projection.solve import ProjectedState, project_after
from mbproj.registry import PROJECTIONS
from mbproj.scene.records import ProjectionSettings

__all__ = ["Method", "ProjectedState", "Projection", "make_method", "project_after"]


#: The paper's methods by the names of their classes, which `PROJECTIONS` has.
METHODS: Mapping[str, type[Method]] = {
    kind.__name__: kind for kind in (Unprojected, Baumgarte, Gopm, Popm, MassOrthogonal, Mmopm, GpopmPinv, Gpopm)
}


def make_method(settings: ProjectionSettings) -> Method:
    """Return the method that the settings name, made with its options from them (`ProjectionEntry.options`)."""
    entry = PROJECTIONS[settings.method]
    make = entry.factory or METHODS[entry.name]
    method: Method = make(**{option: getattr(settings, option) for option in entry.options})
    return method
