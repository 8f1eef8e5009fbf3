"""Which formulation a run takes, why it says so, and what is refused."""

from __future__ import annotations

import dataclasses
from importlib import import_module

import numpy as np
import pytest

from mbproj import Scene
from mbproj.base.errors import InputError, MbprojWarning, warn_once
from mbproj.base.registry import PROJECTIONS, ProjectionEntry
from mbproj.base.settings import ProjectionSettings, Settings
from mbproj.kernel import core
from mbproj.motion.formulations import choice as module
from mbproj.motion.formulations.choice import Choice, choose
from mbproj.motion.simulate import simulate
from mbproj.scene.scene import read_scene
from tests.kernel.scenes import needs_kernel, parallelogram
from tests.model.planar_scenes import REFUSED, SCENES, Drawing
from tests.support import MECHANISMS, REDUNDANT, ROOT, assembled, random_body, random_chain, scene_of

pytestmark = needs_kernel
IN_Y = "the joints keep every body in the plane normal to [0, 1, 0]"
FREE = "not planar: nothing but symmetry "
#: The formulation, the beginning of the reason, and the degrees of freedom of every mechanism.
EXPECTED = {
    "bennett": ("reduced", "not planar: joint 'B' is tilted", 1),
    "bicycle": ("reduced", f"{FREE}keeps body 'front' in the plane", 3),
    "bouncing_ball": ("reduced", f"{FREE}can keep the bodies in a plane: no joint has an axis", 6),
    "bricard": ("reduced", f"{FREE}keeps body 'bar2' in the plane", 1),
    "bump_stop": ("planar", "the joints keep every body in the plane normal to", 2),
    "cam": ("planar", IN_Y, 0),
    "chaplygin_sleigh": ("planar", "the joints keep every body in the plane normal to [0, 0, 1]", 2),
    "crane": ("reduced", f"{FREE}keeps body 'load' in the plane", 5),
    "delta_robot": ("reduced", "not planar: joint 'A2' is tilted", 3),
    "differential": ("planar", IN_Y, 2),
    "door_closer": ("reduced", "not planar: friction depends on the load of joint 'hinge' out of the plane", 1),
    "door_with_stop": ("planar", "the joints keep every body in the plane normal to [0, 0, 1]", 1),
    "double_pendulum": ("planar", IN_Y, 2),
    "drum_brake": ("planar", "the joints keep every body in the plane normal to [0, 0, 1]", 1),
    "five_bar": ("planar", IN_Y, 5),
    "free_body": ("reduced", f"{FREE}can keep the bodies in a plane: no joint has an axis", 6),
    "geneva": ("planar", IN_Y, 1),
    "governor": ("reduced", f"{FREE}keeps body ", 2),
    "heavy_top": ("reduced", f"{FREE}can keep the bodies in a plane: no joint has an axis", 3),
    "hoist": ("planar", IN_Y, 1),
    "hooke_shaft": ("reduced", f"{FREE}keeps body 'driven' in the plane", 1),
    "inline_four": ("planar", "the joints keep every body in the plane normal to [1, 0, 0]", 0),
    "locomotive": ("planar", IN_Y, 1),
    "massless_coupler": ("planar", IN_Y, 1),
    "n_four_bar": ("planar", IN_Y, 1),
    "newtons_cradle": ("planar", IN_Y, 5),
    "physical_pendulum": ("planar", IN_Y, 1),
    "planar_four_bar": ("planar", IN_Y, 1),
    "quarter_car": ("reduced", "not planar: joint 'lower' is tilted", 2),
    "rocking_cabinet": ("planar", IN_Y, 3),
    "rattleback": ("reduced", "not planar: joint 'rolls' rolls out of the plane", 3),
    "rolling_coin": ("reduced", "not planar: joint 'ground' rolls out of the plane", 3),
    "screw_press": ("reduced", "not planar: joint 'nut' couples coordinates that are not in the plane", 1),
    "spatial_four_bar": ("reduced", f"{FREE}keeps body 'crank' in the plane", 2),
    "spatial_slider_crank": ("reduced", f"{FREE}keeps body 'slider' in the plane", 1),
    "spherical_pendulum": ("reduced", f"{FREE}can keep the bodies in a plane: no joint has an axis", 3),
    "split_coupler": ("planar", IN_Y, 4),
    "steered_car": ("reduced", "not planar: joint 'front_left_rolls' rolls out of the plane", 1),
    "stewart_platform": ("reduced", "not planar: joint 'U1' is tilted", 6),
    "stick_slip": ("planar", IN_Y, 1),
    "valve_train": ("planar", IN_Y, 3),
    "swinging_atwood": ("planar", IN_Y, 3),
    "turntable": ("reduced", "not planar: joint 'rolls' rolls out of the plane", 3),
}
FULL_ONLY = sorted(name for name, entry in PROJECTIONS.items() if not entry.compiled)
OPTIONS = {"alpha": 1e3, "gains": (25.0, 25.0)}


def chosen(scene: Scene, method: str = "gpopm", **keys) -> Choice:
    options = {name: OPTIONS[name] for name in PROJECTIONS[method].options}
    settings = Settings(duration=0.02, step=0.01, projection=ProjectionSettings(method=method, **options), **keys)
    return choose(*assembled(scene), settings)


@pytest.fixture
def five_bar():
    return mechanism("five_bar")


def mechanism(name: str) -> Scene:
    return read_scene(next(path for path in MECHANISMS if path.stem == name))


def test_every_mechanism_is_expected_here():
    assert sorted(EXPECTED) == [path.stem for path in MECHANISMS]


def test_the_kernel_has_each_correction_that_the_registry_names():
    assert {entry.correction for entry in PROJECTIONS.values()} - {""} == set(core().Correction.__members__)


def test_a_new_method_runs_in_the_full_formulation(monkeypatch):
    """It is one class and one entry, which need not say anything of the kernel."""
    methods = dict(PROJECTIONS, mine=ProjectionEntry("Gopm", "1", "a copy of gopm"))
    for place in (module, "mbproj.motion.projection", "mbproj.motion.failures"):
        monkeypatch.setattr(place if place is module else import_module(place), "PROJECTIONS", methods)
    settings = Settings(duration=0.02, step=0.01, projection=ProjectionSettings(method="mine"))
    system, state = assembled(mechanism("physical_pendulum"))
    assert choose(system, state, settings).name == "full"
    assert simulate(system, state, settings).position_violation.value < 1e-12


@pytest.mark.parametrize("name", EXPECTED)
def test_each_mechanism_gets_the_smallest_coordinates_that_its_joints_allow(name):
    choice = chosen(mechanism(name))
    formulation, why, degrees = EXPECTED[name]
    assert (choice.name, choice.degrees_of_freedom) == (formulation, degrees)
    assert choice.why.startswith(why)
    total = choice.elimination["eliminated_bodies"] + choice.elimination["core_bodies"]
    assert total == choice.compiled.system.bodies


@pytest.mark.parametrize("name", EXPECTED)
def test_each_mechanism_runs_in_full_coordinates(name):
    full = chosen(mechanism(name), formulation="full", kinematic=False)
    assert (full.name, full.why, full.degrees_of_freedom) == ("full", "as asked for", EXPECTED[name][2])
    assert (full.redundant > 0) == (name in REDUNDANT)
    assert full.elimination is None


@pytest.mark.parametrize("name", SCENES)
def test_planar_scenes_are_planar_and_reduced_when_asked(name):
    """Reduced where the rows out of the plane are not redundant; else the joint is named."""
    scene = SCENES[name](Drawing(2))
    assert chosen(scene).name == chosen(scene, formulation="planar").name == "planar"
    try:
        reduced = chosen(scene, formulation="reduced")
    except InputError as error:
        assert "is redundant: " in str(error)
    else:
        assert (reduced.name, reduced.why) == ("reduced", "as asked for")
        assert reduced.degrees_of_freedom == chosen(scene).degrees_of_freedom


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_not_planar_says_why(name):
    build, reason = REFUSED[name]
    scene = build(Drawing(1))
    choice = chosen(scene)
    assert choice.name == "reduced"
    assert choice.why.startswith(f"not planar: {reason}")
    with pytest.raises(InputError, match="the scene is not planar: ") as caught:
        chosen(scene, formulation="planar")
    assert reason in str(caught.value)


@pytest.mark.parametrize("method", FULL_ONLY)
def test_methods_that_exist_in_full_only_switch_to_it_and_say_so(five_bar, method):
    why = f"the projection '{method}' exists in the full formulation only"
    choice = chosen(five_bar, method)
    assert (choice.name, choice.why, choice.compiled) == ("full", why, None)
    for formulation in ("reduced", "planar"):
        with pytest.raises(InputError, match=f"the {formulation} formulation is not available here: {why}"):
            chosen(five_bar, method, formulation=formulation)


@pytest.mark.parametrize("method", sorted(set(PROJECTIONS) - set(FULL_ONLY)))
def test_the_kernel_has_the_other_methods(five_bar, method):
    assert chosen(five_bar, method).name == "planar"
    assert chosen(five_bar, method, formulation="reduced").name == "reduced"


def test_eliminated_accelerations_exist_in_full_only(five_bar):
    choice = chosen(five_bar, acceleration="eliminated")
    assert (choice.name, choice.why) == ("full", "'acceleration: eliminated' exists in the full formulation only")
    with pytest.raises(InputError, match="not available here: 'acceleration: eliminated'"):
        chosen(five_bar, acceleration="eliminated", formulation="planar")


def test_without_a_kernel_full_runs_and_says_why(five_bar, monkeypatch):
    monkeypatch.setattr(module, "core", lambda: None)
    monkeypatch.setattr(module, "build_info", lambda: "not built")
    warn_once.cache_clear()
    with pytest.warns(MbprojWarning, match=r"the compiled kernel is missing \(not built\), so that simulations run in"):
        choice = chosen(five_bar)
    assert (choice.name, choice.why) == ("full", "the compiled kernel is missing (not built)")
    assert chosen(five_bar, acceleration="eliminated").why.startswith("'acceleration: eliminated' exists in the full")
    with pytest.raises(InputError, match=r"the reduced formulation is not available here: .* \(not built\)"):
        chosen(five_bar, formulation="reduced")
    report = simulate(*assembled(five_bar), Settings(duration=0.02, step=0.01))
    assert (report.formulation, report.why) == ("full", choice.why)


NEEDS = {
    "five_bar": ({"integrator": "esdirk4"}, "implicit steps need the kernel"),
    "double_pendulum": ({"integrator": "auto", "step": None, "tolerance": 1e-6}, "implicit steps need the kernel"),
    "bouncing_ball": ({}, "stops and dry friction need the kernel"),
    "stick_slip": ({}, "stops and dry friction need the kernel"),
}


@pytest.mark.parametrize("name", NEEDS)
def test_what_needs_the_kernel_is_said_without_one(name, monkeypatch):
    settings, message = NEEDS[name]
    monkeypatch.setattr(module, "core", lambda: None)
    scene = read_scene(ROOT / "mechanisms" / f"{name}.yaml")
    with pytest.raises(InputError, match=message) as error:
        simulate(*assembled(scene), Settings(**{"duration": 0.02, "step": 0.01, **settings}))
    assert error.value.problems[0].hint == "install a C++ compiler, or a wheel"


@pytest.mark.parametrize(
    "change", [{"mass": 0.0}, {"inertia": ((0.0,) * 3,) * 3}, {"inertia": ((1.0, 0, 0), (0, 1.0, 0), (0, 0, 0.0))}]
)
def test_a_body_without_definite_mass_and_inertia_runs_reduced(change):
    """The first body hangs on a revolute joint whose rows the second one's mass does not depend on: Eq. 20 holds."""
    scene = random_chain(12, ["revolute", "revolute"])
    light = dataclasses.replace(scene.bodies[0], **change)
    scene = dataclasses.replace(scene, bodies=(light, scene.bodies[1]))
    assert chosen(scene).name == "reduced"
    with pytest.raises(InputError, match="popm needs a definite mass matrix, and body 'body0'"):
        chosen(scene, "popm")


def test_a_four_bar_of_revolutes_runs_in_the_plane_and_is_redundant_in_space():
    scene = parallelogram()
    assert chosen(scene).name == "planar"
    assert chosen(scene).degrees_of_freedom == 1
    reduced = chosen(scene, formulation="reduced")
    assert (reduced.redundant, reduced.degrees_of_freedom) == (3, 1)
    full = chosen(scene, formulation="full")
    assert (full.redundant, full.degrees_of_freedom) == (3, 1)
    assert simulate(*assembled(scene), Settings(duration=0.1, step=0.01)).position_violation.value <= 1e-13


@pytest.mark.parametrize("regular", [True, False])
def test_a_dead_start_is_refused_with_the_joint(regular):
    with pytest.raises(InputError, match=r"joint '[BCD]' is redundant: "):
        simulate(*at_rest(parallelogram(np.pi / 2, regular=regular)), Settings(duration=0.1, step=0.01))


def test_reports_and_choices_agree():
    """What `simulate` reports is what `choose` says, and the run is in these coordinates: the same freedoms."""
    for name in ("five_bar", "spatial_slider_crank", "free_body"):
        settings = Settings(duration=0.02, step=0.01)
        report = simulate(*assembled(mechanism(name)), settings)
        choice = chosen(mechanism(name))
        assert (report.formulation, report.why) == (choice.name, choice.why)
        assert report.degrees_of_freedom == choice.degrees_of_freedom


def test_bodies_without_joints_are_reduced():
    rng = np.random.default_rng(1)
    choice = chosen(scene_of([random_body(rng, "a"), random_body(rng, "b")], []))
    assert (choice.name, choice.degrees_of_freedom) == ("reduced", 12)
    assert choice.elimination["core_bodies"] == 2


def at_rest(scene: Scene):
    """Assembled without the speed that a dead pose does not allow."""
    still = tuple(dataclasses.replace(joint, speed={}) for joint in scene.joints)
    return assembled(dataclasses.replace(scene, joints=still))
