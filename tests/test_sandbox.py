"""What a reader is about to do is done in a child first; one that spins, crashes or takes all memory is an error."""

from __future__ import annotations

import os
import signal
import time

import pytest

from mbproj.base import sandbox
from mbproj.base.errors import InputError, Problem
from mbproj.base.sandbox import try_in_sandbox


@pytest.fixture
def path(tmp_path):
    found = tmp_path / "out.h5"
    found.write_bytes(b"any")
    return found


def spin() -> None:
    while True:
        pass


def sleep() -> None:
    signal.pause()


def crash() -> None:
    os.kill(os.getpid(), signal.SIGSEGV)


def take_memory() -> None:
    bytearray(2**33)


@pytest.mark.parametrize(
    ("act", "what"),
    [
        (spin, "reading it does not come to an end"),
        (sleep, "reading it does not come to an end"),
        (crash, "HDF5 crashes on it"),
        (take_memory, "reading it takes too much memory"),
    ],
)
def test_what_does_not_end_well_is_damage(path, monkeypatch, act, what):
    fork, children = os.fork, list[int]()

    def noted() -> int:
        child = fork()
        children.append(child)
        return child

    monkeypatch.setattr(os, "fork", noted)
    monkeypatch.setattr(sandbox, "SECONDS", 1)
    monkeypatch.setattr(sandbox, "PATIENCE", 1.0 if act is sleep else 60.0)
    with pytest.raises(InputError) as caught:
        try_in_sandbox(act, path)
    assert str(caught.value) == f"error: '{path}' is damaged: {what}; repeat the run"
    (child,) = children
    with pytest.raises(ChildProcessError):  # it is gone, and has been waited for
        os.waitpid(child, os.WNOHANG)


def test_an_input_error_comes_through_with_its_next_step(path):
    def refuse() -> None:
        raise InputError([Problem("wrong äöü", hint="mend it"), Problem("this too")])

    with pytest.raises(InputError) as caught:
        try_in_sandbox(refuse, path)
    assert str(caught.value) == "error: wrong äöü; mend it\nerror: this too"


def test_a_slow_computer_is_no_damage(path, monkeypatch):
    """A child that gets little of the processor is waited for as long as its own clock moves, and a processor that
    computes slowly has more time."""

    def slowly() -> None:
        end = time.monotonic() + 0.5
        while time.monotonic() < end:
            time.sleep(0.01)

    monkeypatch.setattr(sandbox, "PATIENCE", 0.1)
    assert try_in_sandbox(slowly, path)
    monkeypatch.setattr(sandbox, "PATIENCE", 60.0)
    limits: list[int] = []
    monkeypatch.setattr(sandbox, "_lower", lambda kind, limit: limits.append(limit))
    monkeypatch.setattr(sandbox, "SECONDS", 2)
    monkeypatch.setattr(sandbox, "USUAL", 1e-9)  # so that this processor is a slow one
    sandbox._limit(0)
    assert limits[0] > 100


def test_what_was_read_without_fault_is_not_read_again(path, monkeypatch):
    fork, children = os.fork, list[int]()

    def noted() -> int:
        children.append(0)
        return fork()

    monkeypatch.setattr(os, "fork", noted)
    monkeypatch.setattr(sandbox, "SETTLED", 0.01)
    time.sleep(0.05)
    for name in ("parts", "parts", "others", "", ""):
        assert try_in_sandbox(lambda: None, path, name)
    assert len(children) == 4
    path.write_bytes(b"new")  # of the same size, and changed just now: not remembered
    monkeypatch.setattr(sandbox, "SETTLED", 60.0)
    for _ in range(2):
        assert try_in_sandbox(lambda: None, path, "parts")
    assert len(children) == 6


def test_nothing_is_changed_here(path):
    """What the child does stays in the child, and a fault of ours is left to the reader itself."""
    seen: list[int] = []
    try_in_sandbox(lambda: seen.append(1), path)
    try_in_sandbox(lambda: 1 / 0, path)
    assert seen == []
