"""The kinds of values of options and arguments: a number with a unit, several, names, words, a count, a file.

The command line and Python read a value by the same rule, `Kind.of`, with the same message.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Collection, Iterable, Sequence
from operator import index
from typing import Any, ClassVar, final

import click
from click.shell_completion import CompletionItem

from mbproj.base.errors import InputError, Place, Problem, choose_from


class Kind(click.ParamType):  # type: ignore[type-arg]  # generic in the newest click alone
    """A kind of value."""

    name = "value"

    @abstractmethod
    def of(self, value: Any, place: str) -> Any:
        """Return what `value` stands for, which may be text. Raises InputError at `place`."""

    def joined(self, values: tuple[Any, ...]) -> Any:
        """Return one value for those of an option that is given several times."""
        return values

    @final
    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return what a text of the command line stands for."""
        return self.of(value, param.opts[0] if param is not None else "")


class AnyNumber(Kind):
    """A number in the SI unit `unit`: "1e-6", "1 mm", "2 min". Any unit may stand where `unit` is None."""

    bounds: ClassVar[dict[str, float]] = {}

    def __init__(self, unit: str | None, **bounds: float) -> None:
        self.unit, self._bounds = unit, {**self.bounds, **bounds}

    def of(self, value: Any, place: str) -> Any:
        """Return the number in SI."""
        from mbproj.scene.fields.quantities import Number, given_number

        return given_number(value, place, Number(self.unit, **self._bounds))


class Positive(AnyNumber):
    """A positive number in the SI unit `unit`."""

    bounds: ClassVar[dict[str, float]] = {"above": 0.0}


class NotNegative(AnyNumber):
    """A number in the SI unit `unit` that is not below 0."""

    bounds: ClassVar[dict[str, float]] = {"minimum": 0.0}


class Several(Kind):
    """Several values of one kind: "0.01,5 ms" or a list; one value stands for itself. `between` parts a text."""

    def __init__(self, kind: Kind, between: str = ",") -> None:
        self._kind, self._between = kind, between

    def of(self, value: Any, place: str) -> tuple[Any, ...]:
        """Return the values, a tuple."""
        if isinstance(value, str):
            value = value.split(self._between)
        parts: Iterable[Any] = value if isinstance(value, Iterable) else [value]
        return tuple(self._kind.of(part, place) for part in parts)


class Pair(Kind):
    """Two positive numbers in the SI unit `unit`, "20,40"; one stands for two equal ones."""

    def __init__(self, unit: str) -> None:
        self._number = Positive(unit)

    def of(self, value: Any, place: str) -> tuple[float, float]:
        """Return the two numbers in SI."""
        parts = value.split(",") if isinstance(value, str) else [*value] if isinstance(value, Sequence) else [value]
        if len(parts) not in (1, 2):
            raise InputError(Problem(f"'{value}' is not one number or two", Place(place), "e.g. 5,5;20,40"))
        return self._number.of(parts[0], place), self._number.of(parts[-1], place)


@final
class Count(Kind):
    """A whole number between two bounds. Raises TypeError for a number that is not whole."""

    name = "n"

    def __init__(self, least: int = 0, most: int | None = None) -> None:
        self._least, self._most = least, most

    def of(self, value: Any, place: str) -> int:
        """Return the number, also where it is text or NumPy's."""
        try:
            number = int(value) if isinstance(value, str) else index(value)
        except ValueError:
            raise InputError(Problem(f"'{value}' is no whole number", Place(place))) from None
        if number < self._least:
            raise InputError(Problem(f"it must be at least {self._least}, found {number}", Place(place)))
        if self._most is not None and number > self._most:
            raise InputError(Problem(f"it must be at most {self._most}, found {number}", Place(place)))
        return number


@final
class Millimetres(Kind):
    """A width in mm, or a width and a height: "85", "85,60", "85 mm, 60 mm"."""

    def of(self, value: Any, place: str) -> tuple[float, ...]:
        """Return the numbers in mm, a tuple of one or two."""
        if isinstance(value, tuple):
            return value
        from mbproj.base.text import plain_number

        try:
            lengths = tuple(plain_number(part.strip().removesuffix("mm")) for part in value.split(","))
        except ValueError:
            lengths = ()
        if len(lengths) not in (1, 2):
            problem = f"'{value}' is no width in mm, nor a width and a height, as 85 or 85,60"
            raise InputError(Problem(problem, Place(place)))
        return lengths


class Names(Kind):
    """Several names: "gopm,gpopm" or a list."""

    def of(self, value: Any, place: str) -> tuple[Any, ...]:
        """Return the names, a tuple. Raises TypeError where they are neither text nor a list."""
        if not isinstance(value, Iterable):
            raise TypeError(f"names are a text or a list of texts, found {type(value).__name__}")
        return tuple(part.strip() for part in value.split(",")) if isinstance(value, str) else tuple(map(str, value))

    def joined(self, values: tuple[Any, ...]) -> Any:
        """Return all names."""
        return tuple(name for names in values for name in names)


@final
class TruthValues(Names):
    """Several truth values: "false,true"."""

    WORDS = ("false", "true")

    def of(self, value: Any, place: str) -> tuple[bool, ...]:
        """Return the truth values of words."""
        names = super().of([value] if isinstance(value, bool) else value, place)
        for name in names:
            if name.lower() not in self.WORDS:
                hint = "give false, true or false,true"
                raise InputError(Problem(f"'{name}' is neither false nor true", Place(place), hint))
        return tuple(name.lower() == "true" for name in names)


@final
class Corners(Names):
    """Three markers, of which the second is the corner of an angle."""

    def of(self, value: Any, place: str) -> tuple[str, ...]:
        """Return the three names."""
        names = super().of(value, place)
        if len(set(names)) != 3 or len(names) != 3:
            raise InputError(Problem(f"'{value}' is not three markers", Place(place), "give FIRST,CORNER,SECOND"))
        return names

    def joined(self, values: tuple[Any, ...]) -> Any:
        """Return the corners one by one."""
        return values


@final
class Assignments(Kind):
    """Values by name: NAME=VALUE, or a mapping. `value` reads one, at the place "--option NAME"."""

    def __init__(self, value: Callable[[str, Any, str], Any], example: str) -> None:
        self._value, self._example = value, example

    def of(self, value: Any, place: str) -> dict[str, Any]:
        """Return the values by name."""
        if not isinstance(value, str):
            return {name: self._value(name, each, place) for name, each in dict(value).items()}
        name, equals, text = (part.strip() for part in value.partition("="))
        if not equals or not name or not text:
            raise InputError(Problem(f"'{value}' is not NAME=VALUE", Place(place), f"e.g. {self._example}"))
        return {name: self._value(name, text, place)}

    def joined(self, values: tuple[Any, ...]) -> dict[str, Any]:
        """Return all values by name; the last of a name counts."""
        return {name: value for each in values for name, value in each.items()}


class Words(Kind):
    """A word of a registry. The registry is read only where its words are shown, because a search for plug-ins takes
    time."""

    def __init__(self, words: Collection[str]) -> None:
        self._words = words

    def of(self, value: Any, place: str) -> Any:
        """Return the word, also one that is not known: the reader of settings tells of that."""
        return value

    def get_metavar(self, param: click.Parameter, ctx: click.Context | None = None) -> str:
        """The words, as the help shows the values of an option."""
        return "|".join(self._words)

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        """The words that begin with `incomplete`."""
        return [CompletionItem(word) for word in self._words if word.startswith(incomplete)]


@final
class OneOf(Words):
    """One of several words."""

    def of(self, value: Any, place: str) -> str:
        """Return the word. Raises TypeError where it is no text."""
        from mbproj.base.text import text_of

        if (word := text_of(value, place.removeprefix("--"))) not in self._words:
            raise InputError(Problem(f"there is no '{word}'", Place(place), choose_from(word, self._words)))
        return word
