"""The force `bushing`: an elastic element that resists the relative translation and rotation of two frames.

type: bushing
bodies: [ground, arm]
location: [0, 0, 0]                                # global, or by body in its own axes
axes: {euler: [0, 30 deg, 0], sequence: xyz}       # of both frames, global; or by body, each in its body's axes
stiffness: {translation: [1e6, 1e6, 2e5], rotation: [[300, 10, 0], [10, 300, 0], [0, 0, 20]]}
damping: {...}, preload: {...}
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from mbproj.scene.fields import inertia
from mbproj.scene.fields.checks import of_these_bodies, pair_of
from mbproj.scene.fields.choices import Alternatives, NameChoice
from mbproj.scene.fields.containers import Record, Rule
from mbproj.scene.fields.fields import Converted, Field, List
from mbproj.scene.fields.orientation import ORIENTATION
from mbproj.scene.fields.placing import FRAMES, JOINT_POINT, TWO_BODIES
from mbproj.scene.fields.quantities import Number, rows, vector
from mbproj.scene.fields.reading import Unfit
from mbproj.scene.records import Bushing, Force, Matrix, Orientations, Vector

NONE: Vector = (0.0, 0.0, 0.0)
#: The default axes: both frames have the global axes at the scene's pose.
GLOBAL_AXES = Orientations((1.0, 0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))

TWO_FRAMES: Field[Any] = Alternatives((Converted(ORIENTATION, lambda axes: Orientations(axes, axes)), FRAMES))


def _definite(what: str, matrix: Matrix) -> Matrix:
    """The matrix of a stiffness or damping, made exactly symmetric. Raises Unfit where it could give energy away."""
    symmetric = inertia.symmetric(matrix)
    if symmetric is None:
        raise Unfit("is not symmetric", f"a {what} has equal numbers in row 1, column 2 and in row 2, column 1")
    least, _, largest = inertia.principal_moments(symmetric)
    if least < -inertia.ROUND_OFF * max(abs(least), abs(largest)):
        raise Unfit(f"has the negative eigenvalue {least:.6g}", f"no {what} gives energy away")
    return symmetric


def _resistance(what: str, per_length: str, per_angle: str) -> Field[tuple[Matrix, Matrix]]:
    """The field of two matrices, for translation and for rotation; each may be given by its diagonal."""

    def matrix(unit: str) -> Field[Matrix]:
        diagonal = Converted(List(Number(unit, minimum=0.0), 3), inertia.from_principal)
        return Converted(Alternatives((diagonal, rows(unit))), partial(_definite, what))

    zero = inertia.from_principal(NONE)
    keys: dict[str, Field[Any]] = {"translation": matrix(per_length), "rotation": matrix(per_angle)}
    return Record(f"a {what}", keys, lambda translation=zero, rotation=zero: (translation, rotation))


def _bushing(
    name: str, type: str, bodies: tuple[str, str], location: Any, axes: Any = GLOBAL_AXES, **given: Any
) -> Bushing:
    if not any(any(map(any, part)) for part in (*given.get("stiffness", ()), *given.get("damping", ()))) and not any(
        map(any, given.get("preload", ()))
    ):
        raise Unfit("does nothing", "give a 'stiffness', a 'damping' or a 'preload' that is not zero")
    if isinstance(axes, Mapping):
        axes = Orientations(axes[bodies[0]], axes[bodies[1]], local=True)
    return Bushing(name, bodies, pair_of(location, bodies), axes, **given)


def bushing_record(force_type: NameChoice) -> Record[Force]:
    """The record that reads a bushing."""
    preload = {"translation": vector("N"), "rotation": vector("N*m")}
    return Record(
        "a bushing",
        {
            "type": force_type,
            "bodies": TWO_BODIES,
            "location": JOINT_POINT,
            "axes": TWO_FRAMES,
            "stiffness": _resistance("stiffness", "N/m", "N*m/rad"),
            "damping": _resistance("damping", "N*s/m", "N*m*s/rad"),
            "preload": Record("a preload", preload, lambda translation=NONE, rotation=NONE: (translation, rotation)),
        },
        _bushing,
        ("type", "bodies", "location"),
        (
            Rule(("bodies", "location"), of_these_bodies("location")),
            Rule(("bodies", "axes"), of_these_bodies("axes")),
        ),
        named=True,
    )
