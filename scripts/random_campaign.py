"""Random mechanisms in the kernel against the full formulation.

    python scripts/random_campaign.py [--count 1000] [--seed 0] [--minutes 60] [--output build/random]

Trees of up to six bodies on joints of all types, with up to three loops and three forces, masses over six decades; in
space, floating, or in a plane (scripts/random_mechanisms). Where something is off by more than round-off and the
integrator's error allow, it is told, and the scene kept in the folder, for `mbproj run`. The table at the end has the
largest of each error in units of what is allowed. The exit code is 1 where something disagreed.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from pathlib import Path
from time import monotonic

from hypothesis import HealthCheck, Phase, given, seed, settings
from random_mechanisms.agreement import Verdict, examine
from random_mechanisms.plan import Plan, plans
from random_mechanisms.writing import scene_text

#: Mechanisms that hypothesis draws at a time, near ones one after another.
BATCH = 40


class Campaign:
    """What was found so far."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.number, self.disagreed = folder, 0, 0
        self.largest: dict[str, float] = {}
        self.kinds: Counter[str] = Counter()
        self.seen: set[str] = set()

    def take(self, plan: Plan) -> None:
        """Examines a mechanism that was not examined before."""
        text = scene_text(plan)
        if text in self.seen:
            return
        self.seen.add(text)
        self.number += 1
        verdict = examine(text)
        self.kinds[verdict.no_case or "cases"] += 1
        for name in verdict.formulations:
            self.kinds[name] += 1
        self.kinds["redundant"] += verdict.redundant > 0
        self.kinds["structures"] += not verdict.no_case and verdict.freedom == 0
        for finding in verdict.findings:
            self.largest[finding.what] = max(self.largest.get(finding.what, 0.0), finding.excess)
        if verdict.disagreements:
            self._keep(text, verdict)

    def _keep(self, text: str, verdict: Verdict) -> None:
        self.disagreed += 1
        self.folder.mkdir(parents=True, exist_ok=True)
        path = self.folder / f"{self.number:05}.yaml"
        path.write_text(text, encoding="utf-8")
        print(f"{path}: condition {verdict.condition:.1e}, {verdict.redundant} redundant rows", flush=True)
        for finding in verdict.disagreements:
            print(f"  {finding.what}: {finding.excess:.2g} times what is allowed {finding.why}", flush=True)

    def report(self) -> None:
        """The tables."""
        print(f"{self.number} mechanisms, {self.disagreed} disagreed")
        for kind, count in self.kinds.most_common():
            print(f"  {count:6} {kind.splitlines()[0]}")
        for what, excess in sorted(self.largest.items(), key=lambda entry: -entry[1]):
            print(f"  {excess:10.3g} {what}")


def main() -> None:
    """Runs the campaign."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=1000, help="mechanisms to examine")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--minutes", type=float, default=60.0, help="no more are examined after that time")
    parser.add_argument("--output", type=Path, default=Path("build/random"), help="where scenes that disagree are kept")
    asked = parser.parse_args()
    campaign, end = Campaign(asked.output), monotonic() + 60.0 * asked.minutes

    @settings(
        max_examples=BATCH,
        deadline=None,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(plans())
    def examine_some(plan: Plan) -> None:
        if monotonic() < end and campaign.number < asked.count:
            campaign.take(plan)

    batch = 0
    while monotonic() < end and campaign.number < asked.count:
        seed(1000 * asked.seed + batch)(examine_some)()
        batch += 1
    campaign.report()
    sys.exit(1 if campaign.disagreed else 0)


if __name__ == "__main__":
    main()
