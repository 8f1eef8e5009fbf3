"""Building the page of a scene as it is on the disk: check, run, and make the page."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from datetime import datetime
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

from mbproj.calls.check.checked import assembled, checked
from mbproj.calls.run import record
from mbproj.dynamics import unique_components
from mbproj.ending import ending
from mbproj.errors import InputError, SimulationError
from mbproj.integrate.reporting.report import summary
from mbproj.pages.data.pages import PageData, page_of
from mbproj.results import ResultsWriter, open_own_results
from mbproj.scene import Scene, read_scene, settings_to_run
from mbproj.scene.problem_places import placed_in


class Superseded(Exception):
    """The exception where the scene was saved again while it ran."""


class Built(NamedTuple):
    """The result of a save: a line on it, the page if there is one, the problem, and notes on possible mistakes.
    `files` are the files that the scene was read from, as far as they could be read."""

    line: str
    page: PageData | None
    problem: str = ""
    notes: tuple[str, ...] = ()
    files: tuple[Path, ...] = ()


def build(
    path: Path,
    parameters: Mapping[str, str],
    options: Mapping[str, str],
    folder: Path,
    interrupted: Callable[[], bool],
) -> Built:
    """Read, check and run the scene; results go into `folder`. A run that fails gets a page of its samples so far.
    Raises Superseded as soon as `interrupted` returns True."""
    began, files = perf_counter(), tuple[Path, ...]()
    try:
        what = read_scene(str(path), parameters, options)
        files = (path, *_meshes(what, path.parent))
        page, said, notes, problem = _ran(what, path, folder / f"{path.stem}.h5", interrupted)
    except Superseded:
        raise
    except Exception as error:  # the next save may remove the cause, whatever it is
        message, _ = ending(error)
        return Built(f"{_time()} {path.name}: not run", None, message, files=files)
    return Built(f"{_time()} {path.name}: {said}, {perf_counter() - began:.2f} s", page, problem, notes, files)


def _meshes(what: Scene, folder: Path) -> Iterator[Path]:
    for body in what.bodies:
        if body.appearance is not None and body.appearance.mesh is not None:
            yield folder / body.appearance.mesh.file


def _time() -> str:
    return datetime.now().strftime("%H:%M:%S")


def _ran(
    what: Scene, path: Path, results: Path, interrupted: Callable[[], bool]
) -> tuple[PageData, str, tuple[str, ...], str]:
    """Run the scene; return its page, a line on the run, notes, and the reason why it ended early."""
    settings = settings_to_run(what)
    system, state = assembled(what)
    found = checked(what, system, state)
    if not found.can_run:
        raise InputError(list(found.problems))

    def progress(time: float) -> None:
        if interrupted():
            raise Superseded

    problem, violation = "", ""
    for left in (results, results.with_name(f"{results.name}.part")):  # the writer would check a file that it replaces
        left.unlink(missing_ok=True)
    with placed_in(what):
        unique = unique_components(system, state)
        try:
            with ResultsWriter(results, what, system.names.as_mapping(), unique) as recorder:
                report, _ = record(what, system, state, recorder, progress, None)
                numbers = summary(str(path), str(results), report, total_seconds=0.0)
                recorder.attributes(numbers)
            violation = f", joints closed to {numbers['position_violation_max']:.1e}"
        except SimulationError as error:
            problem, _ = ending(error)
    with open_own_results(results) as opened:
        page = page_of([opened], [path.stem])
        until = float(opened.time[-1])
    freedoms = found.degrees_of_freedom
    free = "" if freedoms is None else f"{freedoms} degree{'s' * (freedoms != 1)} of freedom, "
    said = f"{free}{until:.4g} of {settings.duration:.4g} s{violation}"
    return page, said, tuple(note.line("note") for note in found.notes), problem
