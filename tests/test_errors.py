"""What ends a command: mistakes of users and machines short of something have a message, faults of ours a report."""

from __future__ import annotations

import errno
import os

import pytest

from mbproj.base.errors import ExitCode, InputError, SimulationError, message_and_code

SHORT = {"too long": "x" * 5000, "a directory": ".", "missing": "no/such"}


@pytest.mark.parametrize("path", SHORT.values(), ids=SHORT)
def test_a_path_that_the_system_refuses_is_the_users(path):
    with pytest.raises(OSError) as caught:
        os.open(path, os.O_WRONLY)
    message, code = message_and_code(caught.value)
    assert (message, code) == (
        f"error: '{path}': {os.strerror(caught.value.errno)}; give another path",
        ExitCode.BAD_INPUT,
    )


def test_a_machine_that_has_run_out_of_something_is_nobodys_fault():
    assert message_and_code(MemoryError())[1] == ExitCode.FAILED
    full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), "out.csv")
    assert message_and_code(full) == (
        "error: 'out.csv': No space left on device; make room, or use another place",
        ExitCode.FAILED,
    )


def test_errors_of_ours_say_themselves_what_they_are():
    assert message_and_code(InputError("wrong")) == ("error: wrong", ExitCode.BAD_INPUT)
    assert message_and_code(SimulationError(1.0, "it broke")) == (
        "error: stopped at t = 1 s: it broke",
        ExitCode.FAILED,
    )


@pytest.mark.parametrize(
    "error", [ValueError("odd"), OverflowError("large"), OSError(errno.EBADF, "bad"), RecursionError("deep")], ids=repr
)
def test_a_fault_of_ours_is_reported_with_where_it_happened(error):
    try:
        raise error
    except Exception as caught:
        message, code = message_and_code(caught)
    assert code == ExitCode.INTERNAL
    assert message.startswith("Traceback (most recent call last):")
    assert "test_errors.py" in message and message.endswith("please report it with the lines above")
