"""The options of commands that draw: the look of the pictures, as a document has it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import click

from mbproj.cli.explained import Part, option
from mbproj.cli.quantity import Millimetres

Command = TypeVar("Command", bound=Callable[..., Any])


def _looks(**asked: Any) -> None:
    """The command's pictures have this look, to its end."""
    from mbproj.figures.style import figure_style

    sheets = asked.pop("sheets", ())
    click.get_current_context().with_resource(figure_style(*sheets, **asked))


def _sheets(ctx: click.Context, param: click.Parameter, given: tuple[str, ...]) -> None:
    if given:
        _looks(sheets=given)


def _size(ctx: click.Context, param: click.Parameter, given: tuple[float, ...] | None) -> None:
    if given is not None:
        _looks(size=given)


def _font(ctx: click.Context, param: click.Parameter, given: str | None) -> None:
    if given is not None:
        _looks(font=given)


def look(command: Command) -> Command:
    """The options --style, --size and --font, which hold for all pictures of the command."""
    own: dict[str, Any] = {"expose_value": False}
    text = "Name of a font that is installed: the document's, in mathematics too."
    command = option(Part.OUTPUT, "--font", metavar="NAME", help=text, callback=_font, **own)(command)
    text = "Width of a picture in mm, or width and height: 85,60 [default: 160]."
    own_size: dict[str, Any] = {"type": Millimetres(), "callback": _size}
    command = option(Part.OUTPUT, "--size", metavar="W[,H]", help=text, **own, **own_size)(command)
    text = "Style sheet of Matplotlib: FILE.mplstyle, or the name of one of its own; repeatable."
    return option(Part.OUTPUT, "--style", multiple=True, metavar="SHEET", help=text, callback=_sheets, **own)(command)
