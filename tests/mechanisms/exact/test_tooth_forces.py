"""What bearings carry of the forces between teeth: spur wheels outside and inside, against statics; what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import InputError
from tests.kernel.scenes import needs_kernel
from tests.stops.runs import DOP853, run

pytestmark = needs_kernel
#: Wheels of 20 and 30 teeth at a distance of 0.1 m: pitch radii 40 and 60 mm. The first turns steadily.
WHEELS = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {SETTINGS, duration: 0.2}
bodies:
  one: {mass: 1, inertia: [1.0e-3, 1.0e-3, 1.0e-3], position: [0, 0, 0]}
  two: {mass: 1, inertia: [1.0e-3, 1.0e-3, 1.0e-3], position: [FAR, 0, 0]}
joints:
  A: {type: revolute, bodies: [ground, one], location: [0, 0, 0], axis: [0, 0, 1]}
  B: {type: revolute, bodies: [ground, two], location: [FAR, 0, 0], axis: [0, 0, 1]}
  G: {type: gear, joints: [A, B], teeth: [20, SECOND], pressure_angle: 20 deg}
motions: {drive: {joint: A, angle: {constant_speed: 2 rad/s}}}
forces: {load: {type: torsion_spring_damper, joint: B, torque: LOAD}}
""".replace("SETTINGS", DOP853)


@pytest.mark.parametrize(
    "gear", ["{type: gear, joints: [A, B], teeth: [20, SECOND]", "{type: coupler, of: {A: 2, B: SECOND/10}"]
)
@pytest.mark.parametrize("load", [6.0, -6.0])
@pytest.mark.parametrize(("second", "far", "radius"), [(30, 0.1, 0.06), (-30, 0.02, 0.06)])
def test_bearings_carry_the_teeth(second, far, radius, load, gear):
    """F_t = τ/r across the line of centres; F_t tan 20 deg pushes wheels apart, and the wheel inside a ring inwards."""
    text = WHEELS.replace("{type: gear, joints: [A, B], teeth: [20, SECOND]", gear)
    text = text.replace("FAR", f"{far}").replace("SECOND", f"{second}").replace("LOAD", f"{load}")
    _, found = run(text)
    pitch = 0.04 if second > 0 else -0.04
    tangent = -load / (pitch - far)  # the teeth turn the second wheel against its load
    aside = abs(tangent) * np.tan(np.radians(20.0)) * (1.0 if second > 0 else -1.0)
    on_second = np.array([aside, tangent, 0.0])
    assert abs(abs(tangent) - abs(load) / radius) < 1e-9
    force = found["joints/reaction_force"]
    np.testing.assert_allclose(force[:, 2], np.tile(on_second, (len(force), 1)), atol=1e-9)
    np.testing.assert_allclose(force[:, 1], -force[:, 2], atol=1e-9)
    np.testing.assert_allclose(force[:, 0], force[:, 2], atol=1e-9)
    # the wheels are in balance: no torque is left for the bearings
    np.testing.assert_allclose(found["joints/reaction_torque"][:, :2], 0.0, atol=1e-9)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("location: [FAR, 0, 0], axis: [0, 0, 1]", "location: [FAR, 0, 0], axis: [0, 1, 0]", "are not parallel"),
        ("pressure_angle: 20 deg", "pressure_angle: 70 deg", "is no pressure angle"),
        ("gear, joints: [A, B], teeth: [20, SECOND]", "coupler, of: {A: 20}", "is not a sum of two angles"),
        (
            "gear, joints: [A, B], teeth: [20, SECOND]",
            "coupler, of: {A: 20, B: 30}, function: 0.1*sin(s)",
            "is not a sum of two angles",
        ),
        ("bodies: [ground, two]", "bodies: [two, ground]", "the ground is the second body of joint 'B'"),
        (
            "forces: {",
            "forces: {rubs: {type: friction, joint: A, coulomb: {coefficient: 0.1, radius: 5 mm}}, ",
            "friction 'rubs' depends on the load of joint 'A' without forces of teeth",
        ),
    ],
)
def test_what_is_refused(old, new, message):
    text = WHEELS.replace(old, new).replace("FAR", "0.1").replace("SECOND", "30").replace("LOAD", "6")
    with pytest.raises(InputError) as caught:
        run(text)
    assert message in str(caught.value)
    assert "pressure_angle" in str(caught.value)
