"""Elements act on a mechanism through channels. They are data, one file a kind."""

from mbproj.elements.element import Element, Force, Kind, Place, Row, State, called

__all__ = ["Element", "Force", "Kind", "Place", "Row", "State", "called"]
