"""Bodies given by shapes, their rotations and inertias, and how they look."""

from __future__ import annotations

import math
from itertools import permutations, product
from typing import Any

import numpy as np
import pytest

from mbproj.scene.blocks.solids import SHAPES
from mbproj.scene.fields.quantities import inertia_of
from mbproj.scene.fields.reading import Unfit
from mbproj.scene.fields.rotations import (
    SEQUENCES,
    determinant,
    from_axis_angle,
    from_elements,
    from_euler,
    from_matrix,
    from_principal,
    multiply,
    orthonormality_error,
    principal_moments,
    unit,
)
from mbproj.scene.records import COLOURS, Appearance, Body, Matrix, PlacedShape, Quaternion
from mbproj.scene.scene import read_scene_text
from tests.scene.scenes import read_with

# Bodies given by shapes: closed formulas, quadrature over the volume, and what must not matter.

PI = math.pi


def body(written: str) -> Body:
    """The rod of the good scene, with `written` in place of its mass, inertia and position."""
    return read_with("mass: 0.5, inertia: [4e-3, 4e-4, 4e-3], position: [0.1, 0.05, 0.1]", written).bodies[1]


def tensor(found: Body) -> np.ndarray:
    return np.array(found.inertia)


def close(found: Body, other: Body, position: bool = False) -> None:
    """Two bodies of the same mass and inertia, and in the same place if asked for."""
    assert found.mass == pytest.approx(other.mass, rel=1e-14)
    np.testing.assert_allclose(tensor(found), tensor(other), rtol=0, atol=1e-14 * tensor(other).max())
    if position:
        np.testing.assert_allclose(found.position, other.position, rtol=0, atol=1e-15)


#: Each shape as written -> volume, and principal moments about the centre for a mass of 1, from the tables.
FORMULAS: dict[str, tuple[float | None, tuple[float, float, float]]] = {
    "box: [0.2, 0.3, 0.5]": (0.03, ((0.09 + 0.25) / 12, (0.04 + 0.25) / 12, (0.04 + 0.09) / 12)),
    "cylinder: {radius: 0.2, length: 0.6}": (PI * 0.024, ((3 * 0.04 + 0.36) / 12, (3 * 0.04 + 0.36) / 12, 0.04 / 2)),
    "cylinder: {radius: 0.2, length: 0.6, axis: x}": (
        PI * 0.024,
        (0.04 / 2, (3 * 0.04 + 0.36) / 12, (3 * 0.04 + 0.36) / 12),
    ),
    "cylinder: {radius: 0.2, length: 0.6, axis: y}": (
        PI * 0.024,
        ((3 * 0.04 + 0.36) / 12, 0.04 / 2, (3 * 0.04 + 0.36) / 12),
    ),
    "tube: {outer_radius: 0.2, inner_radius: 0.1, length: 0.6, axis: z}": (
        PI * 0.018,
        ((3 * 0.05 + 0.36) / 12, (3 * 0.05 + 0.36) / 12, 0.05 / 2),
    ),
    "sphere: 20 cm": (PI * 0.032 / 3, (0.4 * 0.04,) * 3),
    "hollow_sphere: {outer_radius: 0.2, inner_radius: 0.1}": (
        PI * 0.028 / 3,
        (0.4 * (0.2**5 - 0.1**5) / (0.2**3 - 0.1**3),) * 3,
    ),
    "rod: {length: 0.6}": (None, (0.03, 0.03, 0.0)),
    "rod: {length: 0.6, axis: x}": (None, (0.0, 0.03, 0.03)),
    "point: {}": (None, (0.0, 0.0, 0.0)),
}
SOLID = {written: volume for written, (volume, _) in FORMULAS.items() if volume is not None}


def test_every_shape_is_tested() -> None:
    assert {written.split(":")[0] for written in FORMULAS} == set(SHAPES)


@pytest.mark.parametrize("written", FORMULAS)
def test_principal_moments(written: str) -> None:
    found = body(f"mass: 3, shape: {{{written}}}, position: [1, 2, 3]")
    assert (found.mass, found.position) == (3.0, (1.0, 2.0, 3.0))
    np.testing.assert_allclose(tensor(found), 3 * np.diag(FORMULAS[written][1]), rtol=1e-15)


@pytest.mark.parametrize("written", SOLID)
def test_mass_is_density_times_volume(written: str) -> None:
    found = body(f"density: 7.85 g/cm^3, shape: {{{written}}}, position: [0, 0, 0]")
    assert found.mass == pytest.approx(7850 * SOLID[written], rel=1e-15)
    close(found, body(f"mass: {found.mass!r}, shape: {{{written}}}, position: [0, 0, 0]"))


def test_a_thin_shell_keeps_its_digits() -> None:
    found = body("density: 1, shape: {hollow_sphere: {outer_radius: 1 + 1e-9, inner_radius: 1}}, position: [0, 0, 0]")
    assert found.mass == pytest.approx(4 * PI * ((1 + 1e-9) - 1), rel=2e-9)
    assert found.inertia[0][0] / found.mass == pytest.approx(2 / 3, rel=1e-8)


def test_a_point_has_no_inertia_and_a_shape_may_have_no_mass() -> None:
    zero = ((0.0, 0.0, 0.0),) * 3
    assert body("mass: 2, shape: {point: {}}, position: [0, 0, 0]").inertia == zero
    assert body("mass: 2, shape: {point}, position: [0, 0, 0]").inertia == zero
    assert body("mass: 0, shape: {sphere: 1}, position: [0, 0, 0]") == Body("rod", 0.0, zero, (0.0, 0.0, 0.0))


def gauss(lower: float, upper: float) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights that integrate polynomials up to degree 11 exactly."""
    nodes, weights = np.polynomial.legendre.leggauss(6)
    return (lower + upper) / 2 + (upper - lower) / 2 * nodes, (upper - lower) / 2 * weights


def product_rule(*axes: tuple[np.ndarray, np.ndarray]) -> tuple[list[np.ndarray], np.ndarray]:
    """Coordinates and weights of a product rule."""
    grids = np.meshgrid(*(nodes for nodes, _ in axes), indexing="ij")
    weights = np.prod(np.meshgrid(*(weights for _, weights in axes), indexing="ij"), axis=0)
    return [grid.ravel() for grid in grids], weights.ravel()


ROUND = (np.arange(8) * PI / 4, np.full(8, PI / 4))


def round_rule(outer: float, inner: float, length: float) -> tuple[np.ndarray, np.ndarray]:
    (r, angle, z), weights = product_rule(gauss(inner, outer), ROUND, gauss(-length / 2, length / 2))
    return np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=1), weights * r


def ball_rule(outer: float, inner: float) -> tuple[np.ndarray, np.ndarray]:
    (r, angle, height), weights = product_rule(gauss(inner, outer), ROUND, gauss(-1.0, 1.0))
    across = r * np.sqrt(1 - height**2)
    return np.stack([across * np.cos(angle), across * np.sin(angle), r * height], axis=1), weights * r**2


def box_rule(*edges: float) -> tuple[np.ndarray, np.ndarray]:
    points, weights = product_rule(*(gauss(-edge / 2, edge / 2) for edge in edges))
    return np.stack(points, axis=1), weights


def rod_rule(length: float) -> tuple[np.ndarray, np.ndarray]:
    nodes, weights = gauss(-length / 2, length / 2)
    return np.outer(nodes, [0.0, 0.0, 1.0]), weights / length


def rotation(axis: list[float], angle: float) -> np.ndarray:
    """Rodrigues' formula."""
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross


#: Parts of one body: as written; the rule over the shape; its density, or mass without volume; position; turn.
PARTS: list[tuple[str, tuple[np.ndarray, np.ndarray], float, list[float], np.ndarray]] = [
    (
        "box: [0.2, 0.3, 0.5], density: 1000",
        box_rule(0.2, 0.3, 0.5),
        1000.0,
        [0.3, -0.1, 0.2],
        rotation([1, -2, 0.5], math.radians(40)),
    ),
    (
        "cylinder: {radius: 0.1, length: 0.4}, density: 2000",
        round_rule(0.1, 0.0, 0.4),
        2000.0,
        [-0.2, 0.1, 0.7],
        rotation([1, 0, 0], 1.0),
    ),
    (
        "tube: {outer_radius: 0.2, inner_radius: 0.15, length: 0.3}, density: 2700",
        round_rule(0.2, 0.15, 0.3),
        2700.0,
        [0.0, 0.0, -0.4],
        rotation([0, 1, 1], -2.0),
    ),
    ("sphere: 0.12, density: 900", ball_rule(0.12, 0.0), 900.0, [1.0, 0.0, 0.0], np.eye(3)),
    (
        "hollow_sphere: {outer_radius: 0.2, inner_radius: 0.05}, density: 900",
        ball_rule(0.2, 0.05),
        900.0,
        [-1.0, 0.2, 0.0],
        rotation([3, 1, 1], 0.3),
    ),
    ("rod: {length: 1.5}, mass: 2", rod_rule(1.5), 2.0, [0.1, 0.1, 0.1], rotation([0, 1, 0], 0.5)),
    ("point: {}, mass: 3", (np.zeros((1, 3)), np.ones(1)), 3.0, [0.0, 2.0, 0.0], np.eye(3)),
]


def written_part(shape: str, position: list[float], turn: np.ndarray) -> str:
    return f"{{{shape}, position: {position}, orientation: {{matrix: {turn.tolist()}}}}}"


def integrated(chosen: list[Any]) -> tuple[float, np.ndarray, np.ndarray]:
    """Mass, centre of mass and inertia tensor about it, as sums over the points of the rules."""
    points = np.concatenate([nodes @ turn.T + place for _, (nodes, _), _, place, turn in chosen])
    masses = np.concatenate([density * weights for _, (_, weights), density, _, _ in chosen])
    centre = masses @ points / masses.sum()
    arms = points - centre
    inertia = np.einsum("n,nk,nk", masses, arms, arms) * np.eye(3) - np.einsum("n,ni,nj", masses, arms, arms)
    return masses.sum(), centre, inertia


def test_every_shape_is_a_part() -> None:
    assert {shape.split(":")[0] for shape, *_ in PARTS} == set(SHAPES)


@pytest.mark.parametrize(
    "chosen", [*([part] for part in PARTS), PARTS[:2], PARTS[3:], PARTS], ids=[*SHAPES, "two", "four", "all"]
)
def test_quadrature_over_the_volume(chosen: list[Any]) -> None:
    shapes = ", ".join(written_part(shape, place, turn) for shape, _, _, place, turn in chosen)
    found = body(f"shapes: [{shapes}], origin: [0, 0, 0]")
    mass, centre, inertia = integrated(chosen)
    assert found.mass == pytest.approx(mass, rel=1e-14)
    np.testing.assert_allclose(found.position, centre, rtol=0, atol=1e-14)
    np.testing.assert_allclose(tensor(found), inertia, rtol=0, atol=1e-13 * max(inertia.max(), 1e-3))


def test_a_dumbbell() -> None:
    found = body("shapes: [{point: {}, mass: 1}, {point: {}, mass: 3, position: [0.4, 0, 0]}], position: [7, 8, 9]")
    reduced = 1 * 3 / 4 * 0.4**2
    assert (found.mass, found.position) == (4.0, (7.0, 8.0, 9.0))
    np.testing.assert_allclose(tensor(found), np.diag([0, reduced, reduced]), rtol=0, atol=1e-16)


WHOLES = {
    "box: [2, 3, 4]": "{box: [1, 3, 4], density: 5, position: [-0.5, 0, 0]}, "
    "{box: [1, 3, 4], density: 5, position: [0.5, 0, 0]}",
    "cylinder: {radius: 2, length: 6, axis: y}": "{cylinder: {radius: 2, length: 2, axis: y}, density: 5, position: "
    "[0, -2, 0]}, "
    "{cylinder: {radius: 2, length: 4, axis: y}, density: 5, position: [0, 1, 0]}",
    "cylinder: {radius: 2, length: 6}": "{tube: {outer_radius: 2, inner_radius: 0.5, length: 6}, density: 5}, "
    "{cylinder: {radius: 0.5, length: 6}, density: 5}",
    "sphere: 3": "{hollow_sphere: {outer_radius: 3, inner_radius: 2}, density: 5}, {sphere: 2, density: 5}",
}


@pytest.mark.parametrize("whole", WHOLES)
def test_parts_make_the_whole(whole: str) -> None:
    close(
        body(f"shapes: [{WHOLES[whole]}], origin: [1, 2, 3]"),
        body(f"density: 5, shape: {{{whole}}}, position: [1, 2, 3]"),
        position=True,
    )


def test_an_angle_of_two_boxes_and_the_box_that_is_missing_make_a_square() -> None:
    angle = "{box: [4, 1, 1], density: 5, position: [2, 0.5, 0]}, {box: [1, 3, 1], density: 5, position: [0.5, 2.5, 0]}"
    missing = "{box: [3, 3, 1], density: 5, position: [2.5, 2.5, 0]}"
    square = body("density: 5, shape: {box: [4, 4, 1]}, position: [2, 2, 0]")
    close(body(f"shapes: [{angle}, {missing}], origin: [0, 0, 0]"), square, position=True)
    alone = body(f"shapes: [{angle}], origin: [0, 0, 0]")
    centre = np.array([(4 * 2 + 3 * 0.5) / 7, (4 * 0.5 + 3 * 2.5) / 7, 0])
    np.testing.assert_allclose(alone.position, centre, rtol=1e-15)
    arm, other = np.array([2, 2, 0]) - centre, np.array([2, 2, 0]) - np.array([2.5, 2.5, 0])
    steiner = [mass * (d @ d * np.eye(3) - np.outer(d, d)) for mass, d in ((alone.mass, arm), (45.0, other))]
    removed = tensor(body("density: 5, shape: {box: [3, 3, 1]}, position: [0, 0, 0]"))
    np.testing.assert_allclose(tensor(alone), tensor(square) - removed - steiner[1] - steiner[0], rtol=0, atol=1e-12)


def test_a_turned_shape() -> None:
    turned = "{box: [2, 3, 4], density: 5, orientation: {axis: [0, 0, 1], angle: 90 deg}}"
    close(
        body(f"shapes: [{turned}], position: [0, 0, 0]"),
        body("density: 5, shape: {box: [3, 2, 4]}, position: [0, 0, 0]"),
    )
    along = "{rod: {length: 2, axis: z}, mass: 5, orientation: {axis: [0, 1, 0], angle: 90 deg}}"
    close(
        body(f"shapes: [{along}], position: [0, 0, 0]"),
        body("mass: 5, shape: {rod: {length: 2, axis: x}}, position: [0, 0, 0]"),
    )


def test_the_order_of_the_shapes_does_not_matter() -> None:
    parts = [written_part(shape, place, turn) for shape, _, _, place, turn in PARTS[3:]]
    first = body(f"shapes: [{', '.join(parts)}], origin: [1, 2, 3]")
    for order in permutations(parts):
        close(body(f"shapes: [{', '.join(order)}], origin: [1, 2, 3]"), first, position=True)


def test_position_is_the_centre_of_mass_wherever_the_shapes_frame_is() -> None:
    near = "{box: [1, 2, 3], density: 5, position: [1, 0, 0]}, {sphere: 1, density: 5, position: [0, 2, 0]}"
    far = "{box: [1, 2, 3], density: 5, position: [9, 8, 8]}, {sphere: 1, density: 5, position: [8, 10, 8]}"
    close(body(f"shapes: [{near}], position: [1, 2, 3]"), body(f"shapes: [{far}], position: [1, 2, 3]"))
    assert body(f"shapes: [{far}], position: [1, 2, 3]").position == (1.0, 2.0, 3.0)


def test_origin_is_that_of_the_frame_of_the_shapes() -> None:
    dumbbell = "shapes: [{point: {}, mass: 1}, {point: {}, mass: 3, position: [0.4, 0, 0.8]}], origin: [1, 2, 3]"
    assert body(dumbbell).position == pytest.approx((1.3, 2.0, 3.6), abs=1e-15)
    turned = body(f"{dumbbell}, orientation: {{axis: [0, 0, 1], angle: 90 deg}}")
    assert turned.position == pytest.approx((1.0, 2.3, 3.6), abs=1e-15)
    np.testing.assert_array_equal(tensor(turned), tensor(body(dumbbell)))


def test_shapes_take_parameters() -> None:
    shape = "{cylinder: {radius: crank_length / 2, length: rod_length}}"
    found = body(f"density: 1000, shape: {shape}, position: [0, 0, 0]")
    assert found.mass == pytest.approx(1000 * PI * 0.04**2 * 0.3, rel=1e-15)


# Rotations and inertias, against each other and NumPy.

RNG = np.random.default_rng(20150101)


def about(letter: str, angle: float) -> np.ndarray:
    """The rotation matrix about a coordinate axis."""
    i = "xyz".index(letter)
    j, k = (i + 1) % 3, (i + 2) % 3
    matrix = np.eye(3)
    matrix[j, j] = matrix[k, k] = math.cos(angle)
    matrix[k, j], matrix[j, k] = math.sin(angle), -math.sin(angle)
    return matrix


def matrix_of(q: Quaternion) -> np.ndarray:
    """R v = q v q*, column by column."""
    conjugate = (q[0], -q[1], -q[2], -q[3])
    axes: list[Quaternion] = [(0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0)]
    return np.array([multiply(multiply(q, axis), conjugate)[1:] for axis in axes]).T


def rows(matrix: np.ndarray) -> Matrix:
    (a, b, c), (d, e, f), (g, h, i) = matrix.tolist()
    return ((a, b, c), (d, e, f), (g, h, i))


def same_up_to_sign(p: Quaternion, q: Quaternion) -> float:
    return min(np.abs(np.subtract(p, q)).max(), np.abs(np.add(p, q)).max())


def test_the_sequences_are_the_twelve() -> None:
    assert len(SEQUENCES) == len(set(SEQUENCES)) == 12


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_euler_angles_turn_about_the_bodys_axes_in_turn(sequence: str) -> None:
    for angles in RNG.uniform(-7, 7, (20, 3)).tolist():
        expected = about(sequence[0], angles[0]) @ about(sequence[1], angles[1]) @ about(sequence[2], angles[2])
        assert matrix_of(from_euler(tuple(angles), sequence)) == pytest.approx(expected, abs=2e-15)


def test_the_quaternion_of_the_matrix_of_a_quaternion() -> None:
    random = RNG.normal(size=(200, 4)).tolist()
    special = [q for q in product((-1.0, 0.0, 1e-9, 1.0), repeat=4) if any(q)]
    for given in random + special:
        q = unit(given)
        assert q is not None
        found = from_matrix(rows(matrix_of(q)))
        assert same_up_to_sign(found, q) < 1e-15
        assert math.hypot(*found) == pytest.approx(1.0, abs=3e-16)
        assert found[0] >= 0


def test_axis_and_angle_are_a_rotation_about_a_coordinate_axis() -> None:
    for letter, axis in zip("xyz", np.eye(3).tolist(), strict=True):
        for angle in (-4.0, 0.0, 0.3, math.pi):
            assert matrix_of(from_axis_angle(tuple(axis), angle)) == pytest.approx(about(letter, angle), abs=1e-15)


def test_orthonormality_and_determinant() -> None:
    for q in RNG.normal(size=(20, 4)).tolist():
        matrix = matrix_of(unit(q))
        assert orthonormality_error(rows(matrix)) < 3e-15
        assert determinant(rows(matrix)) == pytest.approx(1.0, abs=3e-15)
    assert orthonormality_error(((1.0, 0.0, 0.0), (0.0, 1.0, 0.25), (0.0, 0.0, 1.0))) == 0.25
    assert determinant(((2.0, 1.0, 0.0), (0.0, 3.0, 0.0), (5.0, 0.0, -1.0))) == -6.0


@pytest.mark.parametrize("scale", [1.0, 1e-320, 5e-324, 1e307])
def test_unit_vectors_of_any_size(scale: float) -> None:
    assert unit((scale, 0.0, -scale)) == pytest.approx((math.sqrt(0.5), 0.0, -math.sqrt(0.5)), abs=2e-16)
    assert unit((0.0, 0.0, 0.0)) is None


@pytest.mark.parametrize("scale", [1.0, 1e-9, 1e200, 1e-200])
def test_principal_moments_as_numpys_eigenvalues(scale: float) -> None:
    for elements in RNG.normal(size=(100, 6)).tolist():
        matrix = from_elements([scale * x for x in elements])
        largest = np.abs(matrix).max()
        assert np.array(principal_moments(matrix)) / largest == pytest.approx(
            np.linalg.eigvalsh(np.array(matrix) / largest), abs=4e-15
        )


def test_equal_moments_about_a_diagonal_are_found_at_once() -> None:
    """A rod along (1, 1, 1), as a model has it: rotations once turned what round-off left, without an end."""
    a, b = 0.009318672582184233, 0.004348555749923228
    matrix = from_elements([a, a + 7e-18, a + 5e-18, b, -b - 3e-18, b + 2e-18])
    assert principal_moments(matrix) == pytest.approx([a - 2 * b, a + b, a + b], abs=1e-16)


def turned(moments: tuple[float, float, float]) -> Matrix:
    """The tensor with these principal moments in axes turned at random."""
    R = matrix_of(unit(RNG.normal(size=4).tolist()))
    return rows(R @ np.diag(moments) @ R.T)


@pytest.mark.parametrize("excess", [0.0, 1e-13, -0.5])
def test_flat_bodies_are_possible_in_any_axes(excess: float) -> None:
    for _ in range(20):
        given = turned((1.0, 2.0, 3.0 * (1 + excess)))
        assert np.array(inertia_of(given)) == pytest.approx(np.array(given), abs=1e-15)
    own = from_principal((3.0 * (1 + excess), 1.0, 2.0))
    assert inertia_of(own) == own


def test_bodies_beyond_flat_are_not() -> None:
    for _ in range(20):
        with pytest.raises(Unfit, match="breaks the triangle inequality: 3 exceeds the sum of the other two"):
            inertia_of(turned((1.0, 2.0, 3.0 * (1 + 3e-12))))
        with pytest.raises(Unfit, match="has a negative principal moment"):
            inertia_of(turned((-1e-11, 2.0, 2.0)))
    for moments in ((3.0 * (1 + 3e-12), 1.0, 2.0), (2.0, -1e-11, 2.0)):
        with pytest.raises(Unfit):
            inertia_of(from_principal(moments))


# How a body looks: its shapes, from its centre of mass, and its `appearance`. Neither has a say in its motion.

TEXT = """\
mbproj: 1
gravity: [0, 0, -9.8]
bodies:
  hammer:
    origin: [3, 0, 0]
    shapes:
      - {box: [0.1, 0.02, 0.02], mass: 1, position: [0.05, 0, 0]}
      - {cylinder: {radius: 30 mm, length: 60 mm, axis: y}, mass: 3, position: [0.1, 0, 0]}
    LOOK
"""


def hammer(look=""):
    (body,) = read_scene_text(TEXT.replace("LOOK", look), "f.yaml").bodies
    return body


def test_shapes_are_placed_from_the_centre_of_mass():
    handle, head = hammer().shapes
    assert (handle.kind, dict(handle.sizes), handle.axis) == ("box", {"a": 0.1, "b": 0.02, "c": 0.02}, "z")
    assert handle.position == pytest.approx((-0.0375, 0.0, 0.0))  # the centre is at 0.0875
    assert (head.kind, dict(head.sizes), head.axis) == ("cylinder", {"radius": 0.03, "length": 0.06}, "y")
    assert head.position == pytest.approx((0.0125, 0.0, 0.0))


def test_an_appearance_changes_nothing_but_the_looks():
    look = "appearance: {colour: steel, opacity: 0.5, shapes: [{sphere: 0.1, position: [0, 0, 1]}]}"
    shape = PlacedShape("sphere", {"r": 0.1}, position=(0.0, 0.0, 1.0))
    assert hammer(look).appearance == Appearance(COLOURS["steel"], 0.5, (shape,))
    assert hammer(look) == hammer()  # as far as the motion goes
    assert hammer().appearance is None


def test_a_colour_may_be_given_in_hexadecimal():
    assert hammer('appearance: {colour: "#44AA77"}').appearance == Appearance("#44aa77")
