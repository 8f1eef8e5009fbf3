"""The full formulation of a mechanism with stops or dry friction, in the kernel's loop: accelerations and projections
are NumPy's."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import InputError, SimulationError
from mbproj.motion.formulations import choice as formulation_choice
from mbproj.motion.formulations import full_in_loop
from mbproj.motion.formulations.full import FullFormulation
from tests.crossed import some
from tests.friction.slider_crank import linkage
from tests.kernel.scenes import needs_kernel
from tests.stops.runs import DOP853, FIXED, run, simulated
from tests.stops.scenes import BALL, DRIVEN, PRESSED_LOOP, SOFT_BALL, THREE_BALLS

FINE = "integrator: dop853, tolerance: 1.0e-9, output_step: 0.1"
COARSE = "integrator: rk4, step: 1.0e-2, output_step: 0.1"
#: Without bounces: the slider is at its stop from 0.0718 s on.
PRESSED_AT_ONCE = PRESSED_LOOP.replace("duration: 3", "duration: 0.2").replace("restitution: 0.4", "restitution: 0")
SCENES = {
    "a ball that bounces and rests": (BALL, {"e": 0.6, "duration": 1.5}),
    "a ball on a soft floor": (SOFT_BALL.replace("duration: 2", "duration: 0.4"), {}),
    "pressed through a loop": (PRESSED_AT_ONCE, {}),
    "pressed through a loop with bounces until it is let go": (
        PRESSED_LOOP.replace("duration: 3", "duration: 1.2"),
        {},
    ),
    "three balls": (THREE_BALLS.replace("duration: 3", "duration: 0.4"), {}),
    "a pusher that a motion drives": (
        DRIVEN.replace("duration: 1", "duration: 0.7, formulation: {formulation}"),
        {"wall": "rigid: true"},
    ),
}
RECORDED = ("bodies/position", "bodies/velocity", "stops/force", "joints/reaction_force", "diagnostics/dissipation")


def text_of(name, formulation, steps=FINE):
    text, more = SCENES[name]
    return text.format(steps=steps, formulation=formulation, **more)


@needs_kernel
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.full] * name.endswith("let go")) for name in SCENES]
)
def test_it_moves_as_the_reduced_one(name):
    report, own = run(text_of(name, "full"))
    _, expected = run(text_of(name, "reduced"))
    assert report.formulation == "full"
    told = [[(event.name, event.kind) for event in each.happened] for each in (own, expected)]
    assert told[0] == told[1]
    assert len(own.happened) > 0
    for path in RECORDED:
        if path in expected.blocks[0]:
            scale = max(1.0, np.abs(expected[path]).max(initial=0.0))
            np.testing.assert_allclose(own[path], expected[path], rtol=0, atol=1e-8 * scale, err_msg=path)
    assert report.position_violation.value < 2e-13


@needs_kernel
@pytest.mark.parametrize(
    ("steps", "until"), [("dop853", 0.2), *(pytest.param("rk4", until, marks=pytest.mark.full) for until in (0.2, 0.7))]
)
def test_friction_goes_by_loads_as_in_the_reduced_one(steps, until):
    """The slider turns at 0.171 s and 0.441 s."""
    _, own = run(linkage(12.0, 0.3, 0.4, until, "full", steps))
    _, expected = run(linkage(12.0, 0.3, 0.4, until, "reduced", steps))
    assert len(expected.happened) > 0
    assert [event.kind for event in own.happened] == [event.kind for event in expected.happened]
    for path in ("bodies/velocity", "friction/force", "friction/dissipation", "diagnostics/work"):
        scale = max(1.0, np.abs(expected[path]).max())
        np.testing.assert_allclose(own[path], expected[path], rtol=0, atol=1e-7 * scale, err_msg=path)


@needs_kernel
def test_accelerations_and_projections_are_numpys(monkeypatch):
    """Each evaluation and each projection of the counters is one of NumPy's."""
    asked = {"terms": 0, "project": 0}
    for name in asked:
        usual = getattr(FullFormulation, name)

        def counted(*given, name=name, usual=usual, **more):
            asked[name] += 1
            return usual(*given, **more)

        monkeypatch.setattr(FullFormulation, name, counted)
    text = BALL.format(steps=COARSE, formulation="full", e=0.6, duration=0.3)
    report, recorded = run(text)
    assert recorded.happened == []
    assert asked == {"terms": report.counters["evaluations"], "project": report.counters["projections"]}


@needs_kernel
@pytest.mark.parametrize("method", some(["gopm", "mass-orthogonal", "baumgarte"], 3))
def test_every_projection_keeps_contacts_as_the_usual_one(method):
    _, usual = run(PRESSED_AT_ONCE.format(steps=COARSE, formulation="full"))
    assert usual["stops/force"][-1].max() > 0.0
    steps = f"{COARSE}, projection: {{method: {method}}}"
    _, own = run(PRESSED_AT_ONCE.format(steps=steps, formulation="full"))
    told = [[(event.name, event.kind) for event in each.happened] for each in (own, usual)]
    assert told[0] == told[1]
    np.testing.assert_allclose(own["bodies/position"], usual["bodies/position"], rtol=0, atol=1e-4)


@needs_kernel
@pytest.mark.parametrize(
    "steps", ["integrator: dop853, tolerance: 1.0e-5, output_step: 0.1", pytest.param(COARSE, marks=pytest.mark.full)]
)
def test_a_run_goes_on_with_the_bits_of_a_longer_one(steps):
    """With redundant rows, of which NumPy's policy remembers how they were, and with a contact that holds."""
    text = PRESSED_AT_ONCE.format(steps=steps, formulation="full")
    whole, _ = simulated(text)
    _, kept = simulated(text.replace("duration: 0.2", "duration: 0.15"))
    mark = kept[-1]
    assert 0.0717 < mark["t"] <= 0.15
    assert whole["stops/force"][-1].max() > 0.0
    assert len(mark["other"]) > 4
    rest, _ = simulated(text, mark)
    for path in ("time", "bodies/position", "bodies/velocity", "stops/force", "diagnostics/dissipation"):
        assert np.array_equal(rest[path], whole[path][whole["time"] > mark["t"]]), path
    assert rest.happened == whole.happened


@needs_kernel
@pytest.mark.parametrize("error", [KeyboardInterrupt, ZeroDivisionError])
def test_what_is_thrown_there_ends_the_run(error, monkeypatch):
    def throw(*_):
        raise error("here")

    monkeypatch.setattr(FullFormulation, "project", throw)
    with pytest.raises(error, match="here"):
        run(BALL.format(steps=DOP853, formulation="full", e=0.6, duration=1.0))


@needs_kernel
def test_why_there_is_no_answer_is_said(monkeypatch):
    def fail(self, t, *_):
        raise SimulationError(t, "no answer", where="joint 'A'")

    monkeypatch.setattr(FullFormulation, "project", fail)
    with pytest.raises(SimulationError, match="joint 'A': no answer") as caught:
        run(BALL.format(steps=FIXED, formulation="full", e=0.6, duration=1.0))
    assert caught.value.formulation == "full"


@needs_kernel
def test_small_numbers_are_kept_there(monkeypatch):
    """The kernel's loop takes them for zero."""
    kept = []
    usual = full_in_loop._Answers.begin_step
    tiny = np.full(4, 5e-324)
    monkeypatch.setattr(full_in_loop._Answers, "begin_step", lambda self: kept.append((tiny * 1.0)[0]) or usual(self))
    run(BALL.format(steps=FIXED, formulation="full", e=0.6, duration=0.1))
    assert set(kept) == {5e-324}


def test_without_the_kernel_stops_and_friction_say_what_to_do(monkeypatch):
    monkeypatch.setattr(formulation_choice, "core", lambda: None)
    ball = BALL.format(steps=FIXED, formulation="full", e=0.6, duration=0.1)
    for text in (ball, linkage(12.0, 0.3, 0.4, 0.7, "full", "rk4")):
        with pytest.raises(InputError, match="stops and dry friction need the kernel") as caught:
            run(text)
        assert "install a C++ compiler, or a wheel" in str(caught.value)
