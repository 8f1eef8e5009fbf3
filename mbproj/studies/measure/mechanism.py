"""A mechanism that is compiled and assembled once, ready to be run many times."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from mbproj.dataclass import brief, dataclass
from mbproj.dynamics import State
from mbproj.dynamics.assembly.adjust import compile_system
from mbproj.errors import InputError, Problem, choose_from
from mbproj.integrate.formulations.choice import Choice, choose
from mbproj.linear.equilibrium.started import start_state
from mbproj.model import System
from mbproj.scene.read import Scene
from mbproj.scene.records import Settings
from mbproj.settings import MECHANISM, SETTINGS
from mbproj.studies.measure.setting import Setting


@dataclass(frozen=True, eq=False)
class Mechanism:
    """A scene with its system and its consistent start. `points` names its markers, or its bodies where it has none."""

    scene: Scene
    system: System
    state: State

    __repr__ = brief

    @classmethod
    def of(cls, scene: Scene) -> Mechanism:
        """Compile and assemble a scene. Raises InputError where the mechanism cannot be assembled."""
        system = compile_system(scene)
        return cls(scene, system, start_state(scene, system))

    @classmethod
    def to_choose_for(cls, scene: Scene) -> Mechanism:
        """Compile and assemble a scene for a study of settings. Raises InputError where the run is kinematic, as no
        setting matters then."""
        mechanism = cls.of(scene)
        if mechanism.choice(scene.settings).kinematic:
            message = "0 degrees of freedom: the run is kinematic, exact at any setting; there is none to choose"
            hint = "simply run it; --set simulation.kinematic=false integrates it all the same"
            raise InputError(Problem(message, scene.place("simulation"), hint))
        return mechanism

    def choice(self, settings: Settings) -> Choice:
        """Return the result of `choose` for a run from the start."""
        return choose(self.system, self.state, settings)

    @property
    def points(self) -> tuple[str, ...]:
        """The names of the points at which errors are measured, (k,): markers, or bodies where the scene has no
        marker."""
        return tuple(self.system.names.markers or self.system.names.bodies)

    @property
    def kind(self) -> str:
        """The kind of the points: "markers" or "bodies"."""
        return "markers" if self.system.names.markers else "bodies"

    def columns(self, names: Sequence[str] = ()) -> tuple[int, ...]:
        """The numbers of the named points, or of all points where no name is given. Raises InputError for an unknown
        name."""
        for name in names:
            if name not in self.points:
                problem = Problem(f"there is no '{name}' among the {self.kind}", hint=choose_from(name, self.points))
                raise InputError(problem)
        return tuple(k for k, name in enumerate(self.points) if not names or name in names)

    def settings(self, setting: Setting, duration: float, output_step: float) -> Settings:
        """The settings of a run of the scene with `setting`, both times in s. Raises InputError where
        `setting.settings` does."""
        return of_scene(self.scene, setting.settings(duration, output_step))

    @property
    def identity(self) -> dict[str, Any]:
        """All that the mechanism follows from, as the key of the store."""
        scene = self.scene
        settings = {entry.name: entry.of(scene.settings) for entry in _OF_SCENE}
        elements = repr(scene.elements) if scene.elements else ""
        return {"scene": scene.text, "parameters": dict(scene.overrides), "settings": settings, "elements": elements}


#: The settings that belong to the mechanism: no study varies them.
_OF_SCENE = [entry for entry in SETTINGS.values() if entry.decides == MECHANISM]


def of_scene(scene: Scene, settings: Settings) -> Settings:
    """Return the settings with those of the scene that belong to its mechanism."""
    return replace(settings, **{entry.key: entry.of(scene.settings) for entry in _OF_SCENE})
