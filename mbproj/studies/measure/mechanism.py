"""A scene made ready to be run many times: compiled and assembled once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from mbproj.dataclass import dataclass
from mbproj.dynamics import State
from mbproj.errors import InputError, Problem
from mbproj.integrate.formulations.choice import choose
from mbproj.linear.equilibrium.started import start_state
from mbproj.model import System, compile_system
from mbproj.registry import EQUILIBRIUM
from mbproj.scene.records import Scene, Settings
from mbproj.scene.text.suggestions import choose_from
from mbproj.studies.measure.setting import Setting


@dataclass(frozen=True, eq=False)
class Mechanism:
    """A scene with its system and its consistent start. `points` are what errors are measured at: the markers' names,
    or the bodies' where the scene has no marker."""

    scene: Scene
    system: System
    state: State

    @classmethod
    def of(cls, scene: Scene) -> Mechanism:
        """Compiles and assembles. Raises InputError where the mechanism cannot be assembled."""
        system = compile_system(scene)
        return cls(scene, system, start_state(scene, system))

    @classmethod
    def to_choose_for(cls, scene: Scene) -> Mechanism:
        """The same, for a study of settings. Raises InputError where a run has nothing to choose: it is kinematic."""
        found = cls.of(scene)
        if choose(found.system, found.state, scene.settings).kinematic:
            message = "0 degrees of freedom: the run is kinematic, exact at any setting; there is none to choose"
            hint = "simply run it; --set simulation.kinematic=false integrates it all the same"
            raise InputError(Problem(message, scene.place("simulation"), hint))
        return found

    @property
    def points(self) -> tuple[str, ...]:
        """Names of the points, (k,)."""
        return tuple(self.system.names.markers or self.system.names.bodies)

    @property
    def kind(self) -> str:
        """What the points are: "markers" or "bodies"."""
        return "markers" if self.system.names.markers else "bodies"

    def columns(self, names: Sequence[str] = ()) -> tuple[int, ...]:
        """Numbers of the points with these names; of all where none is named. Raises InputError for one that is not
        there."""
        for name in names:
            if name not in self.points:
                problem = Problem(f"there is no '{name}' among the {self.kind}", hint=choose_from(name, self.points))
                raise InputError(problem)
        return tuple(k for k, name in enumerate(self.points) if not names or name in names)

    def settings(self, setting: Setting, duration: float, output_step: float) -> Settings:
        """Those of a run of the scene with `setting`. Raises InputError like it."""
        return of_scene(self.scene, setting.settings(duration, output_step))

    @property
    def identity(self) -> dict[str, Any]:
        """What it follows from, for the store."""
        times, start = self.scene.settings.break_times, self.scene.settings.start
        started: dict[str, Any] = {"start": start} if start == EQUILIBRIUM else {}
        if self.scene.settings.adjust_joints is not None:
            started["adjust_joints"] = self.scene.settings.adjust_joints
        text, parameters = self.scene.text, dict(self.scene.overrides)
        own = {"elements": repr(self.scene.elements)} if self.scene.elements else {}
        return {"scene": text, "parameters": parameters, "break_times": list(times), **started, **own}


def of_scene(scene: Scene, settings: Settings) -> Settings:
    """The settings with what belongs to the scene: its break times, where it starts, how far joints may move, and
    whether it is integrated though nothing is free."""
    own = scene.settings
    return replace(
        settings,
        break_times=own.break_times,
        start=own.start,
        adjust_joints=own.adjust_joints,
        kinematic=own.kinematic,
    )
