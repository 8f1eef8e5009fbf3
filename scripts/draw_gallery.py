"""A picture of every mechanism at its start, with the path of its markers: mechanisms/pictures/NAME.png.

    python scripts/draw_gallery.py [NAME ...]

Bodies are bars between their joints, or what SKETCHES says, in orthographic projection. A ring is a revolute joint, a
black ball a spherical one, a cross a universal one; what slides is a block on a rail or a rod in a tube; the ground is
hatched, or grey. Coloured: paths of the markers.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path

import numpy as np
from gallery_sketches import FLAT, SKETCHES, Shape, Sketch
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mbproj import assemble, compile_system, initial_guess, read_scene, settings_to_run, simulate
from mbproj.base.arrays import Array
from mbproj.equations.recorded import Block
from mbproj.functions.plane_curve import points_along
from mbproj.functions.space_curve import Track
from mbproj.joints.table import JOINTS
from mbproj.model.compile.frames import local_frames
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.scene.blocks.ropes import axes as path_axes
from mbproj.scene.blocks.ropes import straight
from mbproj.scene.records import GROUND, Joint
from mbproj.scene.scene import Scene

MECHANISMS = Path(__file__).parents[1] / "mechanisms"
INK, PAPER, STEEL, PLATE, EARTH, FLOOR = "#1F2933", "#FFFFFF", "#A9B7C6", "#CBD5E0", "#8A8F98", "#B9BEC6"
PATHS = ("#D55E00", "#0072B2", "#009E73")
WIDTH, HEIGHT, DPI = 6.0, 4.5, 100

#: Centre of mass and rotation matrix of each body.
Poses = Mapping[str, tuple[Array, Array]]


class History:
    """Keeps poses and marker paths of a run."""

    def __init__(self, bodies: tuple[str, ...]) -> None:
        self.bodies, self.blocks = bodies, list[Block]()

    def write(self, block: Block) -> None:
        """Takes a block of samples."""
        self.blocks.append(block)

    def __getitem__(self, path: str) -> Array:
        return np.concatenate([block[path] for block in self.blocks])

    def poses(self, time: float) -> Poses:
        """Of all bodies and the ground, at the sample after `time`."""
        at = int(np.searchsorted(self["time"], time))
        places, turns = self["bodies/position"][at], rotation_matrix(self["bodies/orientation"][at])
        return {name: (places[k], turns[k]) for k, name in enumerate(self.bodies)} | {GROUND: (np.zeros(3), np.eye(3))}


@dataclass(frozen=True)
class Camera:
    """Orthographic: `screen` (3, 3) has the rows right, up and towards the viewer."""

    screen: Array

    @classmethod
    def of(cls, azimuth: float, elevation: float) -> Camera:
        a, e = np.radians(azimuth), np.radians(elevation)
        right = [-np.sin(a), np.cos(a), 0.0]
        up = [-np.sin(e) * np.cos(a), -np.sin(e) * np.sin(a), np.cos(e)]
        return cls(np.array([right, up, np.cross(right, up)]))

    def flat(self, points: Array) -> Array:
        """Places on the picture, (..., 2)."""
        return (points @ self.screen.T)[..., :2]


def connecting(scene: Scene) -> list[Joint]:
    """The joints that have a place: those that couple others have none, and a rope has many."""
    return [joint for joint in scene.joints if joint.couples is None and "path" not in joint.parameters]


def local_joints(scene: Scene, start: Poses) -> Iterable[tuple[str, Array, Array]]:
    """Of each end of a joint: its body, its point in the body's axes, and the point in space at the start."""
    for joint in connecting(scene):
        for body, given in zip(joint.bodies, (joint.points.first, joint.points.second), strict=True):
            position, rotation = start[body]
            local = np.array(given) if joint.points.local else rotation.T @ (np.array(given) - position)
            yield body, local, position + rotation @ local


def shapes_of(scene: Scene, sketch: Sketch, start: Poses) -> dict[str, tuple[Shape, ...]]:
    """The shapes of every body: the sketch's, or a bar or plate between its joints, or to its centre and markers."""
    found: dict[str, tuple[Shape, ...]] = {}
    for body, (position, rotation) in start.items():
        corners = [local for name, local, _ in local_joints(scene, start) if name == body]
        if len(corners) < 2:
            places = [(np.array(marker.location), marker.local) for marker in scene.markers if marker.body == body]
            corners += [np.zeros(3), *(place if local else rotation.T @ (place - position) for place, local in places)]
        points = np.array(corners)
        found[body] = (Shape(points) if len(points) < 4 else Shape(around(points), None),)
        for pattern, shapes in ({GROUND: ()} | dict(sketch.shapes)).items():
            found[body] = shapes if fnmatch(body, pattern) else found[body]
    for body, shape in profiles(scene, start):
        found[body] = (shape, *(found[body] if body in {GROUND, *sketch.shapes} else ()))
    return found


def profiles(scene: Scene, start: Poses) -> Iterable[tuple[str, Shape]]:
    """The profiles that joints follow, each with the body that carries it: plates, or rails where they are open."""
    joints = [joint for joint in scene.joints if isinstance(joint.parameters.get("curve"), Track)]
    for joint, frame in zip(joints, local_frames(joints, start), strict=True):
        track = joint.parameters["curve"]
        x, y = np.array(points_along(track.line, track.roller)).T[..., None]
        filled = track.line.closed and joint.type != "slot"
        yield joint.bodies[0], Shape(frame[0] + x * frame[1] + y * frame[2], None if filled else 2.0)


def around(points: Array) -> Array:
    """Points of a plane (k, 3) in their order around its edge."""
    from_middle = points - np.mean(points, axis=0)
    plane = np.linalg.svd(from_middle)[2][:2]
    angles = np.arctan2(from_middle @ plane[1], from_middle @ plane[0])
    return points[np.argsort(angles)]


def draw_bodies(axes: Axes, camera: Camera, shapes: Mapping[str, tuple[Shape, ...]], poses: Poses, ink: float) -> None:
    """Every shape at these poses, what is nearer over what is farther; `ink` 1 is full colour."""
    for body, parts in shapes.items():
        position, rotation = poses[body]
        for shape in parts:
            points = position + shape.corners @ rotation.T
            x, y = camera.flat(points).T
            order = 10.0 + ink * 10.0 + np.mean(points @ camera.screen[2]) + 0.1 * (shape.width or 0.0)
            if shape.width is None:
                colour = FLOOR if body == GROUND else PLATE
                axes.fill(x, y, facecolor=colour, edgecolor=INK, linewidth=0.8, alpha=0.85 * ink, zorder=order)
                continue
            fill = EARTH if body == GROUND else STEEL
            for width, colour in ((shape.width + 1.6, INK), (shape.width, fill)):
                axes.plot(
                    x,
                    y,
                    color=colour,
                    linewidth=width,
                    solid_capstyle="round",
                    solid_joinstyle="round",
                    alpha=ink,
                    zorder=order,
                )


SYMBOLS = {"spherical": ("o", INK, 6.0), "universal": ("P", PAPER, 8.0)}


def draw_joints(axes: Axes, camera: Camera, scene: Scene, start: Poses, support: float) -> None:
    """A symbol at every joint, and the ground where it holds one, of size `support` (below 0: above the joint)."""
    ends = list(local_joints(scene, start))
    for joint, (_, _, first), (_, _, point) in zip(connecting(scene), ends[::2], ends[1::2], strict=True):
        if joint.type in ("prismatic", "planar", "knife_edge") or JOINTS[joint.type].is_on_plane:
            continue
        x, y = camera.flat(point)
        if GROUND in joint.bodies and support:
            at, above = camera.flat(first if joint.bodies[0] == GROUND else point)
            draw_ground(axes, at, above, support)
        if JOINTS[joint.type].is_rod:
            axes.plot(*np.stack([camera.flat(first), (x, y)], axis=-1), color=INK, linewidth=1.6, zorder=35)
        marker, face, diameter = SYMBOLS.get(joint.type, ("o", PAPER, 6.5))
        axes.plot(
            x, y, marker, markersize=diameter, markerfacecolor=face, markeredgecolor=INK, markeredgewidth=1.2, zorder=40
        )


def draw_ropes(axes: Axes, camera: Camera, scene: Scene) -> None:
    """Every rope at the scene's pose: straight from circle to circle, and around them."""
    for path in (joint.parameters["path"] for joint in scene.joints if "path" in joint.parameters):
        x, y, _ = (np.array(axis) for axis in path_axes(path.normal))
        _, directions = straight(path)
        line = list[Array]()
        for before, node, after in zip(
            [directions[0], *directions], path.nodes, [*directions, directions[-1]], strict=True
        ):
            for θ in np.linspace(before, after, 30):
                out = node.signed_radius * (np.sin(θ) * x - np.cos(θ) * y)
                line.append(np.array(node.at.vector) + out)
        axes.plot(*camera.flat(np.array(line)).T, color=INK, linewidth=1.6, solid_joinstyle="round", zorder=34)


def draw_ground(axes: Axes, x: float, y: float, support: float) -> None:
    """A triangle at the joint, on a hatched line."""
    half, deep = 0.64 * support, support
    axes.fill([x, x - half, x + half], [y, y - deep, y - deep], facecolor=PAPER, edgecolor=INK, linewidth=1.0, zorder=9)
    axes.plot([x - 1.6 * half, x + 1.6 * half], [y - deep, y - deep], color=INK, linewidth=1.2, zorder=9)
    for step in np.linspace(-1.5, 1.3, 6):
        axes.plot(
            [x + step * half, x + (step - 0.45) * half],
            [y - deep, y - deep - 0.45 * half],
            color=EARTH,
            linewidth=0.9,
            zorder=8,
        )


def draw_scale(axes: Axes, camera: Camera, size: float) -> None:
    """The directions of x, y, z and a bar of a round length."""
    arm, left, bottom = 0.09 * size, axes.get_xlim()[0], axes.get_ylim()[0]
    x, y = left + 0.11 * size, bottom + 0.1 * size
    for name, direction in zip("xyz", np.eye(3), strict=True):
        u, v = arm * camera.flat(direction)
        if np.hypot(u, v) > 0.1 * arm:
            axes.annotate("", (x + u, y + v), (x, y), arrowprops={"arrowstyle": "-|>", "color": EARTH, "lw": 1.0})
            axes.text(x + 1.3 * u, y + 1.3 * v, name, color=EARTH, fontsize=9, ha="center", va="center", style="italic")
    length = max(value for value in (0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0) if value < 0.3 * size)
    left, bottom = left + 0.32 * size, bottom + 0.05 * size
    axes.plot([left, left + length], [bottom, bottom], "|-", color=INK, linewidth=1.2, markersize=7)
    above = bottom + 0.015 * size
    axes.text(left + length / 2, above, f"{length:g} m", color=INK, fontsize=9, ha="center", va="bottom")


def draw(name: str, sketch: Sketch) -> Figure:
    """The picture of mechanisms/<name>.yaml."""
    times = {"duration": str(sketch.duration), "output_step": str(sketch.duration / 400)}
    scene = read_scene(MECHANISMS / f"{name}.yaml", {}, {"integrator": "dop853", "tolerance": "1e-8", **times})
    system = compile_system(scene)
    history = History(system.names.bodies)
    simulate(system, assemble(system, initial_guess(scene, system)), settings_to_run(scene), history)
    figure = Figure(figsize=(WIDTH, HEIGHT), dpi=DPI)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    start, camera = history.poses(0.0), Camera.of(*sketch.view)
    shapes = shapes_of(scene, sketch, start)
    for time in sketch.ghosts:
        draw_bodies(axes, camera, {**shapes, GROUND: ()}, history.poses(time), 0.18)
    draw_bodies(axes, camera, shapes, start, 1.0)
    shown = [k for k, marker in enumerate(system.names.markers) if sketch.markers is None or marker in sketch.markers]
    for colour, k in zip(PATHS, shown, strict=False):
        path = camera.flat(history["markers/position"][:, k])
        axes.plot(*path.T, color=colour, linewidth=1.4, zorder=5 if sketch.view == FLAT else 30)
        axes.plot(*path[0], "o", color=colour, markersize=5, zorder=45)
    draw_ropes(axes, camera, scene)
    size = frame(axes)
    plated = any(shape.width is None for shape in shapes[GROUND])
    draw_joints(axes, camera, scene, start, 0.0 if plated else -0.05 * size if sketch.hangs else 0.05 * size)
    draw_scale(axes, camera, size)
    return figure


def frame(axes: Axes) -> float:
    """Equal scales, everything within, room for the scale below; the height of the picture in m."""
    axes.set_axis_off()
    drawn = axes.dataLim
    height = max(1.4 * drawn.height, 1.15 * drawn.width * HEIGHT / WIDTH)
    x, y = (drawn.x0 + drawn.x1) / 2, (drawn.y0 + drawn.y1) / 2
    axes.set_xlim(x - height * WIDTH / HEIGHT / 2, x + height * WIDTH / HEIGHT / 2)
    axes.set_ylim(y - 0.56 * height, y + 0.44 * height)
    return height


def main() -> None:
    """Draws the mechanisms that are named, or all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME")
    for name in parser.parse_args().names or sorted(path.stem for path in MECHANISMS.glob("*.yaml")):
        path = MECHANISMS / "pictures" / f"{name}.png"
        draw(name, SKETCHES.get(name, Sketch())).savefig(path, metadata={"Software": None})
        print(path)


if __name__ == "__main__":
    main()
