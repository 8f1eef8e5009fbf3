"""The options of commands that draw: the look of pictures, as a document asks for it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

from mbproj.base.errors import InputError, Place, Problem, placed_at
from mbproj.commands.options import File, Millimetres, Part, option

Command = TypeVar("Command", bound=Callable[..., Any])
FORMATS = (".png", ".svg", ".pdf")


def _with_look(**asked: Any) -> None:
    """Give the command's pictures this look until the command ends."""
    from mbproj.show.figures.style import figure_style

    sheets = asked.pop("sheets", ())
    click.get_current_context().with_resource(figure_style(*sheets, **asked))


def _sheets(ctx: click.Context, param: click.Parameter, given: tuple[str, ...]) -> None:
    if given:
        _with_look(sheets=given)


def _size(ctx: click.Context, param: click.Parameter, given: tuple[float, ...] | None) -> None:
    if given is not None:
        _with_look(size=given)


def _font(ctx: click.Context, param: click.Parameter, given: str | None) -> None:
    if given is not None:
        _with_look(font=given)


def look(command: Command) -> Command:
    """Decorate a command with --style, --size and --font, which apply to all its pictures."""
    own: dict[str, Any] = {"expose_value": False}
    text = "Name of a font that is installed: the document's, in mathematics too."
    command = option(Part.OUTPUT, "--font", metavar="NAME", help=text, callback=_font, **own)(command)
    text = "Width of a picture in mm, or width and height: 85,60 [default: 160]."
    own_size: dict[str, Any] = {"type": Millimetres(), "callback": _size}
    command = option(Part.OUTPUT, "--size", metavar="W[,H]", help=text, **own, **own_size)(command)
    text = "Style sheet of Matplotlib: FILE.mplstyle, or the name of one of its own; repeatable."
    return option(Part.OUTPUT, "--style", multiple=True, metavar="SHEET", help=text, callback=_sheets, **own)(command)


def plot_option(command: Command) -> Command:
    """Decorate a command that draws one picture with --plot (`picture_path`) and the options of its look."""
    own: dict[str, Any] = {"type": File(*FORMATS, path_type=Path), "help": "Picture, .png, .svg or .pdf."}
    return option(Part.OUTPUT, "--plot", "picture_path", **own)(look(command))


def check_picture(path: Path | None, *, force: bool, option: str = "--plot") -> None:
    """Raises InputError where the option names no picture, or a file that cannot or may not be written."""
    from mbproj.results.output_files import check_replaceable, picture

    if path is None:
        return
    if path.suffix not in FORMATS:
        message = f"'{path}' has no ending of a picture"
        raise InputError(Problem(message, Place(option), f"end it in {', '.join(FORMATS)}"))
    with placed_at(Place(option)):
        check_replaceable(path, picture(path.suffix[1:]), force=force, hint=f"choose another with {option}")
