"""`mbproj optimise` and `mbproj.optimise`: numbers of a scene that make a measure as small or as large as possible."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mbproj.base.errors import ExitCode, InputError, Place, Problem
from mbproj.commands.declared import Asked, command_of, declared, read
from mbproj.commands.design_command import OUTPUT, Engine, Spec, folder_of, found, search
from mbproj.commands.figure_options import look
from mbproj.commands.kinds import Names
from mbproj.commands.options import Part, option
from mbproj.commands.study_options import FreshWork, answer

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from mbproj.studies.design.run import FoundDesign
    from mbproj.studies.synthesis.synthesise import Synthesis

EXAMPLES = (
    ("Find the smallest bearing load that the constraints allow.", "mbproj optimise load.yaml"),
    ("The same by quadratic programs, whatever the goal.", "mbproj optimise load.yaml --engine slsqp"),
    (
        "Find a mechanism that carries a body through places.",
        "mbproj optimise carry.yaml --topologies four_bar,slider_crank",
    ),
)
ALL = "all"
#: The first headings of the table of topologies.
FIRST = ("topology", "rms")


@declared
def optimise(spec: Spec, *, engine: Engine = None, **effort: Unpack[FreshWork]) -> FoundDesign:
    """Finds the numbers of a scene that make a measure smallest or largest.

    SPEC is a YAML file: a scene, what varies within which bounds, what is minimised or maximised, and subject to what.
    Writes best.yaml, starts.csv and design.png into DIR.

    With --topologies it finds mechanisms. SPEC names the path of a point, a function of the crank's angle, or positions
    of a body. Writes best.yaml, topologies.csv and designs.html.

    Exit code 0: done; 2: wrong input, or no design runs; 3: no design keeps the constraints.

    In Python all else is as in `fit`.
    """
    return found(read(optimise, locals()), fits=False)


TOPOLOGIES = option(
    Part.WHAT,
    "--topologies",
    type=Names(),
    metavar="A,B,..",
    help="Some of four_bar, slider_crank, watt, stephenson, spatial_four_bar; or all.",
)


@command_of(optimise, EXAMPLES, answer, TOPOLOGIES, OUTPUT, look)
def command(asked: Asked[FoundDesign], topologies: tuple[str, ...] | None, output: Path | None, **options: Any) -> int:
    if topologies is not None:
        return synthesise_of(topologies, asked, output, options)
    return search(asked, output, options)


def synthesise_of(
    topologies: tuple[str, ...], asked: Asked[FoundDesign], output: Path | None, options: dict[str, Any]
) -> int:
    """Run the command: read, search, write, report."""
    from mbproj.commands.study_report import OTHER_FOLDER, StudyReport
    from mbproj.results.output_files import DESIGNED, PAGE, csv, make_folder, write_text
    from mbproj.results.table_files import write_csv
    from mbproj.show.page.write import designs_page
    from mbproj.studies.design.folder import best_scene
    from mbproj.studies.synthesis.spec import read_wanted
    from mbproj.studies.synthesis.synthesise import page_data, synthesise, table

    given, study = asked.read(), StudyReport(options, FIRST)
    if given.engine is not None:
        raise InputError(Problem("topologies are brought down by least squares", Place("--engine"), "leave it out"))
    wanted = read_wanted(given.spec)
    folder = make_folder(folder_of(asked, output, "topologies"), OTHER_FOLDER)
    best, rows, page = (folder / name for name in ("best.yaml", "topologies.csv", "designs.html"))
    for path, kind in ((best, DESIGNED), (rows, csv(FIRST)), (page, PAGE)):
        study.check(path, kind)
    names = () if topologies == (ALL,) else topologies
    with study.telling() as tell:
        synthesis = synthesise(wanted, names, folder, given.where, fresh=given.fresh, force=study.force, tell=tell)
    design, listed = synthesis.topologies[0].design, table(synthesis)
    assert design is not None
    title = f"{wanted.kind} of {given.spec.name}"
    written = [
        write_text(best, best_scene(design), DESIGNED, force=study.force, hint=OTHER_FOLDER),
        write_csv(rows, listed.headings, listed.rows, force=study.force, hint=OTHER_FOLDER),
        write_text(page, designs_page(title, page_data(synthesis)), PAGE, force=study.force, hint=OTHER_FOLDER),
    ]
    numbers = {"best": synthesis.topologies[0].topology, "topologies": listed.records}
    study.hand_over(listed, "\n".join(report(synthesis)), numbers, beside=written)
    return int(ExitCode.DONE)


def report(synthesis: Synthesis) -> Iterator[str]:
    """Yield the topologies as a table, and the chosen one."""
    from mbproj.commands.report.text import columns

    unit = "rad" if synthesis.wanted.kind == "function" else "m"
    yield f"{synthesis.topologies[0].topology} does it with the fewest bodies of those that are as good as the best"
    yield ""
    rows = [
        [each.topology, str(each.bodies), "-" if each.design is None else f"{each.rms:.3g}", each.cause]
        for each in synthesis.topologies
    ]
    yield columns(["topology", "bodies", f"off by ({unit}, rms)", ""], rows)
