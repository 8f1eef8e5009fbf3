"""The projection methods, one file each in `methods`; `make_method` finds them by the names of `mbproj.registry`."""

from __future__ import annotations

from importlib import import_module

from mbproj.projection.methods.method import Method, Projection
from mbproj.projection.solve import ProjectedState, project_after
from mbproj.registry import PROJECTIONS
from mbproj.scene.records import ProjectionSettings

__all__ = ["Method", "ProjectedState", "Projection", "make_method", "project_after"]


def make_method(settings: ProjectionSettings) -> Method:
    """Return the method that the settings name, made with its options from them (`ProjectionEntry.options`)."""
    entry = PROJECTIONS[settings.method]
    make = entry.factory or import_module(f"mbproj.projection.methods.{entry.module}").METHOD
    method: Method = make(**{option: getattr(settings, option) for option in entry.options})
    return method
