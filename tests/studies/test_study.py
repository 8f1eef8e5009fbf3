"""The engine of the studies: results by name and in order, resumed where they are stored, with words on the best."""

from __future__ import annotations

import pytest

from mbproj.studies.study import Study
from tests.studies.tasks import fragile


def told(study: Study) -> list[tuple[str, int, int]]:
    seen: list[tuple[str, int, int]] = []
    study.tell = lambda *what: seen.append(what)
    return seen


@pytest.mark.parametrize("where", [1, 3])
def test_results_come_in_the_order_of_the_items_and_only_once(where):
    items = {f"number {k}": k for k in (5, 1, 4)}
    first = Study({"span": where}, int, where)
    assert first.each(fragile, 0.0, {"number 1": 1}, "squares") == [1]
    again = Study({"span": where}, int, where)
    seen = told(again)
    assert again.each(fragile, 0.0, items, "squares", lambda square: (square, f"least {square}")) == [25, 1, 16]
    assert seen == [("squares; least 1", done, 3) for done in (1, 2, 3)]
    assert again.one("number 5", lambda: pytest.fail("it is known")) == 25
    other = Study({"span": where}, str, where)  # of another type: nothing is taken
    assert other.results == {}


def test_an_item_that_fails_leaves_the_others_stored():
    study = Study("fails", int)
    with pytest.raises(TypeError):
        study.each(fragile, 0.0, {"2": 2, "wrong": None, "3": 3}, "squares")
    assert Study("fails", int).results == {"2": 4}
    assert Study("fails", int, fresh=True).results == {}
    assert Study("fails", int).results == {}
