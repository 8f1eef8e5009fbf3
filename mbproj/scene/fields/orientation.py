"""The field of an orientation of a body or a shape: an axis and an angle, a quaternion, a matrix, or Euler angles."""

from __future__ import annotations

from mbproj.scene.fields import rotations
from mbproj.scene.fields.checks import orientation_of, unit_quaternion
from mbproj.scene.fields.choices import Alternatives, NameChoice
from mbproj.scene.fields.containers import Record
from mbproj.scene.fields.fields import Converted, Field, List
from mbproj.scene.fields.quantities import DIRECTION, Number, PositionAngle, rows
from mbproj.scene.records import Quaternion

QUATERNION: Field[Quaternion] = Converted(List(Number(), 4), unit_quaternion)

ORIENTATION: Field[Quaternion] = Converted(
    Alternatives(
        (
            Record(
                "a rotation",
                {"axis": DIRECTION, "angle": PositionAngle()},
                rotations.from_axis_angle,
                ("axis", "angle"),
            ),
            Record("a rotation", {"quaternion": QUATERNION}, lambda quaternion: quaternion, ("quaternion",)),
            Record("a rotation", {"matrix": Converted(rows(""), orientation_of)}, lambda matrix: matrix, ("matrix",)),
            Record(
                "a rotation",
                {
                    "euler": List(PositionAngle(), 3),
                    "sequence": NameChoice("sequence of axes", lambda: rotations.SEQUENCES),
                },
                lambda euler, sequence: rotations.from_euler(euler, sequence),
                ("euler", "sequence"),
            ),
        )
    ),
    unit_quaternion,
)
