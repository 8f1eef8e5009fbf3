"""Films: their pictures stand at the times that they say, in a format that others read."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

from mbproj.base.errors import InputError
from mbproj.commands import animate
from mbproj.show.figures import mechanism
from mbproj.show.figures.mechanism import duration_and_speed, times_of
from tests.pages.runs import FIVE_BAR, five_bar


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return five_bar(tmp_path_factory.mktemp("film") / "five_bar.h5", duration=1)


@pytest.fixture
def short(monkeypatch):
    """Films of five pictures."""
    monkeypatch.setattr(mechanism, "SHORTEST", 0.2)
    monkeypatch.setattr(mechanism, "LONGEST", 0.2)


def run(*arguments):
    return CliRunner().invoke(animate.command, [str(each) for each in arguments], catch_exceptions=False)


@pytest.mark.parametrize(
    ("span", "seconds", "speed"), [(0.1, 4.0, 0.025), (10.0, 10.0, 1.0), (150.0, 15.0, 10.0), (0.0, 0.05, 1.0)]
)
def test_a_film_lasts_as_long_as_one_likes_to_watch(span, seconds, speed):
    assert duration_and_speed(span) == pytest.approx((seconds, speed))


def test_pictures_are_even_in_time():
    times = times_of(np.array([1.0, 1.5, 6.0]))
    assert len(times) == 101
    assert np.allclose(np.diff(times), 0.05)
    assert (times[0], times[-1]) == (1.0, 6.0)
    assert times_of(np.array([2.0])).tolist() == [2.0]


def test_a_gif_has_all_pictures_and_its_bars_where_the_run_has_them(path, tmp_path, short):
    """The colour of the last bar moves as its centre of mass does."""
    target = tmp_path / "mechanism.gif"
    assert run(path, "-o", target).stdout == f"{target}\n"
    with Image.open(target) as shown:
        assert (shown.n_frames, shown.info["duration"], shown.info["loop"]) == (5, 50, 0)
        pictures = []
        for number in range(5):
            shown.seek(number)
            pictures.append(np.asarray(shown.convert("RGB"), dtype=float))
    blue = [np.argwhere(np.linalg.norm(picture - [102, 204, 238], axis=2) < 60.0) for picture in pictures]
    height = np.array([each[:, 0].mean() for each in blue])
    assert (np.diff(height) > 3.0).all()  # rows count downwards, and it falls
    assert run(path, "-o", target).exit_code == 0  # ours is replaced
    target.write_bytes(b"GIF89a of somebody else")
    with pytest.raises(InputError, match=r"mechanism.gif' exists and is not a film in GIF of mbproj"):
        run(path, "-o", target)


def test_ffmpeg_is_given_every_pixel_of_every_picture(path, tmp_path, short, monkeypatch):
    """A stand-in notes what it is told, and counts what it is given."""
    stand_in = tmp_path / "ffmpeg"
    stand_in.write_text(
        f"#!{sys.executable}\nimport sys\nsize = len(sys.stdin.buffer.read())\n"
        "open(sys.argv[-1], 'w').write(' '.join(sys.argv[1:-1]) + f' {size}')\n"
    )
    stand_in.chmod(0o755)
    monkeypatch.setattr(mechanism.shutil, "which", lambda name: str(stand_in))
    run(path, "-o", tmp_path / "mechanism.mp4")
    *told, size = (tmp_path / "mechanism.mp4").read_text().split()
    width, height = map(int, told[told.index("-s") + 1].split("x"))
    assert width % 2 == height % 2 == 0
    assert int(size) == 5 * 3 * width * height
    assert "comment=mbproj" in told
    stand_in.write_text("#!/bin/sh\necho 'Unknown encoder libx264' >&2\nexit 1\n")
    (tmp_path / "mechanism.mp4").unlink()
    with pytest.raises(InputError, match="ffmpeg cannot make the film: Unknown encoder libx264; install one with"):
        run(path, "-o", tmp_path / "mechanism.mp4")
    assert not (tmp_path / "mechanism.mp4").exists()


def test_without_ffmpeg_one_line_says_so(path, tmp_path, monkeypatch):
    monkeypatch.setattr(mechanism.shutil, "which", lambda name: None)
    with pytest.raises(InputError) as error:
        run(path, "-o", tmp_path / "mechanism.mp4")
    (problem,) = error.value.problems
    assert problem.message == "a film in MP4 needs ffmpeg, which is not here"
    assert problem.hint == "install it (apt install ffmpeg), or end the name in .gif"


def test_a_film_is_of_results_alone(path, tmp_path):
    with pytest.raises(InputError, match=r"a film is of results of runs, and '.*five_bar.yaml' is none"):
        run(FIVE_BAR, "-o", tmp_path / "mechanism.gif")
    with pytest.raises(InputError, match=r"--full is for pages, and '.*mechanism.gif' is a film"):
        run(path, "--full", "-o", tmp_path / "mechanism.gif")
