"""The command line: `mbproj COMMAND`. One command a file, loaded when it is asked for."""

from mbproj.cli.main import main

__all__ = ["main"]
