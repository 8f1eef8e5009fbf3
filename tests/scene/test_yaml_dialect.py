"""The traps of YAML 1.1 and of PyYAML: implicit types, duplicate keys, aliases; both its parsers say the same."""

from __future__ import annotations

import pytest
import yaml

from mbproj.errors import InputError
from mbproj.scene.text.document import compose
from mbproj.scene.text.nodes import MappingNode, Node, ScalarNode, SequenceNode
from tests.scene.scenes import GOOD, WRONG, changed, errors, read, read_with

NUMBERS = {
    "1e-6": 1e-6,
    "1E6": 1e6,
    "1.e2": 100.0,
    ".5": 0.5,
    "+5": 5.0,
    "010": 10.0,
    "0o10/10": None,
    "1_000": None,
    "'0.12'": 0.12,
    '"1e-6"': 1e-6,
    "1e+3": 1000.0,
    "2 kg": 2.0,
    "2kg": 2.0,
    "|\n      5\n": 5.0,
    ">\n      1 +\n      2\n": 3.0,
}


@pytest.mark.parametrize("written", NUMBERS)
def test_numbers(written: str) -> None:
    text = changed("mass: 0.12", f"mass: {written}")
    if NUMBERS[written] is None:
        assert errors(text)[0].startswith("f.yaml:15:12: error: unknown unit")
    else:
        assert read(text).bodies[0].mass == NUMBERS[written]


@pytest.mark.parametrize("name", ["on", "off", "no", "yes", "y", "n", "null", "true", "NaN", "_", "a-b", "t", "_1"])
def test_names_that_yaml_takes_for_something_else(name: str) -> None:
    scene = read(GOOD.replace("rod", name).replace(f"{name}_length", "rod_length"))
    assert scene.bodies[1].name == name
    assert scene.joints[1].bodies == ("crank", name)


def test_a_parameter_may_be_called_like_a_unit() -> None:
    scene = read_with("{crank_length: 0.08, rod_length: 0.3}", "{crank_length: 2 * m + 3 m, m: 4, s: 1}")
    assert scene.parameters == {"crank_length": 11.0, "m": 4.0, "s": 1.0}


def test_an_alias_repeats_a_value() -> None:
    text = changed("inertia: [1.0e-4, 1.0e-5, 1.0e-4]", "inertia: &i [1, 1, 1]")
    crank, rod, _ = read(changed("inertia: [4e-3, 4e-4, 4e-3]", "inertia: *i", text)).bodies
    assert crank.inertia == rod.inertia == ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def test_line_ends_and_byte_order_marks_do_not_matter() -> None:
    assert read("\ufeff" + GOOD.replace("\n", "\r\n")).bodies == read(GOOD).bodies
    text = changed("mass: 0.12", "mass: -1").replace("\n", "\r")
    assert errors(text) == ["f.yaml:15:11: error: 'mass' must be at least 0, found -1"]


def test_an_alias_bomb_is_refused() -> None:
    """Of 1e30 values: who makes them all does not come back."""
    levels = "".join(f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]\n" for i in range(1, 30))
    assert errors(f"a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n{levels}") == [
        "f.yaml:6:25: error: more than 500000 values, with aliases counted where they are repeated"
    ]


def test_a_bomb_of_long_expressions_is_refused_as_well() -> None:
    expression = "+".join("1" * 99)
    repeated = "".join(f"  b{i}: *a\n" for i in range(60_000))
    assert errors(f"bodies:\n  a: &a {{mass: {expression}, inertia: [{expression}]}}\n{repeated}")[0].endswith(
        "more than 500000 values, with aliases counted where they are repeated"
    )


LOADERS = [loader for loader in (getattr(yaml, "CBaseLoader", None), yaml.BaseLoader) if loader is not None]
TEXTS = [
    GOOD,
    "a: &x [1, 'b', \"c\"]\nd: *x\n",
    "é: [ü, 'ö']\n",
    "a:\nb: |\n  x\n  y\nc:\n- 1\n- {d: 2}\n",
    '"a\\tb": 5\n',
]
BROKEN = [changed(old, new) for old, new, message in WRONG["dialect"] if "character" not in message]


def outline(node: Node) -> object:
    """The tree with all its places, as plain data."""
    match node:
        case ScalarNode():
            return (node.text, str(node.place), node.column)
        case SequenceNode():
            return (str(node.place), [outline(item) for item in node.items])
        case MappingNode():
            return (str(node.place), {(key, str(node.keys[key])): outline(value) for key, value in node.values.items()})


@pytest.mark.parametrize("text", [*TEXTS, *BROKEN])
def test_both_parsers_say_the_same(text: str) -> None:
    said = []
    for loader in LOADERS:
        try:
            root, problems = compose(text, "f.yaml", loader)
            said.append((outline(root), [str(problem) for problem in problems]))
        except InputError as error:
            said.append(str(error))
    assert said[0] == said[-1]
