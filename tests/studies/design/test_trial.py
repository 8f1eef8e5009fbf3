"""What a search shares between its runs leaves no trace in them: a trial has the bits of a run of its scene alone."""

from __future__ import annotations

import numpy as np
import pytest

import mbproj
from mbproj.integrate import simulate
from mbproj.scene.settings import settings_to_run
from mbproj.studies.design.spec import read_spec
from mbproj.studies.design.trial import Wish, tried
from mbproj.studies.measure.measured_samples import MeasuredSamples
from mbproj.studies.measure.mechanism import Mechanism
from tests.studies.design.scenes import FOUR_BAR, SPRING, written

CASES = {
    "kinematic": (
        FOUR_BAR,
        "  parameters.crank: [0.15, 0.25]\n  parameters.px: [0, 0.4]\n  bodies.c.position.0: [0.79, 0.81]\n",
        "marker: tip",
        ("position_x (m)", lambda results: results.marker("tip").position[:, 0]),
    ),
    "integrated": (
        SPRING,
        "  parameters.mass: [1, 3]\n  parameters.stiffness: [20, 90]\n",
        "joint: rail, quantity: displacement",
        ("displacement (m)", lambda results: results.coordinate("rail.displacement").value),
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_a_trial_has_the_bits_of_a_run_whatever_ran_before(case, tmp_path):
    scene, vary, of, (heading, seen) = CASES[case]
    with mbproj.run(mbproj.read_scene_text(scene)) as results:
        rows = "".join(f"{t!r},0.0\n" for t in results.time.tolist())
    (tmp_path / "wanted.csv").write_text(f"time (s),{heading}\n{rows}", encoding="utf-8")
    match = f"match: {{it: {{{of}, through: wanted.csv}}}}\n"
    wish = Wish.of(read_spec(written(tmp_path, scene, f"vary:\n{vary}{match}")))
    designs = np.random.default_rng(5).random((3, len(wish.paths)))
    there = [tried(wish, u).residuals for u in designs]
    back = [tried(wish, u).residuals for u in designs[::-1]][::-1]
    for u, first, second in zip(designs, there, back, strict=True):
        values = dict(zip(wish.paths, wish.values(u).tolist(), strict=True))
        with mbproj.run(mbproj.read_scene_text(scene, "scene", values)) as results:
            alone = seen(results)
        assert first.tolist() == second.tolist()
        assert first.tolist() == alone.tolist()


def test_a_run_without_accounts_of_energy_moves_alike_and_claims_none():
    mechanism = Mechanism.of(mbproj.read_scene_text(SPRING))
    settings, kept, reports = settings_to_run(mechanism.scene), [], []
    for accounts in (True, False):
        kept.append(MeasuredSamples(mechanism, ()))
        reports.append(simulate(mechanism.system, mechanism.state, settings, kept[-1], accounts=accounts))
    assert reports[0].state.y.tolist() == reports[1].state.y.tolist()
    assert 0.0 < reports[0].energy_drift < 1e-5
    assert np.isnan([reports[1].energy_drift, reports[1].energy_drift_relative, reports[1].energy.work]).all()
