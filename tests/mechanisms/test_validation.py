"""Mechanisms that others computed (mechanisms/validation), against their results (tests/data/validation): over all of
the time with the default method, and over a part of it with every method that is legal."""

from __future__ import annotations

import re

import numpy as np
import pytest

from mbproj import read_scene
from mbproj.base.registry import PROJECTIONS
from scripts.validation.case import CASES, SCENES, TABLES, Case
from scripts.validation.compare import deviations, reference, regular_text, run_case
from scripts.validation.quantities import Done
from tests.crossed import once, some, where

#: With Euler parameters M is singular, and POPM refused; GPOPM is the default.
METHODS = [name for name in PROJECTIONS if name not in ("popm", "gpopm")]
#: Of forty loops, which takes the most time.
LARGEST = "iftomm_n_four_bar_40"
LOOPS = [case for case in CASES.values() if case.loops]


def assert_agrees(case: Case, done: Done, times: int) -> None:
    """Every column, at `times` of the reference's times, within its tolerance."""
    found = deviations(case, done)
    assert {each.column for each in found} == set(reference(case)) - {"t"}
    assert {each.count for each in found} == {times}
    off = [
        f"{each.column} is off by {each.error:.3g}, {each.tolerance:.3g} is allowed"
        for each in found
        if not each.ratio <= 1.0
    ]
    assert not off, "; ".join(off)


@pytest.mark.parametrize("case", where(lambda case: case.name != LARGEST, CASES.values()), ids=CASES)
def test_agrees_over_the_whole_time(case):
    done = run_case(case)
    assert_agrees(case, done, len(reference(case)["t"]))
    assert done.report.position_violation.value <= 2e-13
    assert done.report.counters["projection_failures"] == 0


@pytest.mark.parametrize(
    ("method", "case"),
    where(lambda _, case: case.name != LARGEST, once(METHODS, [*CASES.values()])),
    ids=lambda value: getattr(value, "name", value),
)
def test_every_method_agrees(case, method):
    """Those that the kernel does not have run in the full formulation, which is quicker where no rows are redundant."""
    text = None if PROJECTIONS[method].compiled else regular_text(case)
    done = run_case(case, text, projection=method, duration=str(case.short), **case.quick)
    assert_agrees(case, done, int(np.count_nonzero(reference(case)["t"] <= case.short + 1e-9)))
    if PROJECTIONS[method].corrects:
        assert done.report.position_violation.value <= 2e-13


#: In space, forty loops that pass their singular poses at once leave 4e-7 m of 2e-8.
HARD = ("reduced", LARGEST)


@pytest.mark.parametrize(
    ("formulation", "case"),
    where(
        lambda _, case: case.name not in ("iftomm_n_four_bar_2", "iftomm_n_four_bar_40"),  # a second each
        some([(form, case) for form in ("planar", "reduced") for case in LOOPS if (form, case.name) != HARD], 2),
    ),
    ids=lambda value: getattr(value, "name", value),
)
def test_planar_loops_of_revolutes_agree(formulation, case):
    """As the source has them: their rows are redundant in space, and in the plane they are not seen."""
    done = run_case(case, formulation=formulation)
    assert_agrees(case, done, len(reference(case)["t"]))
    assert done.report.formulation == formulation


@pytest.mark.parametrize(
    ("step", "name"),
    once(
        ["12.5 ms", "10 ms", "5 ms", "3.125 ms", "1/380", "2.5 ms", "2 ms", "1.5625 ms", "1 ms"],
        ["iftomm_n_four_bar_1", "iftomm_n_four_bar_2"],
    ),
)
def test_fixed_steps_past_singular_poses_are_right(name, step):
    """Pivots judged by the smallest of all, which small moments of inertia make, have led 1.3e-2 m off, with closed
    joints and no drift of the energy; rows left out for a whole step 1e-3 m."""
    done = run_case(CASES[name], formulation="reduced", step=step)
    assert max(each.error for each in deviations(CASES[name], done)) < 1e-5


@pytest.mark.parametrize("name", ["adams_revolute", "adams_universal_tilted", "dymola_rssp", "iftomm_slider_crank"])
def test_the_comparison_is_not_blind(name):
    """One per cent more gravity is far out of tolerance."""
    text = CASES[name].scene.read_text(encoding="utf-8")
    heavier = re.sub(r"-9\.8\d+", lambda found: str(1.01 * float(found[0])), text)
    assert heavier != text
    found = deviations(CASES[name], run_case(CASES[name], heavier))
    assert max(each.ratio for each in found) > 3.0


def test_every_scene_and_table_is_a_case():
    assert {path.stem for path in SCENES.glob("*.yaml")} == set(CASES) == {path.stem for path in TABLES.glob("*")}
    for case in CASES.values():
        assert len(case.origin) > 10
        assert read_scene(case.scene).title
