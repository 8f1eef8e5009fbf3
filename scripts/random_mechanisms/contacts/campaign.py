"""Many cases, one after the other: a line for each that is off, a table at the end, their scenes kept."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from time import monotonic

from . import FAMILIES
from .checks import Verdict, examine

#: How much longer runs in NumPy may take.
SLOWER = 5.0
#: What counts as found: the exit code is 1 then.
FAULTS = ("wrong", "refused", "not in time")


def campaign(families: Iterable[str], seeds: range, minutes: float, seconds: float, folder: Path) -> bool:
    """Examines the seeds in turn, all families for each; whether nothing is wrong."""
    kinds: dict[str, Counter[str]] = {name: Counter() for name in families}
    largest: dict[str, tuple[float, str]] = {}
    end = monotonic() + 60.0 * minutes
    for seed in seeds:
        for name, counts in kinds.items():
            if monotonic() > end:
                break
            case = FAMILIES[name](seed)
            verdict = examine(case, seconds * (SLOWER if case.settings["formulation"] == "full" else 1.0))
            counts[verdict.kind] += 1
            counts[f"by {case.integrator}"] += 1
            if verdict.kind == "right":
                for what, error in verdict.errors.items():
                    largest[what] = max(largest.get(what, (0.0, "")), (error, f"{name} {seed}"))
            elif verdict.kind != "no case":
                _tell(f"{name}_{seed:05}", case.integrator, case.text, verdict, folder)
    _table(kinds)
    for what, (error, where) in sorted(largest.items()):
        print(f"  {error:10.2g} of what is allowed, where right: {what} ({where})")
    return not any(counts[kind] for counts in kinds.values() for kind in counts if kind in FAULTS or "exit" in kind)


def _tell(name: str, integrator: str, text: str, verdict: Verdict, folder: Path) -> None:
    """Prints what is off, and keeps the scene with the same words beside it."""
    lines = [f"{verdict.kind}: {name} ({integrator}) {verdict.said if verdict.kind != 'wrong' else ''}".rstrip()]
    lines += [f"  {what}: {error:.2g} times what is allowed, {verdict.words[what]}" for what, error in verdict.off()]
    lines += [f"  it says: {doubt}" for doubt in verdict.doubts]
    print("\n".join(lines), flush=True)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.yaml").write_text(text, encoding="utf-8")
    (folder / f"{name}.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _table(kinds: dict[str, Counter[str]]) -> None:
    names = sorted({kind for counts in kinds.values() for kind in counts if not kind.startswith("by ")})
    print(" ".join(f"{title:>12}" for title in ("family", "cases", *names)))
    for family, counts in kinds.items():
        cases = sum(counts[kind] for kind in names)
        print(" ".join(f"{value:>12}" for value in (family, cases, *(counts[kind] for kind in names))))
    by = sum(kinds.values(), Counter[str]())
    print("by integrator:", ", ".join(f"{name[3:]} {count}" for name, count in sorted(by.items()) if name[:3] == "by "))
