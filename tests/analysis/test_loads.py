"""The largest loads: peaks between samples, works, and the same from the file as from its samples."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.analysis import duration_above, loads_of, recorded_in, samples_of, swings
from mbproj.results import open_results
from mbproj.results.loads.between_samples import in_and_out, integrals, peaks, pieces
from mbproj.results.loads.largest import loads
from tests.results.pendulum_blocks import record

ONE_PIECE = np.zeros(0)


@pytest.mark.parametrize("samples", [30, 60, 120])
def test_a_peak_between_samples_is_found_to_the_stated_uncertainty(samples):
    time = np.linspace(0.0, 2.0 * np.pi, samples)
    values = np.stack([-3.0 * np.sin(time - 0.1), 2.0 + np.cos(time - 1.0)], axis=1)[..., None]
    found = peaks(time, values, pieces(time, ONE_PIECE))
    assert np.all(np.abs(np.abs(found.value) - 3.0) <= found.uncertainty)
    assert found.uncertainty.max() < 200.0 / samples**4 + 1e-14
    assert found.time[1] == pytest.approx(1.0, abs=1e-3)


def test_of_two_peaks_the_higher_one_wins_though_a_sample_meets_the_other():
    time = np.arange(0.0, 8.0, 0.1)
    low, high = np.exp(-((time - 2.0) ** 2)), 1.001 * np.exp(-((time - 6.05) ** 2))
    found = peaks(time, (low + high)[:, None, None], pieces(time, ONE_PIECE))
    assert found.time[0] == pytest.approx(6.05, abs=1e-4)


def test_what_is_constant_is_largest_at_its_first_sample():
    time = np.linspace(0.0, 1.0, 101)
    found = peaks(time, np.full((101, 1, 1), -8000.0), pieces(time, ONE_PIECE))
    assert (found.value[0], found.time[0]) == (-8000.0, 0.0)
    assert found.uncertainty[0] < 1e-10


def test_no_polynomial_crosses_a_jump():
    time = np.linspace(0.0, 2.0, 201)
    values = np.where(time <= 1.0, time, -0.5)
    found = peaks(time, values[:, None, None], pieces(time, np.array([1.0])))
    assert found.value[0] == pytest.approx(1.0, abs=1e-12)
    assert found.time[0] == 1.0
    assert found.uncertainty[0] < 1e-12


def test_a_sample_at_a_jump_is_the_last_before_it():
    """∫ t dt up to the sample at 1 s, and -0.5 from there on."""
    time = np.linspace(0.0, 2.0, 201)
    values = np.where(time <= 1.0, time, -0.5)[:, None]
    areas = integrals(time, values, pieces(time, np.array([1.0])))
    assert areas[:100].sum() == pytest.approx(0.5, abs=1e-12)
    assert areas[100:].sum() == pytest.approx(-0.5, abs=1e-12)


@pytest.mark.parametrize("samples", [11, 14, 30, 80, 300])
@pytest.mark.parametrize("event", [0.61, 0.7123, 0.7999])
def test_a_peak_just_before_a_jump_is_found_to_the_stated_uncertainty(samples, event):
    """A load that grows until a friction reverses: its largest value stands between the last sample and the jump."""
    time = np.linspace(0.0, 1.0, samples)
    shape = np.exp(2.0 * np.minimum(time, event)) * np.cos(0.3 * time)
    values = np.where(time <= event, shape, 1.0 - np.sin(time - event))
    found = peaks(time, np.stack([values, -values], axis=1)[..., None], pieces(time, np.array([event])))
    largest = np.exp(2.0 * event) * np.cos(0.3 * event)
    assert np.all(np.abs(np.abs(found.value) - largest) <= found.uncertainty)
    assert np.all(np.sign(found.value) == [1.0, -1.0])
    if samples >= 30:
        assert found.uncertainty.max() < 1e-3
        np.testing.assert_allclose(found.time, event)


def test_a_load_just_after_an_event_between_few_samples_is_within_the_uncertainty():
    """Two events within three samples: the piece between them has one sample, and no polynomial."""
    time = np.linspace(0.0, 1.0, 21)
    first, last = 0.49, 0.53
    load = np.where(time < first, 1.0, np.where(time < last, 3.0 + 10.0 * (time - first), 2.0))
    found = peaks(time, load[:, None, None], pieces(time, np.array([first, last])))
    assert 3.0 + 10.0 * (last - first) <= found.value[0] + found.uncertainty[0]


def test_works_are_those_of_each_side_of_a_jump():
    """A power whose sign changes at a reversal, and at a zero that is no event; the integrals are closed."""
    event, zero = 0.4321, 0.8123
    time = np.linspace(0.0, 1.0, 26)
    power = np.where(time <= event, -np.exp(time), np.cos(time) - np.cos(zero))[:, None]
    put_in, taken_out = in_and_out(time, power, pieces(time, np.array([event])))
    above = np.sin(zero) - np.sin(event) - (zero - event) * np.cos(zero)
    below = -(np.sin(1.0) - np.sin(zero) - (1.0 - zero) * np.cos(zero))
    assert put_in[0] == pytest.approx(above, rel=1e-7)
    assert taken_out[0] == pytest.approx(np.exp(event) - 1.0 + below, rel=1e-7)


def test_friction_that_only_takes_puts_nothing_in():
    time = np.linspace(0.0, 10.0, 700)
    turns = np.pi * np.arange(1, 4)
    power = -3.0 * np.abs(np.sin(time))[:, None]
    put_in, taken_out = in_and_out(time, power, pieces(time, turns))
    assert put_in[0] == 0.0
    assert taken_out[0] == pytest.approx(3.0 * (7.0 + np.cos(10.0 - 3.0 * np.pi) * -1.0), rel=1e-9)


def test_an_integral_is_exact_for_cubics_and_works_add_up_to_it():
    time = np.sort(np.concatenate([np.linspace(0.0, 1.0, 9), [0.37]]))
    cubic = (4.0 * time**3 - time)[:, None]
    piece = pieces(time, ONE_PIECE)
    assert integrals(time, cubic, piece).sum() == pytest.approx(0.5, abs=1e-14)
    put_in, taken_out = in_and_out(time, cubic, piece)
    assert put_in[0] - taken_out[0] == pytest.approx(0.5, abs=1e-14)
    assert taken_out[0] == pytest.approx(1.0 / 16.0, abs=1e-3)


def test_the_time_above_a_level_is_that_of_the_curve():
    time = np.linspace(0.0, 2.0 * np.pi, 2001)
    assert duration_above(time, np.sin(time), 0.5) == pytest.approx(4.0 * np.pi / 3.0, abs=1e-5)


def test_rainflow_counts_the_example_of_the_standard():
    pytest.importorskip("rainflow")
    counted = swings(np.array([-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0, -2.0]))  # ASTM E1049-85, fig. 6
    assert [(swing.range, swing.cycles) for swing in counted] == [
        (9.0, 0.5),
        (8.0, 1.0),
        (6.0, 0.5),
        (4.0, 1.5),
        (3.0, 0.5),
    ]


def test_the_file_keeps_what_its_samples_say(tmp_path):
    with open_results(record(tmp_path / "pendulum.h5")) as results:
        kept = loads_of(results)
        computed = loads(recorded := recorded_in(results), recorded.cycle())
        by_name = {(load.kind, load.name, load.quantity): load for load in kept}
        pull = by_name["joint", "A", "reaction_force"]
        assert pull.largest == pytest.approx(np.linalg.norm(results.joint("A").reaction_force, axis=1).max(), rel=1e-6)
        assert samples_of(results, pull).max() <= pull.largest + pull.uncertainty
    assert kept
    assert repr(list(kept)) == repr(computed)
