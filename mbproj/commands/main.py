"""The group of commands, and the conversion of errors to messages and exit codes."""

from __future__ import annotations

import gc
import os
import signal
import sys
import warnings
from collections.abc import Mapping
from contextlib import suppress
from types import MappingProxyType
from typing import Any

import click

from mbproj.base.errors import ExitCode, MbprojWarning, message_and_code
from mbproj.base.version import __version__
from mbproj.commands.streams import protect_streams

#: The commands by their purpose, with a line on each. Each is the object `command` of the module of its name.
GROUPS: Mapping[str, Mapping[str, str]] = MappingProxyType(
    {
        "Simulate": {
            "run": "Simulates a scene and writes its results.",
            "rerun": "Repeats a run from its results file.",
            "continue": "Goes on with a run from its results file.",
            "loads": "Finds the forces that a given motion takes.",
        },
        "Look": {
            "check": "Says whether a scene closes and can run.",
            "branches": "Finds all assemblies of a mechanism.",
            "plot": "Draws pictures of results.",
            "animate": "Shows the mechanism moving, in a browser.",
            "watch": "Runs a scene at each save, and shows it moving.",
            "info": "Says what a results file holds.",
            "export": "Writes results as CSV tables, a scene as MJCF or URDF.",
        },
        "Judge": {
            "verify": "Checks the paper's mathematics on a scene.",
            "stability": "Finds where each projection method fails.",
            "compare-results": "Says whether two results are the same motion.",
        },
        "Linearise": {
            "equilibrium": "Finds where a mechanism rests or turns steadily.",
            "modes": "Finds the frequencies and shapes of small motions.",
            "linearize": "Writes the linear model from inputs to outputs.",
        },
        "Choose a setting": {
            "recommend": "Finds the cheapest setting that keeps the error below a goal.",
            "compare": "Puts methods on one scene side by side.",
            "tradeoff": "Measures accuracy against cost on a scene.",
            "threshold": "Finds from which violation on to project.",
        },
        "Design": {
            "sensitivity": "Measures how much numbers change results.",
            "fit": "Fits numbers of a scene to measurements.",
            "optimise": "Finds the numbers that serve a goal best.",
            "curve": "Shows a cam's profile and what limits it.",
        },
        "Automate": {
            "batch": "Runs many scenes and checks what they expect.",
            "sweep": "Runs a family of mechanisms and tabulates it.",
            "schema": "Prints the JSON Schema of scenes or of reports.",
        },
        "Learn": {
            "help": "Shows and searches the pages of the guide.",
            "examples": "Lists or copies the example mechanisms.",
            "new": "Writes a scene to begin with.",
            "import": "Makes a scene of a model in MJCF, URDF or SDF.",
            "paper": "Draws the figures of Zhang, Liu & Liu (2015).",
        },
    }
)
COMMANDS = tuple(name for names in GROUPS.values() for name in names)
#: The modules of commands that have other names.
MODULES = {"continue": "continue_run", "import": "import_model"}


class CommandsOnDemand(click.Group):
    """A group that imports a command's module when the command is used or listed."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        from mbproj.base.registry import load

        command: click.Command = load(f"mbproj.commands.{MODULES.get(cmd_name, cmd_name.replace('-', '_'))}:command")
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the groups of commands, without an import of any."""
        for title, commands in GROUPS.items():
            with formatter.section(title):
                formatter.write_dl([(f"{name:15}", summary) for name, summary in commands.items()])


#: Without `color`, click would drop colour codes, and parts of file names that look like them. `Stream` escapes them
#: instead.
SETTINGS = {"help_option_names": ["-h", "--help"], "max_content_width": 120, "color": True}


@click.group(cls=CommandsOnDemand, context_settings=SETTINGS)
@click.version_option(__version__, prog_name="mbproj")
def mbproj() -> None:
    """Simulates constrained spatial mechanisms and shows that every joint stays closed.

    A YAML scene describes bodies and joints; results go to HDF5; plots are drawn from there. First steps:

    \b
      mbproj help getting_started
      mbproj examples --copy .
      mbproj run five_bar.yaml
      mbproj plot results.h5
    """


def main() -> None:
    """Run a command and exit with a code of `mbproj.base.errors.ExitCode`: the entry point."""
    # The matrices are small: threads would only cost time, and results must not depend on their number.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    # Pictures go into files, so no screen backend is needed; Matplotlib would stop at an unknown one.
    os.environ.pop("MPLBACKEND", None)
    # The garbage collector would search all imported objects dozens of times: 6 % of a short run.
    gc.set_threshold(50_000)
    protect_streams()
    _show_notes()
    _handle_lost_interruptions()
    code = _exit_code()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Python's own end would be interrupted with a traceback
    if code == ExitCode.INTERRUPTED:
        _exit_interrupted()
    sys.exit(int(code))


def _exit_interrupted() -> None:
    """End an interrupted command at once, without Python's wait for threads."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with suppress(OSError):
        sys.stdout.flush()
        sys.stderr.flush()
    os._exit(ExitCode.INTERRUPTED)


def _handle_lost_interruptions() -> None:
    """End the command also where Ctrl-C meets Python in a callback, for example of a weak reference. Python does not
    raise it there."""
    others = sys.unraisablehook

    def end(unraisable: Any) -> None:
        if not issubclass(unraisable.exc_type, KeyboardInterrupt):
            others(unraisable)
            return
        _complain("interrupted")
        _exit_interrupted()

    sys.unraisablehook = end


def _exit_code() -> int:
    try:
        code = mbproj.main(prog_name="mbproj", standalone_mode=False) or ExitCode.DONE
        sys.stdout.flush()
    except click.ClickException as error:
        error.show()
        return ExitCode.BAD_INPUT
    except (KeyboardInterrupt, click.Abort):
        _complain("interrupted")
        return ExitCode.INTERRUPTED
    except Exception as error:
        if _comes_from_an_interruption(error):
            _complain("interrupted")
            return ExitCode.INTERRUPTED
        message, code = message_and_code(error)
        _complain(message)
    return code


def _comes_from_an_interruption(error: BaseException | None) -> bool:
    """Whether Ctrl-C is behind an error: compiled code that calls back, as h5py's iteration, ends in a SystemError."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    return error is not None


def _show_notes() -> None:
    """Show mbproj's warnings as a line on stderr, unless --quiet is given; other warnings stay as they are."""
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
