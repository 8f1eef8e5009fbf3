"""Written by scripts/write_parts.py from the tables that read a scene."""

from collections.abc import Mapping, Sequence
from typing import Any, SupportsFloat, TypeAlias

import numpy.typing as npt

from mbproj.scene.part_classes import ScenePart

#: A number in SI units, or text with a unit or an expression.
Quantity: TypeAlias = SupportsFloat | str
Vector: TypeAlias = Sequence[Quantity] | npt.NDArray[Any]

class Body(ScenePart):
    """A body of a scene. Arguments are its keys:

    mass: a number in kg, optional
    density: a number in kg/m^3, optional
    inertia: 3 numbers, 6 numbers or 3 rows of 3 numbers, optional
    shape: {box, cylinder, tube, sphere, hollow_sphere, rod, point}, optional
    shapes: a list of shapes, optional
    position: 3 numbers, optional
    origin: 3 numbers, optional
    orientation: {axis, angle}, {quaternion}, {matrix} or {euler, sequence}, optional
    velocity: 3 numbers, optional
    angular_velocity: 3 numbers, optional
    start: {position, orientation}, optional
    appearance: {colour, opacity, shapes, mesh}, optional
    one of mass, density, shapes
    one of inertia, shape, shapes
    one of position, origin
    at most one of density, inertia
    at most one of origin, inertia
    at most one of origin, shape
    """

    def __init__(
        self,
        *,
        mass: Quantity | None = ...,
        density: Quantity | None = ...,
        inertia: Vector | Sequence[Vector] | None = ...,
        shape: Mapping[str, Any] | None = ...,
        shapes: Sequence[Mapping[str, Any]] | None = ...,
        position: Vector | None = ...,
        origin: Vector | None = ...,
        orientation: Mapping[str, Any] | None = ...,
        velocity: Vector | None = ...,
        angular_velocity: Vector | None = ...,
        start: Mapping[str, Any] | None = ...,
        appearance: Mapping[str, Any] | None = ...,
    ) -> None: ...

class Marker(ScenePart):
    """A marker of a scene. Arguments are its keys:

    body: the name of a body
    location: 3 numbers or a mapping {name: 3 numbers}
    """

    def __init__(
        self,
        *,
        body: str,
        location: Vector | Mapping[str, Any],
    ) -> None: ...

class Curve(ScenePart):
    """A curve of a scene. Arguments are its keys:

    points: a list of points, optional
    space_points: a list of points, optional
    polyline: a list of points, optional
    circle: a number in m, optional
    ellipse: 2 half axes, optional
    involute: {base, from, to}, optional
    table: a list of rows, optional
    lift: {base, rises}, optional
    closed: true or false, optional
    fillet: a number in m, optional
    roller: a number in m, optional
    flat: true or false, optional
    clockwise: true or false, optional
    one of points, space_points, polyline, circle, ellipse, involute, table, lift
    at most one of roller, flat
    """

    def __init__(
        self,
        *,
        points: Sequence[Sequence[Any]] | None = ...,
        space_points: Sequence[Sequence[Any]] | None = ...,
        polyline: Sequence[Sequence[Any]] | None = ...,
        circle: Quantity | None = ...,
        ellipse: Vector | None = ...,
        involute: Mapping[str, Any] | None = ...,
        table: Sequence[Sequence[Any]] | None = ...,
        lift: Mapping[str, Any] | None = ...,
        closed: bool | None = ...,
        fillet: Quantity | None = ...,
        roller: Quantity | None = ...,
        flat: bool | None = ...,
        clockwise: bool | None = ...,
    ) -> None: ...

class Motion(ScenePart):
    """A motion of a scene. Arguments are its keys:

    joint: the name of a joint
    angle: a number in rad or an expression of t or {constant_speed, harmonic, polynomial, smooth_step, table, expression}, optional
    angle_1: a number in rad or an expression of t or {constant_speed, harmonic, polynomial, smooth_step, table, expression}, optional
    angle_2: a number in rad or an expression of t or {constant_speed, harmonic, polynomial, smooth_step, table, expression}, optional
    displacement: a number in m or an expression of t or {constant_speed, harmonic, polynomial, smooth_step, table, expression}, optional
    displacement_x: a number in m or an expression of t or {constant_speed, harmonic, polynomial, smooth_step, table, expression}, optional
    displacement_y: a number in m or an expression of t or {constant_speed, harmonic, polynomial, smooth_step, table, expression}, optional
    length: a number in m or an expression of t or {constant_speed, harmonic, polynomial, smooth_step, table, expression}, optional
    gap: a number in m or an expression of t or {constant_speed, harmonic, polynomial, smooth_step, table, expression}, optional
    displacement_1: a number in m or an expression of t or {constant_speed, harmonic, polynomial, smooth_step, table, expression}, optional
    displacement_2: a number in m or an expression of t or {constant_speed, harmonic, polynomial, smooth_step, table, expression}, optional
    lap: a number in rad or an expression of t or {constant_speed, harmonic, polynomial, smooth_step, table, expression}, optional
    one of angle, angle_1, angle_2, displacement, displacement_x, displacement_y, length, gap, displacement_1, displacement_2, lap
    """

    def __init__(
        self,
        *,
        joint: str,
        angle: Quantity | Mapping[str, Any] | None = ...,
        angle_1: Quantity | Mapping[str, Any] | None = ...,
        angle_2: Quantity | Mapping[str, Any] | None = ...,
        displacement: Quantity | Mapping[str, Any] | None = ...,
        displacement_x: Quantity | Mapping[str, Any] | None = ...,
        displacement_y: Quantity | Mapping[str, Any] | None = ...,
        length: Quantity | Mapping[str, Any] | None = ...,
        gap: Quantity | Mapping[str, Any] | None = ...,
        displacement_1: Quantity | Mapping[str, Any] | None = ...,
        displacement_2: Quantity | Mapping[str, Any] | None = ...,
        lap: Quantity | Mapping[str, Any] | None = ...,
    ) -> None: ...

class Expectation(ScenePart):
    """An expectation of a scene. Arguments are its keys:

    marker: the name of a marker, optional
    body: the name of a body, optional
    joint: the name of a joint, optional
    force: the name of a force, optional
    motion: the name of a motion, optional
    stop: text, optional
    friction: text, optional
    state: text, optional
    signal: text, optional
    diagnostic: position_violation, velocity_violation, acceleration_violation, kinetic_energy, potential_energy, total_energy, work, dissipation, energy_balance, energy_drift, energy_drift_relative, step_size, steps, rejected_steps, evaluations, projections, projection_iterations, velocity_iterations, projection_failures, projection_fallbacks or factorisations, optional
    quantity: position, velocity, acceleration, transmission_angle, orientation, angular_velocity, angular_acceleration, angle, angle_1, angle_2, displacement, displacement_x, displacement_y, length, gap, displacement_1, displacement_2, lap, angle_speed, angle_1_speed, angle_2_speed, displacement_speed, displacement_x_speed, displacement_y_speed, length_speed, gap_speed, displacement_1_speed, displacement_2_speed, lap_speed, angle_velocity_ratio, angle_1_velocity_ratio, angle_2_velocity_ratio, displacement_velocity_ratio, displacement_x_velocity_ratio, displacement_y_velocity_ratio, length_velocity_ratio, gap_velocity_ratio, displacement_1_velocity_ratio, displacement_2_velocity_ratio, lap_velocity_ratio, angle_mechanical_advantage, angle_1_mechanical_advantage, angle_2_mechanical_advantage, displacement_mechanical_advantage, displacement_x_mechanical_advantage, displacement_y_mechanical_advantage, length_mechanical_advantage, gap_mechanical_advantage, displacement_1_mechanical_advantage, displacement_2_mechanical_advantage, lap_mechanical_advantage, tension_1, tension_2, tension_3, tension_4, tension_5, tension_6, contact, reaction_force, reaction_torque, violation, violation_length, violation_angle, coordinate, rate, force, value, state, dissipation, translation, rotation, translation_rate, rotation_rate or torque, optional
    component: x, y, z or norm, optional
    over: text, optional
    between: 2 markers, optional
    at: a time in s, end, maximum, minimum, largest, range or a place {A.angle: 90 deg}
    value: a number in the unit of the quantity or a list of numbers, optional
    absolute: a number in the unit of the quantity, optional
    relative: a number, optional
    below: a number in the unit of the quantity, optional
    above: a number in the unit of the quantity, optional
    source: text
    one of marker, body, joint, force, motion, stop, friction, state, signal, diagnostic
    one of quantity, diagnostic
    one of value, below, above
    one of absolute, relative, below, above
    """

    def __init__(
        self,
        *,
        at: Mapping[str, Any],
        source: str,
        marker: str | None = ...,
        body: str | None = ...,
        joint: str | None = ...,
        force: str | None = ...,
        motion: str | None = ...,
        stop: str | None = ...,
        friction: str | None = ...,
        state: str | None = ...,
        signal: str | None = ...,
        diagnostic: str | None = ...,
        quantity: str | None = ...,
        component: str | None = ...,
        over: str | None = ...,
        between: Sequence[str] | None = ...,
        value: Quantity | Vector | None = ...,
        absolute: Quantity | None = ...,
        relative: Quantity | None = ...,
        below: Quantity | None = ...,
        above: Quantity | None = ...,
    ) -> None: ...

class Simulation(ScenePart):
    """A simulation of a scene. Arguments are its keys:

    duration: a number in s, optional
    step: a number in s, optional
    tolerance: a number, optional
    integrator: heun2, bs32, rk4, dopri5, dop853, esdirk4, radau5 or auto, optional
    formulation: auto, full, reduced or planar, optional
    kinematic: true or false, optional
    acceleration: bordered or eliminated, optional
    impact_law: newton, poisson or energetic, optional
    output_step: a number in s, optional
    break_times: a list of times, optional
    start: scene or equilibrium, optional
    adjust_joints: a number in m, optional
    projection: none, baumgarte, gopm, popm, mass-orthogonal, mmopm, gpopm or gpopm-pinv or {method, tolerance, test, every, threshold, position, velocity, max_iterations, alpha, gains, fallback, energy, momentum}, optional
    at most one of step, tolerance
    """

    def __init__(
        self,
        *,
        duration: Quantity | None = ...,
        step: Quantity | None = ...,
        tolerance: Quantity | None = ...,
        integrator: str | None = ...,
        formulation: str | None = ...,
        kinematic: bool | None = ...,
        acceleration: str | None = ...,
        impact_law: str | None = ...,
        output_step: Quantity | None = ...,
        break_times: Vector | None = ...,
        start: str | None = ...,
        adjust_joints: Quantity | None = ...,
        projection: str | Mapping[str, Any] | None = ...,
    ) -> None: ...

class Revolute(ScenePart):
    """A revolute joint of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    location: 3 numbers or a mapping {name: 3 numbers}
    axis: 3 numbers or a mapping {name: 3 numbers}
    speed: a number in rad/s, optional
    reflected_inertia: a number in kg*m^2, optional
    limits: {angle}, optional
    angle: a number in rad, optional
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        location: Vector | Mapping[str, Any],
        axis: Vector | str | Mapping[str, Any],
        speed: Quantity | None = ...,
        reflected_inertia: Quantity | None = ...,
        limits: Mapping[str, Any] | None = ...,
        angle: Quantity | None = ...,
    ) -> None: ...

class Spherical(ScenePart):
    """A spherical joint of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    location: 3 numbers or a mapping {name: 3 numbers}
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        location: Vector | Mapping[str, Any],
    ) -> None: ...

class Universal(ScenePart):
    """A universal joint of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    location: 3 numbers or a mapping {name: 3 numbers}
    axes: 2 axes or a mapping {name: 3 numbers}
    speed: {angle_1, angle_2}, optional
    reflected_inertia: {angle_1, angle_2}, optional
    limits: {angle_1, angle_2}, optional
    angle_1: a number in rad, optional
    angle_2: a number in rad, optional
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        location: Vector | Mapping[str, Any],
        axes: Sequence[Vector | str] | Mapping[str, Any],
        speed: Mapping[str, Any] | None = ...,
        reflected_inertia: Mapping[str, Any] | None = ...,
        limits: Mapping[str, Any] | None = ...,
        angle_1: Quantity | None = ...,
        angle_2: Quantity | None = ...,
    ) -> None: ...

class Prismatic(ScenePart):
    """A prismatic joint of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    location: 3 numbers or a mapping {name: 3 numbers}
    axis: 3 numbers or a mapping {name: 3 numbers}
    speed: a number in m/s, optional
    reflected_inertia: a number in kg, optional
    limits: {displacement}, optional
    displacement: a number in m, optional
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        location: Vector | Mapping[str, Any],
        axis: Vector | str | Mapping[str, Any],
        speed: Quantity | None = ...,
        reflected_inertia: Quantity | None = ...,
        limits: Mapping[str, Any] | None = ...,
        displacement: Quantity | None = ...,
    ) -> None: ...

class Cylindrical(ScenePart):
    """A cylindrical joint of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    location: 3 numbers or a mapping {name: 3 numbers}
    axis: 3 numbers or a mapping {name: 3 numbers}
    speed: {angle, displacement}, optional
    reflected_inertia: {angle, displacement}, optional
    limits: {angle, displacement}, optional
    angle: a number in rad, optional
    displacement: a number in m, optional
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        location: Vector | Mapping[str, Any],
        axis: Vector | str | Mapping[str, Any],
        speed: Mapping[str, Any] | None = ...,
        reflected_inertia: Mapping[str, Any] | None = ...,
        limits: Mapping[str, Any] | None = ...,
        angle: Quantity | None = ...,
        displacement: Quantity | None = ...,
    ) -> None: ...

class Planar(ScenePart):
    """A planar joint of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    location: 3 numbers or a mapping {name: 3 numbers}
    axis: 3 numbers or a mapping {name: 3 numbers}
    x_axis: 3 numbers or a mapping {name: 3 numbers}, optional
    speed: {displacement_x, displacement_y, angle}, optional
    reflected_inertia: {displacement_x, displacement_y, angle}, optional
    limits: {displacement_x, displacement_y, angle}, optional
    displacement_x: a number in m, optional
    displacement_y: a number in m, optional
    angle: a number in rad, optional
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        location: Vector | Mapping[str, Any],
        axis: Vector | str | Mapping[str, Any],
        x_axis: Vector | str | Mapping[str, Any] | None = ...,
        speed: Mapping[str, Any] | None = ...,
        reflected_inertia: Mapping[str, Any] | None = ...,
        limits: Mapping[str, Any] | None = ...,
        displacement_x: Quantity | None = ...,
        displacement_y: Quantity | None = ...,
        angle: Quantity | None = ...,
    ) -> None: ...

class Fixed(ScenePart):
    """A fixed joint of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    location: 3 numbers or a mapping {name: 3 numbers}
    reaction: true or false, optional
    axes: a mapping {name: {axis, angle}, {quaternion}, {matrix} or {euler, sequence}}, optional
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        location: Vector | Mapping[str, Any],
        reaction: bool | None = ...,
        axes: Mapping[str, Any] | None = ...,
    ) -> None: ...

class Distance(ScenePart):
    """A distance joint of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    locations: 2 points or a mapping {name: 3 numbers}
    length: a number in m, optional
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        locations: Sequence[Vector] | Mapping[str, Any],
        length: Quantity | None = ...,
    ) -> None: ...

class Telescope(ScenePart):
    """A telescope joint of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    locations: 2 points or a mapping {name: 3 numbers}
    speed: a number in m/s, optional
    reflected_inertia: a number in kg, optional
    limits: {length}, optional
    length: a number in m, optional
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        locations: Sequence[Vector] | Mapping[str, Any],
        speed: Quantity | None = ...,
        reflected_inertia: Quantity | None = ...,
        limits: Mapping[str, Any] | None = ...,
        length: Quantity | None = ...,
    ) -> None: ...

class RevoluteSpherical(ScenePart):
    """A revolute_spherical joint of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    locations: 2 points or a mapping {name: 3 numbers}
    axis: 3 numbers or a mapping {name: 3 numbers}
    length: a number in m, optional
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        locations: Sequence[Vector] | Mapping[str, Any],
        axis: Vector | str | Mapping[str, Any],
        length: Quantity | None = ...,
    ) -> None: ...

class PointInPlane(ScenePart):
    """A point_in_plane joint of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    location: 3 numbers or a mapping {name: 3 numbers}
    axis: 3 numbers or a mapping {name: 3 numbers}
    x_axis: 3 numbers or a mapping {name: 3 numbers}, optional
    speed: {displacement_x, displacement_y}, optional
    reflected_inertia: {displacement_x, displacement_y}, optional
    limits: {displacement_x, displacement_y}, optional
    displacement_x: a number in m, optional
    displacement_y: a number in m, optional
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        location: Vector | Mapping[str, Any],
        axis: Vector | str | Mapping[str, Any],
        x_axis: Vector | str | Mapping[str, Any] | None = ...,
        speed: Mapping[str, Any] | None = ...,
        reflected_inertia: Mapping[str, Any] | None = ...,
        limits: Mapping[str, Any] | None = ...,
        displacement_x: Quantity | None = ...,
        displacement_y: Quantity | None = ...,
    ) -> None: ...

class PointOnLine(ScenePart):
    """A point_on_line joint of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    location: 3 numbers or a mapping {name: 3 numbers}
    axis: 3 numbers or a mapping {name: 3 numbers}
    speed: a number in m/s, optional
    reflected_inertia: a number in kg, optional
    limits: {displacement}, optional
    displacement: a number in m, optional
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        location: Vector | Mapping[str, Any],
        axis: Vector | str | Mapping[str, Any],
        speed: Quantity | None = ...,
        reflected_inertia: Quantity | None = ...,
        limits: Mapping[str, Any] | None = ...,
        displacement: Quantity | None = ...,
    ) -> None: ...

class Cam(ScenePart):
    """A cam joint of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    locations: 2 points or a mapping {name: 3 numbers}
    axis: 3 numbers or a mapping {name: 3 numbers}
    x_axis: 3 numbers or a mapping {name: 3 numbers}
    curve: the name of a curve
    roller: a number in m, optional
    side: outside, inside, left or right, optional
    speed: a number in m/s, optional
    reflected_inertia: a number in kg, optional
    limits: {displacement}, optional
    displacement: a number in m, optional
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        locations: Sequence[Vector] | Mapping[str, Any],
        axis: Vector | str | Mapping[str, Any],
        x_axis: Vector | str | Mapping[str, Any],
        curve: str,
        roller: Quantity | None = ...,
        side: str | None = ...,
        speed: Quantity | None = ...,
        reflected_inertia: Quantity | None = ...,
        limits: Mapping[str, Any] | None = ...,
        displacement: Quantity | None = ...,
    ) -> None: ...

class CamContact(ScenePart):
    """A cam_contact joint of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    locations: 2 points or a mapping {name: 3 numbers}
    axis: 3 numbers or a mapping {name: 3 numbers}
    x_axis: 3 numbers or a mapping {name: 3 numbers}
    curve: the name of a curve
    roller: a number in m, optional
    side: outside, inside, left or right, optional
    speed: a number in m/s, optional
    reflected_inertia: a number in kg, optional
    limits: {gap}, optional
    gap: a number in m, optional
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        locations: Sequence[Vector] | Mapping[str, Any],
        axis: Vector | str | Mapping[str, Any],
        x_axis: Vector | str | Mapping[str, Any],
        curve: str,
        roller: Quantity | None = ...,
        side: str | None = ...,
        speed: Quantity | None = ...,
        reflected_inertia: Quantity | None = ...,
        limits: Mapping[str, Any] | None = ...,
        gap: Quantity | None = ...,
    ) -> None: ...

class FlatFollower(ScenePart):
    """A flat_follower joint of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    locations: 2 points or a mapping {name: 3 numbers}
    axis: 3 numbers or a mapping {name: 3 numbers}
    x_axis: 3 numbers or a mapping {name: 3 numbers}
    curve: the name of a curve
    speed: a number in m/s, optional
    reflected_inertia: a number in kg, optional
    limits: {displacement}, optional
    displacement: a number in m, optional
    normal: 3 numbers or a mapping {name: 3 numbers}
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        locations: Sequence[Vector] | Mapping[str, Any],
        axis: Vector | str | Mapping[str, Any],
        x_axis: Vector | str | Mapping[str, Any],
        curve: str,
        normal: Vector | str | Mapping[str, Any],
        speed: Quantity | None = ...,
        reflected_inertia: Quantity | None = ...,
        limits: Mapping[str, Any] | None = ...,
        displacement: Quantity | None = ...,
    ) -> None: ...

class FlatContact(ScenePart):
    """A flat_contact joint of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    locations: 2 points or a mapping {name: 3 numbers}
    axis: 3 numbers or a mapping {name: 3 numbers}
    x_axis: 3 numbers or a mapping {name: 3 numbers}
    curve: the name of a curve
    speed: a number in m/s, optional
    reflected_inertia: a number in kg, optional
    limits: {gap}, optional
    gap: a number in m, optional
    normal: 3 numbers or a mapping {name: 3 numbers}
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        locations: Sequence[Vector] | Mapping[str, Any],
        axis: Vector | str | Mapping[str, Any],
        x_axis: Vector | str | Mapping[str, Any],
        curve: str,
        normal: Vector | str | Mapping[str, Any],
        speed: Quantity | None = ...,
        reflected_inertia: Quantity | None = ...,
        limits: Mapping[str, Any] | None = ...,
        gap: Quantity | None = ...,
    ) -> None: ...

class SpaceSlot(ScenePart):
    """A space_slot joint of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    locations: 2 points or a mapping {name: 3 numbers}
    axis: 3 numbers or a mapping {name: 3 numbers}
    x_axis: 3 numbers or a mapping {name: 3 numbers}
    curve: the name of a curve
    speed: a number in m/s, optional
    reflected_inertia: a number in kg, optional
    limits: {displacement}, optional
    displacement: a number in m, optional
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        locations: Sequence[Vector] | Mapping[str, Any],
        axis: Vector | str | Mapping[str, Any],
        x_axis: Vector | str | Mapping[str, Any],
        curve: str,
        speed: Quantity | None = ...,
        reflected_inertia: Quantity | None = ...,
        limits: Mapping[str, Any] | None = ...,
        displacement: Quantity | None = ...,
    ) -> None: ...

class CurveOnCurve(ScenePart):
    """A curve_on_curve joint of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    locations: 2 points or a mapping {name: 3 numbers}
    axis: 3 numbers or a mapping {name: 3 numbers}
    x_axis: 3 numbers or a mapping {name: 3 numbers}
    curves: 2 names of curves
    sides: 2 sides, optional
    speed: {displacement_1, displacement_2}, optional
    reflected_inertia: {displacement_1, displacement_2}, optional
    limits: {displacement_1, displacement_2}, optional
    displacement_1: a number in m, optional
    displacement_2: a number in m, optional
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        locations: Sequence[Vector] | Mapping[str, Any],
        axis: Vector | str | Mapping[str, Any],
        x_axis: Vector | str | Mapping[str, Any],
        curves: Sequence[str],
        sides: Sequence[str] | None = ...,
        speed: Mapping[str, Any] | None = ...,
        reflected_inertia: Mapping[str, Any] | None = ...,
        limits: Mapping[str, Any] | None = ...,
        displacement_1: Quantity | None = ...,
        displacement_2: Quantity | None = ...,
    ) -> None: ...

class CurveContact(ScenePart):
    """A curve_contact joint of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    locations: 2 points or a mapping {name: 3 numbers}
    axis: 3 numbers or a mapping {name: 3 numbers}
    x_axis: 3 numbers or a mapping {name: 3 numbers}
    curves: 2 names of curves
    sides: 2 sides, optional
    speed: a number in m/s, optional
    reflected_inertia: a number in kg, optional
    limits: {gap}, optional
    gap: a number in m, optional
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        locations: Sequence[Vector] | Mapping[str, Any],
        axis: Vector | str | Mapping[str, Any],
        x_axis: Vector | str | Mapping[str, Any],
        curves: Sequence[str],
        sides: Sequence[str] | None = ...,
        speed: Quantity | None = ...,
        reflected_inertia: Quantity | None = ...,
        limits: Mapping[str, Any] | None = ...,
        gap: Quantity | None = ...,
    ) -> None: ...

class Slot(ScenePart):
    """A slot joint of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    locations: 2 points or a mapping {name: 3 numbers}
    axis: 3 numbers or a mapping {name: 3 numbers}
    x_axis: 3 numbers or a mapping {name: 3 numbers}
    curve: the name of a curve
    speed: a number in m/s, optional
    reflected_inertia: a number in kg, optional
    limits: {displacement}, optional
    displacement: a number in m, optional
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        locations: Sequence[Vector] | Mapping[str, Any],
        axis: Vector | str | Mapping[str, Any],
        x_axis: Vector | str | Mapping[str, Any],
        curve: str,
        speed: Quantity | None = ...,
        reflected_inertia: Quantity | None = ...,
        limits: Mapping[str, Any] | None = ...,
        displacement: Quantity | None = ...,
    ) -> None: ...

class BallOnSurface(ScenePart):
    """A ball_on_surface joint of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    locations: 2 points or a mapping {name: 3 numbers}
    axis: 3 numbers or a mapping {name: 3 numbers}
    curve: the name of a curve
    roller: a number in m, optional
    side: outside, inside, left or right, optional
    speed: a number in m/s, optional
    reflected_inertia: a number in kg, optional
    limits: {displacement}, optional
    displacement: a number in m, optional
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        locations: Sequence[Vector] | Mapping[str, Any],
        axis: Vector | str | Mapping[str, Any],
        curve: str,
        roller: Quantity | None = ...,
        side: str | None = ...,
        speed: Quantity | None = ...,
        reflected_inertia: Quantity | None = ...,
        limits: Mapping[str, Any] | None = ...,
        displacement: Quantity | None = ...,
    ) -> None: ...

class Screw(ScenePart):
    """A screw joint of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    location: 3 numbers or a mapping {name: 3 numbers}
    axis: 3 numbers or a mapping {name: 3 numbers}
    pitch: a number in m
    speed: {angle, displacement}, optional
    reflected_inertia: {angle, displacement}, optional
    limits: {angle, displacement}, optional
    angle: a number in rad, optional
    displacement: a number in m, optional
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        location: Vector | Mapping[str, Any],
        axis: Vector | str | Mapping[str, Any],
        pitch: Quantity,
        speed: Mapping[str, Any] | None = ...,
        reflected_inertia: Mapping[str, Any] | None = ...,
        limits: Mapping[str, Any] | None = ...,
        angle: Quantity | None = ...,
        displacement: Quantity | None = ...,
    ) -> None: ...

class RollingWheel(ScenePart):
    """A rolling_wheel joint of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    plane: {location, normal}
    centre: 3 numbers or a mapping {name: 3 numbers}
    axis: 3 numbers or a mapping {name: 3 numbers}
    radius: a number in m
    speed: {displacement_x, displacement_y}, optional
    reflected_inertia: {displacement_x, displacement_y}, optional
    limits: {displacement_x, displacement_y}, optional
    displacement_x: a number in m, optional
    displacement_y: a number in m, optional
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        plane: Mapping[str, Any],
        centre: Vector | Mapping[str, Any],
        axis: Vector | str | Mapping[str, Any],
        radius: Quantity,
        speed: Mapping[str, Any] | None = ...,
        reflected_inertia: Mapping[str, Any] | None = ...,
        limits: Mapping[str, Any] | None = ...,
        displacement_x: Quantity | None = ...,
        displacement_y: Quantity | None = ...,
    ) -> None: ...

class RollingBall(ScenePart):
    """A rolling_ball joint of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    plane: {location, normal}
    centre: 3 numbers or a mapping {name: 3 numbers}
    radius: a number in m
    speed: {displacement_x, displacement_y}, optional
    reflected_inertia: {displacement_x, displacement_y}, optional
    limits: {displacement_x, displacement_y}, optional
    displacement_x: a number in m, optional
    displacement_y: a number in m, optional
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        plane: Mapping[str, Any],
        centre: Vector | Mapping[str, Any],
        radius: Quantity,
        speed: Mapping[str, Any] | None = ...,
        reflected_inertia: Mapping[str, Any] | None = ...,
        limits: Mapping[str, Any] | None = ...,
        displacement_x: Quantity | None = ...,
        displacement_y: Quantity | None = ...,
    ) -> None: ...

class RollingEllipsoid(ScenePart):
    """A rolling_ellipsoid joint of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    plane: {location, normal}
    centre: 3 numbers or a mapping {name: 3 numbers}
    axis: 3 numbers or a mapping {name: 3 numbers}
    x_axis: 3 numbers or a mapping {name: 3 numbers}
    semi_axes: 3 semi-axes
    speed: {displacement_x, displacement_y}, optional
    reflected_inertia: {displacement_x, displacement_y}, optional
    limits: {displacement_x, displacement_y}, optional
    displacement_x: a number in m, optional
    displacement_y: a number in m, optional
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        plane: Mapping[str, Any],
        centre: Vector | Mapping[str, Any],
        axis: Vector | str | Mapping[str, Any],
        x_axis: Vector | str | Mapping[str, Any],
        semi_axes: Vector,
        speed: Mapping[str, Any] | None = ...,
        reflected_inertia: Mapping[str, Any] | None = ...,
        limits: Mapping[str, Any] | None = ...,
        displacement_x: Quantity | None = ...,
        displacement_y: Quantity | None = ...,
    ) -> None: ...

class RollingOnLine(ScenePart):
    """A rolling_on_line joint of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    plane: {location, normal}
    centre: 3 numbers or a mapping {name: 3 numbers}
    axis: 3 numbers or a mapping {name: 3 numbers}
    radius: a number in m
    speed: {displacement, angle}, optional
    reflected_inertia: {displacement, angle}, optional
    limits: {displacement, angle}, optional
    displacement: a number in m, optional
    angle: a number in rad, optional
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        plane: Mapping[str, Any],
        centre: Vector | Mapping[str, Any],
        axis: Vector | str | Mapping[str, Any],
        radius: Quantity,
        speed: Mapping[str, Any] | None = ...,
        reflected_inertia: Mapping[str, Any] | None = ...,
        limits: Mapping[str, Any] | None = ...,
        displacement: Quantity | None = ...,
        angle: Quantity | None = ...,
    ) -> None: ...

class RollingOnCurve(ScenePart):
    """A rolling_on_curve joint of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    locations: 2 points or a mapping {name: 3 numbers}
    axis: 3 numbers or a mapping {name: 3 numbers}
    x_axis: 3 numbers or a mapping {name: 3 numbers}
    curve: the name of a curve
    roller: a number in m
    side: outside, inside, left or right, optional
    speed: {displacement, lap, angle}, optional
    reflected_inertia: {displacement, lap, angle}, optional
    limits: {displacement, lap, angle}, optional
    displacement: a number in m, optional
    lap: a number in rad, optional
    angle: a number in rad, optional
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        locations: Sequence[Vector] | Mapping[str, Any],
        axis: Vector | str | Mapping[str, Any],
        x_axis: Vector | str | Mapping[str, Any],
        curve: str,
        roller: Quantity,
        side: str | None = ...,
        speed: Mapping[str, Any] | None = ...,
        reflected_inertia: Mapping[str, Any] | None = ...,
        limits: Mapping[str, Any] | None = ...,
        displacement: Quantity | None = ...,
        lap: Quantity | None = ...,
        angle: Quantity | None = ...,
    ) -> None: ...

class KnifeEdge(ScenePart):
    """A knife_edge joint of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    location: 3 numbers or a mapping {name: 3 numbers}
    axis: 3 numbers or a mapping {name: 3 numbers}
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        location: Vector | Mapping[str, Any],
        axis: Vector | str | Mapping[str, Any],
    ) -> None: ...

class Rope(ScenePart):
    """A rope joint of a scene. Arguments are its keys:

    speed: a number in m/s, optional
    reflected_inertia: a number in kg, optional
    limits: {length}, optional
    length: a number in m, optional
    path: a list of places
    normal: 3 numbers
    frame: the name of a body, optional
    slack: true or false, optional
    free: true or false, optional
    restitution: a number, optional
    stiffness: a number in N/m, optional
    damping: a number in s/m, optional
    at most one of slack, stiffness
    at most one of free, length
    at most one of free, slack
    at most one of free, stiffness
    at most one of free, limits
    at most one of slack, limits
    at most one of stiffness, limits
    at most one of length, limits
    """

    def __init__(
        self,
        *,
        path: Sequence[Mapping[str, Any]],
        normal: Vector | str,
        speed: Quantity | None = ...,
        reflected_inertia: Quantity | None = ...,
        limits: Mapping[str, Any] | None = ...,
        length: Quantity | None = ...,
        frame: str | None = ...,
        slack: bool | None = ...,
        free: bool | None = ...,
        restitution: Quantity | None = ...,
        stiffness: Quantity | None = ...,
        damping: Quantity | None = ...,
    ) -> None: ...

class Gear(ScenePart):
    """A gear joint of a scene. Arguments are its keys:

    joints: 2 names of joints
    teeth: 2 numbers of teeth
    pressure_angle: a number in rad, optional
    """

    def __init__(
        self,
        *,
        joints: Sequence[str],
        teeth: Vector,
        pressure_angle: Quantity | None = ...,
    ) -> None: ...

class Rack(ScenePart):
    """A rack joint of a scene. Arguments are its keys:

    joints: 2 names of joints
    radius: a number in m
    """

    def __init__(
        self,
        *,
        joints: Sequence[str],
        radius: Quantity,
    ) -> None: ...

class Belt(ScenePart):
    """A belt joint of a scene. Arguments are its keys:

    joints: 2 names of joints
    radii: 2 radii
    """

    def __init__(
        self,
        *,
        joints: Sequence[str],
        radii: Vector,
    ) -> None: ...

class Geneva(ScenePart):
    """A geneva joint of a scene. Arguments are its keys:

    joints: 2 names of joints
    slots: a number
    """

    def __init__(
        self,
        *,
        joints: Sequence[str],
        slots: Quantity,
    ) -> None: ...

class Differential(ScenePart):
    """A differential joint of a scene. Arguments are its keys:

    joints: 3 names of joints
    """

    def __init__(
        self,
        *,
        joints: Sequence[str],
    ) -> None: ...

class Coupler(ScenePart):
    """A coupler joint of a scene. Arguments are its keys:

    of: weights of coordinates, as in {A.angle: 2, B: -1}
    function: a number or an expression of s or a list of rows or {rows, between}, optional
    constant: a number, optional
    pressure_angle: a number in rad, optional
    """

    def __init__(
        self,
        *,
        of: Mapping[str, Any],
        function: Quantity | Sequence[Sequence[Any]] | Mapping[str, Any] | None = ...,
        constant: Quantity | None = ...,
        pressure_angle: Quantity | None = ...,
    ) -> None: ...

class SpringDamper(ScenePart):
    """A spring_damper of a scene. Arguments are its keys:

    points: a mapping {name: 3 numbers}, optional
    bodies: 2 names of bodies, optional
    locations: 2 points or a mapping {name: 3 numbers}, optional
    stiffness: a number in N/m, optional
    damping: a number in N*s/m, optional
    free_length: a number in m, optional
    force: a number in N or an expression of t, l, l_dot, optional
    table: a list of rows or {rows, between}, optional
    one of points, bodies
    at most one of points, locations
    at most one of stiffness, force, table
    at most one of free_length, force
    at most one of free_length, table
    at most one of damping, force
    """

    def __init__(
        self,
        *,
        points: Mapping[str, Any] | None = ...,
        bodies: Sequence[str] | None = ...,
        locations: Sequence[Vector] | Mapping[str, Any] | None = ...,
        stiffness: Quantity | None = ...,
        damping: Quantity | None = ...,
        free_length: Quantity | None = ...,
        force: Quantity | None = ...,
        table: Sequence[Sequence[Any]] | Mapping[str, Any] | None = ...,
    ) -> None: ...

class TorsionSpringDamper(ScenePart):
    """A torsion_spring_damper of a scene. Arguments are its keys:

    joint: the name of a joint
    coordinate: angle, angle_1, angle_2 or lap, optional
    stiffness: a number in N*m/rad, optional
    damping: a number in N*m*s/rad, optional
    free_angle: a number in rad, optional
    torque: a number in N*m or an expression of t, angle, angle_dot, optional
    table: a list of rows or {rows, between}, optional
    at most one of stiffness, torque, table
    at most one of free_angle, torque
    at most one of free_angle, table
    at most one of damping, torque
    """

    def __init__(
        self,
        *,
        joint: str,
        coordinate: str | None = ...,
        stiffness: Quantity | None = ...,
        damping: Quantity | None = ...,
        free_angle: Quantity | None = ...,
        torque: Quantity | None = ...,
        table: Sequence[Sequence[Any]] | Mapping[str, Any] | None = ...,
    ) -> None: ...

class LinearSpringDamper(ScenePart):
    """A linear_spring_damper of a scene. Arguments are its keys:

    joint: the name of a joint
    coordinate: displacement, displacement_x, displacement_y, length, gap, displacement_1 or displacement_2, optional
    stiffness: a number in N/m, optional
    damping: a number in N*s/m, optional
    free_displacement: a number in m, optional
    force: a number in N or an expression of t, displacement, displacement_dot, optional
    table: a list of rows or {rows, between}, optional
    at most one of stiffness, force, table
    at most one of free_displacement, force
    at most one of free_displacement, table
    at most one of damping, force
    """

    def __init__(
        self,
        *,
        joint: str,
        coordinate: str | None = ...,
        stiffness: Quantity | None = ...,
        damping: Quantity | None = ...,
        free_displacement: Quantity | None = ...,
        force: Quantity | None = ...,
        table: Sequence[Sequence[Any]] | Mapping[str, Any] | None = ...,
    ) -> None: ...

class Bushing(ScenePart):
    """A bushing of a scene. Arguments are its keys:

    bodies: 2 names of bodies
    location: 3 numbers or a mapping {name: 3 numbers}
    axes: {axis, angle}, {quaternion}, {matrix} or {euler, sequence} or a mapping {name: {axis, angle}, {quaternion}, {matrix} or {euler, sequence}}, optional
    stiffness: {translation, rotation}, optional
    damping: {translation, rotation}, optional
    preload: {translation, rotation}, optional
    """

    def __init__(
        self,
        *,
        bodies: Sequence[str],
        location: Vector | Mapping[str, Any],
        axes: Mapping[str, Any] | None = ...,
        stiffness: Mapping[str, Any] | None = ...,
        damping: Mapping[str, Any] | None = ...,
        preload: Mapping[str, Any] | None = ...,
    ) -> None: ...

class Stop(ScenePart):
    """A stop of a scene. Arguments are its keys:

    points: a mapping {name: 3 numbers}, optional
    bodies: 2 names of bodies, optional
    locations: 2 points or a mapping {name: 3 numbers}, optional
    shortest: a number in m, optional
    longest: a number in m, optional
    plane: {body, location, normal}, optional
    point: {body, location}, optional
    radius: a number in m, optional
    axis: 3 numbers or a mapping {name: 3 numbers}, optional
    friction: a number or {coefficient, static, stribeck_speed}, optional
    rigid: true or false, optional
    exponent: a number, optional
    stiffness: a number in N/m, optional
    restitution: a number, optional
    damping: a number in s/m, optional
    one of points, bodies, plane
    at most one of points, locations
    at most one of plane, locations
    at most one of plane, shortest
    at most one of plane, longest
    at most one of points, point
    at most one of points, radius
    at most one of points, axis
    at most one of points, friction
    at most one of bodies, point
    at most one of bodies, radius
    at most one of bodies, axis
    at most one of bodies, friction
    one of stiffness, rigid
    at most one of exponent, rigid
    at most one of damping, rigid
    at most one of damping, restitution
    at most one of stiffness, friction
    """

    def __init__(
        self,
        *,
        points: Mapping[str, Any] | None = ...,
        bodies: Sequence[str] | None = ...,
        locations: Sequence[Vector] | Mapping[str, Any] | None = ...,
        shortest: Quantity | None = ...,
        longest: Quantity | None = ...,
        plane: Mapping[str, Any] | None = ...,
        point: Mapping[str, Any] | None = ...,
        radius: Quantity | None = ...,
        axis: Vector | str | Mapping[str, Any] | None = ...,
        friction: Quantity | Mapping[str, Any] | None = ...,
        rigid: bool | None = ...,
        exponent: Quantity | None = ...,
        stiffness: Quantity | None = ...,
        restitution: Quantity | None = ...,
        damping: Quantity | None = ...,
    ) -> None: ...

class Force(ScenePart):
    """A force of a scene. Arguments are its keys:

    body: the name of a body
    location: 3 numbers or a mapping {name: 3 numbers}, optional
    force: 3 components
    axes: global or body, optional
    """

    def __init__(
        self,
        *,
        body: str,
        force: Vector,
        location: Vector | Mapping[str, Any] | None = ...,
        axes: str | None = ...,
    ) -> None: ...

class Torque(ScenePart):
    """A torque of a scene. Arguments are its keys:

    body: the name of a body
    torque: 3 components
    axes: global or body, optional
    """

    def __init__(
        self,
        *,
        body: str,
        torque: Vector,
        axes: str | None = ...,
    ) -> None: ...

class Friction(ScenePart):
    """A friction of a scene. Arguments are its keys:

    joint: the name of a joint
    coefficient: a number or {angle, angle_1, angle_2, displacement, displacement_x, displacement_y, length, gap, displacement_1, displacement_2, lap}, optional
    coulomb: {torque, force or coefficient, ...} or {angle, displacement}, optional
    """

    def __init__(
        self,
        *,
        joint: str,
        coefficient: Quantity | Mapping[str, Any] | None = ...,
        coulomb: Mapping[str, Any] | None = ...,
    ) -> None: ...

class DcMotor(ScenePart):
    """A dc_motor of a scene. Arguments are its keys:

    joint: the name of a joint
    coordinate: angle, angle_1, angle_2 or lap, optional
    voltage: a number in V or an expression of t
    resistance: a number in ohm
    inductance: a number in H
    constant: a number in N*m/A
    gear: a number, optional
    friction: a number in N*m*s/rad, optional
    """

    def __init__(
        self,
        *,
        joint: str,
        voltage: Quantity,
        resistance: Quantity,
        inductance: Quantity,
        constant: Quantity,
        coordinate: str | None = ...,
        gear: Quantity | None = ...,
        friction: Quantity | None = ...,
    ) -> None: ...

class HydraulicCylinder(ScenePart):
    """A hydraulic_cylinder of a scene. Arguments are its keys:

    joint: the name of a joint, optional
    coordinate: displacement, displacement_x, displacement_y, length, gap, displacement_1 or displacement_2, optional
    points: a mapping {name: 3 numbers}, optional
    bodies: 2 names of bodies, optional
    locations: 2 points or a mapping {name: 3 numbers}, optional
    opening: a number or an expression of t
    supply: a number in Pa
    flow: a number in m^3/s
    drop: a number in Pa
    area: a number in m^2
    rod_side: a number in m^2, optional
    stroke: a number in m
    retracted: a number in m, optional
    dead_volume: a number in m^3
    bulk_modulus: a number in Pa
    leak: a number in m^3/(s*Pa), optional
    damping: a number in N*s/m, optional
    pressure_1: a number in Pa, optional
    pressure_2: a number in Pa, optional
    one of joint, points, bodies
    at most one of joint, locations
    at most one of points, locations
    """

    def __init__(
        self,
        *,
        opening: Quantity,
        supply: Quantity,
        flow: Quantity,
        drop: Quantity,
        area: Quantity,
        stroke: Quantity,
        dead_volume: Quantity,
        bulk_modulus: Quantity,
        joint: str | None = ...,
        coordinate: str | None = ...,
        points: Mapping[str, Any] | None = ...,
        bodies: Sequence[str] | None = ...,
        locations: Sequence[Vector] | Mapping[str, Any] | None = ...,
        rod_side: Quantity | None = ...,
        retracted: Quantity | None = ...,
        leak: Quantity | None = ...,
        damping: Quantity | None = ...,
        pressure_1: Quantity | None = ...,
        pressure_2: Quantity | None = ...,
    ) -> None: ...

class Maxwell(ScenePart):
    """A maxwell of a scene. Arguments are its keys:

    joint: the name of a joint, optional
    coordinate: displacement, displacement_x, displacement_y, length, gap, displacement_1 or displacement_2, optional
    points: a mapping {name: 3 numbers}, optional
    bodies: 2 names of bodies, optional
    locations: 2 points or a mapping {name: 3 numbers}, optional
    stiffness: a number in N/m
    damping: a number in N*s/m
    one of joint, points, bodies
    at most one of joint, locations
    at most one of points, locations
    """

    def __init__(
        self,
        *,
        stiffness: Quantity,
        damping: Quantity,
        joint: str | None = ...,
        coordinate: str | None = ...,
        points: Mapping[str, Any] | None = ...,
        bodies: Sequence[str] | None = ...,
        locations: Sequence[Vector] | Mapping[str, Any] | None = ...,
    ) -> None: ...

class TorsionMaxwell(ScenePart):
    """A torsion_maxwell of a scene. Arguments are its keys:

    joint: the name of a joint
    coordinate: angle, angle_1, angle_2 or lap, optional
    stiffness: a number in N*m/rad
    damping: a number in N*m*s/rad
    """

    def __init__(
        self,
        *,
        joint: str,
        stiffness: Quantity,
        damping: Quantity,
        coordinate: str | None = ...,
    ) -> None: ...

class PneumaticSpring(ScenePart):
    """A pneumatic_spring of a scene. Arguments are its keys:

    joint: the name of a joint, optional
    coordinate: displacement, displacement_x, displacement_y, length, gap, displacement_1 or displacement_2, optional
    points: a mapping {name: 3 numbers}, optional
    bodies: 2 names of bodies, optional
    locations: 2 points or a mapping {name: 3 numbers}, optional
    area: a number in m^2
    volume: a number in m^3
    pressure: a number in Pa
    ambient: a number in Pa
    exponent: a number, optional
    at: a number in m, optional
    damping: a number in N*s/m, optional
    one of joint, points, bodies
    at most one of joint, locations
    at most one of points, locations
    """

    def __init__(
        self,
        *,
        area: Quantity,
        volume: Quantity,
        pressure: Quantity,
        ambient: Quantity,
        joint: str | None = ...,
        coordinate: str | None = ...,
        points: Mapping[str, Any] | None = ...,
        bodies: Sequence[str] | None = ...,
        locations: Sequence[Vector] | Mapping[str, Any] | None = ...,
        exponent: Quantity | None = ...,
        at: Quantity | None = ...,
        damping: Quantity | None = ...,
    ) -> None: ...

class Servo(ScenePart):
    """A servo of a scene. Arguments are its keys:

    joint: the name of a joint
    coordinate: angle, angle_1, angle_2 or lap, optional
    position: a number in rad or an expression of t, optional
    speed: a number in rad/s or an expression of t, optional
    stiffness: a number in N*m/rad, optional
    damping: a number in N*m*s/rad
    max_speed: a number in rad/s, optional
    max_torque: a number in N*m, optional
    motor_constant: a number in N*m/W^0.5, optional
    one of position, speed
    one of stiffness, speed
    """

    def __init__(
        self,
        *,
        joint: str,
        damping: Quantity,
        coordinate: str | None = ...,
        position: Quantity | None = ...,
        speed: Quantity | None = ...,
        stiffness: Quantity | None = ...,
        max_speed: Quantity | None = ...,
        max_torque: Quantity | None = ...,
        motor_constant: Quantity | None = ...,
    ) -> None: ...

class LinearServo(ScenePart):
    """A linear_servo of a scene. Arguments are its keys:

    joint: the name of a joint, optional
    coordinate: displacement, displacement_x, displacement_y, length, gap, displacement_1 or displacement_2, optional
    points: a mapping {name: 3 numbers}, optional
    bodies: 2 names of bodies, optional
    locations: 2 points or a mapping {name: 3 numbers}, optional
    position: a number in m or an expression of t, optional
    speed: a number in m/s or an expression of t, optional
    stiffness: a number in N/m, optional
    damping: a number in N*s/m
    max_speed: a number in m/s, optional
    max_force: a number in N, optional
    motor_constant: a number in N/W^0.5, optional
    one of joint, points, bodies
    at most one of joint, locations
    at most one of points, locations
    one of position, speed
    one of stiffness, speed
    """

    def __init__(
        self,
        *,
        damping: Quantity,
        joint: str | None = ...,
        coordinate: str | None = ...,
        points: Mapping[str, Any] | None = ...,
        bodies: Sequence[str] | None = ...,
        locations: Sequence[Vector] | Mapping[str, Any] | None = ...,
        position: Quantity | None = ...,
        speed: Quantity | None = ...,
        stiffness: Quantity | None = ...,
        max_speed: Quantity | None = ...,
        max_force: Quantity | None = ...,
        motor_constant: Quantity | None = ...,
    ) -> None: ...

class SpeedTorque(ScenePart):
    """A speed_torque of a scene. Arguments are its keys:

    joint: the name of a joint
    coordinate: angle, angle_1, angle_2 or lap, optional
    torque: a number in N*m or an expression of t, speed
    command: a number or an expression of t, optional
    gear: a number, optional
    friction: a number in N*m*s/rad, optional
    motor_constant: a number in N*m/W^0.5, optional
    """

    def __init__(
        self,
        *,
        joint: str,
        torque: Quantity,
        coordinate: str | None = ...,
        command: Quantity | None = ...,
        gear: Quantity | None = ...,
        friction: Quantity | None = ...,
        motor_constant: Quantity | None = ...,
    ) -> None: ...
