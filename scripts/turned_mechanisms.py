"""Checks that `check`, `run` and the full formulation say the same of every shipped mechanism, however it leans.

Each mechanism is turned as a whole by random and by tiny rotations, and its numbers are rounded to some digits. Degrees
of freedom, the verdict and the exit codes must be those of the mechanism as it stands, and the distance from a singular
pose nearly so. With rounded numbers an over-constrained loop may be refused, but then by all three. `python
scripts/turned_mechanisms.py [NAME ...]` prints each disagreement and ends with 1 where there is one; without a name it
takes all mechanisms, some minutes.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice

import numpy as np

from mbproj.base.errors import InputError, SimulationError
from mbproj.base.mechanisms_folder import mechanisms
from mbproj.commands.report.scene import assembled, checked
from mbproj.motion.simulate import simulate
from mbproj.scene.records import Body, Joint, Pair, Vector
from mbproj.scene.scene import Scene, read_scene
from mbproj.scene.settings import placed_in, settings_to_run
from mbproj.studies.variants import RigidMotion

#: Angles of tiny rotations in rad, digits that numbers are rounded to, and the seed of the axes.
TINY, DIGITS, SEED = (1e-9, 1e-8, 2.7e-8, 1e-7, 1e-6), (6, 7, 8, 9, 10), 70
#: The number of random rotations, and how much of a run is made, in s.
TURNED, SECONDS = 3, 1e-3
#: The formulations that are run.
FORMULATIONS = ("auto", "full")
#: The part by which distances may differ where numbers are rounded to few digits.
NEAR = 1e-3

Verdict = tuple[int, int | None, str, float | None]


def variants(scene: Scene) -> Iterator[tuple[str, Scene]]:
    """Yield the scene turned and rounded, each with a name."""
    rng = np.random.default_rng(SEED)
    for number in range(TURNED):
        leaning = turned(scene, rng.normal(size=3), rng.uniform(0.2, np.pi))
        yield f"turned {number}", leaning
        for digits in DIGITS:
            yield f"turned {number}, {digits} digits", rounded(leaning, digits)
    for angle in TINY:
        leaning = turned(scene, rng.normal(size=3), angle)
        yield f"leans by {angle:g}", leaning
    for digits in DIGITS:
        yield f"{digits} digits", rounded(scene, digits)


def turned(scene: Scene, axis: np.ndarray, angle: float) -> Scene:
    """Return the scene turned about an axis (3,) through the origin by an angle."""
    n = axis / np.linalg.norm(axis)
    cross = np.array([[0.0, -n[2], n[1]], [n[2], 0.0, -n[0]], [-n[1], n[0], 0.0]])
    return RigidMotion(np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross, np.zeros(3)).scene(
        scene
    )


def rounded(scene: Scene, digits: int) -> Scene:
    """Return the scene with poses, points and directions rounded to so many digits after the decimal point."""

    def number(value: float) -> float:
        return round(value, digits)

    def vector(given: Vector) -> Vector:
        x, y, z = map(number, given)
        return x, y, z

    def pair(given: Pair) -> Pair:
        return replace(given, first=vector(given.first), second=vector(given.second))

    def body(given: Body) -> Body:
        w, x, y, z = map(number, given.orientation)
        size = math.hypot(w, x, y, z)
        return replace(given, position=vector(given.position), orientation=(w / size, x / size, y / size, z / size))

    def joint(given: Joint) -> Joint:
        return replace(
            given,
            points=pair(given.points),
            axes=given.axes and pair(given.axes),
            x_axis=given.x_axis and pair(given.x_axis),
        )

    return replace(scene, bodies=tuple(map(body, scene.bodies)), joints=tuple(map(joint, scene.joints)))


def by_check(scene: Scene) -> Verdict:
    """Return exit code, degrees of freedom, verdict and distance of `mbproj check`."""
    try:
        found = checked(scene, *assembled(scene))
    except InputError as error:
        return 2, None, error.problems[0].message, None
    verdict = found.diagnosis.verdict if found.can_run else found.problems[0].message
    return 0 if found.can_run else 4, found.degrees_of_freedom, verdict, found.diagnosis.conditioning.distance


def by_run(scene: Scene, formulation: str) -> Verdict:
    """Return exit code, degrees of freedom and an error of the first steps of `mbproj run`."""
    try:
        system, state = assembled(scene)
        settings = settings_to_run(scene)
        with placed_in(scene):
            report = simulate(
                system, state, replace(settings, duration=SECONDS, output_step=SECONDS, formulation=formulation)
            )
    except InputError as error:
        return 2, None, error.problems[0].message, None
    except SimulationError as error:
        return 3, None, str(error), None
    return 0, report.degrees_of_freedom, "", None


def disagreements(scene: Scene, every: int = 1) -> Iterator[str]:
    """Yield what the scene and `every` so many of its variants do not agree in, in words."""
    upright = by_check(scene)
    of_runs = {name: by_run(scene, name) for name in FORMULATIONS}
    for what, variant in [("as it stands", scene), *islice(variants(scene), 0, None, every)]:
        found, ran = by_check(variant), {name: by_run(variant, name) for name in FORMULATIONS}
        for name, each in ran.items():
            if (each[0] == 0) != (found[0] == 0) or (each[0] == 0 and each[1] != found[1]):
                yield f"{what}: check says {found}, and {name} says {each}"
        if "digits" in what and found[0]:
            continue  # with rounded numbers an over-constrained loop may lock, and a stop be passed: all say so
        if found[:3] != upright[:3]:
            yield f"{what}: check says {found}, and of the mechanism as it stands {upright}"
        elif found[3] is not None and upright[3] is not None and abs(found[3] / upright[3] - 1.0) > NEAR:
            yield f"{what}: distance {found[3]:.6g} for {upright[3]:.6g}"
        for name, each in ran.items():
            if each[:2] != of_runs[name][:2]:
                yield f"{what}: {name} says {each}, and of the mechanism as it stands {of_runs[name]}"


def main(names: list[str]) -> int:
    """Print the disagreements; return 1 where there is one."""
    count = 0
    for path in mechanisms():
        if names and path.stem not in names:
            continue
        try:
            scene = read_scene(path)
        except InputError as error:
            print(f"{path.stem}: left out: {error.problems[0].message}")
            continue
        found = list(disagreements(scene))
        count += len(found)
        print(f"{path.stem}: {len(found)} disagreements", *found, sep="\n  ", flush=True)
    return int(count > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
