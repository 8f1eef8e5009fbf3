"""Which samples a page shows."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.base.errors import InputError
from mbproj.show.page.series import FEWEST, REFUSED, THINNED, frames_of, largest_between


def test_a_dense_run_is_thinned_to_sixty_frames_a_second_and_says_so():
    time = np.linspace(0.0, 20.0, 20001)
    frames = frames_of(time, np.arange(20001), 5)
    assert len(frames.rows) == 1201
    assert (frames.rows[0], frames.rows[-1]) == (0, 20000)
    assert np.abs(np.diff(time[frames.rows]) - 1 / 60).max() <= 1e-3 + 1e-12  # as even as the samples are
    assert frames.remark == "1201 of 20001 samples are shown: more than a screen can show"


def test_a_short_run_keeps_its_samples_and_full_keeps_all():
    time = np.linspace(0.0, 0.08, 801)
    assert len(frames_of(time, np.arange(801), 5).rows) == FEWEST + 1
    assert len(frames_of(time, np.arange(801), 5, full=True).rows) == 801
    assert frames_of(time, np.arange(801), 5, full=True).remark == ""


def test_a_large_mechanism_gets_fewer_frames_and_is_told_why():
    time = np.linspace(0.0, 100.0, 6001)
    frames = frames_of(time, np.arange(6001), 1000)
    assert len(frames.rows) == THINNED // 7000
    assert frames.remark.endswith("the page would be too large for a browser with more")


def test_what_no_browser_opens_is_refused():
    time = np.linspace(0.0, 100.0, 10001)
    with pytest.raises(InputError, match=r"10001 frames of 1000 bodies are 70 million numbers.*leave --full out"):
        frames_of(time, np.arange(10001), 1000, full=True)
    with pytest.raises(InputError, match="bodies are more than a browser shows"):
        frames_of(time, np.arange(10001), REFUSED // 14 + 1)


def test_samples_without_a_pose_are_not_shown():
    whole = np.array([0, 1, 5, 6])
    assert frames_of(np.arange(7.0), whole, 1).rows.tolist() == [0, 1, 5, 6]


def test_no_peak_between_two_frames_is_lost():
    values = np.array([[1.0], [9.0], [2.0], [np.nan], [3.0]])
    assert largest_between(values, np.arange(5), np.array([0, 2, 4])).ravel().tolist() == [1.0, 9.0, 3.0]
