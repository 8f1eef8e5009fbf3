"""Pictures and films of the mechanism itself: poses where the run has them, at the times that they say."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.collections import PolyCollection
from PIL import Image

from mbproj.base.errors import InputError
from mbproj.commands import animate, check, plot
from mbproj.joints.table import JOINTS
from mbproj.results.reader import open_results
from mbproj.scene.scene import read_scene
from mbproj.show.appearance.mechanism import look_of, view_of
from mbproj.show.appearance.motion import motion_at
from mbproj.show.figures import mechanism as film
from mbproj.show.figures.kinds import draw, why_not
from mbproj.show.figures.mechanism import draw_start, duration_and_speed, picture_axes, projected, times_of
from tests.cli.commands import invoked
from tests.crossed import some
from tests.pages.runs import FIVE_BAR, five_bar
from tests.results.pendulum_blocks import record
from tests.support import MECHANISMS, assembled


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return five_bar(tmp_path_factory.mktemp("mechanism") / "five_bar.h5", duration=1)


def outlines(figure):
    """The polygons (k, 2) of each pose."""
    return [
        [path.vertices for path in collection.get_paths()]
        for collection in figure.axes[0].collections
        if isinstance(collection, PolyCollection)
    ]


def test_a_strobe_picture_shows_each_pose_where_the_run_has_it(path):
    with open_results(path) as results:
        figure = draw("mechanism", [results], ["run"], times=(0.0, 0.5, 1.0))
        poses = outlines(figure)
        assert len(poses) == 3
        for time, shapes in zip((0.0, 0.5, 1.0), poses, strict=True):
            sample = np.argmin(np.abs(results.time - time))
            for x, _, z in results["bodies/position"][sample]:
                middles = np.array([0.5 * (shape.min(axis=0) + shape.max(axis=0)) for shape in shapes])
                assert np.linalg.norm(middles - [x, z], axis=1).min() <= 1e-9
        opacities = [collection.get_facecolor()[0, 3] for collection in figure.axes[0].collections]
        assert opacities == sorted(opacities) and opacities[-1] == 1.0
        assert figure.axes[0].get_xlabel() == "x (m)"
        assert figure.axes[0].get_ylabel() == "z (m)"


def test_without_times_it_is_the_start_with_the_whole_path(path):
    with open_results(path) as results:
        figure = draw("mechanism", [results], ["run"])
        assert len(outlines(figure)) == 1
        (tip,) = [line for line in figure.axes[0].lines if line.get_label() == "tip"]
        assert np.allclose(np.column_stack(tip.get_data()), results["markers/position"][:, 0][:, [0, 2]])


def test_a_second_run_is_paler(path):
    with open_results(path) as one, open_results(path) as other:
        poses = [each.get_facecolor()[0, 3] for each in draw("mechanism", [one, other], ["a", "b"]).axes[0].collections]
    assert poses == pytest.approx([0.3, 1.0])


@pytest.mark.parametrize("mechanism", some(MECHANISMS, 3), ids=lambda path: path.stem)
def test_the_start_of_every_shipped_mechanism_lies_in_its_picture(mechanism):
    scene = read_scene(mechanism)
    system, state = assembled(scene)
    motion = motion_at(system, state.q)
    look = look_of(scene, motion, {})
    view = view_of(scene, motion, look)
    axes = np.column_stack(picture_axes(view))
    assert np.allclose(axes.T @ axes, np.eye(2), atol=1e-12)
    figure = draw_start(look, view, motion)
    shapes, *rods = outlines(figure)
    ropes = [joint.parameters["path"] for joint in scene.joints if "path" in joint.parameters]
    parts = sum(len(path.nodes) - 1 for path in ropes)
    assert len(rods) == parts + sum(JOINTS[joint.type].is_rod for joint in scene.joints)
    low, high = np.array([figure.axes[0].get_xlim(), figure.axes[0].get_ylim()]).T
    for point in projected(motion.position[0], view):
        assert (low <= point).all() and (point <= high).all()
    assert len(shapes) >= len(scene.bodies)


def test_plot_takes_times_for_this_kind_alone(path, tmp_path):
    code, out, _ = invoked(
        plot.command, path, "--kind", "mechanism", "--at", "0,500 ms", "-o", tmp_path, "--format", "svg"
    )
    assert (code, out) == (0, f"{tmp_path / 'five_bar-mechanism.svg'}\n")
    assert "at t = 0, 0.5 s" in (tmp_path / "five_bar-mechanism.svg").read_text(encoding="utf-8")
    with pytest.raises(InputError, match="--at is for --kind mechanism alone"):
        invoked(plot.command, path, "--kind", "energy", "--at", "0", "-o", tmp_path)


@pytest.mark.parametrize("ending", ["png", "svg", "html"])
def test_check_draws_the_start(tmp_path, ending):
    picture = tmp_path / f"start.{ending}"
    code, out, _ = invoked(check.command, FIVE_BAR, "--picture", picture)
    assert code == 0
    assert "can run" in out
    assert picture.read_bytes().startswith({"png": b"\x89PNG", "svg": b"<?xml", "html": b"<!doctype html>"}[ending])


def test_check_refuses_other_names(tmp_path):
    with pytest.raises(InputError, match=r"'.*start.txt' is not the name of a picture"):
        invoked(check.command, FIVE_BAR, "--picture", tmp_path / "start.txt")


def test_results_without_a_readable_scene_say_so(tmp_path):
    with open_results(record(tmp_path / "run.h5")) as results:
        reason = why_not("mechanism", [results])
    assert reason is not None and reason.startswith(
        "the scene in the results cannot be read: unknown parameter 'length'"
    )


# Films: their pictures stand at the times that they say, in a format that others read.


@pytest.fixture(scope="module")
def film_path(tmp_path_factory):
    return five_bar(tmp_path_factory.mktemp("film") / "five_bar.h5", duration=1)


@pytest.fixture
def short(monkeypatch):
    """Films of five pictures."""
    monkeypatch.setattr(film, "SHORTEST", 0.2)
    monkeypatch.setattr(film, "LONGEST", 0.2)


def animated(*arguments):
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


def test_a_gif_has_all_pictures_and_its_bars_where_the_run_has_them(film_path, tmp_path, short):
    """The colour of the last bar moves as its centre of mass does."""
    target = tmp_path / "film.gif"
    assert animated(film_path, "-o", target).stdout == f"{target}\n"
    with Image.open(target) as shown:
        assert (shown.n_frames, shown.info["duration"], shown.info["loop"]) == (5, 50, 0)
        pictures = []
        for number in range(5):
            shown.seek(number)
            pictures.append(np.asarray(shown.convert("RGB"), dtype=float))
    blue = [np.argwhere(np.linalg.norm(picture - [102, 204, 238], axis=2) < 60.0) for picture in pictures]
    height = np.array([each[:, 0].mean() for each in blue])
    assert (np.diff(height) > 3.0).all()  # rows count downwards, and it falls
    assert animated(film_path, "-o", target).exit_code == 0  # ours is replaced
    target.write_bytes(b"GIF89a of somebody else")
    with pytest.raises(InputError, match=r"film.gif' exists and is not a film in GIF of mbproj"):
        animated(film_path, "-o", target)


def test_ffmpeg_is_given_every_pixel_of_every_picture(film_path, tmp_path, short, monkeypatch):
    """A stand-in notes what it is told, and counts what it is given."""
    stand_in = tmp_path / "ffmpeg"
    stand_in.write_text(
        f"#!{sys.executable}\nimport sys\nsize = len(sys.stdin.buffer.read())\n"
        "open(sys.argv[-1], 'w').write(' '.join(sys.argv[1:-1]) + f' {size}')\n"
    )
    stand_in.chmod(0o755)
    monkeypatch.setattr(film.shutil, "which", lambda name: str(stand_in))
    animated(film_path, "-o", tmp_path / "film.mp4")
    *told, size = (tmp_path / "film.mp4").read_text().split()
    width, height = map(int, told[told.index("-s") + 1].split("x"))
    assert width % 2 == height % 2 == 0
    assert int(size) == 5 * 3 * width * height
    assert "comment=mbproj" in told
    stand_in.write_text("#!/bin/sh\necho 'Unknown encoder libx264' >&2\nexit 1\n")
    (tmp_path / "film.mp4").unlink()
    with pytest.raises(InputError, match="ffmpeg cannot make the film: Unknown encoder libx264; install one with"):
        animated(film_path, "-o", tmp_path / "film.mp4")
    assert not (tmp_path / "film.mp4").exists()


def test_without_ffmpeg_one_line_says_so(film_path, tmp_path, monkeypatch):
    monkeypatch.setattr(film.shutil, "which", lambda name: None)
    with pytest.raises(InputError) as error:
        animated(film_path, "-o", tmp_path / "film.mp4")
    (problem,) = error.value.problems
    assert problem.message == "a film in MP4 needs ffmpeg, which is not here"
    assert problem.hint == "install it (apt install ffmpeg), or end the name in .gif"


def test_a_film_is_of_results_alone(film_path, tmp_path):
    with pytest.raises(InputError, match=r"a film is of results of runs, and '.*five_bar.yaml' is none"):
        animated(FIVE_BAR, "-o", tmp_path / "film.gif")
    with pytest.raises(InputError, match=r"--full is for pages, and '.*film.gif' is a film"):
        animated(film_path, "--full", "-o", tmp_path / "film.gif")
