"""Arrays of cases: what is computed for many cases at once has the bits that each case has alone."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mbproj.base.arrays import cross, numbers
from mbproj.base.cases import per_case
from mbproj.model.euler_parameters import matrix_L, product, rotation_matrix
from mbproj.studies.case_arrays import CaseArray, CaseObjects, CasesDiffer, KernelOfCases, OneCaseOnly, case_of, stacked

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
