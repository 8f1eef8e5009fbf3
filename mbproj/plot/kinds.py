"""The kinds of pictures, one module each with `draw(results, labels) -> Figure`. Importing this is cheap."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from types import MappingProxyType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mbproj.results import Results


@dataclass(frozen=True)
class Kind:
    """A kind of picture: its module in `mbproj.plot`, one line on it, the names without which it does not apply, and
    whether most results have those, so that it is worth a note where they have not."""

    module: str
    summary: str
    needs: str | None = None
    usual: bool = True


KINDS: Mapping[str, Kind] = MappingProxyType(
    {
        "markers": Kind("markers", "position and velocity of each marker", "markers"),
        "paths": Kind("paths", "path of each marker in a plane", "markers"),
        "coordinates": Kind("coordinates", "joint coordinates and their speeds", "coordinates"),
        "violation": Kind("violation", "violation of the constraints, position and velocity"),
        "joints": Kind("joints", "violation of each joint, lengths and angles", "joints"),
        "reactions": Kind("reactions", "reaction force and torque of each joint", "joints"),
        "forces": Kind("forces", "what forces act along, and their size", "forces", usual=False),
        "motions": Kind("motions", "what motions prescribe, and what they take", "motions", usual=False),
        "energy": Kind("energy", "kinetic, potential and total energy, and the energy balance"),
        "steps": Kind("steps", "step size and iterations of the projection"),
    }
)

#: How the needed names read in a sentence.
NEEDED = {"markers": "markers", "joints": "joints", "coordinates": "joint coordinates", "forces": "forces",
          "motions": "motions"}


def why_not(kind: str, results: Sequence[Results]) -> str | None:
    """Why `kind` does not apply to `results`; None where it does."""
    needs = KINDS[kind].needs
    if needs is None or any(result.names(needs) for result in results):
        return None
    return f"the results have no {NEEDED[needs]}"


def draw(kind: str, results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """The picture of one or several overlaid `results`, each with at least one sample; `labels` name them."""
    module = import_module(f"mbproj.plot.{KINDS[kind].module}")
    figure: Figure = module.draw(results, labels)
    import_module("mbproj.plot.panels").small_print(figure, caption(results))
    return figure


def caption(results: Sequence[Results]) -> str:
    """What the results are of: their title where it is one, and the settings of a single run."""
    titles = {result.title for result in results}
    parts = [titles.pop()] if len(titles) == 1 else []
    if len(results) == 1:
        settings = results[0].settings
        step = f"step {settings.step:g} s" if settings.step is not None else f"tolerance {settings.tolerance:g}"
        parts.append(f"{settings.projection.method}, {settings.integrator}, {step}")
    return "; ".join(part for part in parts if part).replace("$", r"\$")
