"""`mbproj run`: scene -> system -> consistent start -> simulation -> results file, and a summary."""

from __future__ import annotations

from typing import Any

import click

from mbproj.cli.scene_options import overrides, parameters, scene_options


@click.command("run")
@scene_options
@click.option("-o", "--output", default="results.h5", show_default=True, type=click.Path(), help="Results file.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object instead of the summary.")
@click.option("-q", "--quiet", is_flag=True, help="Print nothing but errors.")
def command(scene: str, settings: tuple[str, ...], output: str, as_json: bool, quiet: bool, **options: Any) -> None:
    """Simulates SCENE and writes a results file."""
    from mbproj.cli.execute import execute
    from mbproj.scene import read_scene

    what = read_scene(scene, parameters(settings), overrides(options))
    execute(what, scene, output, as_json=as_json, quiet=quiet)
