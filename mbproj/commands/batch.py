"""`mbproj batch` and `mbproj.batch`: runs many scenes in parallel processes and checks their expectations."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import TYPE_CHECKING, Annotated, Any

import click

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import ExitCode
from mbproj.commands.declared import Asked, command_of, declared, read
from mbproj.commands.figure_options import plot_option
from mbproj.commands.kinds import Positive
from mbproj.commands.options import Argument, FolderPath, Option, Part, scene_file
from mbproj.commands.report.summary import error_words, verdict
from mbproj.commands.report.summary import record as outcome_record
from mbproj.commands.study_options import FreshWork, answer, junit
from mbproj.results.report_schema.facts import report_of
from mbproj.results.report_schema.runs import NOTES
from mbproj.results.views import Table, Tabled
from mbproj.studies.batch import SceneResult, exit_code, run_batch, scene_paths, tasks

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from typing_extensions import Unpack

    from mbproj.commands.arguments import Quantity

#: The largest timeout (s) of a scene: 30 years, which every clock can count.
LONGEST = 1e9
RESULT_WIDTH = len("fault of mbproj")
EXAMPLES = (
    ("Run a scene and all scenes of a folder, and check what they expect.", "mbproj batch five_bar.yaml validation"),
    ("Run all scenes below this folder in a pipeline.", 'mbproj batch "**/*.yaml" --junit report.xml --keep results'),
)
Paths = Annotated["str | Path | Sequence[str | Path]", Argument(scene_file(path_type=Path), many=True)]
Timeout = Annotated[
    "Quantity", Option(Part.EFFORT, "Stop a scene that runs longer.", Positive("s", maximum=LONGEST), "TIME")
]
Keep = Annotated[
    "str | Path | None",
    Option(
        Part.OUTPUT,
        "Keep the results files in DIR. What is complete there is only checked again.",
        FolderPath(path_type=Path),
        "DIR",
    ),
]


@dataclass(frozen=True)
class Batch(Tabled):
    """The results of many scenes, in their order."""

    results: tuple[SceneResult, ...]

    @property
    def holds(self) -> bool:
        """Whether all scenes ran and meet all their expectations."""
        return exit_code(self.results) == ExitCode.DONE

    @property
    def table(self) -> Table:
        """A table with a row for each scene."""
        return Table.of(map(_row, self.results), "scene", "result")

    @property
    def line(self) -> str:
        """A line that counts the scenes by their result."""
        words = [result.word for result in self.results]
        return ", ".join(f"{words.count(word)} {word}" for word in dict.fromkeys(words))

    __repr__ = Tabled.__repr__


@declared
def batch(paths: Paths, *, timeout: Timeout = "5 min", keep: Keep = None, **effort: Unpack[FreshWork]) -> Batch:
    """Runs many scenes and checks their `expect` blocks.

    PATHS are scene files, directories, or patterns ('**/*.yaml').

    Prints a table: scene, result, how many expectations hold, seconds, and the expectation nearest to its limit with
    its error and the error allowed. A scene that fails does not stop the others. With --keep, an interrupted batch
    resumes where it stopped: complete results of the same scene, by the same code, are only checked again.

    Exit code 0: all expectations hold; 3: a scene could not run (wrong input, a failure, the timeout); 4: all scenes
    ran, and an expectation does not hold; 2: wrong options, or no scenes.

    In Python it returns the results. A scene that fails is a row. Raises InputError where there are no scenes.
    """
    asked = read(batch, locals())
    scenes, results = scene_paths(asked.paths), dict[int, SceneResult]()

    def record(number: int, result: SceneResult) -> None:
        results[number] = result
        asked.progress("scenes", len(results), len(scenes))

    _run(asked, scenes, record)
    return Batch(tuple(results[number] for number in sorted(results)))


def _run(asked: Any, scenes: Sequence[Path], record: Callable[[int, SceneResult], None]) -> None:
    """Run the scenes. Results are in the folder that is kept, where complete ones are reused unless the batch is
    `fresh`; else in a temporary folder."""
    if asked.keep is not None:
        run_batch(tasks(scenes, asked.keep, True, not asked.fresh), asked.where, asked.timeout, record)
        return
    with TemporaryDirectory(prefix="mbproj-batch-", ignore_cleanup_errors=True) as folder:
        run_batch(tasks(scenes, Path(folder), keep=False), asked.where, asked.timeout, record)


def _row(result: SceneResult) -> dict[str, object]:
    worst = result.worst
    return {
        "scene": str(result.scene),
        "result": result.word,
        "expectations": len(result.outcomes),
        "hold": sum(outcome.holds for outcome in result.outcomes),
        "seconds": result.seconds,
        "formulation": result.formulation or "",
        "nearest to its limit": "" if worst is None else worst.expectation.name,
        "error": None if worst is None else worst.error,
        "allowed": None if worst is None else worst.expectation.tolerance,
        "message": result.message.partition("\n")[0],
    }


@command_of(batch, EXAMPLES, answer, junit, plot_option)
def command(asked: Asked[Batch], **options: Any) -> int:
    from mbproj.commands.report.junit import junit
    from mbproj.commands.study_report import StudyReport

    wanted = asked.read()
    scenes, study = scene_paths(wanted.paths), StudyReport(options, ("scene", "result"))
    study.write_junit(lambda: junit([]))
    results: dict[int, SceneResult] = {}
    rows = BatchRows([str(scene) for scene in scenes], shown=study.shows_table)

    def record(number: int, result: SceneResult) -> None:
        results[number] = result
        rows.show(results)
        tell("scenes", len(results), len(scenes))

    interrupted = False
    with study.telling(hidden=study.shows_table) as tell:  # the table shows the progress, too
        tell("scenes", 0, len(scenes))
        try:
            _run(wanted, scenes, record)
        except KeyboardInterrupt:
            interrupted = True
    ended = [results[number] for number in sorted(results)]
    code = ExitCode.INTERRUPTED if interrupted else exit_code(ended)
    left = [scene for number, scene in enumerate(scenes) if number not in results]
    study.write_junit(lambda: junit(ended, left))
    rows.finish(results)
    study.hand_over(Batch(tuple(ended)).table, "", _numbers(ended, left, code), lambda: _page(ended))
    for message in _messages(ended):
        click.echo(message, err=True)
    if interrupted:
        click.echo("interrupted", err=True)
    return int(code)


def _page(ended: list[SceneResult]) -> Figure | str:
    """The page with the part of its allowed error that each expectation uses."""
    from mbproj.show.figures.studies import draw_expectations

    judged = [(each.scene, outcome) for each in ended for outcome in each.outcomes]
    shares = {f"{scene}: {outcome.expectation.name}": outcome.share for scene, outcome in judged}
    return draw_expectations(shares) if shares else "no expectation to draw"


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


def _numbers(results: Sequence[SceneResult], left: Sequence[Path], code: ExitCode) -> dict[str, Any]:
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
                **report_of((NOTES,), result),
                "expectations": [outcome_record(outcome) for outcome in result.outcomes],
            }
            for result in results
        ],
    }


def _messages(results: Sequence[SceneResult]) -> Iterator[str]:
    """Yield the full messages of scenes that could not run, and the notes that put a motion in doubt."""
    for result in results:
        yield from (f"{result.scene}: {note}" for note in result.notes if note.doubts_motion)
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
