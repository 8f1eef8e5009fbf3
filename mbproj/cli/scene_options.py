"""The common options of commands on a scene: --set, and one for each key of the `simulation` block.

The scene's reader reads their text by its own rules, with units and suggestions.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Any, TypeVar

import click

from mbproj.cli.completion import Words, scene_file
from mbproj.cli.explained import Part, option
from mbproj.errors import InputError, Place, Problem
from mbproj.registry import (
    ACCELERATIONS,
    FALLBACKS,
    FORMULATIONS,
    IMPACT_LAWS,
    PROJECTIONS,
    STOP_TESTS,
    integrator_choices,
)

Command = TypeVar("Command", bound=Callable[..., Any])

#: The values of a flag of a scene.
BOOL = ("true", "false")
#: Each option: its part of the help, its name, its placeholder or its words, and its help. The parameter's name is the
#: key that the reader knows.
_OPTIONS: tuple[tuple[Part, str, str | Collection[str], str], ...] = (
    (Part.WHAT, "--duration", "TIME", "How long to simulate."),
    (
        Part.INTEGRATION,
        "--integrator",
        integrator_choices(),
        "Runge-Kutta method; esdirk4 and radau5 are implicit, for stiff scenes; auto chooses during the run.",
    ),
    (Part.INTEGRATION, "--step", "TIME", "Fixed step of the integrator; or give --tolerance."),
    (
        Part.INTEGRATION,
        "--tolerance",
        "NUMBER",
        "Error tolerance, for integrators with an error estimate; or give --step.",
    ),
    (
        Part.INTEGRATION,
        "--formulation",
        FORMULATIONS,
        "Coordinates to compute in; auto takes the fewest that fit.",
    ),
    (
        Part.INTEGRATION,
        "--kinematic",
        BOOL,
        "true: the scene must have no degree of freedom, and is not integrated; false: it is integrated in any case.",
    ),
    (Part.INTEGRATION, "--acceleration", ACCELERATIONS, "Solve Eq. 14, or Eqs. 80-81 without multipliers."),
    (Part.INTEGRATION, "--impact-law", IMPACT_LAWS, "Impact law that the restitution of rigid stops belongs to."),
    (Part.PROJECTION, "--projection", PROJECTIONS, "How the constraints are enforced."),
    (Part.PROJECTION, "--projection-tolerance", "NUMBER", "Largest violation at which a position counts as closed."),
    (
        Part.PROJECTION,
        "--projection-test",
        STOP_TESTS,
        "What the projection tolerance limits: the violation, or the paper's norm.",
    ),
    (Part.PROJECTION, "--every", "K", "Project after every K-th step only."),
    (Part.PROJECTION, "--threshold", "NUMBER", "Project only when the violation exceeds this."),
    (Part.PROJECTION, "--project-position", BOOL, "Whether positions are projected."),
    (Part.PROJECTION, "--project-velocity", BOOL, "Whether velocities are projected."),
    (
        Part.PROJECTION,
        "--projection-fallback",
        FALLBACKS,
        "Method to try when a position projection does not converge.",
    ),
    (Part.PROJECTION, "--energy-row", BOOL, "Whether velocities also keep the energy balance: for long runs."),
    (Part.PROJECTION, "--momentum-row", BOOL, "Whether velocities also keep the momenta that nothing changes."),
    (Part.PROJECTION, "--max-iterations", "N", "Largest number of iterations of one projection."),
    (Part.PROJECTION, "--alpha", "NUMBER", "Penalty factor of mass-orthogonal and mmopm."),
    (Part.PROJECTION, "--gains", "A[,B]", "Baumgarte's gains α and β in 1/s."),
    (Part.INTEGRATION, "--break-times", "T[,T..]", "Times at which steps end besides those that the scene has."),
    (Part.OUTPUT, "--output-step", "TIME", "Time between recorded samples, a multiple of the step."),
)
#: Further names of these options.
ALSO = {"--duration": ("--until",)}
#: The names of all these options.
SCENE_OPTIONS = ("--set", *(name for _, name, _, _ in _OPTIONS))


def scene_options(command: Command) -> Command:
    """Decorate a command with the argument SCENE and all these options; `overrides` collects their values."""
    return scene_options_without()(command)


def scene_options_without(*left_out: str) -> Callable[[Command], Command]:
    """Return a decorator like `scene_options` that leaves out some options."""

    def add(command: Command) -> Command:
        for part, name, takes, text in reversed(_OPTIONS):
            if name not in left_out:
                names = (name, *ALSO.get(name, ()), name.removeprefix("--").replace("-", "_"))
                given = {"metavar": takes} if isinstance(takes, str) else {"type": Words(takes)}
                command = option(part, *names, help=text, **given)(command)
        command = option(
            Part.WHAT,
            "--set",
            "settings",
            multiple=True,
            metavar="NAME=VALUE",
            help="Change a parameter, or any value by its path.",
        )(command)
        return click.argument("scene", type=scene_file())(command)

    return add


def overrides(options: Mapping[str, Any]) -> dict[str, str]:
    """The keys of the `simulation` block that the command line gives, from a command's parameters."""
    keys = [name.removeprefix("--").replace("-", "_") for _, name, _, _ in _OPTIONS]
    return {key: options[key] for key in keys if options.get(key) is not None}


def parameters(settings: tuple[str, ...]) -> dict[str, str]:
    """The values that --set changes, by name. Raises InputError where a text is not NAME=VALUE."""
    changed = {}
    for text in settings:
        name, equals, value = text.partition("=")
        if not equals or not name.strip() or not value.strip():
            raise InputError(Problem(f"'{text}' is not NAME=VALUE", Place("--set"), "e.g. --set crank_length=0.1"))
        changed[name.strip()] = value.strip()
    return changed
