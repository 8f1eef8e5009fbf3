"""The file of a sweep: a scene, the ranges of its varied values, their combination, and the measures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import field
from pathlib import Path
from typing import Any

from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Place, Problem
from mbproj.scene.blocks.expectations import Given
from mbproj.scene.blocks.measures import MEASURES, complaints, items_of, measures_of, untimely
from mbproj.scene.fields.choices import NameChoice
from mbproj.scene.fields.containers import ByPath, Record
from mbproj.scene.fields.fields import Text
from mbproj.scene.fields.quantities import Integer
from mbproj.scene.fields.reading import Reading, in_text_order
from mbproj.scene.ranges import RANGE, Listed, Points
from mbproj.scene.ranges.family import column_of, read_mapping, scene_named, units_of
from mbproj.scene.read import SceneText
from mbproj.scene.records import Expectation, KeyPath
from mbproj.scene.settings import settings_to_run
from mbproj.scene.text.changes import Change
from mbproj.scene.text.nodes import Node, from_value
from mbproj.studies.sweep.design import COMBINATIONS, Design, Zip, design_of

FORMAT = "1"
#: The most values of a list, or cases of a zip, that are checked before the sweep. Any other value that does not fit
#: makes a failed case.
MOST = 300
#: The cases whose results files are kept.
KEEP = ("none", "failed", "all")
#: Columns of the summary that are neither parameters nor measures.
COLUMNS = ("case", "status", "message", "time", "joint", "formulation", "seconds", "file")
SPEC: Record[dict[str, Any]] = Record(
    "a sweep",
    {
        "sweep": NameChoice("format version", lambda: (FORMAT,)),
        "scene": Text(),
        "vary": ByPath(
            "path of a value of the scene: a range", RANGE, "say what varies, as in  parameters.length: 0.8:1.2:5"
        ),
        "combine": NameChoice("combination", lambda: COMBINATIONS),
        "samples": Integer(1),
        "seed": Integer(0),
        "measure": MEASURES,
        "keep": NameChoice("word for what to keep", lambda: KEEP),
    },
    dict,
    required=("sweep", "scene", "vary", "measure"),
)


@dataclass(frozen=True, eq=False)
class SweepSpec:
    """The content of a sweep's file. `units` are those of the parameters, by path, "" where unknown. `places` are those
    of the keys."""

    path: Path
    text: str = field(repr=False)
    scene: SceneText
    design: Design
    units: Mapping[str, str]
    measures: tuple[Expectation, ...]
    keep: str
    places: Mapping[KeyPath, Place] = field(repr=False)

    def place(self, *path: str | int) -> Place | None:
        """The place of a key in the file."""
        return self.places.get(path)


def read_spec(path: Path) -> SweepSpec:
    """The sweep in the file at `path`. Raises InputError with every problem, at its place in the file or the scene."""
    text, root, reading = read_mapping(path, SPEC.what, f"it begins with 'sweep: {FORMAT}'")
    scene, base = scene_named(path, root, reading, SPEC)
    reading.items = items_of(base)
    blocks = SPEC.read(root, (), reading)
    if blocks is None:
        raise InputError(in_text_order(reading.problems))
    for complaint in complaints(blocks["measure"], base):
        reading.report(complaint.message, reading.places[complaint.path], complaint.hint)
    _check_names(blocks, reading)
    combine = blocks.get("combine", COMBINATIONS[0])
    design = design_of(blocks["vary"], combine, blocks.get("samples"), blocks.get("seed"), reading)
    if design is None or reading.problems:
        raise InputError(in_text_order(reading.problems))
    reading.problems += _misfits(scene, design, blocks["measure"], reading.places)
    if reading.problems:
        raise InputError(in_text_order(reading.problems))
    return SweepSpec(
        path=path,
        text=text,
        scene=scene,
        design=design,
        units=units_of({path: each.dimension for path, each in blocks["vary"].items()}, scene),
        measures=measures_of(blocks["measure"], base),
        keep=blocks.get("keep", KEEP[0]),
        places=reading.places,
    )


def _check_names(blocks: Mapping[str, Any], reading: Reading) -> None:
    """Report measures that have the name of another column of the summary."""
    taken = {column_of(path) for path in blocks["vary"]} | {*COLUMNS}
    for name in blocks["measure"]:
        if name in taken:
            place = reading.places[("measure", name)]
            reading.report(f"'{name}' is another column of the summary", place, "give the measure another name")


def _misfits(
    scene: SceneText, design: Design, measures: Mapping[str, Given], places: Mapping[KeyPath, Place]
) -> list[Problem]:
    """The problems that the scene's reader finds with values of the sweep, and the measures that runs with these values
    would not have."""
    problems: list[Problem] = []
    for changes in _probes(design, places):
        try:
            read = scene.scene(changes)
            settings = settings_to_run(read)
        except InputError as error:
            problems += error.problems
            continue
        for complaint in untimely(measures, settings):
            problems.append(Problem(complaint.message, places[complaint.path], complaint.hint))
    return list(dict.fromkeys(problems))


def _probes(design: Design, places: Mapping[KeyPath, Place]) -> Iterator[dict[str, Change]]:
    """Yield cases such that each value written in the file occurs."""
    where = {path: places[("vary", path)] for path in design.paths}
    if isinstance(design, Zip):
        for number in range(min(design.count, MOST)):
            nodes = {path: _node(each, number, where[path]) for path, each in design.ranges.items()}
            yield {path: Change(node, where[path]) for path, node in nodes.items()}
        return
    first = {path: Change(each.nodes[0], where[path]) for path, each in design.ranges.items()}
    yield first
    for path, each in design.ranges.items():
        for node in each.nodes[1:MOST]:
            yield first | {path: Change(node, where[path])}


def _node(values: Points, number: int, place: Place) -> Node:
    """A value as written in the file, or as a number where it follows from the ends of a range."""
    if isinstance(values, Listed):
        return values.nodes[number if values.count > 1 else 0]
    ends = {0: 0, values.count - 1: 1}
    return values.nodes[ends[number]] if number in ends else from_value(values.item(number), place)
