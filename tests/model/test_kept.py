"""What a system keeps: results for the last state asked for, which have the bits of a system that keeps nothing."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

from mbproj import assemble, compile_system, initial_guess
from mbproj.base.settings import ProjectionSettings
from mbproj.equations.assembly.assemble import State
from mbproj.model.system import System
from mbproj.motion.formulations import choice as module
from mbproj.motion.formulations.choice import choose
from mbproj.motion.simulate import simulate
from mbproj.scene.scene import read_scene
from tests.kernel.scenes import needs_kernel
from tests.support import ROOT, Recorder

RUN = {"integrator": "dop853", "tolerance": 1e-7, "step": None, "duration": 0.05, "output_step": 0.01}


@pytest.fixture
def five_bar() -> tuple[System, State]:
    return assembled("five_bar")


def assembled(name: str) -> tuple[System, State]:
    scene = read_scene(ROOT / "mechanisms" / f"{name}.yaml")
    system = compile_system(scene)
    return system, assemble(system, initial_guess(scene, system))


def test_a_result_is_kept_until_another_is_asked_for(five_bar):
    """An array that was changed in place is another one."""
    system, _ = five_bar
    calls, at = [], np.array([1.0, 2.0])

    def ask(*given: object) -> int:
        return system.kept("sum", given, lambda: calls.append(given) or len(calls))

    assert [ask(at, "a"), ask(at.copy(), "a"), ask(at, "b"), ask(at, "a")] == [1, 1, 2, 3]
    at[0] = np.nextafter(1.0, 2.0)
    assert ask(at, "a") == 4
    assert pickle.loads(pickle.dumps(system)).kept("sum", (at, "a"), lambda: "anew") == "anew"
    assert replace(system).kept("sum", (at, "a"), lambda: "anew") == "anew"


@needs_kernel
@pytest.mark.parametrize("name", ["five_bar", "bennett", "locomotive", "spatial_slider_crank"])
def test_a_second_run_chooses_by_what_the_first_has_found(name, monkeypatch):
    """It looks for no plane and no rows, and has the bits of a first run. The locomotive and the Bennett linkage have
    redundant rows."""
    system, state = assembled(name)
    settings = replace(read_scene(ROOT / "mechanisms" / f"{name}.yaml").settings, **RUN)

    def recorded(system: System) -> bytes:
        recorder = Recorder()
        simulate(system, state, settings, recorder)
        paths = ("bodies/velocity", "joints/reaction_force", "diagnostics/energy_balance")
        return b"".join(recorder[path].tobytes() for path in paths)

    first = recorded(system)
    looked = []
    for function in ("planar_reduction", "settle_rows"):
        own = getattr(module, function)
        monkeypatch.setattr(module, function, lambda *given, own=own: looked.append(given) or own(*given))
    assert recorded(system) == first
    assert not looked
    assert recorded(replace(system)) == first
    assert looked


@needs_kernel
def test_another_pose_or_projection_is_looked_at_anew(five_bar):
    system, state = five_bar
    settings = replace(read_scene(ROOT / "mechanisms" / "five_bar.yaml").settings, **RUN)
    first = choose(system, state, settings)
    beside = state.changed(positions=np.nextafter(state.q, 9.0))
    assert choose(system, beside, settings).compiled.plane is not first.compiled.plane
    other = replace(settings, projection=ProjectionSettings("gopm"))
    assert choose(system, state, other).compiled.settled == other.projection
    assert choose(system, state, settings).compiled.settled == settings.projection
