"""synthesise(): the best design of each topology, and the simplest topology that fulfils the task."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem, choose_from
from mbproj.results.output_files import DESIGNED, make_folder, write_text
from mbproj.results.views import Table
from mbproj.scene.ranges import column_of
from mbproj.studies.design.run import FoundDesign, find_design
from mbproj.studies.design.spec import read_spec
from mbproj.studies.parallel.hand_out import Where
from mbproj.studies.parallel.progress import Tell
from mbproj.studies.study import Study
from mbproj.studies.synthesis.candidates import (
    ARM,
    EXACT,
    body_of,
    bounds_of,
    candidates,
    crank_of,
    mechanism_of,
    names_for,
    output_of,
    swung_between,
)
from mbproj.studies.synthesis.linkage import (
    FUNCTION,
    PATH,
    POSITIONS,
    Linkage,
    Numbers,
    Slide,
    SpatialFourBar,
)
from mbproj.studies.synthesis.scenes import even_inputs, output_joint, scene_of, unit_of
from mbproj.studies.synthesis.spec import Wanted

#: A topology is as good as the best one where its error is at most this multiple, or it is exact.
AS_GOOD = 1.5
OTHER = "choose another folder with -o"
#: The beginning of the written files.
MARK = "# Found by mbproj"
#: The topologies with two loops.
SIX_BARS = ("watt", "stephenson")
#: The number of positions that a four-bar can take with any pivots in the ground.
THREE = 3


@dataclass(frozen=True, eq=False)
class Synthesised:
    """The result of one topology: its number of bodies, its best `design`, and the `rms` error of its run in m or rad.
    `numbers` are all numbers of the design by name. Without a design that runs, `design` is None and `cause` the
    reason. With a design, `cause` is a doubt that it is the best."""

    topology: str
    bodies: int
    design: FoundDesign | None
    rms: float
    numbers: Mapping[str, float]
    cause: str = ""


@dataclass(frozen=True, eq=False)
class Synthesis:
    """The results of all topologies: the chosen one first, the others in the order of their errors."""

    wanted: Wanted
    topologies: tuple[Synthesised, ...]


def synthesise(
    wanted: Wanted,
    names: Sequence[str],
    folder: Path,
    where: Where = None,
    *,
    fresh: bool = False,
    force: bool = False,
    tell: Tell = lambda *_: None,
) -> Synthesis:
    """Finds designs of these topologies, by default of all that suit the task. Their scenes, and search files for
    `mbproj fit`, are written into the folder. Raises InputError for an unknown topology, or where no design is
    found."""
    able = names_for(wanted.kind)
    for name in names:
        if name not in able:
            message = f"no topology for {wanted.kind} is called '{name}'"
            raise InputError(Problem(message, Place("--topologies"), choose_from(name, able)))
    chosen = tuple(dict.fromkeys(names)) or able
    what = ["synthesis", wanted.text, wanted.values.tolist(), None if wanted.times is None else wanted.times.tolist()]
    study = Study(what, list[dict[str, float]], where, fresh, tell)
    looked = zip(chosen, study.each(candidates, wanted, {name: name for name in chosen}, "topologies"), strict=True)
    results = [_brought_to_an_end(wanted, name, each, folder, where, fresh, force) for name, each in looked]
    if not any(each.design for each in results):
        raise InputError(
            Problem(f"no topology does it; {results[0].topology}: {results[0].cause}", Place(str(wanted.path)))
        )
    return Synthesis(wanted, tuple(in_order(results, wanted.size)))


def in_order(results: Sequence[Synthesised], size: float) -> Iterator[Synthesised]:
    """Yield the topology with the fewest bodies of those as good as the best, and then the others in the order of their
    errors."""
    by_error = sorted(results, key=lambda each: each.rms if each.design else np.inf)
    enough = max(AS_GOOD * by_error[0].rms, EXACT * size)
    good = [each for each in results if each.design and each.rms <= enough]
    first = min(good, key=lambda each: each.bodies)
    yield first
    yield from (each for each in by_error if each is not first)


def _brought_to_an_end(
    wanted: Wanted,
    name: str,
    looked: Sequence[Mapping[str, float]],
    folder: Path,
    where: Where,
    fresh: bool,
    force: bool,
) -> Synthesised:
    """The result for a topology: the design that the search of `find_design` reaches from the best candidate that
    runs."""
    mechanism, cause = mechanism_of(wanted, name), "no design closes at all of its points"
    bodies = 3 if isinstance(mechanism, SpatialFourBar) else len(mechanism.links) + (name == "slider_crank")
    for candidate in looked:
        numbers = {key: value for key, value in candidate.items() if key != "rms"}
        try:
            design = find_design(read_spec(write_search(wanted, name, numbers, folder, force)), where, fresh=fresh)
        except InputError as error:
            cause = error.problems[0].message
            continue
        moved = dict(zip(map(column_of, design.spec.paths), design.x.tolist(), strict=True))
        rms = float(np.sqrt(np.mean(design.trial.residuals**2)))
        return Synthesised(name, bodies, design, rms, {**numbers, **moved}, doubt(wanted, name, rms))
    return Synthesised(name, bodies, None, np.inf, {}, cause)


def doubt(wanted: Wanted, name: str, rms: float) -> str:
    """The doubt whether a search has missed an exact design, in words: for a six-bar that carries a body without an
    exact design; else ""."""
    if wanted.kind != POSITIONS or name not in SIX_BARS or rms <= EXACT * wanted.size:
        return ""
    return "may be missed: searches of six-bars that carry a body are not reliable; more 'starts' look further"


def write_search(wanted: Wanted, name: str, numbers: Mapping[str, float], folder: Path, force: bool) -> Path:
    """Write the scene, its search file, and the tables to match into the folder. Return the path of the search file."""
    mechanism = mechanism_of(wanted, name)
    make_folder(folder, OTHER)

    def write(file: str, text: str) -> Path:
        return write_text(folder / file, f"{MARK} for '{wanted.path.name}'.\n{text}", DESIGNED, force=force, hint=OTHER)

    write(f"{name}.yaml", scene_of(wanted, mechanism, numbers))
    lines = [f"design: 1\nscene: {name}.yaml\nvary:\n"]
    box = bounds_of(wanted, mechanism)
    stay = _fixed_numbers(wanted, mechanism, sum(low < high for low, high in box.values()))
    for key, (low, high) in box.items():
        if low < high and key not in stay:
            room = 0.01 * (high - low)
            ends = min(low, numbers[key] - room), max(high, numbers[key] + room)
            lines.append(f"  parameters.{key}: [{ends[0]!r} {unit_of(key)}, {ends[1]!r} {unit_of(key)}]\n")
    lines.append("match:\n")
    for match, table in _matches(wanted, mechanism):
        write(match["through"], table)
        inside = ", ".join(f"{key}: {value}" for key, value in match.items() if key != "name")
        lines.append(f"  {match['name']}: {{{inside}}}\n")
    return write(f"{name}-search.yaml", "".join(lines) + "starts: 1\n")


def _fixed_numbers(wanted: Wanted, mechanism: Linkage | SpatialFourBar, free: int) -> set[str]:
    """Return the names of the numbers that stay as found, because the positions do not determine them. Three positions
    leave the pivots in the ground free. Where there are more `free` numbers than positions determine, 4 each, the
    pivots stay, and then points that links carry."""
    if wanted.kind != POSITIONS or isinstance(mechanism, SpatialFourBar):
        return set()
    conditions = 4 * len(wanted.values)
    pivots = {name for place in mechanism.pivots.values() for name in place}
    if free <= conditions and len(wanted.values) > THREE:
        return set()
    carried = {x for link in mechanism.links for name, place in link.carries.items() if name != "P" for x in place}
    return pivots if free - len(pivots) <= conditions else pivots | carried


def _matches(wanted: Wanted, mechanism: Linkage | SpatialFourBar) -> Iterator[tuple[dict[str, str], str]]:
    """Yield the matches of a scene, each with its table."""
    if wanted.kind == FUNCTION:
        turned = wanted.values - wanted.values[0]
        match = {"name": "output", "joint": output_joint(mechanism), "quantity": "angle", "through": "function.csv"}
        if even_inputs(wanted):
            yield match, _table("time (s),angle (rad)", np.arange(len(turned)), turned[:, 1])
        else:
            more = {"over": "A.angle", "columns": '{A.angle: "input", angle: "output"}'}
            yield match | more, _table("input (rad),output (rad)", *turned.T)
    elif wanted.kind == POSITIONS:
        x, z, angle = wanted.values.T
        time, arm = np.arange(len(x)), ARM * wanted.size
        heads = "time (s),position_x (m),position_z (m)"
        yield {"name": "P", "marker": "P", "through": "positions_p.csv"}, _table(heads, time, x, z)
        ends = x + arm * np.cos(angle), z + arm * np.sin(angle)
        yield {"name": "Q", "marker": "Q", "through": "positions_q.csv"}, _table(heads, time, *ends)
    elif wanted.times is None:
        match = {"name": "path", "marker": "P", "through": "path.csv", "over": "path"}
        yield match, _table("position_x (m),position_z (m)", *wanted.values.T)
    else:
        match = {"name": "path", "marker": "P", "through": "path.csv"}
        yield match, _table("time (s),position_x (m),position_z (m)", wanted.times, *wanted.values.T)


def _table(headings: str, *columns: Any) -> str:
    rows = zip(*(np.asarray(column, dtype=float).tolist() for column in columns), strict=True)
    return "\n".join([headings, *(",".join(map(repr, row)) for row in rows)]) + "\n"


def table(synthesis: Synthesis) -> Table:
    """A table with a row for each topology, the chosen one first."""
    rows = [
        (each.topology, None if each.design is None else each.rms, each.bodies, each.cause)
        for each in synthesis.topologies
    ]
    return Table(("topology", "rms", "bodies", "cause"), tuple(rows))


# --- The data of a synthesis for its page -----------------------------------------------------------------------------
# The motion of the best design of each topology, and the task.


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
    designs = [_design(wanted, each) for each in synthesis.topologies if each.design is not None]
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
