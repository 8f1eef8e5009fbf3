"""The mutations that measure what the tests catch are of the sources as they are."""

from __future__ import annotations

import pytest

from scripts.mutations import Mutation, read_table
from tests.support import ROOT

TABLE = read_table()


def test_half_of_them_are_in_the_kernel() -> None:
    assert len(TABLE) >= 40
    assert 0.4 <= sum(each.is_compiled for each in TABLE) / len(TABLE) <= 0.6


@pytest.mark.parametrize("mutation", TABLE, ids=lambda each: each.name)
def test_a_mutation_changes_one_place_and_names_tests_that_are_there(mutation: Mutation) -> None:
    """Who changes that place writes the new one into scripts/mutations.yaml."""
    assert (ROOT / mutation.file).read_text().count(mutation.old) == 1
    assert mutation.new != mutation.old
    assert mutation.tests
    assert all((ROOT / test).is_file() for test in mutation.tests)
