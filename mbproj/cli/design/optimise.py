"""`mbproj optimise`: numbers of a scene that make a measure as small or as large as possible."""

from __future__ import annotations

from typing import Any

from mbproj.cli.design.design_command import Asked, options, search
from mbproj.cli.explained import Part, explained, option
from mbproj.cli.quantity import QuantityNames

EXAMPLES = (
    ("Find the smallest bearing load that the constraints allow.", "mbproj optimise load.yaml"),
    ("The same by quadratic programs, whatever the goal.", "mbproj optimise load.yaml --engine slsqp"),
    (
        "Find a mechanism that carries a body through places.",
        "mbproj optimise carry.yaml --topologies four_bar,slider_crank",
    ),
)


@explained("optimise", EXAMPLES)
@options
@option(
    Part.WHAT,
    "--topologies",
    type=QuantityNames(),
    metavar="A,B,..",
    help="Some of four_bar, slider_crank, watt, stephenson, spatial_four_bar; or all.",
)
def command(topologies: tuple[str, ...] | None, **given: Any) -> int:
    """Finds the numbers of a scene that make a measure smallest or largest.

    SPEC is a YAML file: a scene, what varies within which bounds, what is minimised or maximised, and subject to what.
    Writes best.yaml, starts.csv and design.png into DIR.

    With --topologies it finds mechanisms. SPEC names the path of a point, a function of the crank's angle, or positions
    of a body. Writes best.yaml, topologies.csv and designs.html.

    Exit code 0: done; 2: wrong input, or no design runs; 3: no design keeps the constraints.
    """
    if topologies is not None:
        from mbproj.cli.design.topologies import synthesise_of

        return synthesise_of(topologies, Asked.of(given))
    return search(Asked.of(given), fits=False)
