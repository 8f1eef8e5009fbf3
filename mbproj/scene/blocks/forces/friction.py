"""The force `friction` on coordinates of a joint: viscous (`coefficient`), dry (`coulomb`), or both.

type: friction, joint: B, coefficient: 3
type: friction, joint: B, coulomb: {torque: 4 N*m, static: 5 N*m, stribeck_speed: 0.05 rad/s}
type: friction, joint: A, coulomb: {coefficient: 0.2, static: 0.3, radius: 10 mm, bearing_length: 30 mm}
type: friction, joint: S, coulomb: {angle: {coefficient: 0.1, radius: 6 mm}, displacement: {force: 2 N}}
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mbproj.scene.blocks.coordinates import COORDINATES
from mbproj.scene.blocks.forces.coulomb import COULOMB
from mbproj.scene.fields.alternatives import Alternatives
from mbproj.scene.fields.choices import NameChoice, NameReference
from mbproj.scene.fields.containers import Record
from mbproj.scene.fields.fields import Converted, Field
from mbproj.scene.fields.quantities import Number
from mbproj.scene.fields.reading import Unfit
from mbproj.scene.friction import DryFriction
from mbproj.scene.records import Force, JointForce, Law

COEFFICIENT = Number(None, minimum=0.0)
#: Coefficients of viscous friction on coordinates in m and rad.
VISCOUS: Mapping[str, Field[Any]] = {"m": Number("N*s/m", minimum=0.0), "rad": Number("N*m*s/rad", minimum=0.0)}


def _friction(
    name: str,
    type: str,
    joint: str,
    coefficient: Mapping[str, float] | None = None,
    coulomb: Mapping[str, DryFriction] | None = None,
) -> JointForce:
    if coefficient is None and coulomb is None:
        raise Unfit("does nothing", "give 'coefficient', which is viscous, or 'coulomb', which is dry, or both")
    viscous = {key: Law(damping=value) for key, value in (coefficient or {}).items()}
    return JointForce(name, joint, viscous, coulomb=coulomb or {})


def friction_record(force_type: NameChoice) -> Record[Force]:
    """The record that reads friction on a joint."""
    return Record(
        "a friction",
        {
            "type": force_type,
            "joint": NameReference("joint", "joints"),
            "coefficient": Alternatives(
                (
                    Converted(COEFFICIENT, lambda coefficient: {"": coefficient}),
                    Record("a coefficient", {name: VISCOUS[unit] for name, unit in COORDINATES.items()}, dict),
                )
            ),
            "coulomb": COULOMB,
        },
        _friction,
        ("type", "joint"),
        named=True,
    )
