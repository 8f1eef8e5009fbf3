"""Scenes of machines, as templates: linkages with a driven crank, a cam, a Geneva drive, and drums with their loads."""

from __future__ import annotations

from collections.abc import Iterator

from mbproj.base.errors import InputError
from mbproj.scene.templates.bars import closed_and_kept
from mbproj.scene.templates.values import Values, refused

# --- Linkages with a driven crank, whose motion has a closed form: slider-crank and four-bar --------------------------

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


# --- A cam, its roller follower and a spring, designed for a lift law, a speed and a mass -----------------------------


CAM = {"radius": "40 mm", "mass": "0.5 kg", "speed": "30 rad/s"}


def cam(values: Values) -> Iterator[str]:
    """Yield the lines of a disc cam whose follower may lift off, with a spring that is just strong enough."""
    yield from (
        "# A disc cam lifts a roller follower against a spring: up over 120 deg, a dwell of 60 deg, down, and a dwell.",
        "# The contact may open: with --set reserve=0.3 the spring is too weak: the follower flies. See the profile by",
        "# `mbproj curve`. More of it: `mbproj help follow_a_curve`.",
        "mbproj: 1",
        "title: Cam",
        "gravity: [0, 0, -9.81 m/s^2]",
        "parameters:",
        *values.parameters("radius", "mass", "speed"),
        "  roller: 0.3 * radius",
        "  lift: 0.5 * radius",
        "  sharpest: 2*pi * lift * (speed / (2*pi/3))**2   # m/s^2, the largest acceleration of a cycloidal rise",
        "  reserve: 1.3                           # of the spring",
        "  stiffness: reserve * mass * (sharpest + 1 m/s^2) / (2*lift)",
        "  down: radius + roller                  # where the follower is at the lowest",
        "simulation:",
        "  duration: (1 + 150/360) * 2*pi / speed # a turn, and to the middle of the dwell",
        "  tolerance: 1.0e-10",
        "  integrator: dop853",
        "  output_step: (1 + 150/360) * 2*pi / speed / 204",
        "curves:",
        "  law:",
        "    lift:",
        "      base: radius",
        "      rises: [[120 deg, lift, cycloidal], [60 deg, lift, dwell],",
        "              [120 deg, 0 m, cycloidal], [60 deg, 0 m, dwell]]",
        "    roller: roller",
        "    clockwise: true                      # the cam turns counterclockwise: this is the order of the law",
        "bodies:",
        "  shaft: {mass: 2 * mass, shape: {cylinder: {radius: radius, length: roller, axis: y}}, position: [0, 0, 0]}",
        "  follower: {mass: mass, shape: {sphere: roller}, position: [0, 0, down]}",
        "joints:",
        "  axle: {type: revolute, bodies: [ground, shaft], location: [0, 0, 0], axis: [0, -1, 0]}",
        "  guide: {type: prismatic, bodies: [ground, follower], location: [0, 0, down], axis: [0, 0, 1]}",
        "  contact: {type: cam_contact, bodies: [shaft, follower], curve: law, axis: [0, -1, 0], x_axis: [0, 0, 1],",
        "            locations: [[0, 0, 0], [0, 0, down]],",
        "            limits: {gap: {range: [0, null], rigid: true, restitution: 0}}}",
        "forces:",
        "  spring: {type: spring_damper, points: {ground: [0, 0, 6*radius], follower: [0, 0, down]},",
        "           stiffness: stiffness, free_length: 6*radius - down + 2*lift}",
        "motions:",
        "  motor: {joint: axle, angle: {constant_speed: speed}}",
        "markers:",
        "  centre: {body: follower, location: {follower: [0, 0, 0]}}",
        "expect:",
        "  up: {joint: guide, quantity: displacement, at: end, value: lift, relative: 1.0e-8, source: the lift law}",
        "  energy: {diagnostic: energy_drift_relative, at: maximum, below: 1.0e-8, source: energy}",
        "  closed: {diagnostic: position_violation, at: maximum, below: 1.0e-13, source: joints are closed}",
    )


# --- A Geneva drive that turns freely ---------------------------------------------------------------------------------
# Its energy is constant, which gives the speed of the driver in closed form.


GENEVA = {"slots": "4", "length": "100 mm", "mass": "1 kg", "speed": "10 rad/s"}


def geneva(values: Values) -> Iterator[str]:
    """Yield the lines of a driver and a slotted wheel; the run takes two turns and ends in the middle of a slot."""
    yield from (
        "# A Geneva drive: in each of its turns the pin of the driver turns the wheel by one slot, and then its disc",
        "# holds the wheel. Nothing drives it: the driver slows down while the wheel turns, and gets all of it back.",
        "# Look at the speeds of the joints. Other couplings: `mbproj help couple_joints`.",
        "mbproj: 1",
        "title: Geneva drive",
        "gravity: [0, 0, 0]",
        "parameters:",
        *values.parameters("slots", "length", "mass", "speed"),
        "  k: sin(pi / slots)                     # crank over distance: the pin enters its slot along it",
        "  J1: mass * length**2 / 5               # of the driver about its axle",
        "  J2: mass * length**2 / 20              # of the wheel",
        "simulation:",
        "  duration: 2 * 2*pi / speed",
        "  tolerance: 1.0e-12",
        "  integrator: dop853",
        "  output_step: 2*pi / speed / 100",
        "bodies:",
        "  driver: {mass: mass, inertia: [J1, J1, J1], position: [0, 0, 0]}",
        "  wheel: {mass: mass, inertia: [J2, J2, J2], position: [length, 0, 0]}",
        "joints:",
        "  input: {type: revolute, bodies: [ground, driver], location: [0, 0, 0], axis: [0, -1, 0],",
        "          angle: -180 deg, speed: speed}",
        "  output: {type: revolute, bodies: [ground, wheel], location: [length, 0, 0], axis: [0, -1, 0],",
        "           angle: pi / slots}",
        "  drive: {type: geneva, joints: [input, output], slots: slots}",
        "markers:",
        "  pin: {body: driver, location: {driver: [k * length, 0, 0]}}",
        "  rim: {body: wheel, location: {wheel: [-0.9 * length * sqrt(1 - k**2), 0, 0]}}",
        "expect:",
        "  slows: {joint: input, quantity: angle_speed, at: minimum, relative: 1.0e-3,",
        "          value: speed / sqrt(1 + J2/J1 * (k / (1 - k))**2), source: energy in the middle of a slot}",
        "  energy: {diagnostic: energy_drift_relative, at: maximum, below: 1.0e-11, source: energy}",
        "  closed: {diagnostic: position_violation, at: maximum, below: 1.0e-11, source: joints are closed}",
    )


# --- A drum, a rope and a moving block whose load falls ---------------------------------------------------------------
# The fall and the tension of the rope have closed forms.


HOIST = {"radius": "10 cm", "mass": "50 kg", "length": "2 m"}


def hoist(values: Values) -> Iterator[str]:
    """Yield the lines of a hoist whose load falls by the option `length`."""
    yield from (
        "# A hoist whose brake has failed: the load hangs on a moving block, around which a rope runs from the drum to",
        "# the ceiling. So two strands carry it, and the drum pays out twice as much rope as the load falls.",
        "# `mbproj help run_a_rope_over_sheaves` has more places and ropes.",
        "mbproj: 1",
        "title: Hoist",
        "gravity: [0, 0, -g]",
        "parameters:",
        "  g: 9.81 m/s^2",
        *values.parameters("radius", "mass", "length"),
        "  drum: 0.4 * mass                       # a solid cylinder",
        "  inertia: drum * radius**2 / 2          # of the drum about its axle",
        "  fall: g * mass / (mass + 4 * inertia / radius**2)       # m/s^2",
        "  time: sqrt(2 * length / fall)          # until the load has fallen by the length",
        "simulation:",
        "  duration: time",
        "  tolerance: 1.0e-10",
        "  integrator: dop853",
        "  output_step: time / 100",
        "bodies:",
        "  drum: {mass: drum, shape: {cylinder: {radius: radius, length: 4 * radius, axis: y}}, position: [0, 0, 0]}",
        "  load: {mass: mass, shape: {box: [2*radius, 2*radius, 2*radius]}, position: [2*radius, 0, -length]}",
        "joints:",
        "  axle: {type: revolute, bodies: [ground, drum], location: [0, 0, 0], axis: [0, 1, 0]}",
        "  guide: {type: prismatic, bodies: [ground, load], location: [2*radius, 0, -length], axis: [0, 0, 1]}",
        "  rope:",
        "    type: rope",
        "    normal: [0, -1, 0]",
        "    path:",
        "      - {drum: drum, radius: radius, bends: right}",
        "      - {sheave: load, radius: radius, bends: left}",
        "      - {point: ground, at: [3*radius, 0, 0]}",
        "markers:",
        "  hook: {body: load, location: {load: [0, 0, radius]}}",
        "expect:",
        "  falls: {joint: guide, quantity: displacement, at: end, value: -length, relative: 1.0e-9, source: m a = F}",
        "  turns: {joint: axle, quantity: angle, at: end, value: 2*length / radius, relative: 1.0e-9, source: no slip}",
        "  energy: {diagnostic: energy_drift_relative, at: maximum, below: 1.0e-9, source: energy}",
        "  closed: {diagnostic: position_violation, at: maximum, below: 2.0e-13, source: joints are closed}",
    )


# --- A drum whose load falls ------------------------------------------------------------------------------------------
# A row couples the two coordinates; the fall and the force in the rope have closed forms.


WINCH = {"radius": "10 cm", "mass": "50 kg", "length": "2 m"}


def winch(values: Values) -> Iterator[str]:
    """Yield the lines of a winch whose load falls by the option `length`."""
    yield from (
        "# A load hangs on the drum of a winch whose brake has failed. A coupling says that the load rises by what the",
        "# drum winds up. So both fall as one mass, m + J / r². Change the row to see other couplings:",
        "# `mbproj help couple_joints`.",
        "mbproj: 1",
        "title: Winch",
        "gravity: [0, 0, -g]",
        "parameters:",
        "  g: 9.81 m/s^2",
        *values.parameters("radius", "mass", "length"),
        "  drum: 0.4 * mass                       # a solid cylinder",
        "  inertia: drum * radius**2 / 2          # of the drum about its axle",
        "  fall: g * mass / (mass + inertia / radius**2)           # m/s^2",
        "  time: sqrt(2 * length / fall)          # until the load has fallen by the length",
        "simulation:",
        "  duration: time",
        "  tolerance: 1.0e-10",
        "  integrator: dop853",
        "  output_step: time / 100",
        "bodies:",
        "  drum: {mass: drum, shape: {cylinder: {radius: radius, length: 4 * radius, axis: y}}, position: [0, 0, 0]}",
        "  load: {mass: mass, shape: {box: [2*radius, 2*radius, 2*radius]}, position: [radius, 0, -length/2]}",
        "joints:",
        "  axle: {type: revolute, bodies: [ground, drum], location: [0, 0, 0], axis: [0, 1, 0]}",
        "  guide: {type: prismatic, bodies: [ground, load], location: [radius, 0, -length/2], axis: [0, 0, 1]}",
        "  rope: {type: coupler, of: {axle.angle: radius, guide.displacement: 1}}",
        "markers:",
        "  hook: {body: load, location: {load: [0, 0, radius]}}",
        "expect:",
        "  falls: {joint: guide, quantity: displacement, at: end, value: -length, relative: 1.0e-9, source: m a = F}",
        "  turns: {joint: axle, quantity: angle, at: end, value: length / radius, relative: 1.0e-9, source: no slip}",
        "  pull: {joint: rope, quantity: reaction_force, component: z, at: end, relative: 1.0e-8,",
        "         value: mass * (g - fall), source: what is left of the weight}",
        "  energy: {diagnostic: energy_drift_relative, at: maximum, below: 1.0e-9, source: energy}",
        "  closed: {diagnostic: position_violation, at: maximum, below: 1.0e-13, source: joints are closed}",
    )
