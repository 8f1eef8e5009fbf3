"""What a command says of its progress: by a clock of the test's own."""

from __future__ import annotations

import io
from itertools import pairwise

import pytest

from mbproj.cli.main import mbproj
from mbproj.cli.report import progress
from mbproj.cli.report.progress import Line, Telling
from mbproj.studies import TIMING, with_words
from tests.cli.commands import FIVE_BAR
from tests.cli.report.watched import Clock, Terminal
from tests.crossed import full


def told(*events: tuple[float, str, int, int]) -> list[str]:
    """What a terminal shows after each (time, phase, done, whole)."""
    clock, stream = Clock(), Terminal()
    tell = Telling(Line(stream, clock), clock)
    for time, *what in events:
        clock.now = 100.0 + time
        tell(*what)  # type: ignore[arg-type]
    return [text.removesuffix("\x1b[K") for text in stream.getvalue().split("\r")[1:]]


def test_words_on_a_phase_stand_behind_what_is_done() -> None:
    shown = told((0.0, "searches", 0, 3), (2.0, with_words("searches", "best load 5 N"), 1, 3))
    assert shown == ["searches: 0 of 3, 0 s so far", "searches: 1 of 3, best load 5 N, 2 s so far"]


def test_what_is_piped_gets_a_line_now_and_then() -> None:
    clock, stream = Clock(), io.StringIO()
    line = Line(stream, clock)
    tell = Telling(line, clock)
    for second in range(200):
        clock.now = 100.0 + second
        if second % 50 == 0:
            tell("runs", second // 50, 4)
        line.tick()
    assert stream.getvalue().splitlines() == [
        "runs: 0 of 4, 30 s so far",
        "runs: 1 of 4, 60 s so far",
        "runs: 1 of 4, 90 s so far",
        "runs: 2 of 4, 2.0 min so far",
        "runs: 3 of 4, 2.5 min so far",
        "runs: 3 of 4, 3.0 min so far",
    ]


def test_a_short_command_says_nothing_where_it_is_piped() -> None:
    clock, stream = Clock(), io.StringIO()
    line = Line(stream, clock)
    for second in range(29):
        clock.now = 100.0 + second
        line.say("reference")
    line.clear()
    assert stream.getvalue() == ""


def test_parts_that_are_not_alike_promise_no_time() -> None:
    """A part of `recommend` may take a tenth of what the one before took, or ten times as long."""
    shown = told((0, "reference", 0, 1), (21, "methods", 0, 3), (24, "methods", 1, 3), (30, "methods", 2, 3))
    assert shown == [
        "reference, 0 s so far",
        "methods: 0 of 3, 21 s so far",
        "methods: 1 of 3, 24 s so far",
        "methods: 2 of 3, 30 s so far",
    ]


def test_the_time_left_falls_where_parts_are_alike() -> None:
    shown = told((0, TIMING, 0, 4), (50, TIMING, 0, 4), (60, TIMING, 1, 4), (70, TIMING, 2, 4), (80, TIMING, 3, 4))
    assert [text.partition(", ")[2] for text in shown] == [
        "0 s so far",
        "50 s so far",
        "30 s left, 60 s so far",
        "20 s left, 70 s so far",
        "10 s left, 80 s so far",
    ]


def test_what_was_done_before_is_not_counted_as_quick() -> None:
    """A study that resumes tells at once that most is done."""
    assert told((0, TIMING, 8, 10), (10, TIMING, 9, 10))[-1] == f"{TIMING}: 9 of 10, 10 s left, 10 s so far"


def test_the_time_left_falls_between_parts() -> None:
    clock, stream = Clock(), Terminal()
    line = Line(stream, clock)
    line.say("timing: 1 of 4", 30.0)
    for _ in range(40):
        clock.now += 1.0
        line.tick()
    shown = stream.getvalue().replace("\x1b[K", "").split("\r")[1:]
    left = [int(text.split(", ")[1].split()[0]) for text in shown if "left" in text]
    assert left == list(range(30, 0, -1))
    assert all(later < earlier for earlier, later in pairwise(left))
    assert shown[-1] == "timing: 1 of 4, 40 s so far"  # it takes longer than anybody knew


@pytest.mark.parametrize(
    ("command", "options", "said"),
    [
        full("compare", "--until 0.2 --repeat 1 -o OUT", ["reference, ", "runs: 0 of 4, ", "timing, "]),
        full(
            "recommend",
            "--error 1e-3 --until 0.2 --json",
            ["reference, ", "the first integrator, ", "integrators: 1 of 7, "],
        ),
        ("run", "--duration 2 --step 0.001 --output-step 0.001 --json -o OUT", ["of 2 s simulated, "]),
    ],
)
def test_commands_tell_where_they_are_piped(command, options, said, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.setenv("MBPROJ_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(progress, "REPEATED", 0.0)
    arguments = [str(tmp_path / "out") if word == "OUT" else word for word in options.split()]
    mbproj.main([command, FIVE_BAR, *arguments], standalone_mode=False)
    errors = capsys.readouterr().err
    for words in said:
        assert words in errors
