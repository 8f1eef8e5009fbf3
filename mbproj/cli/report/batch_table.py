"""The report of a batch: a table that grows in the order of the scenes, and an object for JSON."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import click

from mbproj.cli.report.expectations import error_words, verdict
from mbproj.cli.report.expectations import record as outcome_record
from mbproj.errors import ExitCode

if TYPE_CHECKING:
    from mbproj.studies.batch import SceneResult

RESULT_WIDTH = len("fault of mbproj")


class BatchRows:
    """The table on stdout. A row is printed as soon as all rows before it are."""

    def __init__(self, scenes: Sequence[str], shown: bool) -> None:
        self._scenes, self._shown, self._next = scenes, shown, 0
        self._width = max(map(len, scenes))
        self._started = perf_counter()
        if shown:
            self._print("scene", "result", "hold", "time", "error against what is allowed")

    def show(self, results: Mapping[int, SceneResult]) -> None:
        """Print the rows that can be printed now."""
        while self._shown and self._next in results:
            self._row(results[self._next])
            self._next += 1

    def finish(self, results: Mapping[int, SceneResult]) -> None:
        """Print the remaining rows, with the scenes that did not run, and the totals."""
        if not self._shown:
            return
        for number in range(self._next, len(self._scenes)):
            if number in results:
                self._row(results[number])
            else:
                self._print(self._scenes[number], "not run", "", "", "")
        counts = _counts(list(results.values()))
        scenes = "scene" if len(self._scenes) == 1 else "scenes"
        click.echo(
            f"{len(self._scenes)} {scenes} in {perf_counter() - self._started:.1f} s: {counts['hold']} as expected, "
            f"{counts['fall_short']} short of it, {counts['failed']} failed"
            + (f", {counts['without_expectations']} without expectations" if counts["without_expectations"] else "")
            + f"; {counts['expectations_hold']} of {counts['expectations']} expectations hold"
        )

    def _row(self, result: SceneResult) -> None:
        hold, detail = "", result.message.partition("\n")[0]
        if result.outcomes:
            hold = f"{sum(outcome.holds for outcome in result.outcomes)} of {len(result.outcomes)}"
            assert result.worst is not None
            detail = f"{result.worst.expectation.name}: {error_words(result.worst)}"
        elif result.code == ExitCode.DONE:
            detail = "(it expects nothing)"
        self._print(str(result.scene), result.word, hold, f"{result.seconds:.2f} s", detail)
        short = [outcome for outcome in result.outcomes if not outcome.holds and outcome is not result.worst]
        for outcome in short:
            detail = f"{outcome.expectation.name}: {error_words(outcome)}"
            self._print("", verdict(outcome), "", "", detail)

    def _print(self, scene: str, result: str, hold: str, time: str, detail: str) -> None:
        click.echo(f"{scene:{self._width}}  {result:{RESULT_WIDTH}}  {hold:>7}  {time:>8}  {detail}".rstrip())


def record(results: Sequence[SceneResult], left: Sequence[Path], code: ExitCode) -> dict[str, Any]:
    """The object that --json prints. `left` are the scenes that did not run because the batch was interrupted."""
    return {
        "exit_code": int(code),
        **_counts(results),
        "not_run": left,
        "scenes": [
            {
                "scene": str(result.scene),
                "result": result.word,
                "exit_code": int(result.code),
                "seconds": result.seconds,
                "formulation": result.formulation,
                "message": result.message or None,
                "output": None if result.output is None else str(result.output),
                "expectations": [outcome_record(outcome) for outcome in result.outcomes],
            }
            for result in results
        ],
    }


def messages(results: Sequence[SceneResult]) -> Iterator[str]:
    """Yield the full messages of scenes that could not run."""
    for result in results:
        if result.message:
            yield result.message if result.code == ExitCode.BAD_INPUT else f"{result.scene}: {result.message}"


def _counts(results: Sequence[SceneResult]) -> dict[str, int]:
    codes = [result.code for result in results]
    outcomes = [outcome for result in results for outcome in result.outcomes]
    unjudged = sum(result.code == ExitCode.DONE and not result.outcomes for result in results)
    return {
        "hold": codes.count(ExitCode.DONE) - unjudged,
        "without_expectations": unjudged,
        "fall_short": codes.count(ExitCode.CHECK_FAILED),
        "failed": len(codes) - codes.count(ExitCode.DONE) - codes.count(ExitCode.CHECK_FAILED),
        "expectations": len(outcomes),
        "expectations_hold": sum(outcome.holds for outcome in outcomes),
    }
