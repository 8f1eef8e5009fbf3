"""Ranges: how they are written, what values they have, and what is said of wrong ones."""

from __future__ import annotations

from itertools import pairwise
from math import log

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbproj.errors import InputError
from mbproj.scene.fields.reading import Reading
from mbproj.scene.ranges import RANGE, Listed, Normal, Points, Spaced, Uniform, given_range, named_range
from mbproj.scene.text.document import compose
from mbproj.scene.text.nodes import flow


def read(text):
    """The range that the value of a key is, or the lines of what is wrong with it."""
    root, _ = compose(f"key: {text}", "spec.yaml")
    reading = Reading()
    found = RANGE.read(root.values["key"], ("key",), reading)
    return found if found is not None else [problem.line() for problem in reading.problems]


def test_evenly_spaced_values_begin_and_end_where_they_are_told_to():
    for text in ("0.8 m:120 cm:5", "{linspace: [0.8 m, 120 cm, 5]}"):
        found = read(text)
        assert isinstance(found, Spaced)
        assert found.items == pytest.approx((0.8, 0.9, 1.0, 1.1, 1.2), rel=1e-15)
        assert (found.item(0), found.item(4)) == (0.8, 1.2)
        assert [flow(node) for node in found.nodes] == ["0.8 m", "120 cm"]


def test_logarithms_are_evenly_spaced():
    for text in ("1:1000:4:log", "{log: [1, 1000, 4]}"):
        found = read(text)
        assert found.items == pytest.approx((1.0, 10.0, 100.0, 1000.0), rel=1e-14)
        assert (found.item(0), found.item(3)) == (1.0, 1000.0)


def test_a_list_holds_numbers_in_si_words_and_lists_of_their_own():
    assert read("[1 g, gopm, [0, 0, 1], 2 * length]").items == (0.001, "gopm", "[0, 0, 1]", "2 * length")
    assert read("2 m").items == (2.0,)
    assert given_range("1,2,4", "--vary").items == (1.0, 2.0, 4.0)


def test_distributions_have_their_quantiles():
    uniform, normal = read("{uniform: [1 m, 3 m]}"), read("{normal: {mean: 100 mm, deviation: 0.1 mm}}")
    assert isinstance(uniform, Uniform)
    assert isinstance(normal, Normal)
    assert uniform.quantile(0.25) == 1.5
    assert normal.quantile(0.5) == pytest.approx(0.1)
    assert normal.quantile(0.8413447460685429) == pytest.approx(0.1001, abs=1e-12)  # Φ(1)
    assert not isinstance(uniform, Points)


@given(st.floats(1e-3, 1e3), st.floats(1e-3, 1e3), st.integers(2, 50), st.booleans())
def test_values_are_evenly_spaced_in_their_measure(first, last, count, logarithmic):
    found = Spaced((), None, first, last, count, logarithmic)
    numbers = [log(item) if logarithmic else item for item in found.items]
    steps = [two - one for one, two in pairwise(numbers)]
    assert steps == pytest.approx([(numbers[-1] - numbers[0]) / (count - 1)] * (count - 1), abs=1e-9)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("1:2", "spec.yaml:1:6: error: 'key' needs first:last:count, found '1:2'"),
        ("1:2:1", "spec.yaml:1:10: error: 'count' must be at least 2, found 1"),
        ("1:x:3", "spec.yaml:1:8: error: unknown name 'x'; parameters are defined under 'parameters'"),
        ("0:1:3:log", "spec.yaml:1:6: error: 'key' needs numbers above 0 for their logarithms"),
        ("{linspac: [1, 2, 3]}", "spec.yaml:1:7: error: unknown range 'linspac'; did you mean 'linspace'?"),
        ("{uniform: [1 m, 2 kg]}", "spec.yaml:1:22: error: a length and a mass are no range"),
        ("{uniform: [2, 1]}", "spec.yaml:1:16: error: 'uniform' has nothing between 2 and 1"),
        ("{normal: {mean: 1}}", "spec.yaml:1:7: error: 'normal' needs {mean: .., deviation: ..}, found a mapping"),
        (
            "{normal: {mean: 1, deviation: 0}}",
            "spec.yaml:1:36: error: 'deviation' must be greater than 0, found 0",
        ),
        (
            "[]",
            "spec.yaml:1:6: error: 'key' needs a list of values, first:last:count, or one of {linspace, log, uniform, "
            "normal}, found a list of 0",
        ),
    ],
)
def test_what_is_wrong_is_said_at_its_place(text, line):
    assert read(text) == [line]


def test_an_option_names_what_varies():
    name, found = named_range("crank = 1 mm:3 mm:3", "--vary")
    assert (name, found.items) == ("crank", (0.001, 0.002, 0.003))
    assert isinstance(named_range("projection=gopm,gpopm", "--vary")[1], Listed)
    with pytest.raises(InputError, match="--vary: error: 'crank' is not NAME=RANGE; e"):
        named_range("crank", "--vary")
    with pytest.raises(InputError, match="--vary crank: error: '--vary crank' needs first:last:count, found '1:2'"):
        named_range("crank=1:2", "--vary")
