"""The data of a synthesis for its page: the motion of the best design of each topology, and the task."""

from __future__ import annotations

from typing import Any

import numpy as np

from mbproj.studies.synthesis.candidates import ARM, body_of, crank_of, output_of, swung_between
from mbproj.studies.synthesis.linkage import Linkage, Numbers, Slide
from mbproj.studies.synthesis.spatial import SpatialFourBar
from mbproj.studies.synthesis.spec import Wanted
from mbproj.studies.synthesis.synthesise import Synthesis, Synthesised, mechanism_of
from mbproj.studies.synthesis.topologies import FUNCTION, PATH, POSITIONS

#: The number of frames of a motion.
FRAMES = 121


def page_data(synthesis: Synthesis) -> dict[str, Any]:
    """Return plain data: the wanted points, and for each design lines (frames, points, 2) in x and z, in m, and its
    `trace`. Wanted positions of a body are `marks`, lines of two points; `carried` (frames, 2, 2) is the design's
    body."""
    wanted = synthesis.wanted
    points = [] if wanted.kind == FUNCTION else wanted.values.tolist()
    marks = []
    if wanted.kind == POSITIONS:
        x, z, angle = wanted.values.T
        marks = _mark(wanted, x + 1j * z, np.exp(1j * angle))
    designs = [_design(wanted, each) for each in synthesis.found if each.design is not None]
    function = np.degrees(wanted.values - wanted.values[0]).tolist() if wanted.kind == FUNCTION else []
    turns = wanted.turns or (wanted.kind == PATH and wanted.times is None)
    return {"turns": turns, "points": points, "marks": marks, "function": function, "designs": designs}


def _design(wanted: Wanted, each: Synthesised) -> dict[str, Any]:
    mechanism = mechanism_of(wanted, each.topology)
    p: Numbers = {name: np.array([[value]]) for name, value in each.numbers.items()}
    crank = _angles(wanted, p)
    unit = "rad" if wanted.kind == FUNCTION else "m"
    lines, trace = _lines(mechanism, p, crank)
    reached, carried = [], []
    if wanted.kind == POSITIONS and isinstance(mechanism, Linkage):
        known = mechanism.solved(p, crank)
        carried = _mark(wanted, known["P"][0], body_of(mechanism, p, known)[0])
    if wanted.kind == FUNCTION:
        output = np.unwrap(output_of(mechanism, p, crank)[0])
        reached = np.degrees(np.stack([crank[0] - crank[0, 0], output - output[0]], axis=1)).tolist()
    label = f"{each.topology}: off by {each.rms:.3g} {unit} (rms)"
    return {"label": label, "lines": lines, "trace": trace, "reached": reached, "carried": carried}


def _mark(wanted: Wanted, place: Any, direction: Any) -> list[Any]:
    """Return lines (N, 2, 2) from the places of a body along its directions."""
    return np.stack([_plane(place), _plane(place + ARM * wanted.size * direction)], axis=1).tolist()


def _angles(wanted: Wanted, p: Numbers) -> Any:
    """The crank's angles of the frames, (1, frames)."""
    share = np.linspace(0.0, 1.0, FRAMES)[None]
    if wanted.kind == FUNCTION:
        return p["start"] + share * np.ptp(wanted.values[:, 0])
    if wanted.kind == POSITIONS:
        count = len(wanted.values)
        return swung_between(p, count, share[0] * (count - 1))
    if wanted.times is None or wanted.turns:
        return p["start"] + p["turn"] * 2.0 * np.pi * share
    return p["start"] + (crank_of(wanted, p)[:, -1:] - p["start"]) * share


def _lines(mechanism: Linkage | SpatialFourBar, p: Numbers, crank: Any) -> tuple[list[Any], list[Any]]:
    """The links as lines, seen along -y, and the path of the point."""
    if isinstance(mechanism, SpatialFourBar):
        angle = mechanism.angle(p, crank)
        pivot = 1.0 + 1j * p["dz"]
        end = pivot + p["lever_length"] * (np.cos(angle) + 1j * np.sin(angle) * np.cos(p["twist"]))
        ways = [[0.0 * crank, p["crank_length"] * np.exp(1j * crank), end, pivot + 0.0 * crank]]
        trace = None
    else:
        known = mechanism.solved(p, crank)
        ways = [[known[link.origin], known[link.toward]] for link in mechanism.links]
        ways += [
            [known[link.origin], known[name], known[link.toward]] for link in mechanism.links for name in link.carries
        ]
        ways += [
            [known[mechanism.link(step.link).toward], known[mechanism.links[0].origin]]
            for step in mechanism.steps
            if isinstance(step, Slide)
        ]
        trace = known["P"] if mechanism.traced else None
    lines = [np.stack([_plane(point[0]) for point in way], axis=1).tolist() for way in ways]
    return lines, [] if trace is None else _plane(trace[0]).tolist()


def _plane(points: Any) -> Any:
    """Return points (N, 2) with six digits, enough for a picture."""
    values = np.stack([points.real, points.imag], axis=1)
    return np.where(np.isfinite(values), np.round(values, 6), 0.0)
