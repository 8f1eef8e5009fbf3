"""The mechanisms that programs are compared on: scenes, what is watched of them, and their exact motions."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from math import cos, pi, radians, sin
from pathlib import Path
from typing import Any

import numpy as np

from mbproj import compile_system, read_scene, read_scene_text
from mbproj.functions.plane_curve import CamFollower, Rise, of_law
from mbproj.scene.scene import Scene

from .by_hand import by_dop853, by_gauss, solved
from .by_mbproj import programs
from .compiled import NoCompiler
from .exact import PI, Real, angle_of, axis_of_top
from .lagrange import FourBar, Governor
from .problem import Array, Equations, Hand, Problem, Rattled
from .stiff_scenes import CASES
from .stiff_scenes import chain as sprung_chain

ROOT = Path(__file__).parents[2]
MECHANISMS = ROOT / "mechanisms"
EXPLICIT = {name: {"integrator": name.lower()} for name in ("RK4", "DOPRI5", "DOP853")}
IMPLICIT = {name: {"integrator": name} for name in ("radau5", "esdirk4", "auto", "dop853")}
ROWS = {
    f"{name}{', energy row' * row}": {"integrator": name.lower(), "energy": row}
    for name in ("RK4", "DOP853")
    for row in (False, True)
}
#: A reference that is less certain is none, m or rad.
UNCERTAIN = 1e-4
Exact = Callable[[Array], tuple[Array, float]]


def _table(name: str, *columns: str) -> Exact:
    """A table of tests/data, whose rows are half seconds apart; "" is a coordinate that is not compared."""
    table = np.genfromtxt(ROOT / "tests" / "data" / name, delimiter=",", names=True)

    def exact(times: Array) -> tuple[Array, float]:
        rows = np.searchsorted(table["t"], times - 1e-9)
        assert np.abs(table["t"][rows] - times).max() < 1e-9
        values = [table[column][rows] if column else np.full(len(rows), np.nan) for column in columns]
        return np.stack(values, axis=-1)[:, None], 0.0

    return exact


# --- The paper's mechanisms, and chains -------------------------------------------------------------------------------


def five_bar() -> Problem:
    return Problem(
        title="Five-bar pendulum, largest tip error up to 5 s",
        scene=read_scene(MECHANISMS / "five_bar.yaml"),
        end=5.0,
        samples=10,
        watch=("tip",),
        exact=_table("five_bar.csv", "tip_x", "", "tip_z"),
        errors=(1e-3, 1e-5, 1e-7, 1e-9),
        mbproj=EXPLICIT,
        hand=_chain_by_hand(5, 1.01 / 12, 9.8, pi / 2, 0.0),
    )


def spatial_slider_crank() -> Problem:
    start, inertia, _ = _slider_crank()

    def watched(y: Array) -> Array:
        turned = y[..., 0]
        a, b = 0.1 - 0.08 * np.sin(turned), 0.12 + 0.08 * np.cos(turned)
        return np.stack([np.sqrt(0.09 - a * a - b * b), 0.0 * a, 0.0 * a], axis=-1)[..., None, :]

    return Problem(
        title="Spatial slider-crank, largest slider error up to 10 s",
        scene=read_scene(MECHANISMS / "spatial_slider_crank.yaml"),
        end=10.0,
        samples=20,
        watch=("slider",),
        exact=_table("slider_crank_comA.csv", "slider_x", "", ""),
        errors=(1e-3, 1e-4, 1e-5, 1e-7, 1e-9),
        mbproj=EXPLICIT,
        hand=Hand(1, (0.0,), (float(start), float(inertia(start) * 6)), watched),
    )


#: Equations by hand have dense matrices: beyond so many links they bound nothing.
DENSE = 20


def chain_text(links: int) -> str:
    """The scene of a planar chain of bars of 1 m, level along x, at rest."""
    bar = f"mass: 1, inertia: [{0.01 / 6!r}, {1.01 / 12!r}, {1.01 / 12!r}]"
    lines = ["mbproj: 1", "gravity: [0, 0, -9.8]", "bodies:"]
    lines += [f"  b{k}: {{{bar}, position: [{k + 0.5}, 0, 0]}}" for k in range(links)]
    lines += ["joints:"]
    for k in range(links):
        pair = f"[{f'b{k - 1}' if k else 'ground'}, b{k}]"
        lines.append(f"  j{k}: {{type: revolute, bodies: {pair}, location: [{k}, 0, 0], axis: [0, 1, 0]}}")
    return "\n".join([*lines, "markers:", f"  tip: {{body: b{links - 1}, location: [{links}, 0, 0]}}"]) + "\n"


def chain(links: int) -> Problem:
    """Steps of a tenth of a radian of the highest frequency of small oscillations about the hanging chain."""
    n, across = np.arange(links), 1.01 / 12
    coupling = links - 0.5 - np.maximum.outer(n, n)
    coupling[n, n] = across + links - 0.75 - n
    stiffness = np.sqrt(9.8 * (links - 0.5 - n))
    step = 0.1 / np.sqrt(np.linalg.eigvalsh(stiffness[:, None] * np.linalg.inv(coupling) * stiffness)[-1])
    count = {5: 200, 20: 200, 100: 100, 500: 20}.get(links, max(20, 10_000 // links))
    hand = _chain_by_hand(links, across, 9.8, pi / 2, 0.0)

    def exact(times: Array) -> tuple[Array, float]:
        """By DOP853 at 1e-12 of the equations by hand; unknown without a compiler."""
        try:
            return hand.watched(by_dop853(hand, float(times[-1]), 1e-12)[None]), 1e-12
        except NoCompiler:
            return np.full((1, 1, 3), np.nan), np.nan

    return Problem(
        title=f"Planar chain of {links} links, level from rest, {count} steps of {1e3 * step:.2g} ms",
        scene=read_scene_text(chain_text(links)),
        end=float(count * step),
        samples=1,
        watch=("tip",),
        exact=exact,
        errors=(),
        mbproj={"RK4": EXPLICIT["RK4"]},
        tried={"": (float(step),)},
        hand=hand if links <= DENSE else None,
    )


def _chain_by_hand(bars: int, J: float, g: float, start: float, down: float) -> Hand:
    """Bars in a row from rest, all at `start` rad from hanging; that is `down` rad from the -z axis."""
    way, side = np.array([sin(down), 0.0, -cos(down)]), np.array([cos(down), 0.0, sin(down)])

    def watched(y: Array) -> Array:
        θ = y[..., :bars]
        tip = np.cos(θ).sum(axis=-1)[..., None] * way + np.sin(θ).sum(axis=-1)[..., None] * side
        return tip[..., None, :]

    return Hand(3, (bars, J, g), (*[start] * bars, *[0.0] * bars), watched)


# --- Stiff mechanisms -------------------------------------------------------------------------------------------------


def four_bar(k: float) -> Problem:
    """That of `mechanisms/split_coupler.yaml` with k in N/m; MuJoCo has a planar joint with springs for the bushing,
    and a ball for the pin that closes the loop. That differs by the square of the bushing's deflection: its frame is
    the near half's, and not midway between both."""
    text = (MECHANISMS / "split_coupler.yaml").read_text(encoding="utf-8").partition("expect:")[0]
    text = f"{text.rstrip()}\n  end: {{body: rocker, location: [end_x, 0, end_z]}}\n"
    before, _, after = text.partition("forces:\n")
    bushing = (
        "  rubber: {type: planar, bodies: [near_half, far_half], location: [middle_x, 0, middle_z], axis: [0, -1, 0],\n"
        "    x_axis: [cos(tilt), 0, sin(tilt)], speed: {angle: 0}}\n"
        "forces:\n"
        "  along: {type: linear_spring_damper, joint: rubber, coordinate: displacement_x,\n"
        "    stiffness: along / softness, damping: 20 N*s/m}\n"
        "  across: {type: linear_spring_damper, joint: rubber, coordinate: displacement_y,\n"
        "    stiffness: transverse / softness, damping: 10 N*s/m}\n"
        "  bends: {type: torsion_spring_damper, joint: rubber, stiffness: bending / softness, damping: 0.02}\n"
    )
    pin = "    type: revolute\n    bodies: [far_half, rocker]\n    location: [end_x, 0, end_z]\n"
    ball = "    type: spherical\n    bodies: [far_half, rocker]\n    location: [end_x, 0, end_z]\n"
    rest = "    axis: [0, -1, 0]\n    speed: rocker_speed - coupler_speed\n"
    assert pin + rest in before
    springs = f"{before.replace(pin + rest, ball)}{bushing}markers:{after.partition('markers:')[2]}"
    given = {"softness": str(1e5 / k)}
    title = f"Four-bar whose coupler a bushing of {k:.0e} N/m holds together"
    scenes = [read_scene_text(each, parameters=given) for each in (text, springs)]
    return _stiff(title, scenes[0], scenes[1], ("middle", "end"), FourBar(k))


def governor(k: float) -> Problem:
    """That of `mechanisms/governor.yaml` with k in N/m; MuJoCo has the spring on the coordinate of the collar."""
    path = MECHANISMS / "governor.yaml"
    given = {"stiffness": str(k), "damping": str(1e-3 * k)}
    before, _, after = path.read_text(encoding="utf-8").partition("expect:")[0].partition("forces:\n")
    force = "forces: {spring: {type: linear_spring_damper, joint: collar, stiffness: stiffness, damping: damping}}\n"
    springs = f"{before}{force}markers:{after.partition('markers:')[2]}"
    title = f"Flyball governor with a spring of {k:.0e} N/m"
    scenes = read_scene(path, given), read_scene_text(springs, parameters=given)
    return _stiff(title, *scenes, ("ball", "collar"), Governor(k))


def _stiff(title: str, scene: Scene, springs: Scene, watch: tuple[str, ...], equations: Equations) -> Problem:
    def exact(times: Array) -> tuple[Array, float]:
        """By another method than all that are compared."""
        return equations.watched(solved(equations, times, 1e-11, 1e-13, "DOP853")[1]), 1e-10

    return Problem(
        title=f"{title}, 0.2 s",
        scene=scene,
        end=0.2,
        samples=10,
        watch=watch,
        exact=exact,
        errors=(1e-3, 1e-4, 1e-5, 1e-6, 1e-7),
        mbproj=IMPLICIT,
        coarsest=0.02,
        mujoco=("discrete", "implicit", "implicitfast"),
        by_coordinates=springs,
        equations=equations,
    )


def integrators(case: str, k: float, until: float = 0.2) -> Problem:
    """A stiff mechanism of `stiff_scenes.py` at a dial: mbproj's own integrators, against radau5 at 1e-10."""
    scene = CASES[case](k)
    coordinates = tuple(compile_system(scene).names.coordinates)
    methods = {name: {"integrator": name} for name in ("esdirk4", "radau5", "dop853")}

    def exact(times: Array) -> tuple[Array, float]:
        """Certain to what esdirk4 is off."""
        fine = {name: {"integrator": name, "tolerance": 1e-10} for name in ("radau5", "esdirk4")}
        first, second = (
            next(program.settings()).run(times).watched for program in programs(replace(problem, mbproj=fine))
        )
        return first, float(np.abs(first - second).max())

    problem = Problem(
        title=f"{case}, {k:.0e}, {until:g} s",
        scene=scene,
        end=until,
        samples=10,
        watch=coordinates,
        exact=exact,
        errors=(1e-3, 1e-5),
        mbproj=methods,
        unit="m or rad",
        alone=True,
    )
    return problem


def springs(links: int) -> Problem:
    """What a step of chains of stiff torsion springs costs, by their links."""
    problem, scene = integrators("chain", 1e6), sprung_chain(1e6, links)
    watch = tuple(compile_system(scene).names.coordinates)
    given = {name: {"integrator": name, "tolerance": 1e-4} for name in ("esdirk4", "radau5")}
    unknown = np.full((1, len(watch), 3), np.nan)
    title = f"Chain of {links} links with springs of 1e6 N m/rad, 0.05 s"
    return replace(
        problem, title=title, scene=scene, watch=watch, samples=1, end=0.05, mbproj=given, errors=(),
        exact=lambda times: (unknown, np.nan),
    )  # fmt: skip


# --- Dry friction, and contact ----------------------------------------------------------------------------------------


def _rubbing(title: str, unit: str, joint: str, friction: str, spring: str, inertia: float, rest: float) -> Problem:
    body = f"{{mass: {inertia}, inertia: [{inertia}, {inertia}, {inertia}], position: [0, 0, 0]}}"
    scene = f"""mbproj: 1
gravity: [0, 0, 0]
bodies: {{b: {body}}}
joints: {{j: {{{joint}, bodies: [ground, b], location: [0, 0, 0], axis: [0, 0, 1]}}}}
forces:
  dry: {{type: friction, joint: j, coulomb: {{{friction}}}}}
{spring}"""
    coordinate = "angle" if unit == "rad" else "displacement"
    return Problem(
        title=f"{title}: rests at {rest:g} {unit} after 2 s",
        scene=read_scene_text(scene),
        end=2.0,
        samples=1,
        watch=(f"j.{coordinate}",),
        exact=lambda times: (np.array([[[rest, np.nan, np.nan]]]), 0.0),
        errors=(),
        mbproj={
            "dopri5, tol = 1e-6": {"integrator": "dopri5", "tolerance": 1e-6},
            "dop853, tol = 1e-10": {"integrator": "dop853", "tolerance": 1e-10},
            "rk4, h = 10 ms": {"integrator": "rk4", "step": 0.01},
        },
        tried={"": (1e-2, 1e-3, 1e-4)},
        unit=unit,
        mujoco=("implicitfast",),
    )


def brake() -> Problem:
    """A brake of 4 N m stops a rotor of 0.5 kg m² from 10 rad/s."""
    joint = "type: revolute, angle: 0 rad, speed: 10 rad/s"
    return _rubbing("Rotor and brake", "rad", joint, "torque: 4 N*m", "", 0.5, 6.25)


def oscillator() -> Problem:
    """1 kg on 100 N/m comes to rest beside its equilibrium by a dry friction of 2 N."""
    joint = "type: prismatic, displacement: 0.09 m, speed: 0 m/s"
    spring = "  spring: {type: linear_spring_damper, joint: j, stiffness: 100}\n"
    return _rubbing("Oscillator with dry friction", "m", joint, "force: 2 N", spring, 1.0, 0.01)


VALVE_STEPS = (1e-4, 5e-5, 2.5e-5)
#: Corners of MuJoCo's mesh of the cam.
CORNERS = (720, 2880)


def valve_train(cylinders: int) -> Problem:
    """The lift of the valve of `mechanisms/valve_train.yaml`'s kind: a cam, the roller of a rocker, its tip on a valve,
    a spring. mbproj holds both contacts as joints, or lets them open; MuJoCo has a mesh for the cam, spheres for roller
    and tip, and soft contacts, stiff by a time constant of two steps. The reference is mbproj's at a tolerance of
    1e-11. Several cylinders on one shaft are for mbproj alone."""
    held, free = (read_scene_text(valve_text(cylinders, held=how)) for how in (True, False))
    methods = {
        f"{how}, {name}, tol = {tolerance:.0e}": {"integrator": name, "tolerance": tolerance, "scene": scene}
        for how, scene in (("held", held), ("contacts", free))[: 2 if cylinders == 1 else 1]
        for name, tolerance in (("dopri5", 1e-5), ("dopri5", 1e-4), ("bs32", 1e-3))
    }

    def exact(times: Array) -> tuple[Array, float]:
        settings = {"integrator": "dop853", "tolerance": 1e-11}
        (one,) = programs(_valve({"": settings}, held, exact, 1))
        (finest,) = one.settings()
        return finest.run(times).watched, 1e-10

    return _valve(methods, held, exact, cylinders)


def _valve(methods: Mapping[str, Mapping[str, object]], scene: Scene, exact: Exact, cylinders: int) -> Problem:
    return Problem(
        title=f"Valve train of {cylinders}, largest error of the lift over 0.5 s",
        scene=scene,
        end=0.5,
        samples=100,
        watch=("guide0.displacement",),
        exact=exact,
        errors=(),
        mbproj=methods,
        tried={"": VALVE_STEPS},
        mujoco=("implicitfast",) if cylinders == 1 else (),
        contacts=True,
        mjcf=_valve_mjcf,
    )


def valve_text(cylinders: int, *, held: bool) -> str:
    """So many cylinders along the shaft, each cam turned against the one before."""
    blocks = {
        "bodies": "  shaft: {mass: 2, inertia: [0.01, 0.01, 0.01], position: [0, 0, 0]}\n",
        "joints": (
            "  axle: {type: revolute, bodies: [ground, shaft], location: [0, 0, 0], axis: [0, -1, 0], "
            "speed: 200 rad/s}\n"
        ),
        "forces": "",
    }
    on_cam, on_valve = ("cam", "flat_follower") if held else ("cam_contact", "flat_contact")
    limit = "" if held else ", limits: {gap: {range: [0, null], rigid: true, restitution: 0}}"
    for k in range(cylinders):
        y, turn = 0.05 * k, 2.0 * np.pi * k / cylinders
        x_axis = f"[{float(-np.sin(turn))!r}, 0, {float(np.cos(turn))!r}]"
        blocks["bodies"] += (
            f"  rocker{k}: {{mass: 0.12, inertia: [6.0e-5, 6.0e-5, 6.0e-5], position: [0.04, {y}, 0.028]}}\n"
            f"  valve{k}: {{mass: 0.1, inertia: [1.0e-5, 1.0e-5, 1.0e-5], position: [0.08, {y}, 0.022]}}\n"
        )
        blocks["joints"] += (
            f"  pivot{k}: {{type: revolute, bodies: [ground, rocker{k}], location: [0.04, {y}, 0.028], axis: y}}\n"
            f"  guide{k}: {{type: prismatic, bodies: [ground, valve{k}], location: [0.08, {y}, 0], axis: -z}}\n"
            f"  on_cam{k}: {{type: {on_cam}, bodies: [shaft, rocker{k}], curve: cam, axis: -y, x_axis: {x_axis}, "
            f"locations: [[0, {y}, 0], [0, {y}, 0.028]]{limit}}}\n"
            f"  on_valve{k}: {{type: {on_valve}, bodies: [rocker{k}, valve{k}], curve: tip, axis: -y, x_axis: z, "
            f"locations: [[0.08, {y}, 0.028], [0.08, {y}, 0.022]], normal: [0, 0, -1]{limit}}}\n"
        )
        blocks["forces"] += (
            f"  spring{k}: {{type: linear_spring_damper, joint: guide{k}, stiffness: 20 kN/m, "
            "free_displacement: -7.5 mm}\n"
        )
    head = """mbproj: 1
gravity: [0, 0, -9.81]
curves:
  cam: {roller: 10 mm, clockwise: true, lift: {base: 18 mm, rises: [[120 deg, 0 m, dwell],
        [75 deg, 5 mm, cycloidal], [75 deg, 0 m, cycloidal], [90 deg, 0 m, dwell]]}}
  tip: {circle: 6 mm}
"""
    return head + "".join(f"{name}:\n{lines}" for name, lines in blocks.items())


def _valve_mjcf(step: float) -> Iterator[tuple[str, str]]:
    dwell, rise = (np.radians(120.0), np.radians(90.0)), np.radians(75.0)
    rises = [Rise(dwell[0], 0.0, "dwell"), Rise(rise, 5e-3, "cycloidal"), Rise(rise, 0.0, "cycloidal")]
    line = of_law(18e-3, [*rises, Rise(dwell[1], 0.0, "dwell")], CamFollower("roller", 10e-3), clockwise=True)
    for corners in CORNERS:
        s = np.linspace(line.start, line.end, corners, endpoint=False)
        (x, y), (x1, y1), *_ = line.derivatives(s, line.at(s))
        speed = np.hypot(x1, y1)
        u, w = (x - 10e-3 * y1 / speed).tolist(), (y + 10e-3 * x1 / speed).tolist()
        mesh = " ".join(f"{-b!r} {h} {a!r}" for h in (-0.004, 0.004) for a, b in zip(u, w, strict=True))
        yield (
            f", {corners} corners",
            f"""<mujoco>
  <option gravity="0 0 -9.81" iterations="50" tolerance="1e-10"/>
  <default><geom solref="{2.0 * step!r} 1" solimp="0.99 0.9999 1e-5" condim="1" mass="0"/></default>
  <asset><mesh name="cam" vertex="{mesh}" inertia="shell"/></asset>
  <worldbody>
    <body>
      <inertial pos="0 0 0" mass="2" diaginertia="0.01 0.01 0.01"/>
      <joint type="hinge" axis="0 -1 0"/>
      <geom type="mesh" mesh="cam" contype="1" conaffinity="0"/>
    </body>
    <body pos="0.04 0 0.028">
      <inertial pos="0 0 0" mass="0.12" diaginertia="6e-5 6e-5 6e-5"/>
      <joint type="hinge" axis="0 1 0"/>
      <geom type="sphere" size="0.01" pos="-0.04 0 0" contype="0" conaffinity="1"/>
      <geom type="sphere" size="0.006" pos="0.04 0 0" contype="2" conaffinity="0"/>
    </body>
    <body pos="0.08 0 0.022">
      <inertial pos="0 0 0" mass="0.1" diaginertia="1e-5 1e-5 1e-5"/>
      <joint name="guide0" type="slide" axis="0 0 -1" stiffness="20000" springref="-0.0075"/>
      <geom type="box" size="0.01 0.01 0.005" pos="0 0 -0.005" contype="0" conaffinity="2"/>
    </body>
  </worldbody>
  <keyframe><key qvel="200 0 0"/></keyframe>
</mujoco>""",
        )


# --- Long motions -----------------------------------------------------------------------------------------------------


def _angle(angle: Array | float, shift: float = 0.0) -> Array:
    """A crank's angle as what is watched."""
    value = np.asarray(angle) - shift
    return np.stack([value, 0.0 * value, 0.0 * value], axis=-1)[..., None, :]


def _ends(where: Callable[[float], tuple[Array, float]]) -> Exact:
    """Of (W, 3) at a time."""

    def exact(times: Array) -> tuple[Array, float]:
        rows, certain = zip(*(where(float(t)) for t in times), strict=True)
        known = np.array(certain)[:, None, None] <= UNCERTAIN
        return np.where(known, np.array(rows), np.nan), max(certain)

    return exact


def _milliseconds(**steps: tuple[float, ...]) -> dict[str, tuple[float, ...]]:
    """Steps by the names of programs, from ms."""
    names = {"rk4": "mbproj, RK4", "dop853": "mbproj, DOP853", "rattle": "RATTLE"}
    names |= {f"gauss{order}": f"by hand, Gauss {order}" for order in (4, 6, 8)}
    tried = {names[name]: tuple(1e-3 * step for step in given) for name, given in steps.items()}
    return tried | {f"{name}, energy row": tried[name] for name in ("mbproj, RK4", "mbproj, DOP853")}


@dataclass(frozen=True)
class _Long:
    """A long motion, but for its span."""

    title: str
    scene: Scene
    watch: str
    unit: str
    exact: Exact
    hand: Hand
    rattle: Rattled
    tried: Mapping[str, tuple[float, ...]]

    def problem(self, span: float) -> Problem:
        return Problem(
            title=f"{self.title}, {span:g} s",
            scene=self.scene,
            end=span,
            samples=1,
            watch=(self.watch,),
            exact=self.exact,
            errors=(),
            mbproj=ROWS,
            tried=self.tried,
            unit=self.unit,
            hand=self.hand,
            rattle=self.rattle,
        )


def long_crank_rocker(span: float) -> Problem:
    """RATTLE has other moments of the bars out of the plane: a flat body makes its mass matrix singular."""
    a, b, c, d = (Real(x) / 100 for x in (10, 30, 25, 30))
    (m1, J1), (m2, J2), (m3, J3) = ((Real(m) / 100, Real(J) / 10000) for m, J in ((200, 100), (30, 24), (25, 13)))
    g = Real(981) / 100

    def angles(φ: Array) -> tuple[Array, ...]:
        x, z = d - a * np.cos(φ), -a * np.sin(φ)
        span2 = x * x + z * z
        ψ = np.arctan2(z, x) + np.arccos((b * b + span2 - c * c) / (2 * b * np.sqrt(span2)))
        χ = np.arctan2(a * np.sin(φ) + b * np.sin(ψ), a * np.cos(φ) + b * np.cos(ψ) - d)
        return ψ, χ, a * np.sin(χ - φ) / (b * np.sin(ψ - χ)), a * np.sin(ψ - φ) / (c * np.sin(ψ - χ))

    def inertia(φ: Array) -> Array:
        ψ, _, ψ1, χ1 = angles(φ)
        coupler = (J2 + m2 * b * b / 4) * ψ1 * ψ1 + m2 * (a * a + a * b * np.cos(φ - ψ) * ψ1)
        return J1 + m1 * a * a / 4 + coupler + (J3 + m3 * c * c / 4) * χ1 * χ1

    def potential(φ: Array) -> Array:
        ψ, χ, _, _ = angles(φ)
        return g * (m1 * a / 2 * np.sin(φ) + m2 * (a * np.sin(φ) + b / 2 * np.sin(ψ)) + m3 * c / 2 * np.sin(χ))

    start = PI / 3
    moments = ((0.01, 0.01, 0.01), (1e-4, 2.4e-3, 2.4e-3), (1e-5, 1.3e-3, 1.3e-3))
    tried = {"dop853": (40, 20, 10, 5), "rk4": (20, 10, 5), "rattle": (20, 10)}
    return _Long(
        "crank-rocker",
        read_scene(MECHANISMS / "planar_four_bar.yaml"),
        "A.angle",
        "rad",
        _ends(lambda t: (_angle(angle_of(inertia, potential, start, 12.0, t), float(start)), 1e-9)),
        Hand(0, (0.0,), (float(start), float(inertia(start) * 12)), lambda y: _angle(y[..., 0], float(start))),
        Rattled(lambda angle, q: _angle(angle), moments=moments),
        _milliseconds(**tried, gauss4=(20, 10, 5), gauss6=(40, 20, 10), gauss8=(40, 20, 10)),
    ).problem(span)


def _slider_crank() -> tuple[Any, Callable[[Any], Any], Callable[[Any], Any]]:
    """Start, inertia and potential over the crank's angle."""
    r, L, rod, slider, crank, along, across, g = (
        Real(x) for x in ("0.08", "0.3", "0.5", "2", "1e-4", "4e-4", "4e-3", "9.8")
    )
    y0, z0 = Real(1) / 10, Real(12) / 100

    def inertia(p: Array) -> Array:
        y, z = y0 - r * np.sin(p), z0 + r * np.cos(p)
        s = np.sqrt(L * L - y * y - z * z)
        s1 = r * (y0 * np.cos(p) + z0 * np.sin(p)) / s
        f1 = r * (z0 * np.cos(p) - y0 * np.sin(p) + r) / (y * y + z * z)
        common, spin = rod / 4 + across / (L * L), along / (L * L)
        return crank + common * (s1 * s1 + r * r) + slider * s1 * s1 + spin * s * s * f1 * f1

    return Real(0), inertia, lambda p: rod * g * r * np.cos(p) / 2


def long_slider_crank(span: float) -> Problem:
    start, inertia, potential = _slider_crank()
    tried = {"dop853": (20, 10, 5), "rk4": (10, 5, 2.5), "rattle": (20, 10)}
    return _Long(
        "spatial slider-crank",
        read_scene(MECHANISMS / "spatial_slider_crank.yaml"),
        "A.angle",
        "rad",
        _ends(lambda t: (_angle(angle_of(inertia, potential, start, 6.0, t)), 1e-9)),
        Hand(1, (0.0,), (0.0, float(inertia(start) * 6)), lambda y: _angle(y[..., 0])),
        Rattled(lambda angle, q: _angle(angle), column=(10, 11)),
        _milliseconds(**tried, gauss4=(10, 5, 2.5), gauss6=(20, 10, 5), gauss8=(20, 10, 5)),
    ).problem(span)


def long_heavy_top(span: float) -> Problem:
    """It nods: its spin is 50 rad/s below that of steady precession."""
    scene = read_scene(MECHANISMS / "heavy_top.yaml", {"excess": "-50"})
    body, θ, precession = scene.bodies[0], radians(30.0), 1.5136100923704108
    A, C, weight = body.inertia[0][0] + 15.0, body.inertia[2][2], 15.0 * 9.81
    along = C * body.angular_velocity[2]
    vertical = A * sin(θ) ** 2 * precession + along * cos(θ)

    def axis(y: Array) -> Array:
        s = np.sin(y[..., 0])
        return np.stack([-s * np.sin(y[..., 1]), s * np.cos(y[..., 1]), np.cos(y[..., 0])], axis=-1)[..., None, :]

    rates = (precession, body.angular_velocity[2])
    return _Long(
        "heavy top",
        scene,
        scene.markers[0].name,
        "m",
        _ends(lambda t: (axis_of_top(A, C, weight, θ, rates, t)[None], 1e-9)),
        Hand(2, (A, C, weight), (θ, 0.0, 0.0, 0.0, vertical, along), axis),
        Rattled(lambda angle, q: q[:1, 9:12], moments=((A, A, C),), hinged=True),
        _milliseconds(
            dop853=(4, 2, 1), rk4=(2, 1), gauss4=(40, 20), gauss6=(80, 40, 20), gauss8=(160, 80, 40), rattle=(2, 1)
        ),
    ).problem(span)


def _swing(title: str, scene: Scene, J: float, start: float, down: float, span: float) -> Problem:
    """Bars in a row from rest, all at `start` degrees from hanging; that is `down` rad from the -z axis."""
    bars, g = len(scene.bodies), float(np.linalg.norm(scene.gravity))
    hand = _chain_by_hand(bars, J, g, radians(start), down)
    #: Steps a second of the reference: swings from large angles are chaotic, and have fast events.
    finest = 50 if start < 45.0 else 2000

    def exact(t: float) -> tuple[Array, float]:
        """By the Gauss method of order 12 in extended precision, and how far steps of twice the size lead from that."""
        fine, coarse = (
            hand.watched(by_gauss(hand, 12, t, max(round(t * each), 1), extended=True)[0])
            for each in (finest, finest // 2)
        )
        return fine, float(np.abs(fine - coarse).max())

    def end_of(_: float, q: Array) -> Array:
        """The tip from the centres of bars of 1 m."""
        joint = np.zeros(3)
        for place in q[:, :3]:
            joint = 2.0 * place - joint
        return np.array([joint])

    tried = {"dop853": (40, 20, 10), "rk4": (20, 10, 5), "rattle": (20, 10)}
    steps = _milliseconds(**tried, gauss4=(20, 10, 5), gauss6=(40, 20, 10), gauss8=(40, 20))
    return _Long(title, scene, scene.markers[0].name, "m", _ends(exact), hand, Rattled(end_of), steps).problem(span)


def long_double_pendulum(span: float, start: float = 20.0) -> Problem:
    given = {"start_upper": f"{start} deg", "start_lower": f"{start} deg"}
    scene = read_scene(MECHANISMS / "double_pendulum.yaml", given)
    return _swing(f"double pendulum from {start:g} degrees", scene, 1.0 / 12.0, start, 0.0, span)


def long_five_bar(span: float, start: float = 10.0) -> Problem:
    """Gravity is turned, so that the bars, which lie along x, hang at `start` degrees."""
    down = pi / 2 - radians(start)
    text = (MECHANISMS / "five_bar.yaml").read_text(encoding="utf-8")
    gravity = f"gravity: [{9.8 * sin(down)!r}, 0, {-9.8 * cos(down)!r}]"
    scene = read_scene_text(text.replace("gravity: [0, 0, -9.8]", gravity).partition("expect:")[0])
    return _swing(f"five bars from {start:g} degrees", scene, 1.01 / 12.0, start, down, span)


#: By name; a name that ends with "-" takes a number, of links, of N/m, of cylinders, or of seconds.
PROBLEMS: dict[str, Callable[..., Problem]] = {
    "five-bar": five_bar,
    "slider-crank": spatial_slider_crank,
    "chain-": lambda links: chain(int(links)),
    "four-bar-": four_bar,
    "governor-": governor,
    **{f"stiff-{case}-": partial(integrators, case) for case in CASES},
    "springs-": lambda links: springs(int(links)),
    "brake": brake,
    "oscillator": oscillator,
    "valve-train-": lambda cylinders: valve_train(int(cylinders)),
    "long-crank-rocker-": long_crank_rocker,
    "long-slider-crank-": long_slider_crank,
    "long-heavy-top-": long_heavy_top,
    "long-double-pendulum-": long_double_pendulum,
    "long-five-bar-": long_five_bar,
}


def chaotic() -> Iterator[Problem]:
    """Swings from large angles over 20 s, with samples at half seconds, for mbproj alone."""
    tried = {"rk4": (0.01,), "dop853": (0.02, 0.01)}
    for problem in (long_double_pendulum(20.0, 120.0), long_five_bar(20.0, 90.0)):
        steps = {f"mbproj, {method}": tried[method.split(",")[0].lower()] for method in ROWS}
        yield replace(problem, samples=40, tried=steps)


def problem_of(name: str) -> Problem:
    """Raises KeyError and ValueError."""
    if name in PROBLEMS and not name.endswith("-"):
        return PROBLEMS[name]()
    kind, _, number = name.rpartition("-")
    return PROBLEMS[f"{kind}-"](float(number))
