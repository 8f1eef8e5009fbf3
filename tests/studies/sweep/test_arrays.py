"""Cases by arrays: the bits that each case has alone, whatever varies."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest

from mbproj.base.arrays import cross, numbers
from mbproj.base.cases import per_case
from mbproj.base.mechanisms_folder import mechanism
from mbproj.model.euler_parameters import matrix_L, product, rotation_matrix
from mbproj.studies.case_arrays import CaseArray, CaseObjects, CasesDiffer, KernelOfCases, OneCaseOnly, case_of, stacked
from mbproj.studies.case_blocks import FEWEST, CaseBlock, as_one, common_values, values_of
from mbproj.studies.sweep.run import CaseTask, CaseWork, run_case, run_cases
from mbproj.studies.sweep.spec import read_spec
from mbproj.studies.sweep.store import Status
from tests.studies.sweep.specs import SCENE, swept, write

pytestmark = pytest.mark.usefixtures("sweeps_here")


# Cases by arrays: the bits that each case has alone, whatever varies; what arrays do not know goes alone.

COUNT = FEWEST + 1
END = "  simulation.duration: 0.2 s\n"
ADAPTIVE = f"{END}  simulation.tolerance: 1e-7\n  simulation.integrator: dop853\n"
#: What varies in a scene, and what is measured.
SWEEPS = {
    "five_bar": (
        f"  parameters.length: 0.9:1.1:{COUNT}\n{ADAPTIVE}",
        "  tip: {marker: tip, quantity: position, component: z, at: end}\n"
        "  lowest: {marker: tip, quantity: position, component: z, at: minimum}\n"
        "  load: {joint: A, quantity: reaction_force, component: norm, at: maximum}\n"
        "  angle: {joint: C, quantity: angle, at: 0.1}\n"
        "  drift: {diagnostic: energy_drift_relative, at: end}\n",
    ),
    "planar_four_bar": (
        f"  gravity.2: -12:-9:{COUNT}\n{ADAPTIVE}",
        "  drift: {diagnostic: energy_drift, at: end}\n  open: {diagnostic: position_violation, at: end}\n",
    ),
    "spatial_slider_crank": (
        f"  bodies.slider.mass: 1.5:2.5:{COUNT}\n  speed: 5:7:{COUNT}\n{END}",
        "  slider: {marker: slider, quantity: position, component: x, at: end}\n"
        "  force: {joint: D, quantity: reaction_force, component: z, at: largest}\n"
        "  open: {diagnostic: velocity_violation, at: end}\n",
    ),
    "quarter_car": (
        f"  bodies.body.mass: 250:300:{COUNT}\n{END}",
        "  drift: {diagnostic: energy_drift, at: end}\n",
    ),
    "governor": (
        f"  speed: 18:22:{COUNT}\n{ADAPTIVE}",
        "  spin: {joint: spin, quantity: angle_speed, at: end}\n  drift: {diagnostic: energy_drift, at: largest}\n",
    ),
    "inline_four": (
        f"  piston_mass: 0.4:0.6:{COUNT}\n  simulation.duration: 20 ms\n",
        "  turned: {joint: main, quantity: angle, at: end}\n  torque: {motion: drive, quantity: force, at: maximum}\n",
    ),
    "differential": (
        f"  drive: 300:500:{COUNT}\n{ADAPTIVE}",
        "  spins: {joint: ice_wheel, quantity: angle_speed, at: end}\n"
        "  shares: {joint: gears, quantity: reaction_torque, component: y, at: end}\n",
    ),
    "heavy_top": (
        f"  nutation: 0.4:0.6:{COUNT}\n{END}",
        "  energy: {diagnostic: kinetic_energy, at: end}\n",
    ),
}


def by_arrays_and_alone(path):
    spec = read_spec(path)
    work = CaseWork(spec.scene, spec.design.paths, spec.measures, None, "none", None)
    tasks = [CaseTask(str(number), spec.design.case(number)) for number in range(spec.design.count)]
    return run_cases(work, tasks), [run_case(work, task) for task in tasks]


@pytest.mark.parametrize("name", SWEEPS)
def test_a_case_has_the_bits_that_it_has_alone(tmp_path, name):
    vary, measure = SWEEPS[name]
    path = tmp_path / "spec.yaml"
    path.write_text(
        f"sweep: 1\nscene: {mechanism(name)}\ncombine: zip\nvary:\n{vary}measure:\n{measure}", encoding="utf-8"
    )
    rows, alone = by_arrays_and_alone(path)
    assert all(row.by_arrays for row in rows)
    for row, own in zip(rows, alone, strict=True):
        assert own.status == row.status == Status.DONE and row.formulation == own.formulation
        assert np.array(row.values).tobytes() == np.array(own.values).tobytes()
    assert len({row.values for row in rows}) == COUNT


@pytest.mark.full
def test_what_fails_or_goes_another_way_goes_alone(tmp_path):
    """Half of the cases fail at 0.1 s; some have other settings; each has the row that it has alone."""
    path = write(tmp_path, f"  length: 0.8:1.2:{COUNT}\n  fails: [0, 1]\n  simulation.step: [0.01, 0.02]\n")
    rows, alone = by_arrays_and_alone(path)
    assert sum(row.by_arrays for row in rows) == 2 * COUNT
    for row, own in zip(rows, alone, strict=True):
        assert (row.status, row.values, row.message, row.time) == (own.status, own.values, own.message, own.time)
    assert {row.status for row in rows if not row.by_arrays} == {Status.FAILED}


def test_groups_go_by_what_is_decided(tmp_path):
    """A mass of zero is a light body, which is eliminated in another way."""
    masses = ", ".join(f"{mass}" for each in range(FEWEST) for mass in (0.0, 1.0 + each / 8.0))
    path = write(tmp_path, f"  bodies.bar.mass: [{masses}]\n")
    rows, alone = by_arrays_and_alone(path)
    assert all(row.by_arrays for row in rows)
    assert [row.values for row in rows] == [own.values for own in alone]


def test_zeros_of_both_signs_are_two_cases(tmp_path):
    """atan2(0, -1) is π, atan2(-0, -1) is -π: here the length is 1.03 m, or 0.97 m."""
    text = SCENE.replace("length: 1 m, fails: 0", "x: 0, length: '1 m + 0.03 m * atan2(x, -1) / pi', fails: 0")
    path = write(tmp_path, f"  parameters.x: [0.0, -0.0]\n  bodies.bar.mass: 1:2:{COUNT}\n", scene=text)
    rows, alone = by_arrays_and_alone(path)
    assert all(row.by_arrays for row in rows)
    assert [row.values for row in rows] == [own.values for own in alone]
    assert len({row.values for row in rows}) == 2 * COUNT


def test_settings_that_are_zeros_of_both_signs_are_apart():
    assert len({common_values(("simulation.a", "b"), (zero, 1.0)) for zero in (0.0, -0.0)}) == 2
    assert len({common_values(("a", "b"), (zero, 1.0)) for zero in (0.0, -0.0)}) == 1


@dataclass(frozen=True)
class Quantity:
    number: float


def test_records_that_differ_in_the_sign_of_a_zero_differ():
    for values in ((0.0, -0.0), (-0.0, 0.0, 0.0)):
        made = as_one([Quantity(each) for each in values])
        assert made.number.values.tobytes() == np.array(values).tobytes()
        (column,) = values_of([(each,) for each in values])
        assert column.values.tobytes() == np.array(values).tobytes()


def test_the_sweep_says_how_many(tmp_path):
    reached, entries = swept(write(tmp_path, "  length: 0.8:1.2:60\n"), tmp_path / "out")
    assert reached.computed == 60 and reached.by_arrays >= 20
    assert all(entry.status == "done" for entry in entries)
    _, again = swept(write(tmp_path, "  length: 0.8:1.2:60\n"), tmp_path / "alone", most_failures=0)
    assert [entry.row.values for entry in entries] == [entry.row.values for entry in again]


def test_other_bits_are_found_and_not_used(tmp_path, monkeypatch):
    """The first case of each group is run alone, too."""

    monkeypatch.setattr(CaseBlock, "measures", lambda block, measures, timeout: [(0.5,)] * block.count)
    with pytest.warns(UserWarning, match="arrays have other bits"):
        rows, alone = by_arrays_and_alone(write(tmp_path, f"  length: 0.8:1.2:{COUNT}\n"))
    assert not any(row.by_arrays for row in rows)
    assert [row.values for row in rows] == [own.values for own in alone]


def test_an_error_that_nobody_expects_is_seen(tmp_path, monkeypatch):
    """The warning has its type, message and place; the cases run alone."""

    def missing(block, measures, timeout):
        return [block.mechanism.no_such_part for _ in measures]

    monkeypatch.setattr(CaseBlock, "measures", missing)
    with pytest.warns(UserWarning, match=r"fault of mbproj: AttributeError: .*no_such_part.*test_arrays\.py:\d+"):
        rows, alone = by_arrays_and_alone(write(tmp_path, f"  length: 0.8:1.2:{COUNT}\n"))
    assert not any(row.by_arrays for row in rows)
    assert [row.values for row in rows] == [own.values for own in alone]


#: What is wrong where a is 2 and b is 2, or where a is 1 and b is 2; and the number of cases that fail then.
WRONG = {
    "a negative mass": ("mass: 1,", "mass: a - b,", 1),
    "no axis": ("axis: [0, 1, 0]", "axis: [0, a - b, 0]", 1),
    "a tilted axis, or none": ("axis: [0, 1, 0]", "axis: [a - b, 0, 0]", 1),
    "a root of a negative number": ("mass: 1,", "mass: 1 + sqrt(a - b),", 1),
    "a division by zero": ("mass: 1,", "mass: 5 + 1 / (a - b),", 1),
}


@pytest.mark.parametrize("name", WRONG)
def test_errors_of_the_input_are_reported_without_a_warning(tmp_path, recwarn, name):
    """The case with the error fails alone, in words; the others have the rows that they have alone."""
    old, new, failed = WRONG[name]
    text = SCENE.replace(old, new).replace("fails: 0", "fails: 0, a: 5, b: 0.25")
    rows, alone = by_arrays_and_alone(
        write(tmp_path, "  parameters.a: [3, 2, 1]\n  parameters.b: [0.5, 2, 0.55, 0.6, 0.65, 0.7]\n", scene=text)
    )
    assert [(row.status, row.values, row.message) for row in rows] == [
        (own.status, own.values, own.message) for own in alone
    ]
    assert [row.status for row in rows].count(Status.FAILED) == failed
    assert sum(row.by_arrays for row in rows) >= len(rows) - 2 * FEWEST
    assert not recwarn.list


def test_contacts_go_alone(tmp_path):
    path = tmp_path / "spec.yaml"
    path.write_text(
        f"sweep: 1\nscene: {mechanism('stick_slip')}\nvary:\n  gravity.2: -10:-9:{COUNT}\n{END}"
        "measure:\n  drift: {diagnostic: energy_drift, at: end}\n",
        encoding="utf-8",
    )
    rows, alone = by_arrays_and_alone(path)
    assert not any(row.by_arrays for row in rows)
    assert [row.values for row in rows] == [own.values for own in alone]


# Arrays of cases: what is computed for many cases at once has the bits that each case has alone.

WIDTH = 5
RNG = np.random.default_rng(3)


def cases(*shape):
    return CaseArray(RNG.normal(size=(WIDTH, *shape)))


#: Functions of an array (4, 4).
FUNCTIONS = {
    "arithmetic": lambda x: (2.0 * x - x[0]) / (1.0 + x * x) + -abs(x),
    "functions": lambda x: np.sqrt(np.abs(x)) * np.sin(x) + np.arctan2(x, x.T) + np.exp(x) ** 1.5,
    "squares": lambda x: x**2,
    "short sums": lambda x: x.sum(axis=1) + np.sum(x, axis=0) + x.sum(axis=-1, keepdims=True),
    "long sums": lambda x: x.sum() + np.sum(np.tile(x, (3, 3)), axis=1),
    "products": lambda x: (x @ x[0]) * (x[:3].T @ x[1:]).sum(axis=0)[2] + x[0] @ x[1] + x[:, 0] @ x.T,
    "stacks of matrices": lambda x: matrix_L(x) @ np.swapaxes(matrix_L(x), -1, -2),
    "rotations": lambda x: rotation_matrix(x) @ cross(x[:, 1:], x[:, :3])[..., None],
    "Euler parameters": lambda x: product(x, x[::-1]),
    "linear algebra": lambda x: np.linalg.solve(x, x[0]) + np.linalg.lstsq(x, x[1], rcond=None)[0],
    "decompositions": lambda x: np.linalg.pinv(x[:3], rcond=1e-12).T @ np.linalg.eigvalsh(x @ x.T),
    "places": lambda x: np.sort(x, axis=0)[np.argmin(x * 0.0 + np.eye(4)[2], axis=1), np.argmax(np.eye(4) + 0.0 * x)],
    "repetitions": lambda x: np.tile(x[0], 3) if not np.iscomplexobj(x) else None,
    "contractions": lambda x: np.einsum("ij,jk,i->k", x, x, x[0]),
    "norms": lambda x: np.linalg.norm(x, axis=1) + np.linalg.norm(x),
    "indices": lambda x: x[[2, 0]][:, [True, False, True, True]][..., None, 1:] + x[[0, 1], [2, 3]].sum(),
    "columns": lambda x: np.column_stack([x[0], x[1]]) @ np.hstack([x[0], x[1]]).reshape(2, -1),
    "choices": lambda x: np.where([True, False, False, True], x, 0.0) + np.concatenate([x[:2], x[2:]], axis=0),
    "extremes": lambda x: np.maximum(x, 0.1).max(axis=0) - x.min() + np.abs(x).max(axis=-1, initial=0.0),
}


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("laid", [lambda x: x, lambda x: x.T], ids=["rows", "columns"])
def test_each_case_has_the_bits_that_it_has_alone(name, laid):
    function, x = FUNCTIONS[name], cases(4, 4)
    found = function(laid(x))
    for at in range(WIDTH):
        assert case_of(found, at).tobytes() == np.asarray(function(laid(x.values[at].copy()))).tobytes()


def test_what_is_written_stays_in_its_case():
    x, y = cases(3, 2), cases(2)
    expected = x.values.copy()
    x[1] = y
    x[:, 0] *= 2.0
    x[[0, 2], 1] = -y
    for at, each in enumerate(expected):
        each[1] = y.values[at]
        each[:, 0] *= 2.0
        each[[0, 2], 1] = -y.values[at]
    assert np.array_equal(x.values, expected)
    total = np.zeros(3, like=x)
    np.add.at(total, [0, 0, 2], x[:, 0])
    assert np.array_equal(total.values[:, 0], x.values[:, 0, 0] + x.values[:, 1, 0])
    np.add.at(total, np.array([1, 0, 1]), x[:, 0])
    assert np.array_equal(total.values[:, 1], x.values[:, 0, 0] + x.values[:, 2, 0])


@pytest.mark.parametrize(
    "write",
    [
        lambda array, x: array.__setitem__(slice(None), x),
        lambda array, x: np.add(array, x, out=array),
        lambda array, x: np.add.at(array, [0], x),
        lambda array, x: np.copyto(array, x),
        lambda array, x: array.__iadd__(x),
    ],
    ids=["item", "out", "at", "copyto", "in place"],
)
def test_several_cases_never_go_into_the_array_of_one(write):
    with pytest.raises(OneCaseOnly):
        write(np.zeros(1), cases(1))


def test_numbers_in_lists_become_arrays_of_cases():
    x = cases()
    found = numbers([[x, 1.0], (2.0, 3.0)])
    assert np.array_equal(found.values[:, 0, 0], x.values)
    assert np.array_equal(case_of(found, 2), [[x.values[2], 1.0], [2.0, 3.0]])
    with pytest.raises(OneCaseOnly):
        float(x)


def test_decisions_divide_the_cases():
    x = CaseArray(np.array([1.0, -2.0, 3.0, -0.5]))
    assert (np.abs(x) > 0.1) and not x * x < 0.0
    with pytest.raises(CasesDiffer) as differ:
        bool(x > 0.0)
    first, second, third, fourth = differ.value.keys
    assert first == third != second == fourth
    with pytest.raises(CasesDiffer):
        stacked([np.zeros(2), np.zeros(3)])
    with pytest.raises(CasesDiffer):
        stacked(["one", "other"])


def test_whole_numbers_are_decided_as_those_of_one_case():
    assert CaseArray(np.array([3.0, 4.0])).is_integer() and not CaseArray(np.array([0.5, 1.25])).is_integer()
    with pytest.raises(CasesDiffer):
        CaseArray(np.array([3.0, 4.5])).is_integer()
    with pytest.raises(CasesDiffer):
        stacked([None, (1.0, 2.0)])


def test_an_error_of_some_cases_divides_them_and_one_of_all_is_raised():
    def root(x):
        return math.sqrt(x)

    with pytest.raises(CasesDiffer) as differ:
        per_case(root)(CaseArray(np.array([1.0, -2.0, 3.0, -0.5])))
    assert differ.value.keys == (False, True, False, True)
    with pytest.raises(ValueError, match=r"math domain|nonnegative"):
        per_case(root)(CaseArray(np.array([-1.0, -2.0])))


def test_zeros_with_signs_are_not_alike():
    with pytest.raises(CasesDiffer):
        CaseArray(np.array([0.0, -0.0])).tobytes()


def test_each_case_has_an_object():
    class Scale:
        def __init__(self, factor):
            self.factor, self.name = factor, "scale"

        def times(self, x):
            return None if x is None else self.factor * x

    factor, x = cases(), cases(2)
    each = KernelOfCases(Scale, WIDTH)(factor)
    assert isinstance(each, CaseObjects) and each.name == "scale" and each.times(None) is None
    assert np.array_equal(each.times(x).values, factor.values[:, None] * x.values)
    each.factor = 2.0
    assert each.factor == 2.0
    assert np.array_equal(per_case(lambda a, b: a[0] * b)(x, 3.0).values, 3.0 * x.values[:, 0])


def test_each_case_has_a_model_of_its_own_also_where_the_numbers_are_equal():
    class Model:
        rows = 0

    models = KernelOfCases(Model, WIDTH)()
    models.rows = CaseArray(np.arange(float(WIDTH)))
    assert [each.rows for each in models.items] == [0.0, 1.0, 2.0, 3.0, 4.0]
