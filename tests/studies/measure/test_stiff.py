"""Studies of stiff mechanisms: references by two implicit methods, and implicit methods among what is tried."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.base.errors import InputError
from mbproj.scene.scene import read_scene_text
from mbproj.studies.compare import compare
from mbproj.studies.measure import reference as references
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import Mechanism
from mbproj.studies.recommend import families, recommend
from mbproj.studies.stability import stability
from mbproj.studies.variants import with_damping
from mbproj.studies.verify.checks import verify
from tests.integrate.stiff_scenes import CREEP
from tests.studies.scenes import OSCILLATOR, PENDULUM

DAMPED = OSCILLATOR.replace("stiffness: 1}", "stiffness: 1, damping: 1}")


@pytest.fixture
def stiff(tmp_path, monkeypatch):
    """A mass that creeps behind 0.1 sin(t) by 2e-4 s; explicit methods need some 800 steps."""
    monkeypatch.setenv("MBPROJ_CACHE", str(tmp_path))
    return read_scene_text(CREEP)


def test_the_reference_is_by_two_implicit_methods_that_differ(stiff, monkeypatch):
    monkeypatch.setattr(references, "STIFF", 100)
    found = references.reference(Mechanism.of(stiff), np.linspace(0.0, 0.5, 6), seconds=1.0)
    assert found.method.startswith("esdirk4, tolerance 1e-")
    assert found.check.startswith("radau5, tolerance 1e-")
    off = abs(found.position[-1, 0, 0] - 0.1 * np.sin(0.5 - 2e-4))
    assert off < 3e-9 + found.uncertainty[-1].max()
    assert found.uncertainty[-1].max() < 1e-5


@pytest.mark.full
def test_an_implicit_method_is_recommended_where_stability_holds_explicit_ones_up(stiff):
    found = recommend(stiff, 1e-4, timed=False)
    assert found.setting.integrator in ("esdirk4", "radau5")
    assert found.best.at() <= 1e-4
    assert found.best.evaluations < 250  # an explicit method takes 9,600; 131 of esdirk4 lose 0.3 % of the energy
    assert found.best.doubt <= 1.0


def test_implicit_families_are_tried_only_where_forces_are_stiff():
    usual, more = (list(families(Setting(), 0.1, stiff=stiff)) for stiff in (False, True))
    assert {"esdirk4", "auto"} <= {family.integrator for family in more[len(usual) :]}
    assert more[: len(usual)] == usual
    assert not {"esdirk4", "auto"} & {family.integrator for family in usual}


@pytest.mark.full
def test_the_implicit_limit_stands_beside_the_explicit_one():
    """RK4 and ESDIRK4 lose a tenth of the energy of a vibration at different stiffness: neither follows what its steps
    do not resolve."""
    explicit, implicit = stability(
        read_scene_text(OSCILLATOR), "stiffness", projections=["gpopm"], low=1, high=1e3, points=3, processes=1
    ).tracks
    assert (explicit.method, implicit.method) == ("gpopm", "gpopm, esdirk4")
    assert explicit.changes[-1].value == pytest.approx(20.1, rel=0.01)
    assert implicit.changes[-1].value > 5.0 * explicit.changes[-1].value


def test_every_damping_is_scaled():
    scene = with_damping(read_scene_text(DAMPED), 10.0)
    (law,) = scene.forces[0].laws.values() if hasattr(scene.forces[0], "laws") else [scene.forces[0].law]
    assert (law.stiffness, law.damping) == (1.0, 10.0)
    with pytest.raises(InputError) as caught:
        with_damping(read_scene_text(OSCILLATOR), 2.0)
    assert caught.value.problems[0].message == "no force of the scene has a 'damping' to vary"


def test_auto_is_compared_at_tolerances_alone(stiff):
    found = compare(stiff, projections=["gpopm"], integrators=["auto"], tolerances=[1e-4], until=0.2, repetitions=1)
    (entry,) = found.entries
    assert entry.solution.failure is None
    assert entry.split is None
    with pytest.raises(InputError) as caught:
        compare(stiff, projections=["gpopm"], integrators=["auto"], steps=[0.1])
    assert caught.value.problems[0].message == "'auto' chooses its steps by their error: it takes no 'step'"


def test_verify_takes_the_explicit_method_of_auto_with_fixed_steps():
    """The order is that of DOP853."""
    text = PENDULUM.replace("step: 0.01", "tolerance: 1.0e-6, integrator: auto")
    spring = "forces:\n  coil: {type: torsion_spring_damper, joint: pin, stiffness: 10, damping: 0.1}\n"
    found = verify(read_scene_text(text + spring))
    assert not found.of("failed")
    (order,) = (check for check in found.checks if check.name == "order")
    assert order.remark.startswith("dop853 has order 8")
