"""The entry point of the command `mbproj`, also as `python -m mbproj`.

Most of a short command's time goes into imports. Ctrl-C ends it there, too, in the words of all commands.
"""

import os
import signal


def _interrupted(number: int, frame: object) -> None:
    os.write(2, b"interrupted\n")
    os._exit(130)


def main() -> None:
    """Import the command line, and run the command."""
    is_usual = signal.getsignal(signal.SIGINT) is signal.default_int_handler  # not so where a shell ignores it
    if is_usual:
        signal.signal(signal.SIGINT, _interrupted)
    from mbproj.commands.main import main as run_command

    if is_usual:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    run_command()


if __name__ == "__main__":
    main()
