"""`register_force` and `register_element`: they add types of force, which run wherever those of mbproj run.

A force is a formula of its coordinate. An element is a function that returns what `mbproj.functions` describes: forces
along several coordinates, states with their rates, rows between coordinates.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from keyword import iskeyword
from numbers import Real
from typing import Literal

from mbproj.base.errors import InputError, Problem
from mbproj.base.plugins import blamed
from mbproj.functions.elements import Element, Force, Place
from mbproj.functions.program import CHANNELS, COORDINATE, RATE, TIME, Program
from mbproj.scene.blocks.elements import ELEMENTS, ElementType
from mbproj.scene.blocks.forces import OWN_RECORDS, TWO_ENDS
from mbproj.scene.expressions.compiled import compiled
from mbproj.scene.expressions.dimensions import Inferred, describe
from mbproj.scene.expressions.evaluate import RESERVED, Value
from mbproj.scene.expressions.syntax_tree import ExpressionError, parse
from mbproj.scene.expressions.units import TIME as SECONDS
from mbproj.scene.expressions.units import Dimension
from mbproj.scene.fields.quantities import Number, dimension_of
from mbproj.scene.text.nodes import plain

#: The variables that the formula of a force, or of its energy, may name.
OF_FORCE: Mapping[str, int] = {"t": TIME, "s": COORDINATE, "s_dot": RATE}
OF_ENERGY: Mapping[str, int] = {"t": TIME, "s": CHANNELS, "s_dot": CHANNELS + 1}
#: Names that no parameter may have: they are keys of every type of force, or variables of a formula.
TAKEN = frozenset({"type", "name", "joint", "coordinate", *TWO_ENDS, *OF_FORCE})


def register_force(
    name: str,
    *,
    along: Literal["m", "rad"],
    force: str,
    parameters: Mapping[str, str],
    defaults: Mapping[str, float] | None = None,
    positive: Collection[str] = (),
    stores: str | None = None,
    loses: bool = False,
) -> None:
    """Adds a type of force to those that a scene may name: a formula of t, s and s_dot, the coordinate in m or rad.

    In m it acts on a joint's coordinate or along the distance of two points. `force` is in N or N*m, positive where
    it drives s up. `parameters` are its keys with their SI units, as {"k": "N/m^3"}; those without one of the
    `defaults` have to be given. `stores` is its stored energy in J. `loses`: whether the rest of the energy that it
    takes is lost.

    Raises InputError where a name cannot be one, or a formula cannot be read or has another unit.
    """
    keys = _keys(name, along, parameters, defaults or {}, positive)
    units = {"s": dimension_of(along), "s_dot": dimension_of(f"{along}/s"), "t": SECONDS}
    dimensions = {**units, **{key: dimension_of(field.unit or "") for key, field in keys.items()}}
    push = _formula(name, force, OF_FORCE, dimensions, "N*m" if along == "rad" else "N")
    energy = None if stores is None else _formula(name, stores, OF_ENERGY, dimensions, "J")

    def make(called: str, s: str, **values: float) -> Element:
        numbers = {key: Value(value) for key, value in {**(defaults or {}), **values}.items()}
        return Element(
            called,
            reads=(s, f"{s}_dot"),
            forces=(Force(s, push(numbers), loses=loses),),
            stores=None if energy is None else energy(numbers),
        )

    text = repr((along, force, dict(parameters), defaults, sorted(positive), stores, loses))
    _add(name, ElementType(along, keys, make, _required(keys, defaults)), text)


def register_element(
    name: str,
    make: Callable[..., Element],
    *,
    along: Literal["m", "rad"],
    parameters: Mapping[str, str],
    defaults: Mapping[str, float] | None = None,
    positive: Collection[str] = (),
) -> None:
    """Adds a type of force that is an element: `make(name, s, **parameters)` is the element of this name that acts
    along the coordinate named s, in m or rad, with the parameters in SI units.

    In m it acts on a joint's coordinate or along the distance of two points. `parameters`, `defaults` and `positive`
    are as those of `register_force`. Raises InputError where a name cannot be one.
    """
    keys = _keys(name, along, parameters, defaults or {}, positive)

    def checked_make(called: str, s: str, **values: float) -> Element:
        with blamed(f"force type '{name}'"):
            element = make(called, s, **{**(defaults or {}), **values})
            if not isinstance(element, Element):
                raise TypeError(f"it makes {element!r}, which is no mbproj.functions.elements.Element")
            _check_real(element)
            return element

    _add(name, ElementType(along, keys, checked_make, _required(keys, defaults)), make)


def _check_real(element: Element) -> None:
    """Raises TypeError where a number of the element is not real: a cast would drop an imaginary part."""
    numbers: dict[str, object] = {}
    for state in element.states:
        numbers |= {f"'start' of state '{state.name}'": state.start, f"'scale' of state '{state.name}'": state.scale}
    for row in element.rows:
        numbers |= {f"'of' of row '{row.name}', '{name}',": weight for name, weight in row.of.items()}
        numbers |= {f"'constant' of row '{row.name}'": row.constant, f"'period' of row '{row.name}'": row.period or 0.0}
    numbers |= {f"the inertia of '{name}'": inertia for name, inertia in element.inertias.items()}
    for name, ends in element.lengths.items():
        places = [end.location if isinstance(end, Place) else end for end in ends if not isinstance(end, str)]
        numbers |= {f"a place of the length '{name}', {number!r},": number for place in places for number in place}
    for program in _programs(element):
        numbers |= {f"'{program.text or name}', {each!r},": each for name, each in _operands(program)}
    for what, number in numbers.items():
        if not isinstance(plain(number), Real):
            raise TypeError(f"{what} is {number!r}, which is no real number")


def _programs(element: Element) -> Iterator[Program]:
    """The programs of an element; its expressions have no other numbers than real ones."""
    programs = [each.rate for each in element.states] + [each.push for each in element.forces]
    programs += [each.function for each in element.rows if each.function is not None]
    yield from (each for each in (*programs, element.stores, element.lost) if isinstance(each, Program))


def _operands(program: Program) -> Iterator[tuple[str, object]]:
    yield from ((each.op.name.lower(), each.operand) for each in program.code)


def _add(name: str, kind: ElementType, made_of: Callable[..., object] | str) -> None:
    ELEMENTS.add(name, kind, made_of, taken=OWN_RECORDS)


def _required(keys: Mapping[str, object], defaults: Mapping[str, float] | None) -> tuple[str, ...]:
    return tuple(key for key in keys if key not in (defaults or {}))


def _unfit(name: str, what: str, hint: str | None = None) -> InputError:
    return InputError(Problem(f"force type '{name}': {what}", hint=hint))


def _keys(
    name: str, along: str, parameters: Mapping[str, str], defaults: Mapping[str, float], positive: Collection[str]
) -> dict[str, Number]:
    """The field that reads each parameter in a scene. Raises InputError for a bad name, unit or bound."""
    if along not in ("m", "rad"):
        raise _unfit(name, f"'along' is 'm' or 'rad', found {along!r}")
    for key, unit in parameters.items():
        if not key.isidentifier() or iskeyword(key) or key in RESERVED or key in TAKEN:
            raise _unfit(name, f"'{key}' cannot be the name of a parameter", "take another word")
        try:
            dimension_of(unit)
        except (ExpressionError, ValueError) as error:
            raise _unfit(name, f"parameter '{key}': {error}", "units are as in a scene: N/m^3, kg*m^2") from error
    for key, value in defaults.items():
        if not isinstance(plain(value), Real):
            raise _unfit(name, f"the default of '{key}' is {value!r}, which is no real number")
    for key in (*defaults, *positive):
        if key not in parameters:
            raise _unfit(name, f"there is no parameter '{key}'", f"parameters are: {', '.join(parameters)}")
    return {key: Number(unit, above=0.0 if key in positive else None) for key, unit in parameters.items()}


def _formula(
    name: str, text: str, variables: Mapping[str, int], dimensions: Mapping[str, Dimension], unit: str
) -> Callable[[Mapping[str, Value]], Program]:
    """A function that returns the program of a formula for given values of the parameters. Raises InputError where the
    formula cannot be read, or is in another unit."""
    try:
        tree = parse(text, frozenset(dimensions))
        symbols = {key: at for at, key in enumerate(dimensions)}
        known = {key: Inferred.of(each) for key, each in dimensions.items()}
        dimension = compiled(tree, {}, symbols, known)[1].dimension
    except ExpressionError as error:
        raise _unfit(name, f"'{text}': {error}", error.hint) from error
    if dimension is not None and not dimension_of(unit).agrees(dimension):
        raise _unfit(name, f"'{text}' is {describe(dimension)}, not in {unit}", "check the units of the parameters")
    return lambda numbers: Program(compiled(tree, numbers, variables)[0], text)
