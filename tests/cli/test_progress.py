"""What a command says of its progress and of the time that is left, by a clock of the tests."""

from __future__ import annotations

import io
import re
from collections.abc import Iterable, Iterator
from itertools import pairwise

import numpy as np
import pytest

from mbproj import read_scene, settings_to_run, simulate
from mbproj.commands.main import mbproj
from mbproj.commands.report import progress
from mbproj.commands.report.progress import Bar, Line, Pace, Telling
from mbproj.motion import kernel_run
from mbproj.studies.parallel.progress import TIMING, with_words
from tests.cli.commands import FIVE_BAR
from tests.crossed import full
from tests.kernel.scenes import needs_kernel
from tests.support import assembled

# A clock and a terminal of a test's own.


class Clock:
    """Seconds that pass when the test says so."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


# What a command says of its progress: by a clock of the test's own.


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


# The time that a run's progress says is left, by a clock of the test's own, and what a run tells of its progress.

#: Simulated time of the runs, and seconds that a step of theirs takes.
END, COST = 10.0, 0.5
UNITS = {"s": 1.0, "min": 60.0, "h": 3600.0}


def shown(steps: Iterable[tuple[float, float]]) -> Iterator[tuple[float, float, float]]:
    """After each (time reached, seconds that it took): the time, what the bar says is left and what is, s."""
    listed, clock, stream = list(steps), Clock(), Terminal()
    bar = Bar(stream, END, clock)
    whole = sum(cost for _, cost in listed)
    for time, cost in listed:
        clock.now += cost
        whole -= cost
        bar.reach(time)
        said = re.findall(r"([0-9.e+]+) (s|min|h) left", stream.getvalue())
        if said and time < END:
            yield time, float(said[-1][0]) * UNITS[said[-1][1]], whole


def off_after_the_first_tenth(steps: Iterable[tuple[float, float]]) -> float:
    """By how much the time left is wrong then at most, relative; until the last minute."""
    return max(abs(said - left) / left for time, said, left in shown(steps) if time >= 0.1 * END and left > 50.0)


def grid(count: int) -> list[float]:
    return [END * (k + 1) / count for k in range(count)]


def test_the_time_left_of_fixed_steps_is_right() -> None:
    assert off_after_the_first_tenth((time, COST) for time in grid(1000)) < 0.06
    assert off_after_the_first_tenth((time, 40.0 * COST) for time in grid(1000)) < 0.06  # of hours, in few digits


def test_the_time_left_of_steps_of_all_sizes_is_right() -> None:
    """Error control: a step takes as long whatever its size, and sizes differ by a factor of ten."""
    sizes = 10.0 ** np.random.default_rng(4).uniform(0.0, 1.0, 4000)
    assert off_after_the_first_tenth((END * time, COST) for time in np.cumsum(sizes) / sizes.sum()) < 0.1


def test_the_time_left_of_a_run_with_events_is_right() -> None:
    """Every tenth step meets something that takes as long as ten steps."""
    costs = [COST * (11.0 if (k + 1) % 10 == 0 else 1.0) for k in range(1000)]
    assert off_after_the_first_tenth(zip(grid(1000), costs, strict=True)) < 0.1


def test_the_time_left_of_a_continued_run_is_that_of_its_own_leg() -> None:
    """Seven tenths were there before; the earlier samples were copied for 200 s before the first step."""
    steps = [(time, COST) for time in grid(1000) if time > 7.0]
    found = list(shown([(steps[0][0], 200.0), *steps[1:]]))
    assert len(found) == len(steps) - 2  # at the first there is no pace yet, and at the end nothing is left
    assert max(abs(said - left) / left for time, said, left in found if time > 7.3 and left > 10.0) < 0.06


def test_the_bar_of_a_continued_run_shows_the_part_of_the_whole() -> None:
    stream = Terminal()
    bar = Bar(stream, END, Clock())
    bar.reach(0.7 * END)
    assert "70%" in stream.getvalue()


def test_where_the_cost_changes_the_time_left_goes_by_the_average_so_far() -> None:
    """The first half takes twice as long: at its end twice the time is said to be left that is, and less and less too
    much from there on."""
    found = {
        time: said / left
        for time, said, left in shown((time, COST * (2.0 if time <= 0.5 * END else 1.0)) for time in grid(1000))
        if left > 10.0
    }
    assert found[0.5 * END] == pytest.approx(2.0, rel=0.05)
    assert found[0.75 * END] == pytest.approx(5.0 / 3.0, rel=0.05)
    assert found[0.9 * END] == pytest.approx(1.4 / 0.9, rel=0.06)


def test_a_pace_is_not_known_where_no_time_has_passed() -> None:
    pace = Pace(END, Clock())
    assert pace.reach(2.0) == pace.reach(2.0) == 0.0


@needs_kernel
def test_a_run_without_samples_tells_how_far_it_is(monkeypatch) -> None:
    """Its first sample after the start is its last."""
    monkeypatch.setattr(kernel_run, "RETURN_SECONDS", 0.0)
    scene = read_scene(FIVE_BAR, {}, {"duration": "1", "step": "1e-4", "output_step": "1"})
    told = list[float]()
    simulate(*assembled(scene), settings_to_run(scene), progress=told.append)
    assert len(told) > 50
    assert told == sorted(told)
    assert told[-1] == 1.0
    assert np.diff(told).max() < 0.05


@pytest.mark.parametrize(
    ("seconds", "said"),
    [(0.25, "0.25 s"), (42.0, "42 s"), (99.0, "99 s"), (110.0, "1.8 min"), (1500.0, "25 min"), (9000.0, "2.5 h")],
)
def test_times_are_said_to_a_twentieth(seconds: float, said: str) -> None:
    assert progress._duration(seconds) == said
