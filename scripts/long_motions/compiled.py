"""The symplectic methods of this folder, in C++: compiled when they are first needed."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from math import inf
from typing import Any

import numpy as np
from peers.compiled import library

from mbproj.equations.assembly.assemble import assemble
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.kinematics import body_rates, pose_of, twist_of
from mbproj.model.compile.mechanism import initial_guess
from mbproj.scene.records import Joint
from mbproj.scene.scene import Scene

Array = np.ndarray
#: A scalar row of two bodies, as the C++ has it.
ROW = np.dtype(
    [
        *((name, "i4") for name in ("kind", "first", "second", "axis", "other")),
        ("u", "3f8"),
        ("v", "3f8"),
        ("start", "f8"),
    ],
    align=True,
)
ALIGNED, ACROSS, BESIDE, UNIT = range(4)


def by_gauss(
    which: int,
    parts: Sequence[float],
    order: int,
    start: Sequence[float],
    span: float,
    steps: int,
    *,
    extended: bool = False,
) -> tuple[Array, int]:
    """The state (n,) after `span` s by a Gauss method, and its evaluations."""
    gauss, y, given = library("../long_motions/gauss.cpp"), np.zeros(16), np.zeros(4)
    y[: len(start)], given[: len(parts)] = start, parts
    pointer, count = given.ctypes.data_as(ctypes.c_void_p), ctypes.c_long(steps)
    function = gauss.gauss_extended if extended else gauss.gauss_double
    function.restype = ctypes.c_double
    end = np.zeros(16)
    if extended:
        done = function(which, pointer, order // 2, ctypes.c_double(span), count, _at(y), _at(end))
    else:
        done, end = function(which, pointer, order // 2, ctypes.c_double(span / steps), count, _at(y)), y
    return end[: len(start)], int(done)


def by_rattle(
    scene: Scene,
    span: float,
    steps: int,
    turned: Sequence[int] = (0, 3, 5),
    moments: Sequence[Sequence[float]] = (),
    *,
    hinged: bool = False,
) -> tuple[float, Array]:
    """By how far a body has turned, rad, and (n, 12) r and the columns of A of all bodies, after `span` s.

    `turned`: the body, and two of these numbers by which it is seen. `moments`: about the bodies' axes, where those of
    the scene make the mass matrix singular, though the motion does not see them; of a body `hinged` at the origin,
    about that."""
    system = compile_system(scene)
    state = assemble(system, initial_guess(scene, system))
    pose, twist = pose_of(state.q), twist_of(pose_of(state.q), state.v)
    r, A, ω = pose.position[:-1], pose.rotation[:-1], body_rates(pose, twist)[:-1]
    count = len(r)
    q, v, w, pull = (np.zeros((count + 1, 12)) for _ in range(4))
    w[count], q[count, 3:] = inf, np.eye(3).T.ravel()
    inertia = np.array([np.diag(body.inertia) for body in scene.bodies]) if not len(moments) else np.array(moments)
    q[:count] = np.concatenate([r, A.swapaxes(1, 2).reshape(-1, 9)], axis=1)
    turning = A @ np.cross(ω[:, None], np.eye(3)).swapaxes(1, 2)
    v[:count] = np.concatenate([twist.velocity[:-1], turning.swapaxes(1, 2).reshape(-1, 9)], axis=1)
    w[:count, :3] = [[body.mass] * 3 for body in scene.bodies]
    w[:count, 3:] = np.repeat(inertia.sum(axis=1, keepdims=True) / 2 - inertia, 3, axis=1)
    pull[:count, :3] = w[:count, :3] * scene.gravity
    if hinged:  # a body is seen from the origin, and its weight acts on the columns of A
        arms = np.einsum("bji,bj->bi", A, r)
        pull[:count] = np.einsum("b,bc,k->bck", w[:count, 0], np.insert(arms, 0, 0.0, axis=1), scene.gravity).reshape(
            -1, 12
        )
        q[:count, :3] = v[:count, :3] = 0.0
        r = np.zeros_like(r)
    names = [body.name for body in scene.bodies] + ["ground"]
    place = np.concatenate([r, np.zeros((1, 3))]), np.concatenate([A, np.eye(3)[None]])
    rows = [row for joint in scene.joints for row in _rows(joint, [names.index(name) for name in joint.bodies], *place)]
    rows += [_row(UNIT, b, b, axis=i, other=j) for b in range(count) for i in range(3) for j in range(i + 1)]
    given, angle = np.array(rows, dtype=ROW), np.zeros(1)
    rattle = library("../long_motions/rattle.cpp").rattle
    seen, size = np.array(turned, dtype=np.int32), ctypes.c_double(span / steps)
    masses = (count + 1, _at(w), _at(pull))
    rattle(*masses, len(given), _at(given), size, ctypes.c_long(steps), _at(q), _at(v), _at(angle), _at(seen))
    return float(angle[0]), q[:count]


def _rows(joint: Joint, bodies: Sequence[int], r: Array, A: Array) -> list[tuple[Any, ...]]:
    """The scalar rows of a joint whose points and axes are given at the start, in global axes."""
    a, b = bodies
    s, t = (
        A[k].T @ (np.array(point) - r[k])
        for k, point in zip(bodies, (joint.points.first, joint.points.second), strict=True)
    )
    rows = [] if joint.type == "prismatic" else [_row(ALIGNED, a, b, axis=k, u=s, v=t) for k in range(3)]
    if joint.axes is None:
        return rows
    first, second = np.array(joint.axes.first), np.array(joint.axes.second)
    if joint.type == "universal":
        return [*rows, _row(ACROSS, a, b, u=A[a].T @ first, v=A[b].T @ second)]
    normals = np.linalg.svd(first[None])[2][1:]
    rows += [_row(ACROSS, a, b, u=A[a].T @ normal, v=A[b].T @ second) for normal in normals]
    if joint.type == "prismatic":
        rows += [_row(BESIDE, a, b, u=A[a].T @ normal, v=t) for normal in normals]
        rows.append(_row(ACROSS, a, b, u=A[a].T @ normals[0], v=A[b].T @ normals[1]))
    return rows


def _row(
    kind: int,
    a: int,
    b: int,
    *,
    axis: int = 0,
    other: int = 0,
    u: Sequence[float] | Array = (0.0, 0.0, 0.0),
    v: Sequence[float] | Array = (0.0, 0.0, 0.0),
) -> tuple[Any, ...]:
    return (kind, a, b, axis, other, tuple(u), tuple(v), 0.0)


def _at(array: Array) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)
