"""The examples that end the help of each command, and a folder with the files that they speak of."""

from __future__ import annotations

import shlex
import shutil
from collections.abc import Iterator
from pathlib import Path

import click

from mbproj.base.mechanisms_folder import mechanism, validation_scenes
from mbproj.commands.main import COMMANDS
from mbproj.commands.main import mbproj as group
from mbproj.commands.options import Command
from tests.cli.commands import mbproj, succeeds

#: These run many simulations, or until Ctrl-C: tests read their examples. scripts/run_guide.py runs all but watch's.
LONG = (
    "stability",
    "recommend",
    "compare",
    "tradeoff",
    "threshold",
    "fit",
    "optimise",
    "batch",
    "sweep",
    "paper",
    "watch",
)


def named(name: str) -> tuple[Command, click.Context]:
    """A command, and the context that `mbproj NAME` runs it in."""
    context = click.Context(group, info_name="mbproj")
    command = group.get_command(context, name)
    assert isinstance(command, Command)
    return command, click.Context(command, info_name=name, parent=context)


def examples(*, long: bool) -> Iterator[tuple[str, list[str]]]:
    """The name of each command with the arguments of each of its examples."""
    for name in COMMANDS:
        if (name in LONG) is long:
            for _, line in named(name)[0].examples:
                yield name, shlex.split(line)[1:]


#: What `sweep` runs.
SWEEP = """\
sweep: 1
scene: five_bar.yaml
vary: {length: [0.9, 1.1], simulation.duration: 1 s}
measure: {tip: {marker: tip, quantity: position, at: end, component: z}}
"""


#: What `fit` and `optimise` search for.
FIT = """\
design: 1
scene: planar_four_bar.yaml
vary: {parameters.speed: [8 rad/s, 16 rad/s]}
match: {crank: {joint: A, quantity: angle, through: crank.csv}}
starts: 1
"""
OPTIMISE = """\
design: 1
scene: planar_four_bar.yaml
vary: {parameters.speed: [8 rad/s, 16 rad/s]}
minimise: {load: {joint: D, quantity: reaction_force, component: norm, at: end}}
subject_to: {far: {joint: A, quantity: angle, at: end, at_least: 25 rad}}
starts: 1
"""


SYNTHESIS = """\
design: 1
synthesis: {positions: places.csv}
"""


#: What `import` reads.
ROBOT = """\
<mujoco>
  <worldbody><body><joint name="hinge" axis="0 1 0"/><geom size="0.1" pos="0 0 -1"/></body></worldbody>
  <actuator><position name="servo" joint="hinge" kp="3"/></actuator>
  <keyframe><key name="home" qpos="0.3" ctrl="0.2"/></keyframe>
</mujoco>
"""


def fill(folder: Path) -> None:
    """Writes the files: copies of the five-bar, the engine and two scenes of the validation, a motion, a sweep, its
    folder, and results of runs."""
    shutil.copy(mechanism("five_bar"), folder)
    shutil.copy(mechanism("planar_four_bar"), folder)
    shutil.copy(mechanism("cam"), folder)
    (folder / "lengths.yaml").write_text(SWEEP, encoding="utf-8")
    assert mbproj("sweep", "lengths.yaml", "-q", folder=folder).returncode == 0
    (folder / "path.yaml").write_text(FIT, encoding="utf-8")
    (folder / "crank.csv").write_text("time (s), angle (rad)\n1, 15\n2, 30\n", encoding="utf-8")
    (folder / "load.yaml").write_text(OPTIMISE, encoding="utf-8")
    (folder / "carry.yaml").write_text(SYNTHESIS, encoding="utf-8")
    (folder / "places.csv").write_text("x,z,angle\n0,0,0\n0.5,0.2,0.3\n1,0.1,0.8\n", encoding="utf-8")
    (folder / "robot.xml").write_text(ROBOT, encoding="utf-8")
    (folder / "u.yaml").write_text("servo: 0.2 * sin(3*t)\n", encoding="utf-8")
    shutil.copy(mechanism("inline_four"), folder)
    measured = "".join(f"{t / 1000},{9 * t}\n" for t in range(20))
    (folder / "measured.csv").write_text(f"time (s), main.angle (deg)\n{measured}", encoding="utf-8")
    (folder / "validation").mkdir()
    for scene in validation_scenes()[:2]:
        shutil.copy(scene, folder / "validation")
    for output, options in {"results.h5": [], "again.h5": [], "gopm.h5": ["--projection", "gopm"]}.items():
        succeeds("run", "five_bar.yaml", "--duration", "1", "-o", output, *options, folder=folder)
