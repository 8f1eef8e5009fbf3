"""The tables of the guide's page on the paper's examples are what the runs say."""

from __future__ import annotations

import numpy as np
import pytest

from scripts.paper_table import EXAMPLES, cells, rows
from tests.crossed import full
from tests.kernel.scenes import needs_kernel
from tests.support import ROOT

PAGE = ROOT / "mbproj" / "guide" / "explanation" / "examples_of_the_paper.md"
ROWS = ("none", "baumgarte", "gopm, paper", "gpopm, violation", "gpopm, paper", "gpopm, dop853, 1e-10")


def shown(example, name):
    """The cells of a row on the page."""
    lines = PAGE.read_text(encoding="utf-8").partition(f"| {example.name} |")[2].splitlines()
    (line,) = [line for line in lines[: len(rows()) + 2] if line.startswith(f"| {name} |")]
    return [cell.strip() for cell in line.strip("|").split("|")][1:]


@needs_kernel
@pytest.mark.parametrize("example", EXAMPLES, ids=lambda each: each.name)
@pytest.mark.parametrize("name", [ROWS[0], *map(full, ROWS[1:])])
def test_a_row_is_what_its_run_says(example, name):
    """Errors and drifts to 5 %; what round-off leaves of the violations, to a factor of 3."""
    told, found = shown(example, name), cells(example, rows()[name])
    if told[0] == "diverges":
        assert found == told
        return
    expected, measured = (np.array(each, dtype=float) for each in (told, found))
    np.testing.assert_allclose(measured[2:], expected[2:], rtol=0.05)
    assert np.abs(np.log(measured[:2] / expected[:2])).max() < np.log(3)
