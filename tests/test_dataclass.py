"""The `dataclass` of mbproj does what that of the standard library does."""

from __future__ import annotations

import copy
import dataclasses
import inspect
import pickle
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import FrozenInstanceError, asdict, field, fields, replace

import pytest

from mbproj.base.dataclass import dataclass


def declared(dataclass, **options):
    """The same two classes by either decorator."""

    @dataclass(frozen=True, **options)
    class Point:
        x: float
        y: float = 2.0
        tags: dict[str, int] = field(default_factory=dict, compare=False)
        secret: str = field(default="s", repr=False)

        def __post_init__(self) -> None:
            if self.x < 0:
                raise ValueError("x < 0")

    @dataclass(frozen=True, **options)
    class Named(Point):
        name: str = "A"

    return Point, Named


OURS, STANDARD = declared(dataclass), declared(dataclasses.dataclass)


@dataclass(frozen=True)
class Pickled:
    value: int


@dataclass
class Counted:
    count: int = 0


def kinds():
    return pytest.mark.parametrize(("ours", "standard"), list(zip(OURS, STANDARD, strict=True)), ids=["Point", "Named"])


@kinds()
def test_instances_are_made_compared_and_shown_alike(ours, standard):
    for given, named in (((1.0,), {}), ((1.0, 3.0), {"tags": {"a": 1}}), ((), {"x": 4.0, "secret": "t"})):
        one, other = ours(*given, **named), standard(*given, **named)
        assert repr(one) == repr(other).replace("STANDARD", "OURS")
        assert asdict(one) == asdict(other)
        assert hash(one) == hash(other) == hash(ours(*given, **named))
        assert one == ours(*given, **named)
        assert one != ours(9.0)
        assert asdict(replace(one, x=8.0)) == asdict(replace(other, x=8.0))
    assert ours.__match_args__ == standard.__match_args__
    assert [each.name for each in fields(ours)] == [each.name for each in fields(standard)]


@kinds()
def test_what_is_refused(ours, standard):
    for kind in (ours, standard):
        point = kind(1.0)
        with pytest.raises(FrozenInstanceError, match="cannot assign to field 'x'"):
            point.x = 2.0
        with pytest.raises(FrozenInstanceError, match="cannot delete field 'x'"):
            del point.x
        with pytest.raises(ValueError, match="x < 0"):
            kind(-1.0)
        with pytest.raises(TypeError, match="missing 1 required positional argument: 'x'"):
            kind()
        with pytest.raises(TypeError, match="unexpected keyword argument 'z'"):
            kind(1.0, z=2.0)


def test_classes_have_the_defaults_of_their_fields():
    """Before fields are asked for, and after."""
    for ours, standard in zip(declared(dataclass), declared(dataclasses.dataclass), strict=True):
        for _ in range(2):
            for name in ("x", "y", "tags", "secret", "name"):
                assert getattr(ours, name, None) == getattr(standard, name, None)
                assert (name in vars(ours)) == (name in vars(standard))
            assert [each.default for each in fields(ours)] == [each.default for each in fields(standard)]


def test_each_instance_has_its_own_default():
    first, second = OURS[0](1.0), OURS[0](1.0)
    assert first.tags is not second.tags


def test_a_class_is_not_another():
    point, named = OURS
    assert point(1.0) != named(1.0)


def test_without_eq_an_instance_is_itself_only():
    point, _ = declared(dataclass, eq=False)
    one = point(1.0)
    assert one != point(1.0)
    assert hash(one) == object.__hash__(one)


def test_what_is_not_frozen_changes_and_has_no_hash():
    counted = Counted()
    counted.count += 1
    assert counted == Counted(1)
    with pytest.raises(TypeError, match="unhashable"):
        hash(counted)


def test_copies_and_pickles_are_equal():
    one = Pickled(3)
    assert pickle.loads(pickle.dumps(one)) == copy.deepcopy(one) == one


def test_init_is_written_when_it_is_needed():
    point, _ = declared(dataclass)
    stub = point.__init__
    point(1.0)
    assert point.__init__ is not stub
    assert list(inspect.signature(point.__init__).parameters) == ["self", "x", "y", "tags", "secret"]


def test_fields_are_found_when_they_are_asked_for():
    point, named = declared(dataclass)
    later = [vars(kind)["__dataclass_fields__"] for kind in (point, named)]
    assert dataclasses.is_dataclass(named)
    assert not any(vars(kind)["__dataclass_fields__"] in later for kind in (point, named))
    fresh = [declared(dataclass)[1] for _ in range(50)]
    patience = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)  # threads meet within the finding
    try:
        with ThreadPoolExecutor(8) as pool:
            asked = [kind for kind in fresh for _ in "1234"]
            found = list(pool.map(lambda kind: [each.name for each in fields(kind)], asked))
    finally:
        sys.setswitchinterval(patience)
    assert found == [["x", "y", "tags", "secret", "name"]] * 200
