"""Scenes of synthesised linkages. Their numbers are parameters, and dependent values are expressions of these, so that
the scene also closes with other numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from mbproj.studies.measure.setting import shortest
from mbproj.studies.synthesis.candidates import ARM, period
from mbproj.studies.synthesis.linkage import FUNCTION, PATH, POSITIONS, Dyad, Linkage, Slide, SpatialFourBar
from mbproj.studies.synthesis.spec import Wanted

#: The beginnings of names of angles. Other numbers are lengths, except those without a unit.
ANGLES = ("start", "tilt", "twist", "lean", "angle", "swing")
#: The number of samples of a path with free timing, and of a function with uneven inputs.
FINE = 120
_AXIS = "axis: {{{0}: [0, -1, 0], {1}: [0, -1, 0]}}"
_BODY = "mass: 1, inertia: [0.01, 0.01, 0.01]"


def unit_of(name: str) -> str:
    """The unit of the number with this name."""
    if name == "turn" or name.endswith("side"):
        return ""
    return "rad" if name.startswith(ANGLES) else "m"


def scene_of(wanted: Wanted, mechanism: Linkage | SpatialFourBar, numbers: Mapping[str, float]) -> str:
    """The scene's text."""
    spatial = isinstance(mechanism, SpatialFourBar)
    parts = _spatial() if isinstance(mechanism, SpatialFourBar) else _planar(mechanism)
    follows, bodies, joints = parts
    marked = "" if spatial or wanted.kind == FUNCTION else "\n".join(_markers(wanted, mechanism)) + "\n"
    drive, simulation = _motion(wanted)
    parameters = [f"  {name}: {shortest(value)} {unit_of(name)}".rstrip() for name, value in numbers.items()]
    return "\n".join(
        [
            "mbproj: 1",
            "gravity: [0, 0, 0]",
            "parameters:",
            *parameters,
            *(f"  {name}: {text}" for name, text in follows),
            "bodies:",
            *(f"  {line}" for line in bodies),
            "joints:",
            *(f"  {line}" for line in joints),
            f"{marked}motions:",
            f'  drive: {{joint: A, angle: "{drive}"}}',
            f"simulation: {{{simulation}, kinematic: true}}",
            "",
        ]
    )


def even_inputs(wanted: Wanted) -> bool:
    """Whether the inputs of a function are evenly spaced: then each is a sample of the run."""
    steps = np.diff(wanted.values[:, 0])
    return bool(np.allclose(steps, steps.mean(), rtol=1e-9, atol=0.0))


def _motion(wanted: Wanted) -> tuple[str, str]:
    """The text of the crank's motion and of the run."""
    count = len(wanted.values)
    if wanted.kind == POSITIONS:
        return _through(count), f"duration: {count - 1} s, output_step: 1"
    if wanted.kind == FUNCTION:
        span = float(np.ptp(wanted.values[:, 0]))
        samples = count - 1 if even_inputs(wanted) else FINE
        return f"{span!r}*t/{count - 1}", f"duration: {count - 1} s, output_step: {count - 1}/{samples}"
    if wanted.times is None:
        return "turn*2*pi*t", f"duration: 1 s, output_step: 1/{FINE}"
    end, steps = float(wanted.times[-1]), np.diff(wanted.times)
    even = np.allclose(steps, steps.mean(), rtol=1e-9, atol=0.0)
    drive = f"turn*2*pi*t/{period(wanted)!r}" if wanted.turns else f"turn*angle*t/{end!r}"
    return drive, f"duration: {end!r} s, output_step: {end!r}/{count - 1 if even else FINE}"


def _through(count: int) -> str:
    """Lagrange's polynomial in t that is 0 at t = 0 and `swing_k` at t = k - 1."""
    terms = []
    for k in range(1, count):
        others = [j for j in range(count) if j != k]
        below = float(np.prod([k - j for j in others]))
        terms.append(f"swing_{k + 1}*" + "*".join(f"(t - {j})" if j else "t" for j in others) + f"/({below!r})")
    return " + ".join(terms)


def _markers(wanted: Wanted, mechanism: Linkage | SpatialFourBar) -> Iterator[str]:
    assert isinstance(mechanism, Linkage)
    yield "markers:"
    yield f"  P: {{body: {mechanism.traced}, location: {{{mechanism.traced}: [px, 0, pz]}}}}"
    if wanted.kind == POSITIONS:
        arm = repr(ARM * wanted.size)
        place = f"[px + {arm}*cos(lean), 0, pz + {arm}*sin(lean)]"
        yield f"  Q: {{body: {mechanism.traced}, location: {{{mechanism.traced}: {place}}}}}"


def _planar(linkage: Linkage) -> tuple[Sequence[tuple[str, str]], Sequence[str], Sequence[str]]:
    """Return the expressions of dependent values, the bodies, and the joints."""
    crank = linkage.links[0]
    at = dict(linkage.pivots)
    follows: list[tuple[str, str]] = []

    def place(point: str, x: str, z: str) -> None:
        follows.extend([(f"{point}_x", x), (f"{point}_z", z)])
        at[point] = (f"{point}_x", f"{point}_z")

    origin = at[crank.origin]
    place(
        crank.toward,
        *(f"{coordinate} + {crank.length}*{f}(start)" for coordinate, f in zip(origin, ("cos", "sin"), strict=True)),
    )
    for step in linkage.steps:
        links = (
            [linkage.link(step.link)] if isinstance(step, Slide) else [*map(linkage.link, (step.first, step.second))]
        )
        follows += _slid(linkage, step, at) if isinstance(step, Slide) else _meeting_point(linkage, step, at)
        at[links[0].toward] = (f"{links[0].toward}_x", f"{links[0].toward}_z")
        for link in links:
            (x, z), (far_x, far_z), turn = at[link.origin], at[link.toward], f"{link.name}_turn"
            follows.append((turn, f"atan2({far_z} - {z}, {far_x} - {x})"))
            for name, (along, across) in link.carries.items():
                if name != "P":
                    place(
                        name,
                        f"{x} + {along}*cos({turn}) - {across}*sin({turn})",
                        f"{z} + {along}*sin({turn}) + {across}*cos({turn})",
                    )
    bodies = []
    for link in linkage.links:
        turn = "start" if link is crank else f"{link.name}_turn"
        bodies.append(_body(link.name, at[link.origin], turn))
    bodies += [_body("slider", at[linkage.link(s.link).toward], s.tilt) for s in linkage.steps if isinstance(s, Slide)]
    return follows, bodies, [*_joints(linkage, at)]


def _body(name: str, place: tuple[str, str], turn: str) -> str:
    pose = f"position: [{place[0]}, 0, {place[1]}], orientation: {{axis: [0, -1, 0], angle: {turn}}}"
    return f"{name}: {{{_BODY}, {pose}}}"


def _meeting_point(linkage: Linkage, step: Dyad, at: Mapping[str, tuple[str, str]]) -> Iterator[tuple[str, str]]:
    one, two = linkage.link(step.first), linkage.link(step.second)
    (x, z), (far_x, far_z), name = at[one.origin], at[two.origin], one.toward
    yield f"{name}_apart", f"hypot({far_x} - {x}, {far_z} - {z})"
    yield f"{name}_along", f"({one.length}**2 - {two.length}**2 + {name}_apart**2)/(2*{name}_apart)"
    yield f"{name}_up", f"{step.side}*sqrt(max({one.length}**2 - {name}_along**2, 0*{one.length}**2))"
    yield f"{name}_x", f"{x} + (({far_x} - {x})*{name}_along - ({far_z} - {z})*{name}_up)/{name}_apart"
    yield f"{name}_z", f"{z} + (({far_z} - {z})*{name}_along + ({far_x} - {x})*{name}_up)/{name}_apart"


def _slid(linkage: Linkage, step: Slide, at: Mapping[str, tuple[str, str]]) -> Iterator[tuple[str, str]]:
    link, (ax, az) = linkage.link(step.link), at[linkage.links[0].origin]
    (x, z), name, cos, sin = at[link.origin], link.toward, f"cos({step.tilt})", f"sin({step.tilt})"
    yield f"{name}_across", f"{step.offset} + ({x} - {ax})*{sin} - ({z} - {az})*{cos}"
    reach = f"{step.side}*sqrt(max({link.length}**2 - {name}_across**2, 0*{link.length}**2))"
    yield f"{name}_ahead", f"({x} - {ax})*{cos} + ({z} - {az})*{sin} + {reach}"
    yield f"{name}_x", f"{ax} + {name}_ahead*{cos} - {step.offset}*{sin}"
    yield f"{name}_z", f"{az} + {name}_ahead*{sin} + {step.offset}*{cos}"


def _joints(linkage: Linkage, at: Mapping[str, tuple[str, str]]) -> Iterator[str]:
    """Return the joints: a pin at each link's origin, and one where the links of a dyad meet."""
    carriers = {name: (each, f"[{x}, 0, {z}]") for each in linkage.links for name, (x, z) in each.carries.items()}
    crank = linkage.links[0]
    carriers[crank.toward] = crank, f"[{crank.length}, 0, 0]"
    for link in linkage.links:
        if link.origin in linkage.pivots:
            x, z = at[link.origin]
            yield _pin(link.origin, "ground", f"[{x}, 0, {z}]", link.name, "[0, 0, 0]")
        else:
            carrier, place = carriers[link.origin]
            yield _pin(link.origin, carrier.name, place, link.name, "[0, 0, 0]")
    for step in linkage.steps:
        if isinstance(step, Dyad):
            one, two = linkage.link(step.first), linkage.link(step.second)
            yield _pin(one.toward, one.name, f"[{one.length}, 0, 0]", two.name, f"[{two.length}, 0, 0]")
            continue
        link, (x, z) = linkage.link(step.link), at[linkage.link(step.link).toward]
        yield _pin(link.toward, link.name, f"[{link.length}, 0, 0]", "slider", "[0, 0, 0]")
        along = f"[cos({step.tilt}), 0, sin({step.tilt})]"
        place = f"location: {{ground: [{x}, 0, {z}], slider: [0, 0, 0]}}"
        axes = f"axis: {{ground: {along}, slider: [1, 0, 0]}}"
        yield f"guide: {{type: prismatic, bodies: [ground, slider], {place}, {axes}}}"


def _pin(name: str, one: str, there: str, two: str, here: str) -> str:
    place = f"location: {{{one}: {there}, {two}: {here}}}"
    return f"{name}: {{type: revolute, bodies: [{one}, {two}], {place}, {_AXIS.format(one, two)}}}"


def _spatial() -> tuple[Sequence[tuple[str, str]], Sequence[str], Sequence[str]]:
    follows = [
        ("from_lever", "crank_length*cos(start) - 1 m"),
        ("upward", "crank_length*sin(start) - dz"),
        ("slanted", "-dy*sin(twist) + upward*cos(twist)"),
        ("far", "from_lever**2 + dy**2 + upward**2 + lever_length**2 - rod_length**2"),
        ("bent", "acos(clip(far/(2*lever_length*hypot(from_lever, slanted)), -1, 1))"),
        ("lever_turn", "atan2(slanted, from_lever) + side*bent"),
    ]
    bodies = [
        _body("crank", ("0", "0"), "start"),
        f"lever: {{{_BODY}, position: [1, dy, dz]}}",
    ]
    axis = "[0, -cos(twist), sin(twist)]"
    end = ", ".join(
        f"lever_length*{part}"
        for part in ("cos(lever_turn)", "sin(lever_turn)*sin(twist)", "sin(lever_turn)*cos(twist)")
    )
    joints = [
        _pin("A", "ground", "[0, 0, 0]", "crank", "[0, 0, 0]"),
        "D: {type: revolute, bodies: [ground, lever], location: {ground: [1, dy, dz], lever: [0, 0, 0]}, "
        f"axis: {{ground: {axis}, lever: {axis}}}}}",
        "rod: {type: distance, bodies: [crank, lever], length: rod_length, "
        f"locations: {{crank: [crank_length, 0, 0], lever: [{end}]}}}}",
    ]
    return follows, bodies, joints


def output_joint(mechanism: Linkage | SpatialFourBar) -> str:
    """The joint whose angle is the output of a function: the pivot of the link in the ground."""
    return "D" if isinstance(mechanism, SpatialFourBar) else mechanism.link(mechanism.output).origin


__all__ = ["PATH", "even_inputs", "output_joint", "scene_of", "unit_of"]
