"""Each entry of the registries once, through the commands: joints, elements, projection methods, integrators.

What a shipped mechanism has is verified there, by `tests/studies/test_verify.py`; here each other entry is, once.
"""

from __future__ import annotations

import json
import re
from itertools import chain, cycle, islice, repeat
from pathlib import Path

import pytest
import yaml
from click.testing import CliRunner, Result

from mbproj import read_scene
from mbproj.base.registry import PROJECTIONS, integrator_choices, is_embedded
from mbproj.commands.main import mbproj
from mbproj.joints.primitives.table import PRIMITIVES
from mbproj.joints.table import JOINTS, TWO_ANGLES, JointType, Parameter
from mbproj.kernel import core
from mbproj.scene.blocks.elements import ELEMENTS
from tests.crossed import some
from tests.kernel.scenes import needs_kernel
from tests.support import MECHANISMS, OWN, parameter

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
    "face": ", axis: [0, 1, 0], normal: [0.2, 0, -1]",
    "axes": ", axes: [[1, 0, 0], [0, 1, 0]]",
}
#: A command each, with what comes behind its name; results.h5 is that of the run.
COMMANDS = (
    ["check", "scene.yaml", "--json"],
    ["run", "scene.yaml", "-o", "results.h5", "--json"],
    ["run", "scene.yaml", "--formulation", "reduced", "-o", "reduced.h5", "--json"],
    ["export", "results.h5", "-o", "tables"],
)
#: And those that take most of the time.
SLOW = (
    ["run", "scene.yaml", "-o", "results.h5", "--json"],
    ["run", "scene.yaml", "--formulation", "full", "-o", "full.h5", "--json"],
    ["animate", "results.h5", "-o", "page.html"],
)


def place_of(joint: JointType) -> str:
    """What a joint of this type needs beside its bodies."""
    if joint.frame == "path":
        places = "{point: body, at: [0.3, 0, 0.1]}, {sheave: ground, at: [1, 0, 0], radius: 0.1, bends: left}"
        return f"normal: [0, -1, 0], path: [{places}, {{point: next, at: [0.3, 0, 1]}}]"
    if joint.is_on_plane:
        axis = ", axis: [0, 1, 0]" if joint.has_axis else ""
        size = "x_axis: [1, 0, 0], semi_axes: [0.4, 0.3, 0.2]" if "semi_axes" in joint.parameters else "radius: 0.3"
        return f"plane: {{location: [0, 0, -0.2], normal: [0, 0, 1]}}, centre: [0.3, 0, 0.1]{axis}, {size}"
    place = "locations: [[0, 0, 1], [0.3, 0, 0.3]]" if joint.separate else "location: [0, 0, 0]"
    given = {name: joint.parameters[name] for name in joint.required_parameters}
    own = "".join(
        f", {name}: {curve_of(each) if each.may_be in ('curve', 'space_curve', 'convex') else parameter(name, each)}"
        for name, each in given.items()
    )
    own += ", x_axis: [1, 0, 0]" if joint.x_axis == "required" else ""
    own += ", limits: {gap: {range: [0, null], rigid: true}}" if "gap" in joint.coordinates else ""
    return place + FRAMES[joint.frame] + own + (", reaction: true" if joint.merges else "")


def curve_of(given: Parameter) -> str:
    """The names of as many curves as a joint wants."""
    return "wire" if given.may_be == "space_curve" else "[disc, disc]" if given.many else "oval"


def scene_with(kind: str) -> str:
    """A body on one joint of this type, and of what couples as many as that wants."""
    if JOINTS[kind].frame == "joints":
        wanted, bodies, joints = JOINTS[kind].couples or TWO_ANGLES, "", ""
        for at, each in enumerate(wanted):
            bodies += f"  body{at}: {BODY.replace('0.3, 0, 0.1', f'{at}.2, 0, 0.1')}\n"
            place = f"bodies: [ground, body{at}], location: [{at}, 0, 0], axis: [0, 1, 0]"
            joints += f"  P{at}: {{type: {OWN[each]}, {place}}}\n"
        names = [f"P{at}" for at in range(len(wanted))]
        given = {name: parameter(name, own) for name, own in JOINTS[kind].parameters.items()}
        own = {"joints": names, **given} if JOINTS[kind].couples else {"of": {"P0.angle": 2, "P1": -3}}
        return f"{HEAD}bodies:\n{bodies}joints:\n{joints}  J: {json.dumps({'type': kind, **own})}\n"
    two = "" if JOINTS[kind].frame == "path" else "bodies: [body, next], "
    joint = f"{{type: {kind}, {two}{place_of(JOINTS[kind])}}}"
    bodies = f"  body: {BODY}\n  next: {BODY}\n"
    ball = "  B: {type: spherical, bodies: [ground, body], location: [0, 0, 0.5]}\n"
    points = "[[0.8, 0, 0.2], [0.2, 0.7, -0.2], [-0.7, 0.2, 0.3], [-0.2, -0.7, 0]]"
    own = f"{{oval: {{ellipse: [0.7, 0.4]}}, disc: {{circle: 0.35}}, wire: {{space_points: {points}, closed: true}}}}"
    curves = f"curves: {own}\n" if {"curve", "curves"} & JOINTS[kind].parameters.keys() else ""
    return f"{HEAD}{curves}bodies:\n{bodies}joints:\n{ball}  J: {joint}\n"


def in_the_kernel(kind: str) -> bool:
    """Whether it has a form of each row."""
    kernel = core()
    return kernel is not None and {PRIMITIVES[row[0]].in_kernel or row[0] for row in JOINTS[kind].rows} <= {
        *[name for name, *_ in kernel.primitives()],
        "coupling",
    }


@pytest.fixture
def call(tmp_path, monkeypatch, read_here):
    """A command in a folder of its own, which has to end well."""
    monkeypatch.chdir(tmp_path)

    def called(text: str, *arguments: str) -> Result:
        (tmp_path / "scene.yaml").write_text(text)
        done = CliRunner().invoke(mbproj, list(arguments), catch_exceptions=False)
        assert done.exit_code == 0, (arguments, done.output)
        return done

    return called


#: Each entry of each registry at least once: joint, element, projection method, integrator. Each element comes once, as
#: the elements take most of the time; then there is none.
LONGEST = max(map(len, (JOINTS, ELEMENTS, PROJECTIONS, integrator_choices())))
COLUMNS = (cycle(JOINTS), chain(ELEMENTS, repeat("")), cycle(PROJECTIONS), cycle(integrator_choices()))
CASES = [*islice(zip(*COLUMNS, strict=False), LONGEST)]


def entries_of(path: Path) -> set[str]:
    """The entries that a shipped mechanism has, and "", which is no element."""
    settings = read_scene(path).settings
    types = re.findall(r"\btype: ([\w-]+)", path.read_text(encoding="utf-8"))
    return {"", settings.projection.method, settings.integrator, *types}


def unverified() -> list[tuple[str, ...]]:
    """The cases to verify, by which each entry is verified once."""
    seen, cases = {entry for path in MECHANISMS for entry in entries_of(path)}, []
    for case in CASES:
        cases += [] if seen.issuperset(case) else [case]
        seen.update(case)
    return cases


UNVERIFIED = unverified()


def with_all(kind: str, element: str, method: str, integrator: str) -> str:
    """The scene with an element, if any, between its last body and the ground, and these settings."""
    text = scene_with(kind)
    steps = "tolerance: 1e-6" if is_embedded(integrator) else "step: 2 ms"
    text = text.replace("step: 2 ms", f"{steps}, integrator: {integrator}, projection: {method}")
    return with_element(text, element) if element else text


def with_element(text: str, element: str) -> str:
    """The scene with an element between its last body and the ground, or on a hinge of its own."""
    along = {"m": "points: {ground: [0, 0, 3], LAST: [0.3, 0, 0.1]}", "rad": "joint: hinge"}[ELEMENTS[element].along]
    given = [*ELEMENTS[element].required]
    for choice in ELEMENTS[element].choices:
        given += [choice.keys[-1]] if choice.needed and not {*choice.keys} & {*given} else []
    values = "".join(f", {name}: 2" for name in given)
    last = [*yaml.safe_load(text)["bodies"]][-1]
    text = text.replace("bodies:\n", f"bodies:\n  door: {BODY}\n", 1)
    hinge = "{type: revolute, bodies: [ground, door], location: [0, 2, 0], axis: [0, 1, 0]}"
    text = text.replace("joints:\n", f"joints:\n  hinge: {hinge}\n", 1)
    return f"{text}forces: {{E: {{type: {element}, {along.replace('LAST', last)}{values}}}}}\n"


def each_case(cases):
    ids = ["-".join(filter(None, case)) for case in CASES]
    return pytest.mark.parametrize(("kind", "element", "method", "integrator"), cases, ids=ids)


@needs_kernel
@pytest.mark.filterwarnings("error::RuntimeWarning")
@each_case(CASES)
def test_each_entry_goes_through_the_commands(kind, element, method, integrator, call):
    through(COMMANDS, with_all(kind, element, method, integrator), kind, method, call)


@needs_kernel
@pytest.mark.filterwarnings("error::RuntimeWarning")
@each_case(some(CASES, 5))
def test_each_entry_runs_in_full_and_is_shown(kind, element, method, integrator, call):
    through(SLOW, with_all(kind, element, method, integrator), kind, method, call)


def through(commands, text, kind, method, call):
    for command in commands:
        if command[0] == "run" and not applies(command, kind, method):
            continue
        done = call(text, *command)
        if command[0] == "run" and PROJECTIONS[method].corrects:
            assert json.loads(done.stdout)["position_violation_max"] <= 1e-13


@needs_kernel
@pytest.mark.filterwarnings("error::RuntimeWarning")
@pytest.mark.parametrize(("kind", "element", "method", "integrator"), some(UNVERIFIED, 8, 3))
def test_each_entry_is_verified(kind, element, method, integrator, call):
    of_the_kernel = [] if PROJECTIONS[method].compiled else OF_THE_KERNEL
    call(with_all(kind, element, method, integrator), "verify", "scene.yaml", "--json", *of_the_kernel)


def test_the_schema_names_each_entry():
    named = {*re.findall(r"[\w-]+", CliRunner().invoke(mbproj, ["schema"]).stdout)}
    assert {*JOINTS, *ELEMENTS, *PROJECTIONS, *integrator_choices()} <= named


#: An order takes 20 s to see in the full formulation; the tests of the methods measure it.
OF_THE_KERNEL = ["--projection", "gpopm"]


def applies(command: list[str], kind: str, method: str) -> bool:
    """Whether the formulation of a run has the method and the joint; M is singular with Euler parameters."""
    if "full" in command:
        return method != "popm"
    if "reduced" in command:
        return PROJECTIONS[method].compiled and in_the_kernel(kind)
    return True
