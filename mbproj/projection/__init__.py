"""Projection: the methods, and the iteration to C = 0. `make_method` finds one by its name."""

from __future__ import annotations

from mbproj.projection import methods
from mbproj.projection.methods import Method, Projection
from mbproj.projection.solve import ProjectedState, project_after
from mbproj.registry import PROJECTIONS
from mbproj.scene.records import ProjectionSettings

__all__ = ["Method", "ProjectedState", "Projection", "make_method", "project_after"]


def make_method(settings: ProjectionSettings) -> Method:
    """Return the method that the settings name, made with its options from them (`ProjectionEntry.options`)."""
    entry = PROJECTIONS[settings.method]
    make = entry.factory or getattr(methods, entry.name)
    method: Method = make(**{option: getattr(settings, option) for option in entry.options})
    return method
