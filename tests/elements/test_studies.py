"""Scenes with elements in the studies: checks, searches, maps; and what is kept tells them apart."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mbproj import Mechanism, solve
from mbproj.elements import Element, Row
from mbproj.errors import InputError
from mbproj.model import compile_system
from mbproj.scene import read_scene_text
from mbproj.studies.recommend.recommendation import recommend
from mbproj.studies.stability.bisection import stability
from mbproj.studies.verify.checks import verify
from tests.crossed import full
from tests.elements.scenes import TWO_SLIDES, scene_of
from tests.kernel.scenes import needs_kernel

pytestmark = needs_kernel
LIFT = Row("lift", {"pin.angle": 0.0, "rail.displacement": 1.0}, "0.04*(1 - cos(s))")
CAM = Element("cam", rows=(LIFT,))
LENGTHS = {"left": ((0.0, 0.0, 0.0), "one"), "right": ("two", (1.0, 0.0, 0.0))}
ROPE = Element("rope", lengths=LENGTHS, rows=(Row("length", {"rope.left": 1.0, "rope.right": 1.0}, constant=2.5),))


def cam_scene():
    return replace(scene_of("z", "speed: 14", duration=0.2, tolerance=1e-8, output_step=0.02), elements=(CAM,))


def rope_scene():
    text = TWO_SLIDES.replace("GRAVITY", "-9.81").replace("FORCES", "")
    return replace(read_scene_text(text), elements=(ROPE,))


@pytest.mark.parametrize(
    ("scene", "left_out"),
    [(cam_scene, {"units"}), full(rope_scene, {"units", "rotation", "translation"})],
    ids=["cam", "rope"],
)
def test_verify_looks_at_elements_from_all_sides(scene, left_out):
    found = {check.name: check for check in verify(scene()).checks}
    assert [name for name, check in found.items() if check.verdict == "failed"] == []
    of_elements = {name for name, check in found.items() if "element" in check.remark}
    assert of_elements == left_out
    moved = {"renumbering", "energy", "closed", "power", "reduced", "turns"} | ({"rotation", "translation"} - left_out)
    assert {found[name].verdict for name in moved} == {"passed"}


def test_a_study_runs_what_the_elements_do():
    """The slide is where the cam lifts it, with every setting that is found."""
    scene = cam_scene()
    found = recommend(scene, 1e-7, timed=False)
    assert found.reached
    run = solve(scene, found.setting, np.linspace(0.0, 0.2, 11))
    assert run.failure is None
    slide = run.body_position[:, 1, 2] - 0.3
    angle = 2.0 * np.arctan2(run.body_orientation[:, 0, 2], run.body_orientation[:, 0, 0])
    np.testing.assert_allclose(slide, 0.04 * (1.0 - np.cos(angle)), atol=1e-13)
    assert slide.max() > 0.07


def test_what_is_kept_of_a_study_tells_elements_apart():
    scene = scene_of("z")
    higher = replace(CAM, rows=(replace(LIFT, function="0.05*(1 - cos(s))"),))
    scenes = [scene, *(replace(scene, elements=(element,)) for element in (CAM, higher))]
    assert len({repr(Mechanism.of(each).identity) for each in scenes}) == 3


def test_the_unit_of_length_cannot_be_varied():
    with pytest.raises(InputError, match="'cam' is data without units"):
        stability(cam_scene(), "length-scale", projections=("gpopm",), points=3, processes=1)


def test_wrong_elements_of_a_scene_are_named():
    with pytest.raises(InputError, match=r"element 'x' reads 'pin\.angel', which does not exist"):
        compile_system(replace(scene_of(), elements=(Element("x", reads=("pin.angel",)),)))
