"""by_arrays(): runs cases that differ in numbers alone in groups with the same decisions. The caller runs all other
cases one by one."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from traceback import extract_tb
from typing import Any, TypeVar

from mbproj.errors import MbprojError, warn_once
from mbproj.scene.text.changes import SIMULATION
from mbproj.studies.cases.array import CasesDiffer, OneCaseOnly

Case = TypeVar("Case")
Result = TypeVar("Result")
#: The fewest cases of a group: in groups of 4, six-bars take 0.8 and five-bars 0.65 of the time of single runs.
FEWEST = 5


def by_arrays(
    cases: Sequence[Case],
    run: Callable[[list[Case]], Sequence[Result | None]],
    holds: Callable[[Case, Result], bool] = lambda case, result: True,
    apart: Callable[[Case], Hashable] = lambda case: None,
) -> dict[int, Result]:
    """Return the results of the cases that arrays can run to their end, by the cases' numbers.

    `run` returns the results of a group, None for a case that must run alone. Cases of a group have the same `apart`.
    `holds` compares the first result of a group with that of a single run; where they differ, the group's results are
    dropped. An error that is none of mbproj's own becomes a warning: the cases of the group run alone.
    """
    by_place: dict[int, Result] = {}
    groups: dict[Any, list[int]] = {}
    for at, case in enumerate(cases):
        groups.setdefault(apart(case), []).append(at)
    waiting = [*groups.values()]
    while waiting:
        own = waiting.pop()
        if len(own) < FEWEST:
            continue
        try:
            results = run([cases[at] for at in own])
        except CasesDiffer as differ:
            parts: dict[Any, list[int]] = {}
            for at, key in zip(own, differ.keys, strict=True):
                parts.setdefault(key, []).append(at)
            waiting += parts.values() if len(parts) > 1 else ()
            continue
        except (OneCaseOnly, MbprojError):  # single runs report the error of each case in words
            continue
        except Exception as error:
            warn_once(f"arrays are not used, which is a fault of mbproj: {_placed(error)}")
            continue
        ended = {at: result for at, result in zip(own, results, strict=True) if result is not None}
        first = next(iter(ended), None)
        if first is None or holds(cases[first], ended[first]):
            by_place |= ended
        else:
            warn_once("arrays have other bits than single cases have, which is a fault of mbproj: not used")
    return by_place


def _placed(error: Exception) -> str:
    """The type, message and place of an error."""
    place = extract_tb(error.__traceback__)[-1]
    return f"{type(error).__name__}: {error} ({place.filename}:{place.lineno})"


def common_values(paths: Sequence[str], values: Sequence[float | str]) -> tuple[str, ...]:
    """Return the values that must be equal in all cases of a group: texts and settings of the run. They are returned as
    texts, which differ where a bit does."""
    pairs = zip(paths, values, strict=True)
    return tuple(repr(each) for path, each in pairs if isinstance(each, str) or path.startswith(f"{SIMULATION}."))
