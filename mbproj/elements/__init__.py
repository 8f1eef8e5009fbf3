"""What acts through channels: elements are data, one file a kind."""

from mbproj.elements.element import Element, Force, Row, State

__all__ = ["Element", "Force", "Row", "State"]
