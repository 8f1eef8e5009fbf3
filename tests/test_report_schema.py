"""The tables of facts: each fact is said, and nothing else is, by the commands that bring it up."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import click
import numpy as np
import pytest
from jsonschema import Draft202012Validator, ValidationError

import mbproj as package
from mbproj.base.errors import InputError
from mbproj.commands import info as build_info
from mbproj.commands.main import mbproj as group
from mbproj.results.report_schema.facts import ANY_NAME, report_of
from mbproj.results.report_schema.files import NOT_BUILT
from mbproj.results.report_schema.reports import REPORTS
from tests.cli.commands import FIVE_BAR, mbproj
from tests.cli.reports import PRINTED_BY, all_of, refuse_what_no_table_says, said_in
from tests.crossed import where
from tests.ropes.scenes import LOAD, UP, scene
from tests.stops.scenes import resting_on_a_stop
from tests.studies.design.scenes import BALL, SPRING, table, written
from tests.studies.scenes import HOLDS, write
from tests.studies.sweep import specs
from tests.support import ROOT

# Small scenes, and the commands on them that together say every fact of every report.

#: Two wheels in mesh, of which one is driven, and what is expected in each way.
GEARS = """\
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 0.1, step: 0.01}
bodies:
  a: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
  b: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0.3, 0, 0]}
joints:
  A: {type: revolute, bodies: [ground, a], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: revolute, bodies: [ground, b], location: [0.3, 0, 0], axis: [0, 1, 0]}
  G: {type: gear, joints: [A, B], teeth: [20, 10]}
markers:
  left: {body: a, location: [0, 0, 0.1]}
  middle: {body: a, location: [0, 0, 0]}
  right: {body: b, location: [0.3, 0, 0.1]}
"""
EXPECTED = """\
motions:
  one: {joint: A, angle: t}
expect:
  ratio: {joint: B, quantity: angle_velocity_ratio, over: A.angle, at: end, value: -2, absolute: 0.1, source: teeth}
  passes: {joint: B, quantity: angle, at: {A.angle: 0.05 rad}, value: -0.1, absolute: 0.1, source: teeth}
  seen: {marker: middle, quantity: transmission_angle, between: [left, right], at: end, below: 7, source: none}
"""
#: A second coupling leaves no degree of freedom.
LOCKED = GEARS.replace("markers:", "  H: {type: coupler, of: {A: 1, B: 3}}\nmarkers:")
#: A door whose end the frame is 0.1 mm away from.
OPEN = """\
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 0.1, step: 0.01, adjust_joints: 1 mm}
bodies:
  a: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0.5, 0, 0]}
joints:
  A: {type: revolute, bodies: [ground, a], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: revolute, bodies: [ground, a], location: {ground: [0, 0.2, 0], a: [-0.5, 0.2, 0.0001]},
    axis: {ground: [0, 1, 0], a: [0, 1, 0]}}
"""
#: A load between two springs that are longer than the way: it rests on either side, and where friction holds it.
TRUSS = """\
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 0.1, step: 0.01}
bodies: {m: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0.3]}}
joints: {j: {type: prismatic, bodies: [ground, m], location: {ground: [0, 0, 0], m: [0, 0, 0]},
  axis: {ground: [0, 0, 1], m: [0, 0, 1]}}}
forces:
  left: {type: spring_damper, points: {ground: [-1, 0, 0], m: [0, 0, 0]}, stiffness: 100, free_length: 1.1}
  right: {type: spring_damper, points: {ground: [1, 0, 0], m: [0, 0, 0]}, stiffness: 100, free_length: 1.1}
"""
RUBS = "  rubs: {type: friction, joint: j, coulomb: {force: 1 N}}\n"
#: A rotor with 1 N m on a brake of 2 N m, which creeps.
CREEPS = """\
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 0.2, integrator: radau5, tolerance: 1.0e-6, output_step: 0.05}
bodies: {rotor: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [0, 0, 0]}}
joints: {B: {type: revolute, bodies: [ground, rotor], location: [0, 0, 0], axis: [0, 0, 1]}}
forces:
  load: {type: torque, body: rotor, torque: [0, 0, 1]}
  brake: {type: friction, joint: B, coulomb: {torque: 2, regularised: 0.01}}
"""
FIVE, ONE = (FIVE_BAR, "--duration", "0.05"), ("--until", "0.1", "--repeat", "1", "-j", "1")
MATCH = "vary: {parameters.angle: [0.1, 1.5]}\nstarts: 1\nmatch: {flight: {body: ball, through: flight.csv}}\n"


def mechanism(name: str) -> Path:
    return ROOT / "mechanisms" / f"{name}.yaml"


#: Commands by the name of their report.
SAID: Mapping[str, Sequence[tuple[object, ...]]] = {
    "run": (
        ("run", *FIVE, "--energy-row", "true", "--certify"),
        ("run", *FIVE, "--accuracy", "1e-3"),
        ("run", mechanism("stick_slip"), "--duration", "0.01"),
        ("run", "pushing.yaml"),
        ("run", "creeps.yaml"),
        ("run", "gears.yaml"),
    ),
    "check": (
        *(("check", mechanism(name)) for name in ("hoist", "door_closer", "bennett")),
        ("check", "open.yaml"),
        ("check", "locked.yaml"),
        ("check", FIVE_BAR),
    ),
    "branches": (("branches", mechanism("planar_four_bar"), "--hold", "A.angle", "--starts", "5"),),
    "curve": (("curve", mechanism("cam"), "--rows", "5"),),
    "equilibrium": (
        ("equilibrium", "rubs.yaml"),
        ("equilibrium", "truss.yaml", "--starts", "9"),
        ("equilibrium", "falls.yaml"),
    ),
    "modes": (("modes", "spring.yaml", "--vary", "stiffness=1:2:2"),),
    "linearize": (("linearize", "spring.yaml", "--inputs", "spring", "--outputs", "rail.displacement"),),
    "info": (
        ("info", "certified.h5"),
        ("info", "verified.h5"),
        ("info", "stopped.h5"),
        ("info", "creeps.h5"),
        ("info", "slips.h5"),
        ("info", "pushed.h5"),
    ),
    "info-loads": (("info", "spring.h5", "--loads", "--level", "0.5", "--rainflow"),),
    "info-steps": (("info", "stopped.h5", "--steps"),),
    "info-energy": (("info", "verified.h5", "--energy"),),
    "info-check": (("info", "verified.h5", "--check"), ("info", "spec-sweep", "--check")),
    "info-thresholds": (("info", "--thresholds"),),
    "build": (("info", "--build"),),
    "compare-results": (("compare-results", "spring.h5", "stiffer.h5"),),
    "loads": (("loads", "hanging.yaml", "--given", "given.csv"),),
    "compare": (("compare", *FIVE[:1], *ONE, "--projections", "gpopm", "--energy-rows", "true"),),
    "tradeoff": (("tradeoff", FIVE_BAR, *ONE, "--projections", "gpopm", "--integrators", "rk4", "--longest", "1 us"),),
    "recommend": (
        ("recommend", "baumgarte.yaml", "--error", "1e-3", "-j", "1"),
        ("recommend", "penalty.yaml", "--error", "1e-3", "-j", "1"),
    ),
    "threshold": (("threshold", FIVE_BAR, *ONE, "--thresholds", "1e-6"),),
    "stability": (
        ("stability", "hanging.yaml", "--vary", "step", "--from", "0.001", "--to", "10", "--points", "2", "-j", "1"),
    ),
    "verify": (("verify", *FIVE),),
    "sensitivity": (("sensitivity", "scene.yaml", "--of", "far", "--to", "angle", "-j", "1"),),
    "fit": (("fit", "design.yaml", "-j", "1"),),
    "optimise-topologies": (("optimise", "wish.yaml", "--topologies", "four_bar", "-j", "1"),),
    "sweep": (("sweep", "spec.yaml", "-j", "1"),),
    "batch": (("batch", "gears.yaml", "pushing.yaml", "-j", "1"),),
    "import": (("import", ROOT / "tests" / "data" / "formats" / "stacks.xml", "-o", "imported.yaml"),),
    "export": (("export", "creeps.yaml", "--mjcf", "creeps.xml"),),
}


def prepare(folder: Path) -> None:
    """The scenes and the files that `SAID` names."""
    write(folder, "hanging", HOLDS)
    falls = "  pin: {type: planar, bodies: [ground, bar], location: [0, 0, 0], axis: [0, 1, 0]}"
    write(
        folder,
        "falls",
        "",
        "  pin: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, 1, 0]}",
        falls,
    )
    for name, projection in (
        ("baumgarte", "baumgarte, gains: [10, 20]"),
        ("penalty", "mass-orthogonal, alpha: 1e6, tolerance: 1e-9, threshold: 1e-8"),
    ):
        write(folder, name, "", "step: 0.01", f"step: 0.01, projection: {{method: {projection}}}")
    texts = {"spring": SPRING, "truss": TRUSS, "rubs": TRUSS + RUBS, "gears": GEARS + EXPECTED, "locked": LOCKED}
    texts |= {"open": OPEN, "pushing": scene(LOAD + UP, duration=0.3).replace("20 ms", "0.5 ms")}
    texts |= {"stopped": resting_on_a_stop(3.0, "tolerance: 1e-6, integrator: dop853")}
    texts |= {"creeps": CREEPS}
    for name, text in texts.items():
        (folder / f"{name}.yaml").write_text(text, encoding="utf-8")
    times = np.linspace(0.0, 1.0, 11)
    table(folder / "flight.csv", time__s=times, position_x__m=10.0 * np.cos(0.5) * times)
    written(folder, BALL, MATCH)
    table(folder / "given.csv", time__s=times, **{"pin.angle__rad": np.sin(times)})
    specs.write(folder, "  fails: [0, 1]\n")
    (folder / "wish.yaml").write_text("design: 1\nsynthesis: {function: turns.csv}\nstarts: 2\n", encoding="utf-8")
    crank = np.linspace(0.0, 1.0, 7)
    table(folder / "turns.csv", input__rad=crank, output__rad=crank)
    for words in (
        ("run", *FIVE, "--certify", "-o", "certified.h5"),
        ("run", *FIVE, "-o", "verified.h5"),
        ("verify", *FIVE, "--store", "verified.h5"),
        ("run", "stopped.yaml", "-o", "stopped.h5"),
        ("run", "creeps.yaml", "-o", "creeps.h5"),
        ("run", "pushing.yaml", "-o", "pushed.h5"),
        ("run", mechanism("stick_slip"), "--duration", "0.01", "-o", "slips.h5"),
        ("run", "spring.yaml", "-o", "spring.h5"),
        ("run", "spring.yaml", "--set", "stiffness=60 N/m", "-o", "stiffer.h5"),
        ("sweep", "spec.yaml", "-j", "1"),
    ):
        done = mbproj(*words, "-q", folder=folder)
        assert done.returncode == (3 if words[0] == "sweep" else 0), done.stderr  # of the sweep a case fails


# The tables of facts: each fact is said, and nothing else is. `tests/cli/commands.py` holds all commands that tests run
# against them, `tests/mechanisms/test_every_command.py` all mechanisms.

#: Reports of studies, which take seconds.
LONG = {"compare", "fit", "optimise-topologies", "recommend", "sensitivity", "stability", "threshold", "tradeoff"}
LONG |= {"verify"}
KINDS = {"string", "number", "integer", "boolean", "array", "map", "object", "null"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """With the scenes and the files that the commands name."""
    made = tmp_path_factory.mktemp("facts")
    prepare(made)
    return made


def test_each_command_with_json_has_a_report():
    context = click.Context(group)
    commands = {name: group.get_command(context, name) for name in group.list_commands(context)}
    able = {name for name, command in commands.items() for each in command.params if "--json" in each.opts}
    assert able == {words[0] for words in PRINTED_BY}
    assert SAID.keys() == REPORTS.keys()


@pytest.mark.long
@pytest.mark.parametrize("name", where(lambda name: name not in LONG, SAID))
def test_each_fact_is_said(folder, name):
    said, report = set(), REPORTS[name]
    for words in SAID[name]:
        done = mbproj(*words, "--json", folder=folder)
        assert done.stdout.startswith(("{", "[")), done.stderr
        said.update(said_in(json.loads(done.stdout), report.kind, report.facts))
    never = [fact.key for fact in all_of(report.facts) if fact not in said and ANY_NAME not in fact.key]
    assert never == [fact.key for fact in all_of(report.facts) if fact.when == NOT_BUILT]


def test_what_is_said_of_a_missing_kernel(monkeypatch):
    monkeypatch.setattr(build_info, "build_info", lambda: "it is lost")
    said = build_info.build_facts()
    refuse_what_no_table_says(["info", "--build"], said)
    assert said["kernel"].keys() == {"built", "reason", "advice"}


@pytest.mark.parametrize("name", REPORTS)
def test_the_schema_is_one_that_python_and_the_command_give(tmp_path, name):
    schema = package.schema(name)
    Draft202012Validator.check_schema(schema)
    assert json.loads(mbproj("schema", "--of", name, folder=tmp_path).stdout) == schema
    for _ in range(2):  # the second replaces the first, which is known as ours
        assert mbproj("schema", "--of", name, "-o", "of.json", folder=tmp_path).returncode == 0
    assert json.loads((tmp_path / "of.json").read_text()) == schema


def test_a_key_that_no_table_has_is_refused_and_so_is_a_report():
    with pytest.raises(ValidationError, match="Additional properties"):
        refuse_what_no_table_says(["run"], {"scene": "a", "output": "b", "status": "interrupted", "more": 1})
    with pytest.raises(ValidationError, match="'formulation' is a required property"):
        refuse_what_no_table_says(["run"], {"scene": "a", "output": "b", "status": "complete"})
    with pytest.raises(TypeError, match=r"no fact is called \['more'\]"):
        report_of(REPORTS["sweep"].facts, None, more=1)
    with pytest.raises(InputError, match="there is no 'rum'; choose from: scene, run"):
        package.schema("rum")


def test_facts_are_told_apart():
    for report in REPORTS.values():
        for facts in (report.facts, *(fact.fields for fact in all_of(report.facts))):
            assert len({fact.key for fact in facts}) == len(facts)
        for fact in all_of(report.facts):
            assert fact.words and {*re.split(r" \| | of | or ", fact.kind)} <= KINDS
            assert not fact.fields or "object" in fact.kind


def test_info_shows_attributes_with_their_units(folder):
    shown = mbproj("info", "verified.h5", folder=folder).stdout
    assert re.search(r"  integration_seconds +\S+ s\n", shown) and re.search(r"  energy_put_in +0 J\n", shown)
    assert re.search(r"  redundant_rows +0\n", shown)
