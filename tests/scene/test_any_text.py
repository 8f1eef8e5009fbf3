"""Whatever the text: a Scene, or an InputError that names a place for every problem."""

from __future__ import annotations

import string

from hypothesis import strategies as st

from mbproj.errors import InputError
from mbproj.scene import Scene, read_scene_text
from tests.crossed import campaign
from tests.scene.scenes import GOOD, ROWS

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
