"""RATTLE, which is symplectic, on the bodies and joints of a scene, with dense matrices, in C++ (`rattle.cpp`)."""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Iterator, Sequence
from functools import partial
from math import inf
from time import process_time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbproj.equations.assembly.assemble import assemble
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.kinematics import body_rates, pose_of, twist_of
from mbproj.model.compile.mechanism import initial_guess
from mbproj.scene.records import Joint
from mbproj.scene.scene import Scene

from .compiled import NoCompiler, library
from .problem import Array, NotDone, Outcome, Problem, Program, Rattled, Setting, step_label

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


def by_rattle(scene: Scene, given: Rattled, span: float, steps: int) -> Array:
    """What is watched after `span` s, (W, 3)."""
    system = compile_system(scene)
    state = assemble(system, initial_guess(scene, system))
    pose, twist = pose_of(state.q), twist_of(pose_of(state.q), state.v)
    r, A, ω = pose.position[:-1], pose.rotation[:-1], body_rates(pose, twist)[:-1]
    count = len(r)
    q, v, w, pull = (np.zeros((count + 1, 12)) for _ in range(4))
    w[count], q[count, 3:] = inf, np.eye(3).T.ravel()
    inertia = (
        np.array([np.diag(body.inertia) for body in scene.bodies])
        if not len(given.moments)
        else np.array(given.moments)
    )
    q[:count] = np.concatenate([r, A.swapaxes(1, 2).reshape(-1, 9)], axis=1)
    turning = A @ np.cross(ω[:, None], np.eye(3)).swapaxes(1, 2)
    v[:count] = np.concatenate([twist.velocity[:-1], turning.swapaxes(1, 2).reshape(-1, 9)], axis=1)
    w[:count, :3] = [[body.mass] * 3 for body in scene.bodies]
    w[:count, 3:] = np.repeat(inertia.sum(axis=1, keepdims=True) / 2 - inertia, 3, axis=1)
    pull[:count, :3] = w[:count, :3] * scene.gravity
    if given.hinged:  # a body is seen from the origin, and its weight acts on the columns of A
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
    packed, angle = np.array(rows, dtype=ROW), np.zeros(1)
    rattle = library("rattle.cpp").rattle
    seen, size = np.array((0, *given.column), dtype=np.int32), ctypes.c_double(span / steps)
    masses = (count + 1, _at(w), _at(pull))
    rattle(*masses, len(packed), _at(packed), size, ctypes.c_long(steps), _at(q), _at(v), _at(angle), _at(seen))
    if not np.isfinite(q[:count]).all():
        raise NotDone("RATTLE diverges")
    return given.watched(float(angle[0]), q[:count])


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


def _at(array: NDArray[Any]) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def _run(problem: Problem, given: Rattled, count: int, times: Array) -> Outcome:
    assert len(times) == 1, "it watches the end"
    begun = process_time()
    watched = by_rattle(problem.scene, given, float(times[-1]), count)
    return Outcome(watched[None], process_time() - begun, None, count)


def programs(problem: Problem) -> Iterator[Program]:
    """One, on long motions."""
    given = problem.rattle
    if given is None:
        return
    try:
        library("rattle.cpp")
    except NoCompiler as error:
        print(f"left out: RATTLE ({error})", file=sys.stderr)
        return

    def settings() -> Iterator[Setting]:
        for step, count in problem.steps("RATTLE"):
            yield Setting(step_label(step), partial(_run, problem, given, count), count)

    yield Program("RATTLE", settings)
