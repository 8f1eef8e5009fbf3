"""`mbproj schema`: the scene format as a JSON Schema."""

from __future__ import annotations

from pathlib import Path

import click

from mbproj.cli.explained import Part, explained, option
from mbproj.cli.study_options import force as force_option

EXAMPLES = (("Write the schema to a file that an editor can read.", "mbproj schema -o scene.schema.json"),)


@explained("schema", EXAMPLES)
@option(
    Part.OUTPUT,
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Write to FILE instead of stdout.",
)
@force_option
def command(output: Path | None, force: bool) -> None:
    """Prints the JSON Schema of scene files, for checks in an editor.

    The schema is of draft 2020-12. For the YAML language server, begin a scene with:

    \b
      # yaml-language-server: $schema=FILE
    """
    import json

    from mbproj.outputs import SCENE_SCHEMA, make_folder, write_text
    from mbproj.scene.schema import scene_schema

    text = json.dumps(scene_schema(), indent=2, ensure_ascii=False)
    if output is None:
        click.echo(text)
        return
    make_folder(output.parent)
    click.echo(write_text(output, text + "\n", SCENE_SCHEMA, force=force))
