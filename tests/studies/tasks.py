"""What tests send to worker processes, which import it by this name."""

from __future__ import annotations

import os
import time
from importlib import import_module


def place(shared: str, item: int) -> tuple[str, int]:
    """What was shared, and the process; after hundredths of a second, or with a fault for a negative item."""
    print("what a function prints is no answer")
    if item < 0:
        raise ValueError(f"{shared} {item}")
    time.sleep(0.01 * item)
    return shared, os.getpid()


def die(shared: None, item: int) -> None:
    """Ends the process at once."""
    os._exit(item)


def environment(names: list[str], item: int) -> list[str | None]:
    """What these variables are in the process."""
    return [os.environ.get(name) for name in names]


def module_file(name: str, item: int) -> str | None:
    """Where the process has this module from."""
    return import_module(name).__file__


def keep(study: str, item: int) -> None:
    """Puts numbers into the store, as a worker of a study does."""
    from mbproj.studies import store as database
    from mbproj.studies.store import encoded

    for part in range(20):
        database.write(study, f"{item}-{part}", encoded([item, part]))


def fragile(shared: float, item: int) -> int:
    """The item's square; 13 ends the process, 17 takes `shared` s, others take a hundredth of a second."""
    if item == 13:
        os._exit(1)
    time.sleep(shared if item == 17 else 0.005)
    return item * item
