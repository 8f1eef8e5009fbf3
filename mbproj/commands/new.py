"""`mbproj new` and `mbproj.new`: new scene files from templates, of any size."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mbproj.base.errors import Place
from mbproj.commands.kinds import OneOf
from mbproj.commands.options import Part, explained, force_option, option
from mbproj.results.output_files import SCENE, write_text
from mbproj.scene.templates.table import OPTIONS, TEMPLATES, scene_text

if TYPE_CHECKING:
    from mbproj.commands.arguments import Quantity
    from mbproj.scene.scene import Scene

KINDS = tuple(TEMPLATES)
EXAMPLES = (
    ("Write a four-bar linkage with a crank of 80 mm.", 'mbproj new four-bar --crank "80 mm" -o four_bar.yaml'),
    ("Print a spatial chain of 20 bars.", "mbproj new chain --links 20 --spatial"),
)
HELP = f"""Writes a commented scene file, ready to run.

It holds the results that it expects. Numbers take units as in a scene ("300 mm") and become parameters of the scene.
An
existing file is not replaced. KIND is one of:

\b
{chr(10).join(f"  {name:12}  {template.summary}" for name, template in TEMPLATES.items())}
"""


def _options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Decorate the command with an option for each number of the templates."""
    for name, number in reversed(list(OPTIONS.items())):
        metavar = "N" if name in ("links", "loops", "slots") else "NUMBER"
        command = option(Part.WHAT, f"--{name}", metavar=metavar, help=f"{number.help} {_defaults(name)}")(command)
    return command


def _defaults(name: str) -> str:
    """The default of an option, for each template."""
    defaults = {kind: template.defaults[name] for kind, template in TEMPLATES.items() if name in template.defaults}
    if len(set(defaults.values())) == 1:
        return f"[default: {next(iter(defaults.values()))}; {', '.join(defaults)}]"
    return f"[default: {', '.join(f'{kind} {default}' for kind, default in defaults.items())}]"


def new(kind: str, *, spatial: bool = False, **numbers: Quantity) -> Scene:
    """Makes the scene of a template, for example "four-bar", with the numbers of `mbproj new`, in SI units or with a
    unit.

    Raises InputError for an unknown template or number, and for lengths that make no mechanism.
    """
    from mbproj.commands.arguments import by_arguments
    from mbproj.scene.scene import read_scene_text
    from mbproj.scene.text.nodes import flow, from_value

    with by_arguments():
        OneOf(KINDS).of(kind, "kind")
        texts = {name: flow(from_value(value, Place(name))) for name, value in numbers.items()}
        return read_scene_text(scene_text(kind, texts, spatial), kind)


@explained("new", EXAMPLES, help=HELP)
@click.argument("kind", type=OneOf(KINDS), metavar="KIND")
@option(
    Part.OUTPUT,
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Write to FILE instead of stdout.",
)
@_options
@option(Part.WHAT, "--spatial", is_flag=True, help="Give every second joint another axis. [chain, tree]")
@force_option
def command(kind: str, output: Path | None, spatial: bool, force: bool, **numbers: str | None) -> None:
    """`mbproj new`."""
    text = scene_text(kind, {name: number for name, number in numbers.items() if number is not None}, spatial)
    if output is None:
        click.echo(text, nl=False)
        return
    click.echo(write_text(output, text, SCENE, force=force))
