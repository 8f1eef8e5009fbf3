"""The command line: `mbproj COMMAND`. Each command has a file, which is loaded when the command is used."""

from mbproj.cli.main import COMMANDS, MODULES, main, mbproj

__all__ = ["COMMANDS", "MODULES", "main", "mbproj"]
