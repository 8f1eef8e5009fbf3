"""`mbproj export SCENE --mjcf FILE --urdf FILE`: a scene as models of other formats, with a table of what they lack."""

from __future__ import annotations

from pathlib import Path

import click

from mbproj.errors import ExitCode, InputError, Problem

ANOTHER_FILE = "choose another file"


def export_models(
    scene: Path, settings: tuple[str, ...], models: dict[str, Path], *, strict: bool, as_json: bool, force: bool
) -> ExitCode:
    """Write the scene as these models, by format, all or none, and print their tables.

    Raises InputError where a file may not be replaced, or the scene cannot be assembled."""
    from mbproj.cli.conversion_table import table_json, table_lines
    from mbproj.cli.scene_options import parameters
    from mbproj.formats.export.mjcf import as_mjcf
    from mbproj.formats.export.urdf import as_urdf
    from mbproj.formats.export.written import Written
    from mbproj.formats.mechanism import Same
    from mbproj.outputs import LOOPS, MODEL, check_replaceable, write_text
    from mbproj.scene import read_scene
    from mbproj.version import __version__

    what = read_scene(str(scene), parameters(settings))
    makers = {"mjcf": as_mjcf, "urdf": as_urdf}
    written: dict[str, Written] = {kind: makers[kind](what, __version__) for kind in models}
    files: list[tuple[str, Path, str]] = []
    for kind, path in models.items():
        files.append((kind, path, written[kind].text))
        if written[kind].loops:
            beside = path.with_suffix(".yaml")
            if beside.resolve() == scene.resolve():
                problem = f"the loops of '{path}' belong in '{beside}', which is the scene"
                raise InputError(Problem(problem, hint="give the model another name"))
            files.append(("loops", beside, written[kind].loops))
    for kind, path, _ in files:
        check_replaceable(path, LOOPS if kind == "loops" else MODEL, force=force, hint=ANOTHER_FILE)
    for kind, path, text in files:
        write_text(path, text, LOOPS if kind == "loops" else MODEL, force=force)
    said = [row for each in written.values() for row in each.said]
    if as_json:
        click.echo(table_json(said, files=[str(path) for _, path, _ in files]))
    else:
        for kind, each in written.items():
            everything = f"everything in the scene has its counterpart in the {kind.upper()}"
            for line in table_lines(each.said, everything):
                click.echo(line)
        for _, path, _ in files:
            click.echo(str(path))
    if strict and any(row.same is Same.NO for row in said):
        return ExitCode.CHECK_FAILED
    return ExitCode.DONE
