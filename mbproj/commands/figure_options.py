"""The options of commands that draw: the look of pictures, as a document asks for it."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import click

from mbproj.base.errors import InputError, Place, Problem, placed_at
from mbproj.commands.kinds import Millimetres
from mbproj.commands.options import File, Part, option

Command = TypeVar("Command", bound=Callable[..., Any])
FORMATS = (".png", ".svg", ".pdf")


def _with_look(**asked: Any) -> None:
    """Give the command's pictures this look until the command ends."""
    from mbproj.show.figures.style import figure_style

    sheets = asked.pop("sheets", ())
    click.get_current_context().with_resource(figure_style(*sheets, **asked))


def _sheets(ctx: click.Context, param: click.Parameter, sheets: tuple[str, ...]) -> None:
    if sheets:
        _with_look(sheets=sheets)


def _size(ctx: click.Context, param: click.Parameter, size: tuple[float, ...] | None) -> None:
    if size is not None:
        _with_look(size=size)


def _font(ctx: click.Context, param: click.Parameter, font: str | None) -> None:
    if font is not None:
        _with_look(font=font)


def look(command: Command) -> Command:
    """Decorate a command with --style, --size and --font, which apply to all its pictures."""
    look_option = partial(option, Part.OUTPUT, expose_value=False)
    text = "Name of a font that is installed: the document's, in mathematics too."
    command = look_option("--font", metavar="NAME", help=text, callback=_font)(command)
    text = "Width of a picture in mm, or width and height: 85,60 [default: 160]."
    command = look_option("--size", metavar="W[,H]", help=text, type=Millimetres(), callback=_size)(command)
    text = "Style sheet of Matplotlib: FILE.mplstyle, or the name of one of its own; repeatable."
    return look_option("--style", multiple=True, metavar="SHEET", help=text, callback=_sheets)(command)


def plot_option(command: Command) -> Command:
    """Decorate a command that draws one picture with --plot (`picture_path`) and the options of its look."""
    kind, text = File(*FORMATS, path_type=Path), "Picture, .png, .svg or .pdf."
    return option(Part.OUTPUT, "--plot", "picture_path", type=kind, help=text)(look(command))


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
