"""The case that all checks of a verification share: a mechanism, a moving state, and quantities that are computed from
it once."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics import State
from mbproj.dynamics.assembly.assemble import coordinate_values
from mbproj.dynamics.contact.inside import stop_sizes
from mbproj.dynamics.equations.constraint_equations import set_jacobian
from mbproj.dynamics.equations.gaps import gaps
from mbproj.dynamics.equations.kinematics import pose_of
from mbproj.dynamics.rank.row_space import scaled_jacobian
from mbproj.errors import InputError
from mbproj.integrate.formulations.choice import Choice
from mbproj.integrate.formulations.compiled import Compiled
from mbproj.integrate.formulations.reduced import Reduced
from mbproj.integrate.formulations.redundant_rows import settle_rows
from mbproj.kernel import core
from mbproj.kernel.bound import without_form
from mbproj.model import System
from mbproj.scene.read import Scene
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.verify.equations import RoundedEquations, equations_at, independent_rows
from mbproj.studies.verify.runs import ShortRuns, short_runs
from mbproj.thresholds import THRESHOLDS

#: Checks with dense matrices are made up to this number of bodies: there their error bounds take a few seconds.
DENSE = 40
#: The mass matrix is not definite where a body has no mass, or a ratio of its smallest to its largest moment of inertia
#: below this.
DEFINITE = 1e-12


class ShortRun(NamedTuple):
    """The short runs from one state, with different numbers of steps."""

    name: str
    state: State
    runs: ShortRuns


@dataclass(frozen=True, eq=False)
class Case:
    """A mechanism with all that its checks need, each computed when first asked for."""

    mechanism: Mechanism

    @property
    def scene(self) -> Scene:
        """The scene of the mechanism."""
        return self.mechanism.scene

    @property
    def system(self) -> System:
        """The scene compiled to arrays."""
        return self.mechanism.system

    @cached_property
    def choice(self) -> Choice:
        """The formulation that a run of the scene uses."""
        return self.mechanism.choice(self.scene.settings)

    @cached_property
    def state(self) -> State:
        """The start with a random velocity added."""
        return self._moving(1.0, 1.0)

    def _moving(self, translating: float, rotating: float) -> State:
        """Return the start with a random velocity added. `translating` and `rotating` scale the parts of that velocity.
        It is projected onto the motions that joints, and rigid stops that touch, allow. Its size is `rate` times the
        mechanism's length, or `rate`."""
        system, start = self.system, self.mechanism.state
        rows = scaled_jacobian(system, pose_of(start.q))[independent_rows(system, start.q)]
        weights = np.tile([system.length] * 3 + [1.0] * 4, system.bodies)
        rate = self.rate * np.random.default_rng(0).normal(size=len(weights))
        rate *= np.tile([translating] * 3 + [rotating] * 4, system.bodies)
        allowed = rate - np.linalg.lstsq(rows, rows @ rate, rcond=None)[0]
        touching = _touching(system, start) * weights
        if (touching @ allowed < 0.0).any():  # it would move into a stop: let it move along the stop
            rows = np.vstack([rows, touching])
            allowed = rate - np.linalg.lstsq(rows, rows @ rate, rcond=None)[0]
        return start.changed(velocities=start.v + weights * allowed)

    @cached_property
    def rate(self) -> float:
        """The rate of the mechanism's motion, rad/s: the largest of its rate at the start, √(g / length), and the
        square root of its largest acceleration at the start. It is 1 where all of these are zero."""
        system, start = self.system, self.mechanism.state
        pulls = [float(np.linalg.norm(system.gravity)) / system.length]
        if not self.too_large:
            pull = equations_at(system, start).accelerations().value[: 7 * system.bodies]
            pulls.append(_fastest(system, pull))
        return max(_fastest(system, start.v), float(np.sqrt(max(pulls)))) or 1.0

    @cached_property
    def equations(self) -> RoundedEquations:
        """The equations of motion at `state`."""
        return equations_at(self.system, self.state)

    @cached_property
    def runs(self) -> ShortRuns:
        """The short runs from `state`."""
        return self._from(self.state)

    @cached_property
    def motions(self) -> tuple[ShortRun, ...]:
        """The short runs from the scene's own start, and from starts that rotate, translate, and do both."""
        states = {
            "from the scene's own start": self.mechanism.state,
            "rotating": self._moving(0.0, 1.0),
            "translating": self._moving(1.0, 0.0),
        }
        others = (ShortRun(name, state, self._from(state)) for name, state in states.items())
        return *others, ShortRun("rotating and translating", self.state, self.runs)

    def _from(self, state: State) -> ShortRuns:
        fastest = max(_fastest(self.system, state.v), self.rate)
        return short_runs(Mechanism(self.scene, self.system, state), fastest, slow=self.choice.name == "full")

    @cached_property
    def displacement(self) -> Array:
        """A random change of all coordinates, (7n,), of the size of the mechanism's length and of 1 for Euler
        parameters."""
        weights = np.tile([self.system.length] * 3 + [1.0] * 4, self.system.bodies)
        return weights * np.random.default_rng(1).normal(size=len(weights))

    @property
    def reference(self) -> Array:
        """The joints' coordinates at `state`, with turns counted, (nc,)."""
        return coordinate_values(self.system, pose_of(self.state.q)) + 2.0 * np.pi * self.state.turns

    @property
    def redundant(self) -> bool:
        """Whether some constraint rows depend on others."""
        return len(self.equations.rows) < self.system.constraints

    @property
    def too_large(self) -> str | None:
        """The reason why checks with dense matrices do not apply; None where they do."""
        bodies = self.system.bodies
        return f"{bodies} bodies: checks with dense matrices stop at {DENSE}" if bodies > DENSE else None

    @property
    def indefinite(self) -> str | None:
        """The reason why M is not definite even in tangent coordinates; None where it is definite."""
        for name, mass, inertia in zip(self.system.names.carriers, self.system.mass, self.system.inertia, strict=True):
            moments = np.linalg.eigvalsh(inertia)
            if mass <= 0.0 or moments[0] <= DEFINITE * moments[-1]:
                return f"body '{name}' has no definite mass and inertia"
        return None

    @cached_property
    def reduced(self) -> Reduced | str:
        """The kernel's reduced formulation, or the reason why it is not available."""
        kernel = core()
        if kernel is None:
            return "there is no compiled kernel"
        missing = without_form(self.system)
        if missing is not None:
            return f"the kernel has no primitive '{missing}'"
        compiled = Reduced(kernel, self.system)
        redundant = settle_rows(compiled, self.mechanism.state)
        regular, _ = compiled.is_regular(self.mechanism.state)
        return compiled if regular and redundant is not None else "in space the start is a singular pose"

    @property
    def planar(self) -> Compiled | str:
        """The kernel's planar formulation, or the reason why it is not available."""
        compiled = self.choice.compiled
        return compiled if compiled is not None and compiled.name == "planar" else self.not_planar

    @property
    def not_planar(self) -> str:
        """The reason why the case is not computed in a plane."""
        try:
            self.mechanism.choice(replace(self.scene.settings, formulation="planar"))
        except InputError as error:
            return error.problems[0].message
        return f"the scene asks for the {self.choice.name} formulation"


def _touching(system: System, start: State) -> Array:
    """The gradients of the gaps of the rigid stops that touch, (k, 7n)."""
    stops, pose = system.stops, pose_of(start.q)
    if stops is None:
        return np.zeros((0, 7 * system.bodies))
    touch = stops.is_rigid & (gaps(stops, pose, start.turns) <= THRESHOLDS.same_written * stop_sizes(system))
    return np.asarray((stops.side[:, None] * set_jacobian(stops.coordinates, pose))[touch])


def _fastest(system: System, rates: Array) -> float:
    """The largest rate, 1/s, in the rates of all coordinates (7n,): speeds over the mechanism's length, and ω = 2
    |Λ'|."""
    parts = np.abs(rates.reshape(-1, 7))
    return max(float(parts[:, :3].max()) / system.length, 2.0 * float(parts[:, 3:].max()))
