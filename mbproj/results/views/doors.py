"""`Shown`: what `Results` offers beside arrays: words for a prompt, tables for pandas and xarray, pictures, a page."""

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
from mbproj.results.layout import Dataset
from mbproj.results.members import Coordinate, Over
from mbproj.results.views import frames, summary_text
from mbproj.scene.records import Scene

Same = TypeVar("Same", bound="Shown")


class Shown(ABC):
    """The part of `Results` that others show. What draws is imported when it is asked for: it stands above results."""

    contents: Contents
    attributes: Mapping[str, Any]
    #: What pictures show the samples over, where that is not time.
    shown_over: Over | None = None

    @abstractmethod
    def __getitem__(self, path: str) -> npt.NDArray[Any]: ...

    def __contains__(self, path: object) -> bool:
        """Whether there is a dataset of the layout at a path, "joints/coordinate"."""
        return any(path == dataset.path for dataset in self.datasets)

    @abstractmethod
    def names(self, kind: str) -> tuple[str, ...]:
        """Names of the columns by kind."""

    @property
    @abstractmethod
    def datasets(self) -> tuple[Dataset, ...]:
        """What the file has of the layout."""

    @property
    @abstractmethod
    def time(self) -> Array:
        """(T), in s."""

    @abstractmethod
    def coordinate(self, name: str) -> Coordinate:
        """A joint coordinate by its whole name."""

    def over(self: Same, name: str, *, modulo: bool = False, of: Shown | None = None) -> Same:
        """The same results, which pictures show over a joint coordinate, "A.angle", in place of time; an angle in
        degrees, modulo a turn where that is asked for. `of`: results of the same samples that have it, where this view
        leaves it out. Raises InputError with the nearest name where there is none."""
        found, shown = (of or self).coordinate(name), copy(self)
        values = np.degrees(found.value) if found.unit == "rad" else found.value
        is_turned = modulo and found.unit == "rad"
        shown.shown_over = Over(name, found.unit, values % 360.0 if is_turned else values, found.speed, is_turned)
        return shown

    @property
    def abscissa(self) -> Array:
        """What pictures show the samples over, (T,): time in s, or the coordinate of `over`."""
        return self.time if self.shown_over is None else self.shown_over.values

    @property
    @abstractmethod
    def title(self) -> str:
        """Title of the scene."""

    @property
    @abstractmethod
    def status(self) -> str:
        """How the run ended."""

    def __repr__(self) -> str:
        if not self.contents.is_open:
            return f"Results of '{self.contents.path}', closed"
        return summary_text.as_text(self.title, self._rows())

    def _repr_html_(self) -> str | None:
        """What a notebook shows; None for the text of closed results."""
        return summary_text.as_html(self.title, self._rows()) if self.contents.is_open else None

    def _rows(self) -> list[tuple[str, str]]:
        return summary_text.rows(self.status, self.time, self.names, self.attributes)

    def to_pandas(self) -> Any:
        """A DataFrame: the index is time in s, columns are (kind, name, quantity): `["markers"]["tip"]["position_x"]`.
        `attrs["units"]` has the unit of each column. Raises ImportError where pandas is not installed."""
        return frames.to_pandas(self.datasets, self.names, self.__getitem__)

    def to_xarray(self) -> Any:
        """A Dataset with the dimensions time, body, joint, marker, ..., all with their names as coordinates. Raises
        ImportError where xarray is not installed."""
        about = {"title": self.title, "status": self.status}
        return frames.to_xarray(self.datasets, self.names, self.__getitem__, about)

    @property
    def scene(self) -> Scene:
        """The scene of the run, read again. Raises InputError where its bodies are not those of the results."""
        found: Scene = import_module("mbproj.pages.appearance.recorded").scene_of(self)
        return found

    @property
    def plot(self) -> Any:
        """Pictures by kind, as `results.plot.reactions("A")`: see `mbproj.calls.pictures.Plots`."""
        return import_module("mbproj.calls.pictures").Plots(self)

    def animate(self) -> Any:
        """The page of `mbproj animate`, which a notebook shows: see `mbproj.calls.pictures.Page`."""
        return import_module("mbproj.calls.pictures").page(self)
