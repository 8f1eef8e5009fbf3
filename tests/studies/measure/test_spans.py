"""Sample times that steps meet, and the sizes of a grid."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbproj.base.errors import InputError
from mbproj.scene.scene import read_scene
from mbproj.studies.measure.reference import common_times, divisors, sampled, stride_for
from mbproj.studies.measure.setting import Setting
from mbproj.studies.tradeoff import MOST, Ladder, step_numbers
from tests.cli.commands import FIVE_BAR


@given(st.sets(st.sampled_from([0.1, 0.05, 0.02, 0.01, 0.005, 0.0025, 0.002, 1.0 / 64.0, 1.0 / 30.0]), min_size=1))
def test_every_step_meets_every_time(steps):
    times = common_times(30.0, steps)
    ratios = np.array([(times[1] - times[0]) / step for step in steps])
    assert ratios == pytest.approx(np.round(ratios), rel=1e-9)
    assert ratios.min() >= 1.0 - 1e-9
    assert times[-1] <= 30.0
    assert 30.0 - times[-1] < times[1]


def test_the_span_ends_with_the_last_common_time():
    assert common_times(1.0, [0.3])[-1] == pytest.approx(0.9)
    assert len(common_times(10.0, [0.001])) == 1001
    assert len(common_times(10.0, [])) == 481
    with pytest.raises(InputError, match=r"the steps do not meet before 2\.1 s, and the study ends at 2 s"):
        common_times(2.0, [0.3, 0.7])


@given(st.integers(min_value=20, max_value=2000))
def test_numbers_of_steps(intervals):
    numbers = step_numbers(intervals)
    assert all(intervals % number == 0 or number % intervals == 0 for number in numbers)
    assert all(20 <= number <= MOST and after >= 1.4 * number for number, after in pairwise(numbers))
    assert numbers[-1] > MOST / 1.5 - intervals


@pytest.mark.parametrize("samples", [200, 480, 997])
def test_each_size_of_a_ladder_meets_some_of_the_times(samples):
    times = np.linspace(0.0, 3.0, samples + 1)
    for setting in Ladder(Setting(), by_tolerance=False).sizes(times):
        stride = stride_for(times, setting.step)
        assert stride is not None
        ratio = times[::stride][1] / setting.step
        assert ratio == pytest.approx(round(ratio), rel=1e-9)
        assert samples % stride == 0
    assert stride_for(times, 0.77) is None


def test_tolerances_of_a_ladder():
    settings = Ladder(Setting(integrator="dop853"), by_tolerance=True).sizes(np.linspace(0.0, 1.0, 11))
    assert [setting.tolerance for setting in settings] == pytest.approx([10.0**-k for k in range(2, 14)])
    assert all(setting.step is None for setting in settings)


def test_divisors():
    assert divisors(12) == [1, 2, 3, 4, 6, 12]


@pytest.mark.parametrize("unit", [1e-300, 1e-9, 1e9, 1e40])
def test_steps_meet_in_every_unit_of_time(unit):
    times = common_times(30.0 * unit, [0.01 * unit, 0.0025 * unit])
    assert times[-1] == pytest.approx(30.0 * unit, rel=1e-9)
    assert times[1] / (0.01 * unit) == pytest.approx(round(times[1] / (0.01 * unit)), rel=1e-9)


def test_steps_that_meet_beyond_all_numbers_do_not_meet():
    with pytest.raises(InputError, match=r"the steps do not meet before .* s, and the study ends at 1 s"):
        common_times(1.0, [1e-3, *(1e40 * (1.0 + part / 997.0) for part in range(12))])


def test_samples_that_no_memory_holds_are_refused():
    with pytest.raises(InputError, match=r"more than 1e\+07 samples, every 0\.01 s until 1e\+44 s"):
        sampled(read_scene(FIVE_BAR), 1e44)
