"""Biconnected components of a mechanism: the parts of its graph of bodies and joints that no single body separates
(Tarjan 1972).

Forces that balance each other go round loops, and no loop leaves its component. Where two components share only one
body, the force of either on it must vanish by itself: rows of C do not change when all bodies move as one. So rows
depend on each other only within components, and the rank is the sum over components. In a tree each joint is a
component.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mbproj.base.arrays import Array, Integers, numbers
from mbproj.base.dataclass import dataclass
from mbproj.equations.constraints import tangent_entries
from mbproj.equations.kinematics import Pose
from mbproj.model.system import System


@dataclass(frozen=True, eq=False)
class Component:
    """Rows (k,) of C, counted without the norm rows, and the bodies (b,) that they hold, the ground left out.

    `is_loop`: whether it has several joints or motions, or one that joins a body to itself. The rows of other
    components cannot depend on each other."""

    rows: Integers
    bodies: Integers
    is_loop: bool = True


def loops_of(system: System) -> list[Component]:
    """Return the components whose rows can depend on each other."""
    return [component for component in components_of(system) if component.is_loop]


def components_of(system: System) -> list[Component]:
    """Return the components; each row is in one, and a motion in that of its joint."""
    rows_of, bodies_of = _links(system)
    edges = [
        (first, second, link)
        for link, bodies in enumerate(bodies_of)
        for first, second in zip(bodies, bodies[1:] + bodies[:1], strict=True)
    ]
    components = []
    for members in _biconnected(system.bodies + 1, edges):
        links = sorted({edges[edge][2] for edge in members})
        bodies = {body for link in links for body in bodies_of[link]} - {system.bodies}
        rows = np.concatenate([rows_of[link] for link in links])
        is_loop = len(links) > 1 or len(bodies_of[links[0]]) < 2
        components.append(Component(np.sort(rows), np.array(sorted(bodies), dtype=np.intp), is_loop))
    return sorted(components, key=lambda component: int(component.rows[0]))


def component_rows(system: System, pose: Pose, components: list[Component]) -> list[Array]:
    """Return the rows of each component in (δr / length, δθ) of its bodies, in units of the length or rad, (k, 6b)."""
    entry_row, body, values = _entries(system, pose)
    component_of = np.full(system.constraints - system.bodies, -1, dtype=np.intp)
    place = np.zeros_like(component_of)
    for number, component in enumerate(components):
        component_of[component.rows], place[component.rows] = number, np.arange(len(component.rows))
    order = np.argsort(component_of[entry_row], kind="stable")
    ends = np.searchsorted(component_of[entry_row][order], np.arange(len(components) + 1))
    blocks = []
    for number, component in enumerate(components):
        mine = order[ends[number] : ends[number + 1]]
        mine = mine[np.isin(body[mine], component.bodies)]
        matrix = np.zeros((len(component.rows), len(component.bodies), 6), like=values)
        np.add.at(matrix, (place[entry_row[mine]], np.searchsorted(component.bodies, body[mine])), values[mine])
        blocks.append(matrix.reshape(len(component.rows), 6 * len(component.bodies)))
    return blocks


def _entries(system: System, pose: Pose) -> tuple[Integers, Integers, Array]:
    """Return row, body and ∂/∂(δr / length, δθ) (e, 6) of the entries of all rows, rows in metres over the length."""
    body, values = tangent_entries(system.rows, pose)
    scaled = values[:, :6] * numbers([system.length] * 3 + [1.0] * 3)
    scaled /= np.where(system.rows.is_length, system.length, 1.0)[system.rows.entry_row, None]
    return system.rows.entry_row, body, scaled


def _links(system: System) -> tuple[list[Integers], list[list[int]]]:
    """Return the rows of each joint and motion, and the bodies that they bind."""
    bound = system.rows
    links = bound.owner[bound.entry_row]
    order = np.argsort(links, kind="stable")
    ends = np.searchsorted(links[order], np.arange(1, int(bound.owner.max(initial=-1)) + 1))
    groups = np.split(order, ends) if len(order) else []
    rows_of = [np.array(sorted(set(bound.entry_row[entries].tolist()))) for entries in groups]
    return rows_of, [sorted(set(bound.body[bound.entry_slot[entries]].tolist())) for entries in groups]


def _biconnected(count: int, edges: list[tuple[int, int, int]]) -> Iterator[list[int]]:
    """The biconnected components of a graph with `count` vertices, as lists of edges, by depth-first search."""
    around: list[list[tuple[int, int]]] = [[] for _ in range(count)]
    for number, (first, second, _) in enumerate(edges):
        if first == second:
            yield [number]
            continue
        around[first].append((second, number))
        around[second].append((first, number))
    depth, low, used = [-1] * count, [0] * count, [False] * len(edges)
    for root in range(count):
        if depth[root] >= 0:
            continue
        depth[root], low[root] = 0, 0
        path, pending, stack = [(root, -1)], {root: iter(around[root])}, list[int]()
        while path:
            vertex, arrived = path[-1]
            step = next(((to, edge) for to, edge in pending[vertex] if not used[edge]), None)
            if step is not None:
                to, edge = step
                used[edge] = True
                stack.append(edge)
                if depth[to] < 0:
                    depth[to] = low[to] = depth[vertex] + 1
                    pending[to] = iter(around[to])
                    path.append((to, edge))
                else:
                    low[vertex] = min(low[vertex], depth[to])
                continue
            path.pop()
            if path:
                parent = path[-1][0]
                low[parent] = min(low[parent], low[vertex])
                if low[vertex] >= depth[parent]:
                    cut = stack.index(arrived)
                    yield stack[cut:]
                    del stack[cut:]
