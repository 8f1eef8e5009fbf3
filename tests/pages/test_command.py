"""`mbproj animate`: what it writes, prints and refuses."""

from __future__ import annotations

import pytest
from click.testing import CliRunner

from mbproj.base.errors import InputError
from mbproj.commands import animate
from mbproj.show.page import write
from tests.pages.runs import FIVE_BAR, five_bar


def run(*arguments):
    """The command's exit code, stdout and stderr; its InputError passes through."""
    result = CliRunner().invoke(animate.command, [str(argument) for argument in arguments], catch_exceptions=False)
    return result.exit_code, result.stdout, result.stderr


@pytest.fixture
def path(tmp_path):
    return five_bar(tmp_path / "run.h5", duration=0.5)


def test_the_page_stands_beside_the_results(path):
    code, out, err = run(path)
    assert (code, out, err) == (0, f"{path.with_suffix('.html')}\n", "")
    assert path.with_suffix(".html").read_text(encoding="utf-8").startswith("<!doctype html>")


def test_a_page_of_ours_is_replaced_and_no_other_file(path, tmp_path):
    run(path)
    assert run(path)[0] == 0
    other = tmp_path / "mine.html"
    other.write_text("<html>mine</html>")
    with pytest.raises(InputError, match=r"mine.html' exists and is not a page of mbproj"):
        run(path, "-o", other)
    assert run(path, "-o", other, "--force")[0] == 0


def test_a_scene_shows_its_start_alone(path, tmp_path):
    code, out, err = run(FIVE_BAR, "-o", tmp_path / "start.html")
    assert (code, out) == (0, f"{tmp_path / 'start.html'}\n")
    assert "the start, assembled; nothing was run" in err
    with pytest.raises(InputError, match="is a scene, and scenes are shown alone"):
        run(path, FIVE_BAR, "-o", tmp_path / "both.html")


def test_two_results_with_labels(path, tmp_path):
    assert run(path, path, "-o", tmp_path / "two.html", "--label", "a", "--label", "b")[0] == 0
    with pytest.raises(InputError, match="--label: 1 for 2 files"):
        run(path, path, "--label", "a")


def test_a_window_without_a_sample_is_refused(path):
    with pytest.raises(InputError, match=r"has no sample from 7 s"):
        run(path, "--from", 7)


def test_the_name_of_a_page_ends_in_html(path, tmp_path):
    with pytest.raises(InputError, match=r"'.*run.txt' is not the name of a page or film"):
        run(path, "-o", tmp_path / "run.txt")


def test_without_the_extra_one_line_says_how_to_install_it(path, monkeypatch):
    monkeypatch.setattr(write, "find_spec", lambda name: None)
    with pytest.raises(InputError) as error:
        run(path)
    (problem,) = error.value.problems
    assert problem.message == "a page needs three.js, which comes with trimesh"
    assert problem.hint == "install it with: pip install 'mbproj[animate]'"
    assert not path.with_suffix(".html").exists()
