"""The common part of `fit` and `optimise`: their options, their report, their files."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from mbproj.base.errors import ExitCode, InputError, Place, Problem
from mbproj.commands.declared import Asked
from mbproj.commands.kinds import OneOf
from mbproj.commands.options import Argument, FolderPath, Option, Part, output_option, scene_file
from mbproj.results.report_schema.facts import report_of
from mbproj.results.report_schema.studies import DESIGN
from mbproj.scene.ranges import column_of

if TYPE_CHECKING:
    from mbproj.studies.design.run import FoundDesign

#: Searches found the same design where their numbers differ from the best by at most this part of their ranges.
SAME = 1e-4
DIFFERENCES = "differences of runs"


Spec = Annotated["str | Path", Argument(scene_file(path_type=Path))]
Engine = Annotated[
    "str | None",
    Option(
        Part.WHAT,
        "Search method [default: by the kind of goal].",
        OneOf(("least_squares", "slsqp", "cma", "nsga2")),
    ),
]
OUTPUT = output_option(None, FolderPath(path_type=Path), "Directory of the design [default: <spec>-design].", "DIR")


def found(asked: Any, *, fits: bool) -> FoundDesign:
    """The design that the file asks for, as `fit` and `optimise` return it. Raises InputError where the file asks for
    another thing."""
    from mbproj.studies.design.run import find_design
    from mbproj.studies.design.spec import read_spec
    from mbproj.studies.synthesis.spec import is_synthesis

    if is_synthesis(asked.spec):
        hint = f"use: mbproj optimise {asked.spec.name} --topologies all"
        problem = "the file asks for a synthesis, which finds mechanisms"
        raise InputError(Problem(problem, Place(str(asked.spec)), hint))
    spec = read_spec(asked.spec)
    if fits != bool(spec.targets):
        what, other = ("matches nothing", "optimise") if fits else ("has no goal", "fit")
        raise InputError(Problem(f"it {what}", spec.place(), f"use: mbproj {other} {asked.spec}"))
    return find_design(spec, asked.where, engine=asked.engine, fresh=asked.fresh, tell=asked.progress)


def search(asked: Asked[FoundDesign], output: Path | None, options: dict[str, Any]) -> int:
    """Run a command: search, write, report."""
    from mbproj.commands.study_report import StudyReport
    from mbproj.results.output_files import picture
    from mbproj.show.figures.designs import whole_page
    from mbproj.show.figures.style import save
    from mbproj.studies.design.folder import FIRST, DesignFolder, data_to_draw, starts_table

    study = StudyReport(options, FIRST)
    folder = DesignFolder(folder_of(asked, output, "design"), study.force)
    figure = folder.path / "design.png"
    study.check(figure, picture("png"))
    with study.telling() as tell:
        design = asked.result(progress=tell)
    written = [*folder.write(design), save(whole_page(data_to_draw(design)), figure, force=study.force)]
    text = "\n".join(report(design))
    study.hand_over(starts_table(design), text, numbers(design), notes=design.notes, beside=written)
    return int(ExitCode.FAILED if design.searches[0].broken > 0.0 else ExitCode.DONE)


def folder_of(asked: Asked[Any], output: Path | None, kind: str) -> Path:
    """The folder asked for, or one named after the file."""
    spec: Path = asked.given["spec"]
    return output or spec.with_name(f"{spec.stem}-{kind}")


def numbers(design: FoundDesign) -> dict[str, Any]:
    """The design as a dictionary for JSON; NaN and infinity are null."""
    from mbproj.studies.design.folder import signs

    known, by = design.knowledge, signs(design)
    deviation = np.full(len(design.x), np.nan) if known is None else known.deviation
    numbers = zip(design.spec.paths, design.x.tolist(), design.spec.units, deviation.tolist(), strict=True)
    goals, limits = design.spec.goals, (limit.name for limit in design.spec.limits)
    return report_of(
        DESIGN,
        design,
        slopes=slopes_by(design),
        starts=len(design.searches),
        value=design.searches[0].value,
        front=[by * each.goals for each in design.searches if each.goals.size],
        rms=rms(design) if design.spec.targets else None,
        numbers={path: {"value": value, "unit": unit, "deviation": spread} for path, value, unit, spread in numbers},
        goals={goal.measure.name: goal.sign * value for goal, value in zip(goals, design.trial.goals, strict=True)},
        constraints=dict(zip(limits, design.trial.limits, strict=True)),
        unseen=[] if known is None else known.unseen,
    )


def rms(design: FoundDesign) -> float:
    """The root mean square of all residuals, in units of their standard deviations."""
    return float(np.sqrt(np.mean(design.trial.residuals**2)))


def report(design: FoundDesign) -> Iterator[str]:
    """Yield the design in words and a table."""
    from mbproj.commands.report.text import columns

    spec, known = design.spec, design.knowledge
    yield f"{design.engine}, because {design.why}"
    by = slopes_by(design)
    if by is not None:
        yield f"slopes: {by['by']}" + (f", because {by['because']}" if by["because"] else " along each run")
        for name, why in by["apart"].items():
            yield f"slopes of {name}: {DIFFERENCES}, because {why}"
    yield _about_searches(design)
    yield ""
    headings = ["", "value", *([] if known is None else ["±"]), "between", "unit"]
    rows = []
    for k, path in enumerate(spec.paths):
        spread = [] if known is None else ["not seen" if np.isnan(known.deviation[k]) else f"{known.deviation[k]:.1e}"]
        between = f"{spec.low[k]:.6g} and {spec.high[k]:.6g}"
        rows.append([column_of(path), f"{design.x[k]:.10g}", *spread, between, spec.units[k]])
    yield columns(headings, rows)
    yield ""
    for target, off in design.deviations:
        size, most, unit = float(np.sqrt(np.mean(off**2))), np.abs(off).max(), target.unit
        yield f"{target.name}: {len(off)} points, off by {size:.3g} {unit} (rms), {most:.3g} {unit} at most"
    for goal, value in zip(spec.goals, design.trial.goals, strict=True):
        wanted = "smallest" if goal.sign > 0.0 else "largest"
        yield f"{goal.measure.name}: {goal.sign * value:.10g} {goal.measure.unit}, the {wanted} found".replace(
            " ,", ","
        )
    for limit, margin in zip(spec.limits, design.trial.limits, strict=True):
        value = limit.bound - margin if limit.side == "at_most" else limit.bound + margin
        words = {"at_least": "at least", "at_most": "at most", "equals": "equal to"}[limit.side]
        yield f"{limit.name}: {value:.10g} {limit.unit}, to be {words} {limit.bound:.10g}".replace(" ,", ",")


def slopes_by(design: FoundDesign) -> dict[str, Any] | None:
    """The method that gave the search its slopes; None where it used none. `because` is the reason why dual numbers did
    not, `apart` the reason for each measure whose slopes came by another method."""
    if design.differences is None:
        return None
    by = DIFFERENCES if design.differences else "dual numbers"
    return {"by": by, "because": design.differences, "apart": design.why_differences}


def _about_searches(design: FoundDesign) -> str:
    """The number of searches, and of those that reached the best design; or the length of the front."""
    best, near = design.searches[0], SAME * (design.spec.high - design.spec.low)
    if best.goals.size:
        many = f"{len(design.searches)} designs on the front" if len(design.searches) > 1 else "one design on the front"
        return f"{design.runs} runs: {many}; the most balanced one:"
    same = sum(bool(np.all(np.abs(each.end - best.end) <= near)) for each in design.searches)
    failed = sum(not np.isfinite(each.value) for each in design.searches)
    starts = f"{len(design.searches)} starts" + (f" ({design.reused} reused)" if design.reused else "")
    ends = f"{same} came to the best design" + (f", {failed} found none that runs" if failed else "")
    return f"{starts}, {design.runs} runs: {ends}"
