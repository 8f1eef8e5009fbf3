"""`mbproj optimise`: numbers of a scene with which a measure is as small or as large as it can be."""

from __future__ import annotations

from typing import Any

from mbproj.cli.design.found import options, search
from mbproj.cli.explained import explained

EXAMPLES = (
    ("Find the smallest bearing load that the constraints allow.", "mbproj optimise load.yaml"),
    ("The same by quadratic programs, whatever the goal.", "mbproj optimise load.yaml --engine slsqp"),
)


@explained("optimise", EXAMPLES)
@options
def command(**given: Any) -> int:
    """Finds the numbers of a scene that make a measure smallest or largest.

    SPEC is a YAML file: a scene, what varies within which bounds, what is minimised or maximised, and subject to what.
    Writes best.yaml, starts.csv and design.png into DIR.

    Exit code 0: done; 2: wrong input, or no design runs; 3: no design keeps the constraints.
    """
    return search(fits=False, **given)
