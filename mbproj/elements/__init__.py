"""What acts through channels: elements are data, one file a kind."""

from mbproj.elements.element import Element, Force, Kind, Place, Row, State, called

__all__ = ["Element", "Force", "Kind", "Place", "Row", "State", "called"]
