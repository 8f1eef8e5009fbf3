"""The options that commands on a scene share: --set, and one for each key of the `simulation` block.

The reader gets their text and reads it by the rules of the scene, with units and suggestions.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import click

from mbproj.errors import InputError, Place, Problem
from mbproj.registry import ACCELERATIONS, FORMULATIONS, PROJECTIONS, STOP_TESTS, integrators

Command = TypeVar("Command", bound=Callable[..., Any])

#: Option, what it takes, help. The parameter's name is the key that the reader knows.
_OPTIONS: tuple[tuple[str, str, str], ...] = (
    ("--duration", "TIME", "How long to simulate."),
    ("--step", "TIME", "Fixed step of the integrator; or give --tolerance."),
    ("--tolerance", "NUMBER", "Error tolerance, for integrators with an error estimate; or give --step."),
    ("--integrator", "|".join(integrators()), "Explicit Runge-Kutta method."),
    ("--formulation", "|".join(FORMULATIONS), "Coordinates to compute in; auto takes the fewest that fit."),
    ("--acceleration", "|".join(ACCELERATIONS), "Solve Eq. 14, or Eqs. 80-81 without multipliers."),
    ("--output-step", "TIME", "Time between recorded samples, a multiple of the step."),
    ("--projection", "|".join(PROJECTIONS), "How the constraints are enforced."),
    ("--projection-tolerance", "NUMBER", "Largest violation at which a position counts as closed."),
    (
        "--projection-test",
        "|".join(STOP_TESTS),
        "What the projection tolerance limits: the violation, or the paper's norm.",
    ),
    ("--every", "K", "Project after every K-th step only."),
    ("--threshold", "NUMBER", "Project only when the violation exceeds this."),
    ("--project-position", "BOOL", "Whether positions are projected."),
    ("--project-velocity", "BOOL", "Whether velocities are projected."),
    ("--projection-fallback", "none|gopm", "Method to try when a position projection does not converge."),
    ("--max-iterations", "N", "Largest number of iterations of one projection."),
    ("--alpha", "NUMBER", "Penalty factor of mass-orthogonal and mmopm."),
    ("--gains", "A[,B]", "Baumgarte's gains α and β in 1/s."),
)


def scene_options(command: Command) -> Command:
    """Adds the argument SCENE and all of these options to a command; `overrides` collects them."""
    for option, metavar, text in reversed(_OPTIONS):
        command = click.option(option, metavar=metavar, help=text)(command)
    change = click.option(
        "--set", "settings", multiple=True, metavar="NAME=VALUE", help="Change a parameter of the scene."
    )
    command = change(command)
    return click.argument("scene", type=click.Path())(command)


def overrides(options: Mapping[str, Any]) -> dict[str, str]:
    """The simulation keys given on the command line, from a command's parameters."""
    keys = [option.removeprefix("--").replace("-", "_") for option, _, _ in _OPTIONS]
    return {key: options[key] for key in keys if options.get(key) is not None}


def parameters(settings: tuple[str, ...]) -> dict[str, str]:
    """What --set changes. Raises InputError where one is not NAME=VALUE."""
    changed = {}
    for text in settings:
        name, equals, value = text.partition("=")
        if not equals or not name.strip() or not value.strip():
            raise InputError(Problem(f"'{text}' is not NAME=VALUE", Place("--set"), "e.g. --set crank_length=0.1"))
        changed[name.strip()] = value.strip()
    return changed
