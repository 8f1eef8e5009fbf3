"""Whatever stands in a file: a scene, or an error at its place; traps of YAML, and thousands of names."""

from __future__ import annotations

import string
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml
from hypothesis import strategies as st

from mbproj.base.errors import MAX_NAMES, InputError, Place, choose_from, did_you_mean
from mbproj.scene.fields.fields import NameReference
from mbproj.scene.fields.reading import Reading
from mbproj.scene.scene import Scene, read_scene, read_scene_text
from mbproj.scene.text.document import compose
from mbproj.scene.text.nodes import MappingNode, Node, ScalarNode, SequenceNode, from_value
from tests.crossed import campaign
from tests.scene.scenes import GOOD, ROWS, WRONG, changed, errors, read, read_with

# Files that are no scene: one clear message each.

NOT_TEXT = ": error: this is a binary file, not a scene; a scene is YAML text in UTF-8"
CONTENTS = {
    "empty": (b"", ": error: the file is empty; a scene begins with 'mbproj: 1'"),
    "comments": (b"# nothing\n\n", ": error: the file is empty; a scene begins with 'mbproj: 1'"),
    "latin-1": (b"mbproj: 1\ntitle: B\xf6se\n", ":2: error: the byte 0xf6 is not UTF-8 text; save the file as UTF-8"),
    "binary": (b"\x7fELF\0\0", NOT_TEXT),
    "UTF-16": ("mbproj: 1".encode("utf-16"), NOT_TEXT),
    "results": (b"\x89HDF\r\n\x1a\n", ": error: this is a results file, not a scene; 'mbproj rerun' repeats its run"),
    "control": (b"a: \x1b[31m\n", ":1:4: error: the character U+001B is not allowed in a scene file"),
    "list": (b"- 1\n", ":1:1: error: a scene is a mapping of keys, found a list of 1; it begins with 'mbproj: 1'"),
    "text": (b"hello\n", ":1:1: error: a scene is a mapping of keys, found 'hello'; it begins with 'mbproj: 1'"),
    "large": (b"#" * 10_000_001, ": error: the file is larger than 10 MB"),
}


@pytest.mark.parametrize("kind", CONTENTS)
def test_contents_that_are_no_scene(tmp_path: Path, kind: str) -> None:
    data, message = CONTENTS[kind]
    path = tmp_path / "scene.yaml"
    path.write_bytes(data)
    with pytest.raises(InputError) as raised:
        read_scene(path)
    assert [str(problem).splitlines()[0] for problem in raised.value.problems] == [f"{path}{message}"]


def test_a_missing_file_with_one_of_a_similar_name(tmp_path: Path) -> None:
    (tmp_path / "crank.yaml").write_text(GOOD)
    with pytest.raises(InputError, match=r"cranc\.yaml: error: there is no such file; did you mean 'crank\.yaml'\?$"):
        read_scene(tmp_path / "cranc.yaml")


def test_a_missing_file_in_a_missing_directory() -> None:
    with pytest.raises(InputError, match=r"^nowhere/scene\.yaml: error: there is no such file$"):
        read_scene("nowhere/scene.yaml")


def test_a_directory(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"error: this is a directory, not a scene file$"):
        read_scene(tmp_path)


def test_a_path_that_cannot_be(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"error: cannot be read: embedded null byte$"):
        read_scene(tmp_path / "a\0b")


def test_a_text_that_is_too_long() -> None:
    with pytest.raises(InputError, match=r"^<text>: error: the text is longer than 10 million characters$"):
        read_scene_text("#" * 10_000_001)


def test_the_path_is_kept(tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(GOOD)
    scene = read_scene(str(path))
    assert (scene.path, scene.text, scene.places["title",].file) == (path, GOOD, str(path))


def test_every_truncation_gives_a_scene_or_an_error_with_a_place() -> None:
    scenes = 0
    for end in range(0, len(GOOD), 7):
        try:
            scenes += isinstance(read_scene_text(GOOD[:end]), Scene)
        except InputError as error:
            assert all(problem.place is not None and problem.place.file == "<text>" for problem in error.problems)
    assert scenes >= 5


# Whatever the text: a Scene, or an InputError that names a place for every problem.

COUNTS = {"few": 75, "many": 300}
SIGNS = "[]{}:,&*!|>'\"#%@`\t\n -?~"
PIECES = st.sampled_from([new for _, new, _ in ROWS]) | st.sampled_from(SIGNS)
YAML_LIKE = st.text(alphabet=string.ascii_letters + string.digits + SIGNS + ".+/()é\u2028\x85", max_size=80)


def scene_or_problems(text: str) -> None:
    try:
        assert isinstance(read_scene_text(text), Scene)
    except InputError as error:
        assert error.problems
        for problem in error.problems:
            assert problem.place is not None
            line, column = problem.place.line or 1, problem.place.column or 1
            assert 1 <= column <= len(problem.place.text or " " * 100) + 1
            assert line >= 1


@campaign(st.text(max_size=200) | YAML_LIKE, **COUNTS)
def test_any_text(text: str) -> None:
    scene_or_problems(text)


@campaign(st.integers(0, len(GOOD)), st.integers(0, 40), PIECES | YAML_LIKE, **COUNTS)
def test_the_good_scene_with_a_piece_replaced(at: int, length: int, piece: str) -> None:
    scene_or_problems(GOOD[:at] + piece + GOOD[at + length :])


@campaign(st.lists(st.floats(-1e50, 1e50), min_size=3, max_size=3), **COUNTS)
def test_numbers_are_read_as_they_were_written(numbers: list[float]) -> None:
    written = ", ".join(map(repr, numbers))
    scene = read_scene_text(GOOD.replace("position: [0, 0.1, 0.12]", f"position: [{written}]"))
    assert list(scene.bodies[0].position) == numbers


# The traps of YAML 1.1 and of PyYAML: implicit types, duplicate keys, aliases; both its parsers say the same.

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


# Scenes with thousands of names: each is looked up, and a wrong one costs no look at all others.


class Names(dict[str, None]):
    """Names that count how many were looked at."""

    looked_at = 0

    def __iter__(self) -> Iterator[str]:
        for name in super().__iter__():
            self.looked_at += 1
            yield name


NAMES = [f"b{number}" for number in range(5000)]


@pytest.mark.parametrize("hint", [choose_from, did_you_mean])
def test_hints_look_at_few_of_many_names(hint) -> None:
    names = Names.fromkeys(NAMES)
    hint("b17x", names)
    assert names.looked_at <= MAX_NAMES + 1


@pytest.mark.parametrize(("name", "found"), [("b4999", "b4999"), ("ground", "ground"), ("b4999x", None)])
def test_a_reference_looks_at_few_of_many_names(name: str, found: str | None) -> None:
    names, place = Names.fromkeys(NAMES), Place("f.yaml", 1, 1)
    reading = Reading(items={"bodies": names})
    assert NameReference("body", "bodies", ("ground",)).read(from_value(name, place), ("joints",), reading) == found
    assert names.looked_at <= MAX_NAMES + 1
    wrong = "unknown body 'b4999x'; choose from: ground, b0, b1, "
    assert [problem.line()[:60] for problem in reading.problems] == (
        [] if found else [f"f.yaml:1:1: error: {wrong}"[:60]]
    )
