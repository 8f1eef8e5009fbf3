"""`mbproj schema`: the scene format as a JSON Schema."""

from __future__ import annotations

from pathlib import Path

import click

from mbproj.errors import InputError, Problem


@click.command("schema")
@click.option("-o", "--output", type=click.Path(path_type=Path), metavar="FILE", help="Write it there, not to stdout.")
def command(output: Path | None) -> None:
    """Prints the JSON Schema (draft 2020-12) of scene files, with which an editor completes and checks them.

    For the YAML language server, begin a scene with:

    \b
      # yaml-language-server: $schema=FILE
    """
    import json

    from mbproj.scene.schema import scene_schema

    text = json.dumps(scene_schema(), indent=2, ensure_ascii=False)
    if output is None:
        click.echo(text)
        return
    try:
        output.parent.mkdir(parents=True, exist_ok=True)
        output.write_text(text + "\n", encoding="utf-8")
    except OSError as error:
        problem = Problem(f"cannot write '{output}': {error.strerror or error}", hint="choose another file with -o")
        raise InputError(problem) from error
    click.echo(output)
