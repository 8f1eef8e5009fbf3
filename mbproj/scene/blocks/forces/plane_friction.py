"""The field of dry friction of a point, ball or wheel on the plane of a stop:

friction: 0.3
friction: {coefficient: 0.3, static: 0.4, stribeck_speed: 0.05 m/s}
"""

from __future__ import annotations

from mbproj.scene.blocks.forces.coulomb import SPEED, STATIC, not_less
from mbproj.scene.fields.alternatives import Alternatives
from mbproj.scene.fields.containers import OneOf, Record, Rule
from mbproj.scene.fields.fields import Converted, Field
from mbproj.scene.stops import PlaneFriction


def _friction(coefficient: float, static: float | None = None, stribeck_speed: float | None = None) -> PlaneFriction:
    return PlaneFriction(coefficient, coefficient if static is None else static, stribeck_speed)


COEFFICIENT = STATIC["coefficient"]
#: A coefficient alone, or a mapping with it.
PLANE_FRICTION: Field[PlaneFriction] = Alternatives(
    (
        Converted(COEFFICIENT, _friction),
        Record(
            "friction",
            {"coefficient": COEFFICIENT, "static": COEFFICIENT, "stribeck_speed": SPEED["m"]},
            _friction,
            ("coefficient",),
            (Rule(("coefficient",), not_less("coefficient"), ("static", "stribeck_speed", "regularised")),),
        ),
    )
)
#: The keys of a stop that exclude friction.
FRICTIONLESS = (OneOf(("stiffness", "friction"), hint="friction is that of rigid stops: rigid: true"),)
