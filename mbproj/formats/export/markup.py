"""Readable XML: one tag on each line, indented, with numbers from which the same numbers are read."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field
from xml.sax.saxutils import quoteattr

import numpy as np

from mbproj.dataclass import dataclass

#: A number of an array is written as 0 where it is less than this part of the largest one.
ROUND_OFF = 1e-15


@dataclass(eq=False)
class Tag:
    """An element with its attributes as texts, and the elements in it."""

    name: str
    attributes: dict[str, str] = field(default_factory=dict)
    children: list[Tag] = field(default_factory=list)

    def add(self, name: str, /, **attributes: object) -> Tag:
        """Add a new element to this one, and return it. Attributes that are None are left out; `class_` is class."""
        child = tag(name, **attributes)
        self.children.append(child)
        return child

    def lines(self, indent: int = 0) -> Iterator[str]:
        """The lines of the element's text."""
        head = f"{' ' * indent}<{self.name}" + "".join(f" {k}={quoteattr(v)}" for k, v in self.attributes.items())
        if not self.children:
            yield f"{head}/>"
            return
        yield f"{head}>"
        for child in self.children:
            yield from child.lines(indent + 2)
        yield f"{' ' * indent}</{self.name}>"


def tag(name: str, /, **attributes: object) -> Tag:
    """An element; numbers and arrays become text."""
    return Tag(name, {key: _text(value) for key, value in attributes.items() if value is not None})


def _text(value: object) -> str:
    if isinstance(value, str):
        return value
    numbers = np.atleast_1d(np.asarray(value, dtype=float)).ravel()
    least = ROUND_OFF * float(np.abs(numbers).max(initial=0.0))
    return " ".join(_number(float(each)) if abs(each) > least else "0" for each in numbers)


def _number(value: float) -> str:
    """The shortest text from which the same number is read."""
    return repr(int(value)) if value == int(value) and abs(value) < 1e15 else repr(value)
