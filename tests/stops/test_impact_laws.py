"""Newton's, Poisson's and Stronge's laws of impact, and one-sided conditions."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from mbproj.base.errors import InputError, SimulationError
from mbproj.base.registry import IMPACT_LAWS
from mbproj.commands.main import mbproj
from mbproj.equations.assembly.compiled import compile_system
from mbproj.kernel import core
from mbproj.scene.scene import read_scene_text
from tests.crossed import full
from tests.kernel.scenes import needs_kernel
from tests.laws import one_sided, strike
from tests.stops.runs import run

pytestmark = needs_kernel


# Newton's, Poisson's and Stronge's laws of impact: where they agree, what each keeps, beside closed forms.

FORMULATIONS = ["full", *(["planar", "reduced"] if core() is not None else [])]
ROUGH = [name for name in IMPACT_LAWS if name != "newton"]

STRUCK = """
mbproj: 1
gravity: [0, 0, -10]
simulation: {duration: 0.5, integrator: dop853, tolerance: 1.0e-8, output_step: 0.05}
bodies:
  rod:
    mass: 1
    inertia: [0.001, 0.02, 0.02]
    position: [0, 0, 0.45]
    orientation: {axis: [0, 1, 0], angle: 50 deg}
    velocity: [-2, 0, 0]
joints:
  P: {type: planar, bodies: [ground, rod], location: [0, 0, 0], axis: [0, 1, 0]}
forces:
  end:
    type: stop
    plane: {body: ground, location: [0, 0, 0], normal: [0, 0, 1]}
    point: {body: rod, location: {rod: [0.25, 0, 0]}}
    rigid: true
    restitution: 0.9
    friction: 1.2
"""


def rough(law, A, speeds, coefficient, e):
    """One stop whose normal row is the first of A (1 + k, f), and its tangents the others."""
    k = len(A) - 1
    partner = [1, 0] if k == 2 else [-1] * k
    return strike(law, A, speeds, [e], np.full(k, coefficient), [(other, 0) for other in partner])


def followed(B, u, coefficient, e):
    """The energetic law at rates u, with the operator B of the rows."""
    A = np.linalg.cholesky(B)
    return rough("energetic", A, np.linalg.solve(A, u), coefficient, e)


def struck_by(law, formulation="auto", text=STRUCK):
    own = f"simulation: {{impact_law: {law}, formulation: {formulation}, "
    return run(text.replace("simulation: {", own))


def falling(rng, k, f=4):
    A, speeds = rng.normal(size=(1 + k, f)), rng.normal(size=f)
    A[0] *= -np.sign(A[0] @ speeds)
    return A, speeds


@pytest.mark.parametrize("law", IMPACT_LAWS)
@given(seed=st.integers(0, 10_000), e=st.floats(1e-3, 1.0))
@settings(deadline=None, max_examples=40, derandomize=True)
def test_sliding_that_does_not_turn_leaves_the_same_speed(law, seed, e):
    """With u_t far from 0 the impulses are (1, -μ û) (1 + e) |u_n| / (B (1, -μ û))_n, whatever e is of."""
    rng = np.random.default_rng(seed)
    A, _ = falling(rng, 1)
    speeds = np.linalg.lstsq(A, np.array([-1.0, 50.0]), rcond=None)[0]
    B, friction = A @ A.T, np.array([1.0, -0.1])
    normal = (1.0 + e) / (B @ friction)[0]
    if normal <= 0.0 or (B @ friction)[1] * normal < -40.0:
        return
    found = rough(law, A, speeds, 0.1, e)
    np.testing.assert_allclose(A @ found.v, [-1.0, 50.0] + B @ friction * normal, rtol=1e-9, atol=1e-9)
    assert found.impulse[0] == pytest.approx(normal, rel=1e-9)


def sticking(B, u, e):
    """Closed form for one tangent: sliding stops at p₁ = -u_t / (B (1, f))_t, and then sticks; the works are areas."""
    f = -MU * np.sign(u[1])
    slide = B @ [1.0, f]
    p1 = -u[1] / slide[1]
    held = -B[1, 0] / B[1, 1]
    rise = B[0] @ [1.0, held]
    u1 = u[0] + slide[0] * p1
    assert u1 < 0.0 < rise
    taken = 0.5 * (u[0] + u1) * p1 - 0.5 * u1**2 / rise
    return p1 - u1 / rise + np.sqrt(2.0 * e**2 * -taken / rise), u1, rise, p1, taken


MU = 1.2


@pytest.mark.parametrize("e", [0.0, 0.3, 0.9])
def test_sliding_that_comes_to_stick_is_that_of_routh(e):
    """A rod of 1 kg with J = 0.0208 kg m², 0.25 m from its centre to the end, at 50°."""
    r, J = 0.25 * np.array([np.cos(np.radians(50)), -np.sin(np.radians(50))]), 0.0208
    B = np.array([[1.0 + r[0] ** 2 / J, -r[0] * r[1] / J], [-r[0] * r[1] / J, 1.0 + r[1] ** 2 / J]])
    u = np.array([-3.0, -1.0])
    normal, _, rise, _, taken = sticking(B, u, e)
    found = followed(B, u, MU, e)
    assert found.impulse[0] == pytest.approx(normal, rel=1e-10)
    after = u + B @ found.impulse
    np.testing.assert_allclose(after, [np.sqrt(2.0 * e**2 * -taken * rise), 0.0], atol=1e-10)
    assert found.taken[0] == pytest.approx(-(1.0 - e**2) * taken, rel=1e-10)


@given(st.integers(0, 10_000), st.sampled_from([1, 2]), st.floats(0.0, 2.0), st.floats(0.0, 1.0))
@settings(deadline=None, max_examples=60, derandomize=True)
@example(0, 1, 2.225e-309, 1.0)  # next to nothing
def test_the_energetic_law_gives_back_its_part_and_creates_none(seed, k, coefficient, e):
    A, speeds = falling(np.random.default_rng(seed), k)
    B, u = A @ A.T, A @ speeds
    compression, whole = followed(B, u, coefficient, 0.0), followed(B, u, coefficient, e)
    after = u + B @ whole.impulse
    assert after[0] >= -1e-9
    assert np.linalg.norm(whole.impulse[1:]) <= (coefficient + 1e-9) * whole.impulse[0]
    lost = 0.5 * u @ np.linalg.solve(B, u) - 0.5 * after @ np.linalg.solve(B, after)
    scale = 0.5 * u @ np.linalg.solve(B, u)
    assert whole.taken[0] == pytest.approx((1.0 - e**2) * compression.taken[0], rel=1e-8, abs=1e-10 * scale)
    assert whole.taken[1:].sum() >= -1e-9 * scale
    assert lost == pytest.approx(whole.taken.sum(), rel=1e-7, abs=1e-9 * scale)


@given(st.integers(0, 10_000), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
@settings(deadline=None, max_examples=40, derandomize=True)
def test_poissons_impulse_is_one_and_e_times_that_of_compression(seed, coefficient, e):
    """Unless what it gives lets the gap close again, where it is more."""
    A, speeds = falling(np.random.default_rng(seed), 1)
    compression = rough("poisson", A, speeds, coefficient, 0.0)
    whole = rough("poisson", A, speeds, coefficient, e)
    after, least = A[0] @ whole.v, (1.0 + e) * compression.impulse[0]
    assert whole.impulse[0] >= least * (1.0 - 1e-9)
    assert abs((whole.impulse[0] - least) * after) <= 1e-7 * abs(A[0] @ speeds) * least
    assert whole.lost == pytest.approx(whole.taken.sum(), abs=1e-9 * (speeds @ speeds))


@pytest.mark.parametrize("law", ["newton", "poisson"])
def test_three_balls_that_touch_part_as_the_impulses_say(law):
    """Compression takes all to 1/3 of the speed with impulses 2/3 and 1/3, and expansion repeats them."""
    N, speeds = np.array([[-1.0, 1.0, 0.0], [0.0, -1.0, 1.0]]), np.array([1.0, 0.0, 0.0])
    np.testing.assert_allclose(strike(law, N, speeds, np.ones(2)).v, [-1 / 3, 2 / 3, 2 / 3], atol=1e-12)


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize("law", ROUGH)
def test_a_rough_impact_that_newtons_law_refuses_goes_on(law, formulation):
    _, recorded = struck_by(law, formulation)
    assert np.abs(recorded["diagnostics/energy_balance"]).max() < 1e-7
    first = recorded.of("impact")[0]
    assert first.impulse > 0.0
    assert first.energy > 0.0


def test_newtons_law_names_one_that_helps():
    """There are no unequal restitutions where one stop is struck."""
    with pytest.raises(
        SimulationError,
        match="friction turns an impact round; use 'impact_law: poisson' in 'simulation', or use a smaller",
    ):
        struck_by("newton")


def test_the_laws_on_a_rod_that_comes_to_stick():
    """What they take of 3.805 J, as the guide has it."""
    r, J = 0.25 * np.array([np.cos(np.radians(50)), -np.sin(np.radians(50))]), 0.0208
    A = np.array([[0.0, 1.0, -r[0] / np.sqrt(J)], [1.0, 0.0, r[1] / np.sqrt(J)]])
    speeds = np.array([-2.0, -1.9, 0.0])
    lost = {law: rough(law, A, speeds, MU, 0.9).lost for law in IMPACT_LAWS}
    assert lost == pytest.approx({"newton": -0.04787, "poisson": 0.7688, "energetic": 0.5880}, abs=1e-4)


OTHER = """forces:
  other:
    type: stop
    rigid: true
    restitution: 0.5
    plane: {body: ground, location: [0, 0, 0], normal: [0, 0, 1]}
    point: {body: rod, location: {rod: [-0.25, 0, 0]}}
"""


def test_the_usual_law_is_the_energetic_one():
    _, usual = run(STRUCK)
    _, named = struck_by("energetic")
    np.testing.assert_array_equal(usual["bodies/velocity"], named["bodies/velocity"])


def test_a_rod_that_lands_flat_on_two_rough_ends_turns_both_rates():
    """Both ends are struck at once and slide on: u_n = -e u_n, and friction takes μ (1 + e) |u_n| of the sliding."""
    flat = STRUCK.replace("angle: 50 deg", "angle: 0 deg").replace("velocity: [-2, 0, 0]", "velocity: [-20, 0, 0]")
    flat = flat.replace("restitution: 0.9", "restitution: 0.5").replace("friction: 1.2", "friction: 0.1")
    other = OTHER.replace("restitution: 0.5", "restitution: 0.5\n    friction: 0.1")
    _, recorded = run(flat.replace("forces:\n", other))
    first = recorded.of("impact")[:2]
    fall = np.sqrt(2.0 * 10.0 * 0.45)
    assert [event.impulse for event in first] == pytest.approx([0.5 * 1.5 * fall] * 2, rel=1e-9)
    sliding = 20.0 - 0.1 * 1.5 * fall
    assert recorded["bodies/velocity"][-1, 0, 0] == pytest.approx(-sliding, rel=1e-9)


@pytest.mark.parametrize("first", [0, *map(full, (100, 200, 300))])
def test_several_rough_stops_create_no_energy_and_stay_in_their_cones(first):
    """Any rows, so that stops and tangents depend on each other; stops that are struck, lie still, or part. Of 12,000
    such impacts 32 have no answer."""
    unanswered = 0
    for seed in range(first, first + 100):
        rng = np.random.default_rng(seed)
        stops, freedoms, k, same = int(rng.integers(2, 4)), int(rng.integers(4, 8)), int(rng.integers(1, 3)), seed % 2
        A, speeds = rng.normal(size=(stops * (1 + k), freedoms)), rng.normal(size=freedoms)
        A[:stops] *= np.where(rng.random(stops) < 0.8, -np.sign(A[:stops] @ speeds), 1.0)[:, None]
        e, coefficient = rng.random(stops), np.repeat(rng.uniform(0.0, 1.5, stops), k)
        rubbing = [(i * k + (1 - j) if k == 2 else -1, i) for i in range(stops) for j in range(k)]
        found = strike("energetic", A, speeds, np.full(stops, e[0]) if same else e, coefficient, rubbing)
        if found is None:
            unanswered += 1
            continue
        energy, gaps = 0.5 * speeds @ speeds, A[:stops] @ found.v
        assert found.lost >= -1e-9 * energy
        assert gaps.min() >= -1e-8
        push = found.impulse[:stops]
        assert push.min() >= 0.0
        along = np.linalg.norm(found.impulse[stops:].reshape(stops, k), axis=1)
        assert np.all(along <= coefficient[::k] * push + 1e-7 * push.max(initial=0.0))
        assert found.taken.sum() == pytest.approx(found.lost, abs=1e-7 * energy)
    assert unanswered <= 2


@given(st.integers(0, 100_000), st.integers(2, 4), st.floats(0.0, 1.0))
@settings(deadline=None, max_examples=60, derandomize=True)
def test_where_nothing_turns_several_stops_part_as_by_newtons_law(seed, stops, e):
    """Bodies slide fast along one direction, which impulses of little friction do not turn."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(2 * stops, 2 * stops))
    rates = np.concatenate([-rng.uniform(0.1, 1.0, stops), rng.choice([-1.0, 1.0], stops) * 1e4])
    speeds, rubbing = np.linalg.solve(A, rates), [(-1, i) for i in range(stops)]
    coefficient = np.full(stops, 1e-3)
    newton, found = (strike(law, A, speeds, np.full(stops, e), coefficient, rubbing) for law in ("newton", "energetic"))
    if np.abs((A @ newton.v)[stops:] / rates[stops:] - 1.0).max() > 0.9:
        return
    np.testing.assert_allclose(found.impulse, newton.impulse, rtol=0, atol=1e-7 * newton.impulse.max())


def test_what_jams_keeps_its_impulse_and_stays_at_rest():
    """A tip and a stop of the knee, both shut, leave one way to go: friction that sticks along it holds any push."""
    A = np.array([[1.0, 0.0], [-0.2, 0.3], [-0.35, 0.55]])  # knee, tip, along the floor
    speeds = np.array([0.0, -8.0])
    found = strike("energetic", A, speeds, [0.0, 0.5], [0.9], [(-1, 1)])
    np.testing.assert_allclose(found.v, 0.0, atol=1e-9)
    assert found.lost == pytest.approx(32.0, rel=1e-9)
    assert found.impulse[1] > 0.0


def test_a_law_without_a_rigid_stop_does_nothing():
    text = STRUCK.replace("rigid: true", "stiffness: 1e5").replace("    friction: 1.2\n", "")
    scene = read_scene_text(text.replace("1e5", "1.0e+5"), simulation={"impact_law": "poisson"})
    with pytest.raises(InputError, match="'impact_law' does nothing: the scene has no rigid stop; leave it out"):
        compile_system(scene)


WALL = "plane: {body: ground, location: [0, 0, 0], normal: [-1, 0, 0]}, point: {body: slow, location: [0, 0, 0]}"
PRESSED_AGAINST_A_WALL = f"""
mbproj: 1
gravity: [0, 0, 0]
simulation: {{duration: 0.5, integrator: rk4, step: 2.0e-2}}
bodies:
  fast: {{mass: 1, inertia: [1, 1, 1], position: [-0.2, 0, 0], velocity: [1, 0, 0]}}
  slow: {{mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}}
forces:
  wall: {{type: stop, {WALL}, rigid: true, restitution: 1}}
  meet: {{type: stop, points: {{fast: [-0.2, 0, 0], slow: [0, 0, 0]}}, shortest: 0.1, rigid: true, restitution: 0}}
"""


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", FORMULATIONS[::2])
@pytest.mark.parametrize(("law", "speed"), [("newton", 0.0), ("poisson", -0.5)])
def test_what_lies_at_a_wall_gives_its_impulse_back_by_poissons_law(law, speed, formulation):
    """Both stop; then the wall gives back m v, which both share. By Newton's law what does not approach stays."""
    _, recorded = struck_by(law, formulation, PRESSED_AGAINST_A_WALL)
    np.testing.assert_allclose(recorded["bodies/velocity"][-1, :, 0], speed, atol=1e-12)


def test_the_command_line_has_it(tmp_path, monkeypatch):
    from click.testing import CliRunner

    monkeypatch.chdir(tmp_path)
    (tmp_path / "rod.yaml").write_text(STRUCK)
    assert CliRunner().invoke(mbproj, ["run", "rod.yaml", "--impact-law", "energetic", "-q"]).exit_code == 0
    assert CliRunner().invoke(mbproj, ["continue", "results.h5", "--until", "0.6", "-q"]).exit_code == 0
    with pytest.raises(InputError, match="unknown impact law 'stronge'; choose from: newton, poisson, energetic"):
        CliRunner().invoke(mbproj, ["run", "rod.yaml", "--impact-law", "stronge"], catch_exceptions=False)


# One-sided conditions: complementarity for any rows, and the energy of impacts.


@given(st.integers(0, 10_000), st.integers(1, 8), st.integers(1, 6))
def test_pushes_and_openings_are_complementary(seed, rows, freedoms):
    rng = np.random.default_rng(seed)
    N, speeds = rng.normal(size=(rows, freedoms)), rng.normal(size=freedoms)
    N[rows // 2] = N[0]  # rows may depend on each other
    b = N @ speeds
    z = one_sided(N, b)
    assert z is not None  # x = -speeds fulfils all
    opening = N @ (N.T @ z) + b
    size = np.linalg.norm(N, axis=1) * np.linalg.norm(speeds)
    assert z.min() >= 0.0
    assert (opening / size).min() > -1e-9
    assert np.abs(z * opening).max() < 1e-8 * (speeds @ speeds)


def test_the_push_is_unique_in_what_it_does():
    """Two equal rows share one push, in any way; the change is that of one."""
    N = np.array([[1.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    z = one_sided(N, np.array([-2.0, -2.0, 3.0]))
    assert N.T @ z == pytest.approx([2.0, 0.0])
    assert z[2] == 0.0


@pytest.mark.parametrize("N", [np.zeros((1, 1)), np.array([[1.0], [-1.0]])])
def test_what_cannot_open_has_no_push(N):
    assert one_sided(N, -np.ones(len(N))) is None


@given(st.integers(0, 10_000), st.integers(1, 6), st.integers(1, 6), st.floats(0.0, 1.0))
def test_equal_restitutions_create_no_energy(seed, rows, freedoms, e):
    rng = np.random.default_rng(seed)
    speeds = rng.normal(size=freedoms)
    N = rng.normal(size=(rows, freedoms))
    N *= -np.sign(N @ speeds)[:, None]  # all are struck
    found = strike("newton", N, speeds, np.full(rows, e))
    energy = 0.5 * speeds @ speeds
    assert found.lost >= -1e-9 * energy
    assert found.taken.sum() == pytest.approx(found.lost, abs=1e-8 * energy)


def test_unequal_restitutions_may_create_energy_and_that_is_seen():
    """Three planes whose normals nearly balance: one asks for what the others leave hardly room for."""
    N = np.array(
        [[0.7611379, -0.54606341, -0.34997693], [0.42011854, 0.89911651, -0.12284096], [-0.74977728, -0.6, 0.27846724]]
    )
    speeds = np.array([0.23854459, 0.72664687, -0.64426765])
    found = strike("newton", N, speeds, [0.0, 0.0, 1.0])
    assert found.lost < -1.0
