"""Whether two results are of the same motion, where they part, and over which horizon an error is known."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mbproj.base.errors import InputError
from mbproj.results.analysis.comparison import COMPARED, MotionComparison, compare_motions
from mbproj.results.analysis.trust import growth, horizons, settled
from mbproj.results.reader import open_results
from mbproj.results.writer import ResultsWriter
from tests.results.pendulum_blocks import NAMES, block, scene, times

# Two results of a pendulum in closed form: the same motion, and where they part when one is disturbed.

Change = Callable[[dict[str, Any]], None]


def write(
    path: Path, time: np.ndarray, change: Change = lambda values: None, names: Any = NAMES, marks: Any = None
) -> Path:
    with ResultsWriter(path, scene(), names, marks or {}) as writer:
        values = {key: np.array(value) for key, value in block(time, names).items()}
        change(values)
        writer.write(values)
    return path


def compared(tmp_path: Path, change: Change, tolerance: float = 1e-6, **absolute: float) -> MotionComparison:
    paths = write(tmp_path / "a.h5", times()), write(tmp_path / "b.h5", times(), change)
    limits = {name.replace("__", "/"): value for name, value in absolute.items()}
    with open_results(paths[0]) as one, open_results(paths[1]) as other:
        return compare_motions(one, other, tolerance, limits)


def test_the_same(tmp_path: Path) -> None:
    found = compared(tmp_path, lambda values: None)
    assert (found.same, found.parting, found.samples, found.missing) == (True, None, 201, {})
    assert {each.quantity for each in found.quantities} == {entry.path for entry in COMPARED}
    assert all(each.largest.difference == 0.0 for each in found.quantities)


def test_where_they_part(tmp_path: Path) -> None:
    def change(values: dict[str, Any]) -> None:
        values["markers/position"][120:, 1, 2] += 1e-3
        values["bodies/velocity"][150, 0] += [3e-3, 4e-3, 0.0]

    found = compared(tmp_path, change)
    assert found.parting is not None
    assert found.parting.quantity == "markers/position"
    first = found.parting.first
    assert first is not None
    assert (first.name, first.time) == ("Mitte", pytest.approx(1.2))
    assert first.difference == pytest.approx(1e-3, rel=1e-12)
    velocity = next(each for each in found.quantities if each.quantity == "bodies/velocity")
    assert (velocity.largest.difference, velocity.largest.time) == (pytest.approx(5e-3, rel=1e-9), 1.5)
    assert not found.same


def test_an_absolute_limit_goes_over_the_relative_one(tmp_path: Path) -> None:
    def change(values: dict[str, Any]) -> None:
        values["markers/position"][120:, 1, 2] += 1e-3

    assert compared(tmp_path, change, markers__position=1.1e-3).same
    assert not compared(tmp_path, change, tolerance=1e-2, markers__position=0.9e-3).same


def test_both_signs_are_one_orientation_and_its_difference_is_an_angle(tmp_path: Path) -> None:
    def change(values: dict[str, Any]) -> None:
        turn, small = values["bodies/orientation"], 1e-3
        turned = np.stack(
            [
                turn[..., 0] * np.cos(small / 2) - turn[..., 1] * np.sin(small / 2),
                turn[..., 0] * np.sin(small / 2) + turn[..., 1] * np.cos(small / 2),
                turn[..., 2],
                turn[..., 3],
            ],
            axis=-1,
        )
        values["bodies/orientation"] = -turned

    found = next(each for each in compared(tmp_path, change).quantities if each.quantity == "bodies/orientation")
    assert (found.unit, found.largest.difference) == ("rad", pytest.approx(1e-3, rel=1e-9))


def test_round_off_about_zero_is_the_same(tmp_path: Path) -> None:
    """Violations apart, x is zero throughout; 1e-17 is all of it, and nothing of the mechanism."""

    def quiet(values: dict[str, Any]) -> None:
        for path in ("joints/reaction_torque", "motions/force"):
            values[path][:] = 0.0

    def noisy(values: dict[str, Any]) -> None:
        quiet(values)
        values["joints/reaction_torque"][:] = 1e-17

    paths = write(tmp_path / "a.h5", times(), quiet), write(tmp_path / "b.h5", times(), noisy)
    with open_results(paths[0]) as one, open_results(paths[1]) as other:
        assert compare_motions(one, other, 1e-9).same


def test_a_nan_is_not_the_same(tmp_path: Path) -> None:
    def change(values: dict[str, Any]) -> None:
        values["joints/speed"][7, 0] = np.nan

    found = compared(tmp_path, change)
    assert found.parting is not None
    assert found.parting.quantity == "joints/speed"


@pytest.mark.filterwarnings("error")
def test_what_is_too_large_to_compare_is_not_the_same(tmp_path: Path) -> None:
    """Its square overflows, and an infinite difference is not less than an infinite limit."""

    def change(values: dict[str, Any]) -> None:
        values["markers/acceleration"][7, 0, 1] = 1e200

    found = compared(tmp_path, change)
    assert found.parting is not None
    assert (found.same, found.parting.quantity) == (False, "markers/acceleration")


def test_reactions_that_joints_share_at_will_are_no_part_of_the_motion(tmp_path: Path) -> None:
    """Components that either of the results marks as not unique are left out, the others are compared."""
    everything = np.ones((len(NAMES["joints"]), 3), dtype=bool)
    shared = everything.copy()
    shared[0, 1] = False
    marks = {"joints/reaction_force_unique": shared, "joints/reaction_torque_unique": everything}

    def load(component: int) -> Change:
        def change(values: dict[str, Any]) -> None:
            values["joints/reaction_force"][90:, 0, component] += 1e3

        return change

    for component, same in ((1, True), (2, False)):
        paths = [write(tmp_path / "a.h5", times()), write(tmp_path / "b.h5", times(), load(component), marks=marks)]
        with open_results(paths[0]) as one, open_results(paths[1]) as other:
            for pair in ((one, other), (other, one)):
                found = compare_motions(*pair, 1e-6)
                assert (found.same, found.left_out) == (same, {NAMES["joints"][0]: "Fy"})


def test_only_shared_times_are_compared_and_a_shorter_run_is_not_the_same(tmp_path: Path) -> None:
    paths = [
        write(tmp_path / f"{name}.h5", time)
        for name, time in (("fine", times()), ("coarse", times(51, 0.04)), ("short", times(101)))
    ]
    with open_results(paths[0]) as fine, open_results(paths[1]) as coarse, open_results(paths[2]) as short:
        other = compare_motions(fine, coarse, 1e-9)
        assert (other.same, other.samples, other.counts) == (True, 51, (201, 51))
        cut = compare_motions(fine, short, 1e-9)
        assert (cut.same, cut.as_long, cut.parting, cut.ends) == (False, False, None, (2.0, 1.0))


def test_names_that_one_has_are_named_and_the_rest_is_compared(tmp_path: Path) -> None:
    fewer = {**NAMES, "markers": ["Mitte"]}
    paths = write(tmp_path / "a.h5", times()), write(tmp_path / "b.h5", times(), names=fewer)
    with open_results(paths[0]) as one, open_results(paths[1]) as other:
        found = compare_motions(one, other, 1e-9)
    assert found.missing == {"markers": ("tip",)}
    assert found.parting is not None  # "Mitte" is the second marker of the one, and the first of the other
    assert found.parting.quantity == "markers/position"


def test_what_cannot_be_compared(tmp_path: Path) -> None:
    shifted, other = times() + 0.005, {**NAMES, "bodies": ["other"]}
    paths = [write(tmp_path / "a.h5", times()), write(tmp_path / "b.h5", shifted)]
    paths.append(write(tmp_path / "c.h5", times(), names=other))
    with open_results(paths[0]) as one, open_results(paths[1]) as late, open_results(paths[2]) as foreign:
        with pytest.raises(InputError, match="no sample time in common; run both with the same --output-step"):
            compare_motions(one, late, 1e-9)
        with pytest.raises(InputError, match="no body in common; give two results of one mechanism"):
            compare_motions(one, foreign, 1e-9)


# Horizons of known errors, and growth laws that are known.

TIME = np.linspace(0.0, 10.0, 1001)


def test_horizons_of_an_exponential_are_where_it_crosses():
    error = 1e-9 * np.exp(2.0 * TIME)[:, None]
    found = horizons(TIME, error, 0.01 * error, np.array([1e-6, 1e-3, 1.0]))
    crossing = np.log(np.array([1e3, 1e6, 1e9])) / 2.0
    np.testing.assert_allclose(found.time[0, :2], crossing[:2], atol=0.01)
    assert found.time[0, 2] == np.inf
    assert np.all(found.low <= found.time)
    assert np.all(found.time <= found.high)
    assert np.all(found.high[0, :2] - found.low[0, :2] < 0.02)
    assert settled(found.low, found.high, TIME).all()


def test_an_error_within_its_uncertainty_leaves_the_horizon_open():
    error = np.full((1001, 1), 1e-6)
    found = horizons(TIME, error, 1e-7 * TIME[:, None], np.array([1.5e-6]))
    assert found.low[0, 0] == pytest.approx(5.0, abs=0.011)
    assert (found.time[0, 0], found.high[0, 0]) == (np.inf, np.inf)
    assert not settled(found.low, found.high, TIME).any()


def test_what_is_not_known_can_exceed_any_limit_but_need_not():
    error = np.where(TIME < 4.0, 1e-9, np.nan)[:, None]
    found = horizons(TIME, error, np.zeros((1001, 1)), np.array([1e-3]))
    assert found.low[0, 0] == pytest.approx(4.0)
    assert found.high[0, 0] == np.inf


@pytest.mark.parametrize(("law", "error"), [("exponential", 1e-9 * np.exp(1.3 * TIME)), ("power", 1e-7 * TIME**2.5)])
def test_growth_laws_are_told_apart_under_oscillations(law, error):
    found = growth(TIME, error * (1.0 + 0.5 * np.sin(9.0 * TIME)), np.zeros_like(TIME), 1e3)
    assert found.law == law
    if law == "exponential":
        assert found.rate == pytest.approx(1.3, rel=0.05)
    else:
        assert found.power == pytest.approx(2.5, rel=0.1)


def test_growth_stops_counting_where_the_error_is_as_large_as_the_motion():
    error = np.minimum(1e-6 * np.exp(3.0 * TIME), 2.0)
    assert growth(TIME, error, np.zeros_like(TIME), 5.0).rate == pytest.approx(3.0, rel=1e-3)


def test_an_error_that_does_not_grow_or_is_not_known_has_no_law():
    for error, unsure in ((np.full_like(TIME, 1e-9), 0.0), (1e-9 * np.exp(TIME), 1.0)):
        found = growth(TIME, error, np.full_like(TIME, unsure), 1.0)
        assert found.law == ""
        assert np.isnan(found.rate)
        assert np.isnan(found.power)
