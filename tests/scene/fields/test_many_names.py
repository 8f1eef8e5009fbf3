"""Scenes with thousands of names: each is looked up, and a wrong one costs no look at all others."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from mbproj.base.errors import MAX_NAMES, Place, choose_from, did_you_mean
from mbproj.scene.fields.fields import NameReference
from mbproj.scene.fields.reading import Reading
from mbproj.scene.text.nodes import from_value


class Names(dict[str, None]):
    """Names that count how many were looked at."""

    looked_at = 0

    def __iter__(self) -> Iterator[str]:
        for name in super().__iter__():
            self.looked_at += 1
            yield name


NAMES = [f"b{number}" for number in range(5000)]


@pytest.mark.parametrize("hint", [choose_from, did_you_mean])
def test_hints_look_at_few_of_many_names(hint) -> None:
    names = Names.fromkeys(NAMES)
    hint("b17x", names)
    assert names.looked_at <= MAX_NAMES + 1


@pytest.mark.parametrize(("name", "found"), [("b4999", "b4999"), ("ground", "ground"), ("b4999x", None)])
def test_a_reference_looks_at_few_of_many_names(name: str, found: str | None) -> None:
    names, place = Names.fromkeys(NAMES), Place("f.yaml", 1, 1)
    reading = Reading(items={"bodies": names})
    assert NameReference("body", "bodies", ("ground",)).read(from_value(name, place), ("joints",), reading) == found
    assert names.looked_at <= MAX_NAMES + 1
    wrong = "unknown body 'b4999x'; choose from: ground, b0, b1, "
    assert [problem.line()[:60] for problem in reading.problems] == (
        [] if found else [f"f.yaml:1:1: error: {wrong}"[:60]]
    )
