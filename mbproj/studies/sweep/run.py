"""run_sweep(): computes the cases that are not in the store yet, and stores each result at once."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import closing

from mbproj.dataclass import dataclass
from mbproj.studies.parallel.bundles import in_bundles
from mbproj.studies.parallel.hand_out import Where
from mbproj.studies.parallel.workers import OVERDUE
from mbproj.studies.sweep.case import CaseTask, CaseWork, run_case, run_cases
from mbproj.studies.sweep.folder import Folder
from mbproj.studies.sweep.row import CaseRow, Keys, Status
from mbproj.studies.sweep.spec import SweepSpec

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
        spec.scene.text,
        str(spec.scene.path),
        spec.design.paths,
        spec.measures,
        timeout,
        spec.keep,
        None if spec.keep == "none" else folder.cases.absolute(),
    )
    keys, store = Keys(spec.scene.whole, spec.design.paths), folder.store
    known = {key: row.status for key, row in store.rows() if _is_whole(key, row, spec, folder, retry_failed)}
    tasks = _Missing(spec, keys, known)
    progress = Progress(spec.design.count, 0, tasks.reused, tasks.failed)
    tell(progress)
    hard = None if timeout is None else PATIENCE * timeout + GRACE
    ended = in_bundles(run_case, work, tasks, where, _lost, hard, run_cases)
    try:
        with closing(ended):
            for rows in ended:
                for task, row in rows:
                    store.add(task.key, dict(zip(spec.design.paths, task.values, strict=True)), row)
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

    def __init__(self, spec: SweepSpec, keys: Keys, known: dict[str, Status]) -> None:
        self._spec, self._keys, self._met = spec, keys, {*known}
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
        return self._keys.of(self._spec.design.case(number))


def _is_whole(key: str, row: CaseRow, spec: SweepSpec, folder: Folder, retry_failed: bool) -> bool:
    """Whether a case need not run again. A case that was stopped or crashed may reach its end now."""
    if row.status in (Status.TIMEOUT, Status.CRASHED) or (retry_failed and row.status == Status.FAILED):
        return False
    began = row.status == Status.DONE or row.time is not None
    wanted = began and (spec.keep == "all" or (spec.keep == "failed" and row.status == Status.FAILED))
    return not wanted or folder.file_of(key).exists()
