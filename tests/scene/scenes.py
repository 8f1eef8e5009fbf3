"""A scene in which nothing is wrong, and scenes with one mistake each."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from mbproj.base.errors import InputError
from mbproj.joints.table import COORDINATE_UNITS, JOINTS
from mbproj.scene.scene import Scene, read_scene_text

# The scene of the design, which reads without a problem, and how a test spoils it.

GOOD = """\
mbproj: 1                                # format version, required
title: Spatial slider-crank (Zhang, Liu & Liu 2015, sect. 5.2)
gravity: [0, 0, -9.8]                    # m/s^2, required: no hidden default
parameters: {crank_length: 0.08, rod_length: 0.3}
simulation:
  duration: 10
  step: 0.01
  integrator: rk4
  formulation: auto
  acceleration: bordered
  output_step: 0.01
  projection: gpopm
bodies:
  crank:
    mass: 0.12
    inertia: [1.0e-4, 1.0e-5, 1.0e-4]
    position: [0, 0.1, 0.12]
    orientation: {axis: [1, 0, 0], angle: 90 deg}
    velocity: [1, 2, 3]
    angular_velocity: [6, 0, 0]
  rod: {mass: 0.5, inertia: [4e-3, 4e-4, 4e-3], position: [0.1, 0.05, 0.1]}
  slider: {mass: 2, inertia: [1e-4, 1e-4, 1e-4], position: [0.2, 0, 0]}
joints:
  A: {type: revolute, bodies: [ground, crank], location: [0, 0.1, 0.12], axis: [1, 0, 0], speed: 6 rad/s}
  B: {type: spherical, bodies: [crank, rod], location: [0, 0.1, "0.12 + crank_length"]}
  C: {type: universal, bodies: [rod, slider], location: [0.2, 0, 0], axes: [[0, -2, 1], [1, 0, 0]]}
  D: {type: prismatic, bodies: [ground, slider], location: [0.2, 0, 0], axis: [1, 0, 0]}
markers:
  tip: {body: slider, location: [0.2, 0, 0]}
"""


def changed(old: str, new: str, text: str = GOOD) -> str:
    """The good scene with the one piece `old` replaced by `new`."""
    assert text.count(old) == 1, old
    return text.replace(old, new)


def read(text: str, **given: Any) -> Scene:
    return read_scene_text(text, "f.yaml", **given)


def read_with(old: str, new: str, **given: Any) -> Scene:
    """The scene with `old` replaced by `new`, read."""
    return read(changed(old, new), **given)


def errors(text: str, **given: Any) -> list[str]:
    """The first line of each problem with the text."""
    with pytest.raises(InputError) as raised:
        read(text, **given)
    return [str(problem).splitlines()[0] for problem in raised.value.problems]


# What is wrong with a scene, by the rows of `wrong/*.yaml`: one piece of the good scene, what stands there instead, and
# the first message (behind the file's name). `schema: blind` marks what a JSON Schema cannot see.

#: What the table of joints has, as messages list it.
JOINT_TYPES = " or ".join([", ".join([*JOINTS][:-1]), [*JOINTS][-1]])
LISTED = {
    "<joints>": JOINT_TYPES,
    "<dry>": ", ".join(name for name, kind in JOINTS.items() if kind.dry),
    **{
        f"<{'dry ' if dry else ''}in {unit or 'any'}>": ", ".join(
            name
            for name, kind in JOINTS.items()
            if kind.dry >= dry and any(unit in (None, COORDINATE_UNITS[row[0]]) for row in kind.coordinates.values())
        )
        for dry in (False, True)
        for unit in ("rad", "m", None)
    },
}
TABLE: dict[str, list[dict[str, str]]] = {
    path.stem: yaml.load(path.read_text(encoding="utf-8"), Loader=getattr(yaml, "CBaseLoader", yaml.BaseLoader))
    for path in sorted((Path(__file__).parent / "wrong").glob("*.yaml"))
}


def _with_lists(message: str) -> str:
    for mark, listed in LISTED.items():
        message = message.replace(mark, listed)
    return message


WRONG: dict[str, list[tuple[str, str, str]]] = {
    group: [(row["old"], row["new"], f"f.yaml:{_with_lists(row['message'])}") for row in rows]
    for group, rows in TABLE.items()
}
ROWS = [row for rows in WRONG.values() for row in rows]
IDS = [f"{group}-{number}" for group, rows in WRONG.items() for number, _ in enumerate(rows)]
#: Those that a JSON Schema of the format accepts nevertheless.
BLIND = {
    f"{group}-{number}"
    for group, rows in TABLE.items()
    for number, row in enumerate(rows)
    if row.get("schema") == "blind"
}
