"""The types of force that are elements: their keys in a scene, and the elements that these make.

Plug-ins add theirs. The reader, the schema, the reference, the studies and the animation read these tables; nothing
else knows a type.
"""

from __future__ import annotations

from mbproj.plugins import Registry
from mbproj.scene.blocks.elements.dc_motor import MOTORS
from mbproj.scene.blocks.elements.element_type import ElementType
from mbproj.scene.blocks.elements.hydraulic_cylinder import CYLINDERS
from mbproj.scene.blocks.elements.maxwell import MAXWELL_ELEMENTS
from mbproj.scene.blocks.elements.pneumatic_spring import GAS_SPRINGS
from mbproj.scene.blocks.elements.servo import SERVOS
from mbproj.scene.blocks.elements.speed_torque import ENGINES
from mbproj.scene.blocks.elements.varying_spring import SPRINGS

__all__ = ["ELEMENTS", "SPRINGS", "ElementType", "element_type"]

ELEMENTS: Registry[ElementType] = Registry(
    "force type", {**MOTORS, **CYLINDERS, **MAXWELL_ELEMENTS, **GAS_SPRINGS, **SERVOS, **ENGINES}
)


def element_type(name: str) -> ElementType:
    """The element type of the force type `name`; for a spring, the one of springs whose numbers change in a run."""
    return SPRINGS[name] if name in SPRINGS else ELEMENTS[name]
