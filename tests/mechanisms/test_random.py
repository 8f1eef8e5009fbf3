"""Random mechanisms run alike in the kernel and in the full formulation; scripts/random_campaign.py runs many more."""

from __future__ import annotations

from hypothesis import HealthCheck, Phase, given, settings

from scripts.random_mechanisms.agreement import examine
from scripts.random_mechanisms.plan import Plan, plans
from scripts.random_mechanisms.writing import scene_text
from tests.kernel.scenes import needs_kernel


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
