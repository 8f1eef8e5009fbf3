"""Derivatives of measures and of what a trial has, against closed forms."""

from __future__ import annotations

import json

import numpy as np
import pytest

import mbproj
from mbproj.kernel import core
from mbproj.show.figures.designs import draw_sensitivities
from mbproj.studies.design.neighbours import Followed
from mbproj.studies.design.slopes import Counted, DifferenceWork, differences
from mbproj.studies.design.spec import read_spec
from mbproj.studies.design.trial import Wish
from tests.cli.commands import mbproj as command
from tests.studies.design.scenes import BALL, SPRING

DROPPED = """\
mbproj: 1
gravity: [0, 0, -10]
parameters: {height: 1.25 m, bounce: 0.8}
bodies:
  ball: {mass: 1, inertia: [1, 1, 1], position: [0, 0, height]}
forces:
  floor: {type: stop, point: {body: ball, location: {ball: [0, 0, 0]}}, rigid: true, restitution: bounce,
          plane: {body: ground, location: [0, 0, 0], normal: [0, 0, 1]}}
simulation: {duration: 0.9 s, tolerance: 1.0e-10, integrator: dop853, output_step: 0.1}
expect:
  up: {body: ball, quantity: position, component: z, at: end, below: 100 m, source: a parabola after the impact}
"""


def slopes(text, **options):
    found = mbproj.sensitivity(text, **options)
    return {(measure, number): (slope, off) for measure, number, _, slope, off, *_ in found.table.rows}


def test_of_a_throw():
    """x = v cos α t, z = v sin α t - g t²/2, at t = 1."""
    found = slopes(BALL, to="speed,angle")
    exact = {
        ("far", "speed"): np.cos(1.0),
        ("far", "angle"): -10.0 * np.sin(1.0),
        ("high", "speed"): np.sin(1.0),
        ("high", "angle"): 10.0 * np.cos(1.0),
    }
    assert {key: slope for key, (slope, _) in found.items()} == pytest.approx(exact, rel=1e-10)
    for key, (slope, off) in found.items():
        assert abs(slope - exact[key]) <= max(off, 1e-12)


def differences_of(text, to, of=("far", "high")):
    scene = mbproj.read_scene_text(text)
    measures = tuple(each for each in scene.expectations if each.name in of)
    x = np.array([scene.parameters[name] for name in to])
    return differences(DifferenceWork(scene, scene.settings, tuple(to), measures), x, np.abs(x), 1)


def test_two_runs_a_number_where_they_agree_and_four_where_they_do_not():
    """x = exp(300 α) t: of second order its slope is off by (300 h)²/6 = 1.5e-6, of fourth by 2.7e-12."""
    gentle = differences_of(BALL, ["speed", "angle"])
    assert gentle.runs == 1 + 2 * 2
    text = BALL.replace("[speed*cos(angle)", "[1 m/s * exp(300*(angle - 1))")
    steep = differences_of(text, ["angle"], ["far"])
    assert steep.runs == 1 + 4
    assert steep.slopes[0, 0] == pytest.approx(300.0, rel=1e-9)
    assert steep.uncertainty[0, 0] < 1e-6 * 300.0
    duals = mbproj.sensitivity(text, of="far", to="angle")
    assert duals.why == (("",),)
    assert duals.slopes[0, 0] == pytest.approx(300.0, rel=1e-9)
    assert abs(duals.slopes[0, 0] - 300.0) < duals.uncertainty[0, 0] < 1e-6 * 300.0


@pytest.mark.full
def test_through_an_impact():
    """After T = √(2h/g): z = e g T τ - g τ²/2, τ = t - T; by h: dT/dh = 1/(g T)."""
    found = slopes(DROPPED)
    g, h, e, t = 10.0, 1.25, 0.8, 0.9
    fall = np.sqrt(2.0 * h / g)
    after, by_height = t - fall, 1.0 / (g * fall)
    exact = {
        ("up", "bounce"): g * fall * after,
        ("up", "height"): (e * g * (after - fall) + g * after) * by_height,
    }
    assert {key: slope for key, (slope, _) in found.items()} == pytest.approx(exact, rel=1e-8)


def test_elasticities_rank_numbers():
    table = mbproj.sensitivity(BALL, of="far", to=["idle", "speed", "angle"]).table
    assert table["number"].tolist() == ["angle", "speed", "idle"]
    assert table["elasticity"] == pytest.approx([-np.tan(1.0), 1.0, 0.0], abs=1e-9)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"of": "fra"}, "no expectation is called 'fra'; choose from: far, high"),
        ({"to": "spede"}, "'spede' is no number of the mechanism by itself; did you mean 'speed'"),
        ({"to": "simulation.duration"}, "'simulation.duration' is no number of the mechanism by itself"),
        ({"to": "bodies.ball.inertia"}, "'bodies.ball.inertia' is no number of the mechanism by itself"),
    ],
)
def test_names_that_are_not_there(options, said):
    with pytest.raises(mbproj.InputError, match=said.replace("(", r"\(")):
        mbproj.sensitivity(BALL, **options)


def test_runs_on_one_side_are_enough():
    """A mass that a larger number leaves without a value, and a start that goes by its square."""
    text = BALL.replace("mass: 1 kg", "mass: 1 + sqrt(2.000001 - idle)").replace("speed*cos(angle)", "1 m/s * idle**2")
    found = mbproj.sensitivity(text, of="far", to="idle")
    assert found.slopes[0, 0] == pytest.approx(4.0, rel=1e-9)
    assert found.uncertainty[0, 0] < 1e-7


def test_a_run_beside_that_fails_is_said():
    """A mass that other numbers make negative."""
    text = BALL.replace("mass: 1 kg", "mass: 1.0e-12 - (idle - 2)**2")
    with pytest.raises(mbproj.InputError, match="a run with another 'idle' fails"):
        mbproj.sensitivity(text, to="idle")


def test_numbers_that_no_other_run_has_are_left_out(tmp_path):
    """A count, of all parameters; by name it is an error."""
    text = BALL.replace("angle: 1 rad, idle: 2}", "angle: 1 rad, idle: 2, count: 3}").replace(
        "mass: 1 kg", "mass: 1.0e-12 - (count - 3)**2"
    )
    (tmp_path / "ball.yaml").write_text(text, encoding="utf-8")
    rows = json.loads(command("sensitivity", "ball.yaml", "-j", "1", "--json", folder=tmp_path).stdout)["slopes"]
    assert {row["number"]: row["by"] for row in rows} == {
        "speed": "dual numbers",
        "angle": "dual numbers",
        "idle": "dual numbers",
        "count": "left out",
    }
    assert {row["slope"] is None for row in rows if row["number"] == "count"} == {True}
    done = command("sensitivity", "ball.yaml", "-j", "1", folder=tmp_path)
    assert (done.returncode, done.stdout.count("count")) == (0, 1)
    assert done.stdout.splitlines()[-1].startswith("left out: count, because 'mass' must be at least 0")
    done = command("sensitivity", "ball.yaml", "-j", "1", "--to", "count", folder=tmp_path)
    assert (done.returncode, "a run with another 'count' fails" in done.stderr) == (2, True)


def test_what_is_nothing_has_no_elasticity():
    """x is to be 0 and is round-off; its slope is told all the same."""
    text = BALL.replace("position: [0, 0, 0], velocity", "position: [1.0e-13*idle, 0, 0], velocity")
    text = text.replace("velocity: [speed*cos(angle)", "velocity: [0 m/s")
    text = text.replace("below: 100 m, source: v cos α t", "value: 0 m, absolute: 1.0e-12, source: it goes up")
    found = mbproj.sensitivity(text, of="far", to="idle")
    assert found.values[0] != 0.0
    assert np.isnan(found.elasticity).all()
    assert found.slopes[0, 0] == pytest.approx(1e-13)


def test_round_off_of_what_is_measured_is_in_the_uncertainty():
    """x = 1 m + 1e-9 m a: neighbours in a are so near that three digits of the slope are left."""
    text = BALL.replace("position: [0, 0, 0], velocity", "position: [1 + 1.0e-9*idle, 0, 0], velocity")
    found = mbproj.sensitivity(text.replace("velocity: [speed*cos(angle)", "velocity: [0 m/s"), of="far", to="idle")
    assert abs(found.slopes[0, 0] - 1e-9) <= found.uncertainty[0, 0] < 1e-10


def test_bars_show_the_elasticities_and_what_has_none(tmp_path):
    """x = v cos α: of v it is 1, of α -α tan α. Straight up x is 0 and has none."""
    axes = draw_sensitivities(mbproj.sensitivity(BALL, of=["far"], to=["speed", "angle"]).table).axes
    widths = {t.get_text(): bar.get_width() for t, bar in zip(axes[0].get_yticklabels(), axes[0].patches, strict=True)}
    assert widths == pytest.approx({"angle": -np.tan(1.0), "speed": 1.0}, rel=1e-9)
    still = BALL.replace("position: [0, 0, 0], velocity: [speed*cos(angle)", "position: [0, 0, 0], velocity: [0 m/s")
    axes = draw_sensitivities(mbproj.sensitivity(still, of=["far"], to=["speed"]).table).axes
    assert axes[0].texts[0].get_text() == "its value is 0: no elasticity"
    (tmp_path / "ball.yaml").write_text(BALL, encoding="utf-8")
    done = command("sensitivity", "ball.yaml", "--to", "speed", "--plot", "bars.png", "-j", "1", folder=tmp_path)
    assert (done.returncode, done.stderr.splitlines()[-1]) == (0, "bars.png")
    assert (tmp_path / "bars.png").read_bytes().startswith(b"\x89PNG")


# Derivatives of what a trial has, against closed forms, and how many runs they take.


@pytest.mark.skipif(core() is None, reason="no compiled kernel")
@pytest.mark.parametrize(
    ("settings", "why", "runs", "error"),
    [
        ("step: 0.002 s", "", 1, 1e-6),
        ("tolerance: 1.0e-9, integrator: dop853", "", 1, 1e-6),
        ("step: 0.002 s", "asked for", 3, 1e-6),
        ("tolerance: 1.0e-9, integrator: dop853", "asked for", 3, 1e-6),  # others follow its steps
        # Solved to a tolerance: central, with a large step.
        ("tolerance: 1.0e-9, integrator: radau5", "radau5 makes implicit steps", 5, 1e-4),
    ],
)
def test_no_run_or_one_a_number_is_enough_where_runs_are_smooth(settings, why, runs, error, tmp_path, monkeypatch):
    """By dual numbers, and by differences where these are asked for, or the only way.

    x = cos ωt, ω² = k/m: ∂x/∂k = -t sin ωt / (2 m ω), ∂x/∂m = t sin ωt ω / (2 m)."""
    times, mass, stiffness = np.linspace(0.1, 2.0, 20), 2.0, 50.0
    rows = "\n".join(f"{time!r},0.0" for time in times.tolist())
    (tmp_path / "seen.csv").write_text(f"time (s),displacement (m)\n{rows}\n", encoding="utf-8")
    (tmp_path / "spring.yaml").write_text(
        SPRING.replace("step: 0.01 s, output", f"{settings}, output"), encoding="utf-8"
    )
    (tmp_path / "fit.yaml").write_text(
        "design: 1\nscene: spring.yaml\nvary: {parameters.mass: [1 kg, 3 kg], parameters.stiffness: [0 N/m, 100 N/m]}\n"
        "match: {it: {joint: rail, quantity: displacement, through: seen.csv}}\n",
        encoding="utf-8",
    )
    if why == "asked for":
        monkeypatch.setattr(Followed, "why", why)
    wish = Wish.of(read_spec(tmp_path / "fit.yaml"))
    trials = Counted(wish)
    slopes = trials.slopes(lambda trial: trial.residuals, wish.shares(np.array([mass, stiffness])), central=False)
    assert (trials.count, trials.why) == (runs, why)
    ω = np.sqrt(stiffness / mass)
    swing = times * np.sin(ω * times) / (2.0 * mass)
    exact = np.stack([swing * ω, -swing / ω], axis=1) * [2.0, 100.0]
    np.testing.assert_allclose(slopes, exact, rtol=0.0, atol=error * np.abs(exact).max())


@pytest.mark.skipif(core() is None, reason="no compiled kernel")
def test_a_measure_that_dual_numbers_do_not_see_goes_alone(tmp_path):
    """A damped mass in a uniform field, v = (g m/c)(1 - exp(-c t/m)): its way by dual numbers, ∫c v² by differences."""
    scene = SPRING.replace("gravity: [0, 0, 0]", "gravity: [-9, 0, 0]").replace("stiffness: 50 N/m", "c: 3 N*s/m")
    scene = scene.replace("stiffness: stiffness, free_displacement: -1 m", "damping: c")
    (tmp_path / "spring.yaml").write_text(scene, encoding="utf-8")
    (tmp_path / "goal.yaml").write_text(
        "design: 1\nscene: spring.yaml\nvary: {parameters.mass: [1 kg, 3 kg], parameters.c: [1 N*s/m, 5 N*s/m]}\n"
        "minimise: {way: {joint: rail, quantity: displacement, at: end}}\n"
        "subject_to: {lost: {diagnostic: dissipation, at: end, at_most: 1000 J}}\n",
        encoding="utf-8",
    )
    wish, x = Wish.of(read_spec(tmp_path / "goal.yaml")), np.array([2.0, 3.0])
    trials = Counted(wish)
    u = wish.shares(x)
    own = trials(u)
    slopes = trials.slopes(lambda trial: np.append(trial.goals, trial.limits), u, central=True) / (wish.high - wish.low)
    assert [each.name for each in own.followed.missing] == ["lost"] and trials.why == ""
    t = 2.0

    def exact(m, c):
        τ, end = m / c, 9.0 * m / c
        way = -end * (t - τ * (1.0 - np.exp(-t / τ)))
        lost = c * end**2 * (t - 2.0 * τ * (1.0 - np.exp(-t / τ)) + 0.5 * τ * (1.0 - np.exp(-2.0 * t / τ)))
        return np.array([way, -lost])

    h = 1e-5
    wanted = np.stack([(exact(*(x + step)) - exact(*(x - step))) / (2.0 * h) for step in h * np.eye(2)], axis=1)
    np.testing.assert_allclose(slopes, wanted, rtol=1e-7)
