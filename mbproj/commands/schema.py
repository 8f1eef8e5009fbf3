"""`mbproj schema`: the scene format, or what --json prints, as a JSON Schema."""

from __future__ import annotations

from pathlib import Path

import click

from mbproj.commands.options import Part, explained, option
from mbproj.commands.study_options import force as force_option
from mbproj.results.report_schema.reports import REPORTS, report_schema

EXAMPLES = (
    ("Write the schema to a file that an editor can read.", "mbproj schema -o scene.schema.json"),
    ("Say what `mbproj run --json` prints: keys, units and meaning.", "mbproj schema --of run"),
)


@explained("schema", EXAMPLES)
@option(
    Part.WHAT,
    "--of",
    type=click.Choice(["scene", *REPORTS]),
    default="scene",
    show_default=True,
    metavar="NAME",
    help=f"Describe scene files, or what a command prints with --json: {', '.join(REPORTS)}.",
)
@option(
    Part.OUTPUT,
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Write to FILE instead of stdout.",
)
@force_option
def command(of: str, output: Path | None, force: bool) -> None:
    """Prints the JSON Schema of scene files, or of a report.

    The schema is of draft 2020-12. An editor checks scenes by it. For the YAML language server, begin a scene with:

    \b
      # yaml-language-server: $schema=FILE
    """
    import json

    from mbproj.results.output_files import SCHEMA, make_folder, write_text
    from mbproj.scene.schema import scene_schema

    text = json.dumps(scene_schema() if of == "scene" else report_schema(of), indent=2, ensure_ascii=False)
    if output is None:
        click.echo(text)
        return
    make_folder(output.parent)
    click.echo(write_text(output, text + "\n", SCHEMA, force=force))
