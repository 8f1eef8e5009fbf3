"""Scenes and designs that tests of designs write."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from mbproj.studies.design.run import FoundDesign, find_design
from mbproj.studies.design.spec import read_spec

#: A ball that is thrown: x = v cos α t, z = v sin α t - g t²/2.
BALL = """\
mbproj: 1
gravity: [0, 0, -10]
parameters: {speed: 10 m/s, angle: 1 rad, idle: 2}
bodies:
  ball: {mass: 1 kg, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0], velocity: [speed*cos(angle), 0, speed*sin(angle)]}
simulation: {duration: 1 s, step: 0.05 s, output_step: 0.05 s}
expect:
  far: {body: ball, quantity: position, component: x, at: end, below: 100 m, source: v cos α t}
  high: {body: ball, quantity: position, component: z, at: end, below: 100 m, source: v sin α t - g t²/2}
"""
#: A mass on a spring: x = cos(√(k/m) t) with k = stiffness.
SPRING = """\
mbproj: 1
gravity: [0, 0, 0]
parameters: {mass: 2 kg, stiffness: 50 N/m}
bodies:
  block: {mass: mass, inertia: [1, 1, 1], position: [1, 0, 0]}
joints:
  rail: {type: prismatic, bodies: [ground, block], location: [0, 0, 0], axis: [1, 0, 0]}
forces:
  spring: {type: linear_spring_damper, joint: rail, stiffness: stiffness, free_displacement: -1 m}
simulation: {duration: 2 s, step: 0.01 s, output_step: 0.01 s}
"""
#: A four-bar in the plane whose crank turns once; the marker "tip" draws a coupler curve.
FOUR_BAR = """\
mbproj: 1
gravity: [0, 0, 0]
parameters: {crank: 0.2 m, coupler: 0.8 m, rocker: 0.7 m, px: 0.2 m, pz: 0.1 m}
bodies:
  a: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [0, 0, 0]}
  b: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [crank, 0, 0], orientation: {axis: [0, -1, 0], angle: 0.6}}
  c: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [0.8, 0, 0], orientation: {axis: [0, -1, 0], angle: 1.8}}
joints:
  A: {type: revolute, bodies: [ground, a], location: [0, 0, 0], axis: [0, -1, 0]}
  B: {type: revolute, bodies: [a, b], location: {a: [crank, 0, 0], b: [0, 0, 0]},
      axis: {a: [0, -1, 0], b: [0, -1, 0]}}
  C: {type: revolute, bodies: [b, c], location: {b: [coupler, 0, 0], c: [rocker, 0, 0]},
      axis: {b: [0, -1, 0], c: [0, -1, 0]}}
  D: {type: revolute, bodies: [ground, c], location: {ground: [0.8, 0, 0], c: [0, 0, 0]},
      axis: {ground: [0, -1, 0], c: [0, -1, 0]}}
motions:
  drive: {joint: A, angle: 2*pi*t}
markers:
  tip: {body: b, location: {b: [px, 0, pz]}}
simulation: {duration: 1 s, output_step: 1/24, kinematic: true}
"""


def table(path: Path, **columns: np.ndarray) -> None:
    """A CSV file with these columns, whose headings have units: `position_x__m` is `position_x (m)`."""
    heads = [name.replace("__", " (") + ")" if "__" in name else name for name in columns]
    rows = zip(*columns.values(), strict=True)
    lines = [",".join(heads), *(",".join(repr(float(value)) for value in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def written(folder: Path, scene: str, spec: str) -> Path:
    """The scene and the design in the folder; the design's path."""
    (folder / "scene.yaml").write_text(scene, encoding="utf-8")
    path = folder / "design.yaml"
    path.write_text(f"design: 1\nscene: scene.yaml\n{spec}", encoding="utf-8")
    return path


def found(path: Path, **options: object) -> tuple[FoundDesign, Mapping[str, float]]:
    """The design of a file, and its numbers by the names of the parameters."""
    design = find_design(read_spec(path), 1, **options)
    names = [name.removeprefix("parameters.") for name in design.spec.paths]
    return design, dict(zip(names, design.x.tolist(), strict=True))
