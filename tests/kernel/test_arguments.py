"""What the kernel is handed is checked where it comes in: an exception with the array's name, and never a crash."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from mbproj.base.thresholds import of_the_kernel
from mbproj.functions.program import CHANNELS, number, variable
from mbproj.kernel import core
from tests.kernel.arguments import block, blocks, functions, model, numbers, primitives, projection, run, state
from tests.kernel.scenes import needs_kernel
from tests.support import ROOT

pytestmark = needs_kernel
NAN, INF = float("nan"), float("inf")


def test_what_is_good_runs():
    assert run().status == core().Status.finished
    acceleration, multipliers = core().SpaceEquations(model(), projection()).accelerations(state())
    assert acceleration.shape == (2, 6)
    assert multipliers.shape == (4,)


WRONG_PRIMITIVES = [
    ({"body": np.array([0, 1, 3, 0])}, "body holds an index out of range"),
    ({"body": np.array([0, 1, -1, 0])}, "body holds an index out of range"),
    ({"is_point": np.array([1, 1])}, "is_point has a wrong shape"),
    ({"local": np.ones((4, 2))}, "local has a wrong shape"),
    ({"local": np.full((4, 3), NAN)}, "local holds a number that is not finite"),
    ({"kind": np.array([0, 99])}, "kind holds an index out of range"),
    ({"slot_count": np.array([2, 99])}, "slot_count holds an index out of range"),
    ({"slot_count": np.array([2, 1])}, "slot_count is not that of its kind"),
    ({"first_slot": np.zeros(3, int)}, "first_slot has a wrong shape"),
    ({"first_slot": np.array([0, 3])}, "first_slot holds an index out of range"),
    ({"first_slot": np.array([-1, 2])}, "first_slot holds an index out of range"),
    ({"parameters": np.zeros((2, 4))}, "parameters has a wrong shape"),
    ({"follows": [{"radii": [0.0, 0.0]}, None]}, "follows is given to a kind that follows none, or is missing"),
    ({"follows": [None]}, "follows has a wrong shape"),
    ({"owner": np.zeros(1, int)}, "owner has a wrong shape"),
    ({"owner": np.array([1, 0])}, "owner does not increase"),
    ({"parameters": numbers([], [0.7])}, "parameters has more than its kind takes"),
    ({"weight": np.full(2, INF)}, "weight holds a number that is not finite"),
    ({"joins": np.array([1, 0])}, "joins couples what is no coordinate"),
    ({"joins": np.array([0, 1])}, "joins couples what is no coordinate"),
    ({"offset": np.array([0.0, NAN])}, "offset holds a number that is not finite"),
]
WRONG_MODELS = [
    ({"mass": np.array([1.0, -1.0])}, "mass or inertia is negative"),
    ({"mass": np.array([1.0, NAN])}, "mass holds a number that is not finite"),
    ({"mass": np.ones(3)}, "inertia has a wrong shape"),
    ({"inertia": np.full((2, 3, 3), INF)}, "inertia holds a number that is not finite"),
    ({"gravity": np.zeros(2)}, "gravity has a wrong shape"),
    ({"gravity": np.full(3, NAN)}, "gravity holds a number that is not finite"),
    ({"row_scale": np.ones(3)}, "row_scale has a wrong shape"),
    ({"row_scale": np.full(4, NAN)}, "row_scale holds a number that is not finite"),
    ({"length": NAN}, "length"),
    ({"length": 0.0}, "length"),
    ({"row_scale": np.zeros(4)}, "row_scale"),
    ({"layout": blocks(states=1)}, "layout has a block of a wrong size"),
    ({"layout": blocks(quadratures=2)}, "layout has a block of a wrong size"),
    ({"layout": blocks(followed=1)}, "layout has a block of a wrong size"),
    ({"layout": blocks()[1:]}, "layout has a block of a wrong size"),
    ({"layout": [*blocks(), block("feet", [1.0])]}, "layout has a block that is not known"),
    ({"layout": [*blocks(), blocks()[0]]}, "layout has a block that is not known"),
    ({"layout": [block("states", [1.0]), *blocks()[:1], *blocks()[2:]]}, "layout does not begin with the bodies"),
    ({"layout": [block("bodies", [NAN] * 26), *blocks()[1:]]}, "layout.scale holds a number that is not finite"),
    ({"layout": [block("bodies", [0.0] * 26), *blocks()[1:]]}, "layout.scale is not positive"),
    ({"layout": [block("bodies", [1.0] * 26, [0.0] * 25), *blocks()[1:]]}, "layout.start has a wrong shape"),
]
#: What functions ask for that is not there.
WRONG_FUNCTIONS = [
    ([number(1.0)], {}, "layout has a block of a wrong size"),
    ([], {"first_rate": 1}, "first_rate holds an index out of range"),
    ([variable(CHANNELS)], {"first_rate": 1}, "programs have variables that are not there"),
    ([], {"channels": {"kind": [0], "index": [0]}}, "channels.index holds an index out of range"),
    ([], {"channels": {"kind": [3], "index": [0]}}, "channels.kind holds an index out of range"),
    ([], {"switches": np.array([[0, 0]])}, "switches holds an index out of range"),
]
WRONG_STATES = [
    ({"y": state()[:1].ravel()}, "y has a wrong shape"),
    ({"y": np.append(state(), 0.0)}, "y has a wrong shape"),
    ({"y": np.full(26, NAN)}, "y holds a number that is not finite"),
    ({"turns": np.zeros(1, int)}, "turns has a wrong shape"),
]
WRONG_TYPES = [
    (model, {"constraints": primitives(body=np.array(["a"] * 4))}),
    (model, {"constraints": primitives(body=np.zeros(4))}),
    (model, {"constraints": primitives(local=1j * np.ones((4, 3)))}),
    (model, {"constraints": primitives(local=np.ones(12))}),
    (model, {"constraints": primitives(body=None)}),
    (model, {"constraints": primitives(follows=None)}),
    (model, {"thresholds": None}),
    (model, {"mass": "12"}),
    (model, {"mass": b"12"}),
    (model, {"length": "1"}),
    (run, {"y": [1.0]}),
    (run, {"model": "model"}),
]
#: In a process of their own each, for these have crashed: what they ask for, and the name in the message.
CRASHES = {
    "model(constraints=primitives(first_slot=np.array([0, 10**9])))": "first_slot",
    "model(constraints=primitives(owner=np.array([0, -5])))": "owner",
    "model(constraints=primitives(body=np.array([0, 999_999, 1, 0])))": "body",
    "run(projection=projection(every=0))": "every",
    "run(steps=core().Steps.by_error(0.0, 1.0, 1e-6, (0.0, 1.0, 0, 2)))": "error",
    "run(tableau=tableau(b=np.zeros(0)))": "b has a wrong shape",
    "run(tableau=tableau(b=np.ones(400)))": "a has a wrong shape",
}


@pytest.mark.parametrize(("changes", "message"), WRONG_PRIMITIVES)
def test_primitives_are_checked(changes, message):
    with pytest.raises(ValueError, match=f"^constraints.{message}"):
        model(constraints=primitives(**changes))


@pytest.mark.parametrize(("changes", "message"), WRONG_MODELS)
def test_models_are_checked(changes, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        model(**changes)


@pytest.mark.parametrize(("codes", "changes", "message"), WRONG_FUNCTIONS)
def test_functions_are_checked(codes, changes, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        model(programs=functions(*codes, variables=CHANNELS + len(codes)), **changes)


@pytest.mark.parametrize(("changes", "message"), WRONG_STATES)
def test_states_are_checked(changes, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        run(**changes)


@pytest.mark.parametrize(("build", "changes"), WRONG_TYPES)
def test_other_types_than_arrays_of_numbers_are_refused(build, changes):
    with pytest.raises(TypeError, match=r"incompatible function arguments|has a wrong type|is none"):
        build(**changes)


def test_fields_that_are_missing_or_unknown_are_refused():
    with pytest.raises(ValueError, match=r"^wheels is not known to the kernel"):
        model(wheels=4)
    with pytest.raises(ValueError, match=r"^mass is missing"):
        core().SpaceModel(thresholds=core().Thresholds(**of_the_kernel()))


@pytest.mark.parametrize("step", [0.0, -0.1, NAN])
def test_steps_are_checked(step):
    with pytest.raises(ValueError, match="step is not positive"):
        core().Steps.fixed(0.0, 1.0, step, 10, 1)
    with pytest.raises(ValueError, match="tolerance is not positive"):
        core().Steps.by_error(0.0, 1.0, step, (0.0, 1.0, 0, 2))


#: Origin, interval, offset and number of samples that do not increase from 0 to 1.
SAMPLES = [(0.0, 0.5, 0, 1), (0.0, 0.0, 0, 3), (0.0, 0.6, 0, 4), (0.0, NAN, 0, 3), (0.0, 0.1, -1, 3)]


@pytest.mark.parametrize("samples", SAMPLES)
def test_times_of_samples_are_checked(samples):
    with pytest.raises(ValueError, match="samples do not increase"):
        core().Steps.by_error(0.0, 1.0, 1e-6, samples)


@pytest.mark.parametrize("code", CRASHES)
def test_what_would_read_beyond_an_array_is_refused(code):
    program = f"import numpy as np; from tests.kernel.arguments import *; {code}"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=ROOT, check=False)
    assert done.returncode == 1, f"{done.returncode}: {done.stdout}{done.stderr}"
    last = done.stderr.strip().splitlines()[-1]
    assert last.startswith("ValueError: ")
    assert CRASHES[code] in last
