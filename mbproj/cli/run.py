"""`mbproj run`: scene -> system -> consistent start -> simulation -> results file, and a summary."""

from __future__ import annotations

from typing import Any

import click

from mbproj.cli.scene_options import overrides, parameters, scene_options


@click.command("run")
@scene_options
@click.option("-o", "--output", default="results.h5", show_default=True, type=click.Path(), help="Results file.")
@click.option("--certify", is_flag=True, help="Say how long each marker can be trusted, by a better solution.")
@click.option("--limit", "limits", multiple=True, type=float, metavar="E",
              help="With --certify: an error in m to give the time for, repeatable (1e-9, 1e-8, .. 1).")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object instead of the summary.")
@click.option("-q", "--quiet", is_flag=True, help="Print nothing but errors.")
def command(
    scene: str,
    settings: tuple[str, ...],
    output: str,
    certify: bool,
    limits: tuple[float, ...],
    as_json: bool,
    quiet: bool,
    **options: Any,
) -> None:
    """Simulates SCENE and writes a results file."""
    from mbproj.cli.execute import execute
    from mbproj.scene import read_scene

    asked = _limits(certify, limits)
    what = read_scene(scene, parameters(settings), overrides(options))
    execute(what, scene, output, certified=asked, as_json=as_json, quiet=quiet)


def _limits(certify: bool, limits: tuple[float, ...]) -> tuple[float, ...] | None:
    """The limits to certify for, increasing; None where that is not asked for."""
    from mbproj.errors import InputError, Place, Problem

    if limits and not certify:
        raise InputError(Problem("needs --certify", Place("--limit"), "add it, or leave this out"))
    if not all(0.0 < limit < float("inf") for limit in limits):
        raise InputError(Problem("an error to stay below is positive", Place("--limit"), "e.g. --limit 1e-3"))
    if not certify:
        return None
    from mbproj.studies.certify import LIMITS

    return tuple(sorted(set(limits))) or LIMITS
