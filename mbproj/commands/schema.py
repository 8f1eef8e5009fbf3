"""`mbproj schema` and `mbproj.schema`: the scene format, or what --json prints, as a JSON Schema."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import click

from mbproj.commands.declared import Asked, command_of, declared, read
from mbproj.commands.kinds import OneOf
from mbproj.commands.options import Option, Part, force_option, output_option
from mbproj.results.report_schema.reports import REPORTS, report_schema

EXAMPLES = (
    ("Write the schema to a file that an editor can read.", "mbproj schema -o scene.schema.json"),
    ("Say what `mbproj run --json` prints: keys, units and meaning.", "mbproj schema --of run"),
)
Of = Annotated[
    str,
    Option(
        Part.WHAT,
        f"Describe scene files, or what a command prints with --json: {', '.join(REPORTS)}.",
        OneOf(["scene", *REPORTS]),
        "NAME",
    ),
]


@declared
def schema(of: Of = "scene") -> dict[str, Any]:
    """Prints the JSON Schema of scene files, or of a report.

    The schema is of draft 2020-12. An editor checks scenes by it. For the YAML language server, begin a scene with:

    \b
      # yaml-language-server: $schema=FILE

    In Python it returns the schema. Raises InputError for an unknown name.
    """
    from mbproj.scene.schema import scene_schema

    name = read(schema, locals()).of
    return scene_schema() if name == "scene" else report_schema(name)


OUTPUT = output_option(None, click.Path(path_type=Path), "Write to FILE instead of stdout.", "FILE")


@command_of(schema, EXAMPLES, OUTPUT, force_option)
def command(asked: Asked[dict[str, Any]], output: Path | None, force: bool) -> None:
    import json

    from mbproj.results.output_files import SCHEMA, make_folder, write_text

    text = json.dumps(asked.result(), indent=2, ensure_ascii=False)
    if output is None:
        click.echo(text)
        return
    make_folder(output.parent)
    click.echo(write_text(output, text + "\n", SCHEMA, force=force))
