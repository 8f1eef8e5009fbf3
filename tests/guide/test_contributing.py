"""The walks of the page on contributing, taken in a copy of mbproj: what each adds is all that it takes."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from mbproj.guide.pages import pages
from tests.guide.fences import fences
from tests.kernel.scenes import needs_kernel
from tests.support import ROOT

#: Behind which line of a table its new lines stand.
TABLES = {
    "mbproj/joints/table.py": "JOINTS: Mapping[str, JointType] = MappingProxyType(\n    {\n",
    "mbproj/base/registry.py": 'Registry(\n    "projection method",\n    {\n',
    "mbproj/motion/projection.py": "    return -X @ np.linalg.solve(C_q @ X, violation)\n",
    "mbproj/scene/blocks/elements.py": '    "force type",\n    {\n',
}
#: Before which line of such a file its new functions, and entries of another table, stand.
FUNCTIONS = {"mbproj/scene/blocks/elements.py": "ELEMENTS: Registry[ElementType]"}
PRIMITIVES = '        "rope": PrimitiveType('
SCENE = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 0.1, step: 1 ms, output_step: 10 ms, integrator: ralston3, projection: lumped}
bodies:
  pin: {mass: 2, inertia: [0.3, 0.4, 0.5], position: [0, 0, 0]}
  ball: {mass: 2, inertia: [0.3, 0.4, 0.5], position: [0.2, 3, 0]}
joints:
  slot:
    {type: pin_in_slot, bodies: [ground, pin], location: [0, 0, 0], axis: [0, 1, 0], x_axis: [1, 0, -1]}
  tube:
    {type: ball_on_cylinder, bodies: [ground, ball], locations: [[0, 3, 0], [0.2, 3, 0]], axis: [0, 1, 0], radius: 0.2}
forces:
  air: {type: drag, joint: slot, coefficient: 40}
  line: {type: drag, points: {pin: [0, 0, 0], ball: [0.2, 3, 0]}, coefficient: 0.5}
  turn: {type: holder, joint: slot, angle: 20 deg, gain: 30, integral: 5}
"""
PROGRAM = """
import sys
# An editable installation finds its own mbproj before the copy.
sys.meta_path = [each for each in sys.meta_path if "Redirecting" not in type(each).__name__]
import numpy as np
from click.testing import CliRunner
from mbproj.commands.main import mbproj
from mbproj.joints.primitives.table import PRIMITIVES

for command in sys.stdin.read().splitlines():
    done = CliRunner().invoke(mbproj, command.split(), catch_exceptions=False)
    assert done.exit_code == 0, (command, done.output)
    if "--json" in command:
        print(done.stdout.replace("\\n", " "))
primitive, h = PRIMITIVES["on_cylinder"](0.3), 1e-30
x, v = np.random.default_rng(1).normal(size=(2, 5, 3, 3))
ahead = x + 1j * h * v
np.testing.assert_allclose(primitive.rate(x, v), primitive.value(ahead).imag / h, rtol=1e-12)
bend = primitive.rate(ahead, v).imag / h
np.testing.assert_allclose(primitive.curvature(x, v), bend, rtol=1e-11)
"""


def walked(folder: Path) -> set[str]:
    """A copy of the package with what the walks add; the files that they touch. The kernel is as it was."""
    shutil.copytree(ROOT / "mbproj", folder / "mbproj", ignore=shutil.ignore_patterns("src", "__pycache__", "guide"))
    touched = set()
    for fence in fences(pages()["contributing"]):
        if fence.language == "cpp":
            assert (ROOT / fence.words[0]).is_file()
        elif fence.words:
            (name,) = fence.words
            touched.add(name)
            if name not in TABLES:
                assert not (folder / name).exists(), name
                (folder / name).write_text(fence.text)
                continue
            head, _, lines = fence.text.rpartition("...\n")
            text = (folder / name).read_text()
            if name in FUNCTIONS and not lines.startswith(" "):
                (folder / name).write_text(text.replace(FUNCTIONS[name], f"{lines}\n\n{FUNCTIONS[name]}", 1))
                continue
            if "PrimitiveType(" in lines:
                (folder / name).write_text(text.replace(PRIMITIVES, f"{lines}{PRIMITIVES}", 1))
                continue
            assert text.count(TABLES[name]) == 1, name
            text = text.replace(TABLES[name], TABLES[name] + lines)
            (folder / name).write_text(text.replace("from mbproj.", f"{head}from mbproj.", 1) if head else text)
    return touched


def called(folder: Path, *commands: str) -> list[dict[str, object]]:
    """What commands print with --json."""
    environment = {**os.environ, "PYTHONPATH": str(folder)}
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        input="\n".join(commands),
        capture_output=True,
        text=True,
        cwd=folder,
        check=False,
        env=environment,
    )
    assert done.returncode == 0, done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()]


@pytest.mark.full
@needs_kernel
def test_the_walks_lead_where_the_page_says(tmp_path):
    assert len(walked(tmp_path)) == 6
    plain, whole = yaml.safe_load(SCENE), yaml.safe_load(SCENE)
    del whole["forces"]["air"], whole["forces"]["line"]  # their law has a kink: an event, which the kernel finds
    (tmp_path / "scene.yaml").write_text(yaml.safe_dump(whole))
    del plain["bodies"]["ball"], plain["joints"]["tube"], plain["forces"]["line"]
    plain["simulation"] |= {"projection": "gpopm"}
    (tmp_path / "slot.yaml").write_text(yaml.safe_dump(plain))
    checked, ran, reduced, planar = called(
        tmp_path,
        "check scene.yaml --json",
        "run scene.yaml -o results.h5 --json",
        "animate results.h5 -o page.html",
        "export results.h5 -o tables",
        "run slot.yaml --formulation reduced -o reduced.h5 --json",
        "run slot.yaml -o planar.h5 --json",
        "verify slot.yaml",
    )
    assert checked["degrees_of_freedom"] == 7  # 2 of the pin, 5 of the ball
    assert [each["formulation"] for each in (ran, reduced, planar)] == ["full", "reduced", "planar"]
    assert max(float(str(each["position_violation_max"])) for each in (ran, reduced, planar)) <= 1e-13
    assert (tmp_path / "tables" / "results-state-turn.sum.csv").is_file()


def test_the_page_shows_the_time_step():
    """In the order of `step.cpp`; comments may be shorter."""
    page = pages()["contributing"]
    (shown,) = [fence.text for fence in fences(page) if "attempt(run)" in fence.text]
    statements = [line.partition("//")[0].strip() for line in shown.splitlines()]
    source = (ROOT / "mbproj/kernel/src/step/step.cpp").read_text(encoding="utf-8")
    places = [source.index(statement) for statement in statements]
    assert len(places) == 7 and places == sorted(places)


#: What stands in the first place that each row of "Where to look" names.
STANDS = {
    "Where is the time step?": "void step(Run& run) {",
    "Where is the paper's loop?": "def march(",
    "Where is a joint defined?": '"revolute": JointType(',
    "Where does a scene become results?": "def record_run(",
    "Where do studies run their cases, and keep what comes of them?": "def each(",
    "Where is a formulation?": "def choose(",
    "Where is a command?": "def command(",
    "Where does a threshold come from?": "class Thresholds",
    "Where is a figure drawn?": '"reactions": PictureKind(',
}


def test_each_thing_stands_where_the_page_says():
    rows = [line.split("|")[1:4] for line in pages()["contributing"].text.splitlines() if line.startswith("| Where")]
    assert [question.strip() for question, *_ in rows] == list(STANDS)
    for question, first, then in rows:
        named, *_ = re.findall(r"`(mbproj/\S+)`", f"{first} {then}")
        place = ROOT / named
        texts = [place] if place.is_file() else list(place.glob("*.py"))
        assert any(STANDS[question.strip()] in text.read_text(encoding="utf-8") for text in texts), question
