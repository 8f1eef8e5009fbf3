"""The tasks of a batch and their results."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from mbproj.analysis import Outcome
from mbproj.dataclass import dataclass
from mbproj.errors import ExitCode

#: The exit code of a scene in one or two words.
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
    """A scene, the file of its results, and whether that file is kept."""

    scene: Path
    output: Path
    keep: bool


@dataclass(frozen=True)
class SceneResult:
    """The result of a scene in a batch. `code` is the exit code that it would have alone, `message` the whole error
    message. `outcomes` are those of its expectations, in their order. `seconds` is the time by the clock. `output` is
    the file with its results, `formulation` that of the run; None where there is none."""

    scene: Path
    code: ExitCode
    message: str
    outcomes: tuple[Outcome, ...]
    seconds: float
    output: Path | None = None
    formulation: str | None = None

    @property
    def word(self) -> str:
        """The result in one or two words. A scene without expectations has only "ran"."""
        return WORDS[self.code] if self.code != ExitCode.DONE or self.outcomes else "ran"

    @property
    def worst(self) -> Outcome | None:
        """The outcome that is closest to its limit or farthest beyond it."""
        return max(self.outcomes, key=lambda outcome: outcome.share, default=None)


def exit_code(results: Iterable[SceneResult]) -> ExitCode:
    """The exit code of the batch. An internal error of mbproj goes first. Then comes FAILED where a scene could not be
    run, wrong input included. Then comes CHECK_FAILED where an expectation is not met."""
    codes = {ExitCode.FAILED if result.code == ExitCode.BAD_INPUT else result.code for result in results}
    return min(codes - {ExitCode.DONE}, default=ExitCode.DONE)
