"""Numbers in files: what other programs read as that number too, and nothing else that Python takes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbproj.base.text import plain_number


@settings(derandomize=True, deadline=None)
@given(st.floats())
def test_numbers_survive(number: float) -> None:
    found = plain_number(f" {number!r}\t")
    assert np.array(found).tobytes() == np.array(number).tobytes() or (math.isnan(found) and math.isnan(number))


@pytest.mark.parametrize("text", ["-7", "+7.", ".5", "7e-3", "7E+3", "Inf", "-infinity", "nan"])
def test_the_usual_forms_are_read(text: str) -> None:
    assert repr(plain_number(text)) == repr(float(text))


@pytest.mark.parametrize("text", ["8_9", "1_000.5", "1e1_0", "８９", "٣", "0x10", "1,5", "1 2", "", "e3", "--1", "ınf"])
def test_other_forms_are_none(text: str) -> None:
    with pytest.raises(ValueError, match="could not convert"):
        plain_number(text)
