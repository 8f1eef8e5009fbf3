"""Linkages with a driven crank, whose motion has a closed form: slider-crank and four-bar."""

from __future__ import annotations

from collections.abc import Iterator

from mbproj.errors import InputError
from mbproj.templates.pendulum import closed_and_kept
from mbproj.templates.values import Values, refused

SLIDER_CRANK = {"crank": "100 mm", "rod": "300 mm", "mass": "1 kg", "speed": "60 rpm"}
FOUR_BAR = {
    "crank": "100 mm",
    "coupler": "300 mm",
    "rocker": "250 mm",
    "frame": "300 mm",
    "mass": "1 kg",
    "speed": "60 rpm",
}
#: Two turns of the crank, in a thousand steps each.
SIMULATION = (
    "  turn: 2*pi / speed                     # s, of the crank",
    "simulation:",
    "  duration: 2 * turn",
    "  step: turn / 1000",
    "  integrator: rk4",
    "  output_step: turn / 200",
)
MOTION = ("motions:", "  drive: {joint: A, angle: {constant_speed: speed}}")


def slider_crank(values: Values) -> Iterator[str]:
    """Yield the lines of a crank, a rod and a slider in line with the crank's axis. Raises InputError where the crank
    cannot go round."""
    if not values.number["rod"] > values.number["crank"]:
        raise InputError(refused("rod", "is not longer than the crank, which cannot go round", "give a longer rod"))
    yield from (
        "# A slider-crank in the x-z plane, driven at constant speed. With φ the crank's angle from the x axis the",
        "# slider is at x = crank cos φ + sqrt(rod² - crank² sin² φ). The rod may slide along the slider's pin, as",
        "# floating pins do: another revolute would hold its plane twice over.",
        "mbproj: 1",
        "title: Slider-crank",
        "gravity: [0, 0, -9.81]",
        "parameters:",
        *values.parameters("crank", "rod", "mass", "speed"),
        "  start: 30 deg                          # φ at the start",
        "  lean: asin(crank / rod * sin(start))   # of the rod",
        "  pin: crank * cos(start) + rod * cos(lean)               # x of the slider",
        "  phi: start + 0.7 * 360 deg             # φ in the first expectations",
        "  root: sqrt(rod**2 - crank**2 * sin(phi)**2)",
        *SIMULATION,
        "bodies:                                  # the axes of crank and rod are body x",
        "  crank:",
        "    mass: mass / 2",
        "    shape: {cylinder: {radius: crank/10, length: crank, axis: x}}",
        "    position: [crank/2 * cos(start), 0, crank/2 * sin(start)]",
        "    orientation: {axis: [0, -1, 0], angle: start}",
        "  rod:",
        "    mass: mass / 2",
        "    shape: {cylinder: {radius: crank/10, length: rod, axis: x}}",
        "    position: [(crank * cos(start) + pin) / 2, 0, crank/2 * sin(start)]",
        "    orientation: {axis: [0, 1, 0], angle: lean}",
        "  slider: {mass: mass, shape: {box: [crank, crank, crank]}, position: [pin, 0, 0]}",
        "joints:",
        "  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, -1, 0], speed: speed}",
        "  B:",
        "    type: revolute",
        "    bodies: [crank, rod]",
        "    location: [crank * cos(start), 0, crank * sin(start)]",
        "    axis: [0, 1, 0]",
        "  C: {type: point_on_line, bodies: [slider, rod], location: [pin, 0, 0], axis: [0, 1, 0]}",
        "  D: {type: prismatic, bodies: [ground, slider], location: [pin, 0, 0], axis: [1, 0, 0]}",
        *MOTION,
        "markers:",
        "  slider: {body: slider, location: {slider: [0, 0, 0]}}",
        "expect:",
        "  slider: {marker: slider, quantity: position, component: x, at: 0.7 * turn, value: crank * cos(phi) + root,",
        "           absolute: 1.0e-10 * rod, source: the formula above}",
        "  speed: {marker: slider, quantity: velocity, component: x, at: 0.7 * turn, absolute: 1.0e-8 * rod * speed,",
        "          value: -crank * speed * sin(phi) * (1 + crank * cos(phi) / root), source: its derivative}",
        *closed_and_kept("1.0e-6"),
    )


def four_bar(values: Values) -> Iterator[str]:
    """Yield the lines of a crank-rocker. Raises InputError where the crank cannot go round."""
    lengths = {name: values.number[name] for name in ("crank", "coupler", "rocker", "frame")}
    crank, *others = lengths.values()
    if not (crank < min(others) and crank + max(others) < sum(others) - max(others)):
        why = "cannot go round: it has to be the shortest, and with the longest less than the other two (Grashof)"
        raise InputError(refused("crank", why, "give a shorter crank"))
    yield from (
        "# A crank-rocker in the x-z plane, driven at constant speed: the crank is the shortest link and goes round",
        "# (Grashof). The rocker's angle is that of two circles that meet. The loop is closed by revolute, spherical,",
        "# universal and revolute joint: in space four revolutes would hold its plane twice over.",
        "mbproj: 1",
        "title: Four-bar",
        "gravity: [0, 0, -9.81]",
        "parameters:",
        *values.parameters(*FOUR_BAR),
        "  start: 60 deg                          # of the crank, from the line of the pivots",
        *_pose("", "start", "At the start"),
        "  phi: start + 0.7 * 360 deg             # the crank's angle in the first expectation",
        *_pose("_then", "phi", "Then"),
        *SIMULATION,
        "bodies:                                  # a bar's axis is its body x, away from the ground or the crank",
        *_bar("crank", "crank/2 * cos(start)", "crank/2 * sin(start)", "start"),
        *_bar("coupler", "(crank * cos(start) + end_x) / 2", "(crank * sin(start) + end_z) / 2", "tilt"),
        *_bar("rocker", "(frame + end_x) / 2", "end_z / 2", "swing"),
        "joints:",
        "  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, -1, 0], speed: speed}",
        "  B: {type: spherical, bodies: [crank, coupler], location: [crank * cos(start), 0, crank * sin(start)]}",
        "  C:",
        "    type: universal",
        "    bodies: [coupler, rocker]",
        "    location: [end_x, 0, end_z]",
        "    axes: [[-sin(tilt), 0, cos(tilt)], [0, 1, 0]]",
        "  D: {type: revolute, bodies: [ground, rocker], location: [frame, 0, 0], axis: [0, -1, 0]}",
        *MOTION,
        "markers:",
        "  coupler_point: {body: coupler, location: {coupler: [0, 0, coupler/3]}}",
        "expect:",
        "  rocker: {joint: D, quantity: angle, at: 0.7 * turn, value: swing_then - swing, absolute: 1.0e-9,",
        "           source: two circles that meet}",
        "  round: {joint: A, quantity: angle, at: turn, value: 360 deg, absolute: 1.0e-9, source: the motion}",
        *closed_and_kept("1.0e-6"),
    )


def _pose(suffix: str, angle: str, when: str) -> Iterator[str]:
    """Yield the parameters, their names ending in `suffix`, for the pose where the crank is at `angle`."""
    s = suffix
    yield f"  # {when}: the line of sight from the crank's end to the rocker's pivot, the coupler's angle and end,"
    yield "  # and the rocker's angle"
    yield f"  span{s}: hypot(frame - crank * cos({angle}), crank * sin({angle}))"
    yield f"  sight{s}: atan2(-crank * sin({angle}), frame - crank * cos({angle}))"
    yield f"  tilt{s}: sight{s} + acos((coupler**2 + span{s}**2 - rocker**2) / (2 * coupler * span{s}))"
    yield f"  end_x{s}: crank * cos({angle}) + coupler * cos(tilt{s})"
    yield f"  end_z{s}: crank * sin({angle}) + coupler * sin(tilt{s})"
    yield f"  swing{s}: atan2(end_z{s}, end_x{s} - frame)"


def _bar(name: str, x: str, z: str, angle: str) -> Iterator[str]:
    yield f"  {name}:"
    yield "    mass: mass"
    yield f"    shape: {{cylinder: {{radius: crank/10, length: {name}, axis: x}}}}"
    yield f"    position: [{x}, 0, {z}]"
    yield f"    orientation: {{axis: [0, -1, 0], angle: {angle}}}"
