"""Four-bars, Hooke's joint, the governor and a Geneva drive against closed forms and Lagrange's equations."""

from __future__ import annotations

from math import cos, sin, sqrt

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.linalg import eig
from scipy.optimize import brentq, fsolve

from mbproj import InputError, read_scene_text
from mbproj.base.mechanisms_folder import mechanism
from mbproj.equations.assembly.assemble import coordinate_values
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.kinematics import pose_of
from mbproj.equations.motions import NO_DRIVE
from mbproj.equations.rank.row_space import NO_CONDITIONS
from mbproj.functions.standard import Curve
from mbproj.joints.table import geneva
from mbproj.linear.equilibrium.balance import EquilibriumProblem
from mbproj.linear.equilibrium.find import equilibrium
from mbproj.linear.equilibrium.start import assembled_start
from mbproj.linear.equilibrium.steady import steady_turn
from mbproj.linear.modes import modes
from tests.kernel.scenes import needs_kernel
from tests.mechanisms.closed_forms import (
    energy,
    expected,
    planar_energy,
    ratio,
    scene,
    spatial_energy,
    spatial_pose,
    time_to_reach,
)
from tests.mechanisms.running import TIGHT, Run, assert_close, global_angular_velocity, run

# The planar and the spatial four-bar: closed-form transmission, and the exact motion from energy.


@pytest.fixture(scope="module")
def planar() -> Run:
    return run("planar_four_bar", **TIGHT, duration=1.0, output_step=0.05)


@pytest.fixture(scope="module")
def spatial() -> Run:
    return run("spatial_four_bar", **TIGHT, duration=1.0, output_step=0.05)


def test_crank_goes_round_and_rocker_does_not(planar, spatial):
    for done in (planar, spatial):
        assert np.ptp(done.column("joints/coordinate", "A.angle")) > 2 * np.pi
        assert np.ptp(done.column("joints/coordinate", "D.angle")) < np.pi


def freudenstein(done: Run):
    """k1, k2, k3 of k1 cos χ - k2 cos φ + k3 = cos(φ - χ)."""
    a, b, c, d = (done.parameters[name] for name in ("crank", "coupler", "rocker", "frame"))
    return d / a, d / c, (a * a - b * b + c * c + d * d) / (2 * a * c)


def test_freudensteins_equation_and_its_derivative(planar):
    k1, k2, k3 = freudenstein(planar)
    φ = planar.parameters["start"] + planar.column("joints/coordinate", "A.angle")
    χ = planar.parameters["swing"] + planar.column("joints/coordinate", "D.angle")
    assert_close(k1 * np.cos(χ) - k2 * np.cos(φ) + k3, np.cos(φ - χ), 1e-12)
    φ_dot, χ_dot = (planar.column("joints/speed", name) for name in ("A.angle", "D.angle"))
    left = -k1 * np.sin(χ) * χ_dot + k2 * np.sin(φ) * φ_dot
    assert_close(left, -np.sin(φ - χ) * (φ_dot - χ_dot), 1e-11)


def test_planar_four_bar_stays_in_its_plane(planar):
    assert_close(planar["bodies/position"][..., 1], 0.0, 1e-13)
    assert_close(planar["bodies/angular_velocity"][..., [0, 2]], 0.0, 1e-12)


def test_planar_four_bar_moves_as_its_energy_demands(planar):
    """The time at which the crank has each recorded angle, by quadrature of the energy equation."""
    start, speed = planar.parameters["start"], planar.parameters["speed"]
    φ = start + planar.column("joints/coordinate", "A.angle")[1::4]
    times = [time_to_reach(angle, start, speed, *planar_energy(planar)) for angle in φ]
    assert_close(times, planar["time"][1::4], 1e-12)


def test_spatial_four_bar_transmits_in_closed_form(spatial):
    φ = spatial.column("joints/coordinate", "A.angle")
    χ = spatial.parameters["swing"] + spatial.column("joints/coordinate", "D.angle")
    exact = [spatial_pose(spatial, angle) for angle in φ]
    assert_close(χ, [pose[0] for pose in exact], 2e-12)
    rates = spatial.column("joints/speed", "A.angle") * [pose[-1] for pose in exact]
    assert_close(spatial.column("joints/speed", "D.angle"), rates, 1e-11)


def test_idle_spin_of_the_rod_is_conserved(spatial):
    """No moment acts about the axis of a rod with equal moments across it that hangs in two balls."""
    spin = spatial.column("bodies/angular_velocity", "rod")[:, 0]
    assert_close(spin, 30.0, 5e-10)


def test_spatial_four_bar_moves_as_its_energy_demands(spatial):
    φ = spatial.column("joints/coordinate", "A.angle")[1::4]
    times = [time_to_reach(angle, 0.0, spatial.parameters["speed"], *spatial_energy(spatial)) for angle in φ]
    assert_close(times, spatial["time"][1::4], 1e-12)


def test_rod_turns_as_its_ends_and_its_spin_say(spatial):
    """ω = n × n' + s n in global axes, with n along the rod."""
    poses = [spatial_pose(spatial, angle) for angle in spatial.column("joints/coordinate", "A.angle")]
    speed = spatial.column("joints/speed", "A.angle")
    n = np.array([C - B for _, B, C, *_ in poses]) / spatial.parameters["coupler"]
    n_dot = np.array([C_dot - B_dot for *_, B_dot, C_dot, _ in poses]) * speed[:, None] / spatial.parameters["coupler"]
    assert_close(global_angular_velocity(spatial, "rod"), np.cross(n, n_dot) + 30.0 * n, 5e-10)


# The four-bar with a split coupler against Lagrange's equations in its four angles, integrated by SciPy.

SCENE = scene("split_coupler")
FOUR_BAR = SCENE.parameters
#: Of crank, near half, far half and rocker: mass, and moment of inertia about the y axis.
MASS = np.array([body.mass for body in SCENE.bodies])
INERTIA = np.array([body.inertia[1][1] for body in SCENE.bodies])
#: Way from the ground to each centre of mass, as factors of e^iθ of the four angles; then the gap between the halves.
LENGTHS = np.array(
    [
        [FOUR_BAR["crank"] / 2, 0.0, 0.0, 0.0],
        [FOUR_BAR["crank"], FOUR_BAR["coupler"] / 4, 0.0, 0.0],
        [0.0, 0.0, -FOUR_BAR["coupler"] / 4, FOUR_BAR["rocker"]],
        [0.0, 0.0, 0.0, FOUR_BAR["rocker"] / 2],
    ]
)
GAP = np.array([-FOUR_BAR["crank"], -FOUR_BAR["coupler"] / 2, -FOUR_BAR["coupler"] / 2, FOUR_BAR["rocker"]])
BENT = np.array([0.0, -1.0, 1.0, 0.0])
SHARE = np.array([0.0, 0.5, 0.5, 0.0])
KX, KZ, KR = FOUR_BAR["along"], FOUR_BAR["transverse"], FOUR_BAR["bending"]
CX, CZ, CR = 20.0, 10.0, 0.02


def gap(θ: np.ndarray) -> tuple[complex, np.ndarray]:
    """The gap y = x + i z seen from midway between the halves, and ∂y/∂θ."""
    midway = np.exp(-1j * (SHARE @ θ))
    y = midway * (FOUR_BAR["frame"] + GAP @ np.exp(1j * θ))
    return y, midway * 1j * GAP * np.exp(1j * θ) - 1j * SHARE * y


def mass(θ: np.ndarray) -> np.ndarray:
    along = LENGTHS * np.exp(1j * θ)
    return np.einsum("b,bk,bl->kl", MASS, along.conj(), along).real + np.diag(INERTIA)


def split_coupler_lagrange(_: float, state: np.ndarray) -> np.ndarray:
    """θ'' from M θ'' = Q, and what the rubber loses, 2 R."""
    θ, rate = state[:4], state[4:8]
    along = 1j * LENGTHS * np.exp(1j * θ)  # ∂r/∂θ of each body
    bias = -(LENGTHS * np.exp(1j * θ)) @ rate**2
    y, y_θ = gap(θ)
    y_dot, bent, bent_dot = y_θ @ rate, BENT @ θ, BENT @ rate
    force = KX * y.real + CX * y_dot.real - 1j * (KZ * y.imag + CZ * y_dot.imag)
    Q = -(force * y_θ).real - BENT * (KR * bent + CR * bent_dot)
    Q -= ((MASS * bias.conj()) @ along).real + 9.81 * MASS @ along.imag
    loss = CX * y_dot.real**2 + CZ * y_dot.imag**2 + CR * bent_dot**2
    return np.concatenate([rate, np.linalg.solve(mass(θ), Q), [loss]])


@pytest.mark.full
def test_the_split_coupler_by_lagranges_equations():
    tilt = FOUR_BAR["tilt"]
    start = np.array([FOUR_BAR["start"], tilt, tilt, FOUR_BAR["swing"]])
    state = np.array(
        [*start, *(FOUR_BAR[name] for name in ("speed", "coupler_speed", "coupler_speed", "rocker_speed")), 0.0]
    )
    times = np.arange(201) * 0.005
    done = solve_ivp(
        split_coupler_lagrange, (0.0, times[-1]), state, method="DOP853", rtol=1e-9, atol=1e-12, t_eval=times
    )
    θ = done.y[:4]
    assert_close(expected("split_coupler", "crank"), θ[0, -1] - start[0], 1e-8)
    assert_close(expected("split_coupler", "rocker"), θ[3, -1] - start[3], 1e-8)
    assert_close(expected("split_coupler", "lost"), done.y[8, -1], 1e-9)
    assert_close(expected("split_coupler", "gap"), np.abs([gap(each)[0] for each in θ.T]).max(), 1e-9)
    assert_close(expected("split_coupler", "bent"), np.abs(BENT @ θ).max(), 1e-8)


def pull(θ: np.ndarray) -> np.ndarray:
    """∂V/∂θ."""
    y, y_θ = gap(θ)
    along = 1j * LENGTHS * np.exp(1j * θ)
    return ((KX * y.real - 1j * KZ * y.imag) * y_θ).real + BENT * KR * (BENT @ θ) + 9.81 * MASS @ along.imag


def test_it_rests_and_rings_as_its_four_angles_say():
    """The modes by differences of the forces, extrapolated, with the rubber's damping."""
    start = np.array([FOUR_BAR["start"], FOUR_BAR["tilt"], FOUR_BAR["tilt"], FOUR_BAR["swing"]])
    system = compile_system(SCENE)
    found = equilibrium(system, assembled_start(SCENE, system))
    coordinates = dict(zip(system.names.coordinates, found.reference.motion.expected, strict=True))
    turned = coordinates["A.angle"], coordinates["D.angle"]
    crank, near = start[0] + turned[0], start[1] + turned[0] + coordinates["B.angle"]
    far = start[1] + turned[1] - coordinates["C.angle"]
    θ = fsolve(pull, [crank, near, far, start[3] + turned[1]], xtol=1e-12)
    assert_close(np.array([crank, near, far, start[3] + turned[1]]), θ, 1e-9)
    assert found.stable
    h = 1e-3 * np.eye(4)
    differences = [np.array([pull(θ + k * e) - pull(θ - k * e) for e in h]) / (2e-3 * k) for k in (1, 2, 3)]
    K = 1.5 * differences[0] - 0.6 * differences[1] + 0.1 * differences[2]
    y_θ = gap(θ)[1]
    D = CX * np.outer(y_θ.real, y_θ.real) + CZ * np.outer(y_θ.imag, y_θ.imag) + CR * np.outer(BENT, BENT)
    one, none = np.eye(4), np.zeros((4, 4))
    λ = eig(np.block([[none, one], [-K, -D]]), np.block([[one, none], [none, mass(θ)]]), right=False)
    λ = λ[λ.imag > 0]
    np.testing.assert_allclose(modes(found.reference).eigenvalues, λ[np.argsort(np.abs(λ))], rtol=1e-8)


def test_steps_to_where_the_rubber_has_no_direction_are_not_taken():
    """Its frames would stand half a turn apart: other equilibria are sought from elsewhere."""
    system = compile_system(SCENE)
    start = assembled_start(SCENE, system)
    problem = EquilibriumProblem.of(system, 0.0, start.q, NO_DRIVE, NO_CONDITIONS, start.x)
    here = problem.at(start.q, coordinate_values(system, pose_of(start.q)))
    turns = here.space.N.reshape(system.bodies, 6, -1)[:, 4]
    far = np.linalg.lstsq(turns, np.array([0.0, 3.13, 0.0, 0.0]), rcond=None)[0]
    assert None in [here.after(part * far) for part in np.linspace(0.7, 1.3, 61)]
    assert here.after(0.1 * far) is not None


# Two shafts with Hooke's joint: the transmission, and the exact motion from energy.


@pytest.fixture(scope="module")
def shafts() -> Run:
    """A light flywheel, so that the driving shaft does not turn evenly."""
    return run("hooke_shaft", {"flywheel": "0.02"}, **TIGHT, duration=1.0, output_step=0.02)


def axis(done: Run) -> np.ndarray:
    """Along the driven shaft."""
    return np.array([np.cos(done.parameters["bend"]), np.sin(done.parameters["bend"]), 0.0])


def driven_angle(done: Run) -> np.ndarray:
    """φ2 (T,) within (-π, π]: how far the driven shaft has turned about its own line."""
    turned = done.rotation("driven") @ done.rotation("driven")[0].T
    return np.arctan2(turned[:, 2, :] @ np.cross(axis(done), [0.0, 0.0, 1.0]), turned[:, 2, 2]) * -1.0


def test_angles_obey_hookes_formula(shafts):
    φ1 = shafts.column("joints/coordinate", "bearing.angle")
    assert np.ptp(φ1) > 2 * np.pi
    exact = np.arctan2(np.sin(φ1), np.cos(φ1) * np.cos(shafts.parameters["bend"]))
    difference = driven_angle(shafts) - exact
    assert_close(np.sin(difference), 0.0, 5e-13)


def test_speeds_obey_hookes_formula(shafts):
    ω2 = global_angular_velocity(shafts, "driven") @ axis(shafts)
    φ1, ω1 = (shafts.column(f"joints/{what}", "bearing.angle") for what in ("coordinate", "speed"))
    assert_close(ω2, ω1 * ratio(shafts, φ1), 1e-11)


def test_cross_turns_in_the_driving_fork_as_spherical_trigonometry_says(shafts):
    """tan of its angle is tan β sin φ1: Napier's rule for the right triangle of the shafts and the fork's axis."""
    φ1, β = shafts.column("joints/coordinate", "bearing.angle"), shafts.parameters["bend"]
    about_first = shafts.column("joints/coordinate", "hooke.angle_1")
    assert_close(np.tan(about_first), np.tan(β) * np.sin(φ1), 2e-13)


def test_floating_bearing_stays(shafts):
    assert_close(shafts.column("joints/coordinate", "floating.displacement"), 0.0, 1e-13)


def test_shafts_turn_as_their_energy_demands(shafts):
    φ1 = shafts.column("joints/coordinate", "bearing.angle")[1::10]
    times = [time_to_reach(angle, 0.0, shafts.parameters["speed"], *energy(shafts)) for angle in φ1]
    assert_close(times, shafts["time"][1::10], 1e-12)


def test_a_flywheel_of_1e6_keeps_the_driving_shaft_even():
    """But for the energy of the driven shaft, which is 5e-9 of the whole."""
    done = run("hooke_shaft", {"flywheel": "1e6"}, **TIGHT, duration=0.7, output_step=0.02)
    assert_close(done.column("joints/coordinate", "bearing.angle"), 10.0 * done["time"], 1e-8)
    ω2 = global_angular_velocity(done, "driven") @ axis(done)
    assert_close(ω2, 10.0 * ratio(done, 10.0 * done["time"]), 1e-7)
    assert ω2.max() == pytest.approx(10.0 / np.cos(np.radians(30.0)), abs=0.02)


# The flyball governor against Lagrange's equation of its arms' angle: where it rests, turns, rings, and its run.

GOVERNOR = scene("governor").parameters
g = 9.81
m, M, J = GOVERNOR["ball"], GOVERNOR["collar"], GOVERNOR["ball"] * 2 / 5 * GOVERNOR["radius"] ** 2
l, a, e, k = GOVERNOR["arm"], GOVERNOR["link"], GOVERNOR["pin"], GOVERNOR["stiffness"]
s = 2 * a * cos(GOVERNOR["start"])
SPINDLE, COLLAR = 0.01, 2.0e-3


def spin_inertia(θ):
    return SPINDLE + COLLAR + 2 * (J + m * (e + l * sin(θ)) ** 2)


def governor_energy(θ):
    """Potential energy of balls, collar and spring."""
    return -2 * (m * l + M * a) * g * cos(θ) + 0.5 * k * (2 * a * cos(θ) - s) ** 2


def closed_form(θ):
    """The speed at which the arms stand at θ."""
    lifted = m * g * l + M * g * a + k * a * (s - 2 * a * cos(θ))
    return sqrt(sin(θ) * lifted / (m * l * (e + l * sin(θ)) * cos(θ)))


def swing_inertia(θ):
    return 2 * (m * l**2 + J) + M * (2 * a * sin(θ)) ** 2


def governor_lagrange(_, state):
    """θ'' where the angular momentum stays, and the power that the damper loses."""
    θ, rate = state[:2]
    Ω = spin_inertia(GOVERNOR["start"]) * GOVERNOR["speed"] / spin_inertia(θ)
    torque = 2 * m * (e + l * sin(θ)) * l * cos(θ) * Ω**2 - 2 * (m * l + M * a) * g * sin(θ)
    torque += k * (2 * a * cos(θ) - s) * 2 * a * sin(θ) - 4 * M * a**2 * sin(θ) * cos(θ) * rate**2
    drag = GOVERNOR["damping"] * (2 * a * sin(θ)) ** 2
    return [rate, (torque - drag * rate) / swing_inertia(θ), drag * rate**2]


def turning(speed):
    read = scene("governor")
    system = compile_system(read)
    start = assembled_start(read, system)
    turn, held = steady_turn(system, start, "spin.angle", speed)
    return equilibrium(system, start, 0.0, turn, held)


@pytest.mark.parametrize("degrees", [17.0, 30.0, 50.0, 75.0])
def test_the_arms_stand_where_the_formula_says(degrees):
    θ = np.radians(degrees)
    found = turning(closed_form(θ))
    coordinates = dict(
        zip(found.reference.system.names.coordinates, found.reference.motion.expected - GOVERNOR["start"], strict=True)
    )
    assert_close([coordinates["right.angle"], coordinates["left.angle"]], θ - 2 * GOVERNOR["start"], 1e-10)
    assert_close(found.drive, 0.0, 1e-10)
    assert found.stable


def test_at_speed_it_swings_against_its_spin():
    """A λ² + C λ + V'' - I'' Ω²/2 + (I' Ω)² / I = 0 where the angular momentum stays (Routh)."""
    θ = np.radians(50.0)
    Ω, I = closed_form(θ), spin_inertia(θ)
    I_1 = 4 * m * (e + l * sin(θ)) * l * cos(θ)
    I_2 = 4 * m * l * (l * cos(θ) ** 2 - (e + l * sin(θ)) * sin(θ))
    V_2 = 2 * (m * l + M * a) * g * cos(θ) + k * ((2 * a * sin(θ)) ** 2 - (2 * a * cos(θ) - s) * 2 * a * cos(θ))
    drag = GOVERNOR["damping"] * (2 * a * sin(θ)) ** 2
    λ = np.roots([swing_inertia(θ), drag, V_2 - 0.5 * I_2 * Ω**2 + (I_1 * Ω) ** 2 / I])
    np.testing.assert_allclose(modes(turning(Ω).reference).eigenvalues, [0.0, λ[λ.imag > 0][0]], rtol=1e-9)


def test_what_its_run_expects():
    L = spin_inertia(GOVERNOR["start"]) * GOVERNOR["speed"]
    θ = brentq(lambda θ: spin_inertia(θ) * closed_form(θ) - L, 0.3, 1.5, xtol=1e-15)
    before, after = (governor_energy(x) + 0.5 * L**2 / spin_inertia(x) for x in (GOVERNOR["start"], θ))
    assert_close(expected("governor", "opens"), θ - GOVERNOR["start"], 1e-10)
    assert_close(expected("governor", "together"), θ - GOVERNOR["start"], 1e-10)
    assert_close(expected("governor", "slows"), closed_form(θ), 1e-9)
    assert_close(expected("governor", "lost"), before - after, 1e-9)
    times = np.arange(601) * 0.01
    done = solve_ivp(
        governor_lagrange, (0, 6), [GOVERNOR["start"], 0, 0], method="DOP853", rtol=1e-10, atol=1e-12, t_eval=times
    )
    assert_close(done.y[0, -1], θ, 1e-6)
    assert_close(done.y[2, -1], before - after, 1e-8)
    assert_close(expected("governor", "swings"), done.y[0].max() - GOVERNOR["start"], 1e-9)


# A Geneva drive that nothing drives: its wheel by the closed form, its speed by the energy, its time by quadrature.

J1, J2, HELD = 2e-3, 0.5e-3, 10.0


def law(φ, slots):
    """f and f' of the pin in its slots, and of the disc."""
    k = np.sin(np.pi / slots)
    turns = np.round(φ / (2.0 * np.pi))
    φ = φ - 2.0 * np.pi * turns
    held = np.cos(φ) < k
    f = np.where(held, np.sign(φ) * np.pi / slots, np.arctan2(k * np.sin(φ), 1.0 - k * np.cos(φ)))
    slope = np.where(held, 0.0, k * (np.cos(φ) - k) / (1.0 - 2.0 * k * np.cos(φ) + k * k))
    return f + 2.0 * np.pi / slots * turns, slope


@pytest.mark.parametrize("slots", [3, 4, 8])
def test_the_function_is_that_of_a_pin_in_a_slot(slots):
    """With f' and, of 4, the numbers of the literature: f' = 2.414214 at the middle, f'' = 1 as it enters."""
    φ = np.linspace(-np.pi, np.pi, 20001)
    f, slope, bend = Curve(geneva(float(slots)).function)(φ)
    own, own_slope = law(φ, slots)
    np.testing.assert_allclose(-f[1:-1], own[1:-1], atol=1e-15)
    np.testing.assert_allclose(-slope, own_slope, atol=1e-14)
    if slots == 4:
        inside = np.abs(φ) < 0.25 * np.pi
        np.testing.assert_allclose(-slope.min(), 1.0 + np.sqrt(2.0), rtol=1e-12)
        np.testing.assert_allclose(np.abs(bend[inside]).max(), 5.406981, rtol=1e-6)
        np.testing.assert_allclose(-Curve(geneva(4.0).function)(np.array([-0.25 * np.pi + 1e-12]))[2], 1.0, rtol=1e-9)


@needs_kernel
@pytest.mark.parametrize("formulation", ["planar", "reduced"])
@pytest.mark.parametrize("slots", [4, 6])
def test_three_turns_keep_the_energy_and_the_closed_form(slots, formulation):
    how = {"formulation": formulation, "tolerance": "1.0e-13"}  # the energy is off by twice the tolerance
    done = run("geneva", **how, parameters={"slots": slots}, duration="2.2 s")
    φ, wheel = done["joints/coordinate"].T[:2]
    assert φ[-1] > 6.0 * np.pi
    f, slope = law(φ, slots)
    np.testing.assert_allclose(wheel, -f, atol=2e-13)
    speed = HELD / np.sqrt(1.0 + J2 / J1 * slope**2)
    np.testing.assert_allclose(done["joints/speed"][:, 0], speed, rtol=1e-11)
    energy = done["diagnostics/total_energy"]
    assert np.abs(energy / energy[0] - 1.0).max() <= 5e-13
    enters = 0.5 * np.pi - np.pi / slots
    half = quad(lambda φ: np.sqrt(1.0 + J2 / J1 * law(φ, slots)[1] ** 2) / HELD, 0.0, enters, epsabs=1e-14)[0]
    turn = 2.0 * half + 2.0 * (np.pi - enters) / HELD
    at = int(np.argmin(np.abs(done["time"] - 3.0 * turn)))
    apart = done["time"][at] - 3.0 * turn
    reached = quad(lambda φ: np.sqrt(1.0 + J2 / J1 * law(φ, slots)[1] ** 2) / HELD, 0.0, φ[at] - 6.0 * np.pi)[0]
    assert abs(reached - apart) <= 1e-12


@pytest.mark.parametrize(
    ("slots", "message"),
    [("2", "has 2 for a number of slots; give a whole number, 3 or more"), ("4.5", "has 4.5 for a number of slots")],
)
def test_what_is_refused(slots, message):
    text = mechanism("geneva").read_text(encoding="utf-8").replace("slots: slots", f"slots: {slots}")
    with pytest.raises(InputError) as caught:
        read_scene_text(text)
    assert message in str(caught.value)
