"""Files that are no scene: one clear message each."""

from __future__ import annotations

from pathlib import Path

import pytest

from mbproj.errors import InputError
from mbproj.scene import Scene, read_scene, read_scene_text
from tests.scene.scenes import GOOD

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
