"""Pictures of the mechanism itself: poses stand where the run has them, and where the bars of the five-bar are."""

from __future__ import annotations

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.collections import PolyCollection

from mbproj.base.errors import InputError
from mbproj.commands import check, plot
from mbproj.equations.assembly.assemble import assemble
from mbproj.equations.assembly.compiled import compile_system
from mbproj.joints.table import JOINTS
from mbproj.model.compile.mechanism import initial_guess
from mbproj.results.reader import open_results
from mbproj.scene.scene import read_scene
from mbproj.show.appearance.mechanism import look_of, view_of
from mbproj.show.appearance.motion import motion_at
from mbproj.show.figures.kinds import draw, why_not
from mbproj.show.figures.mechanism import draw_start, picture_axes, projected
from tests.crossed import some
from tests.pages.runs import FIVE_BAR, five_bar
from tests.results.pendulum_blocks import record
from tests.support import MECHANISMS


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
    system = compile_system(scene)
    motion = motion_at(system, assemble(system, initial_guess(scene, system)).q)
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


def run(command, *arguments):
    result = CliRunner().invoke(command, [str(argument) for argument in arguments], catch_exceptions=False)
    return result.exit_code, result.stdout, result.stderr


def test_plot_takes_times_for_this_kind_alone(path, tmp_path):
    code, out, _ = run(plot.command, path, "--kind", "mechanism", "--at", "0,500 ms", "-o", tmp_path, "--format", "svg")
    assert (code, out) == (0, f"{tmp_path / 'five_bar-mechanism.svg'}\n")
    assert "at t = 0, 0.5 s" in (tmp_path / "five_bar-mechanism.svg").read_text(encoding="utf-8")
    with pytest.raises(InputError, match="--at is for --kind mechanism alone"):
        run(plot.command, path, "--kind", "energy", "--at", "0", "-o", tmp_path)


@pytest.mark.parametrize("ending", ["png", "svg", "html"])
def test_check_draws_the_start(tmp_path, ending):
    picture = tmp_path / f"start.{ending}"
    code, out, _ = run(check.command, FIVE_BAR, "--picture", picture)
    assert code == 0
    assert "can run" in out
    assert picture.read_bytes().startswith({"png": b"\x89PNG", "svg": b"<?xml", "html": b"<!doctype html>"}[ending])


def test_check_refuses_other_names(tmp_path):
    with pytest.raises(InputError, match=r"'.*start.txt' is not the name of a picture"):
        run(check.command, FIVE_BAR, "--picture", tmp_path / "start.txt")


def test_results_without_a_readable_scene_say_so(tmp_path):
    with open_results(record(tmp_path / "run.h5")) as results:
        reason = why_not("mechanism", [results])
    assert reason is not None and reason.startswith(
        "the scene in the results cannot be read: unknown parameter 'length'"
    )
