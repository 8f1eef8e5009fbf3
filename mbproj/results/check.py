"""Reads all of a results file and compares it with its checksums (`info --check`)."""

from __future__ import annotations

from collections.abc import Iterator
from math import prod

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError
from mbproj.base.sandbox import try_in_sandbox
from mbproj.results.file.contents import UNCHECKED
from mbproj.results.layout import CONSTANTS, NAMES, Dataset
from mbproj.results.reader import BESIDE_SAMPLES
from mbproj.results.record import Results

SCENE = ("scene/text", "scene/path", "scene/title", "scene/settings", "scene/overrides", "scene/gravity")


@dataclass(frozen=True)
class Soundness:
    """The result of a check: the faults of a file, a sentence each, and how many datasets and bytes were read.
    `unguarded` are the datasets without a checksum, which an older mbproj wrote."""

    faults: tuple[str, ...]
    datasets: int
    bytes: int
    unguarded: tuple[str, ...]


def check_results(results: Results) -> Soundness:
    """Read every dataset and attribute of the layout, one after another, and return what was found."""
    constants = [entry.path for entry in CONSTANTS if results.contents.has(entry.path)]
    paths = [*SCENE, *(entry.path for entry in NAMES.values()), *constants, *(entry.path for entry in results.datasets)]
    faults = [*_beside_samples(results, constants), *_of_samples(results), *_of_descriptions(results)]
    unguarded = tuple(path for path in paths if not results.contents.is_guarded(path))
    size = sum(8 * prod(results.shape(dataset.path)) for dataset in results.datasets)
    return Soundness(tuple(dict.fromkeys(faults)), len(paths), size, unguarded)


def _beside_samples(results: Results, constants: list[str]) -> Iterator[str]:
    """Yield the faults of the parts beside the samples. Names and attributes were checked when the file was opened."""
    for name in BESIDE_SAMPLES:
        try:
            getattr(results, name)
        except InputError as error:
            yield from _messages(results, error)
    for read in (results.better, results.meshes):
        try:
            read()
        except InputError as error:
            yield from _messages(results, error)
    for path in constants:
        try:
            results.constant(path)
        except InputError as error:
            yield from _messages(results, error)


def _of_descriptions(results: Results) -> Iterator[str]:
    """Yield the faults in the descriptions and units of all datasets. A child process reads them first, since HDF5 may
    search for the text of a damaged attribute without end."""
    contents, units = results.contents, {dataset.path: dataset.unit for dataset in results.datasets}

    def look() -> Iterator[InputError]:
        for path in contents.datasets():
            try:
                contents.check_description(path)
                if path in units and contents.unit(path) != units[path]:
                    yield contents.damaged(path, f"has another unit than '{units[path]}'")
            except InputError as error:
                yield error

    try:
        try_in_sandbox(lambda: list(look()), contents.path, "descriptions")
        for error in look():
            yield from _messages(results, error)
    except InputError as error:
        yield from _messages(results, error)


def _of_samples(results: Results) -> Iterator[str]:
    for dataset in results.datasets:
        try:
            yield from _of_dataset(results, dataset)
        except InputError as error:
            spans = results.contents.unreadable_rows(dataset.path, results.shape("time")[0])
            places = "".join(f", samples {first} to {last}" for first, last in spans)
            yield from (message + places for message in _messages(results, error))


def _of_dataset(results: Results, dataset: Dataset) -> Iterator[str]:
    contents, (samples, *columns) = results.contents, results.shape(dataset.path)
    rows = contents.rows(dataset.path, tuple(columns), dataset.dtype)
    if rows != samples and not contents.unfinished:
        yield f"'{dataset.path}' has {rows} samples where others have {samples}"
    for first, last in contents.unreadable_rows(dataset.path, samples) if contents.unfinished else ():
        yield f"samples {first} to {last} of '{dataset.path}' {UNCHECKED}"
    contents.array(dataset.path, (None, *columns), dataset.dtype, slice(0, samples))
    if dataset.path == "time":
        _ = results.time  # raises InputError where times do not ascend


def _messages(results: Results, error: InputError) -> Iterator[str]:
    return (problem.message.removeprefix(f"'{results.path}' is damaged: ") for problem in error.problems)
