"""Modes of what rolls: Whipple's bicycle against the benchmark, an upright disk, and one that wobbles."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import KroghInterpolator
from scipy.linalg import expm
from scipy.optimize import brentq

import mbproj
from mbproj.base.errors import InputError
from mbproj.equations.constraints import set_velocity
from mbproj.equations.derivatives import MotionAtTime, slip_motion
from mbproj.equations.kinematics import pose_of, twist_of
from mbproj.equations.tangent_space import moved, velocities
from mbproj.linear.equilibrium.solve import NoEquilibrium
from tests.rolling import scenes

# Whipple's bicycle, with the numbers of the benchmark (Meijaard, Papadopoulos, Ruina and Schwab 2007, table 1).

#: Eigenvalues in 1/s of lean and steer by the speed in m/s (their table 2): weave, one of a pair, capsize, castering.
EIGENVALUES = {
    0.0: (-5.53094371765393, -3.13164324790656, 3.13164324790656, 5.53094371765393),
    1.0: (3.52696170990070 + 0.80774027519930j, -3.13423125066578, -7.11008014637442),
    2.0: (2.68234517512745 + 1.68066296590675j, -3.07158645641514, -8.67387984831735),
    3.0: (1.70675605663975 + 2.31582447384325j, -2.63366137253667, -10.35101467245920),
    4.0: (0.41325331521125 + 3.07910818603206j, -1.42944427361326, -12.15861426576447),
    5.0: (-0.77534188219585 + 4.46486771378823j, -0.32286642900409, -14.07838969279822),
    6.0: (-1.52644486584142 + 5.87673060598709j, -0.00406690076970, -16.08537123098026),
    7.0: (-2.13875644258362 + 7.19525913329805j, 0.10268170574766, -18.15788466125262),
    8.0: (-2.69348683581097 + 8.46037971396931j, 0.14327879765713, -20.27940894394569),
    9.0: (-3.21675402252485 + 9.69377351531791j, 0.15790184030917, -22.43788559040858),
    10.0: (-3.72016840437287 + 10.90681139476287j, 0.16105338653172, -24.62459635017404),
}
#: The speeds in m/s from which weave dies out, and from which capsize grows.
WEAVE, CAPSIZE = 4.292382536341, 6.024262015388


def bicycle(speed: float, **simulation: object) -> str:
    """Upright and straight ahead; the paper's z is down, ours up."""
    moves = f"velocity: [{speed!r}, 0, 0]"

    def turning(radius: float) -> str:
        return f"{moves}, angular_velocity: [0, {speed / radius!r}, 0]"

    bodies = (
        f"  rear: {{mass: 2, inertia: [0.0603, 0.12, 0.0603], position: [0, 0, 0.3], {turning(0.3)}}}\n"
        "  frame: {mass: 85, inertia: [[9.2, 0, -2.4], [0, 11, 0], [-2.4, 0, 2.8]], position: [0.3, 0, 0.9], "
        f"{moves}}}\n"
        "  fork: {mass: 4, inertia: [[0.05892, 0, 0.00756], [0, 0.06, 0], [0.00756, 0, 0.00708]], "
        f"position: [0.9, 0, 0.7], {moves}}}\n"
        f"  front: {{mass: 3, inertia: [0.1405, 0.28, 0.1405], position: [1.02, 0, 0.35], {turning(0.35)}}}"
    )
    joints = (
        "  axle: {type: revolute, bodies: [frame, rear], location: [0, 0, 0.3], axis: [0, 1, 0]}\n"
        "  head: {type: revolute, bodies: [frame, fork], location: [1.1, 0, 0], axis: [-sin(18 deg), 0, cos(18 deg)]}\n"
        "  hub: {type: revolute, bodies: [fork, front], location: [1.02, 0, 0.35], axis: [0, 1, 0]}\n"
        f"{scenes.wheel('rear', '[0, 0, 0.3]', '[0, 1, 0]', 0.3)}\n"
        f"{scenes.wheel('front', '[1.02, 0, 0.35]', '[0, 1, 0]', 0.35)}"
    )
    return scenes.scene(bodies, joints, **simulation)


# Modes of what rolls: Whipple's bicycle against the benchmark, an upright disk, and one that wobbles.


def eigenvalues(text):
    return mbproj.modes(mbproj.read_scene_text(text)).eigenvalues


@pytest.mark.parametrize("speed", EIGENVALUES)
def test_whipples_bicycle(speed):
    found = eigenvalues(bicycle(speed))
    moving = found[found != 0.0]
    assert len(moving) == len(EIGENVALUES[speed])
    for expected in EIGENVALUES[speed]:
        assert np.abs(moving - expected).min() < 5e-11


def test_weave_and_capsize_speeds():
    def weave(speed):
        found = eigenvalues(bicycle(speed))
        return found[found.imag > 0.0].real.max()

    def capsize(speed):
        found = eigenvalues(bicycle(speed))
        return found[(found.imag == 0.0) & (found != 0.0)].real.max()

    assert brentq(weave, 4.0, 5.0, xtol=1e-10) == pytest.approx(WEAVE, abs=1e-9)
    speeds = np.array([5.96, 5.98, 6.0, 6.05, 6.07, 6.09])
    assert KroghInterpolator([capsize(float(speed)) for speed in speeds], speeds)(0.0) == pytest.approx(
        CAPSIZE, abs=1e-8
    )


def disk(spin: float) -> str:
    moves = f"velocity: [{0.3 * spin!r}, 0, 0], angular_velocity: [0, {spin!r}, 0]"
    body = f"  disk: {{mass: 1, inertia: [0.0225, 0.045, 0.0225], position: [0, 0, 0.3], {moves}}}"
    return scenes.scene(body, scenes.wheel("disk", "[0, 0, 0.3]", "[0, 1, 0]", 0.3))


@pytest.mark.parametrize("spin", [0.0, 2.0, 3.3, 5.0, 10.0])
def test_an_upright_disk_falls_over_unless_it_is_fast(spin):
    """λ² = (4/5)(g/R - 3 ω²), and zeros: where it is, where it is headed, how far it has turned."""
    found = mbproj.modes(mbproj.read_scene_text(disk(spin)))
    root = np.sqrt(complex(0.8 * (9.81 / 0.3 - 3.0 * spin**2)))
    moving = found.eigenvalues[found.eigenvalues != 0.0]
    assert found.freedom == 3
    expected = [root**2] * (2 if root.real else 1)
    np.testing.assert_allclose(moving**2, expected, rtol=1e-10, atol=1e-10)  # next to 0 the roots are less exact


def test_a_linear_model_of_the_bicycle_has_its_eigenvalues_and_answers():
    """Lean and steer of a push on the frame: at first it leans as the modes' matrices say, A B once and C twice."""
    text = bicycle(5.0).replace(
        "joints:\n", "forces:\n  push: {type: torque, body: frame, torque: [1, 0, 0]}\njoints:\n"
    )
    text += "\nmarkers:\n  saddle: {body: frame, location: [0.3, 0, 0.9]}\n"
    still = text.replace("torque: [1, 0, 0]", "torque: [0 * t, 0, 0]")
    model = mbproj.linearize(mbproj.read_scene_text(still), inputs=["push.x"], outputs=["head.angle", "saddle.y"])
    found = np.linalg.eigvals(model.A)
    for expected in EIGENVALUES[5.0]:
        assert np.abs(found - expected).min() < 1e-9
    t, h = 0.02, 1e-3
    runs = [
        mbproj.run(
            mbproj.read_scene_text(text.replace("torque: [1, 0, 0]", f"torque: [{push} + 0 * t, 0, 0]")), duration=t
        )
        for push in (h, -h)
    ]
    x = expm(np.block([[model.A, model.B], [np.zeros((1, len(model.A) + 1))]]) * t)[: len(model.A), -1]
    ends = [
        (r["joints/coordinate"][-1, r.names("coordinates").index("head.angle")], r["markers/position"][-1, 0, 1])
        for r in runs
    ]
    answer = (np.array(ends[0]) - np.array(ends[1])) / (2.0 * h)
    np.testing.assert_allclose(model.C @ x, answer, rtol=1e-5)


@pytest.mark.parametrize(
    ("word", "rest"), [("motions", "motions: {go: {joint: axle, angle: 3 * t}}"), ("reactions", "")]
)
def test_what_linear_models_of_what_rolls_lack_is_refused(word, rest):
    text = f"{bicycle(0.0)}\n{rest}\n"
    with pytest.raises(InputError, match=f"linear models of rolling mechanisms have no .*{word}"):
        mbproj.linearize(mbproj.read_scene_text(text), inputs=["head.angle"], outputs=["hub.force_z"])


def test_an_eccentric_ball_rolls_to_its_rest_without_slip():
    """In a plane its centre goes by R times the angle; there are 4 eigenvalues 0, and ω² = m g e / (I + m (R - e)²)."""
    tilt = float(np.radians(40.0))
    at = f"[{float(0.02 * np.sin(tilt))!r}, 0, {float(0.1 - 0.02 * np.cos(tilt))!r}]"
    turn = f"orientation: {{axis: [0, 1, 0], angle: {-tilt!r}}}"
    body = f"  ball: {{mass: 1, inertia: [0.004, 0.004, 0.004], position: {at}, {turn}}}"
    ball = (
        "  B: {type: rolling_ball, bodies: [ground, ball], plane: {location: {ground: [0, 0, 0]}, "
        "normal: {ground: [0, 0, 1]}}, centre: {ball: [0, 0, 0.02]}, radius: 0.1}"
    )
    plane = f"\n  P: {{type: planar, bodies: [ground, ball], location: {at}, axis: [0, 1, 0]}}"
    found = mbproj.equilibrium(mbproj.read_scene_text(scenes.scene(body, ball + plane)))
    assert found.stable
    x, z = found.reference.motion.pose.position[0, ::2]
    assert (x, z) == pytest.approx((0.1 * tilt, 0.08), abs=1e-6)
    anywhere = mbproj.equilibrium(mbproj.read_scene_text(scenes.scene(body, ball)))
    assert (anywhere.stable, anywhere.family) == (True, 2)
    modes = mbproj.modes(mbproj.read_scene_text(scenes.scene(body, ball)), at="equilibrium")
    ω = np.sqrt(9.81 * 0.02 / (0.004 + 0.08**2))
    np.testing.assert_allclose(modes.eigenvalues, [0.0] * 3 + [1j * ω] * 2, atol=1e-8)


def test_slip_near_a_motion_is_what_slips_there():
    """A ξ' + H ξ against central differences of the slip at neighbours of a wobbling coin, and H' along its motion."""
    system = mbproj.compile_system(mbproj.read_scene_text(scenes.coin()))
    rng = np.random.default_rng(2)
    q = np.array([0.3, -0.2, 0.4, 0.6, 0.4, -0.5, 0.3])
    q[3:] /= np.linalg.norm(q[3:])
    u, change, ξ, ξ_dot = rng.normal(size=(4, 6))
    rows = np.flatnonzero(system.joints.is_velocity)

    def slip(h):
        """Of ξ moved by h, with δω = ξ' + ω × ξ in body axes."""
        there = moved(q, h * ξ)
        moves = u + h * ξ_dot
        moves[3:] += h * np.cross(u[3:], ξ[3:])
        pose = pose_of(there)
        return set_velocity(system.joints, pose, twist_of(pose, velocities(pose, moves)))[rows]

    def at(t):
        return MotionAtTime(0.0, moved(q, t * u + 0.5 * t**2 * change), u + t * change, change, np.zeros(0)).carried()

    own = slip_motion(system.rows, at(0.0))
    from mbproj.equations.derivatives import row_motion

    A = row_motion(system.rows, at(0.0)).G.dense()[own.rows]
    h = 1e-5
    np.testing.assert_allclose(A @ ξ_dot + own.H.dense() @ ξ, (slip(h) - slip(-h)) / (2.0 * h), rtol=1e-7, atol=1e-8)
    bent = (slip_motion(system.rows, at(h)).H.dense() - slip_motion(system.rows, at(-h)).H.dense()) / (2.0 * h)
    np.testing.assert_allclose(own.H_dot.dense(), bent, atol=2e-6)


@pytest.mark.parametrize("lean", [75.0])
def test_a_coin_that_leans_falls_over_and_is_told_so_by_joint(lean):
    """Its axis is that far from upright; upright, at 90 degrees, it balances."""
    s, c = float(np.sin(np.radians(lean))), float(np.cos(np.radians(lean)))
    at = f"position: [0, 0, {0.3 * s!r}], orientation: {{axis: [0, 1, 0], angle: {lean} deg}}"
    body = f"  coin: {{mass: 1, inertia: [0.0225, 0.0225, 0.045], {at}}}"
    text = scenes.scene(body, scenes.wheel("coin", f"[0, 0, {0.3 * s!r}]", f"[{s!r}, 0, {c!r}]", 0.3))
    with pytest.raises(NoEquilibrium, match=r"wheel of joint 'W_coin' falls over .* start it upright") as error:
        mbproj.equilibrium(mbproj.read_scene_text(text))
    assert "nothing balances" not in str(error.value)
    assert not mbproj.equilibrium(mbproj.read_scene_text(disk(0.0))).stable
