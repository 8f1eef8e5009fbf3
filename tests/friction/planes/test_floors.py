"""Points, blocks and rods on floors and inclines: they slide, stand, rock and fall, and Painlevé's rod."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from mbproj import SimulationError
from tests.friction import closed_forms as exact
from tests.friction.mechanisms import STEPS, block, incline
from tests.friction.planes.scenes import puck
from tests.stops.runs import run

# Points that slide on planes, stick there, and strike them: against closed forms and SciPy. And a slender block that
# rocks on two corners which do not slip (Housner 1963), and on corners that do.


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize(("formulation", "speed"), [("reduced", 5.0), ("full", 0.5)])
def test_it_slides_straight_on_and_stops(formulation, speed):
    """In its own direction, slowed down by μ g."""
    velocity, time = speed * np.array([0.6, 0.8, 0.0]), speed / 4.0
    text = puck("{coefficient: 0.4, static: 0.5}", velocity, duration=1.2 * time, formulation=formulation)
    _, recorded = run(text)
    assert recorded["bodies/position"][-1, 0] == pytest.approx(0.5 * time * velocity, abs=1e-9)
    sticks = {event.time for event in recorded.of("stick")}
    assert max(sticks) == pytest.approx(time, abs=1e-9)
    assert recorded["friction/dissipation"][-1].sum() == pytest.approx(speed**2, rel=1e-8)
    assert recorded.unbalanced < 1e-8


#: A weight that falls on a soft stop beside the puck, and lies there.
SOFT = """\
  table:
    type: stop
    plane: {body: ground, location: [9, 0, 0], normal: [0, 0, 1]}
    point: {body: weight, location: {weight: [0, 0, 0]}}
    stiffness: 1e4 N/m
    restitution: 0.5
"""


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", ["reduced", "full"])
@pytest.mark.parametrize("height", [0.0, 9.0], ids=["it pushes", "it does not"])
def test_it_slides_straight_on_beside_a_soft_stop(formulation, height):
    velocity = 0.5 * np.array([0.6, 0.8, 0.0])
    weight = f"  weight: {{mass: 1, inertia: [0.1, 0.1, 0.1], position: [9, 0, {height}], velocity: [3, 0, 0]}}\n"
    text = puck("0.4", velocity, duration=0.1, formulation=formulation).replace("forces:\n", f"{weight}forces:\n")
    _, recorded = run(text + SOFT)
    assert recorded["bodies/velocity"][-1, 0] == pytest.approx(0.2 * velocity, abs=1e-9)
    assert recorded.unbalanced < 1e-8


@pytest.mark.parametrize("steps", ["dop853", "rk4", "radau5"])
def test_thrown_across_an_incline_it_turns_downhill_and_comes_to_rest(steps):
    """The direction turns, and friction with it; tan 0.3 is below μ = 0.4."""
    time, downhill, across = exact.thrown_across(0.3, 0.4, 2.0, 10.0)
    gravity = [10.0 * np.sin(0.3), 0.0, -10.0 * np.cos(0.3)]
    _, recorded = run(puck("0.4", [0, 2, 0], gravity=gravity, duration=1.5, steps=steps))
    assert max(event.time for event in recorded.of("stick")) == pytest.approx(time, abs=1e-7)
    assert recorded["bodies/position"][-1, 0] == pytest.approx([downhill, across, 0.0], abs=1e-8)
    assert recorded["bodies/velocity"][-1, 0] == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)
    assert recorded.unbalanced < 1e-7


def test_thrown_across_a_steep_incline_it_slides_on():
    down, across = 10.0 * np.sin(0.5), 10.0 * np.cos(0.5)

    def slides(t, y):
        return [y[2], y[3], *([down, 0.0] - 0.4 * across * y[2:] / np.hypot(y[2], y[3]))]

    solved = solve_ivp(slides, (0.0, 1.5), [0.0, 0.0, 0.0, 2.0], method="DOP853", rtol=1e-12, atol=1e-14)
    _, recorded = run(puck("0.4", [0, 2, 0], gravity=[down, 0, -across], duration=1.5))
    ends = np.array([*recorded["bodies/position"][-1, 0, :2], *recorded["bodies/velocity"][-1, 0, :2]])
    assert ends == pytest.approx(solved.y[:, -1], abs=1e-9)
    assert recorded.unbalanced < 1e-8


def test_with_friction_of_the_slope_half_of_the_speed_is_left_in_the_end():
    """μ = tan of the slope: speed and speed downhill together stay the same, so that 2 m/s across become 1 m/s down."""
    down, across = 10.0 * np.sin(0.3), 10.0 * np.cos(0.3)
    _, recorded = run(puck(np.tan(0.3), [0, 2, 0], gravity=[down, 0, -across], duration=3.0))
    velocity = recorded["bodies/velocity"][:, 0]
    assert np.hypot(velocity[:, 0], velocity[:, 1]) + velocity[:, 0] == pytest.approx(2.0, abs=1e-9)
    assert velocity[-1, 0] == pytest.approx(1.0, abs=1e-3)


def test_bounces_take_their_part_of_the_sliding():
    """It strikes with v and rebounds with e v, and so on: together they take μ v (1 + e)/(1 - e) of the speed along the
    floor; then it slides on the floor, and stops."""
    e, v = 0.5, np.sqrt(2.0 * 10.0 * 0.2)
    _, recorded = run(puck("0.1", [3, 0, 0], height=0.2, e=e, duration=4.0))
    flying = v / 10.0 * (1.0 + 2.0 * e / (1.0 - e))
    left = 3.0 - 0.1 * v * (1.0 + e) / (1.0 - e)
    assert recorded.of("impact")[0].time == pytest.approx(v / 10.0, abs=1e-9)
    assert max(event.time for event in recorded.of("stick")) == pytest.approx(flying + left / (0.1 * 10.0), abs=1e-7)
    assert recorded.unbalanced < 1e-7


@pytest.mark.parametrize("μ", [0.1, 0.3, 2.0])
@pytest.mark.parametrize("e", [0.0, 0.5])
def test_a_corner_strikes_the_floor(e, μ):
    """By Newton's law, in flight without weight; the impulse within the cone, at its edge where the corner slips."""
    R, α, tilt, u, w = 0.5, 0.3, 0.2, 1.0, -2.0
    text = block(μ, tilt, R=R, α=α, gravity=0.0, velocity=(u, 0, w), e=e, above=0.1, duration=0.1)
    _, recorded = run(text.replace("simulation: {", "simulation: {impact_law: newton, "))
    (hit,) = recorded.of("impact")
    assert hit.name == "stop 'right'"
    b, h = R * np.sin(α), R * np.cos(α)
    x, z = b * np.cos(tilt) - h * np.sin(tilt), -b * np.sin(tilt) - h * np.cos(tilt)
    m, inertia = 3.0, 3.0 * R**2 / 3.0
    A = np.array([[1.0 / m + z**2 / inertia, -x * z / inertia], [-x * z / inertia, 1.0 / m + x**2 / inertia]])
    along, push = np.linalg.solve(A, [-u, -(1.0 + e) * w])
    if abs(along) > μ * push:
        push = -(1.0 + e) * w / (A[1, 1] - A[1, 0] * μ * np.sign(u))
        along = -μ * push * np.sign(u)
        assert u + A[0] @ [along, push] > 0.0
    assert hit.impulse == pytest.approx(push, rel=1e-9)
    velocity = recorded["bodies/velocity"][-1, 0]
    assert velocity == pytest.approx([u + along / m, 0.0, w + push / m], abs=1e-9)
    turns = (z * along - x * push) / inertia
    assert recorded["bodies/angular_velocity"][-1, 0, 1] == pytest.approx(turns, abs=1e-9)
    assert recorded.unbalanced < 1e-9


#: A slender block that rocks on two corners.
R, α, START, G = 0.5, 0.2, 0.12, 10.0
#: About a corner, kg m².
INERTIA = 4.0 / 3.0 * 3.0 * R**2


def fallen(θ):
    """The speed squared at which it arrives from rest at a tilt."""
    return 2.0 * 3.0 * G * R * (np.cos(α - θ) - np.cos(α)) / INERTIA


def next_tilt(θ):
    """How far it tilts after an impact that leaves Housner's part of its speed."""
    kept = exact.rocking_block_keeps(α) ** 2
    return α - np.arccos(np.cos(α) + kept * (np.cos(α - θ) - np.cos(α)))


def quarter(θ):
    """The time from rest at a tilt to upright."""

    def slowness(s):
        at = θ * (1.0 - s**2)  # takes the root out of the start
        return 2.0 * θ * s / np.sqrt(fallen(θ) - fallen(at))

    return quad(slowness, 0.0, 1.0, epsabs=1e-13, epsrel=1e-13)[0]


@pytest.mark.parametrize("steps", ["dop853", "radau5"])
def test_each_impact_leaves_housners_part_of_the_speed(steps):
    """Times of impact, and the energy that each takes, for four of them."""
    tilts = [START]
    for _ in range(4):
        tilts.append(next_tilt(tilts[-1]))
    times = np.cumsum([quarter(tilts[0]), *(2.0 * quarter(θ) for θ in tilts[1:4])])
    _, recorded = run(block(1.0, START, R=R, α=α, gravity=G, duration=times[-1] + 0.02, steps=steps))
    hits = recorded.of("impact")
    assert [hit.name for hit in hits] == ["stop 'left'", "stop 'right'"] * 2
    assert [hit.time for hit in hits] == pytest.approx(times, abs=1e-8)
    lost = [0.5 * INERTIA * fallen(θ) * (1.0 - exact.rocking_block_keeps(α) ** 2) for θ in tilts[:4]]
    assert [hit.energy for hit in hits] == pytest.approx(lost, rel=1e-8)
    assert recorded.unbalanced < 1e-7


def test_a_block_whose_corners_slip_loses_energy_and_comes_to_rest_upright():
    _, recorded = run(block(0.05, START, R=R, α=α, gravity=G, duration=2.5))
    energy = recorded["diagnostics/total_energy"]
    assert np.diff(energy).max() < 1e-9
    assert recorded["friction/dissipation"][-1].sum() > 1e-3
    assert recorded.unbalanced < 1e-7
    assert recorded["stops/gap"].min() > -1e-9


# A block on an incline that stands, and on one that tilts, against closed forms.

G_INCLINE = 9.81
#: The block's coordinate along the plane is the second one, after the angle of the hinge.
SLIDES = 1


def along(recorded):
    """Where the block is at the end, and its speed."""
    return recorded["joints/coordinate"][-1, SLIDES], recorded["joints/speed"][-1, SLIDES]


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize(("formulation", "steps"), [("full", "dop853"), *(("reduced", steps) for steps in STEPS)])
def test_it_is_released_when_the_angle_is_that_of_static_friction(formulation, steps):
    """Released to 1e-9 s, then on its way as the linear equation has it."""
    tilting = exact.Tilting(ω=0.5, sliding=0.3, static=0.4, g=G_INCLINE)
    text = incline("0.5*t", "{coefficient: 0.3, static: 0.4}", duration=1.4, steps=steps, formulation=formulation)
    _, recorded = run(text)
    (slips,) = recorded.of("slip")
    assert (slips.name, slips.time) == ("friction 'friction'", pytest.approx(tilting.release, abs=1e-9))
    assert along(recorded) == pytest.approx(tilting(1.4), abs=1e-8)
    t = recorded["time"]
    still = t < tilting.release
    assert np.abs(recorded["joints/coordinate"][still, SLIDES]).max() < 1e-13
    assert recorded["friction/force"][still, 0] == pytest.approx(3.0 * G_INCLINE * np.sin(0.5 * t[still]), abs=1e-8)
    assert (recorded["friction/state"][:, 0] == np.where(still, 0, -1)).all()
    assert recorded.unbalanced < 1e-7


@pytest.mark.parametrize("steps", ["dop853", "rk4", "radau5"])
@pytest.mark.parametrize("static", [0.45, 0.6])
def test_it_is_thrown_up_and_comes_back_or_stays(steps, static):
    """At 0.5 rad, tan is 0.546: it comes back with g (sin - μ cos) where the static coefficient is below that."""
    text = incline("0.5", f"{{coefficient: 0.3, static: {static}}}", speed=4.0, steps=steps)
    _, recorded = run(text)
    time, way = exact.up_an_incline(0.5, 0.3, 4.0, G_INCLINE)
    s, rate = along(recorded)
    if static > exact.held_by(0.5):
        (sticks,) = recorded.of("stick")
        assert sticks.time == pytest.approx(time, abs=1e-9)
        assert (s, rate) == (pytest.approx(way, abs=1e-9), pytest.approx(0.0, abs=1e-12))
        assert recorded["friction/force"][-1, 0] == pytest.approx(3.0 * G_INCLINE * np.sin(0.5), rel=1e-9)
    else:
        down = exact.down_an_incline(0.5, 0.3, G_INCLINE)
        assert (s, rate) == pytest.approx((way - 0.5 * down * (2.0 - time) ** 2, -down * (2.0 - time)), abs=1e-8)
        turns = recorded["friction/state"][:, 0]
        assert (turns == np.where(recorded["time"] < time, 1, -1)).all()


def test_energy_is_lost_by_the_way_alone():
    """The plane stands still: what friction took is what potential energy has lost and kinetic energy has not."""
    text = incline("0.9", "{coefficient: 0.3}", speed=3.0, duration=1.5)
    _, recorded = run(text)
    lost = recorded["friction/dissipation"][:, 0]
    assert (np.diff(lost) >= -1e-12).all()
    up = exact.up_an_incline(0.9, 0.3, 3.0, G_INCLINE)[1]
    way = 2.0 * up - along(recorded)[0]
    assert lost[-1] == pytest.approx(0.3 * 3.0 * G_INCLINE * np.cos(0.9) * way, rel=1e-9)
    assert (np.diff(recorded["diagnostics/total_energy"]) <= 1e-9).all()
    assert recorded.unbalanced < 1e-8


@pytest.mark.parametrize("steps", ["radau5", "esdirk4"])
def test_regularised_by_the_force_across_it_creeps(steps):
    """tan 0.3 is 0.62 of the coefficient: it creeps down with the width times artanh of that, and never sticks."""
    text = incline("0.3", "{coefficient: 0.5, regularised: 1.0e-3}", duration=0.5, steps=steps)
    _, recorded = run(text)
    creeps = 1.0e-3 * np.arctanh(np.tan(0.3) / 0.5)
    assert recorded["joints/speed"][-1, SLIDES] == pytest.approx(-creeps, rel=1e-6)
    assert not recorded.of("stick", "slip")


# A rod that falls on rough ends of unequal restitution: its impacts come ever faster, and it ends in contact.

FALLING_ROD = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {{duration: 2, {steps}, output_step: 0.05, formulation: {formulation}, impact_law: {law}}}
bodies:
  rod:
    mass: 1
    inertia: [0.001, 0.0208, 0.0208]
    position: [0, 0, 0.5]
    orientation: {{axis: [0, 1, 0], angle: {angle} deg}}
    velocity: [{speed}, 0, 0]
joints: {{P: {{type: planar, bodies: [ground, rod], location: [0, 0, 0], axis: [0, 1, 0]}}}}
forces:
  {first}
  {second}
"""
END = (
    "{name}: {{type: stop, plane: {{body: ground, location: [0, 0, 0], normal: [0, 0, 1]}}, "
    "point: {{body: rod, location: {{rod: [{x}, 0, 0]}}}}, rigid: true, restitution: {e}, friction: {friction}}}"
)
ENDS = (("a", 0.25, 0.2), ("b", -0.25, 0.8))
ROD_STEPS = {"dop853": "integrator: dop853, tolerance: 1e-9", "rk4": "integrator: rk4, step: 1e-3"}


def falling_rod(*, angle=20, speed=0.3, friction=0.3, steps="dop853", formulation="planar", law="newton", ends=ENDS):
    first, second = (END.format(name=name, x=x, e=e, friction=friction) for name, x, e in ends)
    return FALLING_ROD.format(
        angle=angle, speed=speed, steps=ROD_STEPS[steps], formulation=formulation, law=law, first=first, second=second
    )


@pytest.mark.parametrize("law", ["newton", "poisson"])
@pytest.mark.parametrize("steps", ["dop853", "rk4"])
@pytest.mark.parametrize("formulation", ["planar", "reduced"])
@pytest.mark.parametrize("thrown", [{}, {"angle": -35, "speed": -1, "friction": 0.5}])
def test_it_ends_at_rest_on_both_ends(thrown, formulation, steps, law):
    _, recorded = run(falling_rod(formulation=formulation, steps=steps, law=law, **thrown))
    assert len(recorded.of("impact")) > 10
    assert recorded["stops/force"][-1] == pytest.approx(np.full(2, 0.5 * 9.81), abs=1e-9)
    assert np.abs(recorded["bodies/velocity"][-1]).max() < 1e-12
    assert recorded["bodies/position"][-1, 0, 2] == pytest.approx(0.0, abs=1e-12)
    assert recorded.unbalanced < 1e-7


def test_the_order_of_its_ends_changes_nothing():
    """But round-off, which impacts that come ever faster make larger."""
    (_, one), (_, other) = (run(falling_rod(ends=ends)) for ends in (ENDS, ENDS[::-1]))
    np.testing.assert_allclose(other["bodies/position"], one["bodies/position"], rtol=0, atol=1e-8)
    assert one["bodies/position"][-1, 0, 0] > 0.05


# Painlevé's rod: one end of it slides on a rough floor.

PAINLEVE_ROD = """
mbproj: 1
gravity: [0, 0, -10]
parameters: {tilt: {tilt}, a: 0.5}
simulation: {duration: 0.02, output_step: 0.01, integrator: dopri5, tolerance: 1.0e-9, formulation: {formulation}}
bodies:
  rod:
    mass: 2
    inertia: [2 * a**2 / 3, 2 * a**2 / 3, 0.001]
    position: [0, 0, a * sin(tilt)]
    orientation: {axis: [0, 1, 0], angle: 90 deg - tilt}
    velocity: [{speed}, 0, 0]
forces:
  floor:
    type: stop
    plane: {body: ground, location: [0, 0, 0], normal: [0, 0, 1]}
    point: {body: rod, location: {rod: [0, 0, -a]}}
    rigid: true
    friction: {friction}
"""


def painleve_rod(tilt, speed, friction, formulation="auto"):
    text = PAINLEVE_ROD
    for name, value in (("tilt", tilt), ("speed", speed), ("friction", friction), ("formulation", formulation)):
        text = text.replace(f"{{{name}}}", str(value))
    return run(text)


def push(tilt, friction):
    """N of a rod that slides, m g / (1 + 3 cos² + 3 μ sin cos), with μ < 0 where it leans towards its motion."""
    return 20.0 / (1.0 + 3.0 * np.cos(tilt) ** 2 + 3.0 * friction * np.sin(tilt) * np.cos(tilt))


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", ["auto", "full"])
@pytest.mark.parametrize(("tilt", "friction"), [(0.7, 0.3), (np.arctan(2.0), 1.2), (0.7, 3.0), (1.4, 4.0)])
def test_trailing_it_slides_whatever_the_friction(tilt, friction, formulation):
    """Friction relieves the end that trails: the push is smaller, and there is always one."""
    _, recorded = painleve_rod(tilt, 2.0, friction, formulation)
    assert recorded["stops/force"][0, 0] == pytest.approx(push(tilt, friction), rel=1e-9)
    assert recorded["friction/force"][0, 0] == pytest.approx(-friction * push(tilt, friction), rel=1e-9)


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", ["auto", "full"])
def test_pushed_before_itself_it_presses_harder(formulation):
    _, recorded = painleve_rod(np.arctan(2.0), -2.0, 1.2, formulation)
    assert recorded["stops/force"][0, 0] == pytest.approx(push(np.arctan(2.0), -1.2), rel=1e-9)


@pytest.mark.parametrize("formulation", ["auto", "full"])
@pytest.mark.parametrize(("tilt", "friction"), [(np.arctan(2.0), 1.4), (0.7, 3.0), (1.4, 4.0)])
def test_pushed_before_itself_with_much_friction_it_has_no_motion(tilt, friction, formulation):
    """Above μ = (1 + 3 cos²)/(3 sin cos), 4/3 at the least, no push keeps the end on the floor (Painlevé 1895)."""
    assert push(tilt, -friction) < 0.0
    with pytest.raises(SimulationError, match=r"friction 'floor.*no solution or two.*Painlevé"):
        painleve_rod(tilt, -2.0, friction, formulation)
