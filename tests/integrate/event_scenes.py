"""Scenes whose laws change at a time or in a state."""

from __future__ import annotations

from math import atan, cos, pi, sin, sqrt

from mbproj.motion.simulate import simulate
from mbproj.scene.scene import read_scene_text
from mbproj.scene.settings import settings_to_run
from tests.support import Recorder, assembled

# Scenes whose laws have edges in the state, with what they do in closed form.

#: A mass that falls on a spring without a damper from a height above it, and bounces.
MASS, GRAVITY, STIFFNESS, HEIGHT = 2.0, 9.81, 5000.0, 0.5
BOUNCE = f"""
mbproj: 1
gravity: [0, 0, -{GRAVITY}]
bodies: {{ball: {{mass: {MASS}, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}}}}
joints: {{guide: {{type: prismatic, bodies: [ground, ball], location: [0, 0, 0], axis: [0, 0, 1]}}}}
forces: {{floor: {{type: spring_damper, points: {{ground: [0, 0, -10], ball: [0, 0, 0]}}, force: "LAW"}}}}
simulation: {{duration: 2 s, output_step: 0.1}}
"""
FLOOR = f"{STIFFNESS}*max(0, {10.0 - HEIGHT} - l)"
#: A door with a stop, of moment 4.7 kg m² about its hinge.
DOOR_INERTIA = 1.5 + 20.0 * 0.4**2
DOOR = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 3, output_step: 0.1}
bodies: {door: {mass: 20, inertia: [2, 2, 1.5], position: [0.4, 0, 0]}}
joints: {hinge: {type: revolute, bodies: [ground, door], location: [0, 0, 0], axis: [0, 0, 1], speed: 1 rad/s}}
markers: {handle: {body: door, location: [0.8, 0, 0]}}
forces:
  stop: {type: torsion_spring_damper, joint: hinge, torque: "-5000*max(0, angle - 0.5) - 0.2*sign(angle)"}
"""


def bounce(law: str = FLOOR) -> str:
    return BOUNCE.replace("LAW", law)


def contact_times(count: int) -> list[float]:
    """When the mass meets the spring, leaves it, meets it again, and so on."""
    fall, speed, omega = sqrt(2.0 * HEIGHT / GRAVITY), sqrt(2.0 * GRAVITY * HEIGHT), sqrt(STIFFNESS / MASS)
    contact = 2.0 * (pi - atan(speed * omega / GRAVITY)) / omega
    times = [fall]
    while len(times) < count:
        times.append(times[-1] + (contact if len(times) % 2 else 2.0 * fall))
    return times


def height_at(t: float) -> float:
    """Where the mass is, m."""
    fall, speed, omega = sqrt(2.0 * HEIGHT / GRAVITY), sqrt(2.0 * GRAVITY * HEIGHT), sqrt(STIFFNESS / MASS)
    contact = 2.0 * (pi - atan(speed * omega / GRAVITY)) / omega
    since = (t + fall) % (2.0 * fall + contact)
    if since <= 2.0 * fall:
        return -0.5 * GRAVITY * (since - fall) ** 2
    s = since - 2.0 * fall
    return -HEIGHT - GRAVITY / omega**2 * (1.0 - cos(omega * s)) - speed / omega * sin(omega * s)


def door_times() -> tuple[float, float, float]:
    """When the door meets its stop, leaves it, and passes 0: constant torques, and an oscillation about where the stop
    and the constant torque balance."""
    slow, omega = 0.2 / DOOR_INERTIA, sqrt(5000.0 / DOOR_INERTIA)
    meets = (1.0 - sqrt(1.0 - slow)) / slow
    speed = 1.0 - slow * meets
    leaves = meets + 2.0 * atan(speed * omega / slow) / omega
    return meets, leaves, leaves + (sqrt(speed**2 + slow) - speed) / slow


# Scenes whose forces and motions begin, end or jump at known times.

#: A rotor that turns freely about the y axis by a torque: I θ'' = τ.
INERTIA = 0.5
ROTOR = """
mbproj: 1
gravity: [0, 0, 0]
bodies: {rotor: {mass: 1, inertia: [0.3, 0.5, 0.4], position: [0, 0, 0]}}
joints: {pin: {type: revolute, bodies: [ground, rotor], location: [0, 0, 0], axis: [0, 1, 0]}}
forces: {push: {type: torsion_spring_damper, joint: pin, torque: "TORQUE"}}
simulation: {duration: 2 s}
"""
#: A trolley with a load that hangs from it at rest until the trolley moves.
TROLLEY = """
mbproj: 1
gravity: [0, 0, -9.81]
bodies:
  trolley: {mass: 10, inertia: [1, 1, 1], position: [0, 0, 0]}
  load: {mass: 5, inertia: [0.01, 0.01, 0.01], position: [0, 0, -2]}
joints:
  rail: {type: prismatic, bodies: [ground, trolley], location: [0, 0, 0], axis: [1, 0, 0]}
  hook: {type: revolute, bodies: [trolley, load], location: [0, 0, 0], axis: [0, 1, 0]}
motions: {move: {joint: rail, displacement: {smooth_step: {to: 0.5, start: 3, duration: 0.2}}}}
markers: {load: {body: load, location: [0, 0, -2]}}
simulation: {duration: 10 s, tolerance: 1.0e-8, integrator: dop853, output_step: 1}
"""


def rotor(torque: str) -> str:
    return ROTOR.replace("TORQUE", torque)


class Log(Recorder):
    """A recorder that keeps the events, too."""

    def events(self, events) -> None:
        self.met = list(events)


def run(text: str, **options: str):
    """(recorder, report) of a scene with these options of the command line."""
    scene = read_scene_text(text, simulation=options)
    recorder = Log()
    report = simulate(*assembled(scene), settings_to_run(scene), recorder)
    return recorder, report
