"""Driven linkages against closed forms: cams, a quick return, Jansen's leg, a six-bar press, parallel robots."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from mbproj import assemble, compile_system, initial_guess, read_scene_text, settings_to_run, simulate
from mbproj.results.analysis.loads import loads_of
from mbproj.results.reader import open_results
from mbproj.results.writer import ResultsWriter
from tests.crossed import once
from tests.mechanisms.running import TIGHT, Run, assert_close
from tests.mechanisms.running import run as run_mechanism
from tests.support import Recorder

# Planar linkages in the x-z plane whose joints close by circles: points in closed form, and scenes.

#: Samples in a turn.
SAMPLES = 720


def crossing(p, q, from_p, from_q, side):
    """Where circles about points p and q (complex) cross: to the left of p → q for side 1, to the right for -1."""
    way = q - p
    distance = np.abs(way)
    along = (distance**2 + from_p**2 - from_q**2) / (2.0 * distance)
    return p + way / distance * (along + 1j * side * np.sqrt(from_p**2 - along**2))


def derivatives(values):
    """First and second derivatives by the angle of a function at equal steps of a turn, by its Fourier series."""
    order = np.fft.fftfreq(len(values), 1.0 / len(values))
    order[np.abs(order) == len(values) / 2] = 0.0
    series = np.fft.fft(values)
    first, second = np.fft.ifft(1j * order * series), np.fft.ifft(-(order**2) * series)
    return (first, second) if np.iscomplexobj(values) else (first.real, second.real)


def place(z: complex) -> str:
    """A point as a scene has it."""
    return f"[{float(z.real)!r}, 0, {float(z.imag)!r}]"


def pin(bodies: str, at: complex) -> str:
    """A revolute joint whose angle grows as that of the plane does."""
    return f"{{type: revolute, bodies: [{bodies}], location: {place(at)}, axis: [0, -1, 0]}}"


def block(name: str, entries: Mapping[str, str]) -> str:
    """A block of a scene."""
    return f"{name}:\n" + "".join(f"  {key}: {text}\n" for key, text in entries.items())


def run(text: str, **options):
    """(the system, what was recorded, the report) of a scene's text with these settings."""
    scene = read_scene_text(text, simulation=options)
    system, recorder = compile_system(scene), Recorder()
    report = simulate(system, assemble(system, initial_guess(scene, system)), settings_to_run(scene), recorder)
    assert report.kinematic
    return system, recorder, report


# The driving torque of a six-bar press against virtual work, with positions from circles that cross.

O2, O4 = 0.0 + 0.0j, 0.45 + 0.12j
CRANK, COUPLER, ROCKER, ROD, HEIGHT = 0.11, 0.42, 0.3, 0.5, 0.55
#: The rocker is a bell crank: its other arm, seen from O4, is that to B turned by a right angle and shortened.
ARM = 0.8 * np.exp(-0.5j * np.pi)
SPEED, GRAVITY, LOAD = 2.0 * np.pi, 9.81, 75.0
#: Of each body its mass, kg, and its moment of inertia about its centre, kg m².
MASSES = {
    "crank": (1.2, 2e-3),
    "coupler": (1.5, 2.4e-2),
    "rocker": (2.5, 3.1e-2),
    "rod": (1.1, 2.5e-2),
    "ram": (6.0, 0.05),
}


def pins(theta):
    """A, B, C, D at angles of the crank."""
    A = O2 + CRANK * np.exp(1j * theta)
    B = crossing(A, O4, COUPLER, ROCKER, 1)
    C = O4 + ARM * (B - O4)
    D = C.real + np.sqrt(ROD**2 - (HEIGHT - C.imag) ** 2) + 1j * HEIGHT
    return A, B, C, D


def poses(theta):
    """Of each body its centre and its angle, without turns."""
    A, B, C, D = pins(theta)
    turned = [np.angle(end - start) for start, end in ((O2, A), (A, B), (O4, B), (C, D))]
    centres = (0.5 * (O2 + A), 0.5 * (A + B), (O4 + B + C) / 3.0, 0.5 * (C + D), D)
    return dict(zip(MASSES, zip(centres, [*turned, 0.0 * theta], strict=True), strict=True))


def press():
    A, B, C, D = (complex(each) for each in pins(np.array(0.0)))
    of = {name: complex(centre) for name, (centre, _) in poses(np.array(0.0)).items()}
    bodies = {
        name: f"{{mass: {mass}, inertia: [{inertia}, {inertia}, {inertia}], position: {place(of[name])}}}"
        for name, (mass, inertia) in MASSES.items()
    }
    joints = {
        "main": pin("ground, crank", O2),
        "A": pin("crank, coupler", A),
        "B": pin("coupler, rocker", B),
        "O4": pin("ground, rocker", O4),
        "C": pin("rocker, rod", C),
        "D": pin("rod, ram", D),
        "guide": f"{{type: prismatic, bodies: [ground, ram], location: {place(D)}, axis: [1, 0, 0]}}",
    }
    head = f"mbproj: 1\ngravity: [0, 0, {-GRAVITY}]\n"
    head += f"simulation: {{duration: 1 s, output_step: {1.0 / SAMPLES!r}, kinematic: true}}\n"
    rest = f"motions: {{drive: {{joint: main, angle: {{expression: '{SPEED!r}*t'}}}}}}\n"
    rest += f"forces: {{work: {{type: force, body: ram, force: [{-LOAD}, 0, 0]}}}}\n"
    return head + block("bodies", bodies) + block("joints", joints) + rest


def torque():
    """T dθ = d(kinetic) + d(weights) + F ds at constant speed, at equal steps of a turn."""
    theta = np.arange(SAMPLES) * 2.0 * np.pi / SAMPLES
    found = LOAD * derivatives(pins(theta)[3].real)[0]
    for name, (centre, angle) in poses(theta).items():
        (mass, inertia), turns = MASSES[name], np.unwrap(angle)
        (first, second), (turn, bend) = derivatives(centre), derivatives(turns - (theta if name == "crank" else 0.0))
        found += mass * (SPEED**2 * (first.conjugate() * second).real + GRAVITY * first.imag)
        found += inertia * SPEED**2 * (turn + (name == "crank")) * bend
    return found


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_the_driving_torque_is_that_of_virtual_work(formulation):
    pytest.importorskip("mbproj.kernel._core")
    system, recorder, report = run(press(), formulation=formulation)
    expected = torque()
    np.testing.assert_allclose(
        recorder["motions/force"][:SAMPLES, 0], expected, rtol=0.0, atol=1e-9 * np.abs(expected).max()
    )
    D = pins(np.arange(SAMPLES) * 2.0 * np.pi / SAMPLES)[3]
    ram = recorder["bodies/position"][:SAMPLES, system.names.bodies.index("ram")]
    np.testing.assert_allclose(ram[:, 0], D.real, rtol=0.0, atol=1e-12)
    assert report.energy_drift_relative < 1e-10


@pytest.mark.full
def test_its_peaks_are_those_of_a_run_with_a_hundred_times_the_samples(tmp_path):
    found = []
    for samples in (120, 12_000):
        text = press().replace(f"output_step: {1.0 / SAMPLES!r}", f"output_step: {1.0 / samples!r}")
        system, recorder, _ = run(text)
        path = tmp_path / f"{samples}.h5"
        with ResultsWriter(path, read_scene_text(text), system.names.as_mapping()) as writer:
            for each in recorder.blocks:
                writer.write(each)
        with open_results(path) as results:
            found.append({load[:3]: load for load in loads_of(results)})
    few, many = found
    assert len(few) > 12
    for key, load in few.items():
        apart, size = abs(abs(load.largest) - abs(many[key].largest)), abs(many[key].largest)
        assert apart <= load.uncertainty + many[key].uncertainty + 1e-9 * size + 1e-12, key
        assert load.uncertainty <= 1e-3 * size + 1e-12, key
    drive = few["motion", "drive", "force"]
    assert abs(drive.largest) == pytest.approx(np.abs(torque()).max(), rel=1e-4)


# The torque of a cam: that of virtual work, F ds/dθ, with the law of the cam as a function and as a table.

LIFT, MASS, STIFFNESS, PRELOAD, GRAVITY_ON_CAM, CAM_SPEED = 0.02, 0.8, 4000.0, 60.0, 9.81, 4.0 * np.pi
ROWS = np.array([0.0, 40.0, 80.0, 130.0, 180.0, 235.0, 300.0, 360.0])
HEIGHTS = np.array([0.0, 3.0, 14.0, 20.0, 17.0, 8.0, 1.5, 0.0])


def cam(law: str) -> str:
    bodies = {
        "cam": "{mass: 2, inertia: [0.01, 0.01, 0.01], position: [0, 0, 0]}",
        "follower": f"{{mass: {MASS}, inertia: [0.01, 0.01, 0.01], position: [0, 0, 0.1]}}",
    }
    joints = {
        "shaft": "{type: revolute, bodies: [ground, cam], location: [0, 0, 0], axis: [0, 1, 0]}",
        "guide": "{type: prismatic, bodies: [ground, follower], location: [0, 0, 0.1], axis: [0, 0, 1]}",
        "lift": f"{{type: coupler, of: {{shaft: 0, guide: 1}}, function: {law}}}",
    }
    forces = {
        "spring": f"{{type: linear_spring_damper, joint: guide, stiffness: {STIFFNESS}, "
        f"free_displacement: {-PRELOAD / STIFFNESS!r}}}"
    }
    head = f"mbproj: 1\ngravity: [0, 0, {-GRAVITY_ON_CAM}]\n"
    head += "simulation: {duration: 1 s, output_step: 1 ms, kinematic: true}\n"
    motion = f"motions: {{drive: {{joint: shaft, angle: {{constant_speed: {CAM_SPEED!r}}}}}}}\n"
    return head + block("bodies", bodies) + block("joints", joints) + block("forces", forces) + motion


def of_expression(angle):
    """s, ds/dθ, d²s/dθ² of a follower that rises and falls twice a turn."""
    return (
        0.5 * LIFT * (1.0 - np.cos(2.0 * angle)) ** 2,
        2.0 * LIFT * (1.0 - np.cos(2.0 * angle)) * np.sin(2.0 * angle),
        4.0 * LIFT * (np.sin(2.0 * angle) ** 2 + (1.0 - np.cos(2.0 * angle)) * np.cos(2.0 * angle)),
    )


def of_table(angle):
    spline = CubicSpline(np.radians(ROWS), HEIGHTS / 1000.0, bc_type="periodic")
    return tuple(spline(np.remainder(angle, 2.0 * np.pi), order) for order in range(3))


TABLE = ", ".join(f"[{angle} deg, {height} mm]" for angle, height in zip(ROWS, HEIGHTS, strict=True))
LAWS = {
    "expression": (f"'{0.5 * LIFT} * (1 - cos(2*s))**2'", of_expression),
    "table": (f"{{rows: [{TABLE}], between: periodic}}", of_table),
}


@pytest.mark.parametrize(("law", "formulation"), once([*LAWS], ["planar", "reduced"]))
def test_the_torque_of_a_cam_is_its_force_times_the_slope_of_its_law(law, formulation):
    pytest.importorskip("mbproj.kernel._core")
    text, exact = LAWS[law]
    _, recorder, report = run(cam(text), formulation=formulation)
    angle = CAM_SPEED * recorder["time"]
    s, slope, bend = exact(angle)
    np.testing.assert_allclose(recorder["joints/coordinate"][:, 1], s, rtol=0.0, atol=1e-12)
    force = MASS * (CAM_SPEED**2 * bend + GRAVITY_ON_CAM) + STIFFNESS * s + PRELOAD
    expected = force * slope
    np.testing.assert_allclose(recorder["motions/force"][:, 0], expected, rtol=0.0, atol=1e-9 * np.abs(expected).max())
    # The cam lifts the follower by that force, and takes it from the follower's guide.
    np.testing.assert_allclose(
        recorder["joints/reaction_force"][:, 2, 2], force, rtol=0.0, atol=1e-9 * np.abs(force).max()
    )
    assert report.energy_drift_relative < 1e-8


# The leg of Jansen's walking machine: the path of its foot from circles that cross.

#: T. Jansen's "holy numbers", in his units, cm say: a to m.
a, b, c, d, e, f, g, h, i, j, k, l, m = (38, 41.5, 39.3, 40.1, 55.8, 39.4, 36.7, 65.7, 49, 50, 61.9, 7.8, 15)
MAIN, HIP = 0.0 + 0.0j, -a - l * 1j


def leg(theta):
    """Pins of the left leg at angles of the crank: that of the crank, those of the thigh's other corners, of the knee,
    of the shank's other corner, and the foot."""
    crank = MAIN + m * np.exp(1j * theta)
    top = crossing(crank, HIP, j, b, -1)
    knee = crossing(crank, HIP, k, c, 1)
    outer = crossing(top, HIP, e, d, -1)
    ankle = crossing(outer, knee, f, g, -1)
    return crank, top, outer, knee, ankle, crossing(ankle, knee, h, i, -1)


def jansen(theta):
    crank, top, outer, knee, ankle, foot = (complex(each) for each in leg(np.array(theta)))

    def body(*corners):
        return f"{{mass: 1, inertia: [1, 1, 1], position: {place(sum(corners) / len(corners))}}}"

    bodies = {
        "crank": body(MAIN, crank),
        "upper": body(crank, top),
        "lower": body(crank, knee),
        "thigh": body(top, HIP, outer),
        "shank": body(ankle, knee, foot),
        "front": body(HIP, knee),
        "back": body(outer, ankle),
    }
    joints = {
        "main": pin("ground, crank", MAIN),
        "J": pin("crank, upper", crank),
        "K": pin("crank, lower", crank),
        "top": pin("upper, thigh", top),
        "hip": pin("ground, thigh", HIP),
        "hip2": pin("ground, front", HIP),
        "knee": pin("lower, front", knee),
        "knee2": pin("front, shank", knee),
        "outer": pin("thigh, back", outer),
        "ankle": pin("back, shank", ankle),
    }
    head = "mbproj: 1\ngravity: [0, 0, 0]\nsimulation: {duration: 2 s, output_step: 5 ms, kinematic: true}\n"
    motion = "motions: {drive: {joint: main, angle: {constant_speed: 60 rpm}}}\n"
    marker = f"markers: {{foot: {{body: shank, location: {place(foot)}}}}}\n"
    return head + block("bodies", bodies) + block("joints", joints) + motion + marker


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_the_foot_goes_where_the_circles_cross(formulation):
    pytest.importorskip("mbproj.kernel._core")
    start = 0.3
    _, recorder, _ = run(jansen(start), formulation=formulation)
    theta = start + 2.0 * np.pi * recorder["time"]
    expected = leg(theta)[-1]
    found = recorder["markers/position"][:, 0]
    np.testing.assert_allclose(found[:, 0] + 1j * found[:, 2], expected, rtol=0.0, atol=1e-11)


def test_its_foot_is_level_for_a_third_of_a_turn():
    _, recorder, _ = run(jansen(0.3), duration="1 s", output_step="1 ms")
    along, height = recorder["markers/position"][:, 0, 0], recorder["markers/position"][:, 0, 2]
    low = height < height.min() + 0.01 * c
    assert np.ptp(along[low]) > 0.6 * np.ptp(along)
    assert low.mean() > 1.0 / 3.0


# Quick-return mechanisms: the ratio of the times of both strokes in closed form.

PERIOD = 1.0


def quick_return(crank: float, offset: float) -> str:
    """A crank of this length about (0, offset) whose pin slides in the slot of a lever about the origin."""
    bodies = {
        "crank": f"{{mass: 1, inertia: [1e-3, 1e-3, 1e-3], position: [{0.5 * crank}, 0, {offset}]}}",
        "lever": f"{{mass: 2, inertia: [0.04, 0.04, 0.04], position: [{0.5 * crank}, 0, {0.5 * offset}]}}",
    }
    joints = {
        "pivot": "{type: revolute, bodies: [ground, lever], location: [0, 0, 0], axis: [0, -1, 0]}",
        "main": f"{{type: revolute, bodies: [ground, crank], location: [0, 0, {offset}], axis: [0, -1, 0]}}",
        "slot": f"{{type: point_on_line, bodies: [lever, crank], location: [{crank}, 0, {offset}], "
        f"axis: [{crank}, 0, {offset}]}}",
    }
    head = "mbproj: 1\ngravity: [0, 0, -9.81]\nsimulation: {duration: 2 s, output_step: 1 ms, kinematic: true}\n"
    motion = f"motions: {{drive: {{joint: main, angle: {{constant_speed: {2.0 * np.pi / PERIOD!r}}}}}}}\n"
    return head + block("bodies", bodies) + block("joints", joints) + motion


def turns(time, values):
    """When a smooth curve crosses zero: on the polynomial through six samples around each change of its sign."""
    found = []
    for k in np.flatnonzero(np.sign(values[2:-4]) * np.sign(values[3:-3]) < 0) + 2:
        near = slice(k - 2, k + 4)
        x, lagrange = values[near], 0.0
        for i in range(6):  # t as a polynomial of the value, at 0
            others = np.delete(x, i)
            lagrange += time[near][i] * np.prod(others / (others - x[i]))
        found.append(lagrange)
    return np.array(found)


@pytest.mark.parametrize(("crank", "offset"), [(0.1, 0.2), (0.06, 0.25)])
def test_a_crank_shaper_cuts_slowly_and_returns_fast(crank, offset):
    """The lever turns back where it is across the crank: (π + 2 α) / (π - 2 α) with sin α = r/d."""
    _, recorder, _ = run(quick_return(crank, offset))
    times = turns(recorder["time"], recorder["joints/speed"][:, 0])
    assert len(times) == 4
    strokes = np.diff(times)
    alpha = np.arcsin(crank / offset)
    expected = (np.pi + 2.0 * alpha) / (np.pi - 2.0 * alpha)
    assert max(strokes[0], strokes[1]) / min(strokes[0], strokes[1]) == pytest.approx(expected, rel=1e-9)
    assert strokes[0] + strokes[1] == pytest.approx(PERIOD, abs=1e-10)
    lever = recorder["joints/coordinate"][:, 0]
    assert np.ptp(lever) == pytest.approx(2.0 * alpha, abs=1e-5)


@pytest.mark.parametrize(("crank", "offset"), [(0.2, 0.08), (0.1, 0.06)])
def test_a_whitworth_lever_turns_right_round_with_unequal_halves(crank, offset):
    """The lever is level where the crank's pin is at its pivot's height: 2 (π - φ) and 2 φ with cos φ = d/r."""
    _, recorder, _ = run(quick_return(crank, offset))
    start = np.arctan2(offset, crank)  # of the lever, from level
    half = np.unwrap(recorder["joints/coordinate"][:, 0]) + start
    times = turns(recorder["time"], np.sin(half))
    strokes = np.diff(times[:3])
    phi = np.arccos(offset / crank)
    assert max(strokes) / min(strokes) == pytest.approx((np.pi - phi) / phi, rel=1e-9)
    assert np.ptp(half) == pytest.approx(4.0 * np.pi, abs=1e-9)


# Stewart platform and Delta robot against their inverse kinematics, which is explicit.


@pytest.fixture(scope="module")
def stewart() -> Run:
    return run_mechanism("stewart_platform", **TIGHT, duration=0.4, output_step=0.02)


@pytest.fixture(scope="module")
def delta() -> Run:
    return run_mechanism("delta_robot", **TIGHT, duration=0.4, output_step=0.02)


def legs(done: Run) -> tuple[np.ndarray, np.ndarray]:
    """Vectors (T, 6, 3) along the legs, and the velocities of their upper ends, from the platform's motion alone."""
    known = done.parameters
    base, top = (
        np.array([[known[radius] * f(known[f"{letter}{k}"]) for f in (np.cos, np.sin)] + [0.0] for k in range(1, 7)])
        for radius, letter in (("base", "b"), ("platform", "p"))
    )
    rotation = done.rotation("platform")
    arm = np.einsum("tij,kj->tki", rotation, top)
    ω = np.einsum("tij,tj->ti", rotation, done.column("bodies/angular_velocity", "platform"))
    velocity = done.column("bodies/velocity", "platform")[:, None] + np.cross(ω[:, None], arm)
    return done.column("bodies/position", "platform")[:, None] + arm - base, velocity


def test_legs_have_the_lengths_that_the_pose_of_the_platform_needs(stewart):
    vectors, velocity = legs(stewart)
    length = np.linalg.norm(vectors, axis=-1)
    displacement = np.stack([stewart.column("joints/coordinate", f"P{k}.displacement") for k in range(1, 7)], axis=-1)
    assert np.ptp(displacement, axis=0).min() > 0.05
    assert_close(displacement, length - stewart.parameters["length"], 5e-13)
    speed = np.stack([stewart.column("joints/speed", f"P{k}.displacement") for k in range(1, 7)], axis=-1)
    assert_close(speed, np.sum(vectors * velocity, axis=-1) / length, 1e-12)


def test_legs_start_at_the_speeds_that_the_scene_asks_for(stewart):
    for joint in stewart.scene.joints:
        for coordinate, speed in joint.speed.items():
            assert stewart.column("joints/speed", f"{joint.name}.{coordinate}")[0] == pytest.approx(speed, abs=1e-13)


def arm_angles(done: Run) -> np.ndarray:
    """θ (T, 3) below the horizontal from the platform's position: X cos θ - z sin θ = (X² + y² + z² + L² - l²)/(2L)."""
    known, position = done.parameters, done["markers/position"][:, 0]
    angles = []
    for azimuth in (known["s1"], known["s2"], known["s3"]):
        X = position[:, 0] * np.cos(azimuth) + position[:, 1] * np.sin(azimuth) + known["platform"] - known["base"]
        y = position[:, 1] * np.cos(azimuth) - position[:, 0] * np.sin(azimuth)
        z = position[:, 2]
        k = (X**2 + y**2 + z**2 + known["arm"] ** 2 - known["rod"] ** 2) / (2.0 * known["arm"])
        angles.append(np.arctan2(-z, X) - np.arccos(k / np.hypot(X, z)))
    return np.stack(angles, axis=-1)


def test_arms_have_the_angles_that_the_position_of_the_platform_needs(delta):
    turned = np.stack([delta.column("joints/coordinate", f"A{k}.angle") for k in (1, 2, 3)], axis=-1)
    assert np.ptp(turned, axis=0).min() > 0.1
    assert_close(delta.parameters["start"] + turned, arm_angles(delta), 2e-12)


def test_platform_of_the_delta_robot_never_turns(delta):
    rotation = delta.rotation("platform")
    assert_close(rotation, np.eye(3), 1e-13)
    assert_close(delta.column("bodies/angular_velocity", "platform"), 0.0, 1e-12)


def test_parallel_rods_stay_parallel(delta):
    for k in (1, 2, 3):
        left, right = (delta.rotation(f"rod{k}{side}")[..., 0] for side in "lr")
        assert_close(left, right, 1e-13)


def test_energy_is_conserved(stewart, delta):
    for done in (stewart, delta):
        assert done.report.energy_drift_relative < 1e-11
