"""Recommendations hold against references that the recommender did not see, and why an error cannot be kept."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mbproj import InputError, read_scene
from mbproj.base.mechanisms_folder import mechanism
from mbproj.scene.scene import read_scene_text
from mbproj.studies.measure.measurement import Measurement
from mbproj.studies.measure.reference import Reference, not_smooth, sampled, uneven, why_not
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import Mechanism, solve
from mbproj.studies.recommend import Bench, Family, Unreachable, cheapest, families, recommend, with_closed_joints
from tests.crossed import full, some

# Recommendations hold against references that the recommender did not see, and nothing is much cheaper.
#
# The whole claim (ten mechanisms, three errors, the clock) is measured by scripts/recommendations.py.


@pytest.fixture(autouse=True)
def _own_cache(tmp_path_factory, monkeypatch):
    monkeypatch.setenv("MBPROJ_CACHE", str(tmp_path_factory.getbasetemp() / "cache"))


def unseen(name: str, until: float, **simulation: object) -> Bench:
    """A bench whose reference is DOP853 with error control, which the recommender's is not."""
    ready = Mechanism.of(read_scene(mechanism(name), {}, simulation))
    times = sampled(ready.scene, until)
    tight, loose = (solve(ready, Setting(integrator="dop853", tolerance=tol), times) for tol in (1e-14, 1e-13))
    apart = np.linalg.norm(tight.position - loose.position, axis=2)
    reference = Reference(ready.points, times, tight.position, tight.velocity, apart, "", "")
    return Bench(ready, reference, 1.0, tuple(range(len(ready.points))))


@pytest.mark.parametrize(
    ("name", "until", "goal"),
    some([("hooke_shaft", 1.0, 1e-3), ("five_bar", 1.0, 1e-6), ("spherical_pendulum", 2.0, 1e-9)], 3),
)
def test_a_recommendation_holds_and_nothing_in_a_dense_grid_is_much_cheaper(name, until, goal):
    bench = unseen(name, until, output_step=0.02)
    found = recommend(bench.mechanism.scene, goal, until=until, timed=False)
    fresh = bench.fresh(found.setting, Mechanism.of(bench.mechanism.scene))
    assert found.reached
    assert fresh.at() <= goal + found.uncertain
    assert fresh.evaluations == found.best.evaluations
    rivals = []
    for family in families(Setting(), float(bench.reference.times[1])):
        for fineness in range(7, 209, 7) if family.by_error else range(1, 400):
            cost = family.fixed_cost(fineness, len(bench.reference.times) - 1)
            if not family.by_error and cost > fresh.evaluations / 1.5:
                break
            rivals.append(bench.measure(family.setting(fineness)))
            if family.by_error and rivals[-1].evaluations > fresh.evaluations:
                break
    assert not [rival for rival in rivals if rival.at() <= goal and 1.5 * rival.evaluations < fresh.evaluations]


@pytest.mark.parametrize(("name", "goal"), [("spherical_pendulum", 0.02), full("five_bar", 0.02)])
def test_of_what_is_recommended_no_run_warns_that_its_energy_drifts(name, goal):
    """An error of centimetres can be kept by so few steps that the energy tells of a wrong motion."""
    scene = read_scene(mechanism(name), {}, {"output_step": 0.05})
    found = recommend(scene, goal, until=1.0, timed=False)
    report = solve(Mechanism.of(scene), found.setting, sampled(scene, 1.0)).report
    assert found.best.at() <= goal
    assert not report.drifts


@pytest.mark.full
def test_what_cannot_be_kept_to_the_end_is_kept_as_long_as_round_off_allows():
    scene = read_scene(mechanism("five_bar"), {}, {"output_step": 0.05})
    found = recommend(scene, 3e-14, until=3.0, timed=False)
    assert not found.reached
    assert 0.2 < found.until < 2.5
    assert (found.wanted, found.settings.duration) == (3.0, pytest.approx(found.until, rel=1e-9))
    assert found.best.at() <= 3e-14
    with pytest.raises(Unreachable, match="errors grow from round-off: starts that differ by it"):
        recommend(scene, 1e-19, until=3.0, timed=False)


def test_the_error_counts_at_the_markers_that_are_named():
    scene = read_scene(mechanism("hooke_shaft"))
    one = recommend(scene, 1e-6, ["driven_rim"], until=0.5, timed=False)
    assert one.points == ("driven_rim",)
    assert one.best.worst() == "driven_rim"
    with pytest.raises(InputError, match="no 'driven_rin' among the markers; did you mean 'driven_rim'"):
        recommend(scene, 1e-6, ["driven_rin"])


WHEEL = """
mbproj: 1
gravity: [0, 0, 0]
bodies:
  wheel: {mass: 1, inertia: [0.1, 0.1, 0.2], position: [0, 0, 0]}
joints:
  pin: {type: revolute, bodies: [ground, wheel], location: [0, 0, 0], axis: [0, 1, 0], angle: 1, speed: 2}
forces:
  spring: {type: torsion_spring_damper, joint: pin, stiffness: 5}
simulation: {duration: 2, step: 0.05}
"""


@pytest.mark.full
def test_a_body_that_only_turns_has_an_error_where_it_has_a_marker():
    """Its centre does not move: Heun's method with the longest steps was the cheapest, with an error of 0 m."""
    with pytest.raises(
        InputError, match=r"none of these moves although bodies turn[^z]*put a marker on a body that turns"
    ):
        recommend(read_scene_text(WHEEL), 1e-5)
    rim = "markers: {rim: {body: wheel, location: [0.3, 0, 0]}}\n"
    assert 0.0 < max(recommend(read_scene_text(WHEEL + rim), 1e-5).best.error.values()) <= 1e-5


def test_samples_are_those_of_the_scene():
    scene = read_scene(mechanism("five_bar"))
    np.testing.assert_allclose(sampled(scene, 0.025), [0.0, 0.01, 0.02, 0.025])
    np.testing.assert_allclose(sampled(scene, 0.001), [0.0, 0.001])
    assert len(sampled(replace(scene, settings=replace(scene.settings, step=None, tolerance=1e-6)), None)) == 1001


def test_joints_stay_closed_whatever_the_scene_asks_for():
    assert with_closed_joints(Setting("none")) == Setting("gpopm")
    assert with_closed_joints(Setting("gopm", every=5)) == Setting("gpopm")
    assert with_closed_joints(Setting("mmopm", alpha=1e7, formulation="full")) == Setting("gpopm")
    assert with_closed_joints(Setting("gopm", formulation="full")).projection == "gopm"


class Made(Bench):
    """A bench of made-up errors: those of the family's order, and one lucky setting."""

    def __init__(self, family: Family, lucky: int | None = None) -> None:
        self.family, self.lucky, self.goal, self.tried = family, lucky, 1e-6, []

    def measure(self, setting: Setting) -> Measurement:
        fineness = round(self.family.interval / setting.step)
        self.tried.append(fineness)
        error = 1e-9 if fineness == self.lucky else 1e2 * fineness ** -float(self.family.order)
        return Measurement(setting, {"tip": error}, {"tip": 0.0}, counters={"evaluations": fineness})


def test_the_search_finds_the_coarsest_in_few_runs_and_what_is_lucky_below_it():
    family = Family(Setting(), "rk4", by_error=False, interval=1.0)
    made = Made(family)
    found = cheapest(made, family, 1)
    assert 100.0 <= found.evaluations <= 1.03 * 100.0  # (1e8)^(1/4)
    assert len(set(made.tried)) < 35
    lucky = cheapest(Made(family, lucky=70), family, 1)
    assert lucky.evaluations in (70.0, 100.0, 101.0, 102.0)


def test_a_family_beyond_the_budget_has_no_cheapest():
    bench = unseen("spherical_pendulum", 0.5)
    bench.goal = 1e-9
    family = Family(Setting(), "bs32", by_error=True, interval=float(bench.reference.times[1]))
    assert cheapest(bench, family, 60, budget=200.0) is None


@pytest.mark.full
def test_several_processes_find_what_one_finds():
    """Each integrator is searched on its own, so that the order in which searches end has no say."""
    scene = read_scene(mechanism("spherical_pendulum"), {}, {"output_step": 0.02})
    one, two = (recommend(scene, 1e-4, until=0.5, timed=False, fresh=True, processes=n) for n in (1, 2))
    assert [each.setting for each in one.contenders] == [each.setting for each in two.contenders]
    assert {each.setting for each in one.tried} == {each.setting for each in two.tried}
    assert {each.setting for each in one.contenders} < {each.setting for each in one.tried}


def test_what_was_tried_is_not_tried_again_but_the_winner_runs_afresh(monkeypatch):
    scene = read_scene(mechanism("spherical_pendulum"), {}, {"output_step": 0.02})
    first = recommend(scene, 2e-5, until=0.5, timed=False)
    runs, fresh = [], Bench.fresh
    monkeypatch.setattr(Bench, "fresh", lambda self, which, ready: runs.append(which) or fresh(self, which, ready))
    again = recommend(scene, 2e-5, until=0.5, timed=False)
    assert runs == [first.setting]
    assert again.setting == first.setting


# Why an error cannot be kept: chaos, round-off, too many kinks, a reference that does not converge.

PENDULUM = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 2, step: 0.01}
bodies: {bar: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0.5, 0, 0]}}
joints: {pin: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, 1, 0]}}
markers: {end: {body: bar, location: [1, 0, 0]}}
"""
DOUBLE_PENDULUM = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 20, step: 0.01}
bodies:
  bar: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0.5, 0, 0]}
  tip: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [1.5, 0, 0]}
joints:
  pin: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, 1, 0]}
  knee: {type: revolute, bodies: [bar, tip], location: [1, 0, 0], axis: [0, 1, 0]}
markers: {end: {body: tip, location: [2, 0, 0]}}
"""
DOOR = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 3, step: 1 ms}
bodies: {door: {mass: 20, inertia: [2, 2, 1.5], position: [0.4, 0, 0]}}
joints: {hinge: {type: revolute, bodies: [ground, door], location: [0, 0, 0], axis: [0, 0, 1], speed: 1 rad/s}}
markers: {handle: {body: door, location: [0.8, 0, 0]}}
forces:
  stop: {type: torsion_spring_damper, joint: hinge, torque: "-5000*max(0, angle - 0.5) - 0.2*sign(angle)"}
"""


def uncertain(text: str, by: float, end: float, limit: str = "") -> tuple[Mechanism, Reference]:
    """A mechanism, and a reference that is uncertain by so much (m) after the start."""
    ready = Mechanism.of(read_scene_text(text, "scene.yaml"))
    times = np.linspace(0.0, end, 41)
    found = solve(ready, Setting(integrator="dop853", tolerance=1e-12), times)
    uncertainty = np.full(found.position.shape[:2], by)
    uncertainty[0] = 0.0
    return ready, Reference(ready.points, times, found.position, found.velocity, uncertainty, "", "", limit)


def test_round_off_is_named_only_where_it_explains_the_error():
    ready, reference = uncertain(PENDULUM, 1e-14, 1.0)
    assert why_not(ready, reference, 1e-15, 1.0).startswith("errors grow from round-off: starts that differ by it are ")
    assert why_not(ready, replace(reference, uncertainty=1e-4 * np.ones((41, 1))), 1e-6, 1.0) == (
        "the reference does not converge: the best solutions are uncertain by 0.0001 m at 1 s; a load that is "
        "shorter than a step may be the reason"
    )


def test_a_law_with_too_many_kinks_is_named_and_one_with_edges_is_not():
    """Steps end at the edges of a door's stop, wherever these are: they are no reason."""
    door, _ = uncertain(DOOR, 1e-5, 0.3)
    assert uneven(door, 0.3) == ()
    rattle = PENDULUM + "forces: {push: {type: torsion_spring_damper, joint: pin, torque: '1e-9*abs(sin(9000*t))'}}\n"
    ready, reference = uncertain(rattle, 1e-5, 1.0)
    said = "force 'push' has more kinks in time than steps end at"
    assert not_smooth(uneven(ready, 1.0)) == said
    assert why_not(ready, reference, 1e-7, 1.0) == f"{said}, and the best solutions are uncertain by 1e-05 m at 1 s"
    known = replace(reference, uncertainty=9e-8 * np.ones((41, 1)))
    assert why_not(ready, known, 1e-7, 1.0) == f"{said}, and no setting is that accurate"


def test_a_reference_that_ended_says_why():
    ready, reference = uncertain(PENDULUM, np.inf, 1.0, "dopri5 stopped at 0.3 s")
    assert why_not(ready, reference, 1e-6, 1.0) == "dopri5 stopped at 0.3 s"


def test_chaos_is_named():
    """A double pendulum that tumbles: starts part with a rate of some 1/s."""
    ready, reference = uncertain(DOUBLE_PENDULUM, 1e-3, 20.0)
    why = why_not(ready, reference, 1e-9, 20.0)
    assert why.startswith("the motion is chaotic: starts that differ by round-off part as exp(")


@pytest.mark.full
def test_a_door_with_a_stop_gets_its_recommendation():
    """Its error holds against DOP853 at a tolerance of 1e-13, whose steps end at the stop."""
    ready = Mechanism.of(read_scene_text(DOOR, "door.yaml"))
    found = recommend(ready.scene, 1e-6, until=3.0, timed=False)
    assert found.reached
    times = np.linspace(0.0, 3.0, 31)
    better = solve(ready, Setting(integrator="dop853", tolerance=1e-13), times)
    chosen = solve(ready, found.setting, times)
    assert np.linalg.norm(chosen.position - better.position, axis=2).max() <= 1e-6 + found.uncertain
