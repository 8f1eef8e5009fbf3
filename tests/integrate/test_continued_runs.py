"""A run that goes on from a mark or a results file has the bits of one long run, with stops and dry friction too."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from mbproj.base.errors import InputError
from mbproj.equations.assembly.compiled import compile_system
from mbproj.motion.formulations.full import FullFormulation
from mbproj.motion.marks import Marks
from mbproj.motion.numpy_loop import march
from mbproj.motion.report import Tally
from mbproj.motion.simulate import simulate
from mbproj.motion.time_events import time_events
from mbproj.scene.scene import read_scene, read_scene_text
from mbproj.scene.settings import settings_to_run
from tests.crossed import crossed, full
from tests.friction.scenes import AGAIN, BELT, SLIPS, STICKS
from tests.integrate.event_scenes import TROLLEY, bounce, rotor
from tests.mechanisms.closed_forms import PARALLELOGRAM
from tests.stops.runs import DOP853, goes_on, simulated
from tests.stops.runs import FIXED as FIXED_STEPS
from tests.support import REDUNDANT, ROOT, Recorder, assembled

# A run that goes on from a mark of a shorter one has the bits of one long run: in all formulations, with fixed steps
# and with error control, with rows that follow from others, near singular poses, across events.

FORMULATIONS = ("full", "reduced", "planar")
FIXED = {"integrator": "rk4", "step": "0.01", "output_step": "0.02"}
BY_ERROR = {"integrator": "dopri5", "tolerance": "1e-7", "output_step": "0.03"}
OPTIONS = [pytest.param(FIXED, id="fixed"), pytest.param(BY_ERROR, id="by_error")]
JUMPS = rotor("sin(3*t) + 2*sign(t - 0.313) + 1000*exp(-((t - 0.7)/1e-3)**2)")
TURNING = rotor("3 - 0.2*angle")


class Kept:
    """The marks of a run, in their order."""

    def __init__(self):
        self.marks = []

    def __call__(self, formulation, build, mark):
        self.marks.append(mark)


def scene_of(what, options):
    if what.endswith("\n"):
        return read_scene_text(what, simulation=options)
    return read_scene(ROOT / "mechanisms" / f"{what}.yaml", {}, options)


def run(what, until, options, resumed=None):
    """(recorder, marks) of a run; what a run goes on from comes with it, and the recorder has its report."""
    scene = scene_of(what, options)
    system, state = assembled(scene)
    recorder, kept = Recorder(), Kept()
    settings = replace(settings_to_run(scene), duration=until)
    recorder.report = simulate(system, state, settings, recorder, keep=kept, resumed=resumed or {})
    return recorder, kept.marks


def assert_goes_on(what, short, long, options):
    whole, _ = run(what, long, options)
    _, marks = run(what, short, options)
    mark = marks[-1]
    rest, _ = run(what, long, options, mark)
    first = int(np.searchsorted(whole["time"], mark["t"], side="right"))
    assert 0 < first < len(whole["time"])
    for path in whole.blocks[0]:
        np.testing.assert_array_equal(rest[path], whole[path][first:], err_msg=path)
    for level in ("position_violation", "velocity_violation"):  # the largest of the first part counts, too
        assert getattr(rest.report, level) == getattr(whole.report, level)


@crossed(
    "what, formulation, options",
    [pytest.param(TURNING, id="turning"), pytest.param(JUMPS, id="jumps"), pytest.param(TROLLEY, id="trolley")],
    FORMULATIONS,
    OPTIONS[::-1],
    dear=["full"],
)
def test_the_bits_of_one_long_run(what, formulation, options):
    """The short run ends between two steps of its grid, and once in the middle of a pulse."""
    options = options | {"formulation": formulation}
    what, end = what.replace("start: 3,", "start: 0.6,"), 0.7003
    assert_goes_on(what, end, end + 0.2, options)


@pytest.mark.parametrize(
    ("what", "integrator", "options"),
    [
        (JUMPS, "esdirk4", {"step": "0.04"}),
        (JUMPS, "radau5", {"tolerance": "1e-4"}),
        (TURNING, "radau5", {"step": "0.04"}),
        (bounce(), "esdirk4", {"tolerance": "1e-4"}),
    ],
)
def test_implicit_steps_go_on(what, integrator, options):
    """Accelerations and multipliers that are carried on are part of the state, past events in time and state."""
    assert_goes_on(what, 0.42, 0.5, options | {"integrator": integrator, "output_step": "0.04"})


@crossed("name, options", ["five_bar", *REDUNDANT, "inline_four", "spatial_slider_crank"], OPTIONS, together=1)
def test_shipped_mechanisms_in_their_own_formulation(name, options):
    assert_goes_on(name, 0.205, 0.5, options)


@crossed("options, formulation", OPTIONS[::-1], FORMULATIONS, dear=["full"])
def test_past_a_singular_pose(formulation, options):
    """Rows that a singular pose has left out are part of the state."""
    text = PARALLELOGRAM.replace("CLOSURE", "point_on_line")
    assert_goes_on(text, 0.9, 1.5, options | {"formulation": formulation})


def test_a_run_too_short_to_go_on_from_starts_over():
    """The end has shaped its first step."""
    options = BY_ERROR | {"output_step": "1e-7", "duration": "1e-7"}
    _, marks = run(TURNING, 1e-7, options)
    assert marks[-1] == {}


@pytest.mark.parametrize("torque", ["1000*exp(-((t - 1)/1e-4)**2)", "sqrt(abs(t - 1))", "max(0, sin(40*t))"])
def test_events_do_not_depend_on_the_end(torque):
    system = compile_system(read_scene_text(rotor(torque)))
    short, long = (time_events(system, 0.0, end, 0.01) for end in (2.0, 17.0))
    assert short
    assert short == tuple(event for event in long if event.time <= 2.0)


def without(mark, name):
    return {key: value for key, value in mark.items() if key != name}


@pytest.mark.parametrize("options", [FIXED, BY_ERROR], ids=["fixed", "by_error"])
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_state_that_is_not_of_this_scene_is_refused(formulation, options):
    """As a changed file has it, or one of another scene."""
    options = options | {"formulation": formulation}
    _, marks = run(TURNING, 0.5, options)
    mark = marks[-1]
    short, wild = mark["y"][:-1], np.full_like(mark["y"], np.nan)
    for given in (without(mark, "y"), mark | {"y": short}, mark | {"y": wild}, mark | {"t": "soon"}, {"t": 0.5}):
        with pytest.raises(InputError, match="the state to go on from is not one of this scene"):
            run(TURNING, 1.0, options, given)


def test_what_nobody_keeps_is_not_made():
    scene = scene_of(TURNING, BY_ERROR | {"formulation": "full"})
    system, state = assembled(scene)
    settings = replace(settings_to_run(scene), duration=0.2)
    marks = Marks()
    for _ in march(FullFormulation.of(system, state, settings), state, Tally(), marks):
        assert marks.newest() == {}


# Runs with stops go on from a results file: with the bits of one run, whatever touches when it ends.

TEXT = """
mbproj: 1
gravity: [0, -10, 0]
simulation: {{duration: {duration}, {steps}, formulation: {formulation}}}
bodies:
  bob: {{mass: 1, inertia: [0.01, 0.01, 0.01], position: [0, -1, 0]}}
joints:
  pivot:
    type: revolute
    bodies: [ground, bob]
    location: [0, 0, 0]
    axis: [0, 0, 1]
    speed: 2
    limits: {{angle: {{range: [-0.3, 0.2], {law}}}}}
forces:
  push: {{type: torque, body: bob, torque: [0, 0, "6 * sin(1.5 * t)"]}}
"""


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("law", ["rigid: true, restitution: 0.5", "stiffness: 1.0e4, restitution: 0.5"])
@pytest.mark.parametrize(
    ("formulation", "steps"), [("planar", DOP853), ("planar", FIXED_STEPS), ("full", "integrator: rk4, step: 0.02")]
)
def test_a_run_with_stops_goes_on_with_the_bits_of_a_longer_one(formulation, steps, law):
    """After impacts: the first is at 0.1 s."""
    until = 0.4 if formulation == "full" else 2.0
    long = TEXT.format(duration=2.0 * until, steps=steps, formulation=formulation, law=law)
    _, _, time = goes_on(long, 2.0 * until, until, ("stops/force", "diagnostics/dissipation"))
    assert time > 0.1


SOFT = TEXT.format(duration=2, steps=FIXED_STEPS, formulation="planar", law="stiffness: 1.0e2, restitution: 0.5")


@pytest.mark.parametrize(
    ("part", "missing", "why"),
    [
        ({"counters": {"steps": 0}, "law": 1}, "", "with another law of stops that give way"),
        ({"counters": {"steps": 8}, "law": 2}, "", "which met stops in another way"),
        ({"counters": {"steps": 0}, "law": 2}, "contacts", "which met stops in another way"),
    ],
)
def test_what_an_older_mbproj_has_marked_within_a_run_is_refused(part, missing, why):
    _, kept = simulated(SOFT.replace("duration: 2", "duration: 0.35"))
    mark = next(mark for mark in kept[::-1] if mark["contacts"]["pushing"])
    older = {name: value for name, value in mark.items() if name != missing}
    older["stops"] = {"tally": {"counters": part["counters"]}, "law": part["law"]}
    with pytest.raises(InputError, match=f"an older mbproj made it, {why}"):
        simulated(SOFT, older)


def test_what_an_older_mbproj_has_marked_of_a_whole_run_goes_on():
    whole, _ = simulated(SOFT)
    _, kept = simulated(SOFT.replace("duration: 2", "duration: 0.35"))
    older = {**kept[-1], "stops": {"tally": {"counters": {"steps": 0}}, "law": 2}}
    rest, _ = simulated(SOFT, older)
    assert np.array_equal(rest["bodies/position"], whole["bodies/position"][whole["time"] > older["t"]])


# Runs with dry friction go on from a results file: with the bits of one run, whatever sticks when it ends.

ENDS = (0.5 * (STICKS + SLIPS), SLIPS + 0.1, AGAIN - 0.1, AGAIN + 0.2)
DOPRI5 = "integrator: dopri5, tolerance: 1.0e-9, output_step: 0.02 s"
FIXED_STICKING = "integrator: rk4, step: 0.02 s"
COARSE = "integrator: rk4, step: 0.1 s"


def text(duration, steps, formulation):
    own = f"simulation: {{duration: {duration}, {steps}, formulation: {formulation}}}"
    return re.sub("simulation: .*", own, BELT.partition("expect:")[0])


@pytest.mark.parametrize(
    ("steps", "formulation"), [(DOPRI5, "planar"), (FIXED_STICKING, "planar"), full(COARSE, "full")]
)
def test_a_run_with_friction_goes_on_with_the_bits_of_a_longer_one(steps, formulation):
    whole, _ = simulated(text(3.5, steps, formulation))
    assert [event.kind for event in whole.happened] == ["stick", "slip", "stick"]
    begun = []
    for end in ENDS if formulation == "planar" else ENDS[2:4]:
        end = 0.1 * round(end / 0.1)
        part, kept = simulated(text(f"{end:.1f}", steps, formulation))
        rest, _ = simulated(text(3.5, steps, formulation), kept[-1])
        begun.append(kept[-1]["t"])
        before, after = whole["time"] <= begun[-1], whole["time"] > begun[-1]
        paths = ("time", "bodies/velocity", *(f"friction/{name}" for name in ("rate", "force", "state", "dissipation")))
        for path in paths:
            assert np.array_equal(part[path][: before.sum()], whole[path][before]), (end, path)
            assert np.array_equal(rest[path], whole[path][after]), (end, path)
        assert rest.happened == whole.happened
    assert begun[-1] > STICKS
