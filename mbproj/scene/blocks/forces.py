"""The `forces` block: the records that read each type of force: laws, bushings, forces on bodies, elements.

The force `friction` on coordinates of a joint: viscous (`coefficient`), dry (`coulomb`), or both.

type: friction, joint: B, coefficient: 3
type: friction, joint: B, coulomb: {torque: 4 N*m, static: 5 N*m, stribeck_speed: 0.05 rad/s}
type: friction, joint: A, coulomb: {coefficient: 0.2, static: 0.3, radius: 10 mm, bearing_length: 30 mm}
type: friction, joint: S, coulomb: {angle: {coefficient: 0.1, radius: 6 mm}, displacement: {force: 2 N}}
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from types import MappingProxyType
from typing import Any, final

from mbproj.functions.program import COORDINATE, Program, variable
from mbproj.functions.standard import tabulated
from mbproj.scene.blocks.coordinates import COORDINATES
from mbproj.scene.blocks.elements import ELEMENTS, ElementType, element_type
from mbproj.scene.blocks.friction import COULOMB
from mbproj.scene.blocks.stops import stop_record
from mbproj.scene.fields import rotations
from mbproj.scene.fields.fields import (
    Alternatives,
    Converted,
    Field,
    List,
    NameChoice,
    NameReference,
    OneOf,
    Record,
    Rule,
    Variants,
)
from mbproj.scene.fields.functions import Function, Varying, table
from mbproj.scene.fields.placing import (
    BODY_POINT,
    FRAMES,
    JOINT_POINT,
    ORIENTATION,
    POINTS_OF,
    TWO_BODIES,
    TWO_POINTS,
    two_ends,
)
from mbproj.scene.fields.quantities import Number, of_these_bodies, pair_of, position_in, rows, vector
from mbproj.scene.fields.reading import Unfit
from mbproj.scene.records import (
    BodyForce,
    Bushing,
    DryFriction,
    Force,
    JointForce,
    Kind,
    Law,
    Matrix,
    Orientations,
    PointForce,
    Vector,
)

# --- The force `bushing` ----------------------------------------------------------------------------------------------
# An elastic element that resists the relative translation and rotation of two frames:
#     type: bushing
#     bodies: [ground, arm]
#     location: [0, 0, 0]                             # global, or by body in its own axes
#     axes: {euler: [0, 30 deg, 0], sequence: xyz}    # of both frames, global; or by body, each in its body's axes
#     stiffness: {translation: [1e6, 1e6, 2e5], rotation: [[300, 10, 0], [10, 300, 0], [0, 0, 20]]}
#     damping: {...}, preload: {...}


NONE: Vector = (0.0, 0.0, 0.0)
#: The default axes: both frames have the global axes at the scene's pose.
GLOBAL_AXES = Orientations((1.0, 0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))

TWO_FRAMES: Field[Any] = Alternatives((Converted(ORIENTATION, lambda axes: Orientations(axes, axes)), FRAMES))


def _definite(what: str, matrix: Matrix) -> Matrix:
    """The matrix of a stiffness or damping, made exactly symmetric. Raises Unfit where it could give energy away."""
    symmetric = rotations.symmetric(matrix)
    if symmetric is None:
        raise Unfit("is not symmetric", f"a {what} has equal numbers in row 1, column 2 and in row 2, column 1")
    least, _, largest = rotations.principal_moments(symmetric)
    if least < -rotations.ROUND_OFF * max(abs(least), abs(largest)):
        raise Unfit(f"has the negative eigenvalue {least:.6g}", f"no {what} gives energy away")
    return symmetric


def _resistance(what: str, per_length: str, per_angle: str) -> Field[tuple[Matrix, Matrix]]:
    """The field of two matrices, for translation and for rotation; each may be given by its diagonal."""

    def matrix(unit: str) -> Field[Matrix]:
        diagonal = Converted(List(Number(unit, minimum=0.0), 3), rotations.from_principal)
        return Converted(Alternatives((diagonal, rows(unit))), partial(_definite, what))

    zero = rotations.from_principal(NONE)
    keys: dict[str, Field[Any]] = {"translation": matrix(per_length), "rotation": matrix(per_angle)}
    return Record(f"a {what}", keys, lambda translation=zero, rotation=zero: (translation, rotation))


def _bushing(
    name: str, type: str, bodies: tuple[str, str], location: Any, axes: Any = GLOBAL_AXES, **keys: Any
) -> Bushing:
    if not any(any(map(any, part)) for part in (*keys.get("stiffness", ()), *keys.get("damping", ()))) and not any(
        map(any, keys.get("preload", ()))
    ):
        raise Unfit("does nothing", "give a 'stiffness', a 'damping' or a 'preload' that is not zero")
    if isinstance(axes, Mapping):
        axes = Orientations(axes[bodies[0]], axes[bodies[1]], local=True)
    return Bushing(name, bodies, pair_of(location, bodies), axes, **keys)


def bushing_record(force_type: NameChoice) -> Record[Force]:
    """The record that reads a bushing."""
    preload = {"translation": vector("N"), "rotation": vector("N*m")}
    return Record(
        "a bushing",
        {
            "type": force_type,
            "bodies": TWO_BODIES,
            "location": JOINT_POINT,
            "axes": TWO_FRAMES,
            "stiffness": _resistance("stiffness", "N/m", "N*m/rad"),
            "damping": _resistance("damping", "N*s/m", "N*m*s/rad"),
            "preload": Record("a preload", preload, lambda translation=NONE, rotation=NONE: (translation, rotation)),
        },
        _bushing,
        ("type", "bodies", "location"),
        (
            Rule(("bodies", "location"), of_these_bodies("location")),
            Rule(("bodies", "axes"), of_these_bodies("axes")),
        ),
        named=True,
    )


# --- All types of force -----------------------------------------------------------------------------------------------


COEFFICIENT = Number(None, minimum=0.0)
#: Coefficients of viscous friction on coordinates in m and rad.
VISCOUS: Mapping[str, Field[Any]] = {"m": Number("N*s/m", minimum=0.0), "rad": Number("N*m*s/rad", minimum=0.0)}


def _friction(
    name: str,
    type: str,
    joint: str,
    coefficient: Mapping[str, float] | None = None,
    coulomb: Mapping[str, DryFriction] | None = None,
) -> JointForce:
    if coefficient is None and coulomb is None:
        raise Unfit("does nothing", "give 'coefficient', which is viscous, or 'coulomb', which is dry, or both")
    viscous = {key: Law(damping=value) for key, value in (coefficient or {}).items()}
    return JointForce(name, joint, viscous, coulomb=coulomb or {})


def friction_record(force_type: NameChoice) -> Record[Force]:
    """The record that reads friction on a joint."""
    return Record(
        "a friction",
        {
            "type": force_type,
            "joint": NameReference("joint", "joints"),
            "coefficient": Alternatives(
                (
                    Converted(COEFFICIENT, lambda coefficient: {"": coefficient}),
                    Record("a coefficient", {name: VISCOUS[unit] for name, unit in COORDINATES.items()}, dict),
                )
            ),
            "coulomb": COULOMB,
        },
        _friction,
        ("type", "joint"),
        named=True,
    )


def _law_keys(force: str, coordinate: str, unit: str, free: str) -> dict[str, Field[Any]]:
    """The keys of a law whose function is called `force`, in N or N*m, on a coordinate in m or rad."""
    value = "N*m" if unit == "rad" else "N"
    per_unit = "N*m/rad" if unit == "rad" else "N/m"
    per_rate = "N*m*s/rad" if unit == "rad" else "N*s/m"
    return {
        "stiffness": Varying(Number(per_unit, minimum=0.0)),
        "damping": Varying(Number(per_rate, minimum=0.0)),
        free: Varying(Number(unit, minimum=0.0) if free == "free_length" else position_in(unit)),
        force: Function(
            value, ("t", coordinate, f"{coordinate}_dot"), units=("s", unit, f"{unit}/s"), names_channels=True
        ),
        "table": table(unit, value, ("natural", "clamped", "linear")),
    }


def _law_choices(force: str, free: str) -> tuple[OneOf, ...]:
    return (
        OneOf(("stiffness", force, "table"), hint=f"'{force}' and 'table' are the whole force of the spring"),
        OneOf((free, force)),
        OneOf((free, "table")),
        OneOf(("damping", force), hint=f"write the damping into '{force}'"),
    )


def _law(keys: Mapping[str, Any], force: str, free: str, default: float | None) -> Law:
    """The law of the given keys, with `default` for `free`. Raises Unfit where it has no effect, or a key too many."""
    if not any(key in keys for key in ("stiffness", "damping", force, "table")):
        raise Unfit("does nothing", f"give 'stiffness', 'damping', '{force}' or 'table'")
    if free in keys and "stiffness" not in keys:
        raise Unfit(f"has a '{free}' and no 'stiffness'", "give the stiffness of the spring")
    function: Program | None = keys.get(force)
    if "table" in keys:
        function = Program(tabulated(keys["table"], variable(COORDINATE)))
    return Law(keys.get("stiffness", 0.0), keys.get("damping", 0.0), keys.get(free, default), function)


def _varying(type: str, law: Mapping[str, Any], free: str) -> Kind | None:
    """The element that replaces a spring where a number of its law changes in a run; None for other springs."""
    if not any(isinstance(law.get(key), Program) for key in ("stiffness", "damping", free)):
        return None
    values = dict(law)
    if "table" in law:
        values["table"] = Program(tabulated(law["table"], variable(COORDINATE)))
    return Kind(type, values, element_type(type).units)


def _spring(
    name: str, type: str, points: Any = None, bodies: Any = None, locations: Any = None, **law: Any
) -> PointForce:
    bodies, pair = two_ends(points, bodies, locations)
    spring, varies = _law(law, "force", "free_length", None), _varying(type, law, "free_length")
    return PointForce(name, bodies, pair, Law() if varies else spring, varies)


def _joint_spring(force: str, free: str, unit: str) -> Any:
    def make(name: str, type: str, joint: str, coordinate: str = "", **law: Any) -> JointForce:
        spring, varies = _law(law, force, free, 0.0), _varying(type, law, free)
        return JointForce(name, joint, {coordinate: Law() if varies else spring}, unit, element=varies)

    return make


def _body_force(
    name: str, type: str, body: str, location: Any = None, axes: str = "global", **vector: Any
) -> BodyForce:
    ((key, components),) = vector.items()
    local = isinstance(location, Mapping)
    return BodyForce(
        name, body, components, key == "torque", axes == "body", location[body] if local else location, local
    )


FORCE_TYPE = NameChoice("force type", lambda: FORCE_RECORDS)
JOINT = NameReference("joint", "joints")
AXES = NameChoice("axes", lambda: ("global", "body"))


def _on_joint(what: str, force: str, coordinate: str, unit: str, free: str) -> Record[Force]:
    """The record that reads a spring, a damper or a law on a coordinate of a joint."""
    able = NameChoice("coordinate", lambda: [name for name, its in COORDINATES.items() if its == unit])
    keys = {"type": FORCE_TYPE, "joint": JOINT, "coordinate": able, **_law_keys(force, coordinate, unit, free)}
    choices = _law_choices(force, free)
    return Record(what, keys, _joint_spring(force, free, unit), ("type", "joint"), choices=choices, named=True)


def _on_body(what: str, key: str, unit: str, place: Mapping[str, Field[Any]]) -> Record[Force]:
    """The record that reads a force or a torque of given components."""
    body = {"type": FORCE_TYPE, "body": NameReference("body", "bodies")}
    components = List(Function(unit, names_channels=True), 3, "components")
    keys: dict[str, Field[Any]] = {**body, **place, key: components, "axes": AXES}
    checks = (Rule(("body", "location"), of_these_bodies("location")),) if place else ()
    return Record(what, keys, _body_force, ("type", "body", key), checks, named=True)


def _of_element(type_name: str, kind: ElementType) -> Record[Force]:
    """The record that reads a force that is an element, on a coordinate of a joint or between two points."""
    able = NameChoice("coordinate", lambda: [name for name, its in COORDINATES.items() if its == kind.along])
    keys: dict[str, Field[Any]] = {"type": FORCE_TYPE, "joint": JOINT, "coordinate": able}
    required, choices, checks = ("type", "joint", *kind.required), kind.choices, tuple[Rule, ...]()
    if kind.along == "m":
        keys |= TWO_ENDS
        required, checks = ("type", *kind.required), END_CHECKS
        choices = (OneOf(("joint", "points", "bodies"), needed=True), OneOf(("joint", "locations")), *END_CHOICES)
        choices = (*choices, *kind.choices)

    def make(
        name: str,
        type: str,
        joint: str = "",
        coordinate: str = "",
        points: Any = None,
        bodies: Any = None,
        locations: Any = None,
        **values: Any,
    ) -> Force:
        element = Kind(type_name, values, kind.units)
        if joint:
            return JointForce(name, joint, {coordinate: Law()}, kind.along, element=element)
        if coordinate:
            raise Unfit("has a 'coordinate' and no 'joint'", "name the joint whose coordinate it is")
        return PointForce(name, *two_ends(points, bodies, locations), Law(), element)

    keys |= kind.keys
    article = "an" if type_name[0] in "aeiou" else "a"
    return Record(f"{article} {type_name}", keys, make, required, checks, choices, named=True)


TWO_ENDS: Mapping[str, Field[Any]] = {"points": POINTS_OF, "bodies": TWO_BODIES, "locations": TWO_POINTS}
END_CHECKS = (Rule(("bodies", "locations"), of_these_bodies("locations")),)
END_CHOICES = (OneOf(("points", "locations"), hint="'points' are in global axes, 'locations' go with 'bodies'"),)

OWN_RECORDS: Mapping[str, Record[Force]] = MappingProxyType(
    {
        "spring_damper": Record(
            "a spring_damper",
            {"type": FORCE_TYPE, **TWO_ENDS, **_law_keys("force", "l", "m", "free_length")},
            _spring,
            ("type",),
            END_CHECKS,
            (
                OneOf(("points", "bodies"), needed=True),
                *END_CHOICES,
                *_law_choices("force", "free_length"),
            ),
            named=True,
        ),
        "torsion_spring_damper": _on_joint("a torsion_spring_damper", "torque", "angle", "rad", "free_angle"),
        "linear_spring_damper": _on_joint("a linear_spring_damper", "force", "displacement", "m", "free_displacement"),
        "bushing": bushing_record(FORCE_TYPE),
        "stop": stop_record(FORCE_TYPE),
        "force": _on_body("a force", "force", "N", {"location": BODY_POINT}),
        "torque": _on_body("a torque", "torque", "N*m", {}),
        "friction": friction_record(FORCE_TYPE),
        **{name: _of_element(name, kind) for name, kind in ELEMENTS.builtin.items()},
    }
)


@final
class ForceRecords(Mapping[str, Record[Force]]):
    """The record that reads each type of force, by its name: those of mbproj, and the elements of plug-ins."""

    def __getitem__(self, name: str) -> Record[Force]:
        return OWN_RECORDS[name] if name in OWN_RECORDS else _of_element(name, ELEMENTS[name])

    def __iter__(self) -> Iterator[str]:
        yield from (*OWN_RECORDS, *ELEMENTS.added)

    def __len__(self) -> int:
        return len(OWN_RECORDS) + len(ELEMENTS.added)


FORCE_RECORDS: Mapping[str, Record[Force]] = ForceRecords()

FORCE: Variants[Force] = Variants("type", FORCE_TYPE, FORCE_RECORDS)
