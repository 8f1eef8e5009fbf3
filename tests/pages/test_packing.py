"""Numbers survive packing to half a step, whatever they are."""

from __future__ import annotations

import zlib
from base64 import b64decode

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from mbproj.pages.data.packing import LARGEST, ORDERS, Packer, step_of
from tests.pages.runs import block_of

NUMBERS = arrays(
    float,
    array_shapes(min_dims=2, max_dims=2, min_side=0, max_side=12),
    elements=st.floats(-1e6, 1e6) | st.just(np.nan) | st.just(np.inf),
)


def there_and_back(values: np.ndarray, step: float | np.ndarray) -> np.ndarray:
    packer = Packer()
    packer.add(np.ones((3, 2)), 1.0)  # something before it
    number = packer.add(values, step)
    return block_of(zlib.decompress(b64decode(packer.text())), packer.blocks[number])


@settings(max_examples=60, deadline=None)
@given(NUMBERS)
def test_each_number_is_off_by_half_a_step_at_most(values):
    step = step_of(values, 24)
    back = there_and_back(values, step)
    assert back.shape == values.shape
    finite = np.isfinite(values)
    assert np.array_equal(np.isfinite(back), finite)
    assert (np.abs(back - values) <= 0.5 * step * (1 + 1e-12))[finite].all()


def test_a_step_keeps_the_digits_that_were_asked_for():
    assert step_of(np.array([[3.0, 0.0, -100.0]]), 8).tolist() == [2.0**-6, 1.0, 2.0**-1]


def test_a_smooth_motion_takes_two_bytes_a_number_or_less():
    time = np.linspace(0.0, 10.0, 601)
    values = np.sin(2.0 * time[:, None] * np.arange(1, 9))
    packer = Packer()
    packer.add(values, 2.0**-24)
    assert packer.blocks[0]["order"] == max(ORDERS)
    assert len(b64decode(packer.text())) <= 2.0 * values.size


def test_what_is_too_large_for_its_step_is_no_number():
    values = np.array([[2.0 * LARGEST], [1.0]])
    assert np.isnan(there_and_back(values, 1.0)[0, 0])
    assert there_and_back(values, 1.0)[1, 0] == 1.0


@pytest.mark.parametrize("rows", [0, 1, 2, 3])
def test_few_rows(rows):
    values = np.arange(2.0 * rows).reshape(rows, 2)
    assert np.array_equal(there_and_back(values, 1.0), values)
