"""`integrator: auto`: an explicit method until a force holds it up, an implicit one until nothing does; where nothing
is stiff it has the bits of DOP853."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from mbproj import Scene
from mbproj.base.errors import InputError
from mbproj.motion import automatic as march
from mbproj.motion.automatic import Plan
from mbproj.motion.simulate import simulate
from mbproj.scene.scene import read_scene, read_scene_text
from mbproj.scene.settings import settings_to_run
from tests.cli.commands import mbproj, succeeds
from tests.crossed import crossed, full
from tests.integrate.stiff_scenes import CLAMP, CREEP, rod
from tests.support import ROOT, Recorder, assembled

#: A mass on a spring of 1e8 N/m with its damper, and one that vibrates with 300 rad/s for good, which every method has
#: to follow.
RINGING = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 0.5 s, tolerance: 1.0e-7, integrator: auto, output_step: 0.01}
bodies:
  mass: {mass: 1 kg, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
  bob: {mass: 1 kg, inertia: [0.1, 0.1, 0.1], position: [0.1, 0, 0]}
joints:
  rail: {type: prismatic, bodies: [ground, mass], location: [0, 0, 0], axis: [1, 0, 0]}
  wire: {type: prismatic, bodies: [ground, bob], location: [0, 0, 0], axis: [1, 0, 0]}
forces:
  bush: {type: linear_spring_damper, joint: rail, force: "1e5*sin(3*t) - 1e8*displacement - 2e4*displacement_dot"}
  coil: {type: linear_spring_damper, joint: wire, force: "-9e4*(displacement + 0.1)"}
"""


#: A block on a belt that rubs on it with a steep law: it is carried along, slips, and is carried again.
BELT = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 2 s, tolerance: 1.0e-7, integrator: auto, output_step: 0.02}
bodies:
  block: {mass: 1 kg, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
joints:
  slide: {type: prismatic, bodies: [ground, block], location: [0, 0, 0], axis: [1, 0, 0]}
forces:
  grip: {type: linear_spring_damper, joint: slide, force: "-100*displacement - 6*tanh((displacement_dot - 0.1)/WIDTH)"}
"""


def belt(width: str) -> Scene:
    return read_scene_text(BELT.replace("WIDTH", width))


def damped(stiffness: float) -> Scene:
    scene = rod(stiffness, 1e3)
    return replace(scene, settings=replace(scene.settings, duration=2.0, tolerance=1e-7))


#: Where one method or the other is better, or each for a while.
SCENES = {
    "belt of width 1e-5": lambda: belt("1e-5"),
    "belt of width 1e-3": lambda: belt("1e-3"),
    "damped rod of 1e6 N/m": lambda: damped(1e6),
    "damped rod of 1e7 N/m": lambda: damped(1e7),
    "clamp": lambda: read_scene_text(CLAMP),
    "creep": lambda: read_scene_text(CREEP),
    "ringing": lambda: read_scene_text(RINGING),
    "quarter_car": lambda: read_scene(ROOT / "mechanisms" / "quarter_car.yaml", {}, {"tolerance": "1e-7"}),
    "split_coupler": lambda: read_scene(ROOT / "mechanisms" / "split_coupler.yaml", {}, {"tolerance": "1e-7"}),
}


class Kept(Recorder):
    """A recorder of blocks, events and marks."""

    def __init__(self):
        super().__init__()
        self.met, self.marks = [], []

    def events(self, events):
        self.met = list(events)

    def keep(self, formulation, build, mark):
        self.marks.append(mark)

    @property
    def methods(self):
        return [(event.time, event.kind) for event in self.met if event.name == "integrator"]


def run(scene, resumed=None, until=None, **changes):
    system, state = assembled(scene)
    settings = replace(settings_to_run(scene), **changes)
    settings = settings if until is None else replace(settings, duration=until)
    kept = Kept()
    report = simulate(system, state, settings, kept, keep=kept.keep, resumed=resumed or {})
    return kept, report


@pytest.mark.parametrize("formulation", ["reduced", "planar"])
def test_a_clamp_is_stiff_while_it_holds(formulation):
    """Explicit steps before and after, implicit ones between; on both sides the motion is the exact one."""
    kept, report = run(read_scene_text(CLAMP), formulation=formulation, tolerance=1e-9)
    (begins, implicit), (ends, explicit) = kept.methods
    assert implicit.startswith("esdirk4 goes on, for force 'clamp' (ω h = ")
    assert explicit == "dop853 goes on"
    assert 0.5 < begins < 0.52 and 1.0 < ends < 1.6
    t, x = kept["time"], kept["bodies/position"]
    held, free = (t > 0.51) & (t <= 1.0), t > 1.0
    assert np.abs(x[held, 0, 0] - 0.05).max() < 1e-7
    assert np.abs(x[free, 0, 0] - 0.05 + 0.2 * (t[free] - 1.0) ** 2).max() < 1e-6
    assert np.abs(x[:, 1, 0] - 0.1 * np.cos(10.0 * t)).max() < 5e-6
    assert report.counters["steps"] < 250
    assert report.methods[0].startswith("stiff: force 'clamp' (ω h = ")
    assert report.methods[2].startswith("3 trials of the other method: ")
    _, alone = run(read_scene_text(CLAMP), formulation=formulation, integrator="dop853")
    assert alone.counters["steps"] > 750


def test_in_the_full_formulation(monkeypatch):
    """x follows 0.1 sin(t) with a delay of 2e-4 s: the spring gives way by what its damper and the mass take. The first
    look is early here, because NumPy's steps take long."""
    monkeypatch.setattr(march, "Plan", partial(Plan, due=30))
    kept, report = run(read_scene_text(CREEP), formulation="full")
    (_, kind), *others = kept.methods
    assert kind.startswith("esdirk4 goes on, for force 'bush'")
    assert not others
    assert kept["bodies/position"][-1, 0, 0] == pytest.approx(0.1 * np.sin(0.5 - 2e-4), abs=1e-7)
    assert report.counters["steps"] < 60


@pytest.mark.parametrize("name", ["five_bar", "quarter_car"])
def test_where_nothing_is_stiff_it_has_the_bits_of_dop853(name):
    """A five-bar has no forces; in a quarter car the implicit method is tried."""
    scene = read_scene(ROOT / "mechanisms" / f"{name}.yaml", {}, {"tolerance": "1e-9", "integrator": "auto"})
    (auto, report), (alone, _) = (run(scene, until=3.0, integrator=which) for which in ("auto", "dop853"))
    assert not auto.methods
    why = "no force is stiff" if name == "five_bar" else "esdirk4 was not quicker"
    assert report.methods[0] == f"dop853 throughout: {why}"
    for path in alone.blocks[0]:
        np.testing.assert_array_equal(auto[path], alone[path], err_msg=path)


@pytest.mark.parametrize("name", [full(name) if number % 3 else name for number, name in enumerate(SCENES)])
def test_it_takes_little_more_than_the_better_of_its_methods(name):
    """In steps, 1.25 times and 20 more; trials take a tenth of the evaluations beside the first two."""
    which = ("auto", "dop853", "esdirk4")
    report, *others = (run(SCENES[name](), integrator=each)[1] for each in which)
    steps, *alone = (each.counters["steps"] + each.counters["rejected_steps"] for each in (report, *others))
    assert steps <= 1.25 * min(alone) + 20
    trials = int(report.methods[-1].partition(": ")[2].partition(" ")[0])
    assert trials <= 0.11 * report.counters["evaluations"] + 500


@crossed("until, formulation", [0.51, 0.62, 0.8, 1.1, 1.8], ["reduced", "planar"], together=1)
def test_a_run_goes_on_with_the_bits_of_one_long_run(formulation, until):
    """From before its first change, between the two, and after; and where the end cuts the trial before the first one
    short, at 0.51 s."""
    scene = read_scene_text(CLAMP)
    whole, _ = run(scene, formulation=formulation)
    short, _ = run(scene, formulation=formulation, until=until)
    mark = short.marks[-1]
    rest, _ = run(scene, mark, formulation=formulation)
    first = int(np.searchsorted(whole["time"], mark["t"], side="right"))
    for path in whole.blocks[0]:
        np.testing.assert_array_equal(rest[path], whole[path][first:], err_msg=path)
    assert rest.methods == whole.methods


def test_a_mark_without_its_plan_is_refused():
    scene = read_scene_text(CLAMP)
    mark = run(scene, until=0.2)[0].marks[-1]
    for plan in ({}, mark["plan"] | {"method": "rk4"}, mark["plan"] | {"since": [0.0]}):
        with pytest.raises(InputError, match="the state to go on from is not one of this scene"):
            run(scene, mark | {"plan": plan}, until=0.3)


def test_it_takes_no_step():
    with pytest.raises(InputError) as caught:
        read_scene_text(CLAMP, simulation={"step": "1 ms"})
    assert caught.value.problems[0].message == "'auto' chooses its steps by their error: it takes no 'step'"
    assert caught.value.problems[0].hint == "give a 'tolerance'"


def test_the_summary_and_the_results_file_say_it(tmp_path):
    (tmp_path / "clamp.yaml").write_text(CLAMP)
    done = succeeds("run", "clamp.yaml", folder=tmp_path)
    assert "    stiff: force 'clamp' (ω h = 6" in done.stdout
    assert "; esdirk4 from t = 0.51" in done.stdout
    shown = mbproj("info", "results.h5", folder=tmp_path).stdout
    assert ": integrator, esdirk4 goes on, for force 'clamp' (ω h = 6" in shown
