"""What the kernel's runs of a mechanism have to share with the full formulation."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from mbproj import InputError, Scene, SimulationError, State, System, mobility, read_scene_text, settings_to_run
from mbproj.base.arrays import Array
from mbproj.equations.constraints import jacobian
from mbproj.equations.kinematics import pose_of
from mbproj.motion.formulations.full import FullFormulation
from mbproj.scene.records import GROUND, BodyForce, PointForce

from .elimination import in_the_kernel
from .finding import Finding, off
from .invariants import ADDS_UP, CLOSED, MARGIN, invariants
from .motion import Motion, full_equations, run
from .round_off import ROUND_OFF, RoundOff, round_off
from .solvable import start


@dataclass
class Verdict:
    """All findings on a mechanism, or why it was no case; what it was like."""

    findings: list[Finding] = field(default_factory=list)
    no_case: str = ""
    formulations: tuple[str, ...] = ()
    redundant: int = 0
    freedom: int = 0
    condition: float = 1.0

    @property
    def disagreements(self) -> list[Finding]:
        """What is off by more than is allowed."""
        return [finding for finding in self.findings if not finding.holds]


def examine(text: str) -> Verdict:
    """Runs a scene in every formulation that fits it, and compares."""
    try:
        system, state = start(text)
    except InputError as error:
        return Verdict(no_case=str(error))
    freedom = mobility(system, pose_of(state.q)).degrees_of_freedom
    scene = read_scene_text(text)
    verdict, runs = Verdict(freedom=freedom), dict[str, Motion]()
    for formulation in ("full", "reduced", "auto"):
        try:
            done = run(system, state, replace(settings_to_run(scene), formulation=formulation))
        except (InputError, SimulationError) as error:
            verdict.findings.append(Finding(f"{formulation} runs", np.inf, str(error)))
        else:
            runs.setdefault(done.choice.name, done)
            excess = done.choice.degrees_of_freedom - freedom
            verdict.findings.append(off(f"{formulation} degrees of freedom", excess, 0.5))
    if "full" in runs:
        _compare(verdict, scene, system, state, runs)
    return verdict


def _compare(verdict: Verdict, scene: Scene, system: System, state: State, runs: dict[str, Motion]) -> None:
    """Adds what is found on the runs, by formulation."""
    full = runs["full"]
    settings = replace(settings_to_run(scene), formulation="full")
    verdict.formulations, verdict.redundant = tuple(runs), full.choice.redundant
    for name, done in runs.items():
        equations = FullFormulation.of(system, state, settings, full.choice.redundant)
        limits = [_limit(system, equations, done, at) for at in (0, -1)]
        verdict.condition = max(verdict.condition, *(limit.condition for limit in limits))
        found = list(invariants(system, done, limits, _is_free(scene)))
        if name != "full":
            found += [*_same_equations(system, equations, done, limits), *_same_motion(system, done, full, limits)]
        verdict.findings += [replace(finding, what=f"{name} {finding.what}") for finding in found]


def _is_free(scene: Scene) -> bool:
    """Whether nothing acts from outside but gravity."""
    held = any(GROUND in joint.bodies for joint in scene.joints)
    driven = any(
        isinstance(force, BodyForce) or (isinstance(force, PointForce) and GROUND in force.bodies)
        for force in scene.forces
    )
    return not held and not driven


def _limit(system: System, equations: FullFormulation, done: Motion, at: int) -> RoundOff:
    samples = done.samples
    solve = full_equations(system, equations, float(samples.t[at]), samples.turns[at])
    return round_off(system, samples.q[at], samples.v[at], solve)


def _same_equations(
    system: System, equations: FullFormulation, done: Motion, limits: list[RoundOff]
) -> Iterator[Finding]:
    """At the states of the kernel's run, Eq. 14 gives its accelerations, and its reactions: what joints share at will
    acts alike on the bodies, and the smallest λ are the same."""
    samples, n = done.samples, system.bodies
    for at, limit in zip((0, -1), limits, strict=True):
        q = samples.q[at]
        found = full_equations(system, equations, float(samples.t[at]), samples.turns[at])(q, samples.v[at])
        allowed = in_the_kernel(system, q, found, limit)
        yield off("accelerations", samples.acceleration[at] - found.acceleration, allowed.acceleration)
        difference = samples.multipliers[at] - found.multipliers[n:]
        yield off("loads of joints", jacobian(system, pose_of(q))[n:].T @ difference, allowed.load)
        yield off("multipliers", difference, allowed.multipliers)


def _same_motion(system: System, done: Motion, full: Motion, limits: list[RoundOff]) -> Iterator[Finding]:
    """Poses and velocities of the runs differ by what their steps err, which halving them shows, and by round-off."""
    span = float(done.samples.t[-1])
    moved, pushed = (np.max([getattr(limit, name) for limit in limits], axis=0) for name in ("moved", "acceleration"))
    speed = np.abs(done.samples.v).max() / system.length + 1.0
    q = ADDS_UP * (CLOSED * moved + ROUND_OFF * np.abs(done.samples.q).max(axis=0) + pushed * span**2)
    v = ADDS_UP * (
        speed * (CLOSED * moved + moved * q.max()) + ROUND_OFF * np.abs(done.samples.v).max(axis=0) + pushed * span
    )
    for what, name, grain in (("poses", "q", q), ("velocities", "v", v)):
        steps = sum(np.abs(_of(run, name) - _of(run.finer, name)).max(axis=0) for run in (done, full))
        yield off(what, _of(done, name) - _of(full, name), MARGIN * steps.max() + grain)


def _of(motion: Motion | None, name: str) -> Array:
    assert motion is not None
    found: Array = getattr(motion.samples, name)
    return found
