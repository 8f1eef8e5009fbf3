"""run_sweep(): computes the cases that are not in the store yet, and stores each result at once."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from functools import partial
from pathlib import Path
from time import perf_counter
from uuid import uuid4

import numpy as np

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import ExitCode, InputError, MbprojError, SimulationError, message_and_code
from mbproj.base.settings import Settings
from mbproj.motion.interruption import TimeIsUp, time_limit
from mbproj.results.crash_safety import part_path
from mbproj.results.faults import OutputError
from mbproj.scene.records import Expectation
from mbproj.scene.sampling import whole_steps
from mbproj.scene.scene import Scene, SceneText
from mbproj.scene.settings import settings_to_run
from mbproj.studies.case_blocks import FEWEST, CaseBlock, by_arrays, common_values, values_of
from mbproj.studies.measure.solve import Mechanism, measured_run
from mbproj.studies.parallel.hand_out import Where, in_bundles
from mbproj.studies.parallel.workers import OVERDUE
from mbproj.studies.record import record_run
from mbproj.studies.sweep.folder import Folder
from mbproj.studies.sweep.spec import SweepSpec
from mbproj.studies.sweep.store import CaseRow, Status

# --- One case of a sweep ----------------------------------------------------------------------------------------------
# The scene with its values, run and measured. Any error is in its row.


#: After this many blocks in a row without a case that runs in arrays, arrays are not tried any more.
TRIALS = 3
#: The blocks in a row of each sweep of this process without a case that ran in arrays.
in_vain: Counter[int] = Counter()


@dataclass(frozen=True)
class CaseWork:
    """The common data of all cases: the scene; the paths of the varied values; the measures; the longest time (s) of a
    case. `keep` tells which cases keep their results files in `folder`: "none", "failed" or "all"."""

    scene: SceneText
    paths: tuple[str, ...]
    measures: tuple[Expectation, ...]
    timeout: float | None
    keep: str
    folder: Path | None


@dataclass(frozen=True)
class CaseTask:
    """A case: its key, which is the stem of its results file, and its values."""

    key: str
    values: tuple[float | str, ...]


def run_case(work: CaseWork, task: CaseTask) -> CaseRow:
    """Runs a case. Its results file is written under a temporary name, and renamed when it is complete."""
    started = perf_counter()
    try:
        with time_limit(work.timeout):
            row = _run(work, task)
    except TimeIsUp:
        row = CaseRow(Status.TIMEOUT, message=f"stopped: it took longer than {work.timeout:g} s")
    except InputError as error:
        by_the_machine = isinstance(error.__cause__, OSError)  # a full disk, for example: not a fault of the case
        status = Status.CRASHED if by_the_machine else Status.FAILED
        row = CaseRow(status, message="; ".join(problem.line() for problem in error.problems))
    except OutputError as error:
        row = CaseRow(Status.CRASHED, message=str(error))
    except MbprojError as error:
        row = _failed(error)
    except Exception as error:
        message, code = message_and_code(error)
        row = CaseRow(Status.CRASHED if code == ExitCode.FAILED else Status.FAILED, message=message)
    return replace(row, seconds=perf_counter() - started)


def run_cases(work: CaseWork, tasks: Sequence[CaseTask]) -> tuple[CaseRow, ...]:
    """The rows of several cases. They run by arrays where this is supported, with the bits of single runs."""
    sweep = hash((work.scene.text, work.paths, work.measures))
    rows: dict[int, CaseRow] = {}
    if work.keep != "all" and len(tasks) >= FEWEST and in_vain[sweep] < TRIALS:
        rows = _by_arrays(work, tasks)
        in_vain[sweep] = 0 if rows else in_vain[sweep] + 1
    return tuple(rows.get(at) or run_case(work, task) for at, task in enumerate(tasks))


def _by_arrays(work: CaseWork, tasks: Sequence[CaseTask]) -> dict[int, CaseRow]:
    """The rows of the cases that arrays can run to their end, by the cases' numbers."""

    def holds(task: CaseTask, row: CaseRow) -> bool:
        return np.array_equal(run_case(work, task).values, row.values, equal_nan=True)

    return by_arrays(tasks, partial(_run_block, work), holds, lambda task: common_values(work.paths, task.values))


def _run_block(work: CaseWork, tasks: Sequence[CaseTask]) -> list[CaseRow | None]:
    """The rows of the cases of a group; None for cases that must run alone."""
    begun = perf_counter()
    values = values_of([task.values for task in tasks])
    scene = scene_of(work, CaseTask("", tuple(values)))
    block = CaseBlock.of(scene, sparse(settings_to_run(scene), work.measures, counts=False), len(tasks))
    measures, name = block.measures(work.measures, work.timeout), block.compiled.name
    seconds = (perf_counter() - begun) / len(tasks)
    return [
        None if each is None else CaseRow(Status.DONE, each, formulation=name, seconds=seconds, by_arrays=True)
        for each in measures
    ]


def _run(work: CaseWork, task: CaseTask) -> CaseRow:
    scene = scene_of(work, task)
    if work.keep == "all":
        return _recorded(work, task, scene)
    mechanism, settings = Mechanism.of(scene), sparse(settings_to_run(scene), work.measures)
    try:
        samples, report = measured_run(mechanism, settings, work.measures)
    except SimulationError:
        if work.keep != "failed":
            raise
        return _recorded(work, task, scene)
    return CaseRow(Status.DONE, samples.values(settings.duration), formulation=report.formulation)


def scene_of(work: CaseWork, task: CaseTask) -> Scene:
    """The scene with the values of a case. Raises InputError."""
    return work.scene.scene(dict(zip(work.paths, task.values, strict=True)))


def sparse(settings: Settings, measures: Sequence[Expectation], *, counts: bool = True) -> Settings:
    """Return the settings without samples before the end where only that is measured. Where the count of evaluations
    `counts`, a run with error control keeps its samples: they change the count, but not the motion."""
    late = all(each.at == "end" and each.quantity != "energy_drift_relative" for each in measures)
    if late and settings.step is not None:
        return replace(settings, output_step=whole_steps(settings) * settings.step)
    return settings if counts or not late else replace(settings, output_step=settings.duration)


def _failed(error: MbprojError) -> CaseRow:
    if not isinstance(error, SimulationError):
        return CaseRow(Status.FAILED, message=str(error))
    hint = f"; {error.hint}" if error.hint else ""
    return CaseRow(
        Status.FAILED,
        message=f"{error.cause}{hint}",
        time=error.time,
        joint=error.where or "",
        formulation=error.formulation or "",
    )


def _recorded(work: CaseWork, task: CaseTask, scene: Scene) -> CaseRow:
    """The case's row; its results file is written."""
    assert work.folder is not None
    whole, private = work.folder / f"{task.key}.h5", work.folder / f".{task.key}-{uuid4().hex[:8]}.h5"
    try:
        run = record_run(replace(scene, expectations=work.measures), private, attributes={"output": str(whole)})
        values = tuple(np.nan if each.measured is None else float(each.measured[0]) for each in run.outcomes)
        row = CaseRow(Status.DONE, values, formulation=run.report.formulation)
    except SimulationError as error:
        if error.output is None:  # nothing was simulated
            raise
        row = _failed(error)
    except BaseException:
        _remove(private)
        raise
    try:
        private.replace(whole)
    except OSError:
        _remove(private)
        raise
    return replace(row, kept=True)


def _remove(private: Path) -> None:
    private.unlink(missing_ok=True)
    part_path(private).unlink(missing_ok=True)


# --- All cases of a sweep ---------------------------------------------------------------------------------------------


#: A case that does not stop by itself at its time limit is ended after this multiple of the limit plus this time in s.
PATIENCE, GRACE = 2.0, 5.0


@dataclass(frozen=True)
class Progress:
    """The numbers of cases: all of them, those computed now, and those known from before. `failed` are those of both
    that failed, `by_arrays` the computed ones that ran in arrays."""

    whole: int
    computed: int = 0
    reused: int = 0
    failed: int = 0
    by_arrays: int = 0

    @property
    def left(self) -> int:
        """The number of cases still to be computed."""
        return self.whole - self.computed - self.reused


def run_sweep(
    spec: SweepSpec,
    folder: Folder,
    where: Where = None,
    *,
    timeout: float | None = None,
    most_failures: int | None = None,
    retry_failed: bool = False,
    tell: Callable[[Progress], None] = lambda progress: None,
) -> Progress:
    """Runs the missing cases of a sweep, and returns its progress. It ends after more than `most_failures` failed
    cases. A case may take `timeout` s. With `retry_failed` failed cases run again. Raises KeyboardInterrupt after
    SIGINT or SIGTERM, and StoreLost where a row cannot be stored; earlier results stay stored."""
    work = CaseWork(
        spec.scene,
        spec.design.paths,
        spec.measures,
        timeout,
        spec.keep,
        None if spec.keep == "none" else folder.cases.absolute(),
    )
    store = folder.store
    known = {key: row.status for key, row in store.rows() if _is_whole(key, row, spec, folder, retry_failed)}
    tasks = _Missing(spec, known)
    progress = Progress(spec.design.count, 0, tasks.reused, tasks.failed)
    tell(progress)
    hard = None if timeout is None else PATIENCE * timeout + GRACE
    ended = in_bundles(run_case, work, tasks, where, _lost, hard, run_cases)
    try:
        with closing(ended):
            for rows in ended:
                for task, row in rows:
                    store.add(task.key, row)
                failed = sum(row.status != Status.DONE for _, row in rows)
                computed = progress.computed + len(rows)
                progress = Progress(
                    progress.whole,
                    computed,
                    tasks.reused,
                    progress.failed + failed,
                    progress.by_arrays + sum(row.by_arrays for _, row in rows),
                )
                tell(progress)
                if most_failures is not None and progress.failed > most_failures:
                    break
    finally:
        folder.remove_unfinished()
    return progress


def _lost(task: CaseTask, why: str, seconds: float) -> CaseRow:
    """The row of a case whose process was lost, or ended because it did not stop by itself."""
    status = Status.TIMEOUT if why.startswith(OVERDUE) else Status.CRASHED
    return CaseRow(status, message=why, seconds=seconds)


class _Missing(Iterator[CaseTask]):
    """An iterator over the cases that are not known yet, each once. `reused` counts the other cases passed so far,
    `failed` the failed ones of these."""

    def __init__(self, spec: SweepSpec, known: dict[str, Status]) -> None:
        self._spec, self._met = spec, {*known}
        self.reused = self.failed = 0
        numbers: Iterable[int] = range(spec.design.count)
        if known:  # counted first, because the time left depends on the number of missing cases
            states = [(number, known.get(self._key(number))) for number in numbers]
            numbers = [number for number, status in states if status is None]
            self.reused = spec.design.count - len(numbers)
            self.failed = sum(status not in (None, Status.DONE) for _, status in states)
        self._numbers = iter(numbers)

    def __next__(self) -> CaseTask:
        for number in self._numbers:
            key = self._key(number)
            if key not in self._met:
                self._met.add(key)
                return CaseTask(key, self._spec.design.case(number))
            self.reused += 1
        raise StopIteration

    def _key(self, number: int) -> str:
        return self._spec.key_of(self._spec.design.case(number))


def _is_whole(key: str, row: CaseRow, spec: SweepSpec, folder: Folder, retry_failed: bool) -> bool:
    """Whether a case need not run again. A case that was stopped or crashed may reach its end now."""
    if row.status in (Status.TIMEOUT, Status.CRASHED) or (retry_failed and row.status == Status.FAILED):
        return False
    began = row.status == Status.DONE or row.time is not None
    wanted = began and (spec.keep == "all" or (spec.keep == "failed" and row.status == Status.FAILED))
    return not wanted or folder.file_of(key).exists()
