"""The extremes, on the smallest mechanisms that show them, by every projection method in every formulation: the motion
is the exact one and the joints are closed, or the run says why not. The whole matrix, with the values in between, is
`scripts/stability_campaign.py`."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.base.registry import PROJECTIONS
from scripts.extremes.extremes import EXTREMES
from scripts.extremes.trial import Extreme, attempt, combinations, run
from tests.crossed import FULL, cover
from tests.kernel.scenes import needs_kernel

#: The full formulation takes milliseconds a step.
STEPS = {"full": 4, "reduced": None, "planar": None}
PENALTIES = ("mass-orthogonal", "mmopm")
ALL = tuple(PROJECTIONS)

#: What does not run, and what is said of it: extreme, value, formulations, methods, verdict, words.
SAID = (
    ("masses to zero", 0.0, ("reduced", "planar"), ("popm",), "refused", "body 'coupler' has no definite mass"),
    ("step times frequency", 10.0, ("full", "reduced", "planar"), ALL, "stopped", "stopped at t = "),
    ("step times frequency", 100.0, ("full", "reduced", "planar"), ALL, "stopped", "stopped at t = "),
    ("angle between axes", 1e-3, ("planar",), ALL, "refused", "joint 'second' is tilted"),
    ("heavy end of a chain of 20", 1e12, ("full",), ("gpopm-pinv",), "stopped", "too far apart for this method"),
    ("heavy end of a chain of 1000", 1e12, ("reduced",), ("mass-orthogonal",), "stopped", "at joint 'J"),
    *(
        (
            f"start open in {where}",
            0.1,
            ("full", "reduced", "planar"),
            ("none", "baumgarte"),
            "warned",
            "was open by 0.",
        )
        for where in ("the plane", "space")
    ),
)
#: What runs on one machine and not on another, near the limit, and what is said where it does not.
MAY_SAY = (
    ("mass of the coupler in a loop", 1e12, ("reduced",), ("mass-orthogonal",), "open", "missed their tolerance"),
    *(
        (name, value, ("full",), PENALTIES, "stopped", "the penalty α = 1e+07 is too far from the masses")
        for name, value in (("all masses", 1e-12), ("lengths", 1e-6))
    ),
)


def kernel_of(formulation: str) -> list[pytest.MarkDecorator]:
    """The mark of what runs in the kernel."""
    return [] if formulation == "full" else [needs_kernel]


def cases():
    """All are `full`. The default has each extreme in each formulation, each of its values, each method, and what does
    not run."""
    every = [
        (extreme.name, method, formulation, (extreme.name, value))
        for extreme in EXTREMES.values()
        for value in extreme.brief
        for method, formulation in combinations(extreme)
    ]
    keep = cover(every, rare=[*((3, case[3]) for case in every), *((1, method) for method in ALL)])
    for extreme, value, formulations, methods, *_ in SAID:
        own = (case for case in every if case[3] == (extreme, value) and case[2] in formulations and case[1] in methods)
        keep.add(next(own))
    for case in every:
        name, method, formulation, (_, value) = case
        marks = kernel_of(formulation) + ([] if case in keep else [FULL])
        own = f"{name} {value:g} {method} {formulation}"
        yield pytest.param(EXTREMES[name], value, method, formulation, marks=marks, id=own)


@pytest.mark.parametrize(("extreme", "value", "method", "formulation"), list(cases()))
def test_the_motion_is_right_or_the_run_says_why_not(
    extreme: Extreme, value: float, method: str, formulation: str
) -> None:
    def row_of(table):
        own = (extreme.name, value)
        return next((row[4:] for row in table if row[:2] == own and formulation in row[2] and method in row[3]), None)

    may, expected = row_of(MAY_SAY), row_of(SAID) or ("right", "")
    found = attempt(extreme, value, method, formulation, STEPS[formulation])
    if may is not None and found.verdict != "right":
        expected = may
    assert found.verdict == expected[0], found
    assert expected[1] in found.message
    assert "nan" not in found.message


def stepping():
    """Each formulation with the methods that correct in it, and the extreme that counts its steps."""
    for formulation in ("full", "reduced", "planar"):
        extreme = EXTREMES["steps of the full formulation" if formulation == "full" else "steps in the kernel"]
        for method, entry in PROJECTIONS.items():
            if entry.corrects and method != "popm" and (method, formulation) in combinations(extreme):
                name = f"{method} {formulation}"
                marks = kernel_of(formulation) if formulation != "full" or method == "gpopm" else [FULL]
                yield pytest.param(extreme, method, formulation, marks=marks, id=name)


@pytest.mark.parametrize(("extreme", "method", "formulation"), list(stepping()))
def test_neither_the_length_of_euler_parameters_nor_the_clock_drifts(
    extreme: Extreme, method: str, formulation: str
) -> None:
    """After 1e4 steps in the kernel, or 100: to the last bits of Λ, and to the last bit of t = k h."""
    value = extreme.brief[0]
    done = run(extreme, value, method, formulation)
    assert np.abs(np.linalg.norm(done["bodies/orientation"], axis=-1) - 1.0).max() <= 1e-13
    h = extreme.steps(value)[1]
    k = np.arange(len(done["time"])) * (int(value) // 10)
    np.testing.assert_array_equal(done["time"], k * h)
