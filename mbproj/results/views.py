"""Results as tables of other libraries, which are optional: a DataFrame of pandas, a Dataset of xarray."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from mbproj.results.layout import ALL_NAMES, Dataset

Names = Callable[[str], tuple[str, ...]]
Read = Callable[[str], npt.NDArray[Any]]
#: The kind of the names of columns, and the name of their dimension, by symbol.
AXES = {
    "n": ("bodies", "body"),
    "k": ("markers", "marker"),
    "nj": ("joints", "joint"),
    "nc": ("coordinates", "coordinate"),
    "nf": ("forces", "force"),
    "na": ("applied", "applied"),
    "nm": ("motions", "motion"),
    "ns": ("stops", "stop"),
    "nr": ("frictions", "friction"),
    "nx": ("states", "state"),
    "nu": ("signals", "signal"),
    "nt": ("tensions", "tension"),
    "nv": ("touching", "touching"),
}
#: The name of the dimension and the names of components, by the number of components.
COMPONENTS = {3: ("axis", ("x", "y", "z")), 4: ("euler_parameter", ("0", "1", "2", "3"))}


class TableColumn(NamedTuple):
    """A column of a table: its kind, name and quantity, its unit, its values (T,)."""

    kind: str
    name: str
    quantity: str
    unit: str
    values: npt.NDArray[Any]


def columns(datasets: Sequence[Dataset], names: Names, read: Read) -> Iterator[TableColumn]:
    """All columns but time, in the order of the layout."""
    for dataset in datasets:
        group, _, quantity = dataset.path.partition("/")
        if dataset.path == "time":
            continue
        if dataset.symbol is None:
            yield TableColumn(group, "", quantity, dataset.unit, read(dataset.path))
            continue
        kind, _ = AXES[dataset.symbol]
        for number, name in enumerate(names(kind)):
            values = read(dataset.path)[:, number]
            if values.ndim == 1:
                yield TableColumn(kind, name, quantity, dataset.unit, values)
                continue
            _, components = COMPONENTS[values.shape[1]]
            for component, part in zip(components, values.T, strict=True):
                yield TableColumn(kind, name, f"{quantity}_{component}", dataset.unit, part)


def to_pandas(datasets: Sequence[Dataset], names: Names, read: Read) -> Any:
    """The DataFrame that `Results.to_pandas` describes."""
    pandas = needed("pandas")
    listed = list(columns(datasets, names, read))
    header = pandas.MultiIndex.from_tuples([each[:3] for each in listed], names=["kind", "name", "quantity"])
    index = pandas.Index(read("time"), name="time")
    frame = pandas.DataFrame(np.column_stack([each.values for each in listed]), index, header)
    frame.attrs["units"] = {each[:3]: each.unit for each in listed}
    return frame


def to_xarray(datasets: Sequence[Dataset], names: Names, read: Read, about: Mapping[str, str]) -> Any:
    """The Dataset that `Results.to_xarray` describes."""
    xarray = needed("xarray")
    coordinates: dict[str, Any] = {"time": ("time", read("time"), {"units": "s"})}
    variables: dict[str, Any] = {}
    for dataset in datasets:
        if dataset.path == "time":
            continue
        dimensions = ["time"]
        for size in dataset.shape:
            kind, axis = AXES[size] if isinstance(size, str) else ("", COMPONENTS[size][0])
            labels = names(kind) if isinstance(size, str) else COMPONENTS[size][1]
            coordinates.setdefault(axis, (axis, np.array(labels, dtype=str)))
            dimensions.append(axis)
        attributes = {"units": dataset.unit, "long_name": dataset.description}
        attributes |= {"frame": dataset.frame} if dataset.frame else {}
        variables[dataset.path.replace("/", "_")] = (dimensions, read(dataset.path), attributes)
    for kind, entry in ALL_NAMES.items():
        units = names(kind) if kind.endswith("_units") else ()
        if units:
            axis = AXES[entry.symbol][1]
            coordinates[f"{axis}_unit"] = (axis, np.array(units, dtype=str))
    return xarray.Dataset(variables, coordinates, dict(about))


def needed(name: str) -> Any:
    """Import an optional library. Raises ImportError that says what to install where it is missing."""
    try:
        return import_module(name)
    except ImportError as error:
        raise ImportError(f"{name} is not installed, which makes this table: pip install 'mbproj[tables]'") from error
