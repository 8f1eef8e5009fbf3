"""Bundles of short items: every one once, whatever happens to the processes, and no innocent one is blamed."""

from __future__ import annotations

from itertools import count, islice

from mbproj.studies.parallel.hand_out import LARGEST, in_bundles
from tests.studies.tasks import fragile


def lost(item: int, why: str, seconds: float) -> str:
    return why.split(":")[0].split(" with")[0]


def test_all_items_come_back_and_only_the_guilty_are_blamed():
    found = [pair for ended in in_bundles(fragile, 30.0, range(40), 2, lost, timeout=0.5) for pair in ended]
    assert sorted(item for item, _ in found) == list(range(40))
    expected = {item: item * item for item in range(40)} | {13: "its process ended", 17: "stopped"}
    assert dict(found) == expected


def test_items_are_taken_as_they_are_needed():
    """Of an endless supply, so that any number may be handed out."""
    taken = count()
    ended = in_bundles(fragile, 0.0, (100 + item for item in taken), 1, lost)
    some = list(islice((item for found in ended for item, _ in found), 5))
    ended.close()
    assert sorted(some) == [100, 101, 102, 103, 104]
    assert next(taken) < LARGEST
