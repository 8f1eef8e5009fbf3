"""What is to be run, and what came of it."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from mbproj.analysis import Outcome
from mbproj.dataclass import dataclass
from mbproj.errors import ExitCode

#: What a scene's code means, in a word or two.
WORDS = {
    ExitCode.DONE: "holds",
    ExitCode.CHECK_FAILED: "falls short",
    ExitCode.FAILED: "failed",
    ExitCode.BAD_INPUT: "wrong input",
    ExitCode.INTERNAL: "fault of mbproj",
    ExitCode.INTERRUPTED: "interrupted",
}


@dataclass(frozen=True)
class Task:
    """A scene, where its results go, and whether they are kept there."""

    scene: Path
    output: Path
    keep: bool


@dataclass(frozen=True)
class SceneResult:
    """What came of a scene: the exit code that it would have alone; what is wrong with it (a whole message); the
    `outcomes` of its expectations in their order; how long it took, in s of the clock. `output` is where its results
    are kept, `formulation` the one that ran; None where none did, or the process was lost.
    """

    scene: Path
    code: ExitCode
    message: str
    outcomes: tuple[Outcome, ...]
    seconds: float
    output: Path | None = None
    formulation: str | None = None

    @property
    def word(self) -> str:
        """The result in a word or two; without expectations, a scene has only run."""
        return WORDS[self.code] if self.code != ExitCode.DONE or self.outcomes else "ran"

    @property
    def worst(self) -> Outcome | None:
        """The outcome that comes nearest to what is allowed, or is farthest beyond it."""
        return max(self.outcomes, key=lambda outcome: outcome.share, default=None)


def exit_code(results: Iterable[SceneResult]) -> ExitCode:
    """The code of all: FAILED where a scene could not be run, for wrong input in it too, or else CHECK_FAILED where one
    falls short, or DONE. A fault of mbproj goes before."""
    codes = {ExitCode.FAILED if result.code == ExitCode.BAD_INPUT else result.code for result in results}
    return min(codes - {ExitCode.DONE}, default=ExitCode.DONE)
