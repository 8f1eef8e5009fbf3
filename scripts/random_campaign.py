"""Random mechanisms in the kernel against the full formulation; random contacts against an independent solution.

    python scripts/random_campaign.py [--count 1000] [--seed 0] [--minutes 60] [--output build/random]
    python scripts/random_campaign.py contacts [--count 250] [--seed 0] [--minutes 60] [--seconds 20]
    python scripts/random_campaign.py stage yoke block ...

`mechanisms` (without a name): trees of up to six bodies on joints of all types, with up to three loops and three
forces, masses over six decades; in space, floating, or in a plane (scripts/random_mechanisms). Where something is off
by more than round-off and the integrator's error allow, it is told, and the scene kept in the folder, for `mbproj run`.
The table at the end has the largest of each error in units of what is allowed.

`contacts`, or some of its families by name (scripts/random_mechanisms/contacts): scenes with rigid stops and dry
friction. Each runs as `mbproj run` does, with an integrator drawn for it, in a process of its own that has `--seconds`
of processor time. It is held against the books of energy, the laws of contact, and an independent solution, in minimal
coordinates by hand, with SciPy.
`--count` is the number of seeds from `--seed` on; each makes a scene in each family. A scene is

  right       all checks hold
  noted       one does not, and the run says that it doubts its motion
  wrong       one does not, and the run says nothing
  refused     exit 3 at a time at which the independent solution goes on
  ended       exit 3 from where on that says nothing: a foot has lifted off
  no case     the independent solution does not get through

The exit code is 1 where something disagreed, or was wrong, refused, not in time, or crashed.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from pathlib import Path
from time import monotonic

from hypothesis import HealthCheck, Phase, given, seed, settings
from random_mechanisms.agreement import Verdict, examine
from random_mechanisms.contacts import FAMILIES
from random_mechanisms.contacts.campaign import campaign as contacts
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
    choices = ("mechanisms", "contacts", *FAMILIES)
    parser.add_argument("what", nargs="*", default=["mechanisms"], metavar="WHAT", help=", ".join(choices))
    parser.add_argument("--count", type=int, help="mechanisms to examine (1000), or seeds of contacts (250)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--minutes", type=float, default=60.0, help="no more are examined after that time")
    parser.add_argument("--output", type=Path, default=Path("build/random"), help="where scenes that disagree are kept")
    parser.add_argument("--seconds", type=float, default=20.0, help="of the processor, for a scene with contacts")
    asked = parser.parse_args()
    if unknown := set(asked.what) - set(choices):
        parser.error(f"unknown: {', '.join(sorted(unknown))}; known: {', '.join(choices)}")
    if asked.what == ["mechanisms"]:
        sys.exit(1 if _mechanisms(asked.count or 1000, asked.seed, asked.minutes, asked.output) else 0)
    if "mechanisms" in asked.what:
        parser.error("mechanisms and contacts are campaigns of their own")
    families = list(FAMILIES) if "contacts" in asked.what else asked.what
    seeds = range(asked.seed, asked.seed + (asked.count or 250))
    sys.exit(0 if contacts(families, seeds, asked.minutes, asked.seconds, asked.output) else 1)


def _mechanisms(count: int, first: int, minutes: float, folder: Path) -> int:
    """How many disagreed."""
    campaign, end = Campaign(folder), monotonic() + 60.0 * minutes

    @settings(
        max_examples=BATCH,
        deadline=None,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(plans())
    def examine_some(plan: Plan) -> None:
        if monotonic() < end and campaign.number < count:
            campaign.take(plan)

    batch = 0
    while monotonic() < end and campaign.number < count:
        seed(1000 * first + batch)(examine_some)()
        batch += 1
    campaign.report()
    return campaign.disagreed


if __name__ == "__main__":
    main()
