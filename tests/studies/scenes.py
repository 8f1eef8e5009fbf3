"""Scenes that end as a test wants them to."""

from __future__ import annotations

from pathlib import Path

PENDULUM = """\
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 0.2, step: 0.01}
bodies:
  bar: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0.5, 0, 0]}
joints:
  pin: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, 1, 0]}
markers:
  end: {body: bar, location: [1, 0, 0]}
"""
#: At 0.1 s it has turned by about (m g l / J) t²/2, 0.07 rad: the end, at 1 m, is 7 cm lower.
HOLDS = "  falls: {marker: end, quantity: position, component: z, at: 0.1, below: -1 mm, source: gravity}\n"
SHORT = "  rises: {marker: end, quantity: position, component: z, at: 0.1, above: 1 mm, source: a mistake}\n"
#: A mass of 1 kg on a spring of 1 N/m: it swings at √k rad/s.
OSCILLATOR = """\
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 200, step: 0.1, projection: none}
bodies:
  mass: {mass: 1, inertia: [1, 1, 1], position: [1, 0, 0], velocity: [0.1, 0, 0]}
joints:
  slide: {type: prismatic, bodies: [ground, mass], location: [0, 0, 0], axis: [1, 0, 0]}
forces:
  spring: {type: linear_spring_damper, joint: slide, stiffness: 1}
"""


def write(folder: Path, name: str, expect: str = "", old: str = "", new: str = "") -> Path:
    """The pendulum as folder/name.yaml, with these expectations and one piece replaced."""
    path = folder / f"{name}.yaml"
    assert old in PENDULUM
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(PENDULUM.replace(old, new) + (f"expect:\n{expect}" if expect else ""), encoding="utf-8")
    return path


def hanging(folder: Path, name: str = "hanging") -> Path:
    """A scene that would run for days."""
    return write(
        folder,
        name,
        HOLDS.replace("0.1", "0"),
        "duration: 0.2, step: 0.01",
        "duration: 1e7, step: 1e-5, output_step: 1e6",
    )


def failing(folder: Path, name: str = "failing") -> Path:
    """A scene whose force has no value from 0.1 s on."""
    force = "forces:\n  f: {type: force, body: bar, force: [sqrt(0.1 - t), 0, 0]}\nmarkers:"
    return write(folder, name, HOLDS, "markers:", force)


def wrong(folder: Path, name: str = "wrong") -> Path:
    """A scene with a mistake in it."""
    return write(folder, name, HOLDS, "mass: 1", "mas: 1")
