"""Random mechanisms and scenes with contacts, against the full formulation and independent solutions."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings

from scripts.random_mechanisms.agreement import examine
from scripts.random_mechanisms.contacts import FAMILIES, independent
from scripts.random_mechanisms.contacts.checks import examine as examine_contacts
from scripts.random_mechanisms.contacts.independent import Law, solve
from scripts.random_mechanisms.contacts.scene import times
from scripts.random_mechanisms.plan import Plan, plans
from scripts.random_mechanisms.writing import scene_text
from tests.kernel.scenes import needs_kernel

# Random mechanisms run alike in the kernel and in the full formulation; scripts/random_campaign.py runs many more.


@needs_kernel
@settings(
    max_examples=24,
    derandomize=True,
    deadline=None,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
@given(plans())
def test_formulations_agree_and_keep_what_mechanics_keeps(plan: Plan) -> None:
    """Accelerations, reactions, poses, velocities, closure, energy, momentum: to round-off × the equations' condition,
    and to the error of the steps, which halving them shows."""
    text = scene_text(plan)
    verdict = examine(text)
    assert not verdict.no_case or "fixed joints have merged" in verdict.no_case, "what is drawn is a scene"
    off = [
        f"{finding.what}: {finding.excess:.2g} times what is allowed {finding.why}" for finding in verdict.disagreements
    ]
    assert not off, "\n".join([*off, text])


# Random scenes with contacts against their independent solutions; scripts/random_campaign.py runs many more.

#: Processor time of a scene, s.
SECONDS = 60.0


@needs_kernel
@pytest.mark.parametrize(
    ("family", "seed"),
    [
        ("stage", 2),
        pytest.param("stage", 18, marks=pytest.mark.full),
        pytest.param("yoke", 10, marks=pytest.mark.full),
        ("slider_crank", 1),
        ("block", 6),
        ("plate", 8),
        pytest.param("ball", 0, marks=pytest.mark.full),
        pytest.param("wheel", 1, marks=pytest.mark.full),
    ],
)
def test_runs_agree_with_the_independent_solution(family, seed):
    verdict = examine_contacts(FAMILIES[family](seed), SECONDS)
    assert verdict.kind == "right", (verdict.said, verdict.off(), verdict.words)
    assert verdict.errors["books of energy"] < 1.0


@needs_kernel
@pytest.mark.parametrize("change", ["friction", "mass"])
def test_a_wrong_run_is_found(change):
    """A run of a scene whose friction or mass is half a per cent off is not that of the scene."""
    case = FAMILIES["block"](6)
    pattern = {"friction": r"(friction: (?:{coefficient: )?)([\d.]+)", "mass": r"(block: {mass: )([\d.]+)"}[change]
    text = re.sub(pattern, lambda found: f"{found[1]}{1.005 * float(found[2]):.6g}", case.text)
    assert text != case.text
    verdict = examine_contacts(replace(case, text=text), SECONDS)
    assert verdict.kind == "wrong"
    assert {what for what, _ in verdict.off()} & {str(watched) for watched in case.watched}


@pytest.mark.full
def test_what_is_no_scene_or_does_not_end_is_told():
    case = FAMILIES["block"](6)
    assert examine_contacts(replace(case, text="mbproj: 1\nbodies: {"), SECONDS).kind == "exit 2"
    falls = "gravity: [0, 0, -10]\nbodies: {b: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}}"
    long = f"mbproj: 1\nsimulation: {{duration: 1e4, step: 1e-6, output_step: 1}}\n{falls}\n"
    assert examine_contacts(replace(case, text=long), 2.0).kind == "not in time"


def test_the_independent_solution_converges_to_the_closed_form(monkeypatch):
    """A block slides to rest and sticks; a load that grows from 0.5 s on tears it loose after a time s:
    x = v²/(2 μ g) + c (t - 0.5 - s)³/(6 m)."""
    mu, g, v, c, m = 0.4, 9.81, 1.5, 60.0, 3.0
    law, grip = Law(mu, mu), m * g

    def rate(t, s, width):
        return [s[1], (c * max(t - 0.5, 0.0) - law.drag(width, s[1]) * grip * s[1]) / m]

    def look(t, s, width):
        return [s[0]], grip

    right = v**2 / (2.0 * mu * g) + c * (0.3 - mu * grip / c) ** 3 / (6.0 * m)
    errors = []
    for width in (1e-5, 1e-6):
        monkeypatch.setattr(independent, "WIDTHS", (10.0 * width, width))
        found = solve(rate, look, [0.0, v], np.linspace(0.0, 0.8, 81))
        errors.append(abs(found.values[-1, 0] - right))
        assert errors[-1] < found.known[0]
    assert 8.0 < errors[0] / errors[1] < 12.0


def test_every_family_draws_the_same_scene_again_and_solves_it():
    for family, draw in FAMILIES.items():
        case = draw(5)
        assert case.text == draw(5).text != draw(6).text, family
        assert case.solve(times(0.05)).values.shape == (6, len(case.watched)), family
