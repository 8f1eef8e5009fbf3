"""What a run is held against: its own books of energy, the laws of contact, and the independent solution."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from .independent import Law, Solution, Unsolved
from .running import Outcome, run
from .scene import OUTPUT_STEP, Case, times

#: What is allowed of a difference from the independent solution, over the size of what is compared: by integrator, as
#: its tolerance or step. Five times what that solution is known to comes on top.
ALLOWED = {"dop853": 5e-6, "radau5": 2e-5, "esdirk4": 1e-4, "auto": 5e-5, "rk4": 1e-4}
#: The least size of what is compared: m, m/s, N or N m.
SMALLEST = 0.1
#: Of the books of energy, over the energy that was moved; of laws of contact, over the largest push.
BOOKS, LAWS = 1e-4, 1e-6
#: A gap in m, a speed in m/s that are none.
NO_GAP, NO_SPEED = 1e-9, 1e-6
#: Up to this speed in m/s a slip may keep its direction, as it begins and as it ends (`straight_speed`).
SLOW = 3e-5
#: Where the independent solution is not known to this part of what is compared, a branch decides: no case.
UNKNOWN = 1e-2


#: What is checked, its error, what is allowed of that, and words on it.
Found = tuple[str, float, float, str]


@dataclass
class Verdict:
    """What became of a case: `fault` names what is wrong, "" for nothing; by check, the error over what is allowed."""

    ended: str
    said: str = ""
    doubts: list[str] = field(default_factory=list)
    #: Whether the independent solution goes on where the run was refused.
    goes_on: bool = False
    errors: dict[str, float] = field(default_factory=dict)
    words: dict[str, str] = field(default_factory=dict)

    def off(self) -> list[tuple[str, float]]:
        """The checks that do not hold, with their errors."""
        return [(what, error) for what, error in self.errors.items() if error > 1.0]

    def take(self, found: Found) -> None:
        """Adds a finding, the largest of those with its name."""
        what, error, allowed, words = found
        if error / allowed > self.errors.get(what, -1.0):
            self.errors[what], self.words[what] = error / allowed, words

    @property
    def kind(self) -> str:
        """right, noted (off, and the run says that it doubts its motion), wrong, refused (though there is a motion),
        ended (exit 3 after the independent solution has ended), no case, or how the process died."""
        if self.ended == "at the end":
            return ("noted" if self.doubts else "wrong") if self.off() else "right"
        if self.ended == "exit 3":
            return "refused" if self.goes_on else "ended"
        return self.ended


def examine(case: Case, seconds: float) -> Verdict:
    """Solves a case independently, runs it, and compares."""
    outcome = run(case.text, seconds)
    verdict = Verdict(outcome.ended, outcome.said, outcome.doubts)
    try:
        solution = case.solve(times(case.duration))
    except Unsolved as error:
        if verdict.ended == "at the end":
            verdict.ended, verdict.said = "no case", str(error)
        return verdict
    until = len(outcome.columns.get("time", ()))
    verdict.goes_on = bool((solution.push[: until + 1] >= 0.0).all())
    if until:
        for found in (*energy(outcome), *contact(case.laws, outcome), *motion(case, outcome, solution)):
            verdict.take(found)
    return verdict


def energy(outcome: Outcome) -> Iterator[Found]:
    """Friction takes energy, at all times; what is put in is moved, stored or taken."""
    books = outcome.energy
    moved = sum(np.ptp(books[name]) for name in ("kinetic_energy", "potential_energy", "work", "dissipation")) + 1e-6
    yield "books of energy", np.abs(books["energy_balance"]).max(), BOOKS * moved, f"of {moved:.3g} J moved"
    taken = np.sum([column for name, column in outcome.columns.items() if "friction/dissipation" in name], axis=0)
    given = -np.diff(taken).min() if np.ndim(taken) and len(taken) > 1 else 0.0
    yield "friction gives energy", given, LAWS * moved, f"{given:.3g} J in a sample"


def contact(laws: dict[str, Law], outcome: Outcome) -> Iterator[Found]:
    """At each sample: no stop is passed or pulls; friction within its cone, and against the slip where it slides."""
    columns = outcome.columns
    for name, law in laws.items():
        push, gap = columns[f"stops/force:{name}"], columns[f"stops/gap:{name}"]
        largest = push.max() + 1e-9
        yield "a stop is passed", -gap.min(), NO_GAP, name
        yield "a stop pulls", -push.min(), LAWS * largest, name
        F, u, state = (
            np.array([columns[f"friction/{of}:{name}.{k}"] for k in (1, 2)]).T for of in ("force", "rate", "state")
        )
        size, speed = (np.linalg.norm(each, axis=1) for each in (F, u))
        yield "friction leaves its cone", (size - law.static * push).max(), LAWS * largest, name
        sticks = (state == 0.0).all(axis=1) & (push > LAWS * largest)
        yield "what sticks moves", (speed * sticks).max(), NO_SPEED, name
        power = (F * u).sum(axis=1).max()
        yield "friction pushes along the slip", power, 10.0 * LAWS * largest * NO_SPEED + 1e-12, name
        slides = speed > SLOW
        if slides.any():
            mu = law.slides + (law.static - law.slides) * (
                np.exp(-((speed / law.stribeck) ** 2)) if law.stribeck else 0.0
            )
            off = np.linalg.norm(F + (mu * push / np.where(slides, speed, 1.0))[:, None] * u, axis=1) * slides
            at = int(off.argmax())
            words = f"{name}: {off[at]:.2e} N off, against {speed[at]:.2e} m/s at {columns['time'][at]:.3g} s"
            yield "sliding friction", off[at], 100.0 * LAWS * largest, words


def motion(case: Case, outcome: Outcome, solution: Solution) -> Iterator[Found]:
    """Against the independent solution, as long as it holds and the run went."""
    until = int(np.argmax(solution.push < 0.0)) if (solution.push < 0.0).any() else len(solution.push)
    for watched, truth, known in zip(case.watched, solution.values.T, solution.known, strict=True):
        found, right = outcome.along(watched)[:until], truth[:until]
        right, size = right[: len(found)], max(np.ptp(truth[:until]), SMALLEST) if until else SMALLEST
        if not len(found) or known > UNKNOWN * size:
            continue
        off = np.abs(found - right)
        at = int(off.argmax())
        words = f"off by {off[at]:.2e} at {OUTPUT_STEP * at:.3g} s: {found[at]:.9g}, right {right[at]:.9g}"
        yield str(watched), off[at], ALLOWED[case.integrator] * size + 5.0 * known, words
