"""Expectations against results in closed form: a pendulum's small swing of 0.2 rad at 3 rad/s over 2 s."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from mbproj.results.analysis.expectations import Outcome, outcomes, series
from mbproj.results.layout import DATASETS
from mbproj.results.reader import open_results
from mbproj.results.record import Results
from mbproj.scene.blocks.observables import MECHANICAL_ADVANTAGE, OBSERVABLES, TRANSMISSION_ANGLE, VELOCITY_RATIO
from mbproj.scene.records import Expectation
from tests.results.pendulum_blocks import AMPLITUDE, LENGTH, RATE, record


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Results:
    return open_results(record(tmp_path_factory.mktemp("results") / "a.h5"))


def expected(of: str, item: str, quantity: str, at: float | str, component: str = "", **bounds: Any) -> Expectation:
    return Expectation("e", of, item, quantity, "", component, at, "closed form", **bounds)


def test_a_vector_at_a_time(results: Results) -> None:
    angle = AMPLITUDE * math.cos(RATE * 0.7)
    exact = (0.0, LENGTH * math.sin(angle), -LENGTH * math.cos(angle))
    found = outcomes([expected("marker", "tip", "position", 0.7, value=exact, tolerance=1e-15)], results)[0]
    assert found.error == pytest.approx(0.0, abs=1e-15)
    assert (found.holds, found.time) == (True, pytest.approx(0.7, rel=1e-15))
    off = outcomes([expected("marker", "tip", "position", 0.7, value=(0.0, 0.0, 0.0), tolerance=0.5)], results)[0]
    assert off.error == pytest.approx(LENGTH * math.cos(angle), rel=1e-14)
    assert (off.holds, off.share) == (False, pytest.approx(2 * LENGTH * math.cos(angle), rel=1e-14))


def test_components_and_moments(results: Results) -> None:
    def measured(at: float | str, component: str, of: str = "marker", item: str = "tip", what: str = "velocity") -> Any:
        found = outcomes([expected(of, item, what, at, component, below=9.0)], results)[0]
        assert found.measured is not None
        return found.measured[0]

    time = np.arange(201) * 0.01
    speed = -AMPLITUDE * RATE * np.sin(RATE * time)
    along = LENGTH * speed * np.cos(AMPLITUDE * np.cos(RATE * time))
    assert measured("end", "y") == pytest.approx(along[-1], rel=1e-14)
    assert measured("maximum", "y") == pytest.approx(along.max(), rel=1e-14)
    assert measured("minimum", "y") == pytest.approx(along.min(), rel=1e-14)
    assert measured("largest", "y") == pytest.approx(np.abs(along).max(), rel=1e-14)
    assert measured("range", "y") == pytest.approx(along.max() - along.min(), rel=1e-14)
    assert measured("maximum", "norm") == pytest.approx(LENGTH * np.abs(speed).max(), rel=1e-14)
    assert measured(0.3, "", "joint", "A", "angle") == pytest.approx(AMPLITUDE * math.cos(0.9), rel=1e-14)
    assert measured(0.3, "", "joint", "A", "angle_speed") == pytest.approx(-0.6 * math.sin(0.9), rel=1e-14)


def test_both_signs_are_one_orientation(results: Results) -> None:
    angle = AMPLITUDE * math.cos(RATE * 1.0)
    for sign in (1.0, -1.0):
        exact = (sign * math.cos(angle / 2), sign * math.sin(angle / 2), 0.0, 0.0)
        assert outcomes([expected("body", "bob", "orientation", 1.0, value=exact, tolerance=1e-15)], results)[0].holds


@pytest.mark.parametrize("time", [0.705, 2.01, 0.70000001])
def test_a_time_that_was_not_recorded_is_not_interpolated(results: Results, time: float) -> None:
    found = outcomes([expected("marker", "tip", "position", time, "x", below=9.0)], results)[0]
    assert (found.checked, found.holds, found.measured, found.share) == (False, False, None, math.inf)


def test_energy_drift_is_that_of_the_summary(results: Results) -> None:
    drift = outcomes([expected("diagnostic", "energy_drift", "energy_drift", "maximum", below=1.0)], results)[0]
    relative = outcomes(
        [expected("diagnostic", "energy_drift_relative", "energy_drift_relative", "maximum", below=1.0)], results
    )[0]
    kinetic, potential = (results[f"diagnostics/{name}_energy"] for name in ("kinetic", "potential"))
    size = kinetic.max() + np.ptp(potential)
    assert drift.measured == (np.abs(results["diagnostics/energy_balance"]).max(),)
    assert relative.measured == pytest.approx((drift.measured[0] / size,), rel=1e-14)


@pytest.mark.parametrize(
    ("bounds", "found", "holds"),
    [
        ({"below": 1.0}, 1.0, True),
        ({"below": 1.0}, 1.0 + 2**-52, False),
        ({"below": -1.0}, -1.0, True),
        ({"below": -1.0}, -0.5, False),
        ({"below": 0.0}, 1e-300, False),
        ({"above": 2.0}, 2.0, True),
        ({"above": 2.0}, 1.9, False),
        ({"above": -2.0}, -2.1, False),
        ({"above": -2.0}, 7.0, True),
        ({"below": 1.0}, math.nan, False),
        ({"above": 1.0}, math.nan, False),
        ({"below": 1e3}, math.inf, False),
        ({"below": 0.1 + 0.2}, 0.30000000000000004, True),
    ],
)
def test_bounds(bounds: dict[str, float], found: float, holds: bool) -> None:
    result = Outcome(expected("joint", "A", "angle", "end", **bounds), (found,), 0.0)
    assert result.holds is holds
    assert (result.share <= 1.0) is holds


def test_a_nan_holds_nothing() -> None:
    result = Outcome(expected("joint", "A", "angle", "end", value=(1.0,), tolerance=1.0), (math.nan,), 0.0, math.nan)
    assert not result.holds


def test_what_may_be_expected_is_what_is_recorded(results: Results) -> None:
    """The quantities of each thing are the datasets of the layout, with their shapes and units; drifts are derived."""
    layout = {entry.path: entry for entry in DATASETS}
    groups = {"marker": "markers", "body": "bodies", "force": "forces", "motion": "motions"}
    for of, group in groups.items():
        recorded = {path.partition("/")[2]: entry for path, entry in layout.items() if path.startswith(f"{group}/")}
        assert OBSERVABLES[of].keys() - {TRANSMISSION_ANGLE} == recorded.keys()
        for name in recorded:
            observable = OBSERVABLES[of][name]
            unit = " or ".join(part.replace("*", " ") for part in observable.unit.split(" or "))
            assert (unit or "1") == recorded[name].unit
            size = math.prod(axis for axis in recorded[name].shape if isinstance(axis, int))
            assert observable.components == size
    diagnostics = {path.partition("/")[2] for path in layout if path.startswith("diagnostics/")}
    assert OBSERVABLES["diagnostic"].keys() - {"energy_drift", "energy_drift_relative"} == diagnostics
    joints = {path.partition("/")[2] for path, entry in layout.items() if entry.symbol == "nj"}
    assert joints <= OBSERVABLES["joint"].keys()


ITEMS = {"marker": "tip", "body": "bob", "joint": "A", "force": "spring", "motion": "drive"}


# Without what the pendulum has none of: stops, frictions, states, signals.
@pytest.mark.parametrize("of", [of for of in OBSERVABLES if of not in ("stop", "friction", "state", "signal")])
def test_every_observable_has_a_series(results: Results, of: str) -> None:
    for quantity, observable in OBSERVABLES[of].items():
        if of == "joint" and quantity.startswith(
            ("angle_1", "angle_2", "displacement", "length", "gap", "lap", "tension", "contact")
        ):
            continue  # the pendulum's joint has an angle only
        if quantity == TRANSMISSION_ANGLE or quantity.endswith((VELOCITY_RATIO, MECHANICAL_ADVANTAGE)):
            continue  # these are of other markers or of an input, too: see test_over_coordinates.py
        found = series(expected(of, ITEMS.get(of, quantity), quantity, "end"), results)
        assert found.shape == (201, observable.components)
