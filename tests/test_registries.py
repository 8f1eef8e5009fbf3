"""Each entry of the registries once, through the commands: joints, projection methods, integrators; and a new joint."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest
from click.testing import CliRunner, Result

from mbproj.cli.main import mbproj
from mbproj.errors import InputError
from mbproj.joints import JOINTS
from mbproj.joints.table import AXES_PARALLEL, TWO_ANGLES, JointType
from mbproj.kernel import core
from mbproj.registry import PROJECTIONS, integrator_choices, is_embedded
from tests.kernel.scenes import needs_kernel
from tests.support import OWN

BODY = "{mass: 2, inertia: [0.3, 0.4, 0.5], position: [0.3, 0, 0.1]}"
HEAD = """\
mbproj: 1
gravity: [0.4, 0, -9.81]
simulation: {duration: 40 ms, step: 2 ms, output_step: 10 ms}
"""
#: What a joint says of its frame, and of a parameter by its unit.
FRAMES = {
    "point": "",
    "axis": ", axis: [0, 1, 0]",
    "normal": ", axis: [0, 1, 0]",
    "axes": ", axes: [[1, 0, 0], [0, 1, 0]]",
}
COUPLING_VALUES = {"teeth": [20, 35], "radius": "20 mm", "radii": [0.1, "-20 mm"]}
VALUES = {"m": "20 mm", "rad": "10 deg"}
#: A command each, with what comes behind its name; results.h5 is that of the run.
COMMANDS = (
    ["check", "scene.yaml", "--json"],
    ["run", "scene.yaml", "-o", "results.h5", "--json"],
    ["run", "scene.yaml", "--formulation", "full", "-o", "full.h5", "--json"],
    ["run", "scene.yaml", "--formulation", "reduced", "-o", "reduced.h5", "--json"],
    ["verify", "scene.yaml", "--json"],
    ["animate", "results.h5", "-o", "page.html"],
    ["export", "results.h5", "-o", "tables"],
)


def place_of(joint: JointType) -> str:
    """What a joint of this type needs beside its bodies."""
    place = "locations: [[0, 0, 1], [0.3, 0, 0.3]]" if joint.separate else "location: [0, 0, 0]"
    own = "".join(f", {name}: {VALUES[joint.parameters[name].unit]}" for name in joint.required_parameters)
    return place + FRAMES[joint.frame] + own + (", reaction: true" if joint.merges else "")


def scene_with(kind: str) -> str:
    """A body on one joint of this type, and of what couples as many as that wants."""
    if kind in JOINTS and JOINTS[kind].frame == "joints":
        wanted, bodies, joints = JOINTS[kind].couples or TWO_ANGLES, "", ""
        for at, each in enumerate(wanted):
            bodies += f"  body{at}: {BODY.replace('0.3, 0, 0.1', f'{at}.2, 0, 0.1')}\n"
            place = f"bodies: [ground, body{at}], location: [{at}, 0, 0], axis: [0, 1, 0]"
            joints += f"  P{at}: {{type: {OWN[each]}, {place}}}\n"
        names = [f"P{at}" for at in range(len(wanted))]
        given = {name: COUPLING_VALUES[name] for name in JOINTS[kind].parameters}
        own = {"joints": names, **given} if JOINTS[kind].couples else {"of": {"P0.angle": 2, "P1": -3}}
        return f"{HEAD}bodies:\n{bodies}joints:\n{joints}  J: {json.dumps({'type': kind, **own})}\n"
    joint = f"{{type: {kind}, bodies: [body, next], {place_of(JOINTS.get(kind, NEW))}}}"
    bodies = f"  body: {BODY}\n  next: {BODY}\n"
    ball = "  B: {type: spherical, bodies: [ground, body], location: [0, 0, 0.5]}\n"
    return f"{HEAD}bodies:\n{bodies}joints:\n{ball}  J: {joint}\n"


def in_the_kernel(kind: str) -> bool:
    """Whether it has a form of each row."""
    kernel = core()
    return kernel is not None and {row[0] for row in JOINTS[kind].rows} <= {
        *[name for name, *_ in kernel.primitives()],
        "coupling",
    }


@pytest.fixture
def call(tmp_path, monkeypatch):
    """A command in a folder of its own, which has to end well."""
    monkeypatch.chdir(tmp_path)

    def called(text: str, *arguments: str) -> Result:
        (tmp_path / "scene.yaml").write_text(text)
        done = CliRunner().invoke(mbproj, list(arguments), catch_exceptions=False)
        assert done.exit_code == 0, (arguments, done.output)
        return done

    return called


@needs_kernel
@pytest.mark.parametrize("kind", JOINTS)
def test_each_joint_goes_through_the_commands(kind, call):
    for command in COMMANDS if in_the_kernel(kind) else [each for each in COMMANDS if "reduced" not in each]:
        done = call(scene_with(kind), *command)
        if command[0] == "run":
            assert json.loads(done.stdout)["position_violation_max"] <= 1e-13
    assert kind in call(scene_with(kind), "schema").stdout


@needs_kernel
@pytest.mark.parametrize("name", PROJECTIONS)
def test_each_projection_runs(name, call):
    def run(formulation: str) -> None:
        options = ["--projection", name, "--formulation", formulation, "--quiet"]
        call(scene_with("revolute"), "run", "scene.yaml", *options)

    run("auto")
    if name != "popm":
        run("full")
        return
    with pytest.raises(InputError, match="use 'gpopm'"):  # M is singular with Euler parameters
        run("full")


@needs_kernel
@pytest.mark.parametrize("name", integrator_choices())
def test_each_integrator_runs(name, call):
    steps = "--tolerance=1e-6" if is_embedded(name) else "--step=2ms"
    for formulation in ("auto", "full"):
        options = ["--integrator", name, steps, "--formulation", formulation, "--quiet"]
        call(scene_with("revolute"), "run", "scene.yaml", *options)


NEW = JointType("axis", AXES_PARALLEL)
NEW_JOINT = """
import sys
from types import MappingProxyType
import mbproj.joints as joints
from mbproj.joints import table

row = table.JointType("axis", table.AXES_PARALLEL, aligned=table.ONE_AXIS)
joints.JOINTS = table.JOINTS = MappingProxyType({**table.JOINTS, "parallel": row})
from click.testing import CliRunner
from mbproj.cli.main import mbproj

for command in COMMANDS:
    done = CliRunner().invoke(mbproj, command, catch_exceptions=False)
    assert done.exit_code == 0, (command, done.output)
assert "parallel" in CliRunner().invoke(mbproj, ["schema"]).stdout
"""


@needs_kernel
def test_a_new_joint_is_a_row_of_the_table(tmp_path):
    """Two bodies whose axes stay parallel, wherever they go: nothing but the row says so."""
    (tmp_path / "scene.yaml").write_text(scene_with("parallel"))
    program = NEW_JOINT.replace("COMMANDS", repr(COMMANDS))
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 0, done.stderr
