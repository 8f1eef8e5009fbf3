"""Running the scenes of a batch in parallel processes, with their expectations checked. Scenes are found from paths. A
process that hangs or dies is replaced, and its scene counts as failed."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import ExitCode, InputError, MbprojError, Problem, SimulationError, message_and_code
from mbproj.results.analysis.expectations import Outcome, outcomes
from mbproj.results.check import check_results
from mbproj.results.crash_safety import part_path
from mbproj.results.notes import Note
from mbproj.results.output_files import make_folder
from mbproj.results.reader import open_results
from mbproj.scene.scene import SceneText
from mbproj.scene.text.document import read_text
from mbproj.studies.parallel.hand_out import Where, in_parallel
from mbproj.studies.record import record_run
from mbproj.studies.store import key_of

#: The attribute of a kept file that identifies everything on which its numbers depend.
KEY = "follows_from"
#: The current folder.
HERE = Path()
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
    """A scene, the file of its results, and whether that file is kept. With `resume` a complete file of the same scene,
    by the same code, is taken as it is."""

    scene: Path
    output: Path
    keep: bool
    resume: bool = False


@dataclass(frozen=True)
class SceneResult:
    """The result of a scene in a batch. `code` is the exit code of the scene alone, `message` the whole error message.
    `outcomes` are those of its expectations, in their order. `seconds` is the time by the clock. `output` is the file
    with its results, `formulation` that of the run; None where there is none. `notes` are on the scene and its run."""

    scene: Path
    code: ExitCode
    message: str
    outcomes: tuple[Outcome, ...]
    seconds: float = 0.0
    output: Path | None = None
    formulation: str | None = None
    notes: tuple[Note, ...] = ()

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


def run_batch(tasks: Sequence[Task], where: Where, timeout: float, done: Callable[[int, SceneResult], None]) -> None:
    """Runs all tasks, and calls `done` with the number and the result of each as it ends.

    A scene that takes longer than `timeout` (s) is stopped. Raises KeyboardInterrupt after SIGINT or SIGTERM. No
    process is left behind.
    """
    for number, result in in_parallel(_in_folder, Path.cwd(), tasks, where, _lost, timeout):
        done(number, result)


def _in_folder(folder: Path, task: Task) -> SceneResult:
    return run_task(task, folder)


def _lost(task: Task, why: str, seconds: float) -> SceneResult:
    """The result of a task whose process died or was stopped. Its recorded part can be read."""
    part = part_path(task.output)
    recorded = part if task.keep and part.exists() else None
    if recorded is not None:
        why += f"; what it has recorded is in '{recorded}'"
    return SceneResult(task.scene, ExitCode.FAILED, why, (), seconds, recorded)


def run_task(task: Task, folder: Path = HERE) -> SceneResult:
    """Runs one scene and checks its expectations. The task's paths are relative to `folder`, wherever this process is.
    Any error is part of the result."""
    started = perf_counter()
    try:
        with _output(task, folder) as output:
            result = _run(task, folder / task.scene, output)
    except MbprojError as error:
        formulation = error.formulation if isinstance(error, SimulationError) else None
        result = SceneResult(task.scene, error.exit_code, str(error), (), formulation=formulation)
    except Exception as error:
        message, code = message_and_code(error)
        result = SceneResult(task.scene, code, message, ())
    recorded = task.output if task.keep and (folder / task.output).exists() else None
    return replace(result, seconds=perf_counter() - started, output=recorded)


@contextmanager
def _output(task: Task, folder: Path) -> Iterator[Path]:
    """The file for the results. A file that is not to be kept is removed. Without the folder of the task, on another
    machine, it is in a temporary folder."""
    output = folder / task.output
    if task.keep or output.parent.is_dir():
        try:
            yield output
        finally:
            if not task.keep:
                output.unlink(missing_ok=True)
        return
    with TemporaryDirectory(prefix="mbproj-batch-") as scratch:
        yield Path(scratch) / task.output.name


def _run(task: Task, path: Path, output: Path) -> SceneResult:
    """Run a scene into `output`, or take the results that are there already."""
    text = SceneText(read_text(path), str(task.scene), task.scene)
    scene, key = text.scene(), key_of(text.whole) if task.keep else ""
    if task.resume and output.exists():
        with suppress(InputError), open_results(output) as results:  # a damaged file is replaced by a new run
            is_of = results.status == "complete" and results.attributes.get(KEY) == key
            if is_of and not check_results(results).faults:
                judged = tuple(outcomes(scene.expectations, results))
                return _ended(task, judged, str(results.attributes["formulation"]), results.notes)
    of_task: dict[str, str] = {"output": str(task.output), **({KEY: key} if task.keep else {})}
    run = record_run(scene, output, attributes=of_task)
    return _ended(task, run.outcomes, run.report.formulation, run.notes)


def _ended(task: Task, judged: tuple[Outcome, ...], formulation: str, notes: tuple[Note, ...]) -> SceneResult:
    code = ExitCode.DONE if all(outcome.holds for outcome in judged) else ExitCode.CHECK_FAILED
    return SceneResult(task.scene, code, "", judged, formulation=formulation, notes=notes)


def scene_paths(paths: Iterable[Path]) -> list[Path]:
    """The scene files that `paths` name: files, patterns (`*`, `?`, `[..]`, `**`: any directories), and directories.
    Not every shell expands patterns. A directory stands for its own *.yaml files, by name, without those of its
    subdirectories.

    The files come in the order of `paths`, each once. Raises InputError for a missing path, and for one without a
    scene.
    """
    listed: list[Path] = []
    problems: list[Problem] = []
    for path in paths:
        if path.is_dir():
            inside = sorted(path.glob("*.yaml"))
            wrong = Problem(f"'{path}' has no *.yaml in it", hint=f"for those below it give '{path}/**/*.yaml'")
        elif not path.exists() and any(letter in str(path) for letter in "*?["):
            root = Path(path.anchor)
            inside = sorted(match for match in root.glob(str(path.relative_to(root))) if match.is_file())
            wrong = Problem(f"no file matches '{path}'", hint="give scene files, or directories of them")
        else:
            inside = [path] if path.exists() else []
            wrong = Problem(f"there is no '{path}'", hint="give scene files, or directories of them")
        problems += [] if inside else [wrong]
        listed += inside
    if problems:
        raise InputError(problems)
    if not listed:
        raise InputError(Problem("no scene is given", hint="give files, folders or patterns"))
    first = {os.path.realpath(path): path for path in reversed(listed)}
    return [path for path in dict.fromkeys(listed) if first[os.path.realpath(path)] == path]


def tasks(scenes: Sequence[Path], directory: Path, keep: bool, resume: bool = False) -> list[Task]:
    """A task for each scene, with a results file in `directory`. Scenes in several directories have their results in
    directories of the same names.

    Raises InputError where a directory cannot be made.
    """
    whole = [Path(os.path.realpath(scene)) for scene in scenes]
    common = Path(os.path.commonpath([path.parent for path in whole]))
    outputs = [directory / path.relative_to(common).with_suffix(".h5") for path in whole]
    counts = Counter(outputs)  # a.yaml and a.yml would have the same results file
    outputs = [
        output.with_name(f"{path.name}.h5") if counts[output] > 1 else output
        for output, path in zip(outputs, whole, strict=True)
    ]
    for output in outputs:
        make_folder(output.parent, "choose another directory")
    return [Task(scene, output, keep, resume) for scene, output in zip(scenes, outputs, strict=True)]
