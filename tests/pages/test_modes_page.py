"""The page of a file of modes: bodies swing as Re(shape · exp(iφ)) says, words and choices are those of the file."""

from __future__ import annotations

import numpy as np
import pytest
from click.testing import CliRunner

from mbproj.base.errors import InputError
from mbproj.commands import animate
from mbproj.equations.assembly.compiled import compile_system
from mbproj.linear.equilibrium.start import start_state
from mbproj.linear.modes import modes, stored
from mbproj.linear.reference import reference_at
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.results.linear_files import read_modes, write_modes
from mbproj.scene.scene import read_scene_text
from mbproj.show.page.pages import page_of_modes, words_on
from mbproj.show.page.write import html
from tests.pages.browser import MISSING, SMALL, Opened, browser
from tests.pages.runs import block_of, bytes_of, data_of

#: A damped slider on a spring with a pendulum on it: both modes are complex.
SCENE = """\
mbproj: 1
title: a cart and a pendulum
gravity: [0, 0, -9.81]
simulation: {duration: 1, step: 0.01}
bodies:
  cart: {mass: 2, shape: {box: [0.3, 0.2, 0.2]}, position: [0.6, 0, 0]}
  arm: {mass: 1, shape: {rod: {length: 1, axis: z}}, position: [0.6, 0, -0.5]}
joints:
  slide: {type: prismatic, bodies: [ground, cart], location: [0.6, 0, 0], axis: [1, 0, 0]}
  pin: {type: revolute, bodies: [cart, arm], location: [0.6, 0, 0], axis: [0, 1, 0]}
markers: {tip: {body: arm, location: [0.6, 0, -1]}}
forces:
  spring: {type: spring_damper, points: {ground: [0, 0, 0], cart: [0.5, 0, 0]}, stiffness: 300, damping: 9,
    free_length: 0.5}
"""


def modes_file(path, text=SCENE):
    scene = read_scene_text(text)
    system = compile_system(scene)
    return write_modes(
        path, stored(modes(reference_at(system, start_state(scene, system), "start")), scene.title), scene
    )


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return modes_file(tmp_path_factory.mktemp("modes") / "modes.h5")


@pytest.fixture(scope="module")
def page(path):
    shown = page_of_modes(path, "modes")
    path.with_suffix(".html").write_text(html(shown.title, shown.data, shown.packer), encoding="utf-8")
    return path.with_suffix(".html")


def command(*arguments):
    return CliRunner().invoke(animate.command, [str(each) for each in arguments], catch_exceptions=False)


def test_shapes_are_those_of_the_file_with_one_unit_of_swing(path, page):
    file, text = read_modes(path), page.read_text(encoding="utf-8")
    run, rest = data_of(text)["runs"]
    assert rest["ghost"] and "modes" not in rest
    found = block_of(bytes_of(text), run["blocks"][run["modes"]["shape"]])
    shapes = (found[:, :12] + 1j * found[:, 12:]).reshape(2, 2, 6)
    size = run["modes"]["size"]
    for mode in range(2):
        there = file.displacement[mode] / ([size] * 3 + [1.0] * 3)
        factor = np.vdot(there, shapes[mode]) / np.vdot(there, there)
        assert factor.real > 0 and abs(factor.imag) <= 1e-5 * abs(factor)  # the phase is the file's
        assert np.allclose(shapes[mode], factor * there, atol=2e-6)
        largest = np.linalg.norm(shapes[mode].reshape(2, 2, 3), axis=-1).max()
        assert largest == pytest.approx(1.0, abs=1e-5)
    along = block_of(bytes_of(text), run["blocks"][run["modes"]["along"]])
    assert np.allclose(along[:, 1] + 1j * along[:, 3], shapes[:, 1, 4], atol=4e-6)  # the pin turns the arm about y
    assert np.abs(shapes[1].imag).max() > 0.01


@pytest.mark.parametrize(
    ("eigenvalue", "words"),
    [
        (0.0, "neutral: nothing drives it back"),
        (-4.0, "does not oscillate: it falls by e in 0.25 s"),
        (2.0, "does not oscillate: it grows by e in 0.5 s"),
        (-1 + 2j * np.pi, "1 Hz, damping ratio 0.157"),
        (1 + 2j * np.pi, "1 Hz, damping ratio -0.157: it grows by e in 1 s"),
    ],
)
def test_words_say_how_a_mode_goes_with_time(path, eigenvalue, words):
    from dataclasses import replace

    value = np.array([complex(eigenvalue)])
    size = np.abs(value)
    of_it = {"frequency": value.imag / 2 / np.pi, "damping_ratio": -value.real / np.where(size > 0, size, 1.0)}
    assert words_on(replace(read_modes(path), eigenvalue=value, **of_it), 0) == words


def test_the_command_tells_files_of_modes_from_results(path, tmp_path):
    result = command(path, "-o", tmp_path / "modes.html")
    assert (result.exit_code, result.stdout) == (0, f"{tmp_path / 'modes.html'}\n")
    assert "joints seem to open" in result.stderr
    with pytest.raises(InputError, match="files of modes are shown one at a time"):
        command(path, path)
    with pytest.raises(InputError, match=r"--from is for results of runs, and '.*modes.h5' is none"):
        command(path, "--from", 1)


def test_a_mechanism_that_cannot_move_has_no_mode_to_show(tmp_path):
    held = (
        SCENE
        + """\
motions:
  push: {joint: slide, displacement: {constant_speed: 0}}
  hold: {joint: pin, angle: {constant_speed: 0}}
"""
    )
    with pytest.raises(InputError, match=r"still.h5' has no mode to show"):
        command(modes_file(tmp_path / "still.h5", held))


@pytest.mark.skipif(bool(MISSING), reason=MISSING or "there is a browser")
def test_bodies_swing_about_their_pose_with_the_phase(path, page):
    file = read_modes(path)
    with browser() as chromium:
        shown = Opened(chromium, page, SMALL)
        shown.at(0.0)
        for mode, phase in ((0, 0.0), (1, 40.0), (1, 250.0)):
            shown.page.locator("#mode").select_option(str(mode))
            shown.at(phase)
            pose = shown.run(
                "return page.shown[0].figure.bodies.map((body) => [body.position.toArray().map((x, i) =>"
                "x + page.data.view.middle[i]), body.quaternion.toArray()])"
            )
            amplitude = shown.run("return page.runs[0].amplitude")
            size = shown.run("return page.runs[0].modes.size")
            relative = file.displacement[mode] / ([size] * 3 + [1.0] * 3)
            largest = np.linalg.norm(relative.reshape(2, 2, 3), axis=-1).max()
            swing = amplitude / largest * (file.displacement[mode] * np.exp(1j * np.radians(phase))).real
            there = np.array([place for place, _ in pose])
            assert np.abs(there - file.position - swing[:, :3]).max() <= 1e-5
            x, y, z, w = pose[1][1]
            turned = rotation_matrix(np.array([w, x, y, z]))
            assert np.arctan2(turned[0, 2], turned[0, 0]) == pytest.approx(swing[1, 4], abs=1e-5)
            assert f"Mode {mode + 1} of 2: " in shown.page.locator("#shape").inner_text()
        before = shown.pixels()
        shown.page.locator("#amplitude").evaluate("(it) => { it.value = 0; it.dispatchEvent(new Event('input')); }")
        shown.settle()
        assert shown.pixels() != before
        assert shown.run(
            "return page.shown.map((each) => each.figure.bodies[1].position.toArray())[0]"
        ) == pytest.approx(shown.run("return page.shown.map((each) => each.figure.bodies[1].position.toArray())[1]"))
        shown.page.locator("#scene").click(position={"x": 5, "y": 200})
        shown.page.keyboard.press("n")
        assert shown.run("return page.runs[0].mode") == 0
        assert shown.page.locator("#clock").inner_text().endswith("/ 360.0 °")
        assert shown.complaints == []
        shown.close()
