"""Whether the values of a sweep fit its scene: read as the scene's own, before anything runs, at their places in the
sweep's file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from mbproj.errors import InputError, Place, Problem
from mbproj.scene.blocks.expectations import Given
from mbproj.scene.blocks.measures import untimely
from mbproj.scene.ranges import Listed, Points
from mbproj.scene.read import SceneText
from mbproj.scene.records import KeyPath
from mbproj.scene.settings import settings_to_run
from mbproj.scene.text.changes import Change
from mbproj.scene.text.nodes import Node, from_value
from mbproj.studies.sweep.design import Design, Zip

#: Values of a list, or cases of a zip, that are looked at; of the others each that does not fit is a failed case.
MOST = 300
#: Places by the keys of the sweep's file.
Places = Mapping[KeyPath, Place]


def misfits(scene: SceneText, design: Design, measures: Mapping[str, Given], places: Places) -> list[Problem]:
    """What the scene's reader says of them, and what a run with them does not measure."""
    found: list[Problem] = []
    for changes in _probes(design, places):
        try:
            read = scene.scene(changes)
            settings = settings_to_run(read)
        except InputError as error:
            found += error.problems
            continue
        for complaint in untimely(measures, settings):
            found.append(Problem(complaint.message, places[complaint.path], complaint.hint))
    return list(dict.fromkeys(found))


def _probes(design: Design, places: Places) -> Iterator[dict[str, Change]]:
    """Cases in which each value that is written down occurs."""
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
    """A value as it is written down, or as a number where it follows from others."""
    if isinstance(values, Listed):
        return values.nodes[number if values.count > 1 else 0]
    ends = {0: 0, values.count - 1: 1}
    return values.nodes[ends[number]] if number in ends else from_value(values.item(number), place)
