"""Whipple's bicycle, with the numbers of the benchmark (Meijaard, Papadopoulos, Ruina and Schwab 2007, table 1)."""

from __future__ import annotations

from tests.rolling import scenes

#: Eigenvalues in 1/s of lean and steer by the speed in m/s (their table 2): weave, one of a pair, capsize, castering.
EIGENVALUES = {
    0.0: (-5.53094371765393, -3.13164324790656, 3.13164324790656, 5.53094371765393),
    1.0: (3.52696170990070 + 0.80774027519930j, -3.13423125066578, -7.11008014637442),
    2.0: (2.68234517512745 + 1.68066296590675j, -3.07158645641514, -8.67387984831735),
    3.0: (1.70675605663975 + 2.31582447384325j, -2.63366137253667, -10.35101467245920),
    4.0: (0.41325331521125 + 3.07910818603206j, -1.42944427361326, -12.15861426576447),
    5.0: (-0.77534188219585 + 4.46486771378823j, -0.32286642900409, -14.07838969279822),
    6.0: (-1.52644486584142 + 5.87673060598709j, -0.00406690076970, -16.08537123098026),
    7.0: (-2.13875644258362 + 7.19525913329805j, 0.10268170574766, -18.15788466125262),
    8.0: (-2.69348683581097 + 8.46037971396931j, 0.14327879765713, -20.27940894394569),
    9.0: (-3.21675402252485 + 9.69377351531791j, 0.15790184030917, -22.43788559040858),
    10.0: (-3.72016840437287 + 10.90681139476287j, 0.16105338653172, -24.62459635017404),
}
#: The speeds in m/s from which weave dies out, and from which capsize grows.
WEAVE, CAPSIZE = 4.292382536341, 6.024262015388


def bicycle(speed: float, **simulation: object) -> str:
    """Upright and straight ahead; the paper's z is down, ours up."""
    moves = f"velocity: [{speed!r}, 0, 0]"

    def turning(radius: float) -> str:
        return f"{moves}, angular_velocity: [0, {speed / radius!r}, 0]"

    bodies = (
        f"  rear: {{mass: 2, inertia: [0.0603, 0.12, 0.0603], position: [0, 0, 0.3], {turning(0.3)}}}\n"
        "  frame: {mass: 85, inertia: [[9.2, 0, -2.4], [0, 11, 0], [-2.4, 0, 2.8]], position: [0.3, 0, 0.9], "
        f"{moves}}}\n"
        "  fork: {mass: 4, inertia: [[0.05892, 0, 0.00756], [0, 0.06, 0], [0.00756, 0, 0.00708]], "
        f"position: [0.9, 0, 0.7], {moves}}}\n"
        f"  front: {{mass: 3, inertia: [0.1405, 0.28, 0.1405], position: [1.02, 0, 0.35], {turning(0.35)}}}"
    )
    joints = (
        "  axle: {type: revolute, bodies: [frame, rear], location: [0, 0, 0.3], axis: [0, 1, 0]}\n"
        "  head: {type: revolute, bodies: [frame, fork], location: [1.1, 0, 0], axis: [-sin(18 deg), 0, cos(18 deg)]}\n"
        "  hub: {type: revolute, bodies: [fork, front], location: [1.02, 0, 0.35], axis: [0, 1, 0]}\n"
        f"{scenes.wheel('rear', '[0, 0, 0.3]', '[0, 1, 0]', 0.3)}\n"
        f"{scenes.wheel('front', '[1.02, 0, 0.35]', '[0, 1, 0]', 0.35)}"
    )
    return scenes.scene(bodies, joints, **simulation)
