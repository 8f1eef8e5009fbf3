"""The group of commands, and how an error becomes a message and an exit code."""

from __future__ import annotations

import os
import sys
import warnings
from importlib import import_module
from typing import Any

import click

from mbproj.cli.streams import protect_streams
from mbproj.ending import ending
from mbproj.errors import ExitCode, MbprojWarning
from mbproj.version import __version__

#: Commands in the order of the help; each is the object `command` of the module of its name.
COMMANDS = ("run", "check", "plot", "info", "export", "rerun", "compare", "tradeoff", "threshold", "recommend",
            "verify", "stability", "batch", "compare-results", "help", "new", "paper", "examples", "schema")


class CommandsOnDemand(click.Group):
    """A group that imports a command's module when the command is used or listed."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        command: click.Command = import_module(f"mbproj.cli.{cmd_name.replace('-', '_')}").command
        return command


#: `color`: click drops what looks like a colour where none is shown, and file names with it; `Stream` shows it instead.
SETTINGS = {"help_option_names": ["-h", "--help"], "max_content_width": 120, "color": True}


@click.group(cls=CommandsOnDemand, context_settings=SETTINGS)
@click.version_option(__version__, prog_name="mbproj")
def mbproj() -> None:
    """Simulates constrained spatial mechanisms and shows that every joint stays closed.

    A YAML scene describes bodies and joints; results go to HDF5; plots are drawn from there. First steps:

    \b
      mbproj examples --copy .
      mbproj run five_bar.yaml --projection gpopm
      mbproj plot results.h5
    """


def main() -> None:
    """The entry point: runs a command and exits with a code of `mbproj.errors.ExitCode`."""
    # Matrices here are small: threads would only cost, and results must not depend on their number.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    protect_streams()
    _show_notes()
    sys.exit(int(_exit_code()))


def _exit_code() -> int:
    try:
        code = mbproj.main(standalone_mode=False) or ExitCode.DONE
        sys.stdout.flush()
    except click.ClickException as error:
        error.show()
        return ExitCode.BAD_INPUT
    except (KeyboardInterrupt, click.Abort):
        _complain("interrupted")
        return ExitCode.INTERRUPTED
    except Exception as error:
        message, code = ending(error)
        _complain(message)
    return code


def _show_notes() -> None:
    """What mbproj warns of becomes a line, which --quiet hides; other warnings stay as they are."""
    others = warnings.showwarning

    def show(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
        if not issubclass(category, MbprojWarning):
            others(message, category, *place, **more)
            return
        context = click.get_current_context(silent=True)
        if context is None or not context.params.get("quiet"):
            _complain(f"note: {message}")

    warnings.showwarning = show


def _complain(message: str) -> None:
    click.echo(message, err=True, color=True)
