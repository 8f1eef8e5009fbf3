"""What mechanics conserves, and the same mechanism seen from elsewhere or numbered otherwise."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
import pytest

from mbproj import Scene, read_scene
from mbproj.base.registry import integrators
from mbproj.base.settings import ProjectionSettings, Settings
from mbproj.scene.fields.rotations import from_matrix, multiply
from mbproj.scene.records import Body, Joint, Marker, Pair, Quaternion, Vector
from tests.crossed import some
from tests.mechanisms.running import Run, angular_momentum, assert_close, run, run_scene
from tests.support import ROOT, random_body, random_chain, random_joint, scene_of

#: A rotation that mixes all axes, and a shift.
ROTATION = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
ROTATION = ROTATION * np.linalg.det(ROTATION)
SHIFT = np.array([1.5, -0.7, 2.25])

SETTINGS = Settings(duration=0.1, step=0.005)
TOLERANCE = 1e-11


def mechanisms() -> Mapping[str, Scene]:
    """Loops, trees, a free body and a random chain, each to be run for 20 steps."""
    names = (
        "spatial_slider_crank",
        "planar_four_bar",
        "spatial_four_bar",
        "hooke_shaft",
        "delta_robot",
        "free_body",
        "five_bar",
    )
    scenes = {name: read_scene(ROOT / "mechanisms" / f"{name}.yaml") for name in names}
    scenes["chain"] = random_chain(5, ["universal", "prismatic", "spherical", "revolute", "universal"])
    return {name: replace(scene, settings=SETTINGS) for name, scene in scenes.items()}


SCENES = mechanisms()


@pytest.fixture(scope="module", params=some(SCENES, 3))
def original(request) -> Run:
    return run_scene(SCENES[request.param])


def vector(values: np.ndarray) -> Vector:
    x, y, z = (float(value) for value in values)
    return x, y, z


class Motion:
    """Everything in a scene moved by x -> R x + s."""

    def __init__(self, rotation: np.ndarray, shift: np.ndarray) -> None:
        self.rotation, self.shift = rotation, shift
        self.parameters: Quaternion = from_matrix(tuple(vector(row) for row in rotation))

    def direction(self, given: Vector) -> Vector:
        return vector(self.rotation @ np.array(given))

    def point(self, given: Vector) -> Vector:
        return vector(self.rotation @ np.array(given) + self.shift)

    def body(self, body: Body) -> Body:
        return replace(
            body,
            position=self.point(body.position),
            orientation=multiply(self.parameters, body.orientation),
            velocity=self.direction(body.velocity),
        )

    def joint(self, joint: Joint) -> Joint:
        assert not joint.points.local
        points = Pair(self.point(joint.points.first), self.point(joint.points.second))
        axes = joint.axes and Pair(self.direction(joint.axes.first), self.direction(joint.axes.second))
        return replace(joint, points=points, axes=axes)

    def marker(self, marker: Marker) -> Marker:
        return marker if marker.local else replace(marker, location=self.point(marker.location))

    def __call__(self, scene: Scene) -> Scene:
        return replace(
            scene,
            gravity=self.direction(scene.gravity),
            bodies=tuple(map(self.body, scene.bodies)),
            joints=tuple(map(self.joint, scene.joints)),
            markers=tuple(map(self.marker, scene.markers)),
        )


@pytest.mark.parametrize(
    ("rotation", "shift"), [(ROTATION, np.zeros(3)), (np.eye(3), SHIFT)], ids=["rotation", "translation"]
)
def test_moving_the_whole_scene_moves_the_results(original, rotation, shift):
    moved = run_scene(Motion(rotation, shift)(original.scene))
    for path in ("bodies/position", "markers/position"):
        assert_close(moved[path], original[path] @ rotation.T + shift, TOLERANCE)
    for path in ("bodies/velocity", "markers/velocity"):
        assert_close(moved[path], original[path] @ rotation.T, TOLERANCE)
    for path in ("bodies/acceleration", "joints/reaction_force", "joints/reaction_torque"):
        largest = max(1.0, np.abs(original[path]).max(initial=0.0))
        assert np.abs(moved[path] - original[path] @ rotation.T).max(initial=0.0) < TOLERANCE * largest
    for path in ("bodies/angular_velocity", "diagnostics/kinetic_energy", "diagnostics/energy_balance"):
        assert_close(moved[path], original[path], TOLERANCE)
    for path in ("joints/coordinate", "joints/speed"):
        assert np.abs(moved[path] - original[path]).max(initial=0.0) < TOLERANCE


def shuffled(scene: Scene) -> Scene:
    """Bodies, joints and markers in another order."""
    rng = np.random.default_rng(7)
    orders = {kind: rng.permutation(len(getattr(scene, kind))) for kind in ("bodies", "joints", "markers")}
    return replace(scene, **{kind: tuple(getattr(scene, kind)[k] for k in order) for kind, order in orders.items()})


def test_numbering_bodies_and_joints_otherwise_changes_nothing(original):
    other = run_scene(shuffled(original.scene))
    names = original.system.names
    for kind, paths in (
        ("bodies", ("bodies/position", "bodies/velocity", "bodies/orientation", "bodies/angular_velocity")),
        ("markers", ("markers/position",)),
        ("coordinates", ("joints/coordinate", "joints/speed")),
    ):
        for name in getattr(names, kind):
            for path in paths:
                assert_close(other.column(path, name), original.column(path, name), TOLERANCE)


def reversed_joints(scene: Scene) -> Scene:
    """Every joint from its second body to its first."""

    def turned(joint: Joint) -> Joint:
        axes = joint.axes and Pair(joint.axes.second, joint.axes.first)
        points = Pair(joint.points.second, joint.points.first)
        return replace(joint, bodies=(joint.bodies[1], joint.bodies[0]), points=points, axes=axes)

    return replace(scene, joints=tuple(map(turned, scene.joints)))


@pytest.mark.parametrize("name", ["planar_four_bar", "chain"])
def test_naming_a_joints_bodies_the_other_way_round_negates_its_coordinates(name):
    """A rotation of 2 relative to 1 about an axis is the negative one of 1 relative to 2; a universal joint's angles
    change places as well. Speeds that the scene asks for are left out: they would be asked for with the wrong sign."""
    scene = replace(SCENES[name], joints=tuple(replace(joint, speed={}) for joint in SCENES[name].joints))
    one, other = run_scene(scene), run_scene(reversed_joints(scene))
    assert_close(other["bodies/position"], one["bodies/position"], TOLERANCE)
    exchanged = {"angle_1": "angle_2", "angle_2": "angle_1"}
    for coordinate in one.system.names.coordinates:
        joint, own = coordinate.split(".")
        partner = f"{joint}.{exchanged.get(own, own)}"
        negated = -one.column("joints/coordinate", coordinate)
        assert_close(other.column("joints/coordinate", partner), negated, TOLERANCE)


@pytest.mark.parametrize("method", ["gopm", "mmopm", "gpopm"])
def test_projections_do_not_depend_on_where_the_scene_is(method):
    """The metric of GOPM is not physical, but it has no preferred direction either."""
    penalty = {"alpha": 1e7} if method == "mmopm" else {}
    settings = replace(SETTINGS, projection=ProjectionSettings(method=method, **penalty))
    scene = replace(SCENES["spatial_slider_crank"], settings=settings)
    one, other = run_scene(scene), run_scene(Motion(ROTATION, SHIFT)(scene))
    assert_close(other["bodies/position"], one["bodies/position"] @ ROTATION.T + SHIFT, TOLERANCE)


# What mechanics conserves: exactly where every step conserves it, and otherwise with the integrator's order.


def floating_chain(**settings) -> Scene:
    """Four bodies of random mass joined in a row, far from any ground and without gravity."""
    rng = np.random.default_rng(3)
    kinds = ["spherical", "revolute", "universal"]
    bodies = [random_body(rng, f"body{number}") for number in range(4)]
    joints = [random_joint(rng, f"J{n}", kind, (f"body{n}", f"body{n + 1}")) for n, kind in enumerate(kinds)]
    return scene_of(bodies, joints, gravity=(0.0, 0.0, 0.0), settings=Settings(**settings))


def momentum(done: Run) -> np.ndarray:
    """Linear momentum of all bodies (T, 3)."""
    return np.einsum("b,tbi->ti", [body.mass for body in done.scene.bodies], done["bodies/velocity"])


def drift(values: np.ndarray) -> float:
    return float(np.abs(values - values[0]).max())


@pytest.mark.parametrize("method", ["gpopm", "mmopm", "none"])
def test_centre_of_a_floating_chain_moves_on_a_straight_line(method):
    """Forces, and corrections weighted by mass, are internal: momentum is conserved to round-off in every step."""
    penalty = {"alpha": 1e7} if method == "mmopm" else {}
    done = run_scene(floating_chain(duration=0.4, step=0.01, projection=ProjectionSettings(method=method, **penalty)))
    assert_close(momentum(done), momentum(done)[0], 1e-13)
    mass = np.array([body.mass for body in done.scene.bodies])
    centre = np.einsum("b,tbi->ti", mass, done["bodies/position"]) / mass.sum()
    assert_close(centre, centre[0] + momentum(done)[0] / mass.sum() * done["time"][:, None], 1e-13)


def test_a_projection_that_ignores_mass_pushes_the_centre():
    """GOPM corrects light and heavy bodies alike, as if somebody outside moved them."""
    done = run_scene(floating_chain(duration=0.4, step=0.01, projection=ProjectionSettings(method="gopm")))
    assert drift(momentum(done)) > 1e-11


Quantity = Callable[[Run], np.ndarray]


def energy(done: Run) -> np.ndarray:
    return done["diagnostics/total_energy"]


def vertical(done: Run) -> np.ndarray:
    return angular_momentum(done, "origin")[:, 2]


def spin(done: Run) -> np.ndarray:
    return done["bodies/angular_velocity"][:, 0, 2]


def idle_spin(done: Run) -> np.ndarray:
    return done.column("bodies/angular_velocity", "rod")[:, 0]


def observed_order(simulate: Callable[[float], Run], quantity: Quantity, step: float) -> float:
    """log2 of the ratio of the drifts with this step and with half of it."""
    return float(np.log2(drift(quantity(simulate(step))) / drift(quantity(simulate(step / 2)))))


#: The larger step (s), and whether the order is clean there; where it is not, the drift falls faster.
CHAIN_STEPS = {
    "heun2": (0.002, True),
    "bs32": (0.01, True),
    "rk4": (0.01, True),
    "dopri5": (0.02, False),
    "dop853": (0.1, False),
}


@pytest.mark.parametrize("quantity", [angular_momentum, energy], ids=["momentum", "energy"])
@pytest.mark.parametrize("integrator", list(CHAIN_STEPS))
def test_floating_chain_drifts_with_the_order(integrator, quantity):
    """Angular momentum about the centre, and energy."""
    step, clean = CHAIN_STEPS[integrator]

    def simulate(h: float) -> Run:
        return run_scene(floating_chain(duration=0.4, step=h, output_step=step, integrator=integrator))

    order, expected = observed_order(simulate, quantity, step), integrators()[integrator].order
    assert order == pytest.approx(expected, abs=0.15) if clean else order >= expected - 0.15


TOP_STEPS = {"heun2": 0.0002, "bs32": 0.0005, "rk4": 0.001, "dopri5": 0.001, "dop853": 0.01}


@pytest.mark.parametrize("integrator", some(TOP_STEPS, 3))
def test_top_loses_spin_and_momentum_with_the_order_of_a_linear_oscillation(integrator):
    """With Euler parameters even turning is one: |R(iωh)| - 1 is of order p + 1 in a step, p + 2 where p is even."""
    step, p = TOP_STEPS[integrator], integrators()[integrator].order
    results = [
        run("heavy_top", formulation="full", integrator=integrator, step=h, output_step=step, duration=20 * step)
        for h in (step, step / 2)
    ]
    for quantity in (spin, vertical, energy):
        coarse, fine = (drift(quantity(done)) for done in results)
        assert np.log2(coarse / fine) == pytest.approx(p + (p % 2 == 0), abs=0.15)


@pytest.mark.parametrize(
    ("name", "quantity", "integrator", "step", "clean"),
    some(
        [
            ("double_pendulum", energy, "heun2", 0.005, True),
            ("double_pendulum", energy, "bs32", 0.005, True),
            ("double_pendulum", energy, "rk4", 0.005, True),
            ("double_pendulum", energy, "dopri5", 0.02, False),
            ("double_pendulum", energy, "dop853", 0.05, False),
            ("spatial_four_bar", energy, "heun2", 0.001, True),
            ("spatial_four_bar", energy, "bs32", 0.0025, True),
            ("spatial_four_bar", energy, "rk4", 0.005, True),
            ("spatial_four_bar", idle_spin, "heun2", 0.0005, True),
            ("spatial_four_bar", idle_spin, "bs32", 0.0025, True),
            ("spatial_four_bar", idle_spin, "rk4", 0.0025, True),
            ("spatial_four_bar", idle_spin, "dopri5", 0.005, True),
            ("delta_robot", energy, "rk4", 0.02, True),
            ("stewart_platform", energy, "rk4", 0.02, True),
        ],
        3,
    ),
)
def test_drift_falls_with_the_order(name, quantity, integrator, step, clean):
    duration = {"dop853": 2.0}.get(integrator, 0.5) if name == "double_pendulum" else 0.2

    formulation = "auto"
    if (
        quantity is idle_spin
    ):  # in reduced coordinates that of a symmetric rod is a constant of the equations themselves
        formulation, duration = "full", 40 * step

    def simulate(h: float) -> Run:
        return run(name, integrator=integrator, step=h, output_step=step, duration=duration, formulation=formulation)

    order, expected = observed_order(simulate, quantity, step), integrators()[integrator].order
    assert order == pytest.approx(expected, abs=0.15) if clean else order >= expected - 0.15
