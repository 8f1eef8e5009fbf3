"""`mbproj watch`: check, run and show a scene again at each save."""

from __future__ import annotations

import webbrowser
from pathlib import Path
from typing import Any

import click

from mbproj.cli.explained import Part, explained, option
from mbproj.cli.scene_options import overrides, parameters, scene_options
from mbproj.errors import InputError, Place, Problem

EXAMPLES = (
    ("Print the address of a page that follows the file.", "mbproj watch five_bar.yaml"),
    ("Open it in the browser at once, and show the first second.", "mbproj watch five_bar.yaml --open --duration 1"),
)


@explained("watch", EXAMPLES)
@scene_options
@option(Part.OUTPUT, "--open", "opened", is_flag=True, help="Open the page in the browser.")
@option(
    Part.OUTPUT,
    "--port",
    type=click.IntRange(0, 65535),
    default=0,
    metavar="N",
    help="Port on this machine [default: a free one].",
)
@option(Part.OUTPUT, "-q", "--quiet", is_flag=True, help="Print the address and what is wrong, no line at each save.")
def command(scene: str, settings: tuple[str, ...], opened: bool, port: int, quiet: bool, **options: Any) -> None:
    """Runs SCENE each time it is saved, and shows it moving, until Ctrl-C.

    The page is served to this machine alone, at an address with a secret token. It keeps time and camera. Where the
    scene cannot be read or run, the last page stays, with the reason. Extra: pip install 'mbproj[animate]'.
    """
    from mbproj.cli.watch.follow import follow
    from mbproj.cli.watch.server import Board, Server

    path = Path(scene)
    if not path.is_file():
        raise InputError(Problem(f"'{scene}' is no file that can be watched", hint="give the file of a scene"))
    board = Board()
    try:
        server = Server(board, port)
    except OSError as error:
        raise InputError(Problem(f"port {port} cannot be used: {error.strerror}", Place("--port"))) from error
    try:
        click.echo(server.address)
        if opened:
            webbrowser.open(server.address)
        follow(path, parameters(settings), overrides(options), board, quiet=quiet)
    finally:
        server.close()
