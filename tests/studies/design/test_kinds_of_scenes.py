"""Numbers are found again in scenes that roll, that have cams, signals and states, from runs of the truth."""

from __future__ import annotations

import numpy as np
import pytest

import mbproj
from mbproj.base.mechanisms_folder import mechanism
from tests.crossed import where
from tests.studies.design.scenes import found, table, written

#: A motor whose torque follows an error with a lag: a signal, and a state.
CONTROLLED = """\
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {gain: 3, length: 0.5 m, lag: 0.1 s}
bodies:
  arm: {mass: 1, inertia: [0.02, 0.02, 0.02], position: [0, 0, -length]}
joints: {A: {type: revolute, bodies: [ground, arm], location: [0, 0, 0], axis: [0, -1, 0]}}
signals: {error: "0.5 - A.angle"}
states: {held: {derivative: "(error - held)/lag", initial: 0}}
forces: {motor: {type: torque, body: arm, torque: [0, "-gain*1 N*m*held", 0]}}
simulation: {duration: 1 s, step: 5 ms, output_step: 50 ms}
"""


def scene(name, **changes):
    """A mechanism's scene without what it expects, with shorter runs."""
    text = mechanism(name).read_text(encoding="utf-8").partition("expect:")[0]
    for old, new in changes.items():
        text = text.replace(f"{old}: ", f"{old}: {new}  # ", 1)
    return text


#: Scenes by what they have, what varies (truth, low, high), and what is measured of them.
CASES = {
    "a coin that rolls": (lambda: scene("rolling_coin", time="0.5 s"), {"push": (0.3, 0.1, 0.6)}, "centre"),
    "a ball that rolls": (
        lambda: scene("turntable", time="0.5 s"),
        {"Omega": (3.3, 2.0, 4.0), "x": (0.55, 0.3, 0.7)},
        "centre",
    ),
    "a cam": (lambda: scene("cam"), {"lift": (0.018, 0.01, 0.03), "base": (0.04, 0.03, 0.05)}, "centre"),
    "signals and states": (lambda: CONTROLLED, {"gain": (4.0, 1.0, 8.0), "lag": (0.2, 0.05, 0.4)}, ""),
}


@pytest.mark.parametrize("case", where(lambda case: case != "a cam", CASES))
def test_the_truth_is_found_again(case, tmp_path):
    make, varied, marker = CASES[case]
    text, truth = make(), {name: value for name, (value, _, _) in varied.items()}
    with mbproj.run(mbproj.read_scene_text(text, "scene", truth)) as results:
        every = slice(None, None, max(len(results.time) // 20, 1))
        if marker:
            parts = zip("xyz", results.marker(marker).position[every].T, strict=True)
            table(tmp_path / "m.csv", time__s=results.time[every], **{f"position_{k}__m": part for k, part in parts})
        else:
            table(tmp_path / "m.csv", time__s=results.time, angle__rad=results.coordinate("A.angle").value)
    of = f"marker: {marker}" if marker else "joint: A, quantity: angle"
    vary = "".join(f"  parameters.{name}: [{low}, {high}]\n" for name, (_, low, high) in varied.items())
    spec = f"vary:\n{vary}match: {{m: {{{of}, through: m.csv}}}}\nstarts: 1\n"
    design, numbers = found(written(tmp_path, text, spec))
    assert numbers == pytest.approx(truth, rel=1e-9)
    assert np.sqrt(np.mean(design.trial.residuals**2)) < 1e-11


@pytest.mark.full
def test_a_measure_of_round_off_is_no_measure_where_none_is_named():
    """How well joints close does not depend on numbers but by chance; by its name it is measured all the same."""
    text = CONTROLLED + (
        "expect:\n"
        "  ends: {joint: A, quantity: angle, at: end, below: 10, source: it turns}\n"
        "  closed: {diagnostic: position_violation, at: maximum, below: 1.0e-12, source: joints are closed}\n"
    )
    assert set(mbproj.sensitivity(text, to=["gain"]).table["measure"]) == {"ends"}
    assert set(mbproj.sensitivity(text, of=["closed"], to=["gain"]).table["measure"]) == {"closed"}
