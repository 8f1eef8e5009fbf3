"""`dataclass` as the standard library has it, but late: a class gets its `__init__` when its first instance is made,
and its fields are found when somebody asks for them.

The standard decorator compiles up to six functions for each class, which takes 0.8 ms; a run imports 220 classes, makes
instances of 90 and compares those of four. Here all classes share one copy of each function that need not be fast.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import MISSING, Field, FrozenInstanceError, fields
from functools import cache
from reprlib import recursive_repr
from threading import RLock
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dataclasses import dataclass as dataclass
else:

    def dataclass(cls=None, /, *, frozen=False, eq=True):
        """As `dataclasses.dataclass` with the same options."""
        return _completed(cls, frozen, eq) if cls else lambda cls: _completed(cls, frozen, eq)


def _completed(cls: type, frozen: bool, eq: bool) -> type:
    """Add the generated methods to `cls`, and placeholders for its fields. Methods that it defines itself stay."""
    methods: dict[str, Any] = {"__init__": _first_init(cls), "__repr__": _repr}
    if eq:
        methods |= _comparing(cls, hashed=frozen)
    if frozen:
        methods |= {"__setattr__": _refuse, "__delattr__": _refuse}
    for name, method in methods.items():
        if name not in cls.__dict__:
            setattr(cls, name, method)
    declared = {name: value for name, value in vars(cls).items() if isinstance(value, Field)}
    for name, value in declared.items():
        if value.default is MISSING:
            delattr(cls, name)
        else:
            setattr(cls, name, value.default)
    for name in _Later.NAMES:
        setattr(cls, name, _Later(cls, name, declared))
    return cls


def declared_fields(cls: type) -> Mapping[str, Field[Any]]:
    """The fields that a class itself declares by `field`, by name; `fields` would look at all annotations, too."""
    later = vars(cls)["__dataclass_fields__"]
    return later.declared if isinstance(later, _Later) else {name: later[name] for name in vars(cls)["__annotations__"]}


#: The lock while a class finds its fields, because threads may ask at once. It is reentrant, because a class asks its
#: bases.
_COMPLETING = RLock()


class _Later:
    """A placeholder for an attribute that the standard decorator adds to a class; it is filled when first read.

    It is replaced and never deleted: without it another thread would read the attribute of a base class.
    """

    MATCHED = "__match_args__"
    NAMES = ("__dataclass_fields__", "__dataclass_params__", MATCHED)

    def __init__(self, cls: type, name: str, declared: Mapping[str, Field[Any]]) -> None:
        self._class, self._name, self.declared = cls, name, declared

    def __get__(self, record: object, cls: type | None = None) -> Any:
        with _COMPLETING:
            if self._class.__dict__.get(self._name) is self:
                for name, value in self.declared.items():
                    setattr(self._class, name, value)
                dataclasses.dataclass(init=False, repr=False, eq=False, match_args=False)(self._class)
                setattr(self._class, self.MATCHED, tuple(each.name for each in fields(self._class)))
        return getattr(self._class, self._name)


def _first_init(cls: Any) -> Any:
    def first_init(self: object, *values: object, **named: object) -> None:
        cls.__init__ = _written_init(cls)
        cls.__init__(self, *values, **named)

    return first_init


def _written_init(cls: Any) -> Any:
    """Compile `__init__` with a parameter for each field: instances are made often, so that it has to be fast."""
    scope: dict[str, Any] = {"_store": object.__setattr__, "_MISSING": MISSING}
    parameters, lines = ["self"], []
    for each in fields(cls):
        name, value = each.name, each.name
        if each.default_factory is not MISSING:
            scope[f"_make_{name}"] = each.default_factory
            parameters.append(f"{name}=_MISSING")
            value = f"_make_{name}() if {name} is _MISSING else {name}"
        elif each.default is not MISSING:
            scope[f"_default_{name}"] = each.default
            parameters.append(f"{name}=_default_{name}")
        else:
            parameters.append(name)
        lines.append(f"_store(self, {name!r}, {value})")
    if hasattr(cls, "__post_init__"):
        lines.append("self.__post_init__()")
    exec(f"def __init__({', '.join(parameters)}):\n  " + "\n  ".join(lines or ["pass"]), scope)
    init = scope["__init__"]
    init.__qualname__ = f"{cls.__qualname__}.__init__"
    return init


def _comparing(cls: Any, *, hashed: bool) -> dict[str, Any]:
    """Return `__eq__` and `__hash__` that compare and hash the values of the fields."""

    @cache
    def names() -> tuple[str, ...]:
        return tuple(each.name for each in fields(cls) if each.compare)

    def values(record: object) -> tuple[object, ...]:
        return tuple([getattr(record, name) for name in names()])

    def eq(self: object, other: object) -> bool:
        return values(self) == values(other) if other.__class__ is self.__class__ else NotImplemented

    return {"__eq__": eq, "__hash__": (lambda self: hash(values(self))) if hashed else None}


@recursive_repr()
def _repr(self: Any) -> str:
    shown = ", ".join(f"{each.name}={getattr(self, each.name)!r}" for each in fields(self) if each.repr)
    return f"{self.__class__.__qualname__}({shown})"


#: The most lines of `brief`, and the most characters of one.
LINES, LETTERS = 15, 79


def brief(self: Any) -> str:
    """A `__repr__` for values that a prompt or a notebook shows: a line for each field, arrays by their shape."""
    lines = [self.__class__.__qualname__]
    for each in fields(self):
        value = getattr(self, each.name)
        shape = getattr(value, "shape", ())
        if shape or isinstance(value, (tuple, list, dict)):
            what = f"array {shape}" if shape else f"{type(value).__name__} of {len(value)}"
        else:
            what = getattr(type(value), "__qualname__", "") if hasattr(value, "__dataclass_fields__") else repr(value)
        line = f"  {each.name:18} {what}"
        lines.append(line if len(line) <= LETTERS else f"{line[: LETTERS - 3]}...")
    more = len(lines) - LINES
    return "\n".join(lines if more <= 0 else [*lines[: LINES - 1], f"  and {more + 1} more"])


def _refuse(self: object, name: str, *value: object) -> None:
    raise FrozenInstanceError(f"cannot {'assign to' if value else 'delete'} field {name!r}")
