"""What a search shares between its runs leaves no trace in them: a trial has the bits of a run of its scene alone."""

from __future__ import annotations

import numpy as np
import pytest

import mbproj
from mbproj import settings_to_run
from mbproj.motion.simulate import simulate
from mbproj.studies import case_blocks
from mbproj.studies.design.spec import read_spec
from mbproj.studies.design.trial import Wish, tried, tried_by_arrays
from mbproj.studies.measure.solve import MeasuredSamples, Mechanism
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


@pytest.mark.parametrize("case", CASES)
def test_designs_that_are_tried_by_arrays_have_the_bits_that_they_have_alone(case, tmp_path, monkeypatch):
    """Also those that do not close; and most of the others are run in groups. A constraint is of parameters."""
    scene, vary, of, (heading, _) = CASES[case]
    (tmp_path / "wanted.csv").write_text(f"time (s),{heading}\n0.0,0.0\n0.5,0.1\n1.0,0.2\n", encoding="utf-8")
    first = vary.split(".")[1].split(":")[0]
    wanted = (
        f"match: {{it: {{{of}, through: wanted.csv}}}}\n"
        f"subject_to: {{own: {{expression: {first}*{first}, at_most: 1}}}}\n"
    )
    wide = vary.replace("[0.15, 0.25]", "[0.15, 0.8]")
    wish = Wish.of(read_spec(written(tmp_path, scene, f"vary:\n{wide}{wanted}")))
    designs = [*np.random.default_rng(5).random((24, len(wish.paths)))]
    grouped = []

    def counted(*given, **further):
        rows = case_blocks.by_arrays(*given, **further)
        grouped.extend(rows)
        return rows

    monkeypatch.setattr("mbproj.studies.case_blocks.by_arrays", counted)
    together, alone = tried_by_arrays(wish, designs), [tried(wish, u) for u in designs]
    for one, other in zip(together, alone, strict=True):
        for name in ("residuals", "goals", "limits", "open"):
            assert getattr(one, name).tobytes() == getattr(other, name).tobytes()
        assert (one.cause, one.reached) == (other.cause, other.reached)
    runs = sum(trial.runs for trial in alone)
    assert len(grouped) >= 0.6 * runs and (runs < len(designs)) == (case == "kinematic")


def test_a_run_without_accounts_of_energy_moves_alike_and_claims_none():
    mechanism = Mechanism.of(mbproj.read_scene_text(SPRING))
    settings, kept, reports = settings_to_run(mechanism.scene), [], []
    for accounts in (True, False):
        kept.append(MeasuredSamples(mechanism, ()))
        reports.append(simulate(mechanism.system, mechanism.state, settings, kept[-1], accounts=accounts))
    assert reports[0].state.y.tolist() == reports[1].state.y.tolist()
    assert 0.0 < reports[0].energy_drift < 1e-5
    assert np.isnan([reports[1].energy_drift, reports[1].energy_drift_relative, reports[1].energy.work]).all()
