"""The types of force that are elements, one file each: their keys in a scene, and the elements that these make.

A file here has `TYPES`, its types by name; plug-ins add theirs. The reader, the schema, the reference, the studies and
the animation read these tables; nothing else knows a type.
"""

from __future__ import annotations

from mbproj.plugins import Registry
from mbproj.registry import types_of
from mbproj.scene.blocks.elements.element_type import ElementType
from mbproj.scene.blocks.elements.varying_spring import SPRINGS

__all__ = ["ELEMENTS", "SPRINGS", "ElementType", "element_type"]

ELEMENTS: Registry[ElementType] = Registry("force type", types_of(__name__, __path__))


def element_type(name: str) -> ElementType:
    """The element type of the force type `name`; for a spring, the one of springs whose numbers change in a run."""
    return SPRINGS[name] if name in SPRINGS else ELEMENTS[name]
