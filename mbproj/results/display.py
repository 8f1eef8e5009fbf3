"""`Shown`: views of `Results` beside arrays: text for a prompt, tables for pandas and xarray, pictures, a page."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from copy import copy
from importlib import import_module
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from mbproj.arrays import Array
from mbproj.results.file.contents import Contents
from mbproj.results.layout import MARKS, Dataset
from mbproj.results.members import Coordinate, Over
from mbproj.scene.records import Scene

Same = TypeVar("Same", bound="Shown")


class Shown(ABC):
    """The part of `Results` that displays it. Drawing is imported when it is used: it belongs to folders above."""

    contents: Contents
    attributes: Mapping[str, Any]
    #: The abscissa of pictures, where that is not time.
    shown_over: Over | None = None

    @abstractmethod
    def __getitem__(self, path: str) -> npt.NDArray[Any]: ...

    def __contains__(self, path: object) -> bool:
        """Whether the file has an array of the layout at a path, as "joints/coordinate"."""
        return any(path == dataset.path for dataset in self.datasets) or (
            path in MARKS and self.contents.has(str(path))
        )

    @abstractmethod
    def names(self, kind: str) -> tuple[str, ...]:
        """The names of the columns of a kind."""

    @property
    @abstractmethod
    def datasets(self) -> tuple[Dataset, ...]:
        """The datasets of the layout that the file has."""

    @property
    @abstractmethod
    def time(self) -> Array:
        """The times of the samples (T,), in s."""

    @abstractmethod
    def coordinate(self, name: str) -> Coordinate:
        """A joint coordinate by its full name."""

    def over(self: Same, name: str, *, modulo: bool = False, of: Shown | None = None) -> Same:
        """These results with a joint coordinate, as "A.angle", in place of time as the abscissa of pictures. An angle
        is in degrees, with `modulo` within a turn. `of` are results of the same samples that have the coordinate, where
        this view leaves it out. Raises InputError with the nearest name where there is none."""
        coordinate, shown = (of or self).coordinate(name), copy(self)
        values = np.degrees(coordinate.value) if coordinate.unit == "rad" else coordinate.value
        is_turned = modulo and coordinate.unit == "rad"
        shown.shown_over = Over(
            name, coordinate.unit, values % 360.0 if is_turned else values, coordinate.speed, is_turned
        )
        return shown

    @property
    def abscissa(self) -> Array:
        """The abscissa (T,) of pictures: time in s, or the coordinate of `over`."""
        return self.time if self.shown_over is None else self.shown_over.values

    @property
    @abstractmethod
    def title(self) -> str:
        """The title of the scene."""

    @property
    @abstractmethod
    def status(self) -> str:
        """The status of the run, which says how it ended."""

    def __repr__(self) -> str:
        if not self.contents.is_open:
            return f"Results of '{self.contents.path}', closed"
        from mbproj.results.views.summary_text import as_text, rows

        return as_text(self.title, rows(self.status, self.time, self.names, self.attributes))

    def _repr_html_(self) -> str | None:
        """The HTML that a notebook shows; None for closed results, whose text it shows instead."""
        if not self.contents.is_open:
            return None
        from mbproj.results.views.summary_text import as_html, rows

        return as_html(self.title, rows(self.status, self.time, self.names, self.attributes))

    def to_pandas(self) -> Any:
        """A DataFrame: the index is time in s, columns are (kind, name, quantity): `["markers"]["tip"]["position_x"]`.
        `attrs["units"]` has the unit of each column. Raises ImportError where pandas is not installed."""
        from mbproj.results.views.frames import to_pandas

        return to_pandas(self.datasets, self.names, self.__getitem__)

    def to_xarray(self) -> Any:
        """A Dataset with the dimensions time, body, joint, marker, ..., all with their names as coordinates. Raises
        ImportError where xarray is not installed."""
        from mbproj.results.views.frames import to_xarray

        about = {"title": self.title, "status": self.status}
        return to_xarray(self.datasets, self.names, self.__getitem__, about)

    @property
    def scene(self) -> Scene:
        """The scene of the run, read again. Raises InputError where its bodies are not those of the results."""
        drawn: Scene = import_module("mbproj.pages.appearance.recorded").scene_of(self)
        return drawn

    @property
    def plot(self) -> Any:
        """The pictures by kind, as `results.plot.reactions("A")`: see `mbproj.api.pictures.Plots`."""
        return import_module("mbproj.api.pictures").Plots(self)

    def animate(self) -> Any:
        """The page of `mbproj animate`, which a notebook shows: see `mbproj.api.pictures.Page`."""
        return import_module("mbproj.api.pictures").page(self)
