"""Scenes of bars, as templates: a pendulum, chains and trees, loops of parallelograms, and bars on the rim of a hub."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import pi
from typing import NamedTuple

from mbproj.base.errors import InputError
from mbproj.scene.templates.values import Values, refused

# --- A bar on a pin: the first mechanism, with its period in closed form ----------------------------------------------

PENDULUM = {"length": "1 m", "mass": "1 kg", "angle": "60 deg"}
#: Steps of the arithmetic-geometric mean: each doubles the number of correct digits.
MEANS = 7


def pendulum(values: Values) -> Iterator[str]:
    """Yield the lines of a pendulum over two periods. Raises InputError for an angle that gives no swing."""
    if not 0.0 < abs(values.number["angle"]) < pi:
        raise InputError(refused("angle", "must be between 0 and 180 deg", "it is counted from hanging straight down"))
    yield from (
        "# A uniform bar on a pin, released from rest. Its period has a closed form with the arithmetic-geometric",
        "# mean M of two numbers: 2π / (rate M(1, cos(angle/2))). Look at the joint's angle, and at the expectations.",
        "mbproj: 1",
        "title: Pendulum",
        "gravity: [0, 0, -g]",
        "parameters:",
        "  g: 9.81 m/s^2",
        *values.parameters("length", "mass", "angle"),
        "  radius: length / 50                    # of the bar",
        "  moment: mass * (radius**2 / 4 + length**2 / 3)          # about the pin",
        "  rate: sqrt(mass * g * length / (2 * moment))            # rad/s, of small swings",
        "  a0: 1                                  # arithmetic and geometric means",
        "  b0: cos(angle / 2)",
        *(
            line
            for k in range(1, MEANS)
            for line in (f"  a{k}: (a{k - 1} + b{k - 1}) / 2", f"  b{k}: sqrt(a{k - 1} * b{k - 1})")
        ),
        f"  period: 2 * pi / (rate * a{MEANS - 1})",
        "simulation:",
        "  duration: 2 * period",
        "  step: period / 1000",
        "  integrator: dop853",
        "  output_step: period / 200",
        "bodies:",
        "  bar:                                   # its axis is its body x, which points away from the pin",
        "    mass: mass",
        "    shape: {cylinder: {radius: radius, length: length, axis: x}}",
        "    position: [length/2 * sin(angle), 0, -length/2 * cos(angle)]",
        "    orientation: {axis: [0, 1, 0], angle: 90 deg - angle}",
        "joints:",
        "  pin: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, 1, 0]}",
        "markers:",
        "  end: {body: bar, location: {bar: [length/2, 0, 0]}}",
        "expect:",
        "  hangs: {joint: pin, quantity: angle, at: period/4, value: angle, absolute: 1.0e-7, source: exact period}",
        "  fastest: {joint: pin, quantity: angle_speed, at: period/4, relative: 1.0e-6,",
        "            value: 2 * rate * sin(angle/2), source: energy}",
        "  pull: {joint: pin, quantity: reaction_force, component: norm, at: period/4, relative: 1.0e-6,",
        "         value: mass * (g + length/2 * (2 * rate * sin(angle/2))**2), source: weight and centripetal force}",
        "  returns: {joint: pin, quantity: angle, at: period, value: 0, absolute: 1.0e-7, source: exact period}",
        *closed_and_kept("1.0e-8", "mass * g * length", values.number["length"]),
    )


def closed_and_kept(drift: str, energy: str = "", size: float = 1.0) -> Iterator[str]:
    """Yield the expectations that scenes share: joints closed to the round-off of coordinates of `size` in m, and
    energy kept. Its drift is below `drift` times `energy`, an expression in J; where that is "", times the energy that
    the run exchanges."""
    bound = f"{max(1e-12, 2e-15 * size):.1e}"
    yield f"  closed: {{diagnostic: position_violation, at: maximum, below: {bound}, source: joints are closed}}"
    diagnostic, below = ("energy_drift", f"{drift} * {energy}") if energy else ("energy_drift_relative", drift)
    yield f"  energy: {{diagnostic: {diagnostic}, at: maximum, below: {below}, source: balance of energy}}"


# --- Bars that hang on each other -------------------------------------------------------------------------------------
# Chains and trees, in a plane or in space.


CHAIN = {"links": "5", "length": "1 m", "mass": "1 kg", "angle": "60 deg"}
TREE = {"links": "7", "length": "1 m", "mass": "1 kg", "angle": "30 deg"}

#: Settings that suit any number of bars of any length.
SIMULATION = (
    "simulation:",
    "  duration: 15 * sqrt(length / g)        # a few swings of one bar",
    "  tolerance: 1.0e-9",
    "  integrator: dop853",
    "  output_step: 0.015 * sqrt(length / g)",
)


class _Bar(NamedTuple):
    """A bar: its parent's number (-1: the ground); the side to which it leans (+1 or -1); how many joints are above its
    own; the place of its upper end, in units of the parameters `across` and `down`."""

    parent: int
    side: int
    depth: int
    across: int
    down: int


def chain(values: Values, spatial: bool) -> Iterator[str]:
    """Yield the lines of a chain: bars in a row."""
    links = values.count("links")
    yield "# Bars in a row, the first on the ground, straight at the start. The motion is chaotic: look at when two"
    yield "# runs with different tolerances part (mbproj compare-results)."
    yield from _scene("Chain", values, _placed_bars([(number - 1, 1) for number in range(links)]), spatial)
    yield "  stretched: {marker: end, quantity: position, component: norm, at: maximum, source: the bars are rigid,"
    yield "              below: reach * (1 + 1e-12)}"


def tree(values: Values, spatial: bool) -> Iterator[str]:
    """Yield the lines of a binary tree of bars."""
    links = values.count("links")
    yield "# A binary tree: two bars hang on the end of each, one to either side."
    family = [((number - 1) // 2, 1 if number % 2 == 0 else -1) for number in range(links)]
    yield from _scene("Tree", values, _placed_bars(family), spatial)


def _placed_bars(family: Iterable[tuple[int, int]]) -> list[_Bar]:
    """The bars with their places, from the (parent, side) of each; a parent stands before its children."""
    bars: list[_Bar] = []
    for parent, side in family:
        above = bars[parent] if parent >= 0 else None
        bars.append(
            _Bar(parent, side, 0, 0, 0)
            if above is None
            else _Bar(parent, side, above.depth + 1, above.across + above.side, above.down + 1)
        )
    return bars


def _scene(title: str, values: Values, bars: list[_Bar], spatial: bool) -> Iterator[str]:
    where = "in space" if spatial else "in a plane"
    yield from ("mbproj: 1", f"title: {title} of {len(bars)} {where}", "gravity: [0, 0, -g]", "parameters:")
    yield "  g: 9.81 m/s^2"
    yield from values.parameters("length", "mass", "angle")
    yield "  radius: length / 50                    # of the bars"
    yield "  across: length * sin(angle)            # from one end of a bar to the other"
    yield "  down: length * cos(angle)"
    levels = 1 + max(bar.depth for bar in bars)
    yield f"  reach: {levels} * length".ljust(41) + "# of as many bars as hang on each other"
    yield f"  energy: {len(bars)} * mass * g * reach".ljust(41) + "# J, of the size of what the run exchanges"
    if spatial and levels > 1:
        kick = f"  kick: 0.3 * sqrt(g / reach) / {levels // 2}".ljust(41)
        yield f"{kick}# of every second joint at the start, out of the plane"
    yield from SIMULATION
    yield "bodies:                                  # a bar's axis is its body x, which points to its lower end"
    for number, bar in enumerate(bars):
        x, z = bar.across + bar.side / 2, bar.down + 0.5
        yield f"  bar{number + 1}:"
        yield "    mass: mass"
        yield "    shape: {cylinder: {radius: radius, length: length, axis: x}}"
        yield f"    position: [{x:g} * across, 0, -{z:g} * down]"
        yield f"    orientation: {{axis: [0, 1, 0], angle: 90 deg {'-' if bar.side > 0 else '+'} angle}}"
    yield "joints:"
    for number, bar in enumerate(bars):
        yield from _pin(number, bar, spatial)
    last = len(bars)
    yield "markers:"
    yield f"  end: {{body: bar{last}, location: {{bar{last}: [length/2, 0, 0]}}}}"
    yield "expect:"
    yield from closed_and_kept("1.0e-8", "energy", levels * values.number["length"])


def _pin(number: int, bar: _Bar, spatial: bool) -> Iterator[str]:
    """Yield the lines of the joint of a bar. It turns about y; in space every second one turns about the bar's normal
    in the x-z plane."""
    out_of_plane = spatial and bar.depth % 2 == 1
    normal = f"[cos(angle), 0, {'' if bar.side > 0 else '-'}sin(angle)]"
    axis = f"{normal}, speed: kick" if out_of_plane else "[0, 1, 0]"
    parent = f"bar{bar.parent + 1}" if bar.parent >= 0 else "ground"
    yield f"  pin{number + 1}: {{type: revolute, bodies: [{parent}, bar{number + 1}],"
    yield f"    location: [{bar.across} * across, 0, -{bar.down} * down], axis: {axis}}}"


# --- Loops one below the other ----------------------------------------------------------------------------------------
# Parallelograms, each hanging on the one above.


LADDER = {"loops": "3", "length": "1 m", "mass": "1 kg"}


def ladder(values: Values) -> Iterator[str]:
    """Yield the lines of a ladder with as many loops as its option says."""
    loops = values.count("loops")
    yield from (
        "# A ladder of parallelograms: two rails and a rung, on which the next two rails hang. Each loop is closed by",
        "# revolute, spherical, universal and revolute joint: in space four revolutes would hold its plane twice over.",
        "# The rungs stay level, whatever the rails do.",
        "mbproj: 1",
        f"title: Ladder of {loops}",
        "gravity: [0, 0, -g]",
        "parameters:",
        "  g: 9.81 m/s^2",
        *values.parameters("length", "mass"),
        "  radius: length / 50                    # of the bars",
        "  kick: 0.2 * sqrt(g / length)           # of the first rails at the start",
        *SIMULATION,
        "bodies:                                  # rails are along z, rungs along x",
    )
    for k in range(loops):
        yield from _bar(f"left{k + 1}", "z", f"-length/2, 0, -{k + 0.5:g} * length")
        yield from _bar(f"right{k + 1}", "z", f"length/2, 0, -{k + 0.5:g} * length")
        yield from _bar(f"rung{k + 1}", "x", f"0, 0, -{k + 1} * length")
    yield "joints:"
    for k in range(loops):
        frame, speed = (f"rung{k}", "0") if k else ("ground", "kick")
        n, top, low = k + 1, f"-{k} * length", f"-{k + 1} * length"
        yield f"  A{n}: {{type: revolute, bodies: [{frame}, left{n}], location: [-length/2, 0, {top}], axis: [0, 1, 0],"
        yield f"    speed: {speed}}}"
        yield f"  B{n}: {{type: spherical, bodies: [left{n}, rung{n}], location: [-length/2, 0, {low}]}}"
        yield f"  C{n}: {{type: universal, bodies: [rung{n}, right{n}], location: [length/2, 0, {low}],"
        yield "    axes: [[0, 0, 1], [0, 1, 0]]}"
        yield f"  D{n}: {{type: revolute, bodies: [{frame}, right{n}], location: [length/2, 0, {top}],"
        yield "    axis: [0, 1, 0]}"
    yield from (
        "markers:",
        f"  lowest: {{body: rung{loops}, location: {{rung{loops}: [0, 0, 0]}}}}",
        "expect:",
        f"  level: {{body: rung{loops}, quantity: orientation, at: end, value: [1, 0, 0, 0], absolute: 1.0e-10,",
        "          source: parallelograms}",
        *closed_and_kept("1.0e-6", size=loops * values.number["length"]),
    )


def _bar(name: str, axis: str, position: str) -> Iterator[str]:
    yield f"  {name}:"
    yield "    mass: mass"
    yield f"    shape: {{cylinder: {{radius: radius, length: length, axis: {axis}}}}}"
    yield f"    position: [{position}]"


# --- Bars on the rim of a hub that turns, as on a carousel ------------------------------------------------------------


STAR = {"links": "6", "length": "1 m", "mass": "1 kg", "speed": "3 rad/s"}


def star(values: Values) -> Iterator[str]:
    """Yield the lines of a hub with as many bars as the option `links` says."""
    links = values.count("links")
    yield from (
        "# A hub turns about the vertical; bars hang from its rim, each on a pin along the rim, and swing outwards.",
        "# All of them do the same, and the hub turns slower while they are out. Look at its speed.",
        "mbproj: 1",
        f"title: Star of {links}",
        "gravity: [0, 0, -g]",
        "parameters:",
        "  g: 9.81 m/s^2",
        *values.parameters("length", "mass", "speed"),
        "  radius: length / 50                    # of the bars",
        "  rim: length                            # radius of the hub",
        f"  hub_mass: {links} * mass",
        f"  apart: 360 deg / {links}",
        "  energy: hub_mass * (g * length + (speed * rim)**2)      # J, of the size of what the run exchanges",
        *SIMULATION,
        "bodies:                                  # a bar's axis is its body z",
        "  hub: {mass: hub_mass, shape: {cylinder: {radius: rim, length: rim/10, axis: z}}, position: [0, 0, 0]}",
    )
    for k in range(links):
        yield f"  bar{k + 1}:"
        yield "    mass: mass"
        yield "    shape: {cylinder: {radius: radius, length: length, axis: z}}"
        yield f"    position: [rim * cos({k} * apart), rim * sin({k} * apart), -length/2]"
    yield "joints:"
    yield "  shaft: {type: revolute, bodies: [ground, hub], location: [0, 0, 0], axis: [0, 0, 1], speed: speed}"
    for k in range(links):
        yield f"  pin{k + 1}: {{type: revolute, bodies: [hub, bar{k + 1}], speed: 0,"
        yield f"    location: [rim * cos({k} * apart), rim * sin({k} * apart), 0],"
        yield f"    axis: [-sin({k} * apart), cos({k} * apart), 0]}}"
    yield from (
        "markers:",
        "  end: {body: bar1, location: {bar1: [0, 0, -length/2]}}",
        "expect:",
        "  never_faster: {joint: shaft, quantity: angle_speed, at: maximum,",
        "                 below: speed * (1 + 1e-9) + 1e-9 * sqrt(g / length),",
        "                 source: constant angular momentum; the moment of inertia is smallest at the start}",
        *closed_and_kept("1.0e-6", "energy", 2 * values.number["length"]),
    )
