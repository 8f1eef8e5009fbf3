"""`mbproj animate`: a page on which the mechanism moves."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mbproj.base.errors import InputError, Problem
from mbproj.commands.kinds import AnyNumber, Positive
from mbproj.commands.options import File, Part, explained, force_option, option

if TYPE_CHECKING:
    from mbproj.show.page.pages import PageData

#: The endings of scene files; other files are results.
SCENES = (".yaml", ".yml")
PAGES, FILMS = (".html", ".htm"), (".gif", ".mp4")
EXAMPLES = (
    ("Write results.html, which any browser opens offline. modes.h5 works too.", "mbproj animate results.h5"),
    (
        "Lay a run over another, as a ghost.",
        "mbproj animate results.h5 gopm.h5 -o both.html --label gpopm --label gopm",
    ),
    ("Look at the start of a scene that was not run.", "mbproj animate five_bar.yaml"),
)


@explained("animate", EXAMPLES)
@click.argument("sources", metavar="RESULTS...", nargs=-1, required=True, type=File(".h5", *SCENES, path_type=Path))
@option(
    Part.OUTPUT,
    "-o",
    "--output",
    type=File(".html", ".gif", ".mp4", path_type=Path),
    metavar="FILE",
    help="The page, or a film: .gif, .mp4 [default: <first file>.html].",
)
@option(Part.OUTPUT, "--label", "labels", multiple=True, metavar="TEXT", help="Name of a run, once for each RESULTS.")
@option(Part.WHAT, "--from", "start", type=AnyNumber("s"), metavar="T", help="Begin at this time in s.")
@option(Part.WHAT, "--to", "stop", type=AnyNumber("s"), metavar="T", help="End at this time in s.")
@option(Part.WHAT, "--full", is_flag=True, help="Show every sample, not only what 60 frames a second can.")
@option(
    Part.ACCURACY,
    "--error",
    "limit",
    type=Positive("m"),
    metavar="E",
    help="A certified run turns pale where it may be off by E.",
)
@force_option
def command(
    sources: tuple[Path, ...],
    output: Path | None,
    labels: tuple[str, ...],
    start: float | None,
    stop: float | None,
    full: bool,
    limit: float | None,
    force: bool,
) -> None:
    """Writes a page on which the mechanism of RESULTS moves.

    For a file of modes it shows their shapes, for a scene its start. Several results are shown over each other: the
    first solid, the others as ghosts. The page is one file that opens without a network. Its 3D graphics are three.js,
    which comes with the extra: pip install 'mbproj[animate]'. A name in .gif, or .mp4 with ffmpeg, makes a film.
    """
    from mbproj.results.output_files import PAGE, check_replaceable, write_text
    from mbproj.show.page.write import html

    path = output or sources[0].with_suffix(".html")
    ending = path.suffix.lower()
    if ending not in (*PAGES, *FILMS):
        message = f"--output: '{path}' is not the name of a page or film"
        raise InputError(Problem(message, hint="end it in .html, .gif or .mp4"))
    if labels and len(labels) != len(sources):
        message = f"--label: {len(labels)} for {len(sources)} files"
        raise InputError(Problem(message, hint="give one for each file, in their order, or none"))
    if ending in FILMS:
        for name, value in {"--label": labels or None, "--error": limit, "--full": full or None}.items():
            if value is not None:
                raise InputError(Problem(f"{name} is for pages, and '{path}' is a film"))
        click.echo(_film(sources, start, stop, path, force=force))
        return
    check_replaceable(path, PAGE, force=force)
    page = _page(sources, labels, start, stop, full, limit)
    for run in page.data["runs"]:
        for remark in run["remarks"]:
            click.echo(f"note: {run['label']}: {remark}", err=True)
    click.echo(write_text(path, html(page.title, page.data, page.packer), PAGE, force=force))


def _film(sources: Sequence[Path], start: float | None, stop: float | None, path: Path, *, force: bool) -> Path:
    from mbproj.commands.plot import is_linear
    from mbproj.commands.results_shown import open_with_note, selected
    from mbproj.results.output_files import check_replaceable, film
    from mbproj.show.figures.mechanism import save_film

    for source in sources:
        if source.suffix.lower() in SCENES or is_linear(source):
            message = f"a film is of results of runs, and '{source}' is none"
            raise InputError(Problem(message, hint="write a page: end the name in .html"))
    check_replaceable(path, film(path.suffix[1:].lower()), force=force)
    return save_film(selected([open_with_note(source) for source in sources], start, stop), path, force=force)


def _page(
    sources: Sequence[Path],
    labels: Sequence[str],
    start: float | None,
    stop: float | None,
    full: bool,
    limit: float | None,
) -> PageData:
    from mbproj.commands.plot import is_linear
    from mbproj.show.page.pages import page_of, start_of

    if any(map(is_linear, sources)):
        if len(sources) > 1:
            raise InputError(Problem("files of modes are shown one at a time", hint=f"give '{sources[0]}' alone"))
        for name, value in {"--from": start, "--to": stop, "--error": limit, "--full": full or None}.items():
            if value is not None:
                raise InputError(Problem(f"{name} is for results of runs, and '{sources[0]}' is none"))
        from mbproj.show.page.pages import page_of_modes

        return page_of_modes(sources[0], labels[0] if labels else sources[0].stem)
    scenes = [source for source in sources if source.suffix.lower() in SCENES]
    if not scenes:
        from mbproj.commands.results_shown import open_with_note, selected
        from mbproj.show.figures.rows import derive_labels

        results = [open_with_note(path) for path in sources]
        names = list(labels) or derive_labels(results)
        return page_of(selected(results, start, stop), names, full, limit)
    if len(sources) > 1:
        message = f"'{scenes[0]}' is a scene, and scenes are shown alone"
        raise InputError(Problem(message, hint="run it, and give its results"))
    from mbproj.equations.assembly.compiled import compile_system
    from mbproj.linear.equilibrium.start import start_state
    from mbproj.scene.scene import read_scene
    from mbproj.show.appearance.motion import motion_at

    scene = read_scene(str(scenes[0]), {}, {})
    system = compile_system(scene)
    state = start_state(scene, system)
    return start_of(scene, motion_at(system, state.q), scene.title or scenes[0].stem)
