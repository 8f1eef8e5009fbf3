"""The picture of the places where curves are touched: one panel in a plane, three in space, each path as recorded."""

from __future__ import annotations

import numpy as np
import pytest

import mbproj
from mbproj.figures import kinds
from mbproj.mechanisms_folder import mechanism
from tests.kernel.scenes import needs_kernel
from tests.mechanisms.curves.scenes import FLAT, WIRE, scene

pytestmark = needs_kernel


@pytest.mark.parametrize(
    ("text", "formulation", "axes"),
    [
        (FLAT.replace("LAW", "cycloidal").replace("SPEED", "30"), "planar", [(0, 2)]),
        (WIRE, "reduced", [(0, 1), (0, 2), (1, 2)]),
    ],
)
def test_each_place_of_contact_has_its_path(text, formulation, axes):
    results = mbproj.run(mbproj.read_scene_text(scene(text, formulation, 0.1, "5 ms")))
    figure = kinds.draw("contacts", [results], ["run"])
    path = results["curves/contact"][:, 0]
    assert len(figure.axes) == len(axes)
    for axis, (first, second) in zip(figure.axes, axes, strict=True):
        np.testing.assert_array_equal(axis.lines[0].get_xdata(), path[:, first])
        np.testing.assert_array_equal(axis.lines[0].get_ydata(), path[:, second])
        assert axis.get_xlabel() == f"{'xyz'[first]} (m)"


def test_without_curves_there_is_no_such_picture():
    results = mbproj.run(mechanism("five_bar"), duration=0.01)
    assert kinds.why_not("contacts", [results]) == "the results have no joints that follow curves"
