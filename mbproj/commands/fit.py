"""`mbproj fit`: numbers of a scene that match measurements."""

from __future__ import annotations

from typing import Any

from mbproj.commands.design_command import options, search
from mbproj.commands.options import explained

EXAMPLES = (
    ("Fit lengths to a measured path.", "mbproj fit path.yaml"),
    ("Go on where it was interrupted, on four processors.", "mbproj fit path.yaml -j 4"),
)


@explained("fit", EXAMPLES)
@options
def command(**values: Any) -> int:
    """Finds the numbers of a scene that match measurements.

    SPEC is a YAML file: a scene, what varies within which bounds, which quantity matches which columns of a CSV file.
    Prints the numbers with their standard deviations, and which of them the measurements do not show. Writes
    best.yaml, starts.csv and design.png into DIR.

    Exit code 0: done; 2: wrong input, or no design runs; 3: no design keeps the constraints.
    """
    return search(values, fits=True)
