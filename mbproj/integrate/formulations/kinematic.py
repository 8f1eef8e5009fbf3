"""Kinematic runs: without degrees of freedom joints and motions determine all poses, and nothing is integrated."""

from __future__ import annotations

from dataclasses import replace

from mbproj.errors import InputError, Problem
from mbproj.integrate.steppers.tableau import QUADRATURE
from mbproj.model.system import System
from mbproj.registry import is_explicit
from mbproj.scene.records import ProjectionSettings, Settings
from mbproj.scene.sampling import output_interval
from mbproj.thresholds import THRESHOLDS

#: Words for the settings of the scene that a kinematic run does not use.
UNUSED = "each sample is closed by Newton's method; the scene's integrator, step, tolerance and projection are not used"


def settings_along(system: System, settings: Settings) -> Settings:
    """Return the settings that a kinematic run uses in place of the scene's.

    Positions and velocities are closed at each stage and sample by Newton's method. States of elements are integrated
    by the scene's integrator, whose implicit steps close their predictions. Without states a quadrature of high order
    integrates the work. Raises InputError where states need a step or tolerance and the scene has none."""
    closed = replace(settings, projection=ProjectionSettings(), kinematic=True)
    if not system.states.size:
        interval = output_interval(settings)
        return replace(closed, integrator=QUADRATURE, step=None, tolerance=THRESHOLDS.half_digits, output_step=interval)
    if settings.step is None and settings.tolerance is None:
        message = "states of elements are integrated along the motion: that needs a step or a tolerance"
        raise InputError(Problem(message, key=("simulation",), hint="add 'tolerance' to 'simulation'"))
    return closed


def kinematic_description(system: System, settings: Settings) -> str:
    """Return, for the summary, the description of a kinematic run with these settings of the scene."""
    if not system.states.size:
        return UNUSED
    how = "explicit steps" if is_explicit(settings.integrator) else "implicit steps"
    size = f"step {settings.step:g} s" if settings.step is not None else f"tolerance {settings.tolerance:g}"
    return f"positions are closed by Newton's method; {how} of {settings.integrator}, {size}, integrate the states"
