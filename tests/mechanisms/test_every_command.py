"""Every example through the commands: each ends well, or refuses in words that are named here.

Durations are a few steps, pictures are composed but not drawn, and what can be text or JSON is text of every other
example and JSON of the rest, so that the whole is cheap. For the same reason the examples share the work: one draws its
results or goes on from them, and has two of the five studies, or all where it refuses any.
`tests/studies/test_verify.py` has `verify`.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from functools import partial
from pathlib import Path

import click
import pytest
import yaml
from click.testing import CliRunner
from matplotlib.figure import Figure

from mbproj import compile_system, read_scene
from mbproj.base.errors import MbprojError
from mbproj.base.settings import Settings
from mbproj.commands.main import mbproj
from mbproj.studies.measure.measurement import time_settings
from tests.cli.reports import refuse_what_no_table_says
from tests.crossed import some
from tests.stops.scenes import resting_on_a_stop
from tests.support import MECHANISMS

MOVES = "is not constant at t = 0 s"
TOUCHES, SLIDES = "touches at this pose", "slides here, by the load of its bearing"
#: What commands say of scenes that they cannot do.
REFUSED = {
    "bouncing_ball": {"equilibrium": "nothing balances"},
    "cam": {"equilibrium": MOVES},
    "differential": {"equilibrium": "nothing balances"},
    "door_closer": {"equilibrium": "does not hold where the other forces balance"},
    "drum_brake": {"modes": SLIDES},
    "hoist": {"equilibrium": "nothing balances"},
    "inline_four": {"equilibrium": MOVES},
    "rocking_cabinet": {"equilibrium": "nothing balances", "modes": TOUCHES},
    "rolling_coin": {"equilibrium": "falls over and lies flat"},
    "screw_press": {"modes": SLIDES},
    "steered_car": {"equilibrium": "nothing balances"},
    "stewart_platform": {"equilibrium": "nothing balances"},
    "stick_slip": {"equilibrium": MOVES},
    "swinging_atwood": {"equilibrium": "nothing balances"},
    "turntable": {"equilibrium": MOVES},
    "valve_train": {"equilibrium": "beyond the rigid", "modes": TOUCHES},
}
UNJOINED = "there is nothing to project"
KINEMATIC = "the run is kinematic"
#: The same of studies.
NOT_STUDIED = {
    "bouncing_ball": {"threshold": UNJOINED},
    "free_body": {"threshold": UNJOINED},
    "cam": dict.fromkeys(("compare", "recommend", "tradeoff", "threshold", "stability"), KINEMATIC),
    "inline_four": dict.fromkeys(("compare", "recommend", "tradeoff", "threshold", "stability"), KINEMATIC),
}

pytestmark = [
    pytest.mark.long,
    pytest.mark.filterwarnings("error::RuntimeWarning"),
    pytest.mark.filterwarnings("error::UserWarning"),
    pytest.mark.filterwarnings("default::mbproj.base.errors.MbprojWarning"),
]


def every_scene(first: int) -> pytest.MarkDecorator:
    """The default run has each seventh from the first: as text and as JSON, with each study, drawn and gone on from."""
    return pytest.mark.parametrize("path", some(MECHANISMS, 7, first), ids=lambda path: path.stem)


def _not_drawn(figure: Figure, file: Path, **_: object) -> None:
    file.write_bytes(b"picture")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch, sweeps_here, read_here):
    """Where commands write; their pictures are empty, each timing is of one run, and no other process is started."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MBPROJ_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr("matplotlib.figure.Figure.savefig", _not_drawn)
    monkeypatch.setattr("mbproj.studies.measure.measurement.SHORTEST", 0.0)
    monkeypatch.setattr("mbproj.studies.recommend.time_settings", partial(time_settings, repetitions=1))
    return tmp_path


class Commands:
    """Runs commands in this process, and keeps what they refuse. What can be text or JSON is JSON of every other
    example."""

    def __init__(self, path: Path | None = None) -> None:
        self.refused: dict[str, str] = {}
        self.number = MECHANISMS.index(path) if path in MECHANISMS else 0
        self.as_json = self.number % 2 == 1

    def __call__(self, *arguments: object) -> bool:
        """Whether it ended well. Fails where it ends in a fault, or where what it prints as JSON is none, or not what
        the table of facts says."""
        words = [str(each) for each in arguments]
        done = CliRunner().invoke(mbproj, words, standalone_mode=False)
        if isinstance(done.exception, (MbprojError, click.ClickException)):
            self.refused[words[0]] = str(done.exception)
            return False
        if done.exception is not None:
            raise done.exception
        assert done.return_value in (None, 0), words
        if "--json" in words:
            refuse_what_no_table_says(words, json.loads(done.stdout))
        return True

    def either(self, *arguments: object) -> bool:
        """The same as text, or as JSON."""
        return self(*arguments, *(["--json"] if self.as_json else []))


def said(refused, expected):
    """Whether the commands that refused are those that are expected to, in these words."""
    return refused.keys() == expected.keys() and all(word in refused[name] for name, word in expected.items())


def short(settings: Settings) -> float:
    """Some steps, s."""
    return 2e-3 if settings.step is None else 2.0 * settings.step


@every_scene(0)
def test_commands(path, folder):
    run, scene = Commands(path), read_scene(path)
    until = short(scene.settings)
    assert run.either("check", path)
    assert run("run", path, "--duration", until, "--certify", "--limit", "1e-3", "-o", "certified.h5", "--json")
    assert run.either("run", path, "--duration", until)
    assert run.either("info", "results.h5") and run("info", "results.h5", "--check")
    if run.number // 2 % 2:
        assert (
            run("plot", "results.h5") and run("animate", "results.h5") and run("export", "results.h5", "-o", "tables")
        )
    else:
        assert run("rerun", "results.h5") and run.either("compare-results", "results.h5", "rerun.h5")
        assert run.either("continue", "results.h5", "--until", 2.0 * until, "-o", "longer.h5")
    if run.either("equilibrium", path):
        assert run("run", path, "--duration", until, "--start", "equilibrium", "-o", "rests.h5")
    run.either("modes", path)
    assert said(run.refused, REFUSED.get(path.stem, {})), run.refused


@every_scene(1)
def test_sweeps(path, folder):
    """Of two durations: a second one reuses all cases."""
    run, until = Commands(path), short(read_scene(path).settings)
    vary, measure = {"simulation.duration": [0.5 * until, until]}, {"cost": {"diagnostic": "evaluations", "at": "end"}}
    spec = {"sweep": 1, "scene": str(path), "vary": vary, "measure": measure}
    (folder / "spec.yaml").write_text(json.dumps(spec))
    assert run.either("sweep", "spec.yaml", "--jobs", 1) and run.either("info", "spec-sweep", "--check")


@every_scene(2)
def test_linear_models(path):
    """Of a scene that moves, or has no joint, there is none."""
    names, run = compile_system(read_scene(path)).names, Commands(path)
    ways, seen = names.coordinates[:1], names.coordinates[:2]
    run.either("linearize", path, "--inputs", ",".join(ways), "--outputs", ",".join(seen))


@pytest.mark.full
def test_batches(folder):
    """Of every fourth scene at once, without what they expect of longer runs: each alone is in `test_commands`."""
    for path in MECHANISMS[::4]:
        scene = yaml.load(path.read_text(), getattr(yaml, "CBaseLoader", yaml.BaseLoader))
        scene["simulation"]["duration"] = short(read_scene(path).settings)
        scene["simulation"].pop("output_step", None)
        Path(path.name).write_text(json.dumps({key: block for key, block in scene.items() if key != "expect"}))
    assert Commands()("batch", ".", "--jobs", 1, "--json")


@every_scene(5)
def test_what_runs_is_studied(path):
    run = Commands(path)
    own = (STUDIES[run.number % 5], STUDIES[(run.number + 2) % 5])
    _study(run, path, STUDIES if path.stem in NOT_STUDIED else own)
    assert said(run.refused, NOT_STUDIED.get(path.stem, {})), run.refused


@pytest.mark.full
def test_what_runs_from_its_equilibrium_is_studied_from_there(folder):
    run, path = Commands(), folder / "rests.yaml"
    path.write_text(resting_on_a_stop(3.0, "tolerance: 1e-6, integrator: dop853, break_times: [1 ms]"))
    assert run("run", path, "--duration", "4 ms", "--certify", "--limit", "1e-3")
    assert run("run", path, "--duration", "4 ms", "--accuracy", "1e-3", "--json", "-o", "accurate.h5")
    assert run("verify", path, "--json")
    _study(run, path, STUDIES)
    assert run.refused == {}


STUDIES = (
    "compare --until UNTIL --projections gpopm --force --repeat 1",
    "recommend --until UNTIL --error 1e-3",
    "tradeoff --until UNTIL --integrators rk4 --projections gpopm --longest 1e-6 --repeat 1",
    "threshold --duration UNTIL --thresholds 1e-6 --repeat 1",
    "stability --duration UNTIL --vary length-scale --from 1 --to 2 --points 2 --projections gpopm --force",
)


def _study(run: Commands, path: Path, studies: Iterable[str]) -> None:
    until = str(short(read_scene(path).settings))
    for study in studies:
        name, *options = study.replace("UNTIL", until).split()
        run.either(name, path, *options, "--jobs", 1)
