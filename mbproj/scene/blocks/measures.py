"""The measures of a sweep, evaluated on each run: each is written as an expectation without a value."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from mbproj.scene.blocks.expectation_checks import CHECKS, expectations_of, unsampled
from mbproj.scene.blocks.expectations import EXPECTATION, SUBJECTS, Given
from mbproj.scene.fields.containers import Complaint, Named, OneOf, Record
from mbproj.scene.fields.fields import Converted, Field
from mbproj.scene.fields.reading import Unfit
from mbproj.scene.records import Expectation, Settings

if TYPE_CHECKING:
    from mbproj.scene.read import Scene

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
    """The names of the items that measures may be about, by block, as a `Reading` has them."""
    return {block: tuple(items) for block, items in _blocks(scene).items()}


def complaints(measures: Mapping[str, Given], scene: Scene) -> Iterator[Complaint]:
    """Complaints about measures of items or quantities that the scene does not have."""
    blocks = {**_blocks(scene), "expect": measures}
    for check in CHECKS:
        yield from map(_under_measure, check.complaints(blocks, blocks))


def untimely(measures: Mapping[str, Given], settings: Settings) -> Iterator[Complaint]:
    """Complaints about measures at times at which a run with these settings has no sample."""
    return map(_under_measure, unsampled(measures, settings))


def measures_of(measures: Mapping[str, Given], scene: Scene) -> tuple[Expectation, ...]:
    """The records of measures that passed the checks: expectations without a value or a bound."""
    given = {name: {**words, "source": ""} for name, words in measures.items()}
    return tuple(expectations_of({**_blocks(scene), "expect": given}))


def _under_measure(complaint: Complaint) -> Complaint:
    """The complaint about an expectation as one about the key `measure`."""
    return complaint._replace(path=("measure", *complaint.path[1:]))


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
