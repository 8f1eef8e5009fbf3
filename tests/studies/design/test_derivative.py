"""Derivatives of what a trial has, against closed forms, and how many runs they take."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.kernel import core
from mbproj.studies.design.neighbours import Followed
from mbproj.studies.design.slopes import Counted
from mbproj.studies.design.spec import read_spec
from mbproj.studies.design.trial import Wish
from tests.studies.design.scenes import SPRING

pytestmark = pytest.mark.skipif(core() is None, reason="no compiled kernel")


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
