"""What a sweep measures of a run: the words of an expectation, without a value to hold it against."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from mbproj.scene.blocks.expectation_checks import CHECKS, expectations_of, unsampled
from mbproj.scene.blocks.expectations import EXPECTATION, SUBJECTS, Given
from mbproj.scene.fields.containers import Complaint, Named, OneOf, Record
from mbproj.scene.fields.fields import Converted, Field
from mbproj.scene.fields.reading import Unfit
from mbproj.scene.records import Expectation, Scene, Settings

_WORDS = (*SUBJECTS, "quantity", "component", "over", "between", "at")

MEASURE: Record[Given] = Record(
    "a measure",
    {key: EXPECTATION.keys[key] for key in _WORDS},
    dict,
    required=("at",),
    choices=(
        OneOf(tuple(SUBJECTS), needed=True, hint="a measure is of one thing; write another for the other"),
        OneOf(("quantity", "diagnostic"), needed=True, hint="a diagnostic is a quantity itself"),
    ),
)


def _some(measures: Mapping[str, Given]) -> Mapping[str, Given]:
    if not measures:
        raise Unfit("is empty", "say what to measure, as in  tip: {marker: tip, quantity: position, ..}")
    return measures


MEASURES: Field[Mapping[str, Given]] = Converted(Named("measure", MEASURE), _some)


def items_of(scene: Scene) -> dict[str, tuple[str, ...]]:
    """The names of what measures may be of, by block: what a `Reading` refers to."""
    return {block: tuple(found) for block, found in _blocks(scene).items()}


def complaints(measures: Mapping[str, Given], scene: Scene) -> Iterator[Complaint]:
    """What the scene does not have of what they ask for."""
    blocks = {**_blocks(scene), "expect": measures}
    for check in CHECKS:
        yield from map(_at_home, check.complaints(blocks, blocks))


def untimely(measures: Mapping[str, Given], settings: Settings) -> Iterator[Complaint]:
    """Times at which a run with these settings has no sample."""
    return map(_at_home, unsampled(measures, settings))


def measures_of(measures: Mapping[str, Given], scene: Scene) -> tuple[Expectation, ...]:
    """The records, of measures that the scene has: expectations of nothing in particular."""
    given = {name: {**words, "source": ""} for name, words in measures.items()}
    return tuple(expectations_of({**_blocks(scene), "expect": given}))


def _at_home(found: Complaint) -> Complaint:
    return found._replace(path=("measure", *found.path[1:]))


def _blocks(scene: Scene) -> dict[str, Mapping[str, Any]]:
    kinds: Mapping[str, Any] = {
        "bodies": scene.bodies,
        "joints": scene.joints,
        "forces": scene.forces,
        "motions": scene.motions,
        "markers": scene.markers,
        "signals": scene.signals,
        "states": scene.states,
        "controllers": scene.controllers,
    }
    return {block: {item.name: item for item in items} for block, items in kinds.items()}
